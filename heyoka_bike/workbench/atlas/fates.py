"""Long-term behaviour of many motions, decided from samples in binary64.

A motion is followed window by window until one of these happens, or for `LONGEST`.

- *It falls*: the handlebar turns by a right angle to either side, or the step size vanishes, as it
  does at a singularity. The right angle is found as a zero of the Taylor polynomials.
- *It converges to steady motion.* The energy is constant, so the start determines the speed of
  straight running and the eigenvalues of the equations linearised there. The motion converges if
  all real parts are negative, and if roll, steer and their rates stay so small over a window that
  terms of third order are below a hundredth of the decay.
- *It approaches a limit cycle*: over 20 s the lean changes sign, and its maxima repeat after one,
  two, ... or eight of them, to a thousandth.

A wheel leaves the floor where its normal force passes zero. This is found from samples, which are
32 times denser where the samples, or parabolas through three of them, indicate a zero.

The condition number is the factor by which a motion magnifies a small error of its initial state.
The derivative with respect to the initial state obeys a linear equation, whose coefficients are
known at the samples. Magnus' method of fourth order takes steps over two samples each. It
multiplies the derivative by the exponential of a mean of the coefficients, so fast decay does no
harm.

None of this is proved. Rounding decides where motions are chaotic, and next to the basin boundary.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.parameters import START
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.atlas.data import (
    CYCLE,
    FALLS,
    FRONT,
    LIFTS,
    REAR,
    UNDECIDED,
    UPRIGHT,
    VARIABLES,
    WEAVES,
)
from heyoka_bike.workbench.atlas.runs import (
    LATERAL,
    PITCH,
    ROLL,
    SPACING,
    SPIN,
    STEER,
    WINDOW,
    Runs,
)
from heyoka_bike.workbench.fast.vector_code import STATE_SIZE


def tops(values: Array) -> tuple[Array, Array]:
    """Return the maxima and their places, from a parabola through each local maximum.

    Parameters
    ----------
    values : ndarray, shape (motions, samples)

    Returns
    -------
    ndarray, shape (motions, samples - 2), twice
        Minus infinity where there is no maximum; places count samples from the middle one.
    """
    a, b, c = values[:, :-2], values[:, 1:-1], values[:, 2:]
    with np.errstate(invalid="ignore", divide="ignore"):
        is_top = (b >= a) & (b > c)
        bend = 2 * b - a - c
        top = np.where(is_top, b + (a - c) ** 2 / (8 * bend), -np.inf)
        return top, np.where(is_top, (c - a) / (2 * bend), 0.0)


def largest(values: Array) -> Array:
    """Return the largest value of each row, including maxima between samples."""
    found: Array = np.fmax(np.fmax.reduce(values, axis=1), tops(values)[0].max(axis=1))
    return found


def first_negative(values: Array) -> Array:
    """Return the place, in samples, where each row first passes below zero; NaN without one."""
    with np.errstate(invalid="ignore", divide="ignore"):
        is_below = values < 0
        i = np.argmax(is_below, axis=1)
        rows = np.arange(len(values))
        here, ahead = values[rows, i], values[rows, np.maximum(i - 1, 0)]
        # If the first sample is below zero, there is no earlier sample for an interpolation. Then
        # return the place of the first sample.
        back = np.where(np.isfinite(ahead) & (ahead > 0), here / (here - ahead), 0.0)
        crossed = np.where(is_below.any(axis=1), i - back, np.nan)
        depth, place = tops(-values)
        is_dip = (depth > 0) & ~is_below[:, 1:-1]
        j = np.argmax(is_dip, axis=1)
        dipped = np.where(is_dip.any(axis=1), j + 1 + place[rows, j], np.nan)
    found: Array = np.fmin(crossed, dipped)
    return found


SECONDS = 10
"""The magnification is the largest over this time [s]."""

EARLY_OVERSAMPLING = 2
"""Oversampling within these seconds, because magnification comes in bursts."""

_SECONDS_OF_STEP = 2 * SPACING / EARLY_OVERSAMPLING
_TERMS_OF_EXPONENTIAL = 12  # number of terms of the series for the matrix exponential
# Step in roll and steer for finite differences of the pitch [rad]. The pitch is an even function
# near straight running, so its slopes are accurate to 1e-10.
_SHIFT_OF_PITCH = 1e-5
_AROUND = 2  # number of samples on either side of the largest sample


def conditions(runs: Runs, samples: Array, which: Array) -> Array:
    """Return the largest factor by which each motion magnifies a small initial error.

    This is the largest spectral norm of the derivative of the state with respect to the initial
    state.

    The derivative is that of roll, steer, their rates [rad, rad/s] and speed [m/s], at every other
    sample. The norm is accurate to a few percent in the worst case, where it comes in bursts.

    Parameters
    ----------
    runs : Runs
    samples : ndarray, shape (motions, odd number of samples, 6)
        NaN after the end of a motion.
    which : ndarray, shape (motions,)
        Indices of their bicycles.

    Returns
    -------
    ndarray, shape (motions,)
    """
    slopes = runs.slopes(samples, which)
    length = runs.equations(which).k.length * np.ones(len(samples))
    flow = _start(runs, samples[:, 0], which, length)
    found = [_seen(flow, length)]
    for i in range(0, samples.shape[1] - 2, 2):
        flow = _step(flow, *(slopes[:, i + j] for j in range(3)))
        found.append(_seen(flow, length))
    return _largest_norm(np.stack(found, axis=1))


def _step(flow: Array, begin: Array, middle: Array, end: Array) -> Array:
    mean = _SECONDS_OF_STEP / 6 * (begin + 4 * middle + end)
    tilt = _SECONDS_OF_STEP / 12 * (end - begin)
    exponent = mean + tilt @ mean - mean @ tilt
    found = flow
    for i in range(_TERMS_OF_EXPONENTIAL, 0, -1):
        found = flow + exponent @ found / i
    return found


def _start(runs: Runs, states: Array, which: Array, length: Array) -> Array:
    """Return the derivatives of the initial state by `START`, shape (motions, 6, 5)."""
    found = np.zeros((len(states), STATE_SIZE, len(START)))
    for column, row in enumerate(LATERAL):
        found[:, row, column] = 1.0
    found[:, SPIN, -1] = 1 / length
    k = runs.equations(which).k
    roll, pitch, steer = states[:, ROLL], states[:, PITCH], states[:, STEER]
    for column, (a, b) in enumerate(((_SHIFT_OF_PITCH, 0.0), (0.0, _SHIFT_OF_PITCH))):
        ahead = pitch_on_the_floor(k, roll + a, pitch, steer + b)
        found[:, PITCH, column] = (ahead - pitch_on_the_floor(k, roll - a, pitch, steer - b)) / (
            2 * _SHIFT_OF_PITCH
        )
    return found


def _seen(flow: Array, length: Array) -> Array:
    """Return the derivatives of the variables `START` by their initial values, (motions, 5, 5)."""
    found: Array = flow[:, (*LATERAL, SPIN)].copy()
    found[:, -1] *= length[:, None]
    return found


def _largest_norm(matrices: Array) -> Array:
    """Return each motion's largest spectral norm over its times; NaN entries do not count.

    `matrices` has the shape (motions, times, 5, 5). The Frobenius norm is an upper bound, and close
    if one direction dominates. So the spectral norm is computed near the largest Frobenius norm,
    and a parabola through these values gives the maximum.
    """
    sizes = np.square(matrices).sum(axis=(2, 3))
    sizes[~np.isfinite(sizes)] = 0.0
    around = np.argmax(sizes, axis=1)[:, None] + np.arange(-_AROUND, _AROUND + 1)
    around = np.clip(around, 0, sizes.shape[1] - 1)
    chosen = np.take_along_axis(matrices, around[:, :, None, None], axis=1)
    chosen[~np.isfinite(chosen).all(axis=(2, 3))] = 0.0
    return largest(np.linalg.norm(chosen, ord=2, axis=(2, 3)))


LONGEST = 200.0
"""A motion is followed for at most this time [s]."""

SETTLED = 0.01
"""A converging motion has settled once roll and steer stay below this angle [rad]."""

_SECONDS_OF_WINDOW = WINDOW * SPACING
_FLAT = 0.03  # threshold relative to the square root of the decay; see `_is_straight`
_WINDOWS_OF_WEAVE = 4  # number of windows over which a weave must repeat itself
_REPEATS = 1e-3
_MOST_PEAKS = 8  # maximum number of maxima of the lean in a period
_FINER = 32  # factor by which sampling is refined where a wheel lifts


def _straight(runs: Runs, states: Array, which: Array) -> tuple[Array, Array]:
    """Return speed [m/s] and growth [1/s] of straight running with each motion's energy.

    Both are NaN if the energy does not suffice. The growth is the largest real part of the
    eigenvalues at that speed, negative if it is stable.
    """
    equations = runs.equations(which)
    upright = np.zeros_like(states)
    upright[:, SPIN] = 1 / equations.k.length
    still = equations.energies(list(upright.T))
    surplus = equations.energies(list(states.T)).total - still.potential
    with np.errstate(invalid="ignore"):
        speed = np.sqrt(surplus / still.kinetic) * np.where(states[:, SPIN] < 0, -1.0, 1.0)
    is_known = np.isfinite(speed)
    growth = np.full(len(states), np.nan)
    upright[:, SPIN] *= speed
    slopes = runs.slopes(upright[is_known, None], which[is_known])[:, 0]
    lateral = slopes[:, LATERAL][:, :, LATERAL]
    growth[is_known] = np.linalg.eigvals(lateral).real.max(axis=1)
    return speed, growth


def fates(
    runs: Runs, starts: Array, which: Array, longest: float = LONGEST, *, is_brief: bool = False
) -> Mapping[str, Array]:
    """Compute the quantities of `VARIABLES` for each start.

    Parameters
    ----------
    runs : Runs
    starts : ndarray, shape (motions, 5)
        Initial values in the order of `START`, SI units.
    which : ndarray, shape (motions,)
        Indices of their bicycles.
    longest
        Limit on the time [s], a multiple of five.
    is_brief
        Leave out the condition.

    Returns
    -------
    mapping of ndarray, shape (motions,)
    """
    return _Course(runs, starts, which).run(longest, is_brief=is_brief)


class _Course:
    """Many motions while they are integrated, with the quantities found so far."""

    def __init__(self, runs: Runs, starts: Array, which: Array) -> None:
        self.runs, self.which = runs, which
        self.states = runs.states(starts, which)
        self.speed, self.growth = _straight(runs, self.states, which)
        count = len(starts)
        self.found: dict[str, Array] = {
            name: np.zeros(count, np.int8) if v.flags else np.full(count, np.nan)
            for name, v in VARIABLES.items()
        }
        for name in ("largest_lean", "largest_steer", "fate_time"):
            self.found[name][:] = 0.0
        self.steps = np.abs(starts[:, -1])
        self.before = np.full((count, 1, STATE_SIZE), np.nan)
        self.recent = np.full((count, _WINDOWS_OF_WEAVE * WINDOW, 2), np.nan)
        self.left = np.flatnonzero(np.isfinite(self.states).all(axis=1))

    def run(self, longest: float, *, is_brief: bool) -> Mapping[str, Array]:
        first: list[Array] = []
        for window in range(round(longest / _SECONDS_OF_WINDOW)):
            begin = window * _SECONDS_OF_WINDOW
            left = self.left
            if not len(left):
                break
            part = EARLY_OVERSAMPLING if begin < SECONDS else 1
            samples, ends, self.steps[left] = self.runs.follow(
                self.states[left], self.which[left], self.steps[left],
                spacing=SPACING / part, count=WINDOW * part,
            )  # fmt: skip
            if begin < SECONDS and not is_brief:
                whole = np.full((len(self.states), WINDOW * part + 1, STATE_SIZE), np.nan)
                whole[left] = samples
                first.append(whole if not first else whole[:, 1:])
            self._measure(samples, begin, SPACING / part)
            # The next window needs the sample before its first sample, because a maximum may lie
            # between the two. So keep the sample that lies one spacing of the next window before
            # the end of this window.
            then = EARLY_OVERSAMPLING if begin + _SECONDS_OF_WINDOW < SECONDS else 1
            self.before[left] = samples[:, [-1 - part // then]]
            self._decide(samples, begin, ends)
        self._give_up(longest)
        if first:
            self.found["condition"] = conditions(
                self.runs, np.concatenate(first, axis=1), self.which
            )
        return self.found

    def _measure(self, samples: Array, begin: float, spacing: float) -> None:
        """Update the largest angles, the first lift, and the last time when angles are large."""
        left, found = self.left, self.found
        seen = np.concatenate([self.before[left], samples], axis=1)
        for name, variable in (("largest_lean", ROLL), ("largest_steer", STEER)):
            most = largest(np.abs(seen[:, :, variable]))
            found[name][left] = np.fmax(found[name][left], most)
        angles = np.abs(samples[:, :, (ROLL, STEER)]).max(axis=2)
        is_large = angles > SETTLED
        last = samples.shape[1] - 1 - np.argmax(is_large[:, ::-1], axis=1)
        some = left[is_large.any(axis=1)]
        found["fate_time"][some] = begin + last[is_large.any(axis=1)] * spacing
        self._lift(seen, begin - spacing, spacing)
        self.recent[left, :-WINDOW] = self.recent[left, WINDOW:]
        every = (samples.shape[1] - 1) // WINDOW
        self.recent[left, -WINDOW:] = samples[:, every::every, (ROLL, SPIN)]
        self.states[left] = samples[:, -1]

    def _lift(self, seen: Array, begin: float, spacing: float) -> None:
        """Find the first time when a normal force vanishes, including times between samples."""
        found = self.found
        floor = self.runs.forces(seen, self.which[self.left])
        some = np.flatnonzero(np.isnan(found["lift_time"][self.left]))
        while len(some):
            about, _ = _first_lift(floor[some])
            some, about = some[np.isfinite(about)], about[np.isfinite(about)]
            if not len(some):
                break
            first = np.floor(about).astype(int)
            motions = self.left[some]
            which = self.which[motions]
            near, *_ = self.runs.follow(
                seen[some, first],
                which,
                first.astype(float),
                spacing=spacing / _FINER,
                count=2 * _FINER,
            )
            after, wheel = _first_lift(self.runs.forces(near, which))
            is_so = np.isfinite(after)
            times = begin + spacing * (first + after / _FINER)
            found["lift_time"][motions[is_so]] = times[is_so]
            found["lift_wheel"][motions[is_so]] = wheel[is_so]
            # If the dense samples show no zero, the parabola suggested a zero that does not exist.
            # Then search the later samples.
            for i, j in zip(some[~is_so], first[~is_so], strict=True):
                floor[i, : j + 3] = np.inf
            some = some[~is_so]

    def _decide(self, samples: Array, begin: float, ends: Array) -> None:
        left, found = self.left, self.found
        has_fallen = np.isfinite(ends)
        found["fate"][left[has_fallen]] = FALLS
        found["fate_time"][left[has_fallen]] = begin + ends[has_fallen]
        is_straight = ~has_fallen & self._is_straight(samples)
        found["fate"][left[is_straight]] = UPRIGHT
        found["final_speed"][left[is_straight]] = self.speed[left[is_straight]]
        is_open = ~has_fallen & ~is_straight
        end = begin + _SECONDS_OF_WINDOW
        if end >= _WINDOWS_OF_WEAVE * _SECONDS_OF_WINDOW:
            for i in np.flatnonzero(is_open):
                motion = left[i]
                period = repeats(self.recent[motion, :, 0])
                if period is not None:
                    found["fate"][motion] = CYCLE
                    found["fate_time"][motion] = end - _WINDOWS_OF_WEAVE * _SECONDS_OF_WINDOW
                    self._take_mean(motion, period)
                    is_open[i] = False
        self.left = left[is_open]

    def _is_straight(self, samples: Array) -> NDArray[np.bool_]:
        """True for each motion that is close enough to stable straight running to converge to it.

        An amplitude a obeys about da/dt = growth a + c a^3, where c is some 6 per s for the
        benchmark's weave: up to a = 0.03 sqrt(-growth) the second term is a hundredth of the first.
        """
        growth = self.growth[self.left]
        with np.errstate(invalid="ignore"):
            small = np.minimum(_FLAT * np.sqrt(-growth), SETTLED)
        largest = np.abs(samples[:, :, LATERAL]).max(axis=(1, 2))
        found: NDArray[np.bool_] = largest <= small
        return found

    def _give_up(self, longest: float) -> None:
        """End the motions whose fate is still open, and mark motions that lifted a wheel."""
        found = self.found
        for motion in self.left:
            found["fate_time"][motion] = longest
            peaks = _peaks(self.recent[motion, :, 0])[1]
            turns = np.sign(np.diff(peaks))
            if len(peaks) > _MOST_PEAKS and not (turns == turns[0]).all():
                found["fate"][motion] = WEAVES
                self._take_mean(motion, slice(None))
        has_lifted = np.isfinite(found["lift_time"])
        comes_to = np.isin(found["fate"], (UPRIGHT, CYCLE, WEAVES))
        found["fate"][has_lifted & comes_to] = LIFTS
        is_unknown = ~np.isfinite(self.states).all(axis=1) & (found["fate"] == UNDECIDED)
        for name in ("largest_lean", "largest_steer", "fate_time"):
            found[name][is_unknown] = np.nan

    def _take_mean(self, motion: Any, period: slice) -> None:
        length = np.broadcast_to(self.runs.equations(self.which).k.length, self.which.shape)
        speed = self.recent[motion, period, 1].mean() * length[motion]
        self.found["final_speed"][motion] = speed


def repeats(lean: Array) -> slice | None:
    """Return a slice of whole periods, if a weave repeats itself; None if it does not.

    Parameters
    ----------
    lean : ndarray, shape (samples,)
        Lean of a motion [rad].
    """
    if not lean.min() < 0 < lean.max():
        return None
    places, peaks = _peaks(lean)
    for every in range(1, _MOST_PEAKS + 1):
        # Maxima of the lean to the left and to the right alternate, so a period contains an even
        # number of them.
        period = every if every % 2 == 0 else 2 * every
        if len(peaks) <= max(2 * every, period):
            break
        if max(np.ptp(peaks[i::every]) for i in range(every)) <= _REPEATS * peaks.max():
            last = (len(peaks) - 1) // period * period
            return slice(places[0], places[last])
    return None


def _peaks(lean: Array) -> tuple[Any, Array]:
    """Return the places and the magnitudes of the maxima of the lean to either side."""
    value, _ = tops(np.abs(lean)[None])
    places = np.flatnonzero(np.isfinite(value[0]))
    return places + 1, value[0, places]


def _first_lift(floor: Array) -> tuple[Array, Array]:
    """Return where a normal force first passes below zero, and the wheel on which it acts.

    `floor` has the shape (motions, samples, 2).
    """
    rear, front = first_negative(floor[:, :, 0]), first_negative(floor[:, :, 1])
    is_front = np.isnan(rear) | (front < rear)
    return np.where(is_front, front, rear), np.where(is_front, FRONT, REAR)
