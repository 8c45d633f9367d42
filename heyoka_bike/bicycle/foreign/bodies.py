"""Moving bodies of a model at zero angles, and the 26 parameters that they correspond to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from heyoka_bike.bicycle.foreign.foreign_bicycle import ForeignBicycle
from heyoka_bike.bicycle.foreign.xml_source import MP, Element
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.exact import Exact

Matrix = Any
"""A matrix of mpmath; a vector is a single column."""
Pose = tuple[Matrix, Matrix]
"""The position of an origin, and the rotation matrix of the axes."""

_DIGITS = 15  # decimal digits that survive rounding to binary64
_LENGTHS = ("w", "c", "xB", "zB", "xH", "zH")
"""Parameters that are differences of positions in the file, so their roundoff is relative to the
wheel base."""
_OFF = Fraction(1, 10**9)
"""Largest deviation that counts as rounding [m, kg m^2; dimensionless for unit vectors]."""


@dataclass
class Mass:
    """A mass with its centre and the inertia about the centre, along the axes of the model."""

    mass: Any
    centre: Matrix
    inertia: Matrix

    @classmethod
    def at(cls, pose: Pose, mass: Any, inertia: Matrix) -> Mass:
        """Construct a mass at the origin of a pose, from its inertia along the axes of the pose."""
        centre, axes = pose
        return cls(mass, centre, axes * inertia * axes.T)

    @classmethod
    def zero(cls, centre: Matrix) -> Mass:
        """Construct a mass of zero at a point, without inertia."""
        return cls(MP.zero, centre, MP.zeros(3))

    def joined(self, other: Mass) -> Mass:
        """Return one body with this mass and another."""
        total = self.mass + other.mass
        if not total:
            return self
        centre = (self.mass * self.centre + other.mass * other.centre) / total
        return Mass(total, centre, self.about(centre) + other.about(centre))

    def about(self, point: Matrix) -> Matrix:
        """Return the inertia about `point` instead of the centre of mass."""
        d = self.centre - point
        return self.inertia + self.mass * ((d.T * d)[0] * MP.eye(3) - d * d.T)


@dataclass
class Body:
    """A moving body, with the hinge that connects it to its parent; the base has none.

    Attributes
    ----------
    name
    mass : Mass
    parent
        Name of the parent body; empty for the base.
    point, axis
        Point and direction of the hinge.
    radius
        Radius of a round shape, if the body has one.
    element : Element
        The element of the file that defines the body.
    """

    name: str
    mass: Mass
    parent: str
    point: Matrix
    axis: Matrix
    radius: Any
    element: Element

    def error(self, message: str) -> InputError:
        """Return an `InputError` located at this body."""
        return self.element.error(f"{self.name}: {message}")


def vector(numbers: Sequence[Any]) -> Matrix:
    """Return a column vector."""
    return MP.matrix(list(numbers))


def tensor(xx: Any, yy: Any, zz: Any, xy: Any, xz: Any, yz: Any) -> Matrix:
    """Return a symmetric matrix."""
    return MP.matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def turn(axis: Matrix, angle: Any) -> Matrix:
    """Return the rotation about a unit vector."""
    x, y, z = axis
    k = MP.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return MP.eye(3) + MP.sin(angle) * k + (1 - MP.cos(angle)) * k * k


def turns(angles: Sequence[Any]) -> list[Matrix]:
    """Return the rotations about x, y and z by these angles."""
    return [turn(MP.eye(3)[:, i], angle) for i, angle in enumerate(angles)]


def rotation(scalar: Any, x: Any, y: Any, z: Any) -> Matrix:
    """Return the rotation matrix of a quaternion of any length; the unit matrix if it is zero."""
    along = [x, y, z]
    length = MP.norm(along)
    return turn(vector(along) / length, 2 * MP.atan2(length, scalar)) if length else MP.eye(3)


ORIGIN: Pose = vector([0, 0, 0]), MP.eye(3)
"""The pose of the model itself."""


def composed(outer: Pose, inner: Pose) -> Pose:
    """Convert a pose that is relative to `outer` to the axes in which `outer` is given."""
    place, axes = outer
    moved, turned = inner
    return place + axes * moved, axes * turned


def unit(v: Matrix, element: Element) -> Matrix:
    """Return the unit vector in the direction of `v`; a zero vector is an error in `element`."""
    length = MP.norm(v)
    if not length:
        raise element.error("found an axis of length zero, expected a direction")
    return v / length


def downward(gravity: Sequence[Any], element: Element) -> Any:
    """Return the magnitude of gravity, which must point down.

    Raises
    ------
    InputError
        Gravity does not point along -z.
    """
    x, y, z = gravity
    if x or y or z > 0:
        raise element.error("found gravity that does not point along -z, expected 0 0 -g")
    return -z


def parameters(bodies: Sequence[Body], gravity: Any, root: Element) -> ForeignBicycle:
    """Compute the parameters from a base B with the wheel R, and a fork H with the wheel F.

    The axes of the bicycle follow from its shape: z is up, the axle of the rear wheel points
    sideways, and the front wheel is forward.

    Raises
    ------
    InputError
        The bodies form another tree, the wheels do not stand on one level or are not parallel, or
        the steer axis leans sideways.
    """
    rear_wheel, base, fork, wheel = _roles(bodies, root)
    up = vector([0, 0, 1])
    left = rear_wheel.axis
    if abs(left[2]) > _OFF:
        raise rear_wheel.error(
            "found an axle that is not horizontal at zero angles, expected a horizontal axle"
        )
    ahead = vector([left[1], -left[0], 0]) / MP.norm(left)
    if ((wheel.point - rear_wheel.point).T * ahead)[0] < 0:
        left, ahead = -left, -ahead
    if MP.norm(_cross(wheel.axis, left)) > _OFF:
        raise wheel.error(
            "found an axle that is not parallel to the axle of the rear wheel at zero angles, "
            "expected parallel axles"
        )
    axes = MP.matrix([list(ahead), list(left), list(up)])
    rear, front = axes * rear_wheel.point, axes * wheel.point
    ground = rear[2] - rear_wheel.radius
    lifted = front[2] - wheel.radius - ground
    if abs(lifted) > _OFF:
        raise wheel.error(
            f"found the front wheel's lowest point {_say(lifted)} m above the rear wheel's at zero "
            "angles, expected both at the same height"
        )
    axis, pivot = axes * fork.axis, axes * fork.point
    axis = -axis if axis[2] > 0 else axis
    if abs(axis[1]) > _OFF or not axis[2]:
        raise fork.error(
            "found a steer axis that is horizontal or leans sideways, expected an axis in the "
            "plane of symmetry that is not horizontal"
        )
    foot = pivot[0] + axis[0] / axis[2] * (ground - pivot[2])
    found = ForeignBicycle()
    values = {
        "w": front[0] - rear[0], "c": foot - front[0], "lam": MP.atan2(axis[0], -axis[2]),
        "g": gravity,
    }  # fmt: skip
    middle = rear[1]
    for what, y in (("the front wheel", front[1]), ("the steer axis", pivot[1])):
        found.notes += _left_out(f"{what} is {{}} m off the plane of the rear wheel", y - middle)
    for letter, body, hub in (("R", rear_wheel, rear), ("F", wheel, front)):
        values |= _wheel(letter, body, hub, axes, found)
    for letter, body in (("B", base), ("H", fork)):
        values |= _frame(letter, body, axes, found, (rear[0], middle, ground))
    found.values = {
        symbol: _exact(x, values["w"] if symbol in _LENGTHS else 0) for symbol, x in values.items()
    }
    return found


def _roles(bodies: Sequence[Body], root: Element) -> tuple[Body, Body, Body, Body]:
    """Return the bodies that are the rear wheel, the base, the fork and the front wheel."""
    names = ", ".join(body.name for body in bodies)
    if len(bodies) != 4:
        raise root.error(
            f"found {len(bodies)} bodies that move ({names:.80}), expected 4: rear frame, rear "
            "wheel, fork and front wheel"
        )
    (base,) = (body for body in bodies if not body.parent)
    held = {body.name: [x for x in bodies if x.parent == body.name] for body in bodies}
    ends = sorted(held[base.name], key=lambda body: len(held[body.name]))
    if len(ends) != 2 or len(held[ends[1].name]) != 1:
        raise base.error(
            f"found the bodies {names:.80} joined in another way, expected a wheel and a fork on "
            "the frame, and a wheel on the fork"
        )
    rear, fork = ends
    (front,) = held[fork.name]
    for body in (rear, front):
        if body.radius is None:
            raise body.error(
                "found no radius of this wheel, expected a cylinder, sphere or ellipsoid as its "
                "shape"
            )
    return rear, base, fork, front


def _wheel(
    letter: str, body: Body, hub: Matrix, axes: Matrix, found: ForeignBicycle
) -> dict[str, Any]:
    centre, i = axes * body.mass.centre, axes * body.mass.inertia * axes.T
    found.notes += _left_out(
        f"the centre of mass of {body.name} is {{}} m off its hub", MP.norm(centre - hub)
    )
    found.notes += _left_out(
        f"the inertia of {body.name} differs by {{}} kg m^2 from that of a wheel",
        max(abs(i[0, 0] - i[2, 2]) / 2, abs(i[0, 1]), abs(i[0, 2]), abs(i[1, 2])),
    )
    return {
        f"r{letter}": body.radius, f"m{letter}": body.mass.mass,
        f"I{letter}xx": (i[0, 0] + i[2, 2]) / 2, f"I{letter}yy": i[1, 1],
    }  # fmt: skip


def _frame(
    letter: str, body: Body, axes: Matrix, found: ForeignBicycle, origin: Sequence[Any]
) -> dict[str, Any]:
    x, y, z = axes * body.mass.centre - vector(origin)
    i = axes * body.mass.inertia * axes.T
    found.notes += _left_out(
        f"the centre of mass of {body.name} is {{}} m off the plane of the rear wheel", y
    )
    for ij, value in (("xy", i[0, 1]), ("yz", i[1, 2])):
        found.notes += _left_out(f"the inertia of {body.name} has {ij} = {{}} kg m^2", value)
    return {
        f"x{letter}": x, f"z{letter}": -z, f"m{letter}": body.mass.mass,
        f"I{letter}xx": i[0, 0], f"I{letter}yy": i[1, 1], f"I{letter}zz": i[2, 2],
        f"I{letter}xz": -i[0, 2],
    }  # fmt: skip


def _left_out(what: str, value: Any) -> Iterator[str]:
    if abs(value) > _OFF:
        yield f"left out: {what.format(_say(value))}; no parameter of the bicycle describes this"


def _say(x: Any) -> str:
    return str(MP.nstr(x, 6))


def _exact(x: Any, scale: Any) -> Exact:
    """Round a value to 15 digits, of itself or of `scale` if that is larger."""
    size = max(abs(x), abs(scale))
    if not size:
        return Exact(Fraction(0))
    step = Fraction(10) ** (int(MP.floor(MP.log10(size))) + 1 - _DIGITS)
    return Exact(step * int(MP.nint(x * step.denominator / step.numerator)))


def _cross(u: Matrix, v: Matrix) -> Matrix:
    return vector([
        u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
    ])  # fmt: skip
