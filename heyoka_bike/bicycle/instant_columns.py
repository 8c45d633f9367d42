"""The quantities of a single instant, level by level.

`LEVELS` is the one table of them: a level needs nothing but the levels before it, the parameters
that it names, and what it names besides. How they follow from a state is in `instant`.

Places and velocities are along the ground axes, x along the heading where the yaw is zero, y to the
right, z down, from where the rear wheel touches the floor.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS

ANGLES = ("roll", "steer")
SPEEDS = (*ANGLES, "speed")
"""The independent speeds: roll rate, steer rate, forward speed."""

MATRICES = {"M": "kg m2", "C1": "kg m", "K0": "kg m", "K2": "kg"}
"""Matrices of the linear bicycle, with their units."""


@dataclass(frozen=True, slots=True)
class InstantLevel:
    """A level of quantities: they can be compared once the levels before it are right.

    Attributes
    ----------
    name
    parameters
        Symbols of the parameters that enter here first.
    besides
        What else enters here first.
    columns : tuple of Column
        Its quantities.
    """

    name: str
    parameters: tuple[str, ...]
    besides: str
    columns: tuple[Column, ...]


def _vector(name: str, unit: str, what: str, axes: str = "xyz") -> Iterator[Column]:
    positive = {"x": "forward", "y": "to the right", "z": "down"}
    for axis in axes:
        yield _scalar(f"{name}_{axis}", unit, f"{what}, {axis}", positive[axis])


def _scalar(name: str, unit: str, what: str, positive: str = "") -> Column:
    return Column(name, "instant", unit, what, what, positive, default=True)


_GEOMETRY = (
    _scalar("steer_axis_down_x", "1", "unit vector down the steer axis, upright, x", "forward"),
    _scalar("steer_axis_down_z", "1", "unit vector down the steer axis, upright, z", "down"),
    _scalar("steer_axis_floor_x", "m", "where the steer axis meets the floor, upright", "forward"),
    _scalar("rear_hub_to_axis", "m", "from the rear hub across to the steer axis", "forward"),
    _scalar("hubs_along_axis", "m", "from the rear to the front hub along the steer axis", "down"),
    _scalar("axis_to_front_hub", "m", "from the steer axis across to the front hub", "forward"),
    _scalar("mechanical_trail", "m", "front contact point from the steer axis", "behind it"),
)  # fmt: skip


_MASS = _scalar("mass", "kg", "mass of the bicycle, of all four bodies")


_PLACES = {
    "rear_contact": ("rear contact point", "xy"),
    "front_contact": ("front contact point", "xy"),
    "rear_hub": ("rear hub", "xyz"),
    "front_hub": ("front hub", "xyz"),
    "rear_frame_com": ("centre of mass of the rear frame", "xyz"),
    "front_frame_com": ("centre of mass of the front frame", "xyz"),
    "com": ("centre of mass of the bicycle", "xyz"),
}
_VELOCITIES = (
    _scalar("pitch_rate", "rad s-1", "time derivative of the pitch", "nose up"),
    _scalar("rear_wheel_rate", "rad s-1", "rate of the rear wheel in the rear frame", "backward"),
    _scalar("front_wheel_rate", "rad s-1", "rate of the front wheel in the fork", "backward"),
    *(
        column
        for name, (what, axes) in _PLACES.items()
        for column in _vector(f"{name}_velocity", "m s-1", f"velocity of the {what}", axes)
    ),
)


_MASS_UNITS = ("kg m2", "kg m", "kg")
MASS_MATRIX = tuple(
    _scalar(
        f"mass_{SPEEDS[i]}_{SPEEDS[j]}",
        _MASS_UNITS[(i == 2) + (j == 2)],
        f"mass matrix of roll rate, steer rate and forward speed: {SPEEDS[i]}, {SPEEDS[j]}",
    )
    for i, j in product(range(3), repeat=2)
    if i <= j
)
_MOMENTA = (
    *_vector("momentum", "kg m s-1", "momentum of the bicycle"),
    *_vector("angular_momentum", "kg m2 s-1", "angular momentum about the centre of mass"),
)


_ACCELERATIONS = tuple(
    _scalar(f"{name}_acceleration", unit, what, positive)
    for name, unit, what, positive in (
        ("roll", "rad s-2", "second derivative of the roll angle", "to the right"),
        ("steer", "rad s-2", "second derivative of the steer angle", "to the right"),
        ("forward", "m s-2", "time derivative of the forward speed", "forward"),
        ("pitch", "rad s-2", "second derivative of the pitch", "nose up"),
        ("yaw", "rad s-2", "second derivative of the yaw", "to the right"),
        ("rear_wheel", "rad s-2", "acceleration of the rear wheel in the rear frame", "backward"),
        ("front_wheel", "rad s-2", "acceleration of the front wheel in the fork", "backward"),
    )
)


_LINEAR = (
    *(
        _scalar(f"{name}_{row}_{by}", unit, f"linear {name}, {row} equation, of {by}")
        for name, unit in MATRICES.items()
        for row, by in product(ANGLES, repeat=2)
    ),
    *(
        _scalar(f"eigenvalue_{n}_{part}", "s-1", f"eigenvalue {n} at this speed, {what} part")
        for n in range(1, 5)
        for part, what in (("re", "real"), ("im", "imaginary"))
    ),
)


COORDINATES = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""The columns that give a state; the pitch follows, as both wheels are on the floor."""

