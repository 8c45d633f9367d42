"""The columns by which results are compared, by key and definition.

The benchmark text asks for "roll angle", "roll angular velocity" and "forward speed" without
defining them, and honest programs differ. Each column has one default definition and named
alternates, stored as ``<key>_<definition>``. How they follow from the state is in
`equations.outputs`.
"""

from collections.abc import Container, Mapping

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS

# The description of a column key: its unit, its long name, its positive direction, and the meaning
# of each definition by the definition's key. The first definition is the default.
_Key = tuple[str, str, str, Mapping[str, str]]
_LEAN, _AHEAD = "to the right", "forward"

_DEFINED_KEYS: Mapping[str, _Key] = {
    "roll_angle": ("rad", "roll angle", _LEAN, {
        "lean": "angle of the rear wheel plane from the vertical (yaw, roll, pitch)",
        "tait_bryan_xyz": "first angle of the rear frame's attitude R = Rx Ry Rz; mixes in the yaw",
        "zyx": "roll of the rear frame's attitude R = Rz Ry Rx (yaw, pitch, roll)",
    }),
    "roll_rate": ("rad s-1", "roll angular velocity", _LEAN, {
        "lean_rate": "time derivative of the lean",
        "body_x": "angular velocity of the rear frame along its own x axis",
        "tait_bryan_xyz_rate": "time derivative of roll_angle_tait_bryan_xyz",
        "zyx_rate": "time derivative of roll_angle_zyx",
        "steer_axes_x": "angular velocity of the rear frame across the steer axis, in the frame's "
        "plane",
    }),
    "forward_speed": ("m s-1", "forward speed", _AHEAD, {
        "hub_heading": "velocity of the rear hub along the heading; minus the rear wheel radius "
        "times the wheel's absolute spin rate about its axle",
        "hub_body_x": "velocity of the rear hub along the x axis of the pitched rear frame",
        "wheel_spin": "minus the rear wheel radius times the wheel's rate relative to the frame",
        "contact": "speed of the rear contact point along its track",
        "hub_norm": "magnitude of the rear hub's velocity",
        "com_norm": "magnitude of the velocity of the centre of mass of the whole bicycle",
        "hub_global_x": "velocity of the rear hub along the global x axis, the initial heading",
        "contact_global_x": "velocity of the rear contact point along the global x axis",
        "com_heading": "velocity of the whole bicycle's centre of mass along the rear heading",
        "com_global_x": "velocity of the whole bicycle's centre of mass along the global x axis",
        "front_hub_heading": "velocity of the front hub along the rear heading",
        "front_hub_norm": "magnitude of the front hub's velocity",
        "front_hub_global_x": "velocity of the front hub along the global x axis",
        "front_contact": "speed of the front contact point along its track",
        "front_contact_heading": "velocity of the front contact point along the rear heading",
        "front_contact_global_x": "velocity of the front contact point along the global x axis",
        "front_wheel_heading": "velocity of the front hub along the front wheel's heading; minus "
        "the front wheel radius times the wheel's absolute spin rate about its axle",
        "front_wheel_spin": "minus the front wheel radius times the wheel's rate relative to the "
        "fork",
    }),
    "potential_energy": ("J", "potential energy", "", {"floor": "zero at the floor"}),
    "kinetic_energy": ("J", "kinetic energy", "", {"total": "of all four bodies"}),
    "mechanical_energy": ("J", "mechanical energy", "", {
        "total": "potential plus kinetic; constant",
    }),
    "steer_angle": ("rad", "steer angle", _LEAN, {
        "steer": "rotation of the fork relative to the rear frame about the steer axis",
    }),
    "steer_rate": ("rad s-1", "steer angular velocity", _LEAN, {
        "steer_rate": "time derivative of the steer angle",
    }),
    "pitch": ("rad", "pitch angle", "nose up", {
        "pitch": "rotation of the rear frame about its axle, zero upright",
        "zyx": "pitch of the rear frame's attitude R = Rz Ry Rx (yaw, pitch, roll): of its x axis "
        "from the horizontal",
        "steer_axes": "rotation about the axle of axes of the rear frame with z down the steer "
        "axis: the steer axis tilt upright",
    }),
    "yaw": ("rad", "yaw angle", _LEAN, {
        "yaw": "direction of the heading from the initial one",
    }),
    "yaw_rate": ("rad s-1", "yaw rate", _LEAN, {
        "yaw_rate": "time derivative of the yaw angle",
        "body_z": "angular velocity of the rear frame along its own z axis",
        "steer_axes_z": "angular velocity of the rear frame along the steer axis",
    }),
}  # fmt: skip

BENCHMARK_COLUMNS: tuple[str, ...] = tuple(_DEFINED_KEYS)[:8]
"""The eight columns of the benchmark's result file, in its order (after the time)."""

