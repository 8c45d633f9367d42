"""The whole motion along the published candidates satisfies independent checks of mechanics.

The checks are on rolling, power and quadrature. Velocities and rates of change are central
differences of positions and energies over 1e-25 s, in 330 bits. They share nothing with the dual
numbers and the moment balances of `forces`.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

import flint
import numpy as np
import pytest

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, motion_columns
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.motion.trajectory import Certificate, Stretch, Trajectory, evaluator
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof.dense import with_integrals
from oracles.multibody import to_rim
from oracles.vectors import Balls as OracleBalls
from oracles.vectors import Matrix, Vector
from support.tiers import ONE_MANEUVER

BITS = 330
STEP = Fraction(1, 10**25)
TIMES = 12
# The error of a central difference is STEP^2 times a third derivative of about 1e5. The rate of an
# energy also contains the candidate's error of 1e-70, divided by STEP.
SMALL = "1e-38"


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS):
        yield


@pytest.fixture(scope="module", params=ONE_MANEUVER)
def run(request: pytest.FixtureRequest, candidate: tuple[Trajectory, ...]) -> Trajectory:
    return candidate[request.param - 1]


@pytest.fixture(scope="module")
def stretches(run: Trajectory) -> list[Stretch]:
    """Return the candidate as exact segments, without widening."""
    none = ((Fraction(0),) * 7,) * run.steps
    return list(with_integrals(run, Certificate(run.states, none, none[0])))


class At:
    """All columns at any time, from the polynomials."""

    def __init__(self, run: Trajectory, stretches: Sequence[Stretch]) -> None:
        self.run, self.stretches = run, stretches
        self.balls = Balls(BITS)
        self.equations = Equations.of(run.bicycle, self.balls, is_regular=run.is_regular)

    def state(self, t: Fraction) -> list[flint.arb]:
        piece = next(s.piece for s in reversed(self.stretches) if s.piece.t0 <= t)
        s = (t - piece.t0) / piece.h
        x = flint.arb(flint.fmpq(s.numerator, s.denominator))
        unit = flint.arb(2) ** -piece.grid
        return [flint.arb_poly(list(row))(x) * unit for row in piece.rows]

    def __call__(self, t: Fraction) -> dict[str, Any]:
        return motion_columns(self.equations, self.state(t))


def times(run: Trajectory) -> list[Fraction]:
    rng = random.Random(run.maneuver.name)
    return [Fraction(rng.randrange(10**4, 999 * 10**4), 10**6) for _ in range(TIMES)]


def vector(at: dict[str, Any], name: str, axes: str = "xyz") -> Vector:
    return Vector([at.get(f"{name}_{x}", flint.arb(0)) for x in axes])


def attitude(at: dict[str, Any], end: str) -> Matrix:
    """Return the rotation from the axes of a frame to the ground, by rows."""
    return Matrix(tuple(Vector([at[f"{end}_frame_r{i}{j}"] for j in (1, 2, 3)]) for i in (1, 2, 3)))


def change(at: At, t: Fraction, name: str) -> Vector:
    """Return the velocity of a point."""
    after, before = (vector(at(t + side * STEP), name) for side in (1, -1))
    return (flint.arb(STEP.denominator) / 2) * (after - before)


def omega(at: dict[str, Any], body: str) -> Vector:
    """Return the angular velocity of a body in the ground frame."""
    end = body.split("_")[0]
    turning = vector(at, f"{end}_frame_omega")
    if body.endswith("wheel"):
        turning = Vector([turning[0], at[f"{end}_wheel_omega_y"], turning[2]])
    return attitude(at, end)(turning)


def small(x: Any, scale: float = 1.0) -> bool:
    return bool(abs(x) < flint.arb(SMALL) * scale)


@pytest.mark.parametrize("end", ["rear", "front"])
def test_the_lowest_point_of_a_wheel_is_at_rest(
    run: Trajectory, stretches: list[Stretch], end: str
) -> None:
    at, number = At(run, stretches), OracleBalls(80)
    radius = at.balls.number(run.bicycle["rR" if end == "rear" else "rF"])
    for t in times(run):
        now = at(t)
        axle = attitude(now, end)(Vector([flint.arb(x) for x in (0, 1, 0)]))
        arm = to_rim(number, axle, radius)
        slip = change(at, t, f"{end}_hub") + omega(now, f"{end}_wheel").cross(arm)
        assert all(small(x, 10) for x in slip), float(t)
        # The contact point moves along the heading of its wheel, so it does not move along the
        # axle.
        assert small(change(at, t, f"{end}_contact").dot(axle), 10), float(t)
        turned = at(t + STEP)[f"{end}_wheel_angle"] - at(t - STEP)[f"{end}_wheel_angle"]
        rate = now[f"{end}_wheel_omega_y"] - now[f"{end}_frame_omega_y"]
        assert small(turned * STEP.denominator / 2 - rate, 100), float(t)


def body_energy(at: dict[str, Any], velocity: Vector, bicycle: Bicycle, letter: str) -> Any:
    """Return kinetic and potential energy of one body [J], from parameters alone."""
    p = {symbol: number_of(x) for symbol, x in bicycle.values.items()}
    end = "rear" if letter in "RB" else "front"
    wheel = letter in "RF"
    turning = vector(at, f"{end}_frame_omega")
    x, y, z = turning
    xx = p[f"I{letter}xx"]
    if wheel:
        y = at[f"{end}_wheel_omega_y"]
        spin = xx * x * x + p[f"I{letter}yy"] * y * y + xx * z * z
    else:
        spin = xx * x * x + p[f"I{letter}yy"] * y * y + p[f"I{letter}zz"] * z * z
        spin += 2 * p[f"I{letter}xz"] * x * z
    height = at[f"{end}_hub_z" if wheel else f"{end}_frame_com_z"]
    mass = p[f"m{letter}"]
    return (mass * velocity.dot(velocity) + spin) / 2 - mass * p["g"] * height


def number_of(x: Exact) -> flint.arb:
    return Balls(BITS).number(x)


CENTRE = {"R": "rear_hub", "B": "rear_frame_com", "H": "front_frame_com", "F": "front_hub"}


def gains(at: At, t: Fraction, letter: str) -> Any:
    """Return the rate of change of the energy of a body."""
    after, before = (
        body_energy(at(x), change(at, x, CENTRE[letter]), at.run.bicycle, letter)
        for x in (t + STEP, t - STEP)
    )
    return (after - before) * STEP.denominator / 2


def power(at: At, t: Fraction, letter: str) -> Any:
    """Return the joints' power on a body; the floor does no work on a wheel without slip."""
    now = at(t)
    rear, front = attitude(now, "rear"), attitude(now, "front")
    hub, hub_f = change(at, t, "rear_hub"), change(at, t, "front_hub")
    axle, axle_f = rear(vector(now, "rear_axle_force")), front(vector(now, "front_axle_force"))
    turn, turn_f = rear(vector(now, "rear_axle_moment")), front(vector(now, "front_axle_moment"))
    if letter == "R":
        return axle.dot(hub) + turn.dot(omega(now, "rear_wheel"))
    if letter == "F":
        return axle_f.dot(hub_f) + turn_f.dot(omega(now, "front_wheel"))
    # The steer bearing acts at the pivot. In the axes of the fork, the pivot is at (c, 0, rF) from
    # the front hub.
    p = {symbol: number_of(x) for symbol, x in at.run.bicycle.values.items()}
    tilt = p["lam"]
    ahead = front(Vector([tilt.cos(), flint.arb(0), -tilt.sin()]))
    down = front(Vector([tilt.sin(), flint.arb(0), tilt.cos()]))
    right = front(Vector([flint.arb(x) for x in (0, 1, 0)]))
    f, m = vector(now, "steer_joint_force"), vector(now, "steer_joint_moment")
    force = f[0] * ahead + f[1] * right + f[2] * down
    moment = m[0] * ahead + m[1] * right
    w, w_f = omega(now, "rear_frame"), omega(now, "front_frame")
    pivot = hub_f + w_f.cross(front(Vector([p["c"], flint.arb(0), p["rF"]])))
    if letter == "H":
        return (force.dot(pivot) + moment.dot(w_f)) - axle_f.dot(hub_f) - turn_f.dot(w_f)
    return -force.dot(pivot) - moment.dot(w) - axle.dot(hub) - turn.dot(w)


