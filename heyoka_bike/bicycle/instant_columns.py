"""The quantities of an instant, level by level.

Each level needs only the levels before it, and the parameters and other inputs that it names.
`equations.instant` computes the quantities from a state. Positions and velocities are along the
ground axes: x along the heading at zero yaw, y to the right, z down, from the rear contact point.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

from heyoka_bike.bicycle.column import Column, components
from heyoka_bike.bicycle.columns import COLUMNS, COMPARED
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS

ANGLES = ("roll", "steer")
SPEEDS = (*ANGLES, "speed")
"""The independent speeds: roll rate, steer rate, forward speed."""

MATRICES = {"M": "kg m2", "C1": "kg m", "K0": "kg m", "K2": "kg"}
"""Matrices of the linear bicycle, with their units."""


@dataclass(frozen=True, slots=True)
class InstantLevel:
    """A level of quantities, which can be compared once the levels before it are correct.

    Attributes
    ----------
    name
    parameters
        Symbols of the parameters that enter here first.
    besides
        Everything else that enters here first.
    columns : tuple of Column
        Quantities of the level.
    """

    name: str
    parameters: tuple[str, ...]
    besides: str
    columns: tuple[Column, ...]


# Fields of a column's description: the name, the unit, the long name, and the positive direction
# or, for a vector, the axes.
_InstantRow = tuple[str, str, str, str]
_INSTANT_PLACES = {
    "rear_contact": ("rear contact point", "xy"),
    "front_contact": ("front contact point", "xy"),
    "rear_hub": ("rear hub", "xyz"),
    "front_hub": ("front hub", "xyz"),
    "rear_frame_com": ("centre of mass of the rear frame", "xyz"),
    "front_frame_com": ("centre of mass of the front frame", "xyz"),
    "com": ("centre of mass of the bicycle", "xyz"),
}
_MASS_UNITS = ("kg m2", "kg m", "kg")
_MASSES = tuple(
    (f"mass_{SPEEDS[i]}_{SPEEDS[j]}", _MASS_UNITS[(i == 2) + (j == 2)],
     f"mass matrix of roll rate, steer rate and forward speed: {SPEEDS[i]}, {SPEEDS[j]}", "")
    for i, j in product(range(3), repeat=2) if i <= j
)  # fmt: skip
_INSTANT: Mapping[str, tuple[_InstantRow, ...]] = {
    "geometry": (
        ("steer_axis_down_x", "1", "unit vector down the steer axis, upright, x", "forward"),
        ("steer_axis_down_z", "1", "unit vector down the steer axis, upright, z", "down"),
        ("steer_axis_floor_x", "m", "where the steer axis meets the floor, upright", "forward"),
        ("rear_hub_to_axis", "m", "from the rear hub across to the steer axis", "forward"),
        ("hubs_along_axis", "m", "from the rear to the front hub along the steer axis", "down"),
        ("axis_to_front_hub", "m", "from the steer axis across to the front hub", "forward"),
        ("mechanical_trail", "m", "front contact point from the steer axis", "behind it"),
    ),
    "positions": (("mass", "kg", "mass of the bicycle, of all four bodies", ""),),
    "velocities": (
        ("pitch_rate", "rad s-1", "time derivative of the pitch", "nose up"),
        ("rear_wheel_rate", "rad s-1", "rate of the rear wheel in the rear frame", "backward"),
        ("front_wheel_rate", "rad s-1", "rate of the front wheel in the fork", "backward"),
        *((f"{name}_velocity", "m s-1", f"velocity of the {what}", axes)
          for name, (what, axes) in _INSTANT_PLACES.items()),
    ),
    "energy": (
        *_MASSES,
        ("momentum", "kg m s-1", "momentum of the bicycle", "xyz"),
        ("angular_momentum", "kg m2 s-1", "angular momentum about the centre of mass", "xyz"),
    ),
    "accelerations": (
        ("roll_acceleration", "rad s-2", "second derivative of the roll angle", "to the right"),
        ("steer_acceleration", "rad s-2", "second derivative of the steer angle", "to the right"),
        ("forward_acceleration", "m s-2", "time derivative of the forward speed", "forward"),
        ("pitch_acceleration", "rad s-2", "second derivative of the pitch", "nose up"),
        ("yaw_acceleration", "rad s-2", "second derivative of the yaw", "to the right"),
        ("rear_wheel_acceleration", "rad s-2", "acceleration of the rear wheel in the rear frame",
         "backward"),
        ("front_wheel_acceleration", "rad s-2", "acceleration of the front wheel in the fork",
         "backward"),
    ),
    "linear": (
        *((f"{name}_{row}_{by}", unit, f"linear {name}, {row} equation, of {by}", "")
          for name, unit in MATRICES.items() for row, by in product(ANGLES, repeat=2)),
        *((f"eigenvalue_{n}_{part}", "s-1", f"eigenvalue {n} at this speed, {what} part", "")
          for n in range(1, 5) for part, what in (("re", "real"), ("im", "imaginary"))),
    ),
}  # fmt: skip
MASS_MATRIX = tuple(name for name, *_ in _MASSES)
"""Names of the entries in the upper triangle of the mass matrix, row by row."""

COORDINATES = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""The columns that determine a state; the pitch follows because both wheels are on the floor."""

