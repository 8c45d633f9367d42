"""The columns of the benchmark and the definitions that programs use for them.

The benchmark text asks for "roll angle", "roll angular velocity" and "forward speed" without
defining them, and honest programs differ. Each column here has one default definition and named
alternates, stored as ``<key>_<definition>``. How they follow from the state is in `outputs`.
"""

from collections.abc import Container, Mapping
from functools import partial

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS


def _columns() -> tuple[Column, ...]:
    lean = "to the right"
    ahead = "forward"
    d = True
    return (
        Column("roll_angle", "lean", "rad", "roll angle",
               "angle of the rear wheel plane from the vertical (yaw, roll, pitch)", lean, d),
        Column("roll_rate", "lean_rate", "rad s-1", "roll angular velocity",
               "time derivative of the lean", lean, d),
        Column("forward_speed", "hub_heading", "m s-1", "forward speed",
               "velocity of the rear hub along the heading; minus the rear wheel radius times the "
               "wheel's absolute spin rate about its axle", ahead, d),
        Column("potential_energy", "floor", "J", "potential energy", "zero at the floor", "", d),
        Column("kinetic_energy", "total", "J", "kinetic energy", "of all four bodies", "", d),
        Column("mechanical_energy", "total", "J", "mechanical energy",
               "potential plus kinetic; constant", "", d),
        Column("steer_angle", "steer", "rad", "steer angle",
               "rotation of the fork relative to the rear frame about the steer axis", lean, d),
        Column("steer_rate", "steer_rate", "rad s-1", "steer angular velocity",
               "time derivative of the steer angle", lean, d),
        Column("roll_angle", "tait_bryan_xyz", "rad", "roll angle",
               "first angle of the rear frame's attitude R = Rx Ry Rz; mixes in the yaw", lean),
        Column("roll_angle", "zyx", "rad", "roll angle",
               "roll of the rear frame's attitude R = Rz Ry Rx (yaw, pitch, roll)", lean),
        Column("roll_rate", "body_x", "rad s-1", "roll angular velocity",
               "angular velocity of the rear frame along its own x axis", lean),
        Column("roll_rate", "tait_bryan_xyz_rate", "rad s-1", "roll angular velocity",
               "time derivative of roll_angle_tait_bryan_xyz", lean),
        Column("roll_rate", "zyx_rate", "rad s-1", "roll angular velocity",
               "time derivative of roll_angle_zyx", lean),
        Column("roll_rate", "steer_axes_x", "rad s-1", "roll angular velocity",
               "angular velocity of the rear frame across the steer axis, in the frame's plane",
               lean),
        Column("forward_speed", "hub_body_x", "m s-1", "forward speed",
               "velocity of the rear hub along the x axis of the pitched rear frame", ahead),
        Column("forward_speed", "wheel_spin", "m s-1", "forward speed",
               "minus the rear wheel radius times the wheel's rate relative to the frame", ahead),
        Column("forward_speed", "contact", "m s-1", "forward speed",
               "speed of the rear contact point along its track", ahead),
        Column("forward_speed", "hub_norm", "m s-1", "forward speed",
               "magnitude of the rear hub's velocity", ahead),
        Column("forward_speed", "com_norm", "m s-1", "forward speed",
               "magnitude of the velocity of the centre of mass of the whole bicycle", ahead),
        Column("forward_speed", "hub_global_x", "m s-1", "forward speed",
               "velocity of the rear hub along the global x axis, the initial heading", ahead),
        Column("forward_speed", "contact_global_x", "m s-1", "forward speed",
               "velocity of the rear contact point along the global x axis", ahead),
        Column("forward_speed", "com_heading", "m s-1", "forward speed",
               "velocity of the whole bicycle's centre of mass along the rear heading", ahead),
        Column("forward_speed", "com_global_x", "m s-1", "forward speed",
               "velocity of the whole bicycle's centre of mass along the global x axis", ahead),
        Column("forward_speed", "front_hub_heading", "m s-1", "forward speed",
               "velocity of the front hub along the rear heading", ahead),
        Column("forward_speed", "front_hub_norm", "m s-1", "forward speed",
               "magnitude of the front hub's velocity", ahead),
        Column("forward_speed", "front_hub_global_x", "m s-1", "forward speed",
               "velocity of the front hub along the global x axis", ahead),
        Column("forward_speed", "front_contact", "m s-1", "forward speed",
               "speed of the front contact point along its track", ahead),
        Column("forward_speed", "front_contact_heading", "m s-1", "forward speed",
               "velocity of the front contact point along the rear heading", ahead),
        Column("forward_speed", "front_contact_global_x", "m s-1", "forward speed",
               "velocity of the front contact point along the global x axis", ahead),
        Column("forward_speed", "front_wheel_heading", "m s-1", "forward speed",
               "velocity of the front hub along the front wheel's heading; minus the front wheel "
               "radius times the wheel's absolute spin rate about its axle", ahead),
        Column("forward_speed", "front_wheel_spin", "m s-1", "forward speed",
               "minus the front wheel radius times the wheel's rate relative to the fork", ahead),
        Column("pitch", "pitch", "rad", "pitch angle",
               "rotation of the rear frame about its axle, zero upright", "nose up", d),
        Column("pitch", "zyx", "rad", "pitch angle",
               "pitch of the rear frame's attitude R = Rz Ry Rx (yaw, pitch, roll): of its x axis "
               "from the horizontal", "nose up"),
        Column("pitch", "steer_axes", "rad", "pitch angle",
               "rotation about the axle of axes of the rear frame with z down the steer axis: the "
               "steer axis tilt upright", "nose up"),
        Column("yaw", "yaw", "rad", "yaw angle",
               "direction of the heading from the initial one", lean, d),
        Column("yaw_rate", "yaw_rate", "rad s-1", "yaw rate",
               "time derivative of the yaw angle", lean, d),
        Column("yaw_rate", "body_z", "rad s-1", "yaw rate",
               "angular velocity of the rear frame along its own z axis", lean),
        Column("yaw_rate", "steer_axes_z", "rad s-1", "yaw rate",
               "angular velocity of the rear frame along the steer axis", lean),
    )  # fmt: skip


