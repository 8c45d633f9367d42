"""Convergence of one program with its step or tolerance, and errors that do not fall.

Each column has an observed order of convergence, and what Richardson's extrapolation leaves.

An error that stays the same curve is not the integrator's: the model, its parameters, the start or
the output is another one. An error that stays as large but is another curve in each run is noise:
of the arithmetic, or of iterations that stop early. Near the last digits of the arithmetic it is
always taken for rounding.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import log

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, info, named, warning
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.report import Convergence, Run

# An error of up to this many floors is rounding, not the integrator's.
_AT_FLOOR = 4.0
# Observed orders of one column that differ by more than this are not those of one power law yet.
_STEADY = 0.3
# Errors that fall by less than this power of the step or tolerance do not fall.
_FALLS = 0.2
# Two runs have the same error if their difference is less than this part of it.
_SAME = 0.3
# Exponents within this of 1 are "in proportion".
_PROPORTION = 0.25
_NAMED = 6


def columns_of(runs: Sequence[Run]) -> Mapping[tuple[int, str], list[ColumnScore | None]]:
    """Each maneuver and column, with its score in each run."""
    found: dict[tuple[int, str], list[ColumnScore | None]] = {}
    for i, run in enumerate(runs):
        for m in run.report.maneuvers:
            for c in m.columns:
                found.setdefault((m.maneuver, c.key), [None] * len(runs))[i] = c
    order = list(COMPARED)
    return dict(sorted(found.items(), key=lambda x: (x[0][0], order.index(x[0][1]))))


def converge(runs: Sequence[Run]) -> tuple[Convergence, ...]:
    """Every column that more than one run has."""
    steps = [run.step for run in runs]
    return tuple(
        _converge(maneuver, key, columns, steps)
        for (maneuver, key), columns in columns_of(runs).items()
        if sum(c is not None for c in columns) > 1
    )


def _converge(
    maneuver: int, key: str, columns: Sequence[ColumnScore | None], steps: Sequence[float | None]
) -> Convergence:
    sized = list(zip(columns, steps, strict=True))
    orders = tuple(_order(*coarse, *fine) for coarse, fine in pairwise(sized))
    (coarse, step), (fine, next_step) = sized[-2:]
    extrapolated = None
    if coarse and fine and step and next_step and (order := round(orders[-1] or 0.0)) >= 1:
        extrapolated = _richardson(coarse, fine, (step / next_step) ** order)
    last = next(c for c in reversed(columns) if c is not None)
    return Convergence(
        maneuver=maneuver,
        key=key,
        unit=last.unit,
        definition=last.definition,
        errors=tuple(None if c is None else c.max_abs_error for c in columns),
        orders=orders,
        richardson_error=extrapolated,
        floor=last.floor,
    )


def _order(
    coarse: ColumnScore | None,
    step: float | None,
    fine: ColumnScore | None,
    next_step: float | None,
) -> float | None:
    """log(e1 / e2) / log(h1 / h2); None where an error is rounding only."""
    if coarse is None or fine is None or step is None or next_step is None:
        return None
    before, after = coarse.max_abs_error, fine.max_abs_error
    if coarse.definition != fine.definition or not before or not after:
        return None
    if coarse.is_at_floor(_AT_FLOOR) or fine.is_at_floor(_AT_FLOOR):
        return None
    return log(before / after) / log(step / next_step)


def _richardson(coarse: ColumnScore, fine: ColumnScore, ratio: float) -> float | None:
    """Largest error of the extrapolated values at the times that both runs have.

    The extrapolation is linear, so it may be done on the errors themselves.
    """
    _, i, j = np.intersect1d(coarse.trace.time, fine.trace.time, return_indices=True)
    # A few common times show nothing of the others.
    if 2 * len(i) < len(coarse.trace.time):
        return None
    e1, e2 = coarse.trace.error[i], fine.trace.error[j]
    return float(np.max(np.abs(e2 + (e2 - e1) / (ratio - 1.0))))


def nothing_shared(convergence: Sequence[Convergence], what: str) -> list[Finding]:
    """A warning if no column is in two of the files or programs."""
    said = f"no maneuver has a column that two of the {what}"
    return [] if convergence else [warning("no_shared_columns", said)]


def falling(runs: Sequence[Run], convergence: Sequence[Convergence]) -> list[Finding]:
    """Say what the errors of a series tell of its program, the coarsest run first."""
    pairs = _pairs(runs)
    is_of_tolerances = bool(runs) and runs[-1].step is None
    what = "tolerance" if is_of_tolerances else "step"
    exponents = [p.exponent for p in pairs if p.exponent > _FALLS]
    return [
        *_orders(convergence),
        *(_exponent(exponents) if is_of_tolerances and exponents else ()),
        *_staying([p for p in pairs if p.exponent <= _FALLS], what),
    ]


_OF_ROUNDING = "limited_by_rounding"
_STAYS = {
    _OF_ROUNDING: " or less, does not fall with the {}, and need not: at this size it is rounding "
    "of binary64 arithmetic, not the model; only longer numbers make it smaller",
    "noise_does_not_fall": ", does not fall with the {}, but is another curve in each run: it is "
    "noise, of single-precision numbers (1e-7), of iterations that stop early, or of rough "
    "interpolation, and not the model",
    "error_stays": ", is the same curve in both runs and does not fall with the {}: it is not the "
    "integrator's, but that of the model, its parameters, the start or the output; ask "
    "heyoka-bike diagnose",
}
"""Sentences about errors that stay, by the code of the finding."""


@dataclass(frozen=True, eq=False, slots=True)
class _Pair:
    """A column of the two finest runs.

    Attributes
    ----------
    place
        Maneuver and column ("2.roll_angle").
    exponent
        Of the step or tolerance, with which the error falls.
    error
        What is left, of the scale.
    is_same
        Whether both runs have the same error.
    """

    place: str
    exponent: float
    error: float
    is_same: bool

    @property
    def code(self) -> str:
        """Of what is found if the error does not fall."""
        if self.error < ROUNDING:
            return _OF_ROUNDING
        return "error_stays" if self.is_same else "noise_does_not_fall"


def _pairs(runs: Sequence[Run]) -> list[_Pair]:
    """Columns of the two finest runs whose error is not that of the digits written."""
    sizes = [run.tolerance if run.step is None else run.step for run in runs[-2:]]
    if len(sizes) < 2 or sizes[0] is None or sizes[1] is None or sizes[0] <= sizes[1]:
        return []
    found = []
    for (maneuver, key), (a, b) in columns_of(runs[-2:]).items():
        exponent = _order(a, sizes[0], b, sizes[1])
        if a and b and exponent is not None:
            error = b.max_rel_error or 0.0
            found.append(_Pair(f"{maneuver}.{key}", exponent, error, _is_same(a, b)))
    return found


def _is_same(a: ColumnScore, b: ColumnScore) -> bool:
    """True if the error of two runs is the same curve at the times of both."""
    _, i, j = np.intersect1d(a.trace.time, b.trace.time, return_indices=True)
    if not len(i):
        return False
    return rms(a.trace.error[i] - b.trace.error[j]) < _SAME * rms(b.trace.error[j])


def _exponent(found: Sequence[float]) -> Iterator[Finding]:
    """Say with which power the errors follow the tolerance."""
    exponent = float(median(found))
    how = "in proportion to the tolerance"
    if abs(exponent - 1) > _PROPORTION:
        how = f"like the tolerance to the power {exponent:.1f}"
    said = f"the error falls {how}: exponent {exponent:.2f} ({_spread(found)})"
    yield info("tolerance", said, exponent=exponent, least=min(found), most=max(found))


def _staying(stay: Sequence[_Pair], what: str) -> Iterator[Finding]:
    """Errors that do not fall: rounding, noise, or the model."""
    for code, says in _STAYS.items():
        if pairs := [p for p in stay if p.code == code]:
            is_fine = code == _OF_ROUNDING
            places, worst = [p.place for p in pairs], max(p.error for p in pairs)
            error = f"{worst:.1g}" if is_fine else f"up to {worst:.1g}"
            said = f"{named(places, _NAMED)}: the error, {error} of the scale{says.format(what)}"
            find = info if is_fine else warning
            yield find(code, said, columns=places, max_rel_error=worst)


def _spread(found: Sequence[float]) -> str:
    """Of how many columns a median is, and between which numbers."""
    columns = f"{len(found)} column{'s' if len(found) > 1 else ''}"
    return f"median of {columns}, from {_plain(min(found))} to {_plain(max(found))}"


def _plain(order: float) -> str:
    return f"{round(order, 2) + 0.0:.2f}"  # no -0


def _orders(convergence: Sequence[Convergence]) -> Iterator[Finding]:
    """The order of the program, and whether it has settled."""
    found = [c.orders[-1] for c in convergence if c.orders[-1] is not None]
    if not found:
        return
    order = float(median(found))
    said = f"observed order of convergence {_plain(order)} ({_spread(found)})"
    yield info("order", said, order=order, least=min(found), most=max(found))
    unsteady = [
        f"{c.maneuver}.{c.key}"
        for c in convergence
        if len(c.orders) > 1
        and c.orders[-1] is not None
        and c.orders[-2] is not None
        and abs(c.orders[-1] - c.orders[-2]) > _STEADY
    ]
    if unsteady:
        said = (
            f"the order of {', '.join(unsteady)} still changes from step to step: the steps are "
            "too large, or rounding has been reached, for one power law"
        )
        yield info("order_not_settled", said, columns=unsteady)
