"""A reference, its values and a computed motion have a short text, and a table in a notebook."""

import numpy as np
import pytest

from heyoka_bike import display
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.reference.values import Values
from heyoka_bike.showing import views
from heyoka_bike.showing.document import TableBlock, head
from heyoka_bike.showing.document.html import piece
from heyoka_bike.workbench.fast.simulate import simulate
from support.pages import Page
from support.without_packages import python

COLUMNS = ["roll_angle", "steer_angle"]


def shown(thing):
    """The HTML of an object, checked to be valid and without scripts."""
    page = Page(thing._repr_html_())
    assert {tag for tag, _ in page.tags}.isdisjoint({"script", "iframe", "link"})
    return page


def test_values_at_one_time_are_shown_with_all_digits(reference):
    values = reference[2].evaluate("0.07", COLUMNS)
    first, rule, roll, steer = repr(values).splitlines()
    assert first.split() == ["at", "0.07", "s", "value", "+", "the", "rest"]
    assert set(rule) == {"-"}
    for line, name in ((roll, "roll_angle"), (steer, "steer_angle")):
        words = line.split()
        assert words[:2] == [name, "[rad]"]
        assert [float(x) for x in words[2:]] == [values[name], values.lo[name]]
    assert "0.03396573763788303" in shown(values).text


def test_values_at_some_times_are_a_table(reference):
    times = np.linspace(0, 10, 7)
    values = reference[2].evaluate(times, COLUMNS)
    names, _, *rows = repr(values).splitlines()
    assert names.split() == ["time", "[s]", "roll_angle", "[rad]", "steer_angle", "[rad]"]
    found = np.array([[float(x) for x in row.split()] for row in rows])
    assert np.allclose(found.T, [times, *values.values()], rtol=1e-9, atol=0)


def test_many_times_and_columns_are_cut_and_that_is_said(reference):
    values = reference[2].evaluate(reference[2].time)
    lines = repr(values).splitlines()
    assert len(lines) == 14
    assert max(map(len, lines)) <= 100
    assert lines[-1] == "1001 rows, 40 more columns"
    assert len(shown(values).text) < 2000


def test_values_without_times_are_said_in_a_word(reference):
    for values in (reference[2].rows, reference[2].dense, reference[2].evaluate([], "yaw")):
        assert repr(values).startswith("<values of ")
        assert "values of" in shown(values).text


def test_values_are_a_mapping_of_arrays(reference):
    values = reference[2].evaluate([1.0, 2.0], COLUMNS)
    assert list(values) == COLUMNS
    assert {k: x.shape for k, x in values.items()} == dict.fromkeys(COLUMNS, (2,))
    assert values.time.tolist() == [1.0, 2.0]
    assert values == values
    assert values != reference[2].evaluate([1.0, 2.0], COLUMNS)
    with pytest.raises(KeyError, match="expected roll_angle or steer_angle"):
        values["yaw"]
    pytest.importorskip("pandas")
    frame = values.to_pandas()
    assert frame.index.name == "time"
    assert np.array_equal(frame.loc[2.0, "roll_angle"], values["roll_angle"][1])


def test_a_reference_shows_its_maneuvers(reference):
    page = shown(reference)
    assert reference.content_sha256 in page.text
    assert "4.6" in page.text
    assert len(repr(reference)) < 100
    assert "forward_speed_wheel_spin" in shown(reference[2]).text
    assert "Whole motion" in shown(reference.motion).text


def test_a_trajectory_is_short_and_shows_its_states(bicycle, maneuvers):
    run = integrate(bicycle, maneuvers[1])
    assert len(repr(run)) < 200
    assert "maneuver 2" in repr(run)
    page = shown(run)
    assert f"{float(run.state(maneuvers[1].duration)[0].mid()):.10g}" in page.text


def test_a_simulation_is_short_and_shows_its_rows():
    one = simulate(2)
    assert repr(one) == "<simulation of 1 maneuver: 1001 rows to 10 s>"
    assert f"{one['roll_angle'][-1]:.10g}" in shown(one).text
    assert "Maneuver 3" in shown(simulate()).text


def test_names_are_text_not_markup():
    hostile = "<b onclick=alert(1)>&\"'\x1b[31m\x00"
    times = np.array([0.0, 1.0])
    pieces = (
        shown(Values({hostile: times}, {}, time=times)),
        Page(piece([*head(hostile, hostile), TableBlock([hostile], [[hostile]], hostile)])),
    )
    for page in pieces:
        assert "b" not in {tag for tag, attrs in page.tags if attrs}
        assert "onclick=alert(1)" in page.text


def every_view():
    found, classes = {}, [display.Displayed]
    while classes:
        for c in classes.pop().__subclasses__():
            classes.append(c)
            if "_view" in vars(c):
                found[c] = c._view
    return found


def test_every_class_names_a_view_that_is_there():
    assert callable(views.text)
    for c, name in every_view().items():
        assert callable(getattr(views, name)), c
    assert len(every_view()) > 6


def test_nothing_of_showing_is_imported_before_somebody_looks():
    code = """
import sys
from heyoka_bike import load_reference, score
values = load_reference()[2].evaluate(1.0, "yaw")
report = score("data/peers/exudyn-h0.001.txt")
print(sorted(m for m in sys.modules if m.startswith("heyoka_bike.showing")))
"""
    run = python(code, {"rich", "matplotlib", "pandas"})
    assert run.stdout.strip() == "[]", run.stderr