COLUMNS: tuple[Column, ...] = _columns()
"""All stored columns: the eight of the benchmark, then pitch, yaw and yaw rate, with their
alternates."""


def _following() -> tuple[Column, ...]:
    centre = "velocity of the rear frame's centre of mass, rider included"
    speeds = {
        "rear_com_heading": f"{centre}, along the heading",
        "rear_com_body_x": f"{centre}, along the x axis of the pitched frame",
        "rear_com_global_x": f"{centre}, along the global x axis",
        "rear_com_norm": f"magnitude of the {centre}",
    }
    of = partial(Column, is_dense=False)
    return (
        *(of("forward_speed", name, "m s-1", "forward speed", meaning, "forward")
          for name, meaning in speeds.items()),
        of("yaw", "zyx", "rad", "yaw angle",
           "yaw of the rear frame's attitude R = Rz Ry Rx (yaw, pitch, roll): of its x axis",
           "to the right"),
        of("yaw_rate", "zyx_rate", "rad s-1", "yaw rate", "time derivative of yaw_zyx",
           "to the right"),
    )  # fmt: skip


FOLLOWING: tuple[Column, ...] = _following()
"""Definitions that no set stores: they follow from the columns of any, see `reference.following`.
"""

BENCHMARK_COLUMNS: tuple[str, ...] = tuple(c.name for c in COLUMNS[:8])
"""The eight columns of the benchmark's result file, in its order (after the time)."""

LATERAL = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")
"""Columns of the benchmark that are zero upright and straight."""


_KNOWN = (*COLUMNS, *FOLLOWING, *MOTION_COLUMNS)


def definitions_among(names: Container[str]) -> dict[str, tuple[Column, ...]]:
    """The columns of these names, as the definitions of each key, the default first."""
    found: dict[str, tuple[Column, ...]] = {}
    for column in _KNOWN:
        if column.name in names:
            found[column.key] = (*found.get(column.key, ()), column)
    return found


COMPARED: Mapping[str, tuple[Column, ...]] = definitions_among({column.name for column in _KNOWN})
"""The definitions of every column that results are compared in, the default first: those of the
benchmark, then what a file may have besides by name, of `COLUMNS`, `FOLLOWING` and
`MOTION_COLUMNS`. All that this version knows: those of a set are
`ReferenceManeuver.definitions`."""

DEFINITIONS: Mapping[str, tuple[Column, ...]] = {key: COMPARED[key] for key in BENCHMARK_COLUMNS}
"""The definitions of each column of the benchmark, the default first."""

RATE_OF: Mapping[tuple[str, str], tuple[str, str]] = {
    ("roll_rate", "lean_rate"): ("roll_angle", "lean"),
    ("roll_rate", "tait_bryan_xyz_rate"): ("roll_angle", "tait_bryan_xyz"),
    ("roll_rate", "zyx_rate"): ("roll_angle", "zyx"),
    ("steer_rate", "steer_rate"): ("steer_angle", "steer"),
    ("yaw_rate", "yaw_rate"): ("yaw", "yaw"),
    ("yaw_rate", "zyx_rate"): ("yaw", "zyx"),
}
"""The definition of an angle by that of a rate which is its derivative. A body's
angular velocity along its own x axis is the derivative of no roll angle."""
