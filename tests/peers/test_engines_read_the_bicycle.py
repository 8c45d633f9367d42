"""Engines load the exported models, and represent the bicycle before it moves."""

import re
from functools import partial

import numpy as np
import pytest

from heyoka_bike import check
from heyoka_bike.bicycle.instant_columns import LEVELS
from heyoka_bike.bicycle.parameters import read_bicycle, read_maneuvers
from heyoka_bike.cli import main
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.exports.models import MODELS, refused, render
from heyoka_bike.system.resources import find_input
from support import engines
from support.engines import ENGINES, apart, need, printed
from support.model_files import posed

pytestmark = [pytest.mark.peers, pytest.mark.timeout(600)]

STATES = read_maneuvers(find_input("maneuvers", "states"))[5:105:5]
# Largest differences for DART and for all other engines, relative to 1 + the value or to the size
# of the matrix.
BOUNDS = {"dart": 1e-11}
BOUND = 2e-13
# Larger limits for two groups of quantities. Solving their 15 equations with masses from 2 to 94 kg
# causes more roundoff.
SOLVED = {"accelerations": 1e-12, "forces": 2e-12}


@pytest.fixture
def exported(tmp_path):
    """Write a bicycle for an engine."""

    def write(name, bicycle, maneuvers=(), kind=None):
        format_of = kind or ENGINES[name][2]
        path = tmp_path / f"bicycle{MODELS[format_of].suffix}"
        path.write_bytes(render(format_of, bicycle, maneuvers))
        return path

    return write


@pytest.fixture
def states(tmp_path):
    path = tmp_path / "states.csv"
    assert main(["check", "--states", str(path)]) == 0
    return path


def checked(name, file, states, folder):
    """Return the output of `check` for the table that a program writes."""
    table = folder / "table.csv"
    table.write_text(printed(name, "check", file, states), encoding="ascii")
    return check(table)


@pytest.mark.parametrize("name", ENGINES)
def test_every_quantity_is_right(name, exported, states, bicycle, tmp_path):
    need(name)
    found = checked(name, exported(name, bicycle), states, tmp_path)
    assert found.passed
    there = {level.level.name: level for level in found.levels if level.columns}
    assert list(there) == [level.name for level in LEVELS[:-1]]
    for label, level in there.items():
        bound = max(BOUNDS.get(name, BOUND), SOLVED.get(label, 0))
        worst = max(c.max_error for c in level.columns)
        print(f"{name} {level.level.name}: {worst:.1e}")
        assert worst < bound


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("other", ["benchmark", "pista"])
def test_mass_matrix_of_the_free_tree_is_right(name, other, exported):
    need(name)
    bicycle = read_bicycle(find_input("bicycles", other))
    there = [posed(bicycle, state) for state in STATES]
    postures = [(p.place, p.quaternion, p.angles) for p in there]
    found = apart(engines.mass_matrices, name, exported(name, bicycle), postures)
    worst = 0.0
    for p, matrix in zip(there, found, strict=True):
        expected = p.expected()
        turned = p.per_rate.T @ matrix @ p.per_rate
        worst = max(worst, np.abs(turned - expected).max() / np.abs(expected).max())
    print(f"{name}, {other}: mass matrix within {worst:.1e}")
    assert worst < BOUNDS.get(name, BOUND)


def turned_over(bicycle):
    """The products of inertia have the other sign."""
    return bicycle.replace(IBxz=-bicycle["IBxz"])


def wheel_twice(bicycle):
    """The rear frame includes its wheel, which also exists separately."""
    p = {symbol: value.rational for symbol, value in bicycle.values.items() if symbol != "lam"}
    mass = p["mB"] + p["mR"]
    x, z = p["mB"] * p["xB"] / mass, (p["mB"] * p["zB"] - p["mR"] * p["rR"]) / mass
    found = {"mB": mass, "xB": x, "zB": z}
    wheel = {"xx": p["IRxx"], "yy": p["IRyy"], "zz": p["IRxx"], "xz": 0}
    places = ((p["mB"], p["xB"] - x, p["zB"] - z), (p["mR"], -x, -p["rR"] - z))
    steiner = {
        "xx": sum(m * dz * dz for m, _, dz in places),
        "zz": sum(m * dx * dx for m, dx, _ in places),
        "xz": -sum(m * dx * dz for m, dx, dz in places),
    }
    steiner["yy"] = steiner["xx"] + steiner["zz"]
    found |= {f"IB{ij}": p[f"IB{ij}"] + wheel[ij] + steiner[ij] for ij in wheel}
    return bicycle.replace(**{symbol: Exact(value) for symbol, value in found.items()})


