"""The motion that a file shows: its states, their derivatives, and how well these are known.

Near each row the file is a polynomial through the rows around it. What is said of it is said of
averages over windows, smooth bumps that overlap by half: the mean of a derivative over a bump is
known far better than the derivative at a row, and as well at any spacing that resolves the motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.following import following, in_binary64
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR, Part, spread
from heyoka_bike.scoring.definitions import Understanding
from heyoka_bike.scoring.diagnosis.programs.integrators import RK4
from heyoka_bike.scoring.rows.local_polynomials import local_polynomials
from heyoka_bike.scoring.rows.rates import LATERAL_ANGLES
from heyoka_bike.scoring.units import factor

STATE_KEYS = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""Keys of the columns that the equations of motion need.

The speed may be missing: it then follows from the others by the right equation of the speed, which
is not compared. Rates may be missing: they then are the slopes of their angles.
"""

# Of the last digit in a slope, times the distance of the rows: central differences of order 10.
_IN_SLOPE = 1.23

_DEGREE_OF_WINDOW, _LOWER_DEGREE = 9, 7
_MOST_ROWS_OF_WINDOWS = 1001
_FEWEST_ROWS_OF_WINDOWS = 12
# Half the width of a window: [s], and in rows.
_HALF_WIDTH, _IN_ROWS = 0.15, 4.0
_MOST_ROUNDS = 30
# A lean from which there is no way back [rad].
_LARGEST_LEAN = 1.2
# Nothing of a bicycle is so large, but what has blown up [SI].
_LARGEST_CONDITION = 1e6
# Rows of the beginning, from which the right equations lead back to t = 0, in so many steps.
_BEGINNING, _STEPS_BACK = slice(1, 5), 20
CONVERGED = 1e-15
"""To how much columns of other definitions are taken back [SI]."""
# What is still off after all rounds is lost.
_PART_LOST = 1e-10


@dataclass(frozen=True, eq=False, slots=True)
class Observed:
    """One maneuver of a file.

    Attributes
    ----------
    number
        Of the maneuver.
    time : ndarray, shape (n,)
        [s]
    state : mapping of str to ndarray, shape (n,)
        Columns of `STATE_KEYS` and the yaw, SI, in the default definitions.
    windows : ndarray, shape (w, n)
        Thresholds of rows in averages, each of sum one.
    accelerations : ndarray, shape (3, w), or (2, w) without a speed
        Averages of the derivatives of roll rate, steer rate and speed.
    uncertain : ndarray of the same shape
        By how much they are wrong, as far as the file shows it.
    kinematic : ndarray, shape (2, w)
        Averages of the derivative of roll and steer, less their rates.
    kinematic_uncertain : ndarray, shape (2, w)
    definitions : mapping of str to str
        Names of the columns of `STATE_KEYS`, as they were understood.
    is_begun
        True if its first rows are those of a start.
    has_beginning
        True if these have the rates; otherwise slopes tell them, and the speed is given.
    has_state
        True if the file has all columns of `STATE_KEYS`.
    """

    number: int
    time: Array
    state: Mapping[str, Array]
    windows: Array
    accelerations: Array
    uncertain: Array
    kinematic: Array
    kinematic_uncertain: Array
    definitions: Mapping[str, str]
    is_begun: bool
    has_beginning: bool
    has_state: bool

    def without_speed(self) -> Observed:
        """Return it without what is known of the speed only where that is in the file."""
        return replace(
            self,
            accelerations=self.accelerations[:2],
            uncertain=self.uncertain[:2],
            has_beginning=False,
        )

    def inconsistency(self) -> float:
        """Return the distance of the rates from the slopes of the angles, in parts of them."""
        rates = np.array([self.windows @ self.state[key] for key in ("roll_rate", "steer_rate")])
        least = float(np.finfo(np.float64).tiny)
        size = np.sqrt(np.mean(rates**2, axis=1)) + least
        off = np.sqrt(np.mean(self.kinematic**2, axis=1))
        known = np.median(self.kinematic_uncertain, axis=1)
        return float(np.max(np.maximum(off, known) / size))


def upright(part: Part, understood: Mapping[str, Understanding]) -> Part:
    """The rows before the bicycle lies down: what follows is another motion, or has blown up."""
    if "roll_angle" not in part.values or "roll_angle" not in understood:
        return part
    is_up = np.abs(in_si(part, understood, "roll_angle")) <= _LARGEST_LEAN
    height = part.values.get("potential_energy", np.zeros_like(part.time))
    lies = ~is_up & (height < MEANINGLESS_ERROR * height[0])
    # Without a height: angles in degrees come back.
    row = int(np.argmax(lies)) if lies.any() else len(is_up) - int(np.argmax(is_up[::-1]))
    if row == len(is_up) or row < _FEWEST_ROWS_OF_WINDOWS:
        return part
    return part.at(slice(row))


