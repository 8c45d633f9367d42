"""Undecided values are published within their bounds and marked; no start is rejected.

The circle is one of Basu-Mandal, Chatterjee and Papadopoulos (2007, doi:10.1098/rspa.2007.1849):
the benchmark bicycle leans by 0.25 rad and turns forever. Newton's method finds its steer angle and
speed to more digits than a dataset has, so that its rates cannot be distinguished from zero.
"""

import json
import shutil
from dataclasses import replace
from fractions import Fraction

import flint
import h5py
import numpy as np
import pytest

from generators.drawn_starts import bicycles, starts
from heyoka_bike.bicycle.columns import NORMS
from heyoka_bike.bicycle.equations.initial import pitch_at_start
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.errors import BicycleError, NotCertifiedError
from heyoka_bike.numbers.arithmetic import Balls, dyadic
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.layout import CERTIFICATE, HDF5, TEXT, TEXT_50
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.making import generate
from heyoka_bike.reference.proof.certify import certify
from heyoka_bike.reference.proof.instants import known_states
from heyoka_bike.reference.verification.verify import verify

ZERO = Exact(Fraction(0))
DIGITS = 150


def start(maneuvers, rows=2, **given):
    """Return a maneuver of a few short rows with these initial values, the others zero."""
    keys = ("speed", "roll", "steer", "roll_rate", "steer_rate")
    values = {key: Exact.parse(given.get(key, "0")) for key in keys}
    spacing = Fraction(1, 50)
    name = " ".join(f"{key} {x:.12}" for key, x in given.items())
    return replace(
        maneuvers[0], name=name, **values, spacing=spacing, duration=(rows - 1) * spacing,
        performance_limit=None,
    )  # fmt: skip


def steady_turn(bicycle, maneuvers, roll):
    """Return steer and speed at which both angular accelerations vanish, as decimals."""
    equations = Equations.of(bicycle, Balls(round(3.4 * DIGITS) + 64))
    found, step = [Fraction("0.077"), Fraction("5.8")], Fraction(1, 10 ** (DIGITS // 2))

    def accelerations(steer, speed):
        m = replace(start(maneuvers, roll=roll), steer=Exact(steer), speed=Exact(speed))
        given = [m.roll, m.steer, m.speed]
        lean, turned, v = map(equations.a.number, given)
        zero = flint.arb(0)
        state = [lean, pitch_at_start(equations, m), turned, zero, zero, v / equations.k.length]
        return [dyadic(x.mid()) for x in equations.rates(state)[3:5]]

    with equations.precision():
        for _ in range(9):
            here = accelerations(*found)
            by = [
                accelerations(found[0] + step, found[1]),
                accelerations(found[0], found[1] + step),
            ]
            (a, b), (c, d) = ([(x[i] - here[i]) / step for x in by] for i in (0, 1))
            off = [(here[0] * d - here[1] * b), (here[1] * a - here[0] * c)]
            found = [
                Fraction(round((x - y / (a * d - b * c)) * 10**DIGITS), 10**DIGITS)
                for x, y in zip(found, off, strict=True)
            ]
    return [f"{x.numerator}/{x.denominator}" for x in found]


@pytest.fixture(scope="module")
def circle(bicycle, maneuvers, tmp_path_factory):
    """A dataset of a motion in which many values cannot be distinguished from zero."""
    folder = tmp_path_factory.mktemp("circle") / "set"
    steer, speed = steady_turn(bicycle, maneuvers, "0.25")
    generate(folder, maneuvers=[start(maneuvers, 5, roll="0.25", steer=steer, speed=speed)])
    return folder


@pytest.fixture
def copy(circle, tmp_path):
    return shutil.copytree(circle, tmp_path / "copy")


@pytest.mark.proof
def test_a_hands_free_circle_stays_where_it_is(circle):
    """The values change by less than 1e-60, and their bounds show this."""
    rows = load_reference(circle)[1].rows
    for name in ("roll_angle", "steer_angle", "pitch", "roll_rate", "steer_rate", "forward_speed",
                 "yaw_rate", "kinetic_energy"):  # fmt: skip
        assert (rows.hi[name] == rows.hi[name][0]).all(), name
        assert (rows.lo[name] == rows.lo[name][0]).all(), name
    assert rows.bound["roll_angle"][1:].max() < 1e-60
    assert (rows.hi["roll_rate"] == 0).all()
    assert rows.bound["roll_rate"].max() < 1e-60
    table = [line.split() for line in (circle / TEXT_50).read_text().splitlines()]
    assert len({row[1] for row in table}) == 1
    assert all(abs(Fraction(row[2])) < Fraction(1, 10**60) for row in table)


@pytest.mark.proof
def test_what_is_not_decided_is_marked_everywhere(circle):
    rows = load_reference(circle)[1].rows
    assert rows.undecided["roll_rate"].tolist() == [1, 2, 3, 4]
    # The rounding of row 0 is certain, because its exact value 0.25 is a binary64 number.
    assert rows.undecided["roll_angle"].tolist() == [1, 2, 3, 4]
    assert "steer_angle" not in rows.undecided
    with h5py.File(circle / HDF5) as f:
        assert f["maneuver_1/roll_rate_undecided"][:].tolist() == [1, 2, 3, 4]
    for name in (TEXT, TEXT_50):
        tokens = [line.split()[2] for line in (circle / name).read_text().splitlines()]
        assert tokens[0] == "0"
        assert all(token.startswith("0e-") for token in tokens[1:])
    document = json.loads((circle / CERTIFICATE).read_text())
    (said,) = document["maneuvers"]
    # Number of entries of the text with fewer digits: both rates in all rows except the first.
    short = 2 * (5 - 1)
    assert said["ambiguous"] == sum(map(len, rows.undecided.values())) + short
    assert "not decided" in document["statement"]
    assert verify(circle).passed
    (proof,) = certify(circle)
    assert proof.ambiguous == said["ambiguous"]


def changed(folder, name, change):
    """Change a file of a dataset, and its hash in the manifest."""
    from heyoka_bike.reference.manifest import MANIFEST, sha256

    change(folder / name)
    document = json.loads((folder / MANIFEST).read_text())
    for entry in document["files"]:
        if entry["file"] == name:
            raw = (folder / name).read_bytes()
            entry |= {"bytes": len(raw), "sha256": sha256(raw)}
    (folder / MANIFEST).write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    return folder


def without_mark(path):
    with h5py.File(path, "r+") as f:
        del f["maneuver_1/roll_rate_undecided"]


def with_mark(path):
    with h5py.File(path, "r+") as f:
        f["maneuver_1"].create_dataset("steer_angle_undecided", data=np.array([2]))


def other_candidate(path):
    with h5py.File(path, "r+") as f:
        f["maneuver_1/roll_rate"][2] = 1e-50


def shorter(path):
    path.write_text(path.read_text().replace("0e-", "1e-"))


@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "change"),
    [(HDF5, without_mark), (HDF5, with_mark), (HDF5, other_candidate), (TEXT_50, shorter),
     (TEXT, shorter)],
)  # fmt: skip
def test_a_mark_is_refused_where_it_is_wrong(copy, name, change):
    changed(copy, name, change)
    assert not verify(copy).passed
    with pytest.raises(NotCertifiedError):
        certify(copy)