def axis_forward(bicycle):
    """The steer axis leans forward."""
    return bicycle.replace(lam=-bicycle["lam"])


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize(
    ("mistake", "level"),
    [(turned_over, "energy"), (wheel_twice, "positions"), (axis_forward, "geometry")],
)
def test_a_mistake_is_found_at_its_level(name, mistake, level, exported, states, bicycle, tmp_path):
    need(name)
    found = checked(name, exported(name, mistake(bicycle)), states, tmp_path)
    assert not found.passed
    assert found.failed.level.name == level


# Tests of silent changes and rejections by engines, as listed in docs/how-to/engines.md


def test_mujoco_welds_the_base_of_a_urdf_to_the_ground(exported, bicycle):
    need("mujoco")
    freedoms, masses = apart(engines.mujoco_of_urdf, exported("mujoco", bicycle, kind="urdf"))
    assert (freedoms, sum(masses)) == (3, 9)


def test_pinocchio_without_a_free_joint_has_no_rear_frame(exported, bicycle):
    need("pinocchio")
    found = apart(engines.pinocchio_without_a_free_joint, exported("pinocchio", bicycle))
    assert found == (3, 9)


def test_drake_has_a_gravity_of_its_own(exported, bicycle):
    need("drake")
    light = bicycle.replace(g=Exact.parse("1.62"))
    assert apart(engines.drake_gravity, exported("drake", light)) == [0, 0, -9.81]


def test_dart_takes_small_angles_for_their_sines():
    need("dart")
    assert apart(engines.dart_sine, 5e-4) == 5e-4
    assert apart(engines.dart_sine, 2e-3) == np.sin(2e-3)


def test_dart_reads_no_mjcf_with_settings(exported, bicycle):
    """Without the settings DART would read the file, and fix the base to the ground."""
    need("dart")
    assert not apart(engines.dart_reads_mjcf, exported("dart", bicycle, kind="mjcf"))


def test_dart_leaves_out_the_ellipsoids_of_urdf(exported, bicycle):
    need("dart")
    file = exported("dart", bicycle, kind="urdf")
    assert apart(engines.dart_wheel_shapes_of_urdf, file) == (2, True)
    text = file.read_text(encoding="ascii")
    cylinder = "(<collision>.*?)<cylinder [^>]*/>"
    ellipsoid = r'\1<ellipsoid radii="0.3 0.001 0.3"/>'
    changed, count = re.subn(cylinder, ellipsoid, text, flags=re.DOTALL)
    assert count == 2
    file.write_text(changed, encoding="ascii")
    assert apart(engines.dart_wheel_shapes_of_urdf, file) == (0, True)


def test_dart_makes_the_floor_a_box(exported, bicycle):
    need("dart")
    assert apart(engines.dart_top_of_the_floor, exported("dart", bicycle)) == 5e-4


def test_pybullet_makes_up_inertias_unless_told(exported, bicycle):
    need("pybullet")
    file = exported("pybullet", bicycle)
    kept, made = (
        apart(partial(engines.pybullet_inertias, from_file=x), file) for x in (True, False)
    )
    assert sorted(kept[0]) == pytest.approx([2, 10, 11], abs=1e-12)
    assert max(made[0]) < 1e-3


def test_pybullet_turns_by_binary32():
    need("pybullet")
    error = np.abs(np.array(apart(engines.pybullet_product)) - [0.96, 0, 0, 0.28]).max()
    assert 1e-9 < error < 1e-6


def test_pybullet_has_motors_unless_told(exported, bicycle):
    need("pybullet")
    assert apart(engines.pybullet_motor, exported("pybullet", bicycle)) < 9.99


@pytest.fixture
def flat(bicycle):
    """A bicycle whose rear frame has moments that no solid body has."""
    return bicycle.replace(IByy=Exact.parse("13"))


def test_engines_refuse_moments_of_no_body(flat, exported):
    assert list(refused(flat)) == [
        "moments of inertia of B violate the triangle inequality: most engines refuse this or "
        "change it"
    ]
    for name, said in (("mujoco", "A + B >= C"), ("drake", "Failed to load")):
        need(name)
        assert said in apart(getattr(engines, f"{name}_refuses"), exported(name, flat))


def test_pybullet_takes_moments_of_no_body_for_none(flat, exported):
    need("pybullet")
    inertias = partial(engines.pybullet_inertias, from_file=True)
    assert apart(inertias, exported("pybullet", flat))[0] == (0, 0, 0)


def test_dart_gives_mass_to_what_has_none(exported):
    need("dart")
    skate = read_bicycle(find_input("bicycles", "two-mass-skate"))
    assert apart(engines.dart_masses, exported("dart", skate)) == [10, 1e-9, 1, 1e-9]
