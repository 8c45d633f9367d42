"""Find columns whose values are coarser than their digits: short floats, or multiples of a step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import MOST_SAMPLED, Part, spread
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision
from heyoka_bike.scoring.evidence.words import number_in_unit
from heyoka_bike.scoring.findings import Severity, maneuvers, named
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.reading.results import Quantum
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Undone, places
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.scoring.units import factor

# Minimum number of different values in a column of multiples of a step. The step must also be far
# coarser than the unit of the last digit. By chance, the values of about one smooth column in 1e5
# are multiples of one step.
_FEWEST_LEVELS = 5
# Significant bits of half-precision and single-precision numbers; half precision is tried first.
_HALF, _SINGLE = 11, 24
# Number of last bits that are zero in all values only if the values are counts of a step.
_UNUSED_BITS = 4
_BITS = (_HALF, _SINGLE)
# Largest distance of a written value from the nearest number with few bits, in halves of the unit
# of the last digit written: 1 for rounding, and a little more for the roundoff of reading.
_ROUNDED = 1.01
# The step is found from this many of the smallest distances between values. A small distance is a
# small multiple of the step, so an error of the step matters least there.
_DISTANCES = 100


@dataclass(frozen=True, slots=True)
class HalfPrecision(Evidence):
    """The values of columns are half-precision numbers.

    Attributes
    ----------
    keys
    are_all
        True if all values of the file that vary are half-precision numbers.
    """

    keys: tuple[str, ...]
    are_all: bool

    code = "half_precision"
    severity = Severity.WARNING

    def message(self) -> str:
        which = "All values" if self.are_all else f"The values of {named(self.keys)}"
        return (
            f"{which} are half-precision numbers (11 bits), which have three digits. Store them in "
            "double precision"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


def few_bits(report: Report) -> Undone | None:
    """Look for columns of single or half precision, whatever digits they are written with."""
    bits = {(m.maneuver, c.key): found for m, c in places(report) if (found := _bits_of(m, c))}
    if not bits:
        return None
    keys = {n: tuple(dict.fromkeys(k for (_, k), x in bits.items() if x == n)) for n in _BITS}
    is_all = all((m.maneuver, c.key) in bits for m, c in places(report) if np.ptp(c.trace.value))
    seen: list[Evidence] = []
    if keys[_HALF]:
        seen.append(HalfPrecision(keys[_HALF], is_all and not keys[_SINGLE]))
    if keys[_SINGLE]:
        every = is_all and not keys[_HALF]
        seen.append(SinglePrecision(tuple(sorted(keys[_SINGLE])), is_written=True, are_all=every))
    parts = []
    for m in report.maneuvers:
        quantum = {k: Quantum(2, digits=x) for (n, k), x in bits.items() if n == m.maneuver}
        parts.append(replace(m.part, quantum={**m.part.quantum, **quantum}))
    return Undone(tuple(seen), tuple(parts))


def _bits_of(m: ManeuverScore, c: ColumnScore) -> int | None:
    """Return the bits of a column's values by `bits_of` or its quantum; None for more bits."""
    found = bits_of(m.part.values[c.key], m.part.quantum.get(c.key))
    return found or (_SINGLE if _has_few_bits(m, c) else None)


def bits_of(values: Array, quantum: Quantum | None) -> int | None:
    """Return 11 or 24 if the values are numbers of half or single precision, otherwise None.

    Each value is compared with the spacing of such numbers in its own binade. If that spacing is
    hardly coarser than the digits written, any value is near such a number by chance, so these
    values do not count. Values with far fewer bits are counts of a step, such as an encoder's.
    """
    values = values[spread(len(values), MOST_SAMPLED)]
    values = values[np.isfinite(values) & (values != 0.0)]
    # Use a set, because np.unique would import the module of masked arrays.
    if len(set(values.tolist())) < MIN_ROWS_FOR_SHAPE:
        return None
    least = np.finfo(np.float64).eps * np.abs(values)
    if quantum is not None:
        least = np.maximum(least, quantum.at(values) / 2)
    for bits in _BITS:
        apart = Quantum(2, digits=bits).at(values)
        off = np.abs(values - apart * np.rint(values / apart))
        telling = apart > CLEARLY * least
        if np.sum(telling) >= MIN_ROWS_FOR_SHAPE and np.all(off <= _ROUNDED * least):
            return bits if _use_their_bits(values, bits, least) else None
    return None


