"""The order of a fixed-step method from a single file, by the shape of its error.

The errors that methods of some order can make form a space of few dimensions (`elementary`,
`body_coordinates`). The file's error is fitted by each of these spaces, with one set of
coefficients for all maneuvers and columns, each column weighted by the inverse of what remains of
it. Maneuvers at different speeds pin the order: its terms grow with that power of the rates of
change. An order is claimed only if little remains, and much more with every other order.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import spread
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.diagnosis.numerical.body_coordinates import BodyCoordinates
from heyoka_bike.scoring.diagnosis.numerical.elementary import differentials
from heyoka_bike.scoring.diagnosis.numerical.variation import POSITIONS, VELOCITIES, Variations
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Report

# Rows of a maneuver that are fitted.
_FITTED = 501
# Errors below so many floors are those of the digits written.
_SHOWN = 10.0
# Reweighting has settled after these.
_ROUNDS = 8
# The slowest grid that still follows the fastest mode, which decays in 0.05 s [s].
_WIDEST = 0.02


@dataclass(frozen=True, slots=True)
class _Family:
    """Methods that share their spaces of errors.

    Attributes
    ----------
    says
        What they are.
    limits
        Part of the error that may remain, by order: less for spaces that fit more by themselves.
        What remains of true ones is the next order, some times h times the rates of change.
    clear
        How many times more must remain with every other order.
    keys
        Columns that are compared; all by default.
    """

    says: str
    limits: Mapping[int, float]
    clear: float
    keys: Sequence[str] = tuple(DEFINITIONS)


# What remains, measured (docs/how-diagnosis-works.md): of true orders 1e-4 to 0.17, of others and
# of adaptive integrators 0.28 and more.
_PLAIN = _Family("one-step or multistep", {1: 0.2, 2: 0.2, 3: 0.2, 4: 0.2}, 2.5)
# True ones up to 0.07; 13 terms of second order leave 0.07 of what they do not mean.
_PARTITIONED = _Family("partitioned, such as symplectic Euler,", {1: 0.1, 2: 0.04}, 2.0)
# Ten terms. Speed and energies are left out: constraints that drift spoil them.
_BODIES = _Family(
    "multibody", {1: 0.15, 2: 0.15, 3: 0.15}, 1.5, LATERAL
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Order:
    """An order that explains the error.

    Attributes
    ----------
    order
    method
        What kind of method, in words.
    constrained
        Whether it is one of coordinates with constraints.
    left
        Part of the error that remains, geometric mean over maneuvers and columns.
    others
        The same with each other order, by order.
    """

    order: int
    method: str
    constrained: bool
    left: float
    others: Mapping[int, float]


@dataclass(frozen=True, eq=False, slots=True)
class _Data:
    """Errors of a column at some rows."""

    number: int
    key: str
    name: str
    time: Array
    error: Array
    floor: float


def order_of(report: Report, reference: Reference) -> Order | None:
    """The order that the error's shape tells; None if it does not."""
    data = [_data(m.maneuver, c) for m in report.maneuvers for c in m.columns if _is_shown(c)]
    if len({d.number for d in data}) < 2:
        return None
    motion = Variations(reference)
    if np.max(motion.step) > _WIDEST:
        return None
    y, bodies = motion.states, BodyCoordinates(motion)
    families: Sequence[tuple[_Family, Callable[[int], list[Array]]]] = (
        (_PLAIN, lambda p: differentials(motion.slope, y, p + 1)),
        (_PARTITIONED, lambda p: differentials(motion.slope, y, p + 1, (POSITIONS, VELOCITIES))),
        (_BODIES, bodies.forces),
    )
    for family, forces in families:
        chosen = [d for d in data if d.key in family.keys]
        left = {p: _left(motion, motion.respond(forces(p)), chosen) for p in family.limits}
        order = min(left, key=left.__getitem__)
        best = left.pop(order)
        if best < family.limits[order] and min(left.values()) > family.clear * best:
            return Order(order, family.says, family is _BODIES, best, left)
    return None


def _is_shown(c: ColumnScore) -> bool:
    """Whether a column has an error that is not of its digits."""
    return c.values > 1 and rms(c.trace.error) > _SHOWN * (c.floor or 0.0)


def _data(number: int, c: ColumnScore) -> _Data:
    names = {d.definition: d.name for d in DEFINITIONS[c.key]}
    rows = spread(c.values, _FITTED)
    return _Data(
        number, c.key, names[c.as_understood.definition],
        c.trace.time[rows], c.trace.error[rows], c.floor or 0.0,
    )  # fmt: skip


def _left(motion: Variations, shapes: Array, data: Sequence[_Data]) -> float:
    """Part of the errors that remains when the shapes are fitted, geometric mean."""
    if not data:
        return 1.0
    fitted = [motion.at(shapes, d.number, d.name, d.time) for d in data]
    sizes = [rms(d.error) for d in data]
    # What remains is not trusted below the digits written, or a billionth of the error.
    least = [max(d.floor, 1e-9 * size) for d, size in zip(data, sizes, strict=True)]
    left = sizes
    for _ in range(_ROUNDS):
        left = _remaining(fitted, data, left, least)
    return float(np.exp(np.mean([np.log(a / b) for a, b in zip(left, sizes, strict=True)])))


def _remaining(
    fitted: Sequence[Array], data: Sequence[_Data], sizes: Sequence[float], least: Sequence[float]
) -> list[float]:
    """Sizes of what remains of each column, fitted with weights of the sizes before."""
    shapes = np.concatenate([x / size for x, size in zip(fitted, sizes, strict=True)])
    errors = np.concatenate([d.error / size for d, size in zip(data, sizes, strict=True)])
    scales = np.linalg.norm(shapes, axis=0)
    scales[scales == 0.0] = 1.0
    found = np.linalg.lstsq(shapes / scales, errors, rcond=1e-8)[0] / scales
    return [
        max(rms(d.error - x @ found), low) for d, x, low in zip(data, fitted, least, strict=True)
    ]
