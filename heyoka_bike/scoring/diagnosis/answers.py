"""The answer of a diagnosis: the causes that explain the file, or a description of its error."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import START
from heyoka_bike.scoring.diagnosis import numerical, visible_faults
from heyoka_bike.scoring.diagnosis.beginnings import BeginsAs, WorkFromStart
from heyoka_bike.scoring.diagnosis.claims import above_digits, left_over
from heyoka_bike.scoring.diagnosis.conclusions import (
    Direction,
    Explained,
    ForceUnexplained,
    IntegratedBy,
    Integrator,
    LeftOfEquations,
    LikeliestUntilThen,
    LinearMotion,
    MostlyZeros,
    NoCauseFound,
    TorqueLaw,
    UnitsBeside,
)
from heyoka_bike.scoring.diagnosis.departures import Departs
from heyoka_bike.scoring.diagnosis.energies import (
    EnergyOfOtherMotion,
    EnergyTrend,
    EnergyVaries,
    is_of_motions,
    of_contact,
    of_other_motions,
)
from heyoka_bike.scoring.diagnosis.explain import Diagnosis
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEARISED_CODE
from heyoka_bike.scoring.diagnosis.numerical import RoughError, SmoothError, TooFar
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.program import FittedValue, NumericalMethod
from heyoka_bike.scoring.diagnosis.residual.methods import CLOCK
from heyoka_bike.scoring.diagnosis.residual.observed import STATE_KEYS
from heyoka_bike.scoring.diagnosis.residual.residual import Residual, Visibility, shows_equations
from heyoka_bike.scoring.diagnosis.rows_between import RowsBetween
from heyoka_bike.scoring.diagnosis.visible_faults import AnotherStart, FallsOver
from heyoka_bike.scoring.diagnosis.wrong_columns import ColumnsApart, columns_apart
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import maneuvers
from heyoka_bike.scoring.grades import has_right_digits
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.maneuvers import RowsRepeated
from heyoka_bike.scoring.rows.other_maneuvers import ColumnOfAnotherManeuver

# Key of the column that contains each initial value, by the name of this value.
_COLUMN_OF_START = {f"initial_{name}": key for name, key in zip(START, STATE_KEYS, strict=True)}


_STIFFEST = 3.0
"""Time constant of the stiffest stable contact, in integrator steps. MuJoCo's limit is two."""


def mostly_zeros(report: Report) -> tuple[MostlyZeros, ...]:
    """Return the evidence that most columns contain only zeros; an empty tuple if they do not."""
    are_zeros = [not c.trace.value.any() for _, c in report.places]
    return (MostlyZeros(),) if 2 * sum(are_zeros) > len(are_zeros) else ()