def _use_their_bits(values: Array, bits: int, least: Array | float) -> bool:
    """True if some values have a bit among the last few of numbers with this many bits."""
    coarser = Quantum(2, digits=bits - _UNUSED_BITS).at(values)
    off = np.abs(values - coarser * np.rint(values / np.where(coarser > 0.0, coarser, 1.0)))
    return bool(np.any(off > _ROUNDED * least))


@dataclass(frozen=True, slots=True)
class CoarseGrid(Evidence):
    """All values of a column are multiples of a step that is far coarser than its digits.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    step
        Largest step of the maneuvers [SI unit].
    """

    key: str
    maneuvers: tuple[int, ...]
    step: float

    code = "coarse_grid"
    severity = Severity.WARNING

    def message(self) -> str:
        step = number_in_unit(self.step, COMPARED[self.key][0].unit)
        return (
            f"{self.key} of {maneuvers(self.maneuvers)}: every value is a multiple of {step}, far "
            "coarser than the digits written. Such a step comes from an encoder, a table or "
            "rounding. Errors below it are not judged"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers), "step": self.step}


def coarse_grids(report: Report) -> Undone | None:
    """Look for columns whose values are multiples of a step far coarser than their digits.

    A grid hides errors that are smaller than its step. It counts only if the step is over a
    hundredth of the column's error, or costs one of the first six digits.
    """
    levels = {
        (m.maneuver, c.key): _levels(m, c) for m, c in places(report) if not _has_few_bits(m, c)
    }
    units = {c.key: factor(c.as_understood.unit)[0] for _, c in places(report)}
    steps = {
        (n, key): step
        for (n, key), step in _steps(levels).items()
        if _matters(report[n][key], step * units[key])
    }
    if not steps:
        return None
    errors = grouped(((m.maneuver, c.key) in steps, c.error) for m, c in places(report))
    rest = max(errors.get(False, [1.0]))
    # Each of two values may be wrong by one step, so their difference may be wrong by two steps.
    by_grid = (
        (report[n][key].max_abs_error or 0.0) <= 2 * step * units[key]
        for (n, key), step in steps.items()
    )
    of = {n: {key: step for (m, key), step in steps.items() if m == n} for n in report}
    if rest < min(TOLERANCE, max(errors[True]) / BY_FAR) and all(by_grid):
        # The other columns are right and far more accurate. So the columns that are multiples of a
        # step add no information and are left out.
        on_grid = {key for _, key in steps}
        parts = [m.part.without(on_grid) for m in report.maneuvers]
    else:
        parts = [_on_grid(m.part, of[m.maneuver]) for m in report.maneuvers]
    alike = grouped(((key, step), n) for (n, key), step in steps.items())
    seen = (CoarseGrid(key, tuple(of), step * units[key]) for (key, step), of in alike.items())
    return Undone(tuple(seen), tuple(parts))


def _has_few_bits(m: ManeuverScore, c: ColumnScore) -> bool:
    """True if a column is known to be of single or half precision, and uses these bits."""
    quantum, values = m.part.quantum.get(c.key), m.part.values[c.key]
    if quantum is None or quantum.base != 2 or quantum.digits not in _BITS:
        return False
    return _use_their_bits(values[np.isfinite(values)], quantum.digits, 0.0)


def _matters(c: ColumnScore, step: float) -> bool:
    """True if a step is over a hundredth of a column's error, or costs one of six digits."""
    error = c.max_abs_error or 0.0
    return bool(step > min(error / BY_FAR, RIGHT * c.scale))