def observe(
    part: Part,
    understood: Mapping[str, Understanding],
    equations: Equations,
    parameters: Mapping[str, float] | None = None,
    converged: float = CONVERGED,
) -> Observed | None:
    """The motion of a part; None where the columns or rows do not show it.

    Columns of other definitions are taken back by the equations and parameters of a bicycle, that
    of the reference unless it is given, and as far as is asked for [SI].
    """
    written = _rows_that_move(part, understood)
    if written is None:
        return None
    time, columns, names = written
    parameters = parameters or in_binary64(part.reference.parameters)
    speed = float(part.reference.approximate(time[:1], ["forward_speed"])["forward_speed"][0])
    state = _default_definitions(columns, names, time, equations, parameters, speed, converged)
    windows = _windows(time)
    if windows is None or not all(np.isfinite(x).all() for x in state.values()):
        return None
    digits = np.array([_digits(part, understood, k) for k in columns])
    slopes, off = _mean_slopes(time, np.array([state[k] for k in columns]), windows, digits)
    rates = np.array([windows @ state[k] for k in ("roll_rate", "steer_rate")])
    is_begun = bool(time[0] <= 2 * (time[1] - time[0]))
    found = Observed(
        number=part.number,
        time=time,
        state=state,
        windows=windows,
        accelerations=slopes[2:],
        uncertain=off[2:],
        kinematic=slopes[:2] - rates,
        kinematic_uncertain=off[:2],
        definitions={k: name for k, name in names.items() if k in part.values},
        is_begun=is_begun,
        # Slopes tell less of the first rows.
        has_beginning=is_begun and LATERAL_ANGLES.keys() <= part.values.keys(),
        has_state={*STATE_KEYS} <= part.values.keys(),
    )
    return found if "forward_speed" in columns else found.without_speed()


def _rows_that_move(
    part: Part, understood: Mapping[str, Understanding]
) -> tuple[Array, dict[str, Array], dict[str, str]] | None:
    """Return times, columns of `STATE_KEYS` [SI] and their definitions.

    None where they are no motion, or too few.
    """
    keys = [k for k in STATE_KEYS if k in part.values and k in understood]
    columns = {k: in_si(part, understood, k) for k in keys}
    names = {k: understood[k].assumed().name for k in keys}
    if not {"roll_angle", "steer_angle"} <= columns.keys():
        return None
    rows = np.flatnonzero(np.all([np.isfinite(x) for x in columns.values()], axis=0))
    if len(rows) < _FEWEST_ROWS_OF_WINDOWS:
        return None
    rows = rows[spread(len(rows), _MOST_ROWS_OF_WINDOWS)]
    time, columns = part.time[rows], {k: x[rows] for k, x in columns.items()}
    if not np.all(np.diff(time) > 0.0):
        return None
    for rate, angle in LATERAL_ANGLES.items():
        if rate not in columns and names[angle] != angle:
            return None
        if rate not in columns:
            columns[rate] = local_polynomials(time, columns[angle], _DEGREE_OF_WINDOW)[:, 1]
            names[rate] = rate
    columns = {k: columns[k] for k in STATE_KEYS if k in columns}
    moves = all(np.ptp(x) for key, x in columns.items() if key != "forward_speed")
    is_bounded = np.max(np.abs([*columns.values()])) < _LARGEST_CONDITION
    return (time, columns, names) if moves and is_bounded else None


def start_shown(m: Observed, equations: Equations) -> tuple[Array, Array]:
    """Return the columns of `STATE_KEYS` at t = 0, and how much rows disagree; shape (5,) each.

    To these the right equations lead back from the rows after the first, by Runge and Kutta's
    method: that may be as given, whatever was computed.
    """
    time, state = m.time[_BEGINNING], {k: x[_BEGINNING] for k, x in m.state.items()}

    def slope(y: Array) -> Array:
        return np.array(equations.rates(list(y)))

    y, h = np.array(state_vector(equations, state.__getitem__)[:6]), -time / _STEPS_BACK
    for _ in range(_STEPS_BACK):
        y = RK4(slope, y, h)
    y[5] *= equations.k.length
    found = np.delete(y, 1, axis=0)
    return np.median(found, axis=1), np.ptp(found, axis=1)


def in_si(part: Part, understood: Mapping[str, Understanding], key: str) -> Array:
    """Return a column in SI, with the sign and the zero of the definition."""
    return understood[key].in_si(part.values[key])


