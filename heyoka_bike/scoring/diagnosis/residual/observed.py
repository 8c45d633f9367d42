"""The motion that a file shows: states, their derivatives, and the uncertainty of these.

Near each row the motion is approximated by a polynomial through the rows around it. The derivatives
are averaged over windows, which are smooth bumps that overlap by half. The mean of a derivative
over a bump is much more accurate than the derivative at a row, and its accuracy hardly depends on
the spacing of the rows if this resolves the motion.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.following import following, in_binary64
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR, Part, spread
from heyoka_bike.scoring.definitions import Understanding
from heyoka_bike.scoring.diagnosis.programs.integrators import RK4
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.rows.local_polynomials import local_polynomials
from heyoka_bike.scoring.rows.rates import LATERAL_ANGLES
from heyoka_bike.scoring.units import factor

STATE_KEYS = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""Keys of the columns that the equations of motion need.

If the speed is missing, it follows from the kinetic energy, or from the others by the exact
equation of the speed, which is then not compared. Missing rates are computed as slopes of their
angles.
"""

# Rounding error of a slope by central differences of order 10: this many times the rounding error
# of the column, divided by the distance of the rows.
_IN_SLOPE = 1.23

_DEGREE_OF_WINDOW, _LOWER_DEGREE = 9, 7
_MOST_ROWS_OF_WINDOWS = 1001
_FEWEST_ROWS_OF_WINDOWS = 12
# Minimum half width of a window: in seconds, and in distances of the rows.
_HALF_WIDTH, _IN_ROWS = 0.15, 4.0
_MOST_ROUNDS = 30
# A bicycle that leans more than this does not come upright again [rad].
_LARGEST_LEAN = 1.2
# All angles, rates and speeds are smaller than this, unless the motion has become unstable [SI].
_LARGEST_CONDITION = 1e6
# Rows from which the exact equations are integrated back to t = 0, and number of integration steps.
_BEGINNING, _STEPS_BACK = slice(1, 5), 20
CONVERGED = 1e-15
"""Change at which the conversion of columns to the default definitions stops [SI]."""
# The conversion of columns to the default definitions has failed if its last change exceeds this
# value [SI].
_PART_LOST = 1e-10


