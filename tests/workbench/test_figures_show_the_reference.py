"""Every figure of `heyoka-bike plot` is reproducible, and its lines show the reference."""

import json
import re
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from generators.drawn_bicycles import OTHER_PARAMETERS
from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.workbench.figures import FIGURES, plates

matplotlib = pytest.importorskip("matplotlib")

from heyoka_bike.workbench.figures import eigenvalues, motions
from heyoka_bike.workbench.style import render
from support.texts_apart import assert_texts_are_apart

# The layout of a figure starts from that of the previous format, so SVG must come first.
FORMATS = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}
ANCHORS = Path(__file__).parents[1] / "anchors"


@pytest.fixture(autouse=True)
def _no_heyoka(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)


@pytest.fixture(scope="module")
def stability(reference):
    """The axes of the figure. Drawing takes a second, so the tests share it and must
    not change it."""
    return eigenvalues.stability(reference).axes


@pytest.mark.proof
@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_drawn_in_every_format_and_the_same_again(name, reference):
    draw = next(iter(plates(reference, name).values()))
    figure, again = draw(), draw()
    # SVG is rendered first, because the layout depends on the formats that were drawn before.
    for file_format, start in sorted(FORMATS.items(), reverse=True):
        first = render(figure, file_format)
        assert first.startswith(start)
        # All formats are compared for one figure only, because they share the drawing code.
        if file_format == "svg" or name == "phase":
            assert render(again, file_format) == first, file_format


@pytest.mark.parametrize("name", FIGURES)
def test_no_text_lies_on_another_or_leaves_the_page(name, reference, monkeypatch):
    for draw in plates(reference, name).values():
        assert_texts_are_apart(draw(), monkeypatch)


def test_all_means_every_figure(reference):
    names = list(plates(reference, "all"))
    assert names == [name for kind in FIGURES for name in plates(reference, kind)]
    assert {"maneuver_1", "maneuver_2", "maneuver_3", "stability", "phase", "path"} <= set(names)
    chosen = plates(reference, "all", 2)
    assert len(chosen) == len(FIGURES)
    assert {"maneuver_2", "stability", "phase_2"} <= set(chosen)


def test_command_writes_the_chosen_figure(tmp_path, capsys):
    path = tmp_path / "portrait.svg"
    assert main(["plot", "--figure", "phase", "--maneuver", "2", "-o", str(path)]) == Exit.OK
    assert capsys.readouterr().out == f"{path}\n"
    text = path.read_text()
    assert "<!-- maneuver 2 -->" in text
    assert "<!-- maneuver 1 -->" not in text


def test_help_lists_every_figure(capsys):
    with pytest.raises(SystemExit) as e:
        main(["plot", "--help"])
    assert e.value.code == 0
    out = capsys.readouterr().out
    for name, kind in FIGURES.items():
        assert re.search(rf"^  {name} +{re.escape(kind.about)}$", out, re.MULTILINE), name


def test_eigenvalues_are_those_of_the_published_matrices(stability):
    published = json.loads((ANCHORS / "linear.json").read_text())["matrices"]
    m, c1, k0, k2 = (np.array(published[x]["printed"], float) for x in ("M", "C1", "K0", "K2"))
    upper, lower = stability
    drawn = [x for x in upper.lines if x.get_label() in ("weave", "capsize", "castering")]
    of_pair = [x for x in lower.lines if x.get_label() not in ("weave", "capsize", "castering")]
    imaginary = {tuple(x.get_xdata()): x.get_ydata() for x in of_pair if len(x.get_xdata()) > 2}
    checked = 0
    for line in drawn:
        speeds = line.get_xdata()
        assert speeds[0] < speeds[-1]
        imag = imaginary.get(tuple(speeds), np.zeros_like(speeds))
        if line.get_label() != "weave":
            imag = np.zeros_like(speeds)
        for v, x, y in zip(speeds[::10], line.get_ydata()[::10], imag[::10], strict=True):
            stiffness = 9.81 * k0 + v**2 * k2
            below = -np.linalg.solve(m, np.hstack((stiffness, v * c1)))
            a = np.vstack((np.eye(4)[2:], below))
            nearest = np.abs(np.linalg.eigvals(a) - (x + 1j * y)).min()
            # Near a double root, an eigenvalue is accurate to half of the printed digits only.
            assert nearest < 1e-6, (line.get_label(), v)
            checked += 1
    assert checked > 60
    assert {x.get_label() for x in drawn} == {"weave", "capsize", "castering"}


