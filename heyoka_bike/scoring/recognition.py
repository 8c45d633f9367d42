"""Recognise the maneuver of rows whose file does not name it, by the beginning of the motion.

A wrong program begins like a right one and departs from it later. So rows are compared with each
maneuver over spans of time, each twice as long as the one before. All spans count alike: the first
hundredth of a second as much as the last five seconds. The difference of a column from a maneuver
is relative, |x - y| / (|x| + |y|), in the unit, the sign and the zero that fit best. For columns
that hardly vary, it is relative to their variation. The logarithms of the differences are added.
Few digits, noise or a late error hide a difference in some spans: there all maneuvers are equally
far, and the other spans decide.

The nearest maneuver is a guess while another one cannot be excluded. Two things exclude it:

- The initial conditions of the two differ in a column of the file, or in the rate of an angle, and
  the first rows are by far nearer to those of the nearest maneuver.
- All rows of a column are near the nearest maneuver, and some are far from the other. Wrong
  equations can make many motions from the same initial conditions, but hardly the right motion of
  another maneuver.

No maneuver is excluded if a column excludes the nearest maneuver in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import log
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED, FREE_ZERO, RATE_OF
from heyoka_bike.numbers.double import Array, median
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.units import factor, tried

FASTEST_MODE = 0.05
"""Time constant of the benchmark's fastest mode [s]: rows up to this time show the initial
conditions, whatever the equations are."""

# Rows are near a maneuver if their relative difference from it, beyond the rounding of their
# digits, is at most this value.
NEAR = 0.01
# The first rows have certain initial conditions if their relative difference from these is at most
# EXACT. They surely have different ones if the difference is at least FAR, because the values then
# differ by a factor of 3. A mistake may turn a speed of 4 m/s into 4.67 m/s, which is between the
# two limits.
EXACT, FAR = TOLERANCE, 0.5
# Maximum number of rows of a span that are compared. More rows would not change the result.
MOST_ROWS_OF_SPAN = 16
# Log odds of the named unit (or the SI unit without a named one) against another unit. The sign and
# the zero as written have the same odds against another sign and zero.
LOG_ODDS_AS_WRITTEN = log(5.0)
ZEROED = ("potential_energy", "mechanical_energy")
"""Energies whose zero is a convention."""

# Columns whose values show the maneuver. The values of all other columns, such as heights and
# normal forces, are nearly the same in all maneuvers.
SIZED = {*BENCHMARK_COLUMNS} - {"potential_energy"}
ROUNDOFF = 1e-15  # relative to the scale of a column


@dataclass(frozen=True, slots=True)
class Recognised:
    """The maneuver to which rows are nearest.

    Attributes
    ----------
    maneuver
        Number of the maneuver.
    rivals : tuple of int
        Other maneuvers that cannot be excluded, the nearest first. If there are none, the maneuver
        is certain.
    apart : mapping of int to float
        Typical relative difference from each maneuver, by its number; 1 if the rows do not resemble
        it at all.
    """

    maneuver: int
    rivals: tuple[int, ...]
    apart: Mapping[int, float]


@dataclass(frozen=True, eq=False, slots=True)
class _Column:
    """The differences between a column and a maneuver.

    Attributes
    ----------
    spans
        Logarithm of the difference in each span; 0 without a row.
    largest
        The largest difference of all spans, beyond the rounding of the digits.
    at_start
        The difference in the first rows, which show the initial conditions; None without such rows.
    cost
        Logarithm of the odds against the unit, sign and zero in which the column is read.
    """

    spans: Array
    largest: float
    at_start: float | None
    cost: float


_Nearness = Mapping[str, _Column]
"""The differences of each column from one maneuver, by key."""


class Candidate(Protocol):
    """Rows of a file that are within the run of a maneuver to which they may belong."""

    @property
    def time(self) -> Array: ...
    @property
    def values(self) -> Mapping[str, Array]: ...
    @property
    def units(self) -> Mapping[str, str]: ...
    @property
    def reference(self) -> ReferenceManeuver: ...
    def spacing(self, key: str, values: Array) -> Array: ...


def recognised(candidates: Mapping[int, Candidate]) -> Recognised | None:
    """Return the maneuver to which rows are nearest; None if there is no value to compare.

    Parameters
    ----------
    candidates
        The rows within the run of each maneuver, by its number.
    """
    maneuvers = {n: rows.reference for n, rows in candidates.items()}
    near = {n: _nearness(rows) for n, rows in candidates.items() if len(rows.time)}
    far = {n: _sum(columns) for n, columns in near.items() if columns}
    if not far:
        return None
    first, *others = sorted(far, key=far.__getitem__)
    rivals = (
        n for n in others if not _is_excluded(near[first], near[n], maneuvers[first], maneuvers[n])
    )
    apart = {n: float(np.exp(np.mean([c.spans for c in near[n].values()]))) for n in far}
    return Recognised(first, tuple(rivals), apart)


def _sum(columns: _Nearness) -> float:
    return float(sum(c.spans.sum() + c.cost for c in columns.values()))


def _is_excluded(
    near: _Nearness, far: _Nearness, maneuver: ReferenceManeuver, other: ReferenceManeuver
) -> bool:
    """True if rows that are near one maneuver cannot belong to the other one."""
    keys = near.keys() & far.keys()
    starts = [
        (near[key].at_start, far[key].at_start)
        for key in keys
        if _starts_apart(key, maneuver, other)
    ]
    both = [(a, b) for a, b in starts if a is not None and b is not None]
    runs = [(near[key].largest, far[key].largest) for key in keys if varies(key, maneuver)]
    shows = any(a <= EXACT or b >= FAR for a, b in both if CLEARLY * a <= b)
    shows |= any(a <= NEAR and b >= CLEARLY * NEAR for a, b in runs)
    contradicts = any(CLEARLY * b <= a for a, b in both)
    contradicts |= any(b <= NEAR and a >= CLEARLY * NEAR for a, b in runs)
    return shows and not contradicts


def varies(key: str, maneuver: ReferenceManeuver) -> bool:
    """True if a column fits the maneuver only if it has the same curve, not only the same size."""
    return key not in SIZED or float(np.ptp(maneuver[key])) >= FAR * maneuver.scale(key)


def middle(key: str, maneuver: ReferenceManeuver) -> float:
    """Return the value [SI] to subtract from a column before it is compared with a maneuver."""
    return 0.0 if key in SIZED else float(median(maneuver[key]))


def factors(key: str, named: str | None, maneuver: ReferenceManeuver) -> Mapping[str, float]:
    """Return the factor to SI for each unit in which a column may be written, by unit."""
    found = {unit: factor(unit)[0] for unit in tried(COMPARED[key][0].unit, named)}
    if key == "forward_speed":
        # The speed may be written as a wheel's rate [rad/s]. The factor between the two is the
        # wheel's radius.
        found |= {name: float(Fraction(maneuver.parameters[name])) for name in ("rR", "rF")}
    return found


def _starts_apart(key: str, one: ReferenceManeuver, other: ReferenceManeuver) -> bool:
    """True if the initial conditions of two maneuvers differ in a column, or in its rate."""
    keys = (key, RATE_OF.get(key, key))
    return any(
        abs(one[k][0] - other[k][0]) > TOLERANCE * max(one.scale(k), other.scale(k)) for k in keys
    )


def _nearness(rows: Candidate) -> _Nearness:
    maneuver = rows.reference
    spans = list(_spans(rows.time))
    picked = np.concatenate(spans)
    time = rows.time[picked]
    ends = np.cumsum([len(span) for span in spans])[:-1]
    names = [key for key in COMPARED if key in rows.values]
    expected = maneuver.approximate(time, names)
    found = {}
    for key in names:
        values = rows.values[key][picked]
        half = rows.spacing(key, values) / 2
        good = np.isfinite(values) & np.isfinite(expected[key])
        if not good.any():
            continue
        is_start = good & (time <= FASTEST_MODE)
        if key in RATE_OF and not maneuver[key][0]:
            # If an angle is zero at the start, its first row does not show the rate. The next rows
            # do.
            is_start &= time > 0.0
        else:
            is_start &= np.cumsum(is_start) == 1
        compared = _Compared(
            values, half, expected[key], middle(key, maneuver), maneuver.scale(key), good, is_start,
            ends.tolist(),
        )  # fmt: skip
        forms = (compared.read(form) for form in _forms(key, rows.units.get(key), maneuver))
        found[key] = min(forms, key=lambda c: float(c.spans.sum()) + c.cost)
    return found


def _spans(time: Array) -> Iterator[NDArray[np.intp]]:
    """Yield the rows in each span of time, as indices: the start, then spans of doubling length."""
    late = time > 0.0
    doubled = np.full(len(time), -np.inf)
    doubled[late] = np.ceil(np.log2(time[late]))
    for which in np.unique(doubled):
        span = np.flatnonzero(doubled == which)
        few = min(len(span), MOST_ROWS_OF_SPAN)
        yield span[np.linspace(0, len(span) - 1, few).astype(np.intp)]


_Form = tuple[float, bool, float]
"""Signed factor to SI, whether values count from the first row, and log odds against this form."""


def _forms(key: str, named: str | None, maneuver: ReferenceManeuver) -> Iterator[_Form]:
    """Yield the units, signs and zeros in which a column may be written."""
    written = named or COMPARED[key][0].unit
    signs = (1,) if key.endswith("energy") else (1, -1)
    zeros = (False, True) if key in ZEROED or key in FREE_ZERO else (False,)
    for unit, size in factors(key, named, maneuver).items():
        for sign in signs:
            for is_moved in zeros:
                others = (unit != written) + (sign < 0) + is_moved
                yield sign * size, is_moved, others * LOG_ODDS_AS_WRITTEN


@dataclass(frozen=True, eq=False, slots=True)
class _Compared:
    """Some rows of a column that are compared with one maneuver.

    Attributes
    ----------
    values, half
        Values as written, and the largest rounding error of each.
    expected, middle, scale
        Values of the maneuver at these rows, the value that is subtracted before they are compared,
        and the scale of the column [SI].
    is_finite, is_start
        Rows with a value; rows that show the initial conditions.
    ends
        Indices at which spans end.
    """

    values: Array
    half: Array
    expected: Array
    middle: float
    scale: float
    is_finite: NDArray[np.bool_]
    is_start: NDArray[np.bool_]
    ends: Sequence[int]

    def read(self, form: _Form) -> _Column:
        """Return the differences between column and maneuver, for one unit, sign and zero."""
        times, is_moved, cost = form
        x, y = times * self.values, self.expected
        if is_moved:
            first = int(np.argmax(self.is_finite))
            x, y = x - x[first], y - y[first]
        else:
            x, y = x - self.middle, y - self.middle
        floor = abs(times) * self.half + ROUNDOFF * self.scale + np.finfo(np.float64).tiny
        apart, size = np.abs(x - y) + floor, np.abs(x) + np.abs(y) + floor
        beyond = np.maximum(apart - 2 * floor, 0.0)
        logs, largest = [], 0.0
        columns = (np.split(v, self.ends) for v in (apart, beyond, size, self.is_finite))
        for a, b, s, good in zip(*columns, strict=True):
            if not good.any():
                logs.append(0.0)
                continue
            # Use medians, because a few bad rows do not change them.
            whole = float(median(s[good]))
            logs.append(log(float(median(a[good])) / whole))
            largest = max(largest, float(median(b[good])) / whole)
        some = self.is_start
        at_start = float(median(apart[some]) / median(size[some])) if some.any() else None
        return _Column(np.array(logs), largest, at_start, cost)
