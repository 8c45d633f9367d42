"""`heyoka-bike plot` draws every maneuver of a reference, with units and reproducibly."""

import struct
import sys

import numpy as np
import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.reference.load import load_reference
from heyoka_bike.workbench.figures import FIGURES

matplotlib = pytest.importorskip("matplotlib")

from heyoka_bike.workbench.figures.motions import maneuver as draw
from heyoka_bike.workbench.style import render

LABELS = (
    "roll angle [rad]",
    "roll rate [rad/s]",
    "steer angle [rad]",
    "steer rate [rad/s]",
    "forward speed [m/s]",
    "change of energy [J]",
    "time [s]",
)
ALL = len(FIGURES) + 2  # one of the figures is drawn for each maneuver
PANELS = ("roll_angle", "roll_rate", "steer_angle", "steer_rate", "forward_speed")
ENERGIES = ("kinetic_energy", "potential_energy", "mechanical_energy")


@pytest.fixture(scope="module")
def maneuvers(folder):
    return load_reference(folder)


@pytest.fixture(scope="module")
def figures(folder, tmp_path_factory):
    """A folder with the files that the command writes by default."""
    where = tmp_path_factory.mktemp("drawn")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(where)
        patch.setitem(sys.modules, "heyoka", None)  # drawing works without heyoka
        assert main(["plot", str(folder)]) == Exit.OK
    return where / "figures"


def test_every_maneuver_as_png_and_svg(figures):
    expected = {f"maneuver_{n}.{f}" for n in (1, 2, 3) for f in ("png", "svg")}
    assert {p.name for p in figures.iterdir()} == expected


@pytest.mark.parametrize("number", [1, 2, 3])
def test_png_is_large_enough_to_print_and_not_blank(figures, number):
    from matplotlib.image import imread

    path = figures / f"maneuver_{number}.png"
    width, height = struct.unpack(">II", path.read_bytes()[16:24])
    assert (width, height) == (1400, 1280)  # [px] 7 by 6.4 inches at 200 dots per inch
    pixels = np.round(imread(path)[..., :3] * 255).astype(int)
    for colour in ((0, 114, 178), (213, 94, 0), (0, 0, 0)):  # colours of the lines and the text
        assert (pixels == colour).all(axis=-1).sum() > 500


@pytest.mark.parametrize("number", [1, 2, 3])
def test_svg_has_title_and_labels_with_units(figures, number, maneuvers):
    # matplotlib draws letters as curves. A comment in the file contains their text.
    text = (figures / f"maneuver_{number}.svg").read_text()
    for label in LABELS:
        assert f"<!-- {label} -->" in text
    speed = {1: "4", 2: "4.6", 3: "8"}[number]
    assert f"<!-- Maneuver {number}: initial forward speed {speed} m/s, roll rate 0." in text
    energy = maneuvers[number].rows["mechanical_energy"][0]
    assert f"<!-- mechanical energy, initially {energy:.1f} J -->" in text


def test_lines_are_the_reference(maneuvers):
    maneuver = maneuvers[2]
    *axes, last = draw(maneuvers, [2]).axes
    for ax, name in zip(axes, PANELS, strict=True):
        (line,) = ax.lines
        assert np.array_equal(line.get_xdata(), maneuver.time)
        assert np.array_equal(line.get_ydata(), maneuver.rows[name])
    for line, name in zip(last.lines, ENERGIES, strict=True):
        assert line.get_label().startswith(name.replace("_", " "))
        values = maneuver.rows[name]
        assert np.array_equal(line.get_ydata(), values - values[0])
    # The reference conserves energy to all its digits, so only the error of rounding to binary64
    # remains.
    assert np.abs(last.lines[2].get_ydata()).max() <= np.spacing(2000.0)


def test_same_bytes_again(maneuvers):
    first = render(draw(maneuvers, [1]), "pdf")
    assert render(draw(maneuvers, [1]), "pdf") == first
    assert b"Date" not in first


def test_settings_of_the_user_do_not_matter(maneuvers):
    plain = render(draw(maneuvers, [3]), "svg")
    assert b"Date" not in plain
    with matplotlib.rc_context({"font.size": 30, "lines.linewidth": 9, "axes.facecolor": "red"}):
        assert render(draw(maneuvers, [3]), "svg") == plain


@pytest.mark.parametrize(
    ("name", "start"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("new/a.PDF", b"%PDF")]
)
def test_one_maneuver_into_one_file(folder, tmp_path, name, start, capsys):
    path = tmp_path / name
    assert main(["plot", str(folder), "--maneuver", "2", "-o", str(path)]) == Exit.OK
    assert path.read_bytes().startswith(start)
    # No other file remains in the folder.
    assert [p.name for p in path.parent.iterdir()] == [path.name]
    assert capsys.readouterr().out == f"{path}\n"


def test_folder_format_and_maneuver_can_be_chosen(folder, tmp_path):
    out = tmp_path / "with.dot"
    arguments = ["plot", str(folder), "--maneuver", "3", "--format", "svg", "svg", "-o", f"{out}/"]
    assert main(arguments) == Exit.OK
    assert [p.name for p in out.iterdir()] == ["maneuver_3.svg"]


def test_another_format_is_refused_by_the_parser(capsys):
    with pytest.raises(SystemExit) as e:
        main(["plot", "--format", "jpg"])
    assert e.value.code == Exit.INPUT
    said = "heyoka-bike plot: --format: found 'jpg', expected one of png, svg, pdf"
    assert capsys.readouterr().err.startswith(said)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--maneuver", "4"], "--maneuver: found 4, expected 1 to 3"),
        (["--maneuver", "0"], "--maneuver: found 0, expected 1 to 3"),
        (["--maneuver", "1", "-o", "x.jpg"], "--output: found 'x.jpg', expected a file ending in"),
        (["-o", "x.png"], "--output: found the file 'x.png' for 3 figures, expected a folder"),
        (["--figure", "all", "-o", "x.png"], f"--output: found the file 'x.png' for {ALL} figures"),
        (["--figure", "best"], "--figure: found 'best', expected one of maneuvers, stability,"),
        (["--figure", "phase", "--maneuver", "4"], "--maneuver: found 4, expected 1 to 3"),
        (
            ["--figure", "stability", "--maneuver", "2"],
            "--maneuver does not apply: 'stability' shows no motion",
        ),
        (["--maneuver", "1", "-o", "x.png", "--format", "svg"], "--format can be used only with a"),
        (["-o", "file"], "file/maneuver_1.png: cannot be written: File exists"),
        (["-o", "file/below"], "file/below/maneuver_1.png: cannot be written: Not a directory"),
        (["--maneuver", "1", "-o", "folder.svg/x.pdf/"], "folder.svg/x.pdf/maneuver_1.png: cannot"),
    ],
)
def test_bad_input_gives_one_line(folder, tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    for name in ("file", "folder.svg"):
        (tmp_path / name).write_text("in the way")
    assert main(["plot", str(folder), *arguments]) == Exit.INPUT
    error = capsys.readouterr().err
    assert error.startswith(f"heyoka-bike: {message}")
    assert error.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder.svg"]


def test_folder_without_a_set_gives_one_line(tmp_path, capsys):
    assert main(["plot", str(tmp_path)]) == Exit.INPUT
    error = capsys.readouterr().err
    assert "no manifest.json found" in error
    assert error.count("\n") == 1


def test_without_matplotlib_says_what_to_install(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.style", None)
    assert main(["plot", str(folder)]) == Exit.INPUT
    error = capsys.readouterr().err
    assert 'pip install "heyoka_bike[plot]"' in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
