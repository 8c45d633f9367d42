"""Page, leaderboard and plugin give the verdict of `score`, or report that the file cannot be read.

`test_checker_agrees_with_score.py` compares the header with `score`.
"""

from collections import Counter

import numpy as np
import pytest

from games.voices import NODE, PageJudge, by_score, compare, disagreements, texts
from generators.published_columns import published_table
from heyoka_bike import score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.showing.wording.grade_text import file_grade
from heyoka_bike.system.resources import data_folder
from heyoka_bike.testing.regression import Score

PEERS = data_folder() / "peers"
node = pytest.mark.skipif(NODE is None, reason="Node.js is not installed")


@pytest.fixture(scope="module")
def judge(tmp_path_factory):
    return PageJudge(tmp_path_factory.mktemp("page"))


@node
@pytest.mark.parametrize(("game", "least"), [("honest", 6), ("wrong", 8)])
def test_some_files_of_the_games(judge, game, least, tmp_path):
    said = []
    counts = compare(judge, texts(game, range(3000, 3020), tmp_path), said.append)
    assert said == []
    assert counts["compared"] >= least


@node
@pytest.mark.parametrize("game", ["honest", "wrong"])
@pytest.mark.parametrize(
    ("count", "least"),
    [
        pytest.param(60, 25, marks=pytest.mark.proof),
        pytest.param(250, 120, marks=pytest.mark.slow),
    ],
)
def test_files_of_the_games(judge, game, count, least, tmp_path):
    said = []
    counts = compare(judge, texts(game, range(2000, 2000 + count), tmp_path), said.append)
    assert said == []
    assert counts["compared"] >= least


@node
def test_programs_of_the_field(judge):
    paths = sorted(p for p in PEERS.glob("*.txt") if "forces" not in p.name)
    for path, said in zip(paths, judge.judge(paths), strict=True):
        assert list(disagreements(by_score(path), said)) == []
        assert "refused" not in said, path.name


def write(path, names, rows, separator=",", quote=""):
    lines = [names, *([repr(float(x)) for x in row] for row in rows)]
    path.write_text(
        "".join(separator.join(f"{quote}{x}{quote}" for x in line) + "\n" for line in lines)
    )
    return path


HEADINGS = [
    # Heading and factor of the written times. The expected result is the one of `score`.
    ("t [ms]", 1000.0), ("time [s]", 1.0), ("time", 1.0), ("t", 1.0), ("t [min]", 1 / 60),
    ("time_ms", 1000.0), ("seconds", 1.0), ("timestamp [ns]", 1e9),
]  # fmt: skip


@node
@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("quote", ["", '"'])
@pytest.mark.parametrize(("heading", "factor"), HEADINGS)
def test_units_quotes_and_separators(judge, heading, factor, quote, separator, tmp_path, reference):
    if " " in heading and separator == " ":
        quote = '"'
    rows = np.column_stack(
        [factor * reference[2].time, *(reference[2][k] for k in BENCHMARK_COLUMNS)]
    )
    names = [heading, *(f"m2_{k}" for k in BENCHMARK_COLUMNS)]
    path = write(tmp_path / "r.txt", names, rows[::10], separator, quote)
    (said,) = judge.judge([path])
    assert list(disagreements(by_score(path), said)) == []
    if heading in ("t [ms]", "time [s]", "time") and separator != " ":
        assert said["line"].startswith("right"), said


@node
@pytest.mark.parametrize(
    ("changed", "refused"),
    [
        (lambda names: ["time", *[f"{x} (rear frame)" for x in names[1:]]], "the heading"),
        (lambda names: [*names[:-1], names[-2]], "expected one column of each"),
        (lambda names: ["time", "foo", *names[2:]], 'the heading "foo"'),
        (lambda names: ["x", *names[1:]], 'the heading "x"'),
        (lambda names: names[:-1], "does not fit 9 columns"),
        (lambda names: ["time", "roll_angle [furlong]", *names[2:]], "roll_angle [furlong]"),
        (lambda names: ["time", "roll_angle [deg]", *names[2:]], "by its heading"),
    ],
)
def test_what_is_not_understood_is_refused(judge, changed, refused, tmp_path, reference):
    names = changed(["time", *BENCHMARK_COLUMNS])
    path = write(tmp_path / "r.csv", names, published_table(reference, (2,), every=10))
    (said,) = judge.judge([path])
    assert refused in said["refused"]


@node
def test_a_page_that_is_more_generous_is_seen(tmp_path, reference):
    """The test would notice the old page, which ignored units in headings."""
    judge = PageJudge(tmp_path)
    script = tmp_path / "reading.js"
    script.write_text(script.read_text().replace('unit: unit ? named : ""', 'unit: ""'))
    rows = np.column_stack([reference[2].time, reference[2]["roll_angle"]])
    path = write(tmp_path / "r.csv", ["time", "roll_angle [deg]"], rows)
    (said,) = judge.judge([path])
    assert said["line"].startswith("right")
    wrong = by_score(PEERS / "exudyn-h0.01.txt")
    assert list(disagreements(wrong, said)) != []
    assert list(disagreements(None, said)) != []


class FailedError(Exception):
    """Raised by the plugin in a failing test."""


def passes(report, reference):
    """Return whether a test with ``require(scd=6)`` passes."""

    def fail(message):
        raise FailedError(message)

    try:
        Score(report, reference, (), None, lambda: "switched off", fail).require(scd=6)
    except FailedError:
        return False
    return True


@pytest.mark.parametrize("game", ["honest", "wrong"])
def test_the_plugin_passes_what_is_right(game, reference, tmp_path):
    counts = Counter()
    for file in texts(game, range(3100, 3114), tmp_path):
        if (report := by_score(file.path)) is None:
            continue
        required = score(file.path, reference, ["scd >= 6", "coverage >= 0.99"])
        is_passed = passes(report, reference)
        assert is_passed == required.passed, file.name
        assert is_passed or not report.is_right, file.name
        assert not is_passed or file_grade(report) in (Grade.RIGHT, Grade.UNTOLD), file.name
        counts[is_passed] += 1
    # No wrong file passes, even if it leaves out columns or rows.
    assert counts[False] > 0
    assert (counts[True] > 0) == (game == "honest")
