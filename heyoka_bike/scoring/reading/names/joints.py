"""Names that a program makes of the parts of a model: the way to a joint, and what is meant of it.

So ``bike.steer.phi`` and ``der(bike.steer.phi)`` of Modelica, ``Roll_Joint.Rz.w`` of Simscape, and
``/jointset/fork/steer_angle/value`` of OpenSim. Only joints are read so: the speed or the energy of
some part is not that of the bicycle.
"""

import re
from collections.abc import Mapping

_JOINTS: Mapping[str, tuple[str, int]] = {
    **dict.fromkeys(("roll", "rollangle", "lean", "leanangle"), ("roll", 0)),
    **dict.fromkeys(("steer", "steerangle", "steering", "steeringangle"), ("steer", 0)),
    **dict.fromkeys(("rollrate", "leanrate"), ("roll", 1)),
    **dict.fromkeys(("steerrate", "steeringrate"), ("steer", 1)),
}
"""Joints by their names, and how often the angle is differentiated."""
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
    is_part = way and last in _IS_ANGLE | _IS_RATE
    joint, order = _JOINTS.get(_KIND.sub("", way[-1] if is_part else last), ("", 2))
    order += (derived is not None) + (last in _IS_RATE)
    # The second derivative is an acceleration.
    return f"{joint}_{('angle', 'rate')[order]}" if order < 2 else None
