"""The page of ``export --page`` shows where a file goes and what was found; keys move in it.

Its charts and its replay show one time, and it calls a maneuver a guess where `score` does.
"""

import numpy as np
import pytest

from generators.published_columns import published_table
from heyoka_bike import score
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.checker.page import checker_page
from support.browser import DROP, browser, wait_until

EXUDYN = data_folder() / "peers" / "exudyn-h0.01.txt"
IS_SHOWN = '!document.getElementById("result").hidden'
# Script that drags a file over the page, from one element to another, and out of the page.
DRAG = """(kinds) => {
  const data = new DataTransfer();
  data.items.add(new File(["0 1"], "x.txt"));
  const drop = document.getElementById("drop"), said = document.getElementById("invitation");
  return kinds.map((kind) => {
    const relatedTarget = kind === "dragleave out" ? null : drop;
    const how = { dataTransfer: data, bubbles: true, cancelable: true, relatedTarget };
    document.body.dispatchEvent(new DragEvent(kind.split(" ")[0], how));
    return [drop.matches(".over"), said.textContent];
  });
}"""
CHOSEN = """() => document.querySelector('[aria-pressed="true"]').getAttribute("aria-label")"""
CURSORS = """() => [...document.querySelectorAll("#detail .cursor")].map((line) =>
  [line.getAttribute("visibility"), Number(line.getAttribute("x1"))])"""


@pytest.fixture(scope="module")
def page():
    return checker_page()


@pytest.fixture
def judged(page, opened):
    """Opens the page and drops a file on it, given by name and text."""

    def judge(name, text, until=IS_SHOWN):
        shown = opened(page)
        shown.evaluate(DROP, [name, text])
        wait_until(shown, until)
        return shown

    return judge


@browser
def test_the_target_says_what_it_takes_and_that_a_file_is_over_it(page, opened):
    shown = opened(page)
    invitation = "Drop a result file here, or click to choose one"
    assert shown.inner_text("#invitation") == invitation
    release = "Release the file to judge it"
    assert shown.evaluate(DRAG, ["dragenter", "dragleave in", "dragover", "dragleave out"]) == [
        [True, release], [True, release], [True, release], [False, invitation],
    ]  # fmt: skip
    # Parts of the page that are not needed at first are folded.
    assert not shown.is_visible("#text")
    assert not shown.is_visible("#wanted")
    assert shown.is_visible("#example")
    assert shown.complaints == []


@browser
def test_a_dropped_file_is_named_and_its_verdict_announced(judged):
    shown = judged(EXUDYN.name, EXUDYN.read_text())
    assert shown.inner_text("#invitation").startswith("exudyn-h0.01.txt: drop another file")
    assert not shown.evaluate("document.getElementById('drop').matches('.over')")
    live = shown.evaluate("""() => [...document.querySelectorAll('[aria-live="polite"]')].map(
        (x) => [x.closest("[hidden]") === null, x.textContent])""")
    assert live == [[True, shown.inner_text("#verdict")]]
    assert live[0][1].startswith("Wrong; the worst column has 1.6 correct digits")


@browser
def test_only_what_is_not_the_default_is_said_of_a_column(judged, reference):
    shown = judged(EXUDYN.name, EXUDYN.read_text())
    taken = shown.locator("#matrix td.taken").all_inner_texts()
    assert taken[0] == "tait_bryan_xyz, not the default lean"
    assert taken[3:] == [""] * 5
    rows = published_table(reference, (2,))
    text = "\n".join(" ".join(map(repr, map(float, row))) for row in rows[::10])
    assert judged("right.txt", text).locator("#matrix .taken").count() == 0


@browser
def test_arrow_keys_choose_the_cells(judged):
    shown = judged(EXUDYN.name, EXUDYN.read_text())
    assert shown.evaluate(CHOSEN).startswith("maneuver 1, steer rate: 1.6 digits")
    # The Tab key stops at one cell of the table only, the chosen one.
    assert shown.locator('#matrix button[tabindex="0"]').count() == 1
    shown.locator('#matrix button[tabindex="0"]').focus()
    for key, wanted in [
        ("ArrowRight", "maneuver 2, steer rate"), ("ArrowUp", "maneuver 2, steer angle"),
        ("End", "maneuver 3, steer angle"), ("ArrowRight", "maneuver 3, steer angle"),
        ("Home", "maneuver 1, steer angle"), ("ArrowDown", "maneuver 1, steer rate"),
        ("ArrowDown", "maneuver 1, steer rate"),
    ]:  # fmt: skip
        shown.keyboard.press(key)
        assert shown.evaluate(CHOSEN).startswith(wanted), key
        assert shown.evaluate("document.activeElement.getAttribute('aria-pressed')") == "true"
        assert shown.inner_text("#what").lower() == wanted
    assert shown.complaints == []


