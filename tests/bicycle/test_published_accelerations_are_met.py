"""The nonlinear bicycle reproduces published accelerations, energies and geometry."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

from generators.on_the_floor import along, few_product_state, model, pitch_on_the_floor
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, unfold
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.bicycle.equations.outputs import energies, yaw_rate
from heyoka_bike.bicycle.parameters import read_maneuvers
from heyoka_bike.system.resources import benchmark_maneuvers

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "nonlinear.json").read_text("utf-8"))
BASU_MANDAL = ANCHORS["basu_mandal_table_1"]
CONSISTENT = ANCHORS["basu_mandal_consistent"]
MANEUVERS = range(3)
FORMS = pytest.mark.parametrize("form", [few_products, regular], ids=lambda form: form.__name__)


def _digits_apart(a, found, printed):
    """Return the difference in units of the last printed digit."""
    unit = Fraction(10) ** -len(printed.partition(".")[2])
    return abs(found - a.number(Fraction(printed))) / a.number(unit)


def _velocity(k, a, state, form):
    """Return velocities by name, in axes with z down; the state ends with the yaw."""
    o, u = unfold(k, a, state, is_regular=form is regular)
    yaw = state[6]
    s_yaw, c_yaw = a.sin(yaw), a.cos(yaw)
    # The hub moves with velocity v along the heading, and with r p along the axle. The axle tilts
    # as the bicycle leans.
    ahead, aside = k.length * u.v, k.length * k.rear.r * u.p
    contact = k.length * (u.v + k.rear.r * u.nu)
    return {
        "x": ahead * c_yaw - aside * o.cos_roll * s_yaw,
        "y": ahead * s_yaw + aside * o.cos_roll * c_yaw,
        "z": aside * o.sin_roll,
        "contact_x": contact * c_yaw,
        "contact_y": contact * s_yaw,
        "yaw": yaw_rate(o, u),
        "roll": u.p,
        "pitch": u.q - u.nu,
        "steer": u.steer_rate,
        "rear_wheel": -u.v / k.rear.r - u.q,
        "front_wheel": -u.v_f / k.front.r - u.q_f,
    }


def _accelerations(k, a, state, form):
    """Return velocities, and accelerations as derivatives of the velocities along the motion."""
    if form is few_products:
        state = few_product_state(k, a, state[:6]) + state[6:]
    velocity = _velocity(k, a, state, form)
    rates = [*form(k, a, state[:6]), velocity["yaw"]]
    second = along(a, rates, state, lambda s: list(_velocity(k, a, s, form).values()))
    return velocity, dict(zip(velocity, second, strict=True)), rates


def _start(k, a, maneuver):
    m = read_maneuvers(benchmark_maneuvers())[maneuver]
    zero = a.context.zero
    return [zero, zero, zero, a.number(m.roll_rate), zero, a.number(m.speed) / k.length, zero]


@FORMS
@pytest.mark.parametrize("maneuver", MANEUVERS)
def test_accelerations_at_the_start_of_a_maneuver(form, maneuver):
    k, a = model()
    expected = ANCHORS["initial_accelerations"]["maneuvers"][maneuver]
    start = _start(k, a, maneuver)
    assert start[3] == a.number(Fraction(expected["roll_rate"]))
    assert abs(start[5] * k.length - a.number(Fraction(expected["speed"]))) < 1e-100
    _, found, _ = _accelerations(k, a, start, form)
    for name in ("yaw", "roll", "pitch", "steer", "rear_wheel", "front_wheel"):
        number = a.number(Fraction(expected[name]))
        # The published numbers have at least 24 digits.
        assert abs(found[name] - number) < a.context.mpf("1e-24") * max(1, abs(number)), name


@FORMS
def test_accelerations_of_roll_and_steer_are_those_of_the_derivatives_along_the_motion(form):
    """The regular form contains these accelerations directly."""
    k, a = model()
    _, second, _ = _accelerations(k, a, _start(k, a, 1), form)
    rates = regular(k, a, _start(k, a, 1)[:6])
    # Difference quotients have an error of 1e-70 times the third derivative (see
    # on_the_floor.STEP).
    assert abs(second["roll"] - rates[3]) < a.context.mpf("1e-65")
    assert abs(second["steer"] - rates[4]) < a.context.mpf("1e-65")


@pytest.mark.parametrize("maneuver", MANEUVERS)
def test_energies_at_the_start_of_a_maneuver(maneuver):
    k, a = model()
    e = energies(k, *unfold(k, a, _start(k, a, maneuver), is_regular=True))
    expected = ANCHORS["initial_energies"]
    # The tolerance is half a unit of the last printed digit. The potential energy is exact as
    # printed.
    assert abs(e.potential - a.number(Fraction(expected["potential"]))) < 1e-100
    assert _digits_apart(a, e.kinetic, expected["kinetic"][maneuver]) <= 0.5
    assert _digits_apart(a, e.potential + e.kinetic, expected["total"][maneuver]) <= 0.5


def _basu_mandal(form):
    """Return Basu-Mandal's state from five independent numbers, as values by name."""
    k, a = model()
    mp = a.context
    q, v = BASU_MANDAL["position"], BASU_MANDAL["velocity"]
    roll, steer = mp.pi / 2 - mp.mpf(q["psi"]), -mp.mpf(q["psi_f"])
    pitch = pitch_on_the_floor(k, a, roll, steer)
    roll_rate, steer_rate = -mp.mpf(v["psi"]), -mp.mpf(v["psi_f"])

    def state(spin):
        return [roll, pitch, steer, roll_rate, steer_rate, spin, mp.zero]

    # The wheel's rate relative to the frame is a linear function of the spin, so two evaluations
    # determine the spin.
    at0, at1 = (_velocity(k, a, state(mp.mpf(x)), regular)["rear_wheel"] for x in (0, 1))
    spin = (-mp.mpf(v["beta_r"]) - at0) / (at1 - at0)
    velocity, acceleration, rates = _accelerations(k, a, state(spin), form)
    assert abs(front_contact_height(k, a, roll, pitch, steer)) < 1e-100
    position = {"phi": mp.pi - pitch, "z": k.length * k.rear.r * mp.cos(roll)}
    return a, position, velocity, acceleration, rates


