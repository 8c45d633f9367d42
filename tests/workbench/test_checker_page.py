"""The page of ``export --page`` judges in the browser, alone and offline, as `score` does."""

import base64
import json
import re
import shutil
import subprocess
import zlib

import numpy as np
import pytest

from checker_wasm import build, source_hash
from generators.bad_links import CELL
from generators.published_columns import published_table
from heyoka_bike import read_results, score
from heyoka_bike.cli import main
from heyoka_bike.errors import BicycleError
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.checker.page import KEPT
from heyoka_bike.workbench.replay.page import SCRIPT, STYLE
from heyoka_bike.workbench.replay.scenes import replay
from support.browser import DROP, WIDTHS, browser, wait_until, widths
from support.pages import Page

PEERS = data_folder() / "peers"
EXUDYN = PEERS / "exudyn-h0.01.txt"
# Expression that is true once a link or a file has led to a result, or to the reason why there is
# none.
IS_OVER = """document.getElementById("problem").textContent !== ""
    || !document.getElementById("result").hidden"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    assert main(["export", "--page", "-o", f"{folder}/"]) == 0
    return (folder / "uncontrolled_bicycle.html").read_text(encoding="utf-8")


def test_the_page_stands_alone(page):
    assert len(page.encode()) < 1_500_000
    found = Page(page)
    (policy,) = [a["content"] for a in found.all("meta") if "http-equiv" in a]
    assert re.fullmatch(
        r"default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
        r"script-src 'sha256-[\w+/=]+' 'wasm-unsafe-eval'",
        policy,
    )
    assert not re.search(r"url\(|@import|\bfetch\b|XMLHttpRequest|sendBeacon|WebSocket", page)
    urls = set(re.findall(r"https?://[^\s\"'<>)]+", page))
    assert urls == {"https://jfly.uni-koeln.de/color/.", "http://www.w3.org/2000/svg"}
    for tag, attributes in found.tags:
        for key, value in attributes.items():
            assert not key.startswith("on"), (tag, key)
            assert key not in ("src", "href", "action") or value == "data:,", (tag, key)


def test_every_control_has_a_name(page):
    # Every control of the replay is inside its label. Every other control has a separate label with
    # its id, or an aria-label.
    inside = re.findall(r"<label(?: class=\"\w+\")?><(?:input|select) .*?</label>", page)
    inside += re.findall(r"<label(?: class=\"\w+\")?>\w+ <select .*?</label>", page)
    assert all(Page(x).text for x in inside)
    found = Page(re.sub("|".join(map(re.escape, inside)), "", page))
    named = {a["for"] for a in found.all("label")}
    controls = [*found.all("input"), *found.all("select"), *found.all("textarea")]
    assert {a["id"] for a in controls if "aria-label" not in a} == named


def test_the_judge_in_it_is_that_of_the_header():
    """If this fails, run python docs/_site/checker_wasm.py, with clang and lld."""
    assert source_hash().encode() in KEPT.read_bytes()


@pytest.mark.proof
def test_the_judge_is_built_anew_as_it_is_kept():
    if shutil.which("clang") is None or shutil.which("wasm-ld") is None:
        pytest.skip("clang and lld are not installed")
    version = subprocess.run(["clang", "--version"], capture_output=True, text=True).stdout
    if "clang version 14.0.6" not in version:
        pytest.skip("kept is what Debian's clang 14.0.6 builds")
    assert build() == KEPT.read_bytes()


def packed(kind, content):
    compress = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = compress.compress(json.dumps(content).encode()) + compress.flush()
    return f"#{kind}={base64.urlsafe_b64encode(data).decode().rstrip('=')}"


@pytest.fixture
def judged(page, opened):
    """Opens the page and waits until it has judged the content of an address."""

    def judge(within, **how):
        # The browser is offline, so that no request could succeed.
        return opened(page, within, until=IS_OVER, offline=True, **how)

    return judge


def of_text(name, text):
    return packed("text", {"name": name, "text": text})


def said(dom, name):
    return Page(re.search(rf'<p [^>]*id="{name}"[^>]*>.*?</p>', dom, re.DOTALL)[0]).text


def verdict_of(dom):
    """Return the page's verdict as `score` writes it: without capital letter and full stop."""
    (text,) = re.findall('<span id="verdict">(.*?)</span>', dom)
    return text[:1].lower() + text[1:].removesuffix(".")


