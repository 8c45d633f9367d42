"""Positions in charts show the values, and no extreme is lost."""

import re

import numpy as np
import pytest

from heyoka_bike.scoring.score import score
from heyoka_bike.showing.charts import chart as axis
from heyoka_bike.showing.charts.chart import Level, Line, chart, envelope, highest
from heyoka_bike.showing.charts.results import run_time
from heyoka_bike.system.resources import data_folder


def uneven(n):
    """Increasing times with very different steps, some of which are zero."""
    steps = np.random.default_rng(1).exponential(size=n) ** 3
    steps[::7] = 0.0
    return np.cumsum(steps)


@pytest.mark.parametrize("times", [np.linspace(0.0, 10.0, 100_001), uneven(100_001)])
def test_decimation_keeps_the_extremes_of_every_bin(times):
    values = np.random.default_rng(2).normal(size=len(times))
    bins = 200
    kept = [envelope(times, values, bins), highest(times, values, bins)]
    given = set(zip(times.tolist(), values.tolist(), strict=True))
    edges = np.linspace(times[0], times[-1], bins + 1)
    where = np.clip(np.searchsorted(edges, times, side="right") - 1, 0, bins - 1)
    for (x, y), most in zip(kept, (2 * bins, bins), strict=True):
        assert len(x) <= most
        assert set(zip(x.tolist(), y.tolist(), strict=True)) <= given
        assert (np.diff(x) >= 0).all()
        of = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, bins - 1)
        for i in np.unique(where):
            assert y[of == i].max() == values[where == i].max()
    x, y = kept[0]
    of = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, bins - 1)
    assert all(y[of == i].min() == values[where == i].min() for i in np.unique(where))


@pytest.mark.parametrize("n", [0, 1, 2, 399, 400])
def test_few_points_stay_as_they_are(n):
    x, y = np.arange(n, dtype=float), np.sin(np.arange(n))
    assert envelope(x, y, 200)[0] is x
    assert len(highest(x, y, 200)[0]) == min(n, 200)


def test_points_at_one_time_are_no_trouble():
    x, y = np.zeros(1000), np.arange(1000.0)
    assert [v.tolist() for v in envelope(x, y, 100)] == [[0.0, 0.0], [0.0, 999.0]]


@pytest.mark.parametrize(
    ("low", "high"), [(1e-13, 2e-2), (3.0, 4.0), (1e-40, 1e3), (1e-5, 1e-5), (1e-300, 1e-290)]
)
def test_decades_are_ticks_and_the_labels_are_few(low, high):
    found = axis.decades(low, high)
    assert found.low <= np.log10(low) + 1e-6
    assert found.high >= np.log10(high) - 1e-6
    assert len(found.ticks) == found.high - found.low + 1
    labels = [text for _, text in found.ticks if text]
    assert 1 <= len(labels) <= 8
    for at, text in found.ticks:
        power = re.sub(r"<[^>]*>", "^", text).strip("^").replace("−", "-")
        if "^" in power:
            exponent = float(power.partition("^")[2])
            assert found.at(10.0**exponent) == pytest.approx(at, abs=1e-9)


@pytest.mark.parametrize(
    ("low", "high"),
    [(0.0, 10.0), (-0.2, 0.17), (1837.03, 1837.03), (3123.91, 3123.98), (0.0, 0.0), (-1e9, 2e9),
     (1e-12, 2e-12), (-5.0, -4.9999)],
)  # fmt: skip
def test_labels_of_a_linear_axis_are_their_values(low, high):
    found = axis.linear(low, high)
    assert 0 <= found.at(low) <= found.at(high) <= 1
    assert 2 <= len(found.ticks) <= 9
    assert len({text for _, text in found.ticks}) == len(found.ticks)
    for at, text in found.ticks:
        assert 0 <= at <= 1
        assert len(text) <= 8
        value = float(text.replace("−", "-")) + found.offset
        assert found.at(value) == pytest.approx(at, abs=2e-3)


def test_an_axis_of_one_time_has_a_width():
    found = axis.times(5.0, 5.0)
    assert found.at(5.0) == 0.5


def test_a_spread_of_steps_has_labels_at_1_2_and_5():
    found = axis.spread(1.25e-3, 1e-2)
    assert [text for _, text in found.ticks] == ["0.001", "0.002", "0.005", "0.01"]
    for at, text in found.ticks:
        assert found.at(float(text)) == pytest.approx(at)
    assert [text for _, text in axis.spread(1e-3, 1e-3).ticks] == ["0.001"]


def drawn(y_axis, x, y, **more):
    return chart(
        axis.times(0.0, 10.0), y_axis, [Line("a<b", "error", x, y, "rad")], about="a<b & c",
        title="<e>", x_title="time [s]", height=120, **more,
    )  # fmt: skip


def places(text):
    """Return the points of the first line, from 0 to 1."""
    steps = re.search(r'<path class="error" data-name[^>]* d="M([^"]*)"', text)[1]
    found = np.array(re.findall(r"-?\d+", steps), dtype=float).reshape(-1, 2).cumsum(axis=0)
    return found[:, 0] / 4000, 1 - found[:, 1] / 2000


def test_lines_go_through_their_points():
    t = np.linspace(0.0, 10.0, 300)
    y = 1e-3 * (2 + np.sin(t))
    x_found, y_found = places(drawn(axis.decades(1e-4, 1e-2), t, y))
    np.testing.assert_allclose(10 * x_found, t, atol=10 / 4000)
    np.testing.assert_allclose(-4 + 2 * y_found, np.log10(y), atol=2 / 2000)
    x_found, y_found = places(drawn(axis.linear(0.0, 4e-3), t, y))
    np.testing.assert_allclose(-1.6e-4 + 4.32e-3 * y_found, y, atol=4.32e-3 / 2000)


def test_an_error_of_zero_leaves_the_chart_below():
    t = np.linspace(0.0, 10.0, 100)
    y = np.where(t < 5, 0.0, 1e-3)
    _, found = places(drawn(axis.decades(1e-6, 1e-2), t, y))
    assert (found[t < 5] < 0).all()
    assert (found[t >= 5] == 0.75).all()


def test_few_rows_are_drawn_as_points_too():
    one = drawn(axis.decades(1e-6, 1e-2), np.array([5.0]), np.array([1e-4]))
    assert re.findall(r'<circle cx="(\S+?)" cy="(\S+?)"', one) == [("50%", "60")]
    many = drawn(axis.decades(1e-6, 1e-2), np.linspace(0, 10, 100), np.full(100, 1e-4))
    assert "<circle" not in many


def test_text_of_a_chart_is_escaped():
    text = drawn(
        axis.decades(1e-6, 1e-2), np.zeros(1), np.ones(1), levels=[Level(1e-3, "l", "<x>")]
    )
    assert not re.search(r"<[exb]>|a<b", text)
    assert 'aria-label="a&lt;b &amp; c"' in text
    assert "&lt;x&gt;" in text


def test_a_column_that_ends_early_does_not_end_the_others():
    """Formerly the figure ended with the first column, and an error at 10 s was outside."""
    rows = np.loadtxt(data_folder() / "peers" / "exudyn-h0.01.txt")
    rows[500:, 8] = np.nan
    (maneuver, *_) = score(rows).maneuvers
    time = run_time([maneuver])
    assert (maneuver.t_end, time.low, time.high) == (4.99, 0.0, 10.0)