@pytest.mark.proof
@pytest.mark.parametrize(
    ("given", "is_constant"),
    [
        ({}, True),  # the bicycle is upright and at rest
        ({"steer": "1.33973991"}, False),  # the start is near a static equilibrium
        ({"roll": "0.1", "steer": "-0.02", "speed": "7"}, False),
        ({"steer": "0.05", "speed": "-5"}, False),
        ({"roll": "0.2"}, False),  # the bicycle falls from rest
        ({"steer_rate": "1/8"}, False),  # the rear hub is at rest for an instant
        ({"speed": "1e-12", "roll_rate": "1e-25"}, False),
    ],
)
def test_starts_with_zeros_are_made(maneuvers, tmp_path, given, is_constant):
    m = start(maneuvers, **given)
    (table,) = generate(tmp_path / "set", maneuvers=[m]).tables
    assert verify(tmp_path / "set").passed
    exact = {"roll_angle": m.roll, "forward_speed": m.speed, "steer_rate": m.steer_rate}
    for name, x in exact.items():
        assert table.rows.hi[name][0] == float(x.rational)
        assert table.rows.lo[name][0] == float(x.rational - Fraction(float(x.rational)))
        assert 0 not in table.rows.undecided.get(name, [])
    if is_constant:
        assert not table.rows.ambiguous
        for name, values in table.rows.hi.items():
            assert len(set(values.tolist())) == 1, name
    # The magnitude of a velocity has a bound even at times where it has no series expansion.
    for name in NORMS:
        dense = table.dense
        assert np.isfinite(dense.bound[name]).all()
        assert table.rows.hi[name].min() >= 0


@pytest.mark.slow
def test_every_known_state_is_made(tmp_path):
    short = Fraction(1, 100)
    states = [replace(m, duration=short, spacing=short) for m in known_states()]
    made = generate(tmp_path / "set", maneuvers=states)
    assert [t.maneuver.name for t in made.tables] == [m.name for m in states]
    assert all(end.maneuver.duration == short for end in made.endings)
    assert verify(tmp_path / "set").passed


FORBIDDEN = ("no pitch puts both wheels on the floor", "mass matrix is singular", "singularity")
"""Messages on states that mechanics forbids."""


@pytest.mark.proof
def test_drawn_starts_are_made(bicycle, maneuvers, tmp_path):
    assert list(refused(bicycle, maneuvers, tmp_path, range(3))) == []


@pytest.mark.slow
def test_many_drawn_starts_are_made(bicycle, maneuvers, tmp_path):
    assert list(refused(bicycle, maneuvers, tmp_path, range(3, 200))) == []


def refused(bicycle, maneuvers, tmp_path, numbers):
    """Yield starts of 20 bicycles that are not made or verified without a mechanical reason."""
    drawn = list(bicycles(bicycle, 20))
    for i, m in enumerate(starts(maneuvers[0], numbers.stop)):
        if i not in numbers:
            continue
        folder = tmp_path / str(i)
        try:
            generate(folder, bicycle=drawn[i % len(drawn)], maneuvers=[m])
        except BicycleError as e:
            if not any(words in str(e) for words in FORBIDDEN):
                yield m.name, str(e)
        else:
            yield from ((m.name, c) for c in verify(folder).checks if c.passed is False)