@pytest.mark.parametrize("letter", ["R", "B", "H", "F"])
def test_each_body_gains_the_energy_that_its_joints_give(
    run: Trajectory, stretches: list[Stretch], letter: str
) -> None:
    at = At(run, stretches)
    for t in times(run)[:6]:
        assert small(gains(at, t, letter) - power(at, t, letter), 1e6), float(t)


def test_quadrature_by_gauss_gives_the_same_places(
    run: Trajectory, stretches: list[Stretch]
) -> None:
    """Integrate the columns of the reference piece by piece with 70 nodes."""
    nodes = 70
    pairs = [flint.arb.legendre_p_root(nodes, i, weight=True) for i in range(nodes)]
    at = evaluator(run, BITS)
    radius, k = number_of(run.bicycle["rR"]), at.equations.k
    totals = [flint.arb(0)] * len(INTEGRALS)
    for i in range(run.steps):
        piece = run.piece(i)
        h = flint.arb(flint.fmpq(piece.h.numerator, piece.h.denominator))
        t0 = flint.arb(flint.fmpq(piece.t0.numerator, piece.t0.denominator))
        for x, weight in pairs:
            state = run.state(t0 + h * (x + 1) / 2, i)
            c = at.equations.columns(state)
            _, u = unfold(k, at.balls, state, is_regular=run.is_regular)
            yaw, speed = c["yaw"], c["forward_speed_contact"]
            rates = (
                speed * yaw.cos(), speed * yaw.sin(), -c["forward_speed_wheel_spin"] / radius,
                -(u.v_f / k.front.r + u.q_f),
            )  # fmt: skip
            totals = [y + weight * h / 2 * r for y, r in zip(totals, rates, strict=True)]
    found = At(run, stretches).state(run.breaks[-1])[7:]
    for name, x, y in zip(INTEGRALS, found, totals, strict=True):
        assert abs(x - y) < flint.arb("1e-68"), name


