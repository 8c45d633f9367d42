"""Names of joints: paths to the angle of a joint in a model, or to its rate.

A name may be such a path, as ``bike.steer.phi`` and ``der(bike.steer.phi)`` of Modelica,
``Roll_Joint.Rz.w`` of Simscape and ``/jointset/fork/steer_angle/value`` of OpenSim. Only paths to
joints are read like this, because the speed or the energy of some part is not that of the bicycle.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

# The joint that each name means, and the derivative of its angle: 0 is the angle, 1 its rate.
_JOINTS: Mapping[str, tuple[str, int]] = {
    **dict.fromkeys(("roll", "rollangle", "lean", "leanangle"), ("roll", 0)),
    **dict.fromkeys(("steer", "steerangle", "steering", "steeringangle"), ("steer", 0)),
    **dict.fromkeys(("rollrate", "leanrate"), ("roll", 1)),
    **dict.fromkeys(("steerrate", "steeringrate"), ("steer", 1)),
}
_IS_ANGLE = frozenset({"phi", "q", "angle", "value"})
_IS_RATE = frozenset({"w", "qd", "omega", "speed", "rate"})
_PATH_STEPS = re.compile(r"[./|]")
# A derivative, which may be the last component of a path, as in log.der(bike.roll.phi).
_DERIVATIVE = re.compile(r"((?:.*[./|])?)der\((.+?)(?:,\s*1)?\)")
_WORDS = re.compile(r"[^\W\d_]+")
# Words for the kind of a joint that may occur in its name.
_KINDS = ("revolute", "rev", "joint", "hinge", "pin")
_KIND_OF_JOINT = re.compile(f"{'|'.join(_KINDS)}|_")
# Names of an axis, used for a joint that could have several axes.
_AXES_OF_JOINT = frozenset({"rx", "ry", "rz"})
_NO_NAMES = _AXES_OF_JOINT.union(_KINDS)


def column_of_joint(name: str) -> str | None:
    """Return the column whose joint and quantity are the last words of a name; else None.

    ``Steer_Joint.Rz.q#12`` and ``Bicycle_Steer_Joint_Rz_q`` mean the steer angle, whatever other
    words they contain.
    """
    words = [word for word in _WORDS.findall(name.lower()) if word not in _NO_NAMES]
    is_quantity = words and words[-1] in _IS_ANGLE | _IS_RATE
    return of_joint(".".join(words[-2:])) if is_quantity else None


def of_joint(name: str) -> str | None:
    """Return the column that a path to the angle or rate of a joint means; None for other names."""
    path = name.lower().strip(" \"'")
    if derived := _DERIVATIVE.fullmatch(path):
        path = f"{derived[1]}{derived[2]}"
    steps = [step for step in _PATH_STEPS.split(path) if step and step not in _AXES_OF_JOINT]
    if not steps or (len(steps) == 1 and not derived):
        return None
    *way, last = steps
    is_part = way and last in _IS_ANGLE | _IS_RATE
    joint, order = _JOINTS.get(_KIND_OF_JOINT.sub("", way[-1] if is_part else last), ("", 2))
    order += (derived is not None) + (last in _IS_RATE)
    # The second derivative of an angle is an acceleration, which is not compared.
    return f"{joint}_{('angle', 'rate')[order]}" if order < 2 else None