THEIRS = {
    "x": ("x", -1),
    "y": ("y", 1),
    "z": ("z", -1),
    "theta": ("yaw", -1),
    "psi": ("roll", -1),
    "phi": ("pitch", -1),
    "psi_f": ("steer", -1),
    "beta_r": ("rear_wheel", -1),
    "beta_f": ("front_wheel", -1),
}
"""Names of the published quantities in the package, and their signs."""


@FORMS
@pytest.mark.parametrize(
    ("anchors", "tolerance"),
    [
        # These values were printed with 13 decimals from binary64 computations. The outputs are
        # consistent with the printed inputs to this accuracy.
        pytest.param(BASU_MANDAL, "2e-12", id="as printed"),
        # These values have at least 24 decimals, the last one rounded.
        pytest.param(CONSISTENT, "1e-24", id="consistent"),
    ],
)
def test_the_state_of_basu_mandal(form, anchors, tolerance):
    a, position, velocity, acceleration, rates = _basu_mandal(form)
    mp = a.context
    limit = mp.mpf(tolerance)
    for name in position.keys() & anchors["position"].keys():
        assert abs(position[name] - mp.mpf(anchors["position"][name])) < limit, name
    for values, part in ((velocity, "velocity"), (acceleration, "acceleration")):
        for name, number in anchors[part].items():
            ours, sign = THEIRS[name]
            assert abs(sign * values[ours] - mp.mpf(number)) < limit, (part, name)
    if form is regular:
        assert abs(-rates[3] - mp.mpf(anchors["acceleration"]["psi"])) < limit
        assert abs(-rates[4] - mp.mpf(anchors["acceleration"]["psi_f"])) < limit


@FORMS
def test_the_accelerations_of_symbrim(form):
    a, _, _, acceleration, _ = _basu_mandal(form)
    for name, number in ANCHORS["symbrim"]["acceleration"].items():
        # The published values were computed in binary64 from a state that was printed with 13
        # decimals, including its dependent values. An error of 5e-14 in the state is multiplied by
        # derivatives of up to 20.
        assert abs(acceleration[name] - a.context.mpf(number)) < 1e-12, name


def test_the_steer_axis_point():
    k, a = model()
    mp = a.context
    sin, cos = a.sin(k.tilt), a.cos(k.tilt)
    anchors = ANCHORS["steer_axis_point"]

    def point(which):
        return mp.mpf(anchors[which]["x"]), mp.mpf(anchors[which]["z"])

    def off_axis(x, z):
        """Return the distance from the axis; the hub is d1 behind it, at its radius's height."""
        return (x * cos - (z + k.length * k.rear.r) * sin) - k.length * k.d1

    x, z = point("exact")
    # The coordinates are printed with 20 and 19 decimals.
    assert abs(off_axis(x, z)) < 1e-20
    ground = mp.mpf("1.02") + mp.mpf("0.08")
    assert abs(x - (ground - sin * 9 / 10)) < 5e-20
    assert abs(z + cos * 9 / 10) < 5e-20
    # The benchmark's text truncates both coordinates after eleven decimals. This moves the point by
    # 4.2e-12 m from the axis and by 4.4e-12 m along x.
    x11, z11 = point("printed")
    assert (int(x11 * 10**11), int(z11 * 10**11)) == (int(x * 10**11), int(z * 10**11))
    assert mp.nstr(abs(off_axis(x11, z11)), 2) == "4.2e-12"
    assert mp.nstr(abs(off_axis(x11, z11)) / cos, 2) == "4.4e-12"
