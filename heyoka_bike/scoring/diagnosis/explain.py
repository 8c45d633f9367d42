"""Find the cause of a difference: a missing force, or a mistake that explains the file.

First the exact equations are evaluated along the file's own motion (`residual`). The residual shows
which mistakes of the model, parameters and forces can be the cause, without any simulation. The
likeliest of these are then simulated, together with mistakes of the initial conditions and of the
output, which leave no residual. The file is compared with each simulated motion as with the
reference. If the file does not show its motion (missing columns, few rows), all mistakes of the
library are simulated (`search`). Causes are compared by their odds (`odds`, `ranking`). A search
that reaches its time limit (`budget`) ends with the causes found so far.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis import step_log
from heyoka_bike.scoring.diagnosis.budget import NEVER, BudgetSpentError, Deadline
from heyoka_bike.scoring.diagnosis.claims import ends_search
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.ranking import ranked
from heyoka_bike.scoring.diagnosis.residual.observed import upright
from heyoka_bike.scoring.diagnosis.residual.residual import Residual
from heyoka_bike.scoring.diagnosis.search import EVERYTHING, OF_MODEL, Plan, Search
from heyoka_bike.scoring.diagnosis.seen_file import FileUnderTest
from heyoka_bike.scoring.explanation import Curve
from heyoka_bike.scoring.rows.scaled_columns import ColumnRatio

__all__ = ["Diagnosis", "Hypothesis", "explain"]

FEWEST_ROWS = 3
"""Minimum number of rows. The first row is given, and the error of a second may have any size."""

# Share of the progress bar for evaluating the equations of motion along the file's motion.
_SHARE_OF_EQUATIONS = 0.3
_MOTION = step_log.Step("motion", "does the file's motion satisfy the equations?")


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis:
    """The causes that explain a file.

    Attributes
    ----------
    classes : tuple of tuple of Hypothesis
        The hypotheses, best class first; the file cannot distinguish hypotheses of one class. Empty
        if no hypothesis explains the file, or if the search was stopped and an untried one might
        explain more.
    tried
        Number of hypotheses tried.
    causes : Residual or None
        Residual of the equations of motion along the file's own motion; None if the file does not
        show its motion.
    curves : tuple of Curve
        Errors that the best hypothesis leaves, in the column of each maneuver that it explains
        best.
    units : mapping of str to str
        Units of columns according to the best hypothesis, for columns that seem to be in another
        unit if compared with the correct motion.
    is_whole
        False if the time limit was reached before all causes were tried.
    likeliest : Hypothesis or None
        The best hypothesis so far, if `classes` is empty only because the search was stopped.
    stops_at_unknown_force
        True if pairs of mistakes and other initial conditions were not tried, because the file
        shows a force that no single cause explains.
    edit : ColumnRatio or None
        An offset or a ratio of a column that was found together with a wrong value. The caller must
        undo it and diagnose the rows again.
    """

    classes: tuple[tuple[Hypothesis, ...], ...]
    tried: int
    causes: Residual | None = None
    curves: tuple[Curve, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    is_whole: bool = True
    likeliest: Hypothesis | None = None
    stops_at_unknown_force: bool = False
    edit: ColumnRatio | None = None


def explain(
    parts: Sequence[Part], reference: Reference, *, simulator: Simulator | None = None,
    plan: Plan = EVERYTHING, asks_for_edit: bool = True,
    progress: Callable[[float], None] = lambda _: None, deadline: Deadline = NEVER,
) -> Diagnosis:  # fmt: skip
    """Find the mistakes, alone and in pairs, and the parameters and forces that explain a file.

    The `plan` says which causes are tried. With `asks_for_edit`, an offset or a ratio of a column
    is also looked for, together with a wrong value. `progress` is called with the fraction of the
    work that is done, 0 to 1. At the `deadline` the search ends, and the causes found so far are
    compared.
    """
    parts = [upright(part, understand(parts)) for part in parts]
    if max(len(part.time) for part in parts) < FEWEST_ROWS:
        return Diagnosis((), 0)
    library = OF_MODEL if plan.asks_equations else ()
    try:
        with step_log.logged(_MOTION) as log:
            file = FileUnderTest(
                parts, reference, simulator or Simulator(), library, deadline, asks_for_edit
            )
            log.found = partial(_left_of_equations, file.residual)
    except BudgetSpentError:
        return Diagnosis((), 0, is_whole=False)
    progress(_SHARE_OF_EQUATIONS)
    if file.edit is not None:
        return Diagnosis((), file.tried, file.residual, edit=file.edit)
    search = Search(file, is_thorough=deadline.is_thorough)
    residual, is_whole = file.residual, True
    try:
        rest = 1.0 - _SHARE_OF_EQUATIONS
        search.carry_out(plan.steps, lambda share: progress(_SHARE_OF_EQUATIONS + rest * share))
    except BudgetSpentError:
        # The time limit has been reached. Continue with the hypotheses that were judged before it.
        is_whole = False
    progress(1.0)
    classes = ranked(file, search.found, search.starts)
    tried = file.tried + (len(OF_MODEL) if residual else 0)
    if not classes:
        ended = is_whole and plan is EVERYTHING and search.stops_at_unknown_force
        return Diagnosis((), tried, residual, is_whole=is_whole, stops_at_unknown_force=ended)
    best, usual = classes[0][0], file.right.understood
    if not (is_whole or ends_search(best, residual)):
        return Diagnosis((), tried, residual, is_whole=False, likeliest=best)
    units = {key: u.unit for key, u in best.understood.items() if u.unit != usual[key].unit}
    return Diagnosis(classes, tried, residual, file.curves(best), units, is_whole)


def _left_of_equations(residual: Residual | None) -> str:
    """Describe the residual of the accelerations in words."""
    if residual is None:
        return "the file does not show its motion"
    shares = ", ".join(f"{name} {x:.1e}" for name, x in residual.shares.items())
    told = residual.visibility.name.lower().replace("_", " ")
    return f"residual relative to the accelerations: {shares}; visible: {told}"
