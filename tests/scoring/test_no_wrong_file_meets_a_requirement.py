"""Wrong files in many variations: none passes a requirement that it does not meet.

A small share is played here; ``python tests/games/play.py wrong`` or ``-m slow`` plays all 20,000.
"""

from dataclasses import replace

import pytest

from games import play
from games.wrong_files import KINDS
from heyoka_bike.scoring import grades, measures, requirements, score, verdict
from heyoka_bike.scoring.judge import signs as judge_signs
from heyoka_bike.scoring.report import Report

ROUNDS = range(3)
"""In each round one file of every kind is played."""


def outcomes(kinds, count=4):
    """Lazily play the first `count` files of each of these kinds."""
    numbers = [list(KINDS).index(kind) + i * len(KINDS) for kind in kinds for i in range(count)]
    return map(play.play_wrong, numbers)


def is_lost(kinds, count=4):
    """True if a file of the first ones of these kinds is lost. The test stops at the first one."""
    return any(o.lost for o in outcomes(kinds, count))


@pytest.mark.proof
@pytest.mark.parametrize("turn", ROUNDS)
def test_no_wrong_file_passes(turn):
    numbers = range(turn * len(KINDS), (turn + 1) * len(KINDS))
    found = play.play("wrong", numbers, processes=1)
    assert [(o.number, o.lost) for o in found if o.lost] == []
    assert sum(o.is_refused for o in found) < len(found) / 4


@pytest.mark.slow
def test_no_wrong_file_of_20000_passes():
    found = play.play("wrong", range(play.COUNTS["wrong"]))
    assert [(o.number, o.lost) for o in found if o.lost] == []


# The game must be able to fail: each of the following tests breaks the scorer and checks that the
# game notices it.


def test_the_game_sees_values_that_are_not_compared(monkeypatch):
    check = score.check

    def of_what_was(texts, report):
        maneuvers = [
            replace(m, columns=tuple(replace(c, missing=0) for c in m.columns))
            for m in report.maneuvers
        ]
        return check(texts, replace(report, maneuvers=tuple(maneuvers)))

    monkeypatch.setattr(score, "check", of_what_was)
    assert is_lost(["no_numbers"])


@pytest.fixture
def a_part_is_enough(monkeypatch):
    """Let few columns and a part of the run suffice, so that only the patched check decides."""
    for module in (verdict, requirements):
        monkeypatch.setattr(module, "ALL_COLUMNS", 0)
        monkeypatch.setattr(module, "MIN_COVERAGE", 0.0)


@pytest.mark.usefixtures("a_part_is_enough")
def test_the_game_sees_signs_taken_one_by_one(monkeypatch):
    monkeypatch.setattr(judge_signs, "_impossible", lambda keys, signs: [])
    kinds = ["rate_against_angle", "improper_matrix", "signs_against_each_other"]
    assert all(o.lost for o in outcomes(kinds, 2))


@pytest.mark.usefixtures("a_part_is_enough")
def test_the_game_sees_zeros_that_count_as_digits(monkeypatch):
    monkeypatch.setattr(measures, "_in_common", lambda values, largest: 0.0)
    assert is_lost(["rows_at_whole_numbers"], 10)


def test_the_game_sees_an_energy_that_nobody_asks_about(monkeypatch):
    monkeypatch.setattr(verdict, "performance", lambda change, limit, **of: verdict.Claim(change))
    assert is_lost(["energy_that_is_bought"], 2)


def test_the_game_sees_a_column_that_is_left_out_in_silence(monkeypatch):
    monkeypatch.setattr(Report, "not_compared", ())
    assert is_lost(["another_column_beside"], 2)


@pytest.mark.usefixtures("a_part_is_enough")
def test_the_game_sees_a_word_that_rests_on_few_digits(monkeypatch):
    def right_to_the_digits(error, *, unexplained, scale, **_):
        return grades.Grade.RIGHT if unexplained <= 1e-6 * scale else grades.Grade.WRONG

    monkeypatch.setattr(grades, "grade", right_to_the_digits)
    assert is_lost(["rows_where_rounding_is_right"], 6)


def test_the_game_sees_coverage_by_the_ends_alone(monkeypatch):
    whole = score._coverage

    def by_the_ends(part, most_apart):
        start, end, _, _ = whole(part, most_apart)
        return start, end, (end - start) / 10, 0.01

    monkeypatch.setattr(score, "_coverage", by_the_ends)
    assert is_lost(["rows_dropped"])


def test_the_game_sees_a_row_that_is_forgiven(monkeypatch):
    measures = score.measures.measures

    def without_the_worst(t, error, reference, scale):
        kept = abs(error) < max(abs(error))
        return measures(t[kept], error[kept], reference[kept], scale)

    monkeypatch.setattr(score.measures, "measures", without_the_worst)
    assert is_lost(["one_value", "first_row", "last_row"])


@pytest.mark.proof
def test_the_game_sees_a_choice_made_for_each_maneuver(monkeypatch):
    understand, score_maneuver = score.understand, score._score_maneuver

    def by_itself(part, understood, limit):
        return score_maneuver(part, understand([part]), limit)

    monkeypatch.setattr(score, "_score_maneuver", by_itself)
    assert is_lost(["definitions_mixed", "units_mixed", "zeros_differ"])
