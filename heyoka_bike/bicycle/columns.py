"""All columns: of the benchmark, of the whole motion, and of single instants.

`COLUMNS`. The benchmark text asks for "roll angle", "roll angular velocity" and "forward speed"
without defining them, and honest programs differ. Each column has one default definition and named
alternates, stored as ``<key>_<definition>``. How they follow from the state is in `outputs`.

`MOTION_COLUMNS` are those of motion.h5: the whole configuration and all forces. How they follow
from the state is in `whole_motion`; docs/motion.md tells of the axes.

`LEVELS` is the one table of the quantities of an instant: a level needs nothing but the levels
before it, the parameters that it names, and what it names besides. How they follow from a state is
in `instant`. Their places and velocities are along the ground axes, x along the heading where the
yaw is zero, y to the right, z down, from where the rear wheel touches the floor.
"""

import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from itertools import product


@dataclass(frozen=True, slots=True)
class Column:
    """A stored quantity.

    Attributes
    ----------
    key
        Name of the column (``roll_angle``).
    definition
        Name of the definition, of the axes or of the frame it refers to; the first one listed of a
        key is its default.
    unit
        SI unit, UDUNITS spelling.
    long_name, meaning, positive
        For people: what it is, how it is defined, which way is positive.
    default
        Whether it is meant by the key alone.
    is_dense
        Whether there are Chebyshev pieces of it; else it follows from columns that have them.
    """

    key: str
    definition: str
    unit: str
    long_name: str
    meaning: str
    positive: str = ""
    default: bool = False
    is_dense: bool = True

    @property
    def name(self) -> str:
        """Name of the dataset: the key, followed by the definition for an alternate."""
        return self.key if self.default else f"{self.key}_{self.definition}"


# Unit, what it is, which way is positive, and the definitions with their meanings, by key. The
# first definition is the default.
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
"""All stored columns: the eight of the benchmark, then their alternates, then pitch, yaw and yaw
rate with theirs."""

FOLLOWING: tuple[Column, ...] = tuple(
    _defined(key, *of, is_stored=False)
    for key, definitions in _FOLLOWING.items()
    for of in definitions.items()
)
"""Definitions that no set stores: they follow from the columns of any, see `reference.following`.
"""

NORMS = tuple(c.name for c in COLUMNS if c.definition.endswith("_norm"))
"""Magnitudes of velocities: their roots are not analytic where a velocity vanishes."""

LATERAL = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")
"""Columns of the benchmark that are zero upright and straight."""


_FRAME_NAMES = {"rear": "rear frame", "front": "front frame (fork and handlebar)"}
_TO_GROUND = "unit quaternion from the axes of the {frame} to the ground frame, q0 the scalar"
_FLOOR = "force of the floor on the {end} wheel"
_FRAME_AXES = "along the axes of the {frame}, y along the axle"
_STEER_AXES = "z down the steer axis, y right along the front axle, x forward across both"
_ON_FRONT = "of the rear frame on the front frame"

# Name, definition, unit, what it is, meaning, and the axes of a vector or which way is positive.
_DefinitionText = tuple[str, str, str, str, str, str]

# What is said of each end stands in one group, all of the rear before all of the front.
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


def _components(name: str, what: str, along: str, ahead: str = "forward") -> Iterator[list[str]]:
    """Names, and what they are, of a column, or of a vector's along its axes; which is positive."""
    if along not in ("xyz", "xy", "xz"):
        yield [name, what, along]
        return
    positive = {"x": ahead, "y": "to the right", "z": "down"}
    for axis in along:
        yield [f"{name}_{axis}", f"{what}, {axis}", positive[axis]]


def _motion_columns() -> Iterator[Column]:
    for rows in _GROUPS:
        for end in _FRAME_NAMES if "{end}" in rows[0][0] else ("",):
            for row in rows:
                name, definition, unit, what, meaning, along = (
                    text.format(end=end, frame=_FRAME_NAMES.get(end)) for text in row
                )
                ahead = "initial heading" if definition == "ground_axes" else "forward"
                for key, long_name, positive in _components(name, what, along, ahead):
                    yield Column(
                        key, definition, unit, long_name, meaning, positive, default=True,
                        is_dense=definition != "demand",
                    )  # fmt: skip


MOTION_COLUMNS: tuple[Column, ...] = tuple(_motion_columns())
"""All columns of motion.h5."""

DENSE_COLUMNS: tuple[str, ...] = tuple(c.name for c in MOTION_COLUMNS if c.is_dense)
"""Names of those with Chebyshev pieces: all but the friction demands, which follow from them
by a root that need not be analytic."""

CONTACT_FORCES = {
    f"{end}_friction": tuple(
        f"{end}_{part}_force" for part in ("normal", "longitudinal", "lateral")
    )
    for end in _FRAME_NAMES
}
"""The columns that the friction demands follow from."""


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

