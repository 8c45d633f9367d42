"""Correct files in many variations: none is refused, loses digits, or fails a met requirement.

``python tests/games/play.py honest`` or ``-m slow`` plays all 5,000.
"""

import numpy as np
import pytest

from games import play
from games.files import references
from heyoka_bike import load_motion, load_reference
from heyoka_bike.scoring import definitions, score


def test_the_games_are_played_with_the_published_values():
    """The games' reference caches its values; the first and all later calls give the published
    ones."""
    for whole, published in zip(references(), (load_reference(), load_motion()), strict=True):
        for number, m in published.items():
            names = sorted(m.at_any_time)[::6]
            for t in (m.time[:20] + 1e-3, m.time):
                expected = m.continued((t, 0 * t), names)
                for chosen in (names[::2], names, names[1::3]):
                    found = whole[number].continued((t, 0 * t), chosen)
                    assert list(found) == chosen
                    for name in chosen:
                        np.testing.assert_array_equal(found.hi[name], expected.hi[name])
                        np.testing.assert_array_equal(found.lo[name], expected.lo[name])


@pytest.mark.proof
def test_no_honest_file_loses_a_digit(honest_outcomes):
    assert [(o.number, o.lost) for o in honest_outcomes if o.lost] == []


# In these files, a definition other than the default reduces the error by a factor of 3 to 7. That
# definition is the likeliest, but others remain possible.
@pytest.mark.parametrize("number", [916, 1244, 1997, 2040, 2351, 2724, 4044])
def test_the_likeliest_definition_counts_where_several_are_open(number):
    assert not play.play_honest(number).lost


@pytest.mark.slow
def test_no_honest_file_of_5000_loses_a_digit():
    found = play.play("honest", range(play.COUNTS["honest"]))
    assert [(o.number, o.lost) for o in found if o.lost] == []


# The game must be able to fail: each of the following tests breaks the scorer and checks that the
# game notices it.


def lost(count):
    """True if a file of the first `count` is lost. The test stops at the first one."""
    return any(play.play_honest(number).lost for number in range(count))


def test_the_game_sees_a_sign_that_is_not_recognised(monkeypatch):
    unsigned = (*definitions._UNSIGNED, "steer_angle", "roll_angle")
    monkeypatch.setattr(definitions, "_UNSIGNED", unsigned)
    assert lost(6)


@pytest.mark.proof
def test_the_game_sees_a_zero_in_binary64(monkeypatch):
    monkeypatch.setattr(score, "_with_exact_zero", lambda understood, parts: understood)
    assert lost(18)


def test_the_game_sees_axes_that_are_forbidden(monkeypatch):
    def all_alike(signs):
        return [tuple(signs)] if len(set(signs.values())) > 1 else []

    monkeypatch.setattr("heyoka_bike.scoring.judge.signs.contradictions", all_alike)
    assert lost(6)


def test_the_game_sees_half_a_digit(monkeypatch):
    errors = score.errors
    monkeypatch.setattr(score, "errors", lambda *given: [np.sqrt(10) * e for e in errors(*given)])
    assert lost(3)