WHERE = ("yaw", "rear_contact_x", "rear_contact_y", "rear_wheel_angle", "front_wheel_angle")
"""The columns that may be given besides and drive nothing; by default they are zero."""

_LEVEL_OF = {
    "rad": "posture", "1": "posture", "m": "positions", "rad s-1": "velocities",
    "m s-1": "velocities", "J": "energy", "N": "forces", "N m": "forces",
}  # fmt: skip


def _known(name: str) -> tuple[Column, ...]:
    """Columns of the benchmark and of the whole motion that are of a level."""
    return tuple(
        c
        for c in (*COLUMNS, *MOTION_COLUMNS)
        if c.name not in (*COORDINATES, *WHERE)
        and ("forces" if c.definition == "demand" else _LEVEL_OF[c.unit]) == name
    )


LEVELS = (
    InstantLevel("geometry", ("w", "c", "lam", "rR", "rF"), "the steer axis", _GEOMETRY),
    InstantLevel(
        "posture", (), "the pitch that puts both wheels on the floor; yaw, roll, pitch, steer in "
        "this order", _known("posture"),
    ),
    InstantLevel(
        "positions", ("mR", "xB", "zB", "mB", "xH", "zH", "mH", "mF"), "the contact points: the "
        "lowest points of both wheels", (*_known("positions"), _MASS),
    ),
    InstantLevel(
        "velocities", (), "rolling without slip", (*_known("velocities"), *_VELOCITIES)
    ),
    InstantLevel(
        "energy",
        ("g", "IRxx", "IRyy", "IBxx", "IByy", "IBzz", "IBxz", "IHxx", "IHyy", "IHzz", "IHxz",
         "IFxx", "IFyy"),
        "inertia about each body's own centre of mass, in axes that turn with it",
        (*_known("energy"), *MASS_MATRIX, *_MOMENTA),
    ),
    InstantLevel(
        "accelerations", (), "the equations of motion: forces of inertia, w x I w of all bodies, "
        "the rates of the constraints, weight", _ACCELERATIONS,
    ),
    InstantLevel("forces", (), "Newton's and Euler's laws of each body", _known("forces")),
    InstantLevel("linear", (), "derivatives about upright straight running", _LINEAR),
)  # fmt: skip
"""In the order in which a program is checked."""

_STORED = {c.name: c for c in (*COLUMNS, *MOTION_COLUMNS)}

QUANTITIES: Mapping[str, Column] = {
    **{name: _STORED[name] for name in (*COORDINATES, *WHERE)},
    **{c.name: c for level in LEVELS for c in level.columns},
}
"""The coordinates and every quantity, by name."""

UNITS: Mapping[str, str] = {name: c.unit for name, c in QUANTITIES.items()}
"""Their SI units."""
