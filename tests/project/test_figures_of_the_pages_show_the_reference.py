"""The figures of the pages are reproducible and show the values of the reference."""

import json
import re
import struct
import subprocess
import sys
import tomllib
from dataclasses import replace
from fractions import Fraction
from importlib.util import find_spec
from math import cos, sin, tan
from pathlib import Path

import numpy as np
import pytest

from after_ten_seconds import committed
from after_ten_seconds import number as first_number
from generators.drawn_bicycles import OTHER_PARAMETERS
from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.errors import MissingPackageError
from heyoka_bike.system.resources import benchmark_bicycle, data_folder

matplotlib = pytest.importorskip("matplotlib")

import figures
from figures import after, certified_bounds, definition_distances, dimensions, overview, true_errors
from heyoka_bike.reference.proof import enclose as proving
from heyoka_bike.workbench.style import render
from support.texts_apart import assert_texts_are_apart

HAS_HEYOKA = find_spec("heyoka") is not None
NAMES = [
    pytest.param(
        name,
        marks=pytest.mark.skipif(name == "after" and not HAS_HEYOKA, reason="needs heyoka"),
    )
    for name in figures.FIGURES
]
STATE = ("roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate")


@pytest.fixture(autouse=True)
def _no_heyoka(monkeypatch, request):
    if "with_heyoka" not in request.fixturenames:
        monkeypatch.setitem(sys.modules, "heyoka", None)


@pytest.fixture
def with_heyoka():
    pytest.importorskip("heyoka")


@pytest.fixture
def quick_bounds(monkeypatch):
    """Replace the proved bounds with quick ones that are not proved."""

    def made(runs):
        breaks = np.linspace(0.0, 10.0, 6)
        time = np.linspace(0.0, 10.0, 11)
        return [
            certified_bounds.Bounded(
                run.maneuver.name, run.precision, breaks, 1e-66 * (1 + breaks[1:]), time, None
            )
            for run in runs
        ]

    monkeypatch.setattr(certified_bounds, "bounds", made)


@pytest.fixture(scope="module")
def followed(reference):
    """The motions after the ten seconds, computed once."""
    return after.motions(reference, (1, 2, 3)) if HAS_HEYOKA else None


@pytest.fixture
def quick_motions(monkeypatch, followed):
    """Return the computed motions instead of computing them again."""
    monkeypatch.setattr(after, "motions", lambda _, numbers: [followed[n - 1] for n in numbers])


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
def test_every_figure_is_the_same_again(name, reference, quick_bounds, quick_motions):
    first, again = (render(figures.draw(name, reference=reference), "svg") for _ in range(2))
    assert first.startswith(b"<?xml")
    assert again == first


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
def test_no_text_lies_on_another_or_leaves_the_page(
    name, reference, quick_bounds, quick_motions, monkeypatch
):
    for maneuver in (None, 1, 2, 3) if name == "after" else (None,):
        assert_texts_are_apart(figures.draw(name, maneuver, reference), monkeypatch)


@pytest.mark.proof
def test_the_script_draws_to_a_file(tmp_path):
    path = tmp_path / "bicycle.svg"
    command = [sys.executable, Path(figures.__path__[0]), "bicycle", path]
    subprocess.run(command, check=True, timeout=120)
    assert path.read_bytes().startswith(b"<?xml")


@pytest.mark.proof
def test_what_needs_heyoka_says_so(reference):
    with pytest.raises(MissingPackageError, match="heyoka is not installed"):
        figures.draw("after", reference=reference)


@pytest.mark.proof
@pytest.mark.parametrize("number", [1, 2])
def test_errors_are_the_differences_of_the_text_files(reference, folder, number):
    left, right = true_errors.draw(reference, [number]).axes
    exact = columns(folder / "uncontrolled-bicycle.txt", number)
    drawn = {x.get_label(): x for x in left.lines}
    energies = dict(zip(true_errors.RUNS.values(), right.lines, strict=False))
    for name, label in true_errors.RUNS.items():
        found = columns(data_folder() / "peers" / name, number)
        e = found["mechanical_energy"]
        assert energies[label].get_ydata()[-1] == pytest.approx(100 * (e.max() - e.min()) / e[0])
        assert (energies[label].get_xdata() == found["time"]).all()
        if name.startswith("scipy"):  # only SciPy's run uses the default definitions
            worst = max(np.abs(found[c] - exact[c]).max() / np.abs(exact[c]).max() for c in STATE)
            # The text has 17 digits, so the difference of two columns has an error of 1e-15 of the
            # scale.
            assert drawn[label].get_ydata()[-1] == pytest.approx(100 * worst, rel=1e-4)
    for line in (*drawn.values(), *energies.values()):
        assert (np.diff(line.get_ydata()) >= 0).all()