def answers(
    diagnosis: Diagnosis, report: Report, first: Sequence[visible_faults.VisibleFault]
) -> tuple[Evidence, ...]:
    """List the causes that explain the file, or describe its error if none does.

    `first` is the evidence that was found without simulation, see `visible_faults.shown`.
    """
    units = (UnitsBeside(diagnosis.units),) if diagnosis.units else ()
    if diagnosis.classes and diagnosis.classes[0][0].codes == (LINEARISED_CODE,):
        return (_linear(diagnosis.classes[0][0]), *units)
    falls = tuple(x for x in first if isinstance(x, FallsOver))
    if diagnosis.classes:
        # Do not report wrong initial conditions, or rows that repeat the first one, in addition to
        # a cause that explains them. Report a fall after its cause.
        others = (
            x for x in first
            if not isinstance(x, FallsOver | AnotherStart)
            and not (isinstance(x, RowsRepeated) and x.rows == report[x.maneuvers[0]].rows)
        )  # fmt: skip
        causes = (
            _integrated(rank, hypotheses) or _explained(rank, hypotheses, report, diagnosis.causes)
            for rank, hypotheses in enumerate(diagnosis.classes[: THRESHOLDS.max_answers], 1)
        )
        is_method = any(m.kind == "method" for m in diagnosis.classes[0][0].mistakes)
        energies = _energies(diagnosis.causes, report) if is_method else ()
        return (*others, *causes, *energies, *units, *falls)
    if any(is_whole_cause(x, report) for x in first):
        return tuple(first)
    integrator = _integrator(diagnosis.causes)
    step = integrator.methods[0].step if integrator is not None else 0.0
    # Report a soft contact only if the program could have made it stiffer with the same step.
    yields = tuple(x for x in of_contact(report) if x.constant > _STIFFEST * step)
    if not diagnosis.is_whole:
        # The evidence further below assumes that a complete search has excluded all other causes,
        # so an incomplete search does not report it.
        if diagnosis.likeliest is not None:
            return (*first, LikeliestUntilThen(diagnosis.likeliest))
        direction = tuple(_direction(diagnosis.causes))
        shape = _without_work(numerical.described(report), direction, diagnosis.causes, report)
        return (*yields, *first, *direction, *shape)
    # If the contact yields, do not report the nearest integrator: the contact explains the error
    # better.
    integrator = None if yields else integrator
    is_integrator = integrator is not None and integrator.is_explained
    whole = columns_apart(report) or (integrator if is_integrator else None)
    nothing = _no_cause(diagnosis, report)
    if isinstance(whole, ColumnsApart):
        # If only these columns are wrong, their wrong first rows indicate wrong output, not wrong
        # initial conditions.
        first = [x for x in first if not (isinstance(x, AnotherStart) and x.key in whole.columns)]
        rough = numerical.noise(report, whole.columns)
        return (*first, whole, *rough, replace(nothing, is_of_output=True))
    energies = _energies(diagnosis.causes, report)
    if whole is not None:
        return (*first, whole, *energies)
    forces = (*_direction(diagnosis.causes), *_unexplained(diagnosis))
    if falls:
        return (*forces, *first)
    shape = _without_work(numerical.causes(report), forces, diagnosis.causes, report)
    # If the columns are too far from the exact ones, the residual of the equations has no meaning,
    # so it is not reported.
    is_told = not forces and not any(isinstance(x, TooFar) for x in shape)
    described = tuple(_described(diagnosis.causes)) if is_told else ()
    if has_right_digits(nothing.max_rel_error):
        # If the file is right, the small error of the integrator needs no explanation.
        described = tuple(x for x in described if not x.may_be_explicit)
    if forces or (described and not described[0].may_be_explicit):
        shape = tuple(x for x in shape if not isinstance(x, SmoothError))
    if forces:
        # A force that the equations show is no matter of the order or the units of columns.
        shape = tuple(x for x in shape if not isinstance(x, TooFar))
        first = (*visible_faults.other_heights(report), *first)
    if forces or described:
        # Do not report how the error grows in the first rows, because the residual of the equations
        # shows more.
        shape = tuple(x for x in shape if not isinstance(x, BeginsAs))
    noise = tuple(x for x in shape if isinstance(x, RoughError) and x.are_all)
    if noise:
        # Noise also changes the first row, the energy and the accelerations, so the evidence from
        # these is not reported.
        first = tuple(x for x in first if not isinstance(x, AnotherStart))
        shape, described = (), ()
    # An integration method that only resembles the error is reported last.
    nearest = () if integrator is None else (integrator,)
    told = (*energies, *yields, *forces, *noise, *described)
    if not (told or first):
        return (nothing, *shape, *nearest)
    general = tuple(x for x in shape if isinstance(x, SmoothError))
    shape = tuple(x for x in shape if x not in general)
    if any(isinstance(x, ForceUnexplained) for x in forces):
        nothing = replace(nothing, closest=())
    # Report an invisible difference of the first row late, because it is weaker evidence than the
    # rest.
    small = tuple(x for x in first if isinstance(x, AnotherStart) and not x.is_visible)
    first = tuple(x for x in first if x not in small)
    return (*told, *first, *shape, *small, nothing, *general, *nearest)


