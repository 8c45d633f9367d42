"""Where a force acts whose law is not known.

A stop, a kick, a gust, a controller: the size of such a force depends on anything, but it acts on
one body in one direction. So it changes the accelerations of roll, steer and speed in a ratio that
this place determines. Its size is fitted in each window of the run. A single size cannot make up
for three accelerations, unless the place is right.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.vectors import Vector
from heyoka_bike.scoring.diagnosis.programs.forces import Law, Moving
from heyoka_bike.scoring.ratios import AS_GOOD, CLEARLY

_X: Vector = (1.0, 0.0, 0.0)
_Y: Vector = (0.0, 1.0, 0.0)
_Z: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Load:
    """A force or torque that acts on one body or joint in one direction.

    Attributes
    ----------
    says
        The force or torque in messages.
    unit
        Unit of its size.
    law
        The force of size 1. Directions are the heading, to the right and down.
    """

    says: str
    unit: str
    law: Law


def _push(body: str, axis: Vector) -> Law:
    """Make a unit force at the centre of mass of a body."""
    return lambda _: {f"v_{body}": axis}


LOADS: Mapping[str, Load] = {
    "steer_axis": Load("a torque on the steer axis", "N m", lambda _: {"rates": _Y}),
    "rear_roll": Load("a torque that rolls the rear frame", "N m", lambda _: {"turn_B": _X}),
    "rear_yaw": Load("a vertical torque on the rear frame", "N m", lambda _: {"turn_B": _Z}),
    "front_roll": Load("a torque that rolls the fork or the front wheel", "N m",
                        lambda _: {"turn_H": _X}),
    "front_yaw": Load("a vertical torque on the fork or the front wheel", "N m",
                       lambda _: {"turn_H": _Z}),
    "rear_axle": Load("a torque between rear wheel and rear frame", "N m",
                       lambda _: {"spin_R": _Y}),
    "front_axle": Load("a torque between front wheel and fork", "N m", lambda _: {"spin_F": _Y}),
    "hub_forward": Load("a force along the heading at the rear hub", "N", lambda _: {"v_R": _X}),
    **{f"{name}_{way}": Load(f"{kind} at the centre of mass of the {body}", "N", _push(b, axis))
       for name, b, body in (("rear", "B", "rear frame"), ("front", "H", "fork"))
       for way, axis, kind in (("forward", _X, "a force along the heading"),
                               ("side", _Y, "a force to the side"),
                               ("vertical", _Z, "a vertical force"))},
    "ground_side": Load("a force along the ground's y axis at the centre of mass of the rear frame",
                         "N", lambda m: {"v_B": m.ground(_Y)}),
    "drag": Load("a force along the velocity of the rear frame's centre of mass", "N s/m",
                  lambda m: {"v_B": m.now["v_B"]}),
    "weight": Load("a vertical force on all bodies in proportion to their masses", "N/kg",
                    lambda m: {f"v_{b}": (0.0, 0.0, mass) for b, mass in m.masses.items()}),
}  # fmt: skip
"""The loads that are tried, by name."""


CONSTANT, TIME = "nothing", "time"
"""Values of `FittedLoad.varies_with` besides the variables of the state."""


@dataclass(frozen=True, slots=True)
class FittedLoad:
    """A load of any size that explains the residual.

    Attributes
    ----------
    load
        Key in `LOADS`.
    relief
        Factor by which the residual of the equation that falls least falls, a geometric mean over
        the maneuvers.
    size
        Largest size, with its sign, where it changes the accelerations [unit of the load].
    maneuver, time
        Where it has this size [s].
    varies_with
        `CONSTANT`; `TIME` if it is the same function of time in every maneuver; or the variable to
        which it is proportional, one of `forces.PLACE_IN_STATE`. Otherwise empty.
    coefficient
        The constant size, or the ratio of the size to the variable [SI]; otherwise 0.
    """

    load: str
    relief: float
    size: float
    maneuver: int
    time: float
    varies_with: str = ""
    coefficient: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Windows:
    """The residual in the windows of all maneuvers.

    Attributes
    ----------
    left : sequence of ndarray, shape (q, w)
        Residual accelerations of each maneuver in units of their sizes.
    floors : sequence of ndarray, shape (q, 1)
        Resolution limits of these.
    averages : callable
        Function from accelerations, shape (3, n), to their averages, in the same units as `left`.
    numbers : sequence of int
        Number of each maneuver.
    times : sequence of ndarray, shape (w,)
        Mean time of each window [s].
    variables : mapping of str to sequence of ndarray, shape (w,)
        Averages of the variables of `forces.PLACE_IN_STATE` in the windows.
    """

    left: Sequence[Array]
    floors: Sequence[Array]
    averages: Callable[[Array], Sequence[Array]]
    numbers: Sequence[int]
    times: Sequence[Array]
    variables: Mapping[str, Sequence[Array]]


def find_loads(moving: Moving, windows: Windows) -> tuple[FittedLoad, ...]:
    """Return the loads that explain the residual, with any size, the best first.

    Empty if the residual has fewer than three equations, because a free size and a free choice of
    the load then explain anything.
    """
    if any(len(x) < 3 for x in windows.left):
        return ()
    found = [_at(name, moving, windows) for name in LOADS]
    most = max(x.relief for x in found)
    near = [x for x in found if x.relief > max(CLEARLY, most / AS_GOOD)]
    return tuple(sorted(near, key=lambda x: -x.relief))


def _at(name: str, moving: Moving, windows: Windows) -> FittedLoad:
    """Fit the size of a load in every window."""
    unit = np.array([[1.0], [1.0], [float(moving.equations.k.length)]])
    added = moving.added(moving.powers(LOADS[name].law(moving)))
    each = windows.averages(np.array(np.broadcast_arrays(*added, moving.state[0])[:3]) * unit)
    sizes, weights, falls = [], [], []
    for left, by_unit, floor in zip(windows.left, each, windows.floors, strict=True):
        weight = np.maximum(np.sum(by_unit**2, axis=0), np.finfo(np.float64).tiny)
        size = np.sum(left * by_unit, axis=0) / weight
        before, after = (
            np.mean(x**2, axis=1, keepdims=True) for x in (left, left - size * by_unit)
        )
        falls.append(np.log((before + floor**2) / (after + floor**2)) / 2)
        sizes.append(size)
        weights.append(np.sqrt(weight))
    clear = list(map(_where_it_acts, sizes, weights))
    i = int(np.argmax([np.max(x) for x in clear]))
    w = int(np.argmax(clear[i]))
    variable, coefficient = _varies_with(sizes, weights, windows)
    return FittedLoad(
        name,
        float(np.exp(np.min(np.mean(falls, axis=0)))),
        float(sizes[i][w]),
        windows.numbers[i],
        float(windows.times[i][w]),
        variable,
        coefficient,
    )


def _where_it_acts(size: Array, weight: Array) -> Array:
    """Return the magnitude of a size; 0 where the load changes the accelerations little.

    There the size is uncertain.
    """
    effect = np.abs(size) * weight
    return np.where(effect * CLEARLY > np.max(effect), np.abs(size), 0.0)


def _varies_with(
    sizes: Sequence[Array], weights: Sequence[Array], windows: Windows
) -> tuple[str, float]:
    """Return what determines a size, and its ratio to this variable, see `FittedLoad`.

    The weights are the effects of size 1: where a force hardly acts, its size is uncertain.
    """
    size, weight = np.concatenate(sizes), np.concatenate(weights)

    def left_by(other: Array) -> float:
        return float(np.sqrt(np.mean((weight * (size - other)) ** 2)))

    def ratio_to(x: Array) -> float:
        square = float(np.sum((weight * x) ** 2))
        return float(np.sum(weight**2 * size * x)) / square if square else 0.0

    known = {CONSTANT: np.ones_like(size)}
    known |= {name: np.concatenate(x) for name, x in windows.variables.items()}
    ratios = {name: ratio_to(x) for name, x in known.items()}
    left = {name: left_by(ratios[name] * x) for name, x in known.items()}
    least = left_by(np.zeros_like(size)) / CLEARLY
    best = CONSTANT if left[CONSTANT] < least else min(left, key=left.__getitem__)
    if left[best] < least:
        return best, ratios[best]
    if len(sizes) > 1 and all(np.array_equal(t, windows.times[0]) for t in windows.times):
        squares = np.square(weights)
        common = np.sum(squares * sizes, axis=0) / np.sum(squares, axis=0)
        if left_by(np.tile(common, len(sizes))) < least:
            return TIME, 0.0
    return "", 0.0