def columns(path, number):
    """Columns of a maneuver in a file with the benchmark's 25 columns."""
    names = (*("roll_angle", "roll_rate", "forward_speed"), "potential_energy", "kinetic_energy",
             "mechanical_energy", "steer_angle", "steer_rate")  # fmt: skip
    table = np.loadtxt(path)
    assert table.shape == (1001, 25)
    first = 1 + 8 * (number - 1)
    return {"time": table[:, 0]} | {n: table[:, first + i] for i, n in enumerate(names)}


@pytest.mark.proof
def test_energy_lets_pass_what_is_wrong_by_percents(reference):
    """The figure shows that the first run meets the energy limit although its error is large."""
    left, right = true_errors.draw(reference, [1]).axes
    assert left.lines[0].get_ydata()[-1] > 2.0
    limit = next(x.get_ydata()[0] for x in right.lines if len(x.get_ydata()) == 2)
    assert right.lines[0].get_ydata()[-1] < limit == 1e-3


@pytest.mark.proof
def test_distances_of_definitions_follow_from_the_attitude(reference):
    axes = definition_distances.draw(reference, [1]).axes
    assert definition_distances.COLUMNS == ("roll_angle", "roll_rate", "forward_speed")
    for key in definition_distances.COLUMNS:
        default, *others = (x.definition for x in DEFINITIONS[key])
        panels = [ax for ax in axes if ax.get_ylabel().startswith(key.replace("_", " "))]
        assert all(f"minus {default} " in ax.get_ylabel() for ax in panels)
        assert [t.get_text() for ax in panels for t in ax.get_legend().get_texts()] == others
    rows = reference[1].rows
    roll, pitch, yaw = rows["roll_angle"], rows["pitch"], rows["yaw"]
    attitude = turns(2, yaw) @ turns(0, roll) @ turns(1, pitch)
    others = {
        "tait_bryan_xyz": np.arctan2(-attitude[:, 1, 2], attitude[:, 2, 2]),
        "zyx": np.arctan2(attitude[:, 2, 1], attitude[:, 2, 2]),
    }
    for line in axes[0].lines:
        far = np.maximum.accumulate(np.abs(others[line.get_label()] - roll))
        assert np.abs(line.get_ydata() - far).max() < 1e-15


def turns(axis, angles):
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found = np.zeros((len(angles), 3, 3))
    found[:, axis, axis] = 1
    found[:, i, i] = found[:, j, j] = np.cos(angles)
    found[:, j, i], found[:, i, j] = np.sin(angles), -np.sin(angles)
    return found


@pytest.mark.proof
@pytest.mark.parametrize("number", [1, 2, 3])
def test_every_definition_of_the_legend_is_to_be_seen(reference, number):
    for ax in definition_distances.draw(reference, [number]).axes:
        low, high = ax.get_ylim()
        assert len(ax.lines) == len(ax.get_legend().get_texts())
        for line in ax.lines:
            assert low < line.get_ydata()[-1] < high, line.get_label()


@pytest.mark.proof
def test_small_differences_are_not_lost_in_binary64(reference):
    line = definition_distances.draw(reference, [3]).axes[0].lines[1]
    late = line.get_ydata()[line.get_ydata() > 0]
    assert late[0] < 1e-20


@pytest.mark.proof
def test_bicycle_names_all_parameters_with_the_values_of_the_file(reference):
    with benchmark_bicycle().open("rb") as f:
        parameters = tomllib.load(f)["parameters"]
    assert len(parameters) == 26
    texts = [t.get_text() for t in dimensions.draw(reference).texts]
    for symbol, entry in parameters.items():
        name = r"\lambda" if symbol == "lam" else symbol
        if len(symbol) > 1 and symbol != "lam":
            name = f"{symbol[0]}_{{{symbol[1:]}}}"
        value = entry["value"].replace("pi", r"$\pi$").replace("-", "\N{MINUS SIGN}")
        unit = entry["unit"].replace("^2", "$^2$")
        assert f"${name}$ = {value} {unit}" in texts