FREE_ZERO = frozenset(
    key
    for key, (column, *_) in COMPARED.items()
    if key == "yaw"
    or column.definition == "in_frame"
    or (column.definition == "ground_axes" and key.endswith(("_x", "_y")))
)
"""Keys of the quantities that no equation of motion contains: the heading, the places on the floor
and the angles of the wheels. Any value may be their zero."""

DEFINITIONS: Mapping[str, tuple[Column, ...]] = {key: COMPARED[key] for key in BENCHMARK_COLUMNS}
"""The definitions of each column of the benchmark, the default first."""

ALIASES: Mapping[str, tuple[str, ...]] = {
    "roll_angle": ("roll", "phi", "varphi", "\u03c6", "\u03d5", "lean", "leanangle"),
    "roll_rate": (
        "rollangularvelocity", "rollvelocity", "angularrollvelocity", "phidot", "dphi", "phid", "p",
        "leanrate", "leanangularvelocity", "rolldot", "rolld", "leand", "dotphi", "dotvarphi",
        "\u03c6\u0307", "\u03d5\u0307",
    ),
    "forward_speed": (
        "speed", "velocity", "v", "vx", "forwardvelocity", "longitudinalspeed",
        "longitudinalvelocity",
    ),
    "potential_energy": ("potential", "epot", "ep", "pe", "u"),
    "kinetic_energy": ("kinetic", "ekin", "ek", "ke"),
    "mechanical_energy": ("mechanical", "energy", "total", "totalenergy", "emech", "etot", "e"),
    "steer_angle": ("steer", "steering", "steeringangle", "delta", "\u03b4"),
    "steer_rate": (
        "steerangularvelocity", "steeringangularvelocity", "steervelocity", "steeringvelocity",
        "steeringrate", "angularsteervelocity", "deltadot", "ddelta", "deltad", "steerdot",
        "steerd", "dotdelta", "\u03b4\u0307",
    ),
    "pitch": ("pitchangle", "theta", "\u03b8"),
    "yaw": ("yawangle", "heading", "headingangle", "psi", "\u03c8"),
    "yaw_rate": ("yawangularvelocity", "yawvelocity", "headingrate", "psidot", "dpsi", "yawdot"),
}  # fmt: skip
"""By key, other names of columns as programs write them: small letters without any breaks."""

KEYS_BY_WORD: Mapping[str, str] = {
    **{key.replace("_", ""): key for key in COMPARED},
    **{alias: key for key, aliases in ALIASES.items() for alias in aliases},
}
"""The key that each name means, in small letters without any breaks."""

_NOT_OF_THE_WORD = re.compile(r"\[[^][]*\]|\([^()]*\)|[\s_-]+")


def key_of(name: str) -> str | None:
    """Key of the column that a name means (``phi``, ``Roll [deg]``); None if it is not known."""
    return KEYS_BY_WORD.get(_NOT_OF_THE_WORD.sub("", name.lower()))


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


# Name, unit, what it is, and which way is positive or the axes of a vector.
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
"""Names of the entries of the mass matrix, row by row, up to those of its symmetry."""

COORDINATES = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""The columns that give a state; the pitch follows, as both wheels are on the floor."""

WHERE = ("yaw", "rear_contact_x", "rear_contact_y", "rear_wheel_angle", "front_wheel_angle")
"""The columns that may be given besides and drive nothing; by default they are zero."""

_LEVEL_OF = {
    "rad": "posture", "1": "posture", "m": "positions", "rad s-1": "velocities",
    "m s-1": "velocities", "J": "energy", "N": "forces", "N m": "forces",
}  # fmt: skip


def _level(name: str, besides: str, *parameters: str) -> InstantLevel:
    """A level: first its columns of the benchmark and of the whole motion, then its own."""
    known = (
        c
        for c in (*COLUMNS, *MOTION_COLUMNS)
        if c.name not in (*COORDINATES, *WHERE)
        and ("forces" if c.definition == "demand" else _LEVEL_OF[c.unit]) == name
    )
    own = (
        Column(key, "instant", unit, long_name, long_name, positive, default=True)
        for row, unit, what, along in _INSTANT.get(name, ())
        for key, long_name, positive in _components(row, what, along)
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
"""In the order in which a program is checked."""

QUANTITIES: Mapping[str, Column] = {
    **{name: COMPARED[name][0] for name in (*COORDINATES, *WHERE)},
    **{c.name: c for level in LEVELS for c in level.columns},
}
"""The coordinates and every quantity, by name."""

UNITS: Mapping[str, str] = {name: c.unit for name, c in QUANTITIES.items()}
"""Their SI units."""