@dataclass(frozen=True, eq=False, slots=True)
class Observed:
    """The motion that one maneuver of a file shows.

    Attributes
    ----------
    number
        Number of the maneuver.
    time : ndarray, shape (n,)
        [s]
    state : mapping of str to ndarray, shape (n,)
        Columns of `STATE_KEYS` and the yaw, in SI and the default definitions.
    windows : ndarray, shape (w, n)
        Weights of the rows in the averages; the weights of each average add up to 1.
    accelerations : ndarray, shape (3, w), or (2, w) without a speed
        Averages of the derivatives of roll rate, steer rate and speed.
    uncertain : ndarray of the same shape
        Uncertainty of the accelerations, as far as the file shows it.
    kinematic : ndarray, shape (2, w)
        Averages of the derivatives of roll and steer, minus their rates.
    kinematic_uncertain : ndarray, shape (2, w)
        Uncertainty of `kinematic`.
    definitions : mapping of str to str
        Names of the columns of `STATE_KEYS`, by the interpretation of the file.
    is_begun
        True if the rows begin at the start of the maneuver.
    has_beginning
        True if they do and the file contains both rates.
    has_state
        True if the file contains all columns of `STATE_KEYS`.
    determines_state
        True if it contains them, or the others follow from it: the speed from the kinetic energy,
        or a single rate as the slope of its angle. The other rate shows whether an integrator's
        error makes rates and slopes differ.
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
    determines_state: bool

    def without_speed(self) -> Observed:
        """Return a copy without the acceleration of the speed, for files without the speed."""
        return replace(
            self,
            accelerations=self.accelerations[:2],
            uncertain=self.uncertain[:2],
            has_beginning=False,
        )

    def inconsistency(self) -> float:
        """Return the largest of the relative differences of rates from slopes of their angles."""
        return max(self.inconsistencies().values())

    def inconsistencies(self) -> dict[str, float]:
        """Return for each rate its relative difference from the slope of its angle."""
        rates = np.array([self.windows @ self.state[key] for key in LATERAL_ANGLES])
        least = float(np.finfo(np.float64).tiny)
        size = np.sqrt(np.mean(rates**2, axis=1)) + least
        off = np.sqrt(np.mean(self.kinematic**2, axis=1))
        known = np.median(self.kinematic_uncertain, axis=1)
        found = np.maximum(off, known) / size
        return dict(zip(LATERAL_ANGLES, found.tolist(), strict=True))


def upright(part: Part, understood: Mapping[str, Understanding]) -> Part:
    """Return only the rows before the bicycle lies down; later rows do not show its motion."""
    if "roll_angle" not in part.values or "roll_angle" not in understood:
        return part
    is_up = np.abs(in_si(part, understood, "roll_angle")) <= _LARGEST_LEAN
    height = part.values.get("potential_energy", np.zeros_like(part.time))
    lies = ~is_up & (height < MEANINGLESS_ERROR * height[0])
    # If there is no potential energy, find the row after which the lean remains large. An angle in
    # degrees that is read as radians becomes small again, so it is not mistaken for a fall.
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
    """Determine the motion of a part; None if its columns or rows do not show it.

    Columns with other definitions are converted to the default ones with the equations and
    parameters of a bicycle (by default that of the reference), until changes are below `converged`
    [SI].
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
    has_speed, there = "forward_speed" in columns, {*part.values} - {"kinetic_energy"}
    if not has_speed:
        # An energy that gives another initial speed may be computed wrongly, so it is not used.
        moving = _speed_by_energy(part, understood, equations, time, state)
        if moving is not None and abs(moving[0] - speed) <= TOLERANCE * speed:
            state["forward_speed"] = moving
            there.add("forward_speed")
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
        # Slopes of angles are less accurate in the first rows than elsewhere, so the rates must be
        # in the file.
        has_beginning=is_begun and LATERAL_ANGLES.keys() <= part.values.keys(),
        has_state={*STATE_KEYS} <= part.values.keys(),
        determines_state=not missing_for_equations(there),
    )
    return found if has_speed else found.without_speed()


def _speed_by_energy(
    part: Part, understood: Mapping[str, Understanding], equations: Equations, time: Array,
    state: Mapping[str, Array],
) -> Array | None:  # fmt: skip
    """Compute the speed of a motion from its kinetic energy; None without this column.

    The kinetic energy is a quadratic polynomial of the spin.
    """
    key = "kinetic_energy"
    if key not in part.values or key not in understood:
        return None
    energy = in_si(part, understood, key)[np.searchsorted(part.time, time)]
    y = state_vector(equations, state.__getitem__)
    at = [equations.energies([*y[:5], y[5] * x]).kinetic for x in (0, 1, 2)]
    square, linear = (at[2] - 2 * at[1] + at[0]) / 2, (4 * at[1] - at[2] - 3 * at[0]) / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(linear**2 - 4 * square * (at[0] - energy))
        found: Array = state["forward_speed"] * (root - linear) / (2 * square)
    return found if np.isfinite(found).all() else None


def missing_for_equations(keys: Collection[str]) -> tuple[str, ...]:
    """Return the columns that a file with these keys lacks for a check of the equations.

    The speed follows from the kinetic energy, and a single missing rate is the slope of its angle.
    """
    known = {*keys, "forward_speed"} if "kinetic_energy" in keys else keys
    missing = tuple(key for key in STATE_KEYS if key not in known)
    is_computed = len(missing) == 1 and missing[0] in LATERAL_ANGLES
    return () if is_computed else missing