@pytest.mark.proof
def test_bicycle_is_drawn_to_scale(reference, bicycle):
    w, c, r_rear, r_front = (float(bicycle[s]) for s in ("w", "c", "rR", "rF"))
    tilt = float(bicycle["lam"])
    side = dimensions.draw(reference).axes[0]
    rims = [
        patch.get_path().get_extents() for patch in side.patches
        if type(patch).__name__ == "PathPatch"
    ]  # fmt: skip
    for box, x, radius in zip(rims, (0.0, w), (r_rear, r_front), strict=True):
        assert (box.x0, box.x1) == pytest.approx((x - radius, x + radius), abs=1e-9)
        assert (box.y0, box.y1) == pytest.approx((0.0, 2 * radius), abs=1e-9)
    slanted = [
        line for line in side.lines
        if len(line.get_xdata()) == 2 and not is_vertical(line) and np.ptp(line.get_ydata()) > 1
    ]  # fmt: skip
    (axis,) = slanted
    (x0, x1), (y0, y1) = axis.get_data()
    assert (x1 - x0) / (y1 - y0) == pytest.approx(-tan(tilt))
    assert x0 + y0 * tan(tilt) == pytest.approx(w + c)
    arrows = {
        (tuple(np.round(a.xyann, 9)), tuple(np.round(a.xy, 9)))
        for a in side.texts if getattr(a, "arrow_patch", None) is not None
    }  # fmt: skip
    b, h = ((float(bicycle[f"x{s}"]), -float(bicycle[f"z{s}"])) for s in "BH")
    across = {(a[0], e[0]) for a, e in arrows if a[1] == e[1]}
    up = {(a[1], e[1]) for a, e in arrows if a[0] == e[0]}
    assert {(0, b[0]), (0, h[0]), (0, w)} <= across
    assert {(0, b[1]), (0, h[1])} <= up
    spokes = [
        np.hypot(e[0] - a[0], e[1] - a[1]) for a, e in arrows if a in {(0.0, r_rear), (w, r_front)}
    ]
    assert sorted(spokes) == pytest.approx([r_rear, r_front])
    # The horizontal and the vertical direction have the same scale.
    figure_box = side.get_position()
    wide, high = (np.ptp(x) for x in (side.get_xlim(), side.get_ylim()))
    size = side.figure.get_size_inches()
    assert wide / (figure_box.width * size[0]) == pytest.approx(
        high / (figure_box.height * size[1])
    )
    assert (cos(tilt), sin(tilt)) == pytest.approx((0.9510565163, 0.3090169944))


@pytest.mark.proof
def test_angles_are_positive_to_the_right(reference):
    """The curved arrows of lean, yaw and steer point to the right."""
    _, behind, above = dimensions.draw(reference).axes
    (lean,) = arcs(behind)
    assert lean[-1, 0] > lean[0, 0] == pytest.approx(0.0, abs=1e-12)
    yaw, steer = arcs(above)
    # The bicycle is seen from above, so a turn to the right is drawn downwards.
    assert yaw[0, 1] == 0.0 > yaw[-1, 1]
    assert steer[-1, 1] < steer[0, 1]


def arcs(ax):
    return [line.get_xydata() for line in ax.lines if len(line.get_xdata()) == 30]


@pytest.mark.proof
def test_overview_is_wide_small_transparent_and_the_reference(reference):
    figure = overview.draw(reference, [1, 2, 3])
    png, svg = (render(figure, f) for f in ("png", "svg"))
    assert struct.unpack(">II", png[16:24]) == (1200, 420)
    assert len(svg) < 100_000
    from io import BytesIO

    from matplotlib.image import imread

    pixels = imread(BytesIO(png))
    assert pixels[0, 0, 3] == pixels[-1, -1, 3] == 0.0
    for number, ax in zip(reference, figure.axes[1:], strict=True):
        time, roll = ax.lines[1].get_data()
        exact = reference[number].evaluate(time, "roll_angle")["roll_angle"]
        assert np.abs(roll - exact).max() < 1e-14
        assert any(t.get_text() == f"{np.abs(exact).max():.2g} rad" for t in ax.texts)


@pytest.mark.proof
def test_certificate_without_heyoka_says_what_is_missing(reference, candidate, monkeypatch):
    class Proved:
        pieces = tuple((Fraction(1, 10**66),) * 7 for _ in candidate[2].pieces)

    monkeypatch.setattr(proving, "enclose", lambda run, progress: Proved)
    figure = certified_bounds.draw(reference, [3])
    (legend,) = figure.legends
    said = [t.get_text() for t in legend.get_texts()]
    assert said == ["certified bound", "true error: needs heyoka"]
    (ax,) = figure.axes
    stairs = ax.patches[0].get_data()
    assert (stairs.edges == [float(t) for t in candidate[2].breaks]).all()