WHERE = ("yaw", "rear_contact_x", "rear_contact_y", "rear_wheel_angle", "front_wheel_angle")
"""Optional columns of a state, which do not enter the equations of motion; zero by default."""

_LEVEL_OF = {
    "rad": "posture", "1": "posture", "m": "positions", "rad s-1": "velocities",
    "m s-1": "velocities", "J": "energy", "N": "forces", "N m": "forces",
}  # fmt: skip


def _level(name: str, besides: str, *parameters: str) -> InstantLevel:
    """Construct a level: columns of the benchmark and of the whole motion first, then others."""
    known = (
        c
        for c in (*COLUMNS, *MOTION_COLUMNS)
        if c.name not in (*COORDINATES, *WHERE)
        and ("forces" if c.definition == "demand" else _LEVEL_OF[c.unit]) == name
    )
    own = (
        Column(key, "instant", unit, long_name, long_name, positive, default=True)
        for row, unit, what, along in _INSTANT.get(name, ())
        for key, long_name, positive in components(row, what, along)
    )
    return InstantLevel(name, parameters, besides, (*known, *own))


LEVELS = (
    _level("geometry", "the steer axis", "w", "c", "lam", "rR", "rF"),
    _level(
        "posture",
        "the pitch that puts both wheels on the floor; yaw, roll, pitch, steer in this order",
    ),
    _level(
        "positions", "the contact points: the lowest points of both wheels",
        "mR", "xB", "zB", "mB", "xH", "zH", "mH", "mF",
    ),
    _level("velocities", "rolling without slip"),
    _level(
        "energy", "inertia about each body's own centre of mass, in axes that turn with it",
        "g", "IRxx", "IRyy", "IBxx", "IByy", "IBzz", "IBxz", "IHxx", "IHyy", "IHzz", "IHxz", "IFxx",
        "IFyy",
    ),
    _level(
        "accelerations", "the equations of motion: forces of inertia, w x I w of all bodies, the "
        "rates of the constraints, weight",
    ),
    _level("forces", "Newton's and Euler's laws of each body"),
    _level("linear", "derivatives about upright straight running"),
)  # fmt: skip
"""The levels, in the order in which a program is checked."""

QUANTITIES: Mapping[str, Column] = {
    **{name: COMPARED[name][0] for name in (*COORDINATES, *WHERE)},
    **{c.name: c for level in LEVELS for c in level.columns},
}
"""The coordinates and every quantity, by name."""

UNITS: Mapping[str, str] = {name: c.unit for name, c in QUANTITIES.items()}
"""SI units of `QUANTITIES`, by name."""