def matrix(dom):
    """Return the digits by column and maneuver."""
    found = {}
    for name, row in re.findall(r'<tr><th scope="row">([\w ]+)</th>(.*?)</tr>', dom):
        for maneuver, digits in re.findall(
            r'aria-label="maneuver (\d), [\w ]+: (-?[\d.]+) digits', row
        ):
            found[int(maneuver), name.replace(" ", "_")] = float(digits)
    return found


@pytest.mark.proof
@browser
@pytest.mark.parametrize("name", ["exudyn-h0.01.txt", "scipy-rtol1e-7.txt"])
def test_it_says_what_score_says(judged, name):
    shown = judged(of_text(name, (PEERS / name).read_text()))
    dom = shown.content()
    assert shown.complaints == []
    assert said(dom, "problem") == ""
    report = score(PEERS / name)
    verdict = report.verdict.partition(": ")[2]
    assert verdict_of(dom) == verdict.partition(")")[0] + ")"
    found = matrix(dom)
    assert set(found) == {(m.maneuver, c.key) for m in report.maneuvers for c in m.columns}
    for (m, key), digits in found.items():
        assert digits == pytest.approx(min(report[m][key].scd, 14.0), abs=0.1)
    # The table contains the ten worst rows. Marks show where their digits begin to differ.
    rows = re.findall(r"<tr><td>([\d.]+)</td><td>(.*?)</td><td>(.*?)</td><td>", dom)
    assert len(rows) == 10
    worst = report.worst
    column = report[worst.maneuver][worst.column]
    assert float(rows[0][0]) == column.time_of_max
    for _, mine, exact in rows:
        heads = [x.partition("<mark>")[0] for x in (mine, exact)]
        assert heads[0] == heads[1]
        assert "<mark>" in mine


def table(reference, numbers=(1, 2, 3), every=10):
    return published_table(reference, numbers, every)


def as_text(rows, separator=" ", heading=""):
    lines = [separator.join(f"{x:.17g}" for x in row) for row in rows]
    return "\n".join([heading, *lines] if heading else lines) + "\n"


def quoted(text):
    return "".join(",".join(f'"{x}"' for x in line.split(",")) + "\n" for line in text.splitlines())


@pytest.mark.proof
@browser
def test_texts_of_many_kinds(judged, reference):
    rows = table(reference)
    one = table(reference, (2,))
    degrees = one[:, [0, 7, 1]] * np.array([1, -180 / np.pi, -180 / np.pi])
    heading = "time,maneuver_2_steer_angle,m2_roll_angle [deg]"
    two = "right, compared only in part (2 of 8 columns); the worst column has 1"
    constant = one.copy()
    constant[:, 6] = np.round(one[0, 6], 1)  # five digits, while the other columns have 17
    cases = {
        "comma": (as_text(rows, ","), "right; the worst column has 1", 24),
        "semicolon": (as_text(rows, "; ", "a line; of text"), "right; the worst column has 1", 24),
        "fortran": (as_text(rows).replace("e", "D"), "right; the worst column has 1", 24),
        "one": (as_text(one), "right; the worst column has 1", 8),
        "named": (as_text(degrees, ",", heading), two, 2),
        "quoted": (quoted(as_text(degrees, ",", heading)), two, 2),
        "milliseconds": (as_text(degrees * [1e3, 1, 1], ",", heading.replace("time", "t [ms]")),
                         two, 2),
        "decimal commas": (
            as_text(rows, ";").replace(".", ","), "right; the worst column has 1", 24
        ),
        "counted": (as_text(rows, " ", " ".join(map(str, range(1, 26)))), "right; the worst", 24),
        "part": (
            as_text(rows[:80]), "right, compared only in part; the worst column has 1", 24
        ),
        "constant": (as_text(constant), "close; the worst column has 4.", 8),
    }  # fmt: skip
    for name, (text, verdict, count) in cases.items():
        shown = judged(of_text(name, text))
        dom = shown.content()
        assert shown.complaints == [], name
        assert verdict_of(dom).startswith(verdict), name
        assert len(matrix(dom)) == count, name


