"""`heyoka-bike animate` writes a page or a film, or says in one line why not."""

import json
import re
import shutil
import sys

import numpy as np
import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.system.resources import data_folder

RESULT = str(data_folder() / "peers" / "scipy-rtol1e-4.txt")


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def few_frames(monkeypatch):
    from heyoka_bike.showing.replay import film as replay_film

    monkeypatch.setitem(replay_film.RATES, "gif", 1)
    monkeypatch.setitem(replay_film.RATES, "mp4", 1)


def maneuvers(path):
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'id="data">\n(.*?)\n<', text, re.S)[1])["maneuvers"]


def test_a_page_of_the_reference(tmp_path, monkeypatch, capsys):
    for package in ("heyoka", "matplotlib", "scipy"):
        monkeypatch.setitem(sys.modules, package, None)
    assert main(["animate"]) == Exit.OK
    assert capsys.readouterr().out == "uncontrolled-bicycle.html\n"
    found = maneuvers(tmp_path / "uncontrolled-bicycle.html")
    assert [m["number"] for m in found] == [1, 2, 3]
    assert [p.name for p in tmp_path.iterdir()] == ["uncontrolled-bicycle.html"]


def test_a_result_and_one_maneuver(tmp_path, capsys):
    assert main(["animate", RESULT, "--maneuver", "2", "-o", "new/two.htm"]) == Exit.OK
    assert capsys.readouterr().out == "new/two.htm\n"
    (found,) = maneuvers(tmp_path / "new" / "two.htm")
    assert found["number"] == 2
    assert max(map(abs, found["result"]["differences"]["roll"])) > 1e-7


def test_nine_columns_are_of_the_maneuver_told(tmp_path):
    table = np.loadtxt(RESULT)
    np.savetxt("nine.txt", table[:, [0, *range(17, 25)]], fmt="%.15g")
    assert main(["animate", "nine.txt", "--maneuver", "3", "-o", "a.html"]) == Exit.OK
    assert main(["animate", "nine.txt", "-o", "b.html"]) == Exit.OK
    assert maneuvers(tmp_path / "a.html")[0]["result"] is not None
    assert [m["result"] is None for m in maneuvers(tmp_path / "b.html")] == [True, True, False]


def test_the_same_file_again(tmp_path):
    for name in ("a.html", "b.html"):
        assert main(["animate", RESULT, "-o", name]) == Exit.OK
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


@pytest.mark.parametrize(
    "arguments",
    [["-o", "x.gif"], pytest.param([RESULT, "--format", "gif"], marks=pytest.mark.proof)],
)
def test_a_gif_has_frames_that_move(tmp_path, few_frames, arguments):
    pytest.importorskip("matplotlib")
    from PIL import Image

    assert main(["animate", *arguments, "--maneuver", "2"]) == Exit.OK
    (path,) = tmp_path.glob("*.gif")
    with Image.open(path) as film:
        assert film.n_frames == 51
        assert film.size == (800, 520)
        assert film.info["duration"] == 200  # 10 s in all
        frames = []
        for i in (0, 2, 40):
            film.seek(i)
            frames.append(np.asarray(film.convert("RGB")).astype(int))
    for frame in frames:
        red, green, blue = np.moveaxis(frame, -1, 0)
        assert ((red > green + 60) & (green > blue + 40)).sum() > 1000  # frame and shirt
    for a, b in ((0, 1), (1, 2)):
        assert (np.abs(frames[a] - frames[b]).max(axis=-1) > 40).sum() > 1000


FFMPEG = """#!{python}
import sys
data = sys.stdin.buffer.read()
width, height = map(int, sys.argv[sys.argv.index("-s") + 1].split("x"))
frames, rest = divmod(len(data), 4 * width * height)
rate = sys.argv[sys.argv.index("-framerate") + 1]
print(frames, rest, width % 2, height % 2, rate, file=open(sys.argv[-1], "w"))
"""


@pytest.mark.proof
@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in is a script")
def test_ffmpeg_gets_every_frame(tmp_path, few_frames, monkeypatch):
    pytest.importorskip("matplotlib")
    tool = tmp_path / "bin" / "ffmpeg"
    tool.parent.mkdir()
    tool.write_text(FFMPEG.format(python=sys.executable))
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(tool.parent), prepend=":")
    assert main(["animate", "-o", "x.mp4"]) == Exit.OK
    assert (tmp_path / "x.mp4").read_text().split() == ["51", "0", "0", "0", "5.0"]


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg to encode with")
def test_an_mp4_is_written(tmp_path, few_frames):
    assert main(["animate", "-o", "x.mp4"]) == Exit.OK
    assert (tmp_path / "x.mp4").read_bytes()[4:8] == b"ftyp"


def test_without_ffmpeg_says_so(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["animate", "-o", "x.mp4"]) == Exit.INPUT
    error = capsys.readouterr().err
    assert error == (
        "heyoka-bike: ffmpeg is not installed; MP4 needs it (a name ending in .gif does not)\n"
    )
    assert not list(tmp_path.iterdir())


def test_without_matplotlib_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.style", None)
    assert main(["animate", "-o", "x.gif"]) == Exit.INPUT
    error = capsys.readouterr().err
    assert 'pip install "heyoka_bike[plot]"' in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["-o", "x.webm"], 1, "--output: found 'x.webm', expected a name ending in .html, .htm,"),
        (["-o", "x.html", "--format", "gif"], 1, "--format: found gif for the file 'x.html'"),
        (["--maneuver", "4"], 1, "--maneuver: found '4', expected 1 to 3"),
        (["no.txt"], 1, "no.txt: cannot be read"),
        (["--reference", "nowhere"], 1, "nowhere: no manifest.json found"),
        (["-o", "file/x.html"], 1, "file/x.html: cannot be written: File exists"),
        (["file.html", "-o", "file.html"], 1, "file.html: is a result file to be scored"),
        (["one.txt", "--maneuver", "2"], 2, "one.txt: found"),
    ],
)
def test_bad_input_gives_one_line(tmp_path, capsys, arguments, code, message):
    for name in ("file", "file.html"):
        (tmp_path / name).write_text("in the way")
    table = np.loadtxt(RESULT)
    np.savetxt("one.txt", table[:1, :9] + np.r_[20, np.zeros(8)])
    before = sorted(p.name for p in tmp_path.iterdir())
    assert main(["animate", *arguments]) == code
    error = capsys.readouterr().err
    assert error.startswith(f"heyoka-bike: {message}")
    assert error.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == before
