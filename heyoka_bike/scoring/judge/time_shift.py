"""Rows that hold the right motion at times that are off by a constant, such as one second.

Small shifts look like other errors and are left to the diagnosis. Here the whole motion has to fit:
shifted by one and the same time in all maneuvers, what was wrong all over is right.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.numbers.double import Array, median
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.scoring.alignment import Part, spread
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.units import factor

# Rows that are compared, and times that are tried first [s]: the fastest mode decays in 0.05 s.
_ROWS = 200
_GRID = 0.02
# Below this part of their size the columns are not wrong enough to ask.
_WRONG = 0.02
# ... and shifted they have to be so many times better in each maneuver, and this good. Definitions
# of the roll angle differ by 0.03 of it.
_BETTER = 10.0
_RIGHT = 0.05
# Half the rows at least must have a place in the run.
_KEPT = 0.5
# Halvings of the golden section: from a hundredth of a second to a nanosecond.
_ROUNDS = 40
_GOLDEN = (5**0.5 - 1) / 2
# A time of few decimals is meant if the file cannot tell it from the best one [s].
_DECIMALS = range(7)
_AS_GOOD = 1.1


def time_shifted(report: Report) -> Iterator[Finding]:
    """Times that are off by a constant."""
    shift = time_shift([m.part for m in report.maneuvers])
    if shift is None:
        return
    first = all(abs(m.part.time[0] - shift) < (m.step or 0.0) / 10 for m in report.maneuvers)
    starts = f"; the first row, at {shift:.6g} s, holds the initial state" if first else ""
    yield warning(
        "time_shifted",
        f"All times are {abs(shift):.9g} s too {'late' if shift > 0 else 'early'}: with that taken "
        f"{'off' if shift > 0 else 'into account'} the motion fits{starts}. The errors here are "
        "those at the times as written",
        shift=shift,
    )


def time_shift(parts: Sequence[Part]) -> float | None:
    """Return the delay of the times of a file [s]; None if they are not shifted.

    Signs and units of the columns are those that fit best, definitions those by default.
    """
    motions = [m for part in parts if (m := _motion(part)) is not None]
    if not motions or any(m.error(0.0) < _WRONG for m in motions):
        return None
    longest = max(float(m.time[-1]) for m in motions)
    if longest <= 0.0:
        # All rows are of the start, which fits any motion.
        return None
    grid = np.arange(-longest, longest, _GRID)
    first = min(grid, key=lambda shift: _joint(motions, shift, exact=False))
    best = _refined(motions, float(first))
    if abs(best) <= max(1.5 * m.spacing for m in motions):
        return None
    before, after = ([m.error(shift) for m in motions] for shift in (0.0, best))
    if any(a > _RIGHT or _BETTER * a > b for a, b in zip(after, before, strict=True)):
        return None
    limit = _AS_GOOD * _joint(motions, best)
    return next(
        (x for x in (round(best, n) for n in _DECIMALS) if _joint(motions, x) <= limit), best
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Motion:
    """Some rows of a maneuver.

    Attributes
    ----------
    reference : ReferenceManeuver
    time : ndarray, shape (n,)
        As written [s].
    values : mapping of str to ndarray, shape (n,)
        As written.
    spacing
        Of all rows [s].
    """

    reference: ReferenceManeuver
    time: Array
    values: Mapping[str, Array]
    spacing: float

    def error(self, shift: float, *, exact: bool = True) -> float:
        """Error over size of the worst column, with times so much earlier.

        If not exact, by straight lines between the rows of the reference.
        """
        time = self.time - shift
        inside = (time >= 0.0) & (time <= float(self.reference.duration))
        if np.mean(inside) < _KEPT:
            return np.inf
        time = time[inside]
        if exact:
            expected = self.reference.approximate(time, list(self.values))
        else:
            rows = self.reference.rows
            expected = {k: np.interp(time, self.reference.time, rows[k]) for k in self.values}
        return max(_apart(x[inside], expected[k]) for k, x in self.values.items())


def _apart(values: Array, expected: Array) -> float:
    """Error over size of a column, with the sign and the unit that fit."""
    size, own = rms(expected), rms(values)
    if not size or not own:
        return np.inf
    in_degrees = factor("degree")[0]
    # Rates are in degrees per second where angles are in degrees.
    unit = in_degrees if own > size / in_degrees**0.5 else 1.0
    sign = np.sign(np.dot(values / own, expected / size))
    return rms(sign * unit * values - expected) / size


def _motion(part: Part) -> _Motion | None:
    if len(part.time) < 2:
        return None
    rows = spread(len(part.time), _ROWS)
    # Speed and energies hardly vary: they show no shift.
    values = {key: part.values[key][rows] for key in LATERAL if key in part.values}
    if not values:
        return None
    good = np.all([np.isfinite(x) for x in values.values()], axis=0)
    if not good.any():
        return None
    return _Motion(
        part.reference,
        part.time[rows][good],
        {key: x[good] for key, x in values.items()},
        float(median(np.diff(part.time))),
    )


def _joint(motions: Sequence[_Motion], shift: float, *, exact: bool = True) -> float:
    """Geometric mean of the errors over the maneuvers."""
    errors = [m.error(shift, exact=exact) for m in motions]
    return float(np.exp(np.mean(np.log(np.maximum(errors, np.finfo(np.float64).tiny)))))


def _refined(motions: Sequence[_Motion], near: float) -> float:
    """The best shift within a step of the grid, by golden section."""
    low, high = near - _GRID, near + _GRID
    for _ in range(_ROUNDS):
        a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        if _joint(motions, a) < _joint(motions, b):
            high = b
        else:
            low = a
    return (low + high) / 2
