"""The header and `score` agree on definitions, units, signs, digits and grades."""

from itertools import islice

import numpy as np
import pytest

from games.checker import (
    Checker,
    compare,
    corpus_files,
    game_files,
    judged_by_score,
    judged_files,
    result_files,
)
from heyoka_bike import read_results
from heyoka_bike.system.resources import data_folder


@pytest.fixture(scope="module")
def checker(tmp_path_factory):
    return Checker(tmp_path_factory.mktemp("checker"))


def compared(checker, files):
    said = []
    counts = compare(checker, judged_files(files), said.append)
    return counts, said


def some():
    yield from game_files("honest", [4])
    for name in ("exudyn-h0.01.txt", "scipy-rtol1e-7.txt"):
        yield name, lambda name=name: read_results(data_folder() / "peers" / name)


def wrong_in_degrees(tmp_path):
    """Write a file with reversed rows after the first, with angles and rates in degrees."""
    table = np.loadtxt(data_folder() / "peers" / "exudyn-h0.01.txt")
    table[1:, 1:] = table[:0:-1, 1:]
    for first in range(0, 24, 8):
        table[:, [first + k for k in (1, 2, 7, 8)]] *= -180 / np.pi
    path = tmp_path / "wrong-in-degrees.txt"
    np.savetxt(path, table, "%.17g")
    yield path.name, lambda: read_results(path)


def test_the_first_row_of_a_wrong_motion_tells_its_units(checker, tmp_path):
    counts, said = compared(checker, wrong_in_degrees(tmp_path))
    assert said == []
    assert counts["columns"] == 24


def test_some_files(checker):
    counts, said = compared(checker, some())
    assert said == []
    assert counts["columns"] > 70


@pytest.mark.proof
def test_programs_of_the_field_and_of_others(checker):
    counts, said = compared(checker, [*result_files()])
    assert said == []
    assert counts["columns"] > 1000
    counts, said = compared(checker, corpus_files(every=11))
    assert said == []
    assert counts["files"] > 20


@pytest.mark.slow
def test_all_programs_of_others(checker):
    counts, said = compared(checker, corpus_files())
    assert said == []
    assert counts["files"] > 230


@pytest.mark.proof
@pytest.mark.parametrize(("game", "least"), [("honest", 50), ("wrong", 33)])
def test_files_of_the_games(checker, game, least):
    counts, said = compared(checker, game_files(game, range(2000, 2050)))
    assert said == []
    assert counts["files"] >= least


CHANGES = [
    # Each pair replaces a line with a wrong line. The first four wrong lines: always the default
    # definition, a wrong degree, a different limit, and an ignored offset.
    ("#define UB_EXPECTED 1.6094379124341003", "#define UB_EXPECTED 30.0"),
    ('"degree", 0.017453292519943295', '"degree", 0.0175'),
    ("#define BICYCLE_CLOSE_DIGITS 3.0", "#define BICYCLE_CLOSE_DIGITS 2.4"),
    ("- u->offset - exact);", "- exact);"),
    # This wrong line ignores the first row.
    ("told = ub_told_way(key, starts);", "told = 0;"),
]


@pytest.mark.proof
def test_another_judge_is_noticed(tmp_path):
    honest = game_files("honest", range(60))
    others, known = judged_files([*wrong_in_degrees(tmp_path), *some(), *honest]), []

    def files():
        yield from known
        for judged in others:
            known.append(judged)
            yield judged

    for i, change in enumerate(CHANGES):
        said, every = [], files()
        (tmp_path / str(i)).mkdir()
        checker = Checker(tmp_path / str(i), change)
        while not said and (some_more := list(islice(every, 8))):
            compare(checker, some_more, said.append)
        assert said, change


@pytest.mark.proof
def test_the_line_is_the_beginning_of_the_verdict(checker):
    for name in ("exudyn-h0.01.txt", "scipy-rtol1e-7.txt", "scipy-rtol1e-10.txt"):
        judged = judged_by_score(name, read_results(data_folder() / "peers" / name))
        ((_, line),) = checker.judge([judged.parts])
        said = judged.report.verdict.partition(": ")[2]
        assert said.partition(")")[0] + ")" == line
