"""`plot` and `animate` in Python return what the commands write, and show it in a notebook."""

from html import unescape

import numpy as np
import pytest

import heyoka_bike as hb
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.system.resources import data_folder

FILE = data_folder() / "peers" / "exudyn-h0.01.txt"
TABLE = np.loadtxt(FILE)


@pytest.mark.proof
def test_a_figure_is_given_or_written_as_the_command_does(tmp_path):
    pytest.importorskip("matplotlib")
    figure = hb.plot("stability")
    assert figure._repr_png_().startswith(b"\x89PNG")
    (path,) = hb.plot("stability", tmp_path / "python.svg")
    assert main(["plot", "--figure", "stability", "-o", str(tmp_path / "command.svg")]) == 0
    assert path.read_bytes() == (tmp_path / "command.svg").read_bytes()


def test_a_figure_of_each_maneuver_is_a_tuple(tmp_path):
    pytest.importorskip("matplotlib")
    assert len(hb.plot()) == 3
    assert hb.plot(maneuver=2).get_suptitle() == hb.plot()[1].get_suptitle()
    assert [p.name for p in hb.plot("phase", tmp_path / "figures")] == ["phase.png", "phase.svg"]


@pytest.mark.parametrize(
    ("arguments", "named", "says"),
    [
        (["best"], {}, "figure: found 'best', expected one of maneuvers"),
        (["maneuvers", "x.png"], {}, "path: found the file 'x.png' for 3 figures"),
        (["phase", "x.jpg"], {}, "path: found 'x.jpg', expected a file ending in .png"),
        ([], {"maneuver": 7}, "maneuver: found 7, expected 1 to 3"),
        ([TABLE], {}, "figure: found a ndarray, expected the name of a figure"),
        (["atlas"], {}, "needs the folder of an atlas"),
        (["phase"], {"reference": TABLE}, "reference: found a ndarray, expected the folder"),
    ],
)
def test_what_cannot_be_drawn_is_refused(arguments, named, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as raised:
        hb.plot(*arguments, **named)
    assert says in str(raised.value)
    assert not list(tmp_path.iterdir())


def test_a_replay_is_shown_or_written_as_the_command_does(tmp_path):
    shown = hb.animate(FILE)
    path = hb.animate(FILE, tmp_path / "python.html")
    assert main(["animate", str(FILE), "-o", str(tmp_path / "command.html")]) == 0
    assert path.read_bytes() == (tmp_path / "command.html").read_bytes()
    assert shown.html.encode() == path.read_bytes()
    assert shown.save(tmp_path / "saved.html").read_bytes() == path.read_bytes()
    assert len(repr(shown)) < 100


def test_a_notebook_shows_the_page_in_a_frame_of_its_own():
    shown = hb.animate(maneuver=3)
    start, _, rest = shown._repr_html_().partition('srcdoc="')
    page, _, end = rest.partition('"')
    assert unescape(page) == shown.html
    assert start == '<iframe sandbox="allow-scripts" '
    assert end.count("<") == 1


def test_a_replay_is_of_all_that_can_be_scored(tmp_path):
    of_array = hb.animate(TABLE).html
    assert of_array.count("<canvas") == 1
    assert hb.animate(TABLE[:, 0], maneuver=2, roll_angle=TABLE[:, 9]).html != of_array
    assert len(hb.animate(TABLE, maneuver=2).html) < len(of_array)
    assert "results" in of_array


@pytest.mark.parametrize(
    ("arguments", "named", "says"),
    [
        ([FILE, "x.png"], {}, "found 'x.png', expected a name ending in .html"),
        ([TABLE[:, :7]], {}, "array: found 7 columns, expected 9 or 25"),
        ([], {"maneuver": 7}, "found maneuver 7, expected 1 to 3"),
        ([TABLE[:, 0]], {"rol_angle": TABLE[:, 1]}, "did you mean roll_angle?"),
        (["mine.html", "mine.html"], {}, "is a result file to be scored"),
    ],
)
def test_what_cannot_be_replayed_is_refused(arguments, named, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.html").write_bytes(FILE.read_bytes())
    with pytest.raises(InputError) as raised:
        hb.animate(*arguments, **named)
    assert says in str(raised.value)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.html"]
