"""The equations of a bicycle as JavaScript, for motions that a page computes.

They are written by evaluating the model itself, see `numbers.straight_line`; ``motion.js`` follows
a motion with them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from heyoka_bike.bicycle.equations.bodies import bodies_of
from heyoka_bike.bicycle.equations.constants import constants_of
from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, lateral_condition
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    INTEGRALS,
    Configuration,
    track_speeds,
    whole_rates,
)
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.straight_line import Language, StraightLine

MOTION_SCRIPT = Path(__file__).with_name("motion.js").read_text(encoding="utf-8")
"""Follows a motion by `motion_source`."""

ERROR = 1e-8
"""The largest error of angles [rad], rates [rad/s] and speed [m/s] within 10 s."""

STATE = ("roll", "pitch", "steer", "roll_rate", "steer_rate", "spin", "yaw", *INTEGRALS, "track")
"""The integrated variables; `track` is the length of the rear track [m]."""

OBSERVED = (
    "front_x", "front_y", "speed", "potential", "kinetic", "rear_normal", "front_normal",
)  # fmt: skip
"""The derived quantities: front contact [m], speed [m/s], energies [J], normal forces [N]."""

DIVISORS = 3
"""The number of divisors of the equations that may vanish; a motion ends there."""

_JAVASCRIPT = Language(
    opening="const {name} = ({arguments}) => {{",
    closing="}};",
    statement="const {name} = {value}",
    output="{result}",
)

_Formulas = Callable[[Equations, Sequence[Number]], Sequence[Number]]


def motion_source(bicycle: Bicycle, free: Sequence[str] = ()) -> str:
    """Functions and names for ``motion.js``.

    Parameters
    ----------
    bicycle : Bicycle
    free
        Symbols of parameters that ``P`` has, in place of the bicycle's.

    ``rates(y, f)`` puts the time derivatives of the state y into f, and after them the `DIVISORS`;
    ``observe(y, f)`` what is `OBSERVED`; ``floorGap([roll, pitch, steer], f)`` the height of the
    front wheel [m]. ``spinOf([speed], f)`` is the state's ``spin``.
    """

    def function(name: str, size: int, formulas: _Formulas) -> str:
        return _JAVASCRIPT.function(
            name, {"y": size}, "f", lambda code, y: formulas(_equations(bicycle, free, code), y)
        )

    parts = [
        "const { sin, cos, sqrt, atan2 } = Math;",
        f"const STATE = {json.dumps(STATE)}, OBSERVED = {json.dumps(OBSERVED)};",
        f"const DIVISORS = {DIVISORS}, P = {json.dumps({x: float(bicycle[x]) for x in free})};",
        function("rates", len(STATE), _rates),
        function("observe", len(STATE), _observed),
        function("floorGap", 3, _floor_gap),
        function("spinOf", 1, _spin),
    ]
    return "\n".join(parts) + "\n"


def _equations(bicycle: Bicycle, free: Sequence[str], code: StraightLine) -> Equations:
    """With constants rounded once, or written as formulas of what is free."""
    if not free:
        return Equations.binary64(bicycle).convert(code.literal, code)
    p: dict[str, Number] = {symbol: value.rational for symbol, value in bicycle.values.items()}
    p |= {symbol: code.variable(f"P.{symbol}") for symbol in free}
    tilt = p["lam"] if "lam" in free else code.number(bicycle["lam"])
    k = constants_of(p, tilt, code, is_vertical=False)
    return Equations(bicycle, k, bodies_of(p, tilt, code), code)


def _rates(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    o, u = equations.unfold(y)
    rear, _ = track_speeds(equations.k, u)
    _, c1, c3 = lateral_condition(o)
    divisors = (o.kappa, o.den, c3 * o.cb - c1 * o.sb)
    return [*whole_rates(equations, y), rear, *divisors]


def _observed(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    x_y = Configuration.of(equations, y).places()["front_contact"][:2]
    energies, contacts = equations.energies(y), forces(equations, y)
    _, u = equations.unfold(y)
    return [
        *x_y, equations.k.length * u.v, energies.potential, energies.kinetic,
        contacts.rear.normal, contacts.front.normal,
    ]  # fmt: skip


def _floor_gap(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    return [front_contact_height(equations.k, equations.a, *y)]


def _spin(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    return [y[0] / equations.k.length]