@pytest.mark.slow
def test_certified_bound_is_above_the_true_error_and_is_the_published_one(
    reference, folder, with_heyoka
):
    figure = certified_bounds.draw(reference, [3])
    (ax,) = figure.axes
    stairs = ax.patches[0].get_data()
    (error,) = (x for x in ax.lines if "true error" in x.get_label())
    published = json.loads((folder / "certificate.json").read_text())["maneuvers"][2]["bound"]
    # The published bounds are rounded up to three digits.
    assert stairs.values.max() <= float(published) < 1.01 * stairs.values.max()
    piece = np.clip(np.searchsorted(stairs.edges, error.get_xdata()) - 1, 0, None)
    assert (error.get_ydata() <= stairs.values[piece]).all()
    assert error.get_ydata().max() > 1e-73


@pytest.fixture
def panels(reference, quick_motions):
    """Panels of the figure of the motion after ten seconds, by name."""
    if not HAS_HEYOKA:
        pytest.skip("needs heyoka")
    return {ax.get_label(): ax for ax in after.draw(reference, (1, 2, 3)).axes}


@pytest.fixture(scope="module")
def page():
    """Numbers of docs/after-ten-seconds.md, by table and quantity."""
    return {name: {r[0]: first_number(r[1]) for r in rows} for name, rows in committed().items()}


def said(table, quantity):
    """Value of a quantity in a table."""
    return float(table[quantity])


def numbers_in(ax):
    """Numbers in the notes of a panel."""
    text = " ".join(t.get_text() for t in ax.texts).replace("\N{MINUS SIGN}", "-")
    return [float(x) for x in re.findall(r"-?\d+\.\d+", text)]


@pytest.mark.proof
def test_the_cycle_drawn_is_the_one_of_the_page(panels, page, reference):
    beginning, cycle = panels["portrait"].lines
    for values, what in zip(cycle.get_data(), ("roll", "steer"), strict=True):
        largest = said(page["cycle"], f"largest {what} angle [rad]")
        # The drawn points are 1/200 s apart, so the largest of them is below the maximum by at most
        # 1/30,000 of it.
        assert 0 <= largest - values.max() < 4e-5 * largest
        assert 0 <= largest + values.min() < 4e-5 * largest
        # The cycle returns to its beginning up to the rounding errors of 200 s, about 1e-14.
        assert values[-1] == pytest.approx(values[0], abs=1e-13)
    times = np.linspace(0.0, 10.0, len(beginning.get_xdata()))
    exact = reference[1].evaluate(times, ("roll_angle", "steer_angle"))
    for values, name in zip(beginning.get_data(), ("roll_angle", "steer_angle"), strict=True):
        # The values are rounded to binary64, which is an error of about 1e-15.
        assert np.abs(values - exact[name]).max() < 1e-13


@pytest.mark.proof
def test_leans_come_to_the_cycle_by_the_multiplier_of_the_page(panels, page, reference):
    ax = panels["cycle"]
    leans, line = ax.lines
    time, distance = leans.get_data()
    roll = reference[1].evaluate(time[time < 10], "roll_angle")["roll_angle"]
    largest = said(page["cycle"], "largest roll angle [rad]")
    assert np.abs(np.abs(np.abs(roll) - largest) - distance[time < 10]).max() < 1e-13
    period = said(page["cycle"], "period [s]")
    # In these rows the other modes have decayed, and the distance is well above the rounding
    # errors. So each distance is the previous distance times the multiplier of half a period, to
    # 0.1 %.
    settled = (distance < 1e-6) & (distance > 1e-11)
    assert settled.sum() > 40
    half = said(page["cycle"], "half-period multiplier 1")
    ratio = distance[settled][1:] / distance[settled][:-1]
    assert np.abs(ratio / -half - 1).max() < 1e-3
    (start, end), (first, last) = line.get_data()
    floquet = said(page["cycle"], "Floquet multiplier 1")
    # The line has errors of 0.1 % at its two ends, and it spans 23 periods. So the error of the
    # factor per period is below 1e-4.
    assert (last / first) ** (period / (end - start)) == pytest.approx(floquet, rel=1e-4)
    on_line = first * (last / first) ** ((time[settled] - start) / (end - start))
    assert np.abs(on_line / distance[settled] - 1).max() < 1e-3
    # The figure shows the numbers with four decimals.
    assert numbers_in(ax) == pytest.approx([floquet, period], abs=5e-5)


