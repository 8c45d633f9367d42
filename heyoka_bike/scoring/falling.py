"""How the errors of one program fall with its step or tolerance, and why some do not.

An error that stays the same curve is not the integrator's: the model, its parameters, the start or
the output is another one. An error that stays as large but is another curve in each run is noise:
of the arithmetic, or of iterations that stop early. Near the last digits of the arithmetic it is
always taken for rounding.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Convergence, Run

ROUNDING = 1e-11
"""Of the scale: what binary64 arithmetic may leave of a run. 1e-16 in each of a million operations
that add up is 1e-13 to 1e-10; correct programs were seen to stop at 4e-14 to 2e-12."""

# Observed orders of one column that differ by more than this are not those of one power law yet.
_STEADY = 0.3
# An error this close to its floor is rounding of what is written.
_AT_FLOOR = 4.0
# Errors that fall by less than this power of the step or tolerance do not fall.
_FALLS = 0.2
# Two runs have the same error if their difference is less than this part of it.
_SAME = 0.3
# Exponents within this of 1 are "in proportion".
_PROPORTION = 0.25
_NAMED = 6


def falling(runs: Sequence[Run], convergence: Sequence[Convergence]) -> list[Finding]:
    """What the errors of a series say about its program, the coarsest run first."""
    return [*_orders(convergence), *_exponents(runs), *_staying(runs)]


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


def _size(run: Run) -> float | None:
    return run.tolerance if run.step is None else run.step


def _pairs(runs: Sequence[Run]) -> list[_Pair]:
    """Columns of the two finest runs whose error is not that of the digits written."""
    sizes = [_size(run) for run in runs[-2:]]
    if len(sizes) < 2 or sizes[0] is None or sizes[1] is None or sizes[0] <= sizes[1]:
        return []
    ratio = log(sizes[0] / sizes[1])
    coarse, fine = (
        {(m.maneuver, c.key): c for m in run.report.maneuvers for c in m.columns if c.values}
        for run in runs[-2:]
    )
    found = []
    for (maneuver, key), b in fine.items():
        a = coarse.get((maneuver, key))
        if a is None or a.as_understood.definition != b.as_understood.definition:
            continue
        before, after = (c.as_understood.measures.max_abs_error for c in (a, b))
        if not before or not after or any(c.is_at_floor(_AT_FLOOR) for c in (a, b)):
            continue
        exponent = log(before / after) / ratio
        error = b.as_understood.measures.max_rel_error or 0.0
        found.append(_Pair(f"{maneuver}.{key}", exponent, error, _is_same(a, b)))
    return found


def _is_same(a: ColumnScore, b: ColumnScore) -> bool:
    """Whether the error of two runs is the same curve at the times of both."""
    _, i, j = np.intersect1d(a.trace.time, b.trace.time, return_indices=True)
    if not len(i):
        return False
    return rms(a.trace.error[i] - b.trace.error[j]) < _SAME * rms(b.trace.error[j])


def _exponents(runs: Sequence[Run]) -> Iterator[Finding]:
    """How the errors follow the tolerance."""
    if not runs or runs[-1].step is not None:
        return
    found = [p.exponent for p in _pairs(runs) if p.exponent > _FALLS]
    if not found:
        return
    exponent = float(median(found))
    how = "in proportion to the tolerance"
    if abs(exponent - 1) > _PROPORTION:
        how = f"like the tolerance to the power {exponent:.1f}"
    yield Finding(
        "tolerance",
        f"the error falls {how}: exponent {exponent:.2f} (median of {len(found)} "
        f"column{'s' if len(found) > 1 else ''}, from {min(found):.2f} to {max(found):.2f})",
        evidence={"exponent": exponent, "least": min(found), "most": max(found)},
    )


def _staying(runs: Sequence[Run]) -> Iterator[Finding]:
    """Errors that do not fall: rounding, noise, or the model."""
    stay = [p for p in _pairs(runs) if p.exponent <= _FALLS]
    what = "tolerance" if runs and runs[-1].step is None else "step"
    rounding = [p for p in stay if p.error < ROUNDING]
    if rounding:
        yield Finding(
            "limited_by_rounding",
            f"{_names(rounding)}: the error, {_worst(rounding):.1g} of the scale or less, does not "
            f"fall with the {what}, and need not: at this size it is rounding of binary64 "
            "arithmetic, not the model; only longer numbers make it smaller",
            evidence=_evidence(rounding),
        )
    noise = [p for p in stay if p.error >= ROUNDING and not p.is_same]
    if noise:
        yield Finding(
            "noise_does_not_fall",
            f"{_names(noise)}: the error, up to {_worst(noise):.1g} of the scale, does not fall "
            f"with the {what}, but is another curve in each run: it is noise, of single-precision "
            "numbers (1e-7), of iterations that stop early, or of rough interpolation, and not the "
            "model",
            Severity.WARNING,
            _evidence(noise),
        )
    same = [p for p in stay if p.error >= ROUNDING and p.is_same]
    if same:
        yield Finding(
            "error_stays",
            f"{_names(same)}: the error, up to {_worst(same):.1g} of the scale, is the same curve "
            f"in both runs and does not fall with the {what}: it is not the integrator's, but that "
            "of the model, its parameters, the start or the output; ask heyoka-bike diagnose",
            Severity.WARNING,
            _evidence(same),
        )


def _names(pairs: Sequence[_Pair]) -> str:
    more = len(pairs) - _NAMED
    names = ", ".join(p.place for p in pairs[:_NAMED])
    return names + (f" and {more} more" if more > 0 else "")


def _worst(pairs: Sequence[_Pair]) -> float:
    return max(p.error for p in pairs)


def _evidence(pairs: Sequence[_Pair]) -> dict[str, object]:
    return {"columns": [p.place for p in pairs], "max_rel_error": _worst(pairs)}


def _plain(order: float) -> str:
    return f"{round(order, 2) + 0.0:.2f}"  # no -0


def _orders(convergence: Sequence[Convergence]) -> list[Finding]:
    """The order of the program, and whether it has settled."""
    found = [c.orders[-1] for c in convergence if c.orders[-1] is not None]
    if not found:
        return []
    order = float(median(found))
    findings = [
        Finding(
            "order",
            f"observed order of convergence {_plain(order)} (median of {len(found)} "
            f"column{'s' if len(found) > 1 else ''}, from {_plain(min(found))} to "
            f"{_plain(max(found))})",
            evidence={"order": order, "least": min(found), "most": max(found)},
        )
    ]
    unsteady = [
        f"{c.maneuver}.{c.key}"
        for c in convergence
        if len(c.orders) > 1
        and c.orders[-1] is not None
        and c.orders[-2] is not None
        and abs(c.orders[-1] - c.orders[-2]) > _STEADY
    ]
    if unsteady:
        findings.append(
            Finding(
                "order_not_settled",
                f"the order of {', '.join(unsteady)} still changes from step to step: the steps "
                "are too large, or rounding has been reached, for one power law",
                evidence={"columns": unsteady},
            )
        )
    return findings