@pytest.mark.proof
@browser
def test_what_cannot_be_read_is_told_as_score_tells_it(judged, tmp_path):
    row = "1.0 " * 8
    cases = [
        "", "hello world\nfoo\n",
        *(f"{'0.5 1.0 ' * n}\n{'0.6 1.0 ' * n}\n" for n in (3, 7)),
        "".join(f"{i / 10} {row}\n" for i in range(7)) + f"0.7 {row[4:]}\n0.8 {row}\n",
    ]  # fmt: skip
    for text in cases:
        path = tmp_path / "mine.txt"
        path.write_text(text)
        dom = judged(of_text("mine.txt", text)).content()
        with pytest.raises(BicycleError) as raised:
            read_results(path)
        line = str(raised.value).replace(str(path), "mine.txt")
        # The page and `score` use the same words for what they found in the file. Their words for
        # expected headings and options differ.
        found, expected = line.split(", expected ", 1)
        same = f"{found}, expected {re.split(',| columns', expected)[0]}"
        assert said(dom, "problem").startswith(same), line
        assert "heyoka-bike score mine.txt" in said(dom, "problem")
        assert 'id="result" aria-label="Result" hidden' in dom


@pytest.mark.proof
@browser
def test_a_file_is_dropped_and_its_result_is_linked(page, opened, judged):
    dropped = opened(page)
    dropped.evaluate(DROP, ["dropped.txt", EXUDYN.read_text()])
    wait_until(dropped, IS_OVER)
    dropped.click("#link")
    wait_until(dropped, "location.hash.startsWith('#result=')")
    dom, address = dropped.content(), dropped.evaluate("location.hash")
    assert dropped.complaints == []
    assert "dropped.txt: 1001 of 1001 rows compared, 0 to 10 s of 0 to 10 s" in said(dom, "facts")
    assert re.fullmatch("#result=[\\w-]+", address)
    assert len(address) < 8000
    shown = judged(address)
    linked = shown.content()
    assert shown.complaints == []
    assert verdict_of(linked) == f"shared, not checked here: {verdict_of(dom)}"
    assert 'class="verdict shared"' in linked
    assert matrix(linked) == matrix(dom)
    assert "drop the file to judge it" in said(linked, "facts")


def shared(*cells, **changes):
    return packed("result", {"name": "x.csv", "whole": True, "cells": [*cells]} | changes)


FORGED = {
    "a verdict of its own": packed(
        "result",
        {
            "name": "my-engine.csv",
            "line": "right; the worst column has 14.0 correct digits",
            "style": "right",
            "remarks": ["1001 rows"],
            "cells": [],
        },
    ),
    "a verdict beside cells": shared(CELL, line="right; the worst column has 14.0 correct digits"),
    "no cell": shared(),
    "no cells": shared(cells=None),
    "null": packed("result", None),
    "null as text": packed("text", None),
    "a number as text": packed("text", {"name": "x", "text": 1}),
    "an object as name": packed("text", {"name": {}, "text": "0 1\n"}),
    "cells of null": shared(None),
    "twice": shared(CELL, CELL),
    "another key": shared(CELL | {"more": 1}),
    "a key less": shared({k: v for k, v in CELL.items() if k != "rms_error"}),
    "a column that is a word": shared(CELL | {"key": "constructor"}),
    "a column by inheritance": shared(CELL | {"key": "__proto__"}),
    "another column": shared(CELL | {"column": 3}),
    "no rows": shared(CELL | {"rows": 0}),
    "digits in words": shared(CELL | {"digits": "14"}),
    "damaged": "#result=AAAA",
    "no code": "#text=!!",
    "something else": "#x",
    "cut": shared(CELL)[:-9],
    "too much": packed("text", {"name": "x", "text": " " * 65_000_000}),
}


