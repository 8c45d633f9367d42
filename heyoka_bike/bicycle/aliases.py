"""Other names of columns, as programs write them."""

import re
from collections.abc import Mapping

from heyoka_bike.bicycle.columns import COMPARED

ALIASES: Mapping[str, tuple[str, ...]] = {
    "roll_angle": ("roll", "phi", "varphi", "\u03c6", "\u03d5", "lean", "leanangle"),
    "roll_rate": (
        "rollangularvelocity", "rollvelocity", "angularrollvelocity", "phidot", "dphi", "phid", "p",
        "leanrate", "leanangularvelocity", "rolldot", "rolld", "leand", "droll", "dlean", "dotphi",
        "dotvarphi", "\u03c6\u0307", "\u03d5\u0307",
    ),
    "forward_speed": (
        "speed", "velocity", "v", "vx", "forwardvelocity", "longitudinalspeed",
        "longitudinalvelocity",
    ),
    "potential_energy": ("potential", "pot", "epot", "ep", "pe", "u"),
    "kinetic_energy": ("kinetic", "kin", "ekin", "ek", "ke"),
    "mechanical_energy": (
        "mechanical", "mech", "energy", "total", "totalenergy", "emech", "etot", "e",
    ),
    "steer_angle": ("steer", "steering", "steeringangle", "delta", "\u03b4"),
    "steer_rate": (
        "steerangularvelocity", "steeringangularvelocity", "steervelocity", "steeringvelocity",
        "steeringrate", "angularsteervelocity", "deltadot", "ddelta", "deltad", "steerdot",
        "steerd", "dsteer", "dotdelta", "\u03b4\u0307",
    ),
    "pitch": ("pitchangle", "theta", "\u03b8"),
    "yaw": ("yawangle", "heading", "headingangle", "psi", "\u03c8"),
    "yaw_rate": (
        "yawangularvelocity", "yawvelocity", "headingrate", "psidot", "dpsi", "yawdot", "dyaw",
    ),
}  # fmt: skip
"""Other names of columns as programs write them, by key: lower case without separators."""

KEYS_BY_WORD: Mapping[str, str] = {
    **{key.replace("_", ""): key for key in COMPARED},
    **{alias: key for key, aliases in ALIASES.items() for alias in aliases},
}
"""Keys by name; the names are in lower case without separators."""

_NOT_OF_THE_WORD = re.compile(r"\[[^][]*\]|\([^()]*\)|[\s_-]+")


def key_of(name: str) -> str | None:
    """Return the key of the column that a name means (``phi``, ``Roll [deg]``); None if unknown."""
    return KEYS_BY_WORD.get(_NOT_OF_THE_WORD.sub("", name.lower()))