_CENTRE = "velocity of the rear frame's centre of mass, rider included"
_FOLLOWING: Mapping[str, Mapping[str, str]] = {
    "forward_speed": {
        "rear_com_heading": f"{_CENTRE}, along the heading",
        "rear_com_body_x": f"{_CENTRE}, along the x axis of the pitched frame",
        "rear_com_global_x": f"{_CENTRE}, along the global x axis",
        "rear_com_norm": f"magnitude of the {_CENTRE}",
    },
    "yaw": {
        "zyx": "yaw of the rear frame's attitude R = Rz Ry Rx (yaw, pitch, roll): of its x axis"
    },
    "yaw_rate": {"zyx_rate": "time derivative of yaw_zyx"},
}


def _defined(key: str, definition: str, meaning: str, *, is_stored: bool = True) -> Column:
    unit, long_name, positive, definitions = _DEFINED_KEYS[key]
    is_default = is_stored and definition == next(iter(definitions))
    return Column(key, definition, unit, long_name, meaning, positive, is_default, is_stored)


_STORED = [_defined(key, *of) for key, (*_, known) in _DEFINED_KEYS.items() for of in known.items()]
_FIRST_COLUMNS = [c for c in _STORED if c.default and c.key in BENCHMARK_COLUMNS]

COLUMNS: tuple[Column, ...] = (*_FIRST_COLUMNS, *(c for c in _STORED if c not in _FIRST_COLUMNS))
"""All stored columns: the eight of the benchmark and their alternates, then pitch, yaw and yaw rate
with their alternates."""

FOLLOWING: tuple[Column, ...] = tuple(
    _defined(key, *of, is_stored=False)
    for key, definitions in _FOLLOWING.items()
    for of in definitions.items()
)
"""Definitions that no dataset stores: they follow from stored columns, see
`reference.following`."""

NORMS = tuple(c.name for c in COLUMNS if c.definition.endswith("_norm"))
"""Magnitudes of velocities: square roots, which are not analytic where a velocity vanishes."""

LATERAL = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")
"""Columns of the benchmark that are zero in upright straight running."""

_KNOWN = (*COLUMNS, *FOLLOWING, *MOTION_COLUMNS)


def definitions_among(names: Container[str]) -> dict[str, tuple[Column, ...]]:
    """Return the columns with these names, grouped by key, the default definition first."""
    found: dict[str, tuple[Column, ...]] = {}
    for column in _KNOWN:
        if column.name in names:
            found[column.key] = (*found.get(column.key, ()), column)
    return found


COMPARED: Mapping[str, tuple[Column, ...]] = definitions_among({column.name for column in _KNOWN})
"""The definitions of every column in which results are compared, the default first. The columns of
the benchmark come first, then the others that a file may have by name, from `COLUMNS`, `FOLLOWING`
and `MOTION_COLUMNS`. These are all definitions of this version; those of one dataset are in
`ReferenceManeuver.definitions`."""

FREE_ZERO = frozenset(
    key
    for key, (column, *_) in COMPARED.items()
    if key == "yaw"
    or column.definition == "in_frame"
    or (column.definition == "ground_axes" and key.endswith(("_x", "_y")))
)
"""Keys of the quantities that do not enter the equations of motion: heading, position on the floor
and wheel angles. Their zero is arbitrary."""

DEFINITIONS: Mapping[str, tuple[Column, ...]] = {key: COMPARED[key] for key in BENCHMARK_COLUMNS}
"""The definitions of each column of the benchmark, the default first."""

DERIVATIVES: Mapping[tuple[str, str], tuple[str, str]] = {
    ("roll_rate", "lean_rate"): ("roll_angle", "lean"),
    ("roll_rate", "tait_bryan_xyz_rate"): ("roll_angle", "tait_bryan_xyz"),
    ("roll_rate", "zyx_rate"): ("roll_angle", "zyx"),
    ("steer_rate", "steer_rate"): ("steer_angle", "steer"),
    ("yaw_rate", "yaw_rate"): ("yaw", "yaw"),
    ("yaw_rate", "zyx_rate"): ("yaw", "zyx"),
}
"""The rates that are derivatives of angles, each with its angle; both as key and definition. The
angular velocity of a body along its own x axis is not the derivative of any roll angle."""

ANGLE_OF: Mapping[str, str] = {rate: angle for (rate, _), (angle, _) in DERIVATIVES.items()}
"""The key of the angle that each rate belongs to, by the key of the rate."""

RATE_OF: Mapping[str, str] = {angle: rate for rate, angle in ANGLE_OF.items()}
"""The key of the rate that belongs to each angle, by the key of the angle."""