@pytest.mark.proof
@browser
@pytest.mark.parametrize("kind", FORGED)
def test_a_bad_link_is_one_line(judged, kind):
    shown = judged(FORGED[kind])
    dom = shown.content()
    assert shown.complaints == []
    assert 'id="result" aria-label="Result" hidden' in dom
    assert verdict_of(dom) == ""
    assert said(dom, "problem").startswith("the link ") or kind == "a number as text"
    assert said(dom, "problem")


@pytest.mark.proof
@browser
def test_the_verdict_of_a_link_follows_from_its_cells(judged):
    wrong = CELL | {"key": 1, "column": 1, "grade": 4, "digits": 1.6, "max_error": 0.1}
    every = [CELL | {"key": k, "column": k} for k in range(8)]
    other = CELL | {"maneuver": 2}
    worst = "the worst column has 14.0 correct digits (roll_angle in maneuver 1)"
    for cells, whole, verdict in [
        (every, True, f"right; {worst}"),
        (every, False, f"right, compared only in part; {worst}"),
        (every[:5], True, f"right, compared only in part (5 of 8 columns); {worst}"),
        (
            (*every, other),
            True,
            f"right, compared only in part (1 of 8 columns in maneuver 2); {worst}",
        ),
        (
            (CELL, wrong),
            True,
            "wrong; the worst column has 1.6 correct digits (roll_rate in maneuver 1)",
        ),
    ]:  # fmt: skip
        shown = judged(shared(*cells, whole=whole))
        dom = shown.content()
        assert shown.complaints == []
        assert verdict_of(dom) == f"shared, not checked here: {verdict}"
        assert 'class="verdict shared"' in dom


@pytest.mark.proof
@browser
def test_rows_outside_the_run_are_no_verdict(judged, reference):
    """With negative times only one row remained, and the page once called the file correct."""
    rows = table(reference, (2,))
    rows[:, 0] *= -1
    shown = judged(of_text("x", as_text(rows[::-1])))
    dom = shown.content()
    assert shown.complaints == []
    assert "found 1 of 101 rows within the run" in said(dom, "problem")
    assert verdict_of(dom) == ""


@pytest.mark.proof
@browser
def test_what_a_link_says_stays_text(judged):
    name = '<img src=x onerror="document.title=1">'
    shown = judged(of_text(name, as_text(np.loadtxt(EXUDYN)[::20])))
    dom = shown.content()
    assert shown.complaints == []
    assert "<img" not in dom
    assert name in said(dom, "facts")


@pytest.mark.proof
@browser
def test_nothing_is_cut_off_in_a_narrow_window(page, opened, judged):
    address = of_text("x", as_text(np.loadtxt(EXUDYN)[::20]))
    for content, window in widths(opened, page, address, until=IS_OVER):
        assert content <= window
    hidden_by_width = []
    for width in WIDTHS:
        shown = judged(address, width=width)
        # The script returns the labels of axes that leave their drawing, and all labels that are
        # drawn.
        cut, every = shown.evaluate("""() => {
            const drawn = [...document.querySelectorAll(".curve")].filter((s) => s.clientWidth);
            const letters = drawn.flatMap((svg) => {
                const box = svg.getBoundingClientRect();
                return [...svg.querySelectorAll("text")].map((text) => {
                    const { left, right } = text.getBoundingClientRect();
                    return left < box.left - 1 || right > box.right + 1;
                });
            });
            return [letters.filter(Boolean).length, letters.length];
        }""")
        assert cut == 0
        assert every > 15
        # A table that is wider than the window is shaded at its sides.
        hidden, shades = shown.evaluate("""() => {
            const box = document.querySelector("#worst").parentElement;
            const shades = getComputedStyle(box).backgroundImage.split("gradient").length - 1;
            return [box.scrollWidth - box.clientWidth, shades];
        }""")
        assert shades == 4
        hidden_by_width.append(hidden)
    assert hidden_by_width[0] > 0
    assert hidden_by_width[2:] == [0, 0]


