"""Why a result differs: which force is missing, which mistake explains the file.

First the file's own motion is put into the exact equations (`residual`): what remains says which
mistakes of the model, which parameters and which forces can be the cause, without any simulation.
The likeliest are then simulated, with mistakes of the start and of what is written, which leave
nothing in the equations, and the file is compared with each motion as it is with the reference.
Where a file does not show its motion (columns are missing, rows are few) all mistakes of the
library are simulated (`search`). All are compared by their odds (`odds`, `ranking`).
A search that has no time left (`budget`) ends with what was found until then.
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
from heyoka_bike.scoring.diagnosis.search import OF_MODEL, OF_WHAT_IS_WRITTEN, SEARCH, Search
from heyoka_bike.scoring.diagnosis.seen_file import FileUnderTest
from heyoka_bike.scoring.evidence.output_faults import ColumnRatio
from heyoka_bike.scoring.explanation import Curve

__all__ = ["Diagnosis", "Hypothesis", "explain"]

FEWEST_ROWS = 3
"""Fewer rows show nothing: the first one is given, and the error of one more may have any size."""

# Of the work, by putting the file's motion into the equations.
_SHARE_OF_EQUATIONS = 0.3
_MOTION = step_log.Step("motion", "what does the file's motion leave of the equations?")


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis:
    """The causes that explain a file.

    Attributes
    ----------
    classes : tuple of tuple of Hypothesis
        Ranked; hypotheses of a class cannot be told apart. Empty if nothing explains it, and of a
        search that was stopped also if what it did not try might explain more.
    tried
        Number of hypotheses tried.
    causes : Residual or None
        What the equations of motion say of the file's own motion; None where it does not show it.
    curves : tuple of Curve
        What the best of all leaves, in the column of each maneuver that it explains best.
    units : mapping of str to str
        Units that columns have if the best of all is true, where they seem to have others beside
        the correct motion.
    is_whole
        False if the time was spent before all was tried.
    likeliest : Hypothesis or None
        Where `classes` are empty only for that, the best until then.
    stops_at_unknown_force
        True if two mistakes at once, and other starts, were not tried: the equations leave a force
        of which no cause explains anything.
    edit : ColumnRatio or None
        An offset or a ratio of a column that was found together with a wrong value: it is to be
        undone, and the rows diagnosed again.
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
    only_output: bool = False, asks_for_edit: bool = True,
    progress: Callable[[float], None] = lambda _: None, deadline: Deadline = NEVER,
) -> Diagnosis:  # fmt: skip
    """Find the mistakes, alone and in pairs, and the parameters and forces that explain a file.

    With `only_output` only mistakes of the output are tried. With `asks_for_edit` an offset or a
    ratio of a column is also looked for, together with a wrong value. `progress` is called with the
    part of the work that is done, 0 to 1. At the `deadline` what was found until then is compared.
    """
    parts = [upright(part, understand(parts)) for part in parts]
    if max(len(part.time) for part in parts) < FEWEST_ROWS:
        return Diagnosis((), 0)
    library = () if only_output else OF_MODEL
    try:
        with step_log.logged(_MOTION) as told:
            file = FileUnderTest(
                parts, reference, simulator or Simulator(), library, deadline, asks_for_edit
            )
            told.found = partial(_left_of_equations, file.residual)
    except BudgetSpentError:
        return Diagnosis((), 0, is_whole=False)
    progress(_SHARE_OF_EQUATIONS)
    if file.edit is not None:
        return Diagnosis((), file.tried, file.residual, edit=file.edit)
    search = Search(file, is_thorough=deadline.is_thorough)
    residual, is_whole = file.residual, True
    steps = OF_WHAT_IS_WRITTEN if only_output else SEARCH
    try:
        rest = 1.0 - _SHARE_OF_EQUATIONS
        search.carry_out(steps, lambda share: progress(_SHARE_OF_EQUATIONS + rest * share))
    except BudgetSpentError:
        # What was judged before stays.
        is_whole = False
    progress(1.0)
    classes = ranked(file, search.found, search.starts)
    tried = file.tried + (len(OF_MODEL) if residual else 0)
    if not classes:
        ended = is_whole and not only_output and search.stops_at_unknown_force
        return Diagnosis((), tried, residual, is_whole=is_whole, stops_at_unknown_force=ended)
    best, usual = classes[0][0], file.right.understood
    if not (is_whole or ends_search(best, residual)):
        return Diagnosis((), tried, residual, is_whole=False, likeliest=best)
    units = {key: u.unit for key, u in best.understood.items() if u.unit != usual[key].unit}
    return Diagnosis(classes, tried, residual, file.curves(best), units, is_whole)


def _left_of_equations(residual: Residual | None) -> str:
    """What is left of the accelerations, in words."""
    if residual is None:
        return "it is not shown"
    shares = ", ".join(f"{name} {x:.1e}" for name, x in residual.shares.items())
    told = residual.visibility.name.lower().replace("_", " ")
    return f"of the accelerations {shares}; it shows {told}"