def test_critical_speeds_are_marked_with_their_published_digits(stability):
    upper, lower = stability
    texts = " ".join(t.get_text() for t in upper.texts)
    assert "weave speed\n4.29238… m/s" in texts  # the published value is 4.292382536341
    assert "capsize speed\n6.02426… m/s" in texts  # the published value is 6.024262015388
    for ax in (upper, lower):
        (shade,) = ax.patches
        box = shade.get_extents().transformed(ax.transData.inverted())
        assert (box.x0, box.x1) == pytest.approx((4.292382536341, 6.024262015388), abs=1e-9)
        dotted = [x.get_xdata()[0] for x in ax.lines if x.get_linestyle() == ":" or is_vertical(x)]
        assert dotted == [4.0, 4.6, 8.0]


def is_vertical(line):
    x = line.get_xdata()
    return len(x) == 2 and x[0] == x[1]


def test_portraits_are_the_dense_output(reference):
    grid = np.reshape(motions.phase(reference, [1, 2, 3]).axes, (3, 3))
    points = motions.PORTRAIT_POINTS
    times = [Fraction(10 * i, points - 1) for i in range(0, points, 50)]
    for number, row in zip(reference, grid, strict=True):
        values = reference[number].evaluate(times)
        for ax, (across, up) in zip(row, motions.PORTRAITS, strict=True):
            curve, start, end = ax.lines
            for drawn, name in ((curve.get_xdata(), across), (curve.get_ydata(), up)):
                scale = reference[number].scale(name)
                assert np.abs(drawn[::50] - values[name]).max() < 1e-14 * scale
            assert (start.get_xdata()[0], start.get_ydata()[0]) == tuple(curve.get_xydata()[0])
            assert (end.get_xdata()[0], end.get_ydata()[0]) == tuple(curve.get_xydata()[-1])
    # The published start is upright and straight, with a roll rate of 0.5 rad/s.
    assert grid[1, 0].lines[0].get_xydata()[0] == pytest.approx((0.0, 0.5), abs=1e-15)


def test_modes_are_named_only_where_they_are_those_of_the_benchmark(reference):
    other = replace(reference, parameters={**reference.parameters, "zB": "-30"})
    labels = {x.get_label() for x in eigenvalues.stability(other).axes[0].lines}
    assert {"real", "complex"} <= labels
    assert not labels & {"weave", "capsize", "castering"}


@pytest.mark.proof
@pytest.mark.parametrize("changes", OTHER_PARAMETERS)
def test_other_bicycles_are_drawn(reference, changes):
    other = replace(reference, parameters={**reference.parameters, **changes})
    (draw,) = plates(other, "stability").values()
    assert render(draw(), "svg").startswith(b"<?xml")


def test_paths_are_those_of_the_contact_point(reference):
    grid = np.reshape(motions.path(reference, [1, 2, 3]).axes, (3, 2))
    for number, (above, over_time) in enumerate(grid, start=1):
        line, dots = above.lines
        rows = reference.motion[number].rows
        for axis, drawn in zip("xy", line.get_data(), strict=True):
            # The drawn points of the path are the rows of the reference.
            np.testing.assert_allclose(drawn, rows[f"rear_contact_{axis}"], atol=1e-13)
        assert len(dots.get_xdata()) == 11
        # The line turns with the yaw, so its curvature is the change of yaw divided by the length.
        x, y = line.get_data()
        length = np.hypot(np.diff(x), np.diff(y))
        turned = np.diff(reference[number].rows["yaw"])
        time, bent = over_time.lines[-1].get_data()
        middle = (bent[1:] + bent[:-1]) / 2
        np.testing.assert_allclose(
            middle / 1000, turned / length, atol=1e-2 * np.max(abs(bent / 1000))
        )
        assert time[-1] == 10
