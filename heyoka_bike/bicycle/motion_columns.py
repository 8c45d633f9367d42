"""The columns of motion.h5: the whole configuration and all forces.

How they follow from the state is in `whole_motion`; docs/motion.md tells of the axes.
"""

from collections.abc import Iterator
from functools import partial

from heyoka_bike.bicycle.column import Column

_column = partial(Column, default=True)

_GROUND = {"x": "initial heading", "y": "to the right", "z": "down"}
_AXES = {"x": "forward", "y": "to the right", "z": "down"}
_FRAMES = {"rear": "rear frame", "front": "front frame (fork and handlebar)"}


def _places(name: str, what: str, meaning: str, axes: str = "xyz") -> Iterator[Column]:
    for axis in axes:
        yield Column(
            f"{name}_{axis}", "ground_axes", "m", f"{what}, {axis}", f"{meaning}; ground frame",
            _GROUND[axis], default=True,
        )  # fmt: skip


def _vector(
    name: str, definition: str, unit: str, what: str, meaning: str, axes: str = "xyz"
) -> Iterator[Column]:
    for axis in axes:
        yield _column(f"{name}_{axis}", definition, unit, f"{what}, {axis}", meaning, _AXES[axis])


def _columns() -> Iterator[Column]:
    for end in _FRAMES:
        yield from _places(
            f"{end}_contact", f"{end} contact point", f"lowest point of the {end} wheel", "xy"
        )  # fmt: skip
    for end in _FRAMES:
        yield from _places(
            f"{end}_hub", f"{end} hub", f"centre of the {end} wheel, its centre of mass"
        )
    for end, frame in _FRAMES.items():
        yield from _places(
            f"{end}_frame_com", f"centre of mass of the {end} frame", f"of the {frame}"
        )
    yield from _places("com", "centre of mass of the bicycle", "of all four bodies")
    for end, frame in _FRAMES.items():
        yield _column(
            f"{end}_wheel_angle", "in_frame", "rad", f"{end} wheel angle",
            f"how far the wheel has turned in the {frame} since the start, about its y axis",
            "backward: a wheel that rolls forward turns by a negative angle",
        )  # fmt: skip
    for end, frame in _FRAMES.items():
        yield from _vector(
            f"{end}_frame_omega", "frame_axes", "rad s-1",
            f"angular velocity of the {end} frame", f"absolute, along the axes of the {frame}",
        )  # fmt: skip
        yield _column(
            f"{end}_wheel_omega_y", "frame_axes", "rad s-1",
            f"angular velocity of the {end} wheel, y",
            f"absolute, about its axle; along x and z that of the {frame}", "backward",
        )  # fmt: skip
    for end, frame in _FRAMES.items():
        for i in range(4):
            yield _column(
                f"{end}_frame_q{i}", "to_ground", "1", f"quaternion of the {end} frame, q{i}",
                f"unit quaternion from the axes of the {frame} to the ground frame, q0 the scalar",
            )  # fmt: skip
        for i in range(1, 4):
            for j in range(1, 4):
                yield _column(
                    f"{end}_frame_r{i}{j}",
                    "to_ground",
                    "1",
                    f"rotation matrix of the {end} frame, r{i}{j}",
                    f"row {i} (ground frame), column {j} (axis of the {frame})",
                )
    for end in _FRAMES:
        floor = f"force of the floor on the {end} wheel"
        yield _column(
            f"{end}_normal_force", "heading_axes", "N", f"{end} normal force", floor,
            "upward: the floor pushes",
        )  # fmt: skip
        yield _column(
            f"{end}_longitudinal_force", "heading_axes", "N", f"{end} longitudinal force",
            f"{floor}, along the wheel's heading, where its plane meets the floor", "forward",
        )  # fmt: skip
        yield _column(
            f"{end}_lateral_force", "heading_axes", "N", f"{end} lateral force",
            f"{floor}, across the wheel's heading", "to the right",
        )  # fmt: skip
        yield _column(
            f"{end}_friction", "demand", "1", f"{end} friction demand",
            "tangential over normal contact force; rolling needs a friction coefficient of at "
            "least this", is_dense=False,
        )  # fmt: skip
    for end, frame in _FRAMES.items():
        axes = f"along the axes of the {frame}, y along the axle"
        yield from _vector(
            f"{end}_axle_force", "frame_axes", "N", f"{end} axle force",
            f"of the frame on the wheel, {axes}",
        )  # fmt: skip
        yield from _vector(
            f"{end}_axle_moment", "frame_axes", "N m", f"{end} axle moment",
            f"of the frame on the wheel, about the hub, {axes}; none about y", "xz",
        )  # fmt: skip
    steered = "z down the steer axis, y right along the front axle, x forward across both"
    yield from _vector(
        "steer_joint_force", "steer_axes", "N", "steer joint force",
        f"of the rear frame on the front frame; {steered}",
    )  # fmt: skip
    yield from _vector(
        "steer_joint_moment", "steer_axes", "N m", "steer joint moment",
        "of the rear frame on the front frame, about the point of the steer axis that is on the "
        f"floor when upright and straight; {steered}; none about z", "xy",
    )  # fmt: skip


MOTION_COLUMNS: tuple[Column, ...] = tuple(_columns())
"""All columns of motion.h5."""

DENSE_COLUMNS: tuple[str, ...] = tuple(c.name for c in MOTION_COLUMNS if c.is_dense)
"""Names of those with Chebyshev pieces: all but the friction demands, which follow from them
by a root that need not be analytic."""

CONTACT_FORCES = {
    f"{end}_friction": tuple(
        f"{end}_{part}_force" for part in ("normal", "longitudinal", "lateral")
    )
    for end in _FRAMES
}
"""What the friction demands follow from."""