def _steps(levels: Mapping[tuple[int, str], tuple[Array, float]]) -> dict[tuple[int, str], float]:
    """Find for each column, by place, the step of which all its values are multiples.

    If a column has too few levels in one maneuver, the step is found from its other maneuvers, or
    from its levels in all maneuvers together.
    """
    found = {place: step for place, x in levels.items() if (step := step_of(*x)) is not None}
    known = {key: step for (_, key), step in found.items()}
    for key, each in grouped(
        (key, x) for (_, key), x in levels.items() if key not in known
    ).items():
        every = np.unique(np.concatenate([values for values, _ in each]))
        if (step := step_of(every, max(least for _, least in each))) is not None:
            known[key] = step
    for place, (values, least) in levels.items():
        of_key = known.get(place[1])
        if of_key is None or not _are_multiples(values, of_key, least):
            continue
        # A column has the same step in all maneuvers, unless it is written with a different number
        # of decimals in some of them.
        if abs(found.setdefault(place, of_key) / of_key - 1.0) < RIGHT:
            found[place] = of_key
    return {place: found[place] for place in levels if place in found}


def _levels(m: ManeuverScore, c: ColumnScore) -> tuple[Array, float]:
    """Return the different values of a column as written, and half of the last digit."""
    quantum, values = m.part.quantum.get(c.key), m.part.values[c.key]
    # The first row contains the given initial conditions, so it may be exact where the rest of the
    # column is measured in steps.
    values = values[1:][np.isfinite(values[1:])]
    least = float(np.max(np.abs(values), initial=0.0)) * float(np.finfo(np.float64).eps)
    if quantum is not None:
        least = max(least, float(np.max(quantum.at(values), initial=0.0)) / 2)
    return np.unique(values), least


def _on_grid(part: Part, steps: Mapping[str, float]) -> Part:
    """Replace the values of columns with the nearest exact multiples of their steps."""
    quantum = {key: Quantum(base=10, places=0, step=step) for key, step in steps.items()}
    values = {key: step * np.rint(part.values[key] / step) for key, step in steps.items()}
    return replace(
        part,
        values={**part.values, **values},
        quantum={**part.quantum, **quantum},
        lo={key: x for key, x in part.lo.items() if key not in steps},
    )


def step_of(levels: Array, least: float) -> float | None:
    """Find the step of which all levels (different values) are multiples; None without one."""
    apart = np.diff(levels)
    apart = apart[apart > MAX_ROUNDING_FLOORS * least]
    if len(levels) < _FEWEST_LEVELS or not len(apart):
        return None
    step = _common(np.sort(apart)[:_DISTANCES], least)
    if step is None:
        return None
    # A large difference of two values contains many steps, so rounding affects it least. Refine the
    # step with larger and larger differences, and finally with the largest value.
    ends = 2 ** np.arange(int(np.log2(len(levels) - 1)) + 1)
    for whole in (*(levels[[*ends, -1]] - levels[0]), np.max(np.abs(levels))):
        step = float(whole) / max(round(float(whole) / step), 1)
    return step if _are_multiples(levels, step, least) else None


def _common(distances: Array, least: float) -> float | None:
    """Find the largest common divisor of distances, to a hundredth; None if there is none.

    Euclid's algorithm: a remainder is at most half a step, so the step falls until all remainders
    vanish. If the step comes near `least`, the resolution of the digits, before that, there is no
    common divisor.
    """
    step = float(distances[0])
    while step > BY_FAR * least:
        rest = np.abs(distances - step * np.rint(distances / step))
        rest = rest[BY_FAR * rest > step]
        if not len(rest):
            return step
        step = float(np.min(rest))
    return None


def _are_multiples(levels: Array, step: float, least: float) -> bool:
    off = float(np.max(np.abs(levels - step * np.rint(levels / step))))
    return step > BY_FAR * least and off <= MAX_ROUNDING_FLOORS * least