def _rows_that_move(
    part: Part, understood: Mapping[str, Understanding]
) -> tuple[Array, dict[str, Array], dict[str, str]] | None:
    """Return times, columns of `STATE_KEYS` [SI] and their definitions.

    None if a column does not change, or there are too few rows or columns.
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


def start_shown(
    m: Observed, equations: Equations, rates: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Return the columns of `STATE_KEYS` at t = 0 and their scatter, shape (5,) each.

    They are found by integrating the equations back from the rows after the first, by the
    Runge-Kutta method. The first row is not used: it may contain the given initial values even if
    the motion started from others.

    Parameters
    ----------
    m : Observed
    equations : Equations
        Equations with the lengths of the program.
    rates : callable
        Time derivative of the state of the regular form, with the yaw.
    """
    time, state = m.time[_BEGINNING], {k: x[_BEGINNING] for k, x in m.state.items()}
    y, h = np.array(state_vector(equations, state.__getitem__)), -time / _STEPS_BACK
    for _ in range(_STEPS_BACK):
        y = RK4(rates, y, h)
    y[5] *= equations.k.length
    found = np.delete(y, (1, 6), axis=0)
    return np.median(found, axis=1), np.ptp(found, axis=1)


def in_si(part: Part, understood: Mapping[str, Understanding], key: str) -> Array:
    """Return a column in SI, with the sign and the zero of the definition."""
    return understood[key].in_si(part.values[key])


def _digits(part: Part, understood: Mapping[str, Understanding], key: str) -> float:
    """Return the standard deviation of the rounding to the digits written [SI]."""
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
    """Return the weights of the rows in windows over the run; None if the run is too short."""
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
    """Return the averages of the columns' derivatives over windows, and their uncertainty.

    The uncertainty is the difference from polynomials of lower degree, combined with the effect of
    random rounding to the digits written.
    """
    middle = (rows - np.mean(rows, axis=1, keepdims=True)).T
    slope, lower = (
        (windows @ local_polynomials(time, middle, degree)[:, 1]).T
        for degree in (_DEGREE_OF_WINDOW, _LOWER_DEGREE)
    )
    # By integration by parts, the mean of a derivative weighted by the bump is the mean of the
    # column weighted by minus the slope of the bump.
    per_row = np.gradient(windows, time, axis=1)
    rounding = np.multiply.outer(digits, np.sqrt(np.sum(per_row**2, axis=1)))
    return slope, np.hypot(slope - lower, rounding)


def integral(time: Array, x: Array) -> Array:
    """Integrate a column from the first row to each row."""
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
    """Convert columns to the default definitions, and add the yaw; NaN if this does not converge.

    Definitions differ little, so the state is corrected repeatedly by the difference between the
    written columns and those computed from the state. A missing speed begins at the given initial
    speed.
    """
    state = {"forward_speed": np.full_like(time, speed), **columns, "yaw": np.zeros_like(time)}
    is_default = all(names.get(k) == k for k in STATE_KEYS)
    for _ in range(_MOST_ROUNDS):
        with np.errstate(all="ignore"):
            y = state_vector(equations, state.__getitem__)
            own = equations.columns(y)
            found = {**own, **following(own, parameters)}
        yaw = integral(time, np.nan_to_num(found["yaw_rate"]))
        if is_default:
            return {**state, "yaw": yaw}
        off = {k: columns[k] - found[names[k]] for k in columns} | {"yaw": yaw - state["yaw"]}
        if "forward_speed" not in columns:
            with np.errstate(all="ignore"):
                rate = np.nan_to_num(equations.rates(y[:6])[5] * equations.k.length)
            off["forward_speed"] = speed + integral(time, rate) - state["forward_speed"]
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
    """Return the state of the reduced equations from columns, with both wheels on the floor."""
    roll, steer, roll_rate, steer_rate, speed = (column(key) for key in STATE_KEYS)
    if pitch is None:
        pitch = pitch_on_the_floor(equations.k, roll, np.zeros_like(roll), steer)
    spin = speed / equations.k.length
    return [roll, pitch, steer, roll_rate, steer_rate, spin, column("yaw")]
