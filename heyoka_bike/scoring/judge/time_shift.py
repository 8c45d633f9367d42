"""Times that are off by a constant.

Rows may contain the right motion at times that are off by a constant, such as one second. Small
shifts resemble other errors, and the diagnosis finds them. Here the whole motion has to fit: one
shift of all maneuvers must turn a motion that is wrong everywhere into a right one.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.numbers.double import Array, median
from heyoka_bike.scoring.alignment import ROWS_COMPARED, Part, spread
from heyoka_bike.scoring.evidence.contradictions import TimeShift
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY, FEW_COLUMNS
from heyoka_bike.scoring.recognition import FASTEST_MODE
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.units import factor

# Step between the shifts of a first coarse search [s].
_FIRST_STEP = FASTEST_MODE / 2
# Largest error of columns that fit, relative to their rms. It must exceed 0.03, by which the
# definitions of the roll angle differ. In addition, the shift must clearly reduce the errors in
# each maneuver.
_FITS = 0.05
# Number of steps of the golden section search, which narrows the shift from a hundredth of a second
# to a nanosecond.
_ROUNDS_OF_GOLDEN_SECTION = 40
_GOLDEN_RATIO = (5**0.5 - 1) / 2
# The shift is rounded to the smallest number of decimal places with which the error is at most this
# many times the error with the best shift.
_PLACES_TRIED = range(7)
_AS_GOOD_AS_BEST = 1.1


def time_shifted(report: Report) -> Iterator[TimeShift]:
    """Yield the constant by which all times are off, if there is one."""
    shift = time_shift([m.part for m in report.maneuvers])
    if shift is None:
        return
    begins = all(abs(m.part.time[0] - shift) < (m.step or 0.0) / 10 for m in report.maneuvers)
    yield TimeShift(shift, begins)


def time_shift(parts: Sequence[Part]) -> float | None:
    """Return the delay of the times of a file [s]; None if they are not shifted.

    Signs and units of the columns are those that fit best; definitions are the default ones.
    """
    motions = [few for part in parts if (few := _some_rows(part)) is not None]
    if not motions or any(_error(m, 0.0) < _FITS for m in motions):
        return None
    longest = max(float(m.time[-1]) for m in motions)
    if longest <= 0.0:
        # All rows are at the start of the motion, where they fit any motion.
        return None
    grid = np.arange(-longest, longest, _FIRST_STEP)
    first = min(grid, key=lambda shift: _mean_error(motions, shift, exact=False))
    best = _refined(motions, float(first))
    numbers = [m.number for m in motions]
    apart = [float(median(np.diff(p.time))) for p in parts if p.number in numbers]
    if abs(best) <= 1.5 * max(apart):
        return None
    before, after = ([_error(m, shift) for m in motions] for shift in (0.0, best))
    # With few columns, any fit seems good (see `ratios`).
    needed = CLEARLY if sum(len(m.values) for m in motions) > FEW_COLUMNS else BY_FAR
    if any(a > _FITS or needed * a > b for a, b in zip(after, before, strict=True)):
        return None
    limit = _AS_GOOD_AS_BEST * _mean_error(motions, best)
    return next(
        (x for x in (round(best, n) for n in _PLACES_TRIED) if _mean_error(motions, x) <= limit),
        best,
    )


def _some_rows(part: Part) -> Part | None:
    """Return some rows of roll and steer, which show a shift; None if there are none."""
    if len(part.time) < 2:
        return None
    # Speed and energies hardly vary, so they do not show a shift.
    some = part.at(spread(len(part.time), ROWS_COMPARED)).only(LATERAL)
    good = np.all([np.isfinite(x) for x in some.values.values()], axis=0)
    return some.at(good) if some.values and good.any() else None


def _error(part: Part, shift: float, *, exact: bool = True) -> float:
    """Return the largest relative error of the columns, with all times earlier by `shift`.

    If not `exact`, the reference is interpolated linearly between its rows.
    """
    time, reference = part.time - shift, part.reference
    inside = (time >= 0.0) & (time <= float(reference.duration))
    if 2 * np.count_nonzero(inside) < len(inside):
        return np.inf
    time = time[inside]
    if exact:
        expected = reference.approximate(time, list(part.values))
    else:
        expected = {k: np.interp(time, reference.time, reference.rows[k]) for k in part.values}
    return max(_relative_error(x[inside], expected[k]) for k, x in part.values.items())


def _relative_error(values: Array, expected: Array) -> float:
    """Return the relative rms error of a column, with the sign and the unit that fit."""
    size, own = rms(expected), rms(values)
    if not size or not own:
        return np.inf
    in_degrees = factor("degree")[0]
    # The factor between degrees and radians also converts degrees per second to radians per second.
    unit = in_degrees if own > size / in_degrees**0.5 else 1.0
    sign = np.sign(np.dot(values / own, expected / size))
    return rms(sign * unit * values - expected) / size


def _mean_error(motions: Sequence[Part], shift: float, *, exact: bool = True) -> float:
    """Return the geometric mean of the errors over the maneuvers."""
    errors = [_error(m, shift, exact=exact) for m in motions]
    return float(np.exp(np.mean(np.log(np.maximum(errors, np.finfo(np.float64).tiny)))))


def _refined(motions: Sequence[Part], near: float) -> float:
    """Return the best shift within one step of the grid around `near`, by golden-section search."""
    low, high = near - _FIRST_STEP, near + _FIRST_STEP
    for _ in range(_ROUNDS_OF_GOLDEN_SECTION):
        a, b = high - _GOLDEN_RATIO * (high - low), low + _GOLDEN_RATIO * (high - low)
        if _mean_error(motions, a) < _mean_error(motions, b):
            high = b
        else:
            low = a
    return (low + high) / 2