@pytest.mark.proof
@browser
def test_before_a_file_is_there_the_exact_motion_is_shown(page, opened):
    shown = opened(page, until="document.querySelectorAll('#asked [aria-label^=Exact]').length")
    dom = shown.content()
    assert shown.complaints == []
    section = dom.partition('<section id="asked"')[2].partition("</section>")[0]
    assert re.findall(r'aria-label="(Exact .*?)"', section) == [
        f"Exact roll angle of maneuver {n}" for n in (1, 2, 3)
    ]
    assert 'id="asked" aria-label="The exact motion" hidden' not in dom
    shown.click("#example")
    wait_until(shown, IS_OVER)
    assert 'id="asked" aria-label="The exact motion" hidden' in shown.content()


def test_the_replay_is_that_of_animate(page):
    """Both use one script and one style; formerly the page drew a T of its own."""
    assert SCRIPT.read_text(encoding="utf-8") in page
    assert STYLE.read_text(encoding="utf-8") in page
    assert len(Page(page).all("canvas")) == 1


# Script that returns what the replay of the page shows: its scenes with their notes, the list of
# notes, the number of cells in each row of values, and whether it compares two motions.
SCENES = """() => {
  const found = scenesBeside(shown, exactly).map(({ scene, notes }) => ({ ...scene, notes }));
  const notes = [...document.querySelectorAll("#moving li")].map((x) => x.textContent);
  const cells = [...document.querySelectorAll(".values tbody tr")].map((x) => x.cells.length);
  const isCompared = document.querySelector(".replay").matches(".compared");
  return JSON.parse(JSON.stringify({ found, notes, cells, isCompared }));
}"""


def scenes_shown(judged, name, text):
    shown = judged(of_text(name, text))
    assert shown.complaints == []
    return shown.evaluate(SCENES)


@pytest.mark.proof
@browser
def test_the_replay_shows_a_result_where_animate_shows_it(judged, reference):
    told = scenes_shown(judged, EXUDYN.name, EXUDYN.read_text())
    right = replay(reference, read_results(EXUDYN))
    assert told["isCompared"]
    assert set(told["cells"]) == {4}
    assert len(told["found"]) == 3
    for scene, found in zip(right.scenes, told["found"], strict=True):
        exact, mine = scene.reference.motion, scene.result.motion
        places = {"yaw": "yaw", "pitch": "pitch", "roll": "roll", "steer": "steer",
                  "rear_wheel": "rear_wheel", "front_wheel": "front_wheel",
                  "track": "rear_track"}  # fmt: skip
        values = {name: (getattr(exact, key), getattr(mine, key)) for name, key in places.items()}
        for i, axis in enumerate("xy"):
            values[axis] = (exact.rear_contact[:, i], mine.rear_contact[:, i])
            values[f"front_{axis}"] = (exact.front_contact[:, i], mine.front_contact[:, i])
        assert found["duration"] == 10
        for name, (one, other) in values.items():
            np.testing.assert_allclose(found["columns"][name], one, atol=2e-7, err_msg=name)
            difference, wanted = found["result"]["differences"][name], other - one
            size = np.abs(wanted).max()
            np.testing.assert_allclose(difference, wanted, atol=1e-3 * size + 1e-13, err_msg=name)
        assert tuple(found["notes"]) == scene.result.notes
        assert set(found["notes"]) <= set(told["notes"])


