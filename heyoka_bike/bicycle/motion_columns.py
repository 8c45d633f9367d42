"""The columns of motion.h5: the whole configuration and all forces.

How they follow from the state is in `equations.whole_motion`; docs/motion.md describes the axes.
"""

from collections.abc import Iterator

from heyoka_bike.bicycle.column import Column, components

_FRAME_NAMES = {"rear": "rear frame", "front": "front frame (fork and handlebar)"}
_TO_GROUND = "unit quaternion from the axes of the {frame} to the ground frame, q0 the scalar"
_FLOOR = "force of the floor on the {end} wheel"
_FRAME_AXES = "along the axes of the {frame}, y along the axle"
_STEER_AXES = "z down the steer axis, y right along the front axle, x forward across both"
_ON_FRONT = "of the rear frame on the front frame"

# Fields of a column's description: the name, the definition, the unit, the long name, the meaning,
# and the positive direction or, for a vector, the axes.
_DefinitionText = tuple[str, str, str, str, str, str]

# A group whose names contain {end} lists all of its columns for the rear wheel, then all for the
# front wheel.
_GROUPS: tuple[tuple[_DefinitionText, ...], ...] = (
    (("{end}_contact", "ground_axes", "m", "{end} contact point",
      "lowest point of the {end} wheel; ground frame", "xy"),),
    (("{end}_hub", "ground_axes", "m", "{end} hub",
      "centre of the {end} wheel, its centre of mass; ground frame", "xyz"),),
    (("{end}_frame_com", "ground_axes", "m", "centre of mass of the {end} frame",
      "of the {frame}; ground frame", "xyz"),),
    (("com", "ground_axes", "m", "centre of mass of the bicycle",
      "of all four bodies; ground frame", "xyz"),),
    (("{end}_wheel_angle", "in_frame", "rad", "{end} wheel angle",
      "how far the wheel has turned in the {frame} since the start, about its y axis",
      "backward: a wheel that rolls forward turns by a negative angle"),),
    (
        ("{end}_frame_omega", "frame_axes", "rad s-1", "angular velocity of the {end} frame",
         "absolute, along the axes of the {frame}", "xyz"),
        ("{end}_wheel_omega_y", "frame_axes", "rad s-1", "angular velocity of the {end} wheel, y",
         "absolute, about its axle; along x and z that of the {frame}", "backward"),
    ),
    (
        *((f"{{end}}_frame_q{i}", "to_ground", "1", f"quaternion of the {{end}} frame, q{i}",
           _TO_GROUND, "") for i in range(4)),
        *((f"{{end}}_frame_r{i}{j}", "to_ground", "1",
           f"rotation matrix of the {{end}} frame, r{i}{j}",
           f"row {i} (ground frame), column {j} (axis of the {{frame}})", "")
          for i in (1, 2, 3) for j in (1, 2, 3)),
    ),
    (
        ("{end}_normal_force", "heading_axes", "N", "{end} normal force", _FLOOR,
         "upward: the floor pushes"),
        ("{end}_longitudinal_force", "heading_axes", "N", "{end} longitudinal force",
         f"{_FLOOR}, along the wheel's heading, where its plane meets the floor", "forward"),
        ("{end}_lateral_force", "heading_axes", "N", "{end} lateral force",
         f"{_FLOOR}, across the wheel's heading", "to the right"),
        ("{end}_friction", "demand", "1", "{end} friction demand",
         "tangential over normal contact force; rolling needs a friction coefficient of at least "
         "this", ""),
    ),
    (
        ("{end}_axle_force", "frame_axes", "N", "{end} axle force",
         f"of the frame on the wheel, {_FRAME_AXES}", "xyz"),
        ("{end}_axle_moment", "frame_axes", "N m", "{end} axle moment",
         f"of the frame on the wheel, about the hub, {_FRAME_AXES}; none about y", "xz"),
    ),
    (
        ("steer_joint_force", "steer_axes", "N", "steer joint force",
         f"{_ON_FRONT}; {_STEER_AXES}", "xyz"),
        ("steer_joint_moment", "steer_axes", "N m", "steer joint moment",
         f"{_ON_FRONT}, about the point of the steer axis that is on the floor when upright and "
         f"straight; {_STEER_AXES}; none about z", "xy"),
    ),
)  # fmt: skip


def _motion_columns() -> Iterator[Column]:
    for rows in _GROUPS:
        for end in _FRAME_NAMES if "{end}" in rows[0][0] else ("",):
            for row in rows:
                name, definition, unit, what, meaning, along = (
                    text.format(end=end, frame=_FRAME_NAMES.get(end)) for text in row
                )
                ahead = "initial heading" if definition == "ground_axes" else "forward"
                for key, long_name, positive in components(name, what, along, ahead):
                    yield Column(
                        key, definition, unit, long_name, meaning, positive, default=True,
                        is_dense=definition != "demand",
                    )  # fmt: skip


MOTION_COLUMNS: tuple[Column, ...] = tuple(_motion_columns())
"""All columns of motion.h5."""

DENSE_COLUMNS: tuple[str, ...] = tuple(c.name for c in MOTION_COLUMNS if c.is_dense)
"""Names of the columns with Chebyshev pieces: all except the friction demands, which contain a
square root that need not be analytic."""

CONTACT_FORCES = {
    f"{end}_friction": tuple(
        f"{end}_{part}_force" for part in ("normal", "longitudinal", "lateral")
    )
    for end in _FRAME_NAMES
}
"""The columns that the friction demands follow from."""