def is_whole_cause(x: Evidence, report: Report) -> bool:
    """True if a fault that was found without simulation explains the whole error of a report."""
    if isinstance(x, RowsBetween) and x.keys:
        return {c.key for _, c in report.places if not (c.is_right or c.is_hidden)} <= {*x.keys}
    return isinstance(x, (RowsRepeated, RowsBetween, ColumnOfAnotherManeuver, Departs))


def is_right(report: Report) -> bool:
    """True if the errors of all columns are below the resolution of the digits written."""
    return all(c.is_hidden for _, c in report.places)


def _linear(h: Hypothesis) -> LinearMotion:
    """Return the evidence that the program solves the linear equations, with no other mistake."""
    unknown = tuple(dict.fromkeys(key for n, key in h.floors if (n, key) not in h.after))
    # Energies of linear motions show less about the integrator than the lateral columns, so use the
    # lateral columns if the file has any.
    lateral = {k: x for k, x in h.after.items() if k[1] in LATERAL} or h.after
    place, left = max(lateral.items(), key=lambda x: x[1])
    return LinearMotion(h, unknown, place, left)


def _integrated(rank: int, hypotheses: Sequence[Hypothesis]) -> IntegratedBy | None:
    """Return the integration methods if the likeliest hypothesis is one; otherwise None."""
    found = [(h, m) for h in hypotheses for m in h.mistakes if isinstance(m, NumericalMethod)]
    if not found or found[0][0] is not hypotheses[0]:
        return None
    methods = tuple(m for _, m in found)
    return IntegratedBy(hypotheses[0], methods, left_over(hypotheses[0], None), rank > 1)


def _integrator(causes: Residual | None) -> Integrator | None:
    """Return the integration methods whose error the residual resembles; None if there are none."""
    methods = tuple(m for m in causes.methods if m.says != CLOCK) if causes else ()
    return Integrator(methods, methods[0].relief > CLEARLY) if methods else None


def _direction(causes: Residual | None) -> Iterator[Direction]:
    """Yield the cause that explains nearly all of the residual, but not the whole run."""
    if causes is not None and causes.best is not None and not acts_elsewhere(causes):
        yield Direction(causes.best)


def acts_elsewhere(causes: Residual) -> bool:
    """True if a load explains clearly more than the best cause, which only resembles it."""
    best = causes.best
    return best is not None and any(x.relief > CLEARLY * best.relief for x in causes.loads)


def _unexplained(diagnosis: Diagnosis) -> Iterator[TorqueLaw | ForceUnexplained]:
    """Yield the evidence of an unexplained force; as a torque law if one variable determines it."""
    causes = diagnosis.causes
    if causes is None or causes.visibility is Visibility.NOTHING:
        return
    is_elsewhere = acts_elsewhere(causes)
    if not (causes.is_open or is_elsewhere):
        return
    is_beside = causes.best is not None and not is_elsewhere
    if causes.best is None and causes.law is not None:
        yield TorqueLaw(causes.law)
        return
    is_end = diagnosis.stops_at_unknown_force
    closest, loads = ((), ()) if is_beside else (_closest(causes), causes.loads)
    yield ForceUnexplained(_left(causes), is_beside, is_end, closest, loads)


def _described(causes: Residual | None) -> Iterator[LeftOfEquations]:
    """Yield the residual of the equations if it is visible and no integrator explains it."""
    if causes is not None and causes.is_described:
        yield _left(causes)


def _energies(causes: Residual | None, report: Report) -> tuple[EnergyOfOtherMotion, ...]:
    """Return energies that do not belong to the file's motion; empty if a force is unexplained."""
    if causes is None or not shows_equations(causes) or causes.is_open:
        return ()
    equations = Equations.binary64(causes.program.motion.bicycle)
    return tuple(of_other_motions(report, causes.motions, equations))


