"""``export --nearest-valid-inertia`` changes only impossible inertias, as little as possible."""

import numpy as np
import pytest

from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.cli import main
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.exports.models import refused
from heyoka_bike.reference.exports.solid import nearest_solid
from heyoka_bike.system.resources import collection, find_input

# Exported parameters are written with 12 digits.
ROUNDOFF = 1e-11


def inertia(bicycle, letter):
    value = {
        ij: float(bicycle[f"I{letter}{ij}"]) if f"I{letter}{ij}" in bicycle.values else 0.0
        for ij in ("xx", "yy", "zz", "xz")
    }
    zz = value["zz"] if letter in "BH" else value["xx"]
    return np.array([[value["xx"], 0, value["xz"]], [0, value["yy"], 0], [value["xz"], 0, zz]])


def lacking(matrix):
    """Return how far a matrix is from a solid body's; negative if a solid body has it."""
    a, b, c = np.linalg.eigvalsh(matrix)
    return max(c - a - b, -a)


def test_every_bicycle_becomes_solid_and_a_solid_one_stays():
    for name in collection("bicycles"):
        bicycle = read_bicycle(find_input("bicycles", name))
        found, said = nearest_solid(bicycle)
        assert not list(refused(found)), name
        for letter in "BHRF":
            # The moments of a hoop are exactly at the limit, so hoops stay unchanged. The bicycle
            # bluenose has two of them.
            assert lacking(inertia(found, letter)) <= 0, f"{name} {letter}"
        if not list(refused(bicycle)):
            assert (found, said) == (bicycle, [])


@pytest.mark.parametrize(
    ("letter", "changes"),
    [
        ("B", {"IByy": "13"}),  # the largest moment is about the axle
        ("B", {"IByy": "7"}),  # the largest moment is in the plane of symmetry
        ("H", {"IHxx": "0.09"}),
        ("R", {"IRyy": "0.2"}),
    ],
)
def test_no_other_solid_body_is_nearer(letter, changes, bicycle):
    """Random changes of the result that stay solid are farther from the given inertia."""
    wrong = bicycle.replace(**{s: Exact.parse(x) for s, x in changes.items()})
    given = inertia(wrong, letter)
    size = np.abs(given).max()
    assert lacking(given) > 0
    found = inertia(nearest_solid(wrong)[0], letter)
    assert lacking(found) < 0
    distance = np.linalg.norm(found - given)
    draw = np.random.default_rng(7)
    tried = 0
    for _ in range(3000):
        step = draw.normal(size=(3, 3)) * size * 10 ** draw.uniform(-6, -1)
        other = found + (step + step.T) / 2
        if lacking(other) <= 0:
            tried += 1
            # The result keeps a margin against rounding, of 1e-9 of the largest moment.
            assert np.linalg.norm(other - given) > distance - 1e-8 * size
    assert tried > 100


def test_principal_axes_stay():
    wrong = read_bicycle(find_input("bicycles", "browser"))
    before, after = (inertia(x, "B") for x in (wrong, nearest_solid(wrong)[0]))
    assert np.abs(before @ after - after @ before).max() < ROUNDOFF


def test_the_command_reports_each_change(tmp_path, capsys):
    options = ["--bicycle", "browser", "-o", str(tmp_path)]
    assert main(["export", "--model", "urdf", "--nearest-valid-inertia", *options]) == 0
    assert capsys.readouterr().err == (
        "heyoka-bike: Batavus Browser: IBxx is 0.539622 in place of 0.529629\n"
        "heyoka-bike: Batavus Browser: IByy is 1.3064 in place of 1.3164\n"
        "heyoka-bike: Batavus Browser: IBzz is 0.76678 in place of 0.756787\n"
    )
    assert 'iyy="1.3064026084' in (tmp_path / "bicycle.urdf").read_text()


def test_the_option_belongs_to_models(tmp_path, capsys):
    code = main(["export", "--equations", "c", "--nearest-valid-inertia", "-o", str(tmp_path)])
    assert code == 1
    said = "heyoka-bike: --nearest-valid-inertia cannot be combined with --equations\n"
    assert capsys.readouterr().err == said
