"""Every quantity of a user's own states, in binary64; of known ones see `proof.instants`."""

from collections.abc import Mapping
from fractions import Fraction

import flint
import numpy as np

from heyoka_bike.bicycle.columns import COORDINATES, LEVELS, WHERE
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.instant import Instant, quantities
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.proof.instants import BITS, LinearBicycle


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
        True if those of the linear bicycle are wanted.

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
            linear = LinearBicycle(bicycle)
            by_speed = {v: linear.at(Fraction(v)) for v in np.unique(speed)}
        for c in LEVELS[-1].columns:
            found[c.name] = np.array([float(by_speed[v][c.name].mid()) for v in speed])
    return {name: np.broadcast_to(np.asarray(x, float), speed.shape) for name, x in found.items()}


def binary64_states(bicycle: Bicycle, given: Mapping[str, Array]) -> tuple[Equations, list[Number]]:
    """The equations for arrays, and the variables of states as `Instant` takes them."""
    equations = Equations.binary64(bicycle)
    roll, steer, roll_rate, steer_rate, speed = (given[key] for key in COORDINATES)
    pitch = pitch_on_the_floor(equations.k, roll, 0 * roll, steer)
    where = [given.get(name, 0 * roll) for name in WHERE]
    return equations, [
        roll, pitch, steer, roll_rate, steer_rate, speed / equations.k.length, *where
    ]  # fmt: skip