@pytest.mark.proof
def test_leans_of_maneuver_2_die_out_like_the_weave_of_the_page(panels, page, reference):
    ax = panels["straight"]
    leans, line = ax.lines
    time, lean = leans.get_data()
    roll = reference[2].evaluate(time[time < 10], "roll_angle")["roll_angle"]
    assert np.abs(np.abs(roll) - lean[time < 10]).max() < 1e-13
    weave = said(page["settling"], "eigenvalue at the final speed, weave [1/s]")
    (start, end), (first, last) = line.get_data()
    # The eigenvalue belongs to the speed that is rounded to binary64.
    assert np.log(last / first) / (end - start) == pytest.approx(weave, rel=1e-12)
    # After 50 s the capsize mode has decayed to 1e-5. The runs are rounded to 2^-69.
    late = (time > 50) & (lean > 1e-15)
    assert late.sum() > 30
    on_line = first * (last / first) ** ((time[late] - start) / (end - start))
    assert np.abs(on_line / lean[late] - 1).max() < 1e-4
    # The curve ends at the time when rounding begins to dominate.
    assert end == ax.get_xlim()[1] == pytest.approx(time[lean > after.ROUNDOFF][-1], abs=1.0)
    speed = said(page["settling"], "final speed [m/s]")
    assert numbers_in(ax) == pytest.approx([speed, weave], abs=5e-5)


@pytest.mark.proof
def test_the_fall_drawn_ends_where_the_page_says(panels, page):
    fall = page["fall"]
    lift = said(fall, "lift-off, time [s]")
    roll, at_roll = panels["roll"].lines
    floor, rear, front, at_force = panels["forces"].lines
    # Until the lift-off, errors of binary64 grow to about 1e-8 (rad and s).
    for line in (roll, rear, front, at_roll, at_force):
        assert line.get_xdata()[-1] == pytest.approx(lift, abs=1e-7)
    for line in (roll, at_roll):
        angle = said(fall, "roll angle at the lift-off [rad]")
        assert line.get_ydata()[-1] == pytest.approx(angle, abs=1e-7)
    # At the lift-off the force changes by 5e5 N/s, so an error in time causes an error of the
    # force.
    for line in (rear, at_force):
        assert line.get_ydata()[-1] == pytest.approx(0.0, abs=1e-2)
    force = said(fall, "normal force on the front wheel at the lift-off [N]")
    assert front.get_ydata()[-1] == pytest.approx(force, abs=1e-2)
    greatest = roll.get_ydata().argmax()
    # The points are a millisecond apart, and the curve is flat at its maximum.
    when = said(fall, "largest roll angle, time [s]")
    assert roll.get_xdata()[greatest] == pytest.approx(when, abs=3e-3)
    largest = said(fall, "largest roll angle [rad]")
    assert roll.get_ydata()[greatest] == pytest.approx(largest, abs=1e-6)
    # Both normal forces are positive until the lift-off.
    assert (rear.get_ydata()[:-1] > 0).all()
    assert (front.get_ydata() > 0).all()
    assert list(floor.get_ydata()) == [0.0, 0.0]
    assert panels["forces"].get_ylim()[0] < 0
    assert roll.get_xdata()[0] == rear.get_xdata()[0] == 40.0
    assert numbers_in(panels["roll"]) == pytest.approx([lift], abs=5e-5)


@pytest.mark.proof
@pytest.mark.parametrize(
    ("shown", "names"),
    [(1, {"portrait", "cycle"}), (2, {"straight"}), (3, {"roll", "forces"})],
)
def test_a_maneuver_alone_has_its_own_panels(panels, reference, quick_motions, shown, names):
    found = {ax.get_label(): ax for ax in after.draw(reference, (shown,)).axes}
    assert set(found) == names
    for name, ax in found.items():
        for line, other in zip(ax.lines, panels[name].lines, strict=True):
            assert (line.get_xydata() == other.get_xydata()).all()


def is_vertical(line):
    x = line.get_xdata()
    return len(x) == 2 and x[0] == x[1]


@pytest.mark.proof
@pytest.mark.parametrize("changes", OTHER_PARAMETERS)
@pytest.mark.parametrize("name", ["bicycle", "overview"])
def test_other_bicycles_are_drawn(reference, name, changes):
    other = replace(reference, parameters={**reference.parameters, **changes})
    assert render(figures.draw(name, reference=other), "svg").startswith(b"<?xml")
