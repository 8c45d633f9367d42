"""A proof computes the constants of the equations equally often for many segments and for few."""

from dataclasses import replace
from fractions import Fraction

import pytest

from heyoka_bike.bicycle.equations import reduced
from heyoka_bike.bicycle.equations.whole_motion import dense_columns
from heyoka_bike.reference.proof.dense import expansions, with_integrals
from heyoka_bike.reference.proof.enclose import enclose

pytestmark = pytest.mark.proof


@pytest.fixture
def made(monkeypatch):
    """Counts how often constants are computed."""
    count = []
    original = reduced.constants
    monkeypatch.setattr(reduced, "constants", lambda *a: count.append(1) or original(*a))
    return count


def stages(run, made):
    """Return how often each stage of a proof computes the constants."""
    counts = []
    certificate = enclose(run)
    counts.append(len(made))
    stretches = list(with_integrals(run, certificate))
    counts.append(len(made))
    list(expansions(run, dense_columns, stretches))
    counts.append(len(made))
    made.clear()
    return counts


def test_however_many_pieces_there_are(candidate, made):
    run = candidate[2]
    found = []
    for pieces in (2, 6):
        end = Fraction(run.breaks[pieces])
        part = replace(
            run, maneuver=replace(run.maneuver, duration=end, spacing=end),
            breaks=run.breaks[: pieces + 1], pieces=run.pieces[:pieces],
        )  # fmt: skip
        found.append(stages(part, made))
    assert found[0] == found[1]
    # Number of computations up to the end of each stage. The stages compute the constants for
    # circles, matrices and defects (3 computations), for circles and integrals (2), and for circles
    # and series (2).
    assert found[0] == [3, 5, 7]