@pytest.mark.proof
@browser
def test_the_replay_says_what_is_not_of_the_file(judged, tmp_path, reference):
    """The page uses `animate`'s words for parts from the reference, and for the end of a run."""
    one = table(reference, (2,))
    rolls = one[:, :2].copy()
    falls = rolls.copy()
    falls[:, 1] += np.maximum(falls[:, 0] - 4, 0)
    cases = {
        "roll.csv": (rolls, "time,m2_roll_angle", "the values of the reference are used instead."),
        "late.csv": (rolls[20:], "time,m2_roll_angle", "The rows of the file begin at 2 s"),
        "short.csv": (rolls[:60], "time,m2_roll_angle", "The rows of the file end at 5.9 s."),
        "falls.csv": (falls, "time,m2_roll_angle", "its bicycle has fallen."),
        "energy.csv": (one[:, [0, 4]], "time,m2_potential_energy", "no usable column"),
    }
    for name, (rows, heading, wanted) in cases.items():
        text = as_text(rows, ",", heading)
        told = scenes_shown(judged, name, text)
        assert any(wanted in note for note in told["notes"]), (name, told["notes"])
        assert told["isCompared"] == (name != "energy.csv")
        assert told["found"][0]["result"] is None
        assert told["found"][0]["notes"] == ["The file does not contain maneuver 1."]
        if name == "energy.csv":
            continue
        path = tmp_path / name
        path.write_text(text)
        (scene,) = replay(reference, read_results(path), 2).scenes
        assert tuple(told["found"][1]["notes"]) == scene.result.notes
        assert told["found"][1]["result"]["first"] == scene.result.first


@pytest.mark.proof
@browser
def test_the_replay_rests_until_it_is_asked(page, opened):
    """The replay starts only on request, and does not capture keys of the rest of the page."""
    shown = opened(page, is_stopped=True)
    shown.clock.run_for(1500)
    assert shown.inner_text(".clock") == "0.00 s"
    assert shown.get_attribute(".play", "aria-label") == "Play"
    taken = shown.evaluate("""() => {
        const press = (where, key) => !where.dispatchEvent(
            new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
        const text = document.getElementById("text"), canvas = document.querySelector("canvas");
        return [press(text, " "), press(document.body, "End"), press(canvas, "End")];
    }""")
    shown.clock.run_for(100)
    assert taken == [False, False, True]
    assert shown.inner_text(".clock") == "10.00 s"
    assert shown.complaints == []


@pytest.mark.proof
@browser
def test_the_replay_shows_a_result_no_longer_than_it_is_there(page, opened, judged):
    shown = opened(page)
    shown.click("#example")
    shown.wait_for_selector(".replay.compared")
    shown.click("#paste summary")
    shown.fill("#text", "hello")
    shown.click("#judge")
    shown.wait_for_selector(".replay:not(.compared)")
    assert shown.locator("#moving li").count() == 0
    assert shown.complaints == []
    linked = judged(shared(CELL))
    assert linked.complaints == []
    assert "so only the exact motion is shown" in linked.content()
    assert linked.locator(".replay.compared").count() == 0


@pytest.mark.proof
@browser
def test_lines_of_numbers_are_read_or_quoted(judged, reference):
    lines = as_text(table(reference, (2,))).splitlines()
    read = {
        "fortran": ["2*0. " + lines[0].split(" ", 2)[2], *lines[1:]],
        "mathematica": [line.replace("e-", "*^-") for line in lines],
    }
    for name, text in read.items():
        dom = judged(of_text(name, "\n".join(text))).content()
        assert verdict_of(dom).startswith("right; the worst column has 1"), name
        assert "not read" not in said(dom, "facts"), name
    assert lines[0].startswith("0 0 ")
    dom = judged(of_text("x", "\n".join(["2*, 9", "# dt = 0.1", *lines, "# 1 2 3 4 5 6 7 8 9"])))
    assert '2 lines with numbers were not read: line 1: "2*, 9", line 104: "# 1 2 3' in said(
        dom.content(), "facts"
    )
    dom = judged(of_text("x", "\n".join(["  1.0e+03 *", *lines]))).content()
    assert "MATLAB's common factor" in said(dom, "problem")
