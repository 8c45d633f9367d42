"""Names that a program makes of the parts of a model: the way to a joint, and what is meant of it.

So ``bike.steer.phi`` and ``der(bike.steer.phi)`` of Modelica, ``Roll_Joint.Rz.w`` of Simscape, and
``/jointset/fork/steer_angle/value`` of OpenSim. Only joints are read so: the speed or the energy of
some part is not that of the bicycle.
"""

import re
from collections.abc import Mapping

_JOINTS: Mapping[str, str] = {
    **dict.fromkeys(("roll", "rollangle", "lean", "leanangle"), "roll"),
    **dict.fromkeys(("steer", "steerangle", "steering", "steeringangle"), "steer"),
}
_RATES: Mapping[str, str] = {
    **dict.fromkeys(("rollrate", "leanrate"), "roll"),
    **dict.fromkeys(("steerrate", "steeringrate"), "steer"),
}
_IS_ANGLE = frozenset({"phi", "q", "angle", "value"})
_IS_RATE = frozenset({"w", "qd", "omega", "speed", "rate"})

_STEPS = re.compile(r"[./|]")
_DERIVATIVE = re.compile(r"der\((.+)\)")
# What kind of joint it is, beside which one it is.
_KIND = re.compile(r"revolute|rev|joint|hinge|pin|_")
# An axis of a joint that could have several.
_AXIS = re.compile(r"r[xyz]")


def of_joint(name: str) -> str | None:
    """The column that the name of a joint's angle or rate means; None if it is no such name."""
    path = name.lower().strip(" \"'")
    if derived := _DERIVATIVE.fullmatch(path):
        path = derived[1]
    steps = [step for step in _STEPS.split(path) if step and not _AXIS.fullmatch(step)]
    if not steps or (len(steps) == 1 and not derived):
        return None
    *way, last = steps
    is_rate = last in _IS_RATE
    if way and (is_rate or last in _IS_ANGLE):
        last = way[-1]
    word = _KIND.sub("", last)
    if word in _RATES and last is steps[-1]:
        joint, is_rate = _RATES[word], True
    elif word in _JOINTS:
        joint = _JOINTS[word]
    else:
        return None
    if derived and is_rate:
        # An acceleration.
        return None
    return f"{joint}_{'rate' if derived or is_rate else 'angle'}"