def _digits(part: Part, understood: Mapping[str, Understanding], key: str) -> float:
    """Standard deviation of the last digit written [SI]."""
    if key not in part.values:
        return (
            _IN_SLOPE
            * _digits(part, understood, LATERAL_ANGLES[key])
            / float(np.median(np.diff(part.time)))
        )
    quantum, values = part.quantum.get(key), part.values[key]
    values = values[np.isfinite(values)]
    unit = factor(understood[key].unit)[0]
    least = float(np.finfo(np.float64).eps) * float(np.max(np.abs(values), initial=0.0))
    if quantum is None:
        return least * unit
    return max(float(np.sqrt(np.mean(quantum.at(values) ** 2) / 12)), least) * unit


def _windows(time: Array) -> Array | None:
    """Bumps over the run; None where there is no room for some."""
    spacing = float(np.max(np.diff(time))) if len(time) > 1 else np.inf
    half = max(_HALF_WIDTH, _IN_ROWS * spacing)
    count = int((time[-1] - time[0]) / half) - 1
    if count < 1:
        return None
    centres = np.linspace(time[0] + half, time[-1] - half, count)
    x = (time[None] - centres[:, None]) / half
    bumps = np.where(np.abs(x) < 1.0, (1.0 - np.minimum(x * x, 1.0)) ** 3, 0.0)
    weights = bumps * np.gradient(time)
    found: Array = weights / weights.sum(axis=1, keepdims=True)
    return found


def _mean_slopes(time: Array, rows: Array, windows: Array, digits: Array) -> tuple[Array, Array]:
    """Averages of derivatives of columns, and how far those of polynomials of lower degree are off.

    What digits leave of an average is that of random ones.
    """
    middle = (rows - np.mean(rows, axis=1, keepdims=True)).T
    slope, lower = (
        (windows @ local_polynomials(time, middle, degree)[:, 1]).T
        for degree in (_DEGREE_OF_WINDOW, _LOWER_DEGREE)
    )
    # The mean of a derivative is minus that over the slope of the bump.
    per_row = np.gradient(windows, time, axis=1)
    rounding = np.multiply.outer(digits, np.sqrt(np.sum(per_row**2, axis=1)))
    return slope, np.hypot(slope - lower, rounding)


def _integral(time: Array, x: Array) -> Array:
    """Return the integral from the first row to each row."""
    powers = np.arange(1, _LOWER_DEGREE + 2)
    local = local_polynomials(time, x, _LOWER_DEGREE)[:-1] / powers
    steps = (local * np.diff(time)[:, None] ** powers).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _default_definitions(
    columns: Mapping[str, Array],
    names: Mapping[str, str],
    time: Array,
    equations: Equations,
    parameters: Mapping[str, float],
    speed: float,
    converged: float,
) -> dict[str, Array]:
    """The columns in the default definitions, and the yaw; NaN if they are not found.

    Definitions are near one another: the motion is that whose columns are those written. A speed
    along a fixed axis tells little of one across it. A speed that is not written begins with the
    right one.
    """
    state = {"forward_speed": np.full_like(time, speed), **columns, "yaw": np.zeros_like(time)}
    is_default = all(names.get(k) == k for k in STATE_KEYS)
    for _ in range(_MOST_ROUNDS):
        with np.errstate(all="ignore"):
            y = state_vector(equations, state.__getitem__)
            own = equations.columns(y)
            found = {**own, **following(own, parameters)}
        yaw = _integral(time, np.nan_to_num(found["yaw_rate"]))
        if is_default:
            return {**state, "yaw": yaw}
        off = {k: columns[k] - found[names[k]] for k in columns} | {"yaw": yaw - state["yaw"]}
        if "forward_speed" not in columns:
            with np.errstate(all="ignore"):
                rate = np.nan_to_num(equations.rates(y[:6])[5] * equations.k.length)
            off["forward_speed"] = speed + _integral(time, rate) - state["forward_speed"]
        apart = float(np.max(np.abs([*off.values()])))
        state |= {k: state[k] + np.nan_to_num(x) for k, x in off.items()}
        if apart < converged:
            break
    else:
        if not apart < _PART_LOST:
            state["yaw"] = np.full_like(time, np.nan)
    return state


def state_vector(
    equations: Equations, column: Callable[[str], Array], pitch: Array | None = None
) -> list[Array]:
    """The state of the regular form from columns by key, with both wheels on the floor."""
    roll, steer, roll_rate, steer_rate, speed = (column(key) for key in STATE_KEYS)
    if pitch is None:
        pitch = pitch_on_the_floor(equations.k, roll, np.zeros_like(roll), steer)
    spin = speed / equations.k.length
    return [roll, pitch, steer, roll_rate, steer_rate, spin, column("yaw")]