@pytest.mark.proof
def test_bounds_grow_with_what_is_not_known(candidate: tuple[Trajectory, ...]) -> None:
    """A state with an error of 1e-30 gives positions with errors some hundred times larger."""
    run = candidate[2]
    loose = ((Fraction(1, 10**30),) * 7,) * run.steps
    *_, last = with_integrals(run, Certificate(run.states, loose, loose[0]))
    for bound in last.bounds[7:]:
        assert 1e-30 < bound < 1e-23


@pytest.mark.proof
def test_normal_forces_at_rest_are_those_of_the_lever_rule(bicycle: Bicycle) -> None:
    balls = Balls(BITS)
    rest = forces(Equations.of(bicycle, balls), [balls.number(0)] * 6)
    p = {symbol: x.rational for symbol, x in bicycle.values.items()}
    total = p["g"] * (p["mR"] + p["mB"] + p["mH"] + p["mF"])
    on_front = p["g"] * (p["mB"] * p["xB"] + p["mH"] * p["xH"] + p["mF"] * p["w"]) / p["w"]
    for contact, exact, printed in (
        (rest.rear, total - on_front, "612.836470588235"),
        (rest.front, on_front, "309.303529411765"),
    ):
        assert abs(contact.normal - balls.number(exact)) < flint.arb("1e-80")
        assert contact.normal.str(15, radius=False) == printed
        for x in (contact.longitudinal, contact.lateral):
            assert abs(x) < flint.arb("1e-80")
    # The rear axle carries the force of the floor on the wheel less the wheel's weight. No bearing
    # transmits a moment about its own axis.
    assert abs(rest.rear_axle.force[2] - balls.number(total - on_front - p["mR"] * p["g"])) < 1e-60
    for free in (rest.rear_axle.moment[1], rest.front_axle.moment[1], rest.steer.moment[2]):
        assert abs(free) < flint.arb("1e-80")


def test_numpy_arrays_give_the_same_forces(
    run: Trajectory, stretches: list[Stretch], bicycle: Bicycle
) -> None:
    at = At(run, stretches)
    moments = times(run)
    states = [at.state(t)[:6] for t in moments]
    state = [np.array([float(s[j].mid()) for s in states]) for j in range(6)]
    found = forces(Equations.binary64(bicycle, is_regular=run.is_regular), state)
    for i, t in enumerate(moments):
        exact = at(t)
        for end, contact in (("rear", found.rear), ("front", found.front)):
            for name in ("normal", "longitudinal", "lateral"):
                x = float(exact[f"{end}_{name}_force"].mid())
                # In binary64, a weight of 922 N has 15 digits.
                assert abs(getattr(contact, name)[i] - x) < 1e-11