def _without_work(
    shape: tuple[Evidence, ...], forces: Sequence[Evidence], causes: Residual | None, report: Report
) -> tuple[Evidence, ...]:
    """Drop the changes of the energy if a known force causes them, so that no integrator does."""
    is_known = any(
        x.loads if isinstance(x, ForceUnexplained) else isinstance(x, Direction | TorqueLaw)
        for x in forces
    )
    if causes is None or not is_known:
        return shape
    equations = Equations.binary64(causes.program.motion.bicycle)
    if not is_of_motions(report, causes.motions, equations):
        return shape
    return tuple(x for x in shape if not isinstance(x, EnergyTrend | EnergyVaries | WorkFromStart))


def _left(causes: Residual) -> LeftOfEquations:
    return LeftOfEquations(causes.shares, causes.acts_in, causes.above)


def _explained(
    rank: int, hypotheses: tuple[Hypothesis, ...], report: Report, causes: Residual | None
) -> Explained:
    """Return the evidence that mistakes, or as few fitted values as possible, explain the file."""
    first = hypotheses[0]
    as_given = grouped(
        (key, x.maneuver or 0) for x in first.found if (key := _written_as_given(x, report))
    )
    rest = left_over(first, causes)
    return Explained(
        rank,
        hypotheses,
        rest,
        _acceleration(first, causes),
        tuple(f"{key} of {maneuvers(numbers)}" for key, numbers in as_given.items()),
        max(above_digits(first).values(), default=0.0),
        () if rest is None or causes is None else _rivals(first, causes),
    )


def _rivals(h: Hypothesis, causes: Residual) -> tuple[Hypothesis, ...]:
    """Return other causes that reduce the residual of the equations nearly as much as one cause."""
    if h.mistakes[0].kind != "model":
        return ()
    relief = causes.relief(h.mistakes)
    near = (x for x in _by_relief(causes) if x.relief * CLEARLY > relief and x.count <= h.count)
    return tuple(x for x in near if not x.parts & h.parts)[: THRESHOLDS.max_refined]


def _by_relief(causes: Residual) -> list[Hypothesis]:
    """Return the plausible causes that explain a part of the residual, the best first."""
    every = (x for x in (*causes.fitted, *causes.known) if x.log_odds > 0.0)
    return sorted(
        (x for x in every if x.relief > THRESHOLDS.explained_factor), key=lambda x: -x.relief
    )


def _acceleration(h: Hypothesis, causes: Residual | None) -> tuple[str, float, float] | None:
    """Return the equation with the largest residual, its size, and the factor by which it falls.

    None if the causes do not change the model, or reduce the residual too little.
    """
    if causes is None or all(m.kind != "model" for m in h.mistakes):
        return None
    relief = causes.relief(h.mistakes)
    where = max(causes.shares, key=causes.shares.__getitem__)
    return (where, causes.shares[where], relief) if relief > THRESHOLDS.explained_factor else None


def _written_as_given(x: FittedValue, report: Report) -> str:
    """Name the column whose first row has the given initial value, although another was fitted.

    Empty if there is no such column.
    """
    key = _COLUMN_OF_START.get(x.name, "")
    for m, c in report.by_column().get(key, ()):
        is_small = CLEARLY * abs(float(c.trace.error[0])) < abs(x.value - x.right)
        if m.maneuver == x.maneuver and c.trace.time[0] == 0.0 and is_small:
            return key
    return ""


def _no_cause(diagnosis: Diagnosis, report: Report) -> NoCauseFound:
    # If several columns have the same error, take the one whose name is last.
    m, c = max(report.places, key=lambda x: (x[1].error, f"{x[1].key} of maneuver {x[0].maneuver}"))
    seen = diagnosis.causes
    is_met = seen is not None and shows_equations(seen) and seen.is_met
    return NoCauseFound(diagnosis.tried, m.maneuver, c.key, c.error, is_met, _closest(seen))


def _closest(causes: Residual | None) -> tuple[Hypothesis, ...]:
    """Return the causes that explain the largest part of the residual, but not all of it."""
    if causes is None or not causes.visibility:
        return ()
    return tuple(_by_relief(causes)[: THRESHOLDS.max_refined])
