"""The motion that the page of an atlas computes in a browser is that of the model."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, lateral_condition
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import Configuration, rates_of_integrals
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.workbench.atlas.data import FALLS
from heyoka_bike.workbench.atlas.page import page as atlas_motion
from heyoka_bike.workbench.atlas.page.page import (
    DIVISORS,
    MOTION_SCRIPT,
    OBSERVED,
    STATE,
    motion_source,
)
from heyoka_bike.workbench.atlas.store import load_atlas

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no node to run JavaScript with")

# The values result from a few hundred operations, some of which are differences. The limit is 1e4
# units of roundoff.
ROUNDOFF = 1e-12


def run(source, script, given):
    """Return the output of a script, which finds its input as ``given``."""
    text = f'"use strict";{source}\nconst given = {json.dumps(given)};\n{script}'
    done = subprocess.run([NODE, "-"], input=text, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def states():
    draw = np.random.default_rng(5).uniform
    angles, rates = draw(-0.5, 0.5, (40, 3)), draw(-2, 2, (40, 2))
    rest = (draw(1, 40, (40, 1)), draw(-3, 3, (40, 6)))
    return np.hstack([angles, rates, *rest])


@pytest.fixture(scope="module")
def right(bicycle, states):
    """Return rates and observed quantities from the model in NumPy, one row per state."""
    e, y = Equations.binary64(bicycle), states.T
    found, f = e.columns(y), forces(e, y)
    x, front_y, _ = Configuration.of(e, y).places()["front_contact"]
    o, _ = e.unfold(y)
    _, c1, c3 = lateral_condition(o)
    rates = [
        *e.rates_with_yaw(y), *rates_of_integrals(e, y), found["forward_speed_contact"],
        o.kappa, o.den, c3 * o.cb - c1 * o.sb,
    ]  # fmt: skip
    observed = [
        x, front_y, found["forward_speed"], found["potential_energy"], found["kinetic_energy"],
        f.rear.normal, f.front.normal,
    ]  # fmt: skip
    assert (len(rates), len(observed)) == (len(STATE) + DIVISORS, len(OBSERVED))
    return np.array(rates).T, np.array(observed).T


def difference(found, right):
    """Return the difference relative to the largest value of each quantity."""
    return np.abs(np.asarray(found, dtype=float) - right) / np.abs(right).max(axis=0)


EVALUATED = """
const at = (formulas, size) => given.map((y) => { const f = []; formulas(y, f); return f; });
console.log(JSON.stringify([at(rates), at(observe), at(floorGap)]));
"""


def test_rates_and_forces_are_those_of_the_equations(bicycle, states, right):
    rates, observed, gap = run(motion_source(bicycle), EVALUATED, states.tolist())
    assert difference(rates, right[0]).max() < ROUNDOFF
    assert difference(observed, right[1]).max() < ROUNDOFF
    e = Equations.binary64(bicycle)
    exact = front_contact_height(e.k, e.a, *states.T[:3])
    assert np.abs(np.array(gap)[:, 0] - exact).max() < 1e-15


def test_parameters_may_be_free(bicycle, states):
    free = ("w", "c", "lam", "zB", "IBxz", "rR", "mH", "g")
    other = bicycle.replace(
        **{x: Exact.parse(str(round(1.1 * float(bicycle[x]), 6))) for x in free}
    )
    given = {x: float(other[x]) for x in free}
    script = f"Object.assign(P, {json.dumps(given)}); {EVALUATED}"
    rates, observed, gap = run(motion_source(bicycle, free), script, states.tolist())
    e, y = Equations.binary64(other), states.T
    assert difference(np.array(rates)[:, :6], np.array(e.rates(y)).T).max() < ROUNDOFF
    front = forces(e, y).front.normal
    assert difference(np.array(observed)[:, -1], front).max() < ROUNDOFF
    exact = front_contact_height(e.k, e.a, *y[:3])
    assert np.abs(np.array(gap)[:, 0] - exact).max() < 1e-14


def test_a_wrong_sign_is_seen(bicycle, states, right):
    source = motion_source(bicycle)
    head, rates, tail = re.split(r"(const rates = .*?\n};)", source, maxsplit=1, flags=re.S)
    lines = rates.splitlines()
    signs = [i for i, line in enumerate(lines) if re.search(r" [-+] ", line)]
    assert len(signs) > 200
    for i in signs[:: len(signs) // 12]:
        sign = re.search(r" ([-+]) ", lines[i])[1]
        turned = lines[i].replace(f" {sign} ", " + " if sign == "-" else " - ", 1)
        broken = "\n".join([*lines[:i], turned, *lines[i + 1 :]])
        found = run(head + broken + tail, EVALUATED, states.tolist())[0]
        assert difference(found, right[0]).max() > 1e3 * ROUNDOFF


FOLLOWED = "console.log(JSON.stringify(given.map((start) => follow(start, 10))));"


def followed(bicycle, starts):
    return run(motion_source(bicycle) + MOTION_SCRIPT, FOLLOWED, starts)


def start(speed, roll_rate, **more):
    return {"roll": 0, "steer": 0, "steer_rate": 0, "speed": speed, "roll_rate": roll_rate, **more}


def test_maneuvers_are_those_of_the_reference(bicycle, maneuvers, reference):
    given = [start(float(m.speed), float(m.roll_rate)) for m in maneuvers]
    for number, motion in enumerate(followed(bicycle, given), start=1):
        columns = motion["columns"]
        time = np.linspace(0, 10, len(columns["roll"]))
        assert (len(time), motion["falls"]) == (501, False)
        pairs = {
            "roll": "roll_angle", "steer": "steer_angle", "speed": "forward_speed", "yaw": "yaw",
            "roll_rate": "roll_rate", "steer_rate": "steer_rate", "pitch": "pitch",
        }  # fmt: skip
        exact = reference[number].approximate(time, tuple(pairs.values()))
        for name, column in pairs.items():
            assert np.abs(columns[name] - exact[column]).max() < atlas_motion.ERROR
        whole = reference.motion[number].rows.hi
        for name in ("rear_contact_x", "rear_contact_y", "front_wheel_angle"):
            assert np.abs(columns[name] - whole[name][::2]).max() < 10 * atlas_motion.ERROR
        for name in ("rear_normal", "front_normal"):
            assert columns[name] == pytest.approx(whole[f"{name}_force"][::2], abs=1e-5)


def test_the_edge_of_falling_is_where_it_is(bicycle):
    # At 4.6 m/s, the basin boundary lies between the roll rates 2.46491144053243234304 and
    # 2.46491144053243234306 rad/s (docs/harder-tier.md).
    at = [2.464911, 2.464912]
    assert [m["falls"] for m in followed(bicycle, [start(4.6, w) for w in at])] == [False, True]


def test_a_motion_ends_where_the_equations_do(bicycle):
    # At a steer angle of about 80 degrees a divisor vanishes, and heyoka's steps stop there.
    (found,) = followed(bicycle, [start(4.863690887411336, 3.7550073139195383)])
    assert found["falls"]
    assert found["duration"] == pytest.approx(0.2)
    heyoka_stops = 0.215239023
    assert found["duration"] < heyoka_stops < found["duration"] + 0.02


def test_a_start_that_cannot_be_is_told(bicycle):
    found = followed(bicycle, [start(5, 0, steer=0.3, roll=-0.2), start(5, 0, roll=1.6)])
    assert found[0] is not None
    assert found[1] is None


@pytest.mark.proof
def test_replays_come_to_what_the_atlas_says(bicycle, request):
    pytest.importorskip("heyoka")
    pytest.importorskip("zarr")
    atlas = load_atlas(request.getfixturevalue("small_atlas"))
    found = atlas.variables
    (speeds, roll_rates) = (axis.values.tolist() for axis in atlas.axes)
    given = [
        (start(v, w), float(found["fate_time"][i, j]) + 1)
        for i, v in enumerate(speeds)
        for j, w in enumerate(roll_rates)
    ]
    script = "console.log(JSON.stringify(given.map(([start, end]) => follow(start, end))));"
    motions = run(motion_source(bicycle) + MOTION_SCRIPT, script, given)
    fates, times, leans = (found[n].ravel() for n in ("fate", "fate_time", "largest_lean"))
    assert (fates == FALLS).any()
    assert (fates != FALLS).any()
    for motion, fate, time, lean in zip(motions, fates, times, leans, strict=True):
        assert motion["falls"] == (fate == FALLS)
        if motion["falls"]:
            # The duration is the time of the last frame, and frames are 0.02 s apart. Both
            # computations stop when steps become short, at times that differ by up to 5 ms.
            assert -0.005 < time - motion["duration"] < 0.025
        else:
            # The tolerance is for a maximum between two frames that are 0.02 s apart, at
            # accelerations of about 10 rad/s^2.
            largest = max(map(abs, motion["columns"]["roll"]))
            assert largest == pytest.approx(lean, abs=1e-3)
