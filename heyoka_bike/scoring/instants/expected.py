"""What every quantity of a state is: correctly rounded in the known states, else in binary64."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import nan

import flint
import numpy as np

from heyoka_bike.bicycle.equations.configuration import INTEGRALS
from heyoka_bike.bicycle.equations.initial import initial_state, pitch_on_the_floor
from heyoka_bike.bicycle.equations.instant import Instant, linear_quantities, quantities
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import NonnegativeRoots
from heyoka_bike.bicycle.instant_columns import COORDINATES, LEVELS, UNITS, WHERE
from heyoka_bike.bicycle.parameters import START, Bicycle, Maneuver
from heyoka_bike.bicycle.stability.linear import matrices
from heyoka_bike.errors import UndecidedError
from heyoka_bike.numbers.arithmetic import Number, exact_ball
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.rounding import Enclosure

BITS = 256
"""Of the balls. A value of less than 2^-_NOTHING that is not known to differ from zero is zero."""

_NOTHING = 160
_KEYS = dict(zip(START, ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed"),
                 strict=True))  # fmt: skip


def of_known(bicycle: Bicycle, states: Sequence[Maneuver]) -> dict[str, Array]:
    """Coordinates and quantities of states by name, each the binary64 nearest to the exact value.

    One that is not defined is NaN: a multiple eigenvalue, the friction demand without a force.

    Raises
    ------
    UndecidedError
        Balls that do not decide a rounding.
    InputError
        No pitch puts both wheels on the floor.
    """
    return dict(_of_known(tuple(bicycle.values.items()), tuple(states)))


@lru_cache(8)
def _of_known(
    parameters: tuple[tuple[str, Exact], ...], states: tuple[Maneuver, ...]
) -> Mapping[str, Array]:
    bicycle = Bicycle("", dict(parameters))
    balls = NonnegativeRoots(BITS)
    equations = Equations.of(bicycle, balls)
    rows = []
    with balls.precision():
        linear = _Linear(bicycle)
        for state in states:
            start = initial_state(equations, state)
            instant = Instant.of(equations, [*start, *[balls.number(0)] * len(INTEGRALS)])
            given = {_KEYS[key]: balls.number(getattr(state, key)) for key in START}
            found = {**given, **dict.fromkeys(WHERE, balls.number(0)), **quantities(instant)}
            found |= linear.at(state.speed.fraction())
            rows.append([_nearest(x, f"{state.name}: {name}") for name, x in found.items()])
    return dict(zip(found, np.array(rows).T, strict=True)) if rows else {}


def of_own(
    bicycle: Bicycle, given: Mapping[str, Array], *, is_linear: bool = True
) -> dict[str, Array]:
    """Quantities of states by name, in binary64.

    Parameters
    ----------
    bicycle
        Any parameters, sensible or not.
    given
        `COORDINATES`, and some of `WHERE` [SI].
    is_linear
        Whether those of the linear bicycle are wanted.

    Returns
    -------
    dict of str to ndarray
        With ``height``, of the front wheel above the floor [m]: zero but for rounding where there
        is a pitch that puts both wheels on the floor.
    """
    with np.errstate(all="ignore"):
        equations, state = binary64_states(bicycle, given)
        found = quantities(Instant.of(equations, state))
        found["height"] = front_contact_height(equations.k, equations.a, *state[:3])
    speed = given["forward_speed"]
    if is_linear:
        with flint.ctx.workprec(BITS):
            linear = _Linear(bicycle)
            by_speed = {v: linear.at(Fraction(v)) for v in np.unique(speed)}
        for c in LEVELS[-1].columns:
            found[c.name] = np.array([float(by_speed[v][c.name].mid()) for v in speed])
    return {name: np.broadcast_to(np.asarray(x, float), speed.shape) for name, x in found.items()}


def as_csv(bicycle: Bicycle, states: Sequence[Maneuver]) -> bytes:
    """The table of `of_known`, each value with the digits of its binary64."""
    table = of_known(bicycle, states)
    heading = ("state", *(f"{name} [{UNITS[name]}]" for name in table))
    rows = zip(*table.values(), strict=True)
    lines = [
        (str(number), *(repr(float(x)) for x in row)) for number, row in enumerate(rows, start=1)
    ]
    return "".join(",".join(row) + "\n" for row in (heading, *lines)).encode()


def binary64_states(bicycle: Bicycle, given: Mapping[str, Array]) -> tuple[Equations, list[Number]]:
    """The equations for arrays, and the variables of states as `Instant` takes them."""
    equations = Equations.binary64(bicycle)
    roll, steer, roll_rate, steer_rate, speed = (given[key] for key in COORDINATES)
    pitch = pitch_on_the_floor(equations.k, roll, 0 * roll, steer)
    where = [given.get(name, 0 * roll) for name in WHERE]
    return equations, [
        roll, pitch, steer, roll_rate, steer_rate, speed / equations.k.length, *where
    ]  # fmt: skip


class _Linear:
    """The linear bicycle in balls, which are of the precision that flint has now."""

    def __init__(self, bicycle: Bicycle) -> None:
        self._matrices = matrices(bicycle, NonnegativeRoots(BITS))
        self._g = exact_ball(bicycle["g"].rational)
        self._at: dict[Fraction, dict[str, flint.arb]] = {}

    def at(self, speed: Fraction) -> dict[str, flint.arb]:
        """Quantities of the last level at a speed [m/s]."""
        if speed not in self._at:
            self._at[speed] = linear_quantities(self._matrices, self._g, speed)
        return self._at[speed]


def _nearest(x: Number, name: str) -> float:
    if isinstance(x, int):
        return float(x)
    if not x.is_finite():
        return nan
    enclosed = Enclosure.of(x)
    size = max(-enclosed.low, enclosed.high)
    if enclosed.low <= 0 <= enclosed.high and size << _NOTHING <= 1 << enclosed.grid:
        return 0.0
    nearest = enclosed.binary64()
    if nearest is None:
        raise UndecidedError(f"{name}: {BITS} bits do not decide its nearest binary64")
    return nearest + 0.0