@browser
def test_the_charts_and_the_replay_show_one_time(judged):
    shown = judged(EXUDYN.name, EXUDYN.read_text())
    shown.evaluate("() => showMotions.goTo(1, 2.5)")
    wait_until(shown, "document.querySelector('.clock').textContent === '2.50 s'")
    early = shown.evaluate(CURSORS)
    shown.evaluate("() => showMotions.goTo(1, 5)")
    wait_until(shown, "document.querySelector('.clock').textContent === '5.00 s'")
    late = shown.evaluate(CURSORS)
    assert [v for v, _ in early + late] == ["visible"] * 4
    assert all(b > a for (_, a), (_, b) in zip(early, late, strict=True))
    # A click into the chart moves the replay to that time. A click on a cell changes the maneuver
    # of the replay.
    box = shown.locator("#curve svg").bounding_box()
    shown.mouse.click(box["x"] + 0.75 * box["width"], box["y"] + 0.5 * box["height"])
    wait_until(shown, "document.querySelector('.clock').textContent !== '5.00 s'")
    there = float(shown.inner_text(".clock").removesuffix(" s"))
    # Because of its marks, the axis is narrower than the chart.
    assert there == pytest.approx(7.5, abs=0.5)
    shown.click('[aria-label^="maneuver 3, roll angle"]')
    assert shown.is_checked('input[name="maneuver"][value="3"]')
    wait_until(shown, "document.querySelector('#detail .cursor').getAttribute('x1') !== null")
    assert [v for v, _ in shown.evaluate(CURSORS)] == ["visible"] * 2


@browser
def test_what_the_digits_of_a_file_cannot_show_is_no_difference(judged, reference):
    """The file has six decimals; formerly the page showed a difference of 1.6e-39."""
    rows = published_table(reference, (2,))
    text = "\n".join(" ".join(f"{x:.6f}" for x in row) for row in rows)
    shown = judged("six.txt", text)
    shown.evaluate("() => showMotions.goTo(2, 3.21)")
    wait_until(shown, "document.querySelector('.clock').textContent === '3.21 s'")
    cells = shown.locator(".values tbody tr td:last-child").all_inner_texts()
    names = shown.locator(".values tbody th").all_inner_texts()
    differences = dict(zip(names, cells, strict=True))
    assert {differences[x] for x in ("roll [rad]", "steer [rad]", "speed [m/s]")} == {"0"}


def of_another_speed(reference):
    """Return maneuver 1 without roll and steer, its speed wrong by the ratio of the wheel radii."""
    rows = published_table(reference, (1,))
    rows[:, 3] *= 0.35 / 0.3
    rows[:, 1:3] = 0.0
    rows[:, 7:] = 0.0
    return "\n".join(" ".join(f"{x:.9g}" for x in row) for row in rows[::10])


@browser
def test_a_guessed_maneuver_is_called_a_guess_and_can_be_chosen(judged, reference, tmp_path):
    text = of_another_speed(reference)
    path = tmp_path / "guess.txt"
    path.write_text(text)
    (finding,) = [f for f in score(path).said if f.code == "maneuver_guessed"]
    chosen, may_be = finding.evidence["maneuver"], finding.evidence["may_be"]
    shown = judged("guess.txt", text)
    said = f"maneuver {chosen}, which is a guess: it may also be maneuver {may_be[0]}"
    assert said in shown.inner_text("#guess")
    assert said in shown.inner_text("#announced")
    assert shown.input_value("#maneuver") == str(chosen)
    shown.select_option("#maneuver", str(may_be[0]))
    assert f"maneuver {may_be[0]}, as chosen" in shown.inner_text("#facts")
    assert shown.inner_text("#guess") == ""
    assert shown.is_visible("#maneuver")


@browser
def test_a_maneuver_that_is_not_recognised_can_be_chosen(judged):
    text = "\n".join(" ".join([f"{i / 50}", *[f"{1e3 * np.cos(i):.3f}"] * 8]) for i in range(50))
    shown = judged("none.txt", text, 'document.getElementById("problem").textContent !== ""')
    assert "unlike every maneuver" in shown.inner_text("#problem")
    assert shown.input_value("#maneuver") == ""
    shown.select_option("#maneuver", "3")
    assert "maneuver 3, as chosen" in shown.inner_text("#facts")
    assert shown.inner_text("#problem") == ""
