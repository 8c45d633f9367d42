"""The Newton-Euler oracle reproduces published accelerations and forces.

A wrong sign in the oracle changes each number by far more than the tolerance.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import flint
import pytest

from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle, read_maneuvers
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers
from oracles import multibody
from oracles.newton_euler import Motion, move, solve_pitch

BICYCLE = read_bicycle(benchmark_bicycle())
MANEUVERS = read_maneuvers(benchmark_maneuvers())
DIGITS = 40

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "nonlinear.json").read_text("utf-8"))
PRINTED = ANCHORS["basu_mandal_table_1"]
CONSISTENT = ANCHORS["basu_mandal_consistent"]
AT_START = ANCHORS["initial_accelerations"]["maneuvers"]
START = pytest.mark.parametrize("maneuver", range(3))
"""The three maneuvers of the benchmark."""


@pytest.fixture(autouse=True)
def _enough_digits() -> Iterator[None]:
    with flint.ctx.workprec(400):
        yield


def basu_mandal_state(bicycle: Bicycle = BICYCLE) -> Motion:
    """Return Basu-Mandal's state from its five independent numbers.

    The published axes are x backward and z up: yaw = -theta, roll = pi/2 - psi, pitch = pi - phi,
    steer = -psi_f, and wheel angles are -beta.
    """
    q, v = PRINTED["position"], PRINTED["velocity"]
    return move(
        bicycle,
        Exact(-Fraction(q["psi"]), Fraction(1, 2)),
        None,
        -Fraction(q["psi_f"]),
        roll_rate=-Fraction(v["psi"]),
        steer_rate=-Fraction(v["psi_f"]),
        rear_wheel_rate=-Fraction(v["beta_r"]),
        digits=DIGITS,
    )


def misses(motion: Motion, anchors: dict[str, Any]) -> dict[str, Any]:
    """Return distances from the published numbers, rounded up, by name."""
    m = motion
    (x, y, z), (xx, yy, zz) = m.rear_hub_velocity, m.rear_hub_acceleration
    found = {
        "position": {"phi": flint.arb.pi() - m.pitch, "z": -m.rear_hub_position[2]},
        "velocity": {
            "x": -x,
            "y": y,
            "z": -z,
            "theta": -m.yaw_rate,
            "psi": -m.roll_rate,
            "phi": -m.pitch_rate,
            "psi_f": -m.steer_rate,
            "beta_r": -m.rear_wheel_rate,
            "beta_f": -m.front_wheel_rate,
        },
        "acceleration": {
            "x": -xx,
            "y": yy,
            "z": -zz,
            "theta": -m.yaw_acc,
            "psi": -m.roll_acc,
            "phi": -m.pitch_acc,
            "psi_f": -m.steer_acc,
            "beta_r": -m.rear_wheel_acc,
            "beta_f": -m.front_wheel_acc,
        },
    }
    return {
        f"{part} {name}": distance(x, anchors[part][name])
        for part, numbers in found.items()
        for name, x in numbers.items()
        if name in anchors[part]
    }


def distance(found: Any, expected: str) -> Any:
    """Return an upper bound of the difference."""
    bound = abs(found - flint.arb(expected)).abs_upper()
    assert bound.is_finite()
    return bound


def at_start(maneuver: int, bicycle: Bicycle = BICYCLE) -> Motion:
    m = MANEUVERS[maneuver]
    return move(
        bicycle,
        m.roll,
        None,
        m.steer,
        roll_rate=m.roll_rate,
        steer_rate=m.steer_rate,
        speed=m.speed,
        digits=DIGITS,
    )


def start_misses(motion: Motion, maneuver: int) -> dict[str, Any]:
    names = ("yaw", "roll", "pitch", "rear_wheel", "steer", "front_wheel")
    return {x: distance(getattr(motion, f"{x}_acc"), AT_START[maneuver][x]) for x in names}


@pytest.mark.parametrize(
    ("anchors", "count", "tolerance"),
    [
        # These values were printed with 13 decimals from binary64 computations. Inputs and outputs
        # agree with each other to this accuracy.
        pytest.param(PRINTED, 20, "2e-12", id="as printed"),
        # In this case the printed state was corrected so that it satisfies the constraints, to at
        # least 24 decimals.
        pytest.param(CONSISTENT, 16, "1e-22", id="consistent"),
    ],
)
def test_the_state_of_basu_mandal(anchors: dict[str, Any], count: int, tolerance: str) -> None:
    found = misses(basu_mandal_state(), anchors)
    assert len(found) == count
    for name, miss in found.items():
        assert miss < flint.arb(tolerance), name


@START
def test_accelerations_at_the_start_of_a_maneuver(maneuver: int) -> None:
    for name, miss in start_misses(at_start(maneuver), maneuver).items():
        # The published values have at least 24 digits.
        assert miss < flint.arb("1e-23"), name


@START
def test_energies_at_the_start_of_a_maneuver(maneuver: int) -> None:
    motion, expected = at_start(maneuver), ANCHORS["initial_energies"]
    assert distance(motion.potential_energy, expected["potential"]) < flint.arb("1e-35")
    # The tolerance is half a unit of the last printed digit.
    assert distance(motion.kinetic_energy, expected["kinetic"][maneuver]) < flint.arb("5e-27")


def test_normal_forces_upright_at_rest() -> None:
    # These values are printed in SymBRiM, tests/test_bicycle/test_whipple_bicycle.py.
    motion = move(BICYCLE, 0, None, 0, roll_rate=0, steer_rate=0, speed=0, digits=DIGITS)
    rear, front = motion.rear_contact, motion.front_contact
    assert distance(rear.normal, "612.836470588236") < flint.arb("1e-12")
    assert distance(front.normal, "309.303529411765") < flint.arb("1e-12")

    # The lever rule about the rear contact point gives the normal forces as fractions.
    p = {symbol: x.rational for symbol, x in BICYCLE.values.items()}
    total = p["g"] * (p["mR"] + p["mB"] + p["mH"] + p["mF"])
    on_front = p["g"] * (p["mB"] * p["xB"] + p["mH"] * p["xH"] + p["mF"] * p["w"]) / p["w"]
    for force, exact in ((rear, total - on_front), (front, on_front)):
        expected = flint.arb(flint.fmpq(exact.numerator, exact.denominator))
        assert abs(force.normal - expected) < flint.arb("1e-30")
        assert abs(force.longitudinal) < flint.arb("1e-30")
        assert abs(force.lateral) < flint.arb("1e-30")


def test_a_pitch_that_does_not_exist_is_refused() -> None:
    # At this roll and steer the front wheel reaches below the floor at every pitch.
    with pytest.raises(ValueError, match="no pitch"):
        solve_pitch(BICYCLE, Fraction(3, 2), Fraction(3, 2), digits=20)


def opposite(symbol: str) -> Bicycle:
    return BICYCLE.replace(**{symbol: Exact(-BICYCLE[symbol].rational)})


def break_gyroscopic_torque(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(omega: Any, momentum: Any) -> Any:
        return momentum.cross(omega)

    monkeypatch.setattr(multibody, "gyroscopic_torque", wrong)


def break_moving_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(self: Any, velocities: Any) -> Any:
        omega = velocities[self.wheel].angular
        arm = multibody.to_rim(self.number, self.axle, self.radius)
        return omega.cross(omega.cross(arm))

    monkeypatch.setattr(multibody.Rolling, "rest", wrong)


def break_steer_bearing(monkeypatch: pytest.MonkeyPatch) -> None:
    right = multibody.SamePoint.rest

    def wrong(self: Any, velocities: Any) -> Any:
        rest = right(self, velocities)
        return [-x for x in rest] if self.name == "steer force" else rest

    monkeypatch.setattr(multibody.SamePoint, "rest", wrong)


@pytest.mark.parametrize(
    ("bicycle", "breakage"),
    [
        pytest.param(opposite("IBxz"), None, id="IBxz"),
        pytest.param(opposite("IHxz"), None, id="IHxz"),
        pytest.param(BICYCLE, break_gyroscopic_torque, id="gyroscopic torque"),
        pytest.param(BICYCLE, break_moving_contact, id="moving contact point"),
        pytest.param(BICYCLE, break_steer_bearing, id="steer bearing"),
    ],
)
def test_a_wrong_sign_misses_the_published_state(
    bicycle: Bicycle,
    breakage: Callable[[pytest.MonkeyPatch], None] | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if breakage is not None:
        breakage(monkeypatch)
    # A wrong sign causes an error of at least 1e10 times the tolerance above.
    assert max(misses(basu_mandal_state(bicycle), PRINTED).values()) > flint.arb("0.1")


@START
@pytest.mark.parametrize("symbol", ["IBxz", "IHxz"])
def test_a_wrong_inertia_misses_the_start_of_a_maneuver(maneuver: int, symbol: str) -> None:
    motion = at_start(maneuver, opposite(symbol))
    assert max(start_misses(motion, maneuver).values()) > flint.arb("0.01")
