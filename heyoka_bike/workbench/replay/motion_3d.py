"""Compute the motion in space: angles, contact points and the rotation of the wheels.

The equations of motion contain neither position nor yaw; this module integrates both from the
state. The *ground frame* has x along the initial heading, y to the right, z down, and its origin at
the initial rear contact point.

The rates of yaw, track and wheels are those of `rates_of_integrals`. They are integrated by Gauss
quadrature over short steps between the requested times, with the yaw inside a step by collocation,
so the error is that of binary64. `Configuration` computes everything else.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.equations.outputs import yaw_rate
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import Configuration, track_speeds, wheel_rates
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import ReferenceManeuver

State = Callable[[Array], Mapping[str, Array]]
"""A function from ascending times [s] to the columns of `STATE` at them."""

STATE = ("roll_angle", "pitch", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""Columns that determine the motion, in their default definitions."""

# Number of quadrature nodes in a step, and maximum length of a step [s]. Shorter steps would change
# the positions in the benchmark's maneuvers by no more than roundoff.
_NODES_OF_QUADRATURE, _LONGEST_STEP = 12, 0.05


@dataclass(frozen=True, eq=False, slots=True)
class Place:
    """The position and heading at which a motion starts.

    Attributes
    ----------
    x, y
        Rear contact point [m].
    yaw
        Yaw angle [rad].
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Motion3D:
    """Positions [m] in the ground frame and angles [rad] of the bicycle at n times.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Times [s].
    roll, pitch, steer, yaw : ndarray, shape (n,)
        As the columns of these names; right positive, pitch nose up.
    rear_contact, front_contact : ndarray, shape (n, 3)
        Lowest points of the wheels.
    rear_wheel, front_wheel : ndarray, shape (n,)
        Angle by which a wheel has turned in frame or fork, about the y axis: forward is negative.
    rear_track : ndarray, shape (n,)
        Length of the rear wheel's track [m].
    """

    time: Array
    roll: Array
    pitch: Array
    steer: Array
    yaw: Array
    rear_contact: Array
    front_contact: Array
    rear_wheel: Array
    front_wheel: Array
    rear_track: Array


def reference_state(maneuver: ReferenceManeuver) -> State:
    """Return the state of a reference as a function of time."""
    return lambda t: maneuver.approximate(t, STATE)


def motion_3d(
    equations: Equations, state: State, time: Array, start: Place | None = None
) -> Motion3D:
    """Return the motion of the bicycle in the ground frame.

    Parameters
    ----------
    equations : Equations
        Equations of the bicycle in binary64, see `Equations.binary64`.
    state
        Smooth function of time; a rough one limits the accuracy of the positions.
    time : ndarray, shape (n,)
        Ascending times [s], at least one.
    start : Place
        Position at the first time; by default the origin.
    """
    place = Place() if start is None else start
    yaw, x, y, rear_wheel, front_wheel, track = _integrals(equations, state, time, place)
    here = _of_form(equations, state(time))
    roll, pitch, steer = here[:3]
    front_contact = Configuration.of(equations, [*here, yaw, x, y]).places()["front_contact"]
    return Motion3D(
        time=time, roll=roll, pitch=pitch, steer=steer, yaw=yaw,
        rear_contact=np.column_stack((x, y, np.zeros_like(x))),
        front_contact=np.column_stack(front_contact),
        rear_wheel=rear_wheel, front_wheel=front_wheel, rear_track=track,
    )  # fmt: skip


def _of_form(equations: Equations, values: Mapping[str, Array]) -> list[Array]:
    """Convert columns of `STATE` to the variables of the regular form, without the yaw."""
    k, (*others, speed) = equations.k, (values[name] for name in STATE)
    return [*others, speed / (k.length * k.rear.r)]


def _integrals(equations: Equations, state: State, time: Array, start: Place) -> list[Array]:
    """Integrate, to get yaw, rear contact x and y, wheel angles and length of the rear track."""
    fine, where = _with_steps(time)
    step = np.diff(fine)[:, None]
    nodes, weights, inside = _collocation()
    at = fine[:-1, None] + step * nodes
    k = equations.k
    o, u = equations.unfold(_of_form(equations, state(at.ravel())))
    turning = yaw_rate(o, u).reshape(at.shape)
    yaw = _summed(start.yaw, step * turning @ weights[:, None])
    yaw_inside = yaw[:-1, None] + step * (turning @ inside.T)
    rear_wheel, front_wheel, rear_rim, _ = (
        x.reshape(at.shape) for x in (*wheel_rates(k, u), *track_speeds(k, u))
    )
    rates = (
        (start.x, rear_rim * np.cos(yaw_inside)),
        (start.y, rear_rim * np.sin(yaw_inside)),
        (0.0, rear_wheel), (0.0, front_wheel), (0.0, rear_rim),
    )  # fmt: skip
    found = [yaw, *(_summed(first, step * rate @ weights[:, None]) for first, rate in rates)]
    return [x[where] for x in found]


def _with_steps(time: Array) -> tuple[Array, NDArray[np.intp]]:
    """Insert times into long gaps; return all times and the indices of the given ones."""
    counts = np.maximum(np.ceil(np.diff(time) / _LONGEST_STEP).astype(int), 1)
    parts = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(time[:-1], time[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, time[-1:]]), np.concatenate(([0], np.cumsum(counts)))


def _summed(first: float, steps: Array) -> Array:
    return first + np.concatenate(([0.0], np.cumsum(steps)))


def _collocation() -> tuple[Array, Array, Array]:
    """Return Gauss nodes and weights on 0..1, and weights of integrals from 0 to each node."""
    x, w = np.polynomial.legendre.leggauss(_NODES_OF_QUADRATURE)
    # `integrals` contains the integrals of the Legendre polynomials up to each node. `through`
    # converts values at the nodes to coefficients of the interpolating polynomial.
    degrees = np.arange(_NODES_OF_QUADRATURE)
    values = np.polynomial.legendre.legvander(x, _NODES_OF_QUADRATURE)
    integrals = np.empty((_NODES_OF_QUADRATURE, _NODES_OF_QUADRATURE))
    integrals[:, 0] = x + 1
    integrals[:, 1:] = (values[:, 2:] - values[:, :-2]) / (2 * degrees[1:] + 1)
    through = (2 * degrees[:, None] + 1) / 2 * values[:, :-1].T * w
    return (x + 1) / 2, w / 2, integrals @ through / 2
