"""The odds of a claimed definition are correct for the errors that other programs make.

Each error curve is scaled and added to the exact column of one definition. The file is then scored
against another definition. Odds of x to 1 against the truth may occur in at most one of x cases.
"""

from itertools import permutations

import numpy as np
import pytest

pytest.importorskip("heyoka")


from games import play
from generators.correct_programs import adaptive, fixed_step
from generators.fixed_steps import Equations
from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.scoring import definitions
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.definitions import Sample, Understanding
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.system.resources import data_folder

pytestmark = pytest.mark.proof

PEERS = data_folder() / "peers"
EXUDYN = {
    "roll_angle": "roll_angle_tait_bryan_xyz",
    "roll_rate": "roll_rate_body_x",
    "forward_speed": "forward_speed_hub_body_x",
}
OPEN = tuple(EXUDYN)
# Sizes of the error, relative to the difference between two definitions. Their logarithms are
# evenly spaced.
SIZES = np.outer((1, -1), 10.0 ** np.arange(-1.5, 1.6)).ravel()
ROWS = (50, 1001)  # the first half second, and the whole run


@pytest.fixture(scope="module")
def errors(reference):
    """Error curves of each column that has several definitions: key, maneuver, error."""
    runs = [(read_results(PEERS / name), EXUDYN) for name in (
        "exudyn-h0.01.txt", "exudyn-h0.001.txt", "exudyn-loose-newton.txt")]  # fmt: skip
    runs += [(read_results(PEERS / f"scipy-rtol1e-{n}.txt"), {}) for n in (4, 7)]
    equations = Equations(reference)
    for method in ("explicit Euler", "implicit midpoint", "generalised alpha", "RK4"):
        runs.append((fixed_step(equations, method, 0.01), {}))
    runs += [(adaptive(equations, solver, 1e-4), {}) for solver in ("RK45", "BDF")]
    return [
        (key, r.maneuver, r.values[key] - reference[r.maneuver].rows[names.get(key, key)])
        for results, names in runs
        for r in results.maneuvers
        for key in OPEN
    ]


def odds_against_the_truth(reference, errors, rows):
    found = []
    for key, number, error in errors:
        m = reference[number]
        values = {key: m[key][:rows]}
        written = Rows(number, m.time[:rows], m.time_lo[:rows], values, {}, {})
        sample = Sample(align(Results("x", "text", (written,), 17), reference).parts[0])
        unit = error[:rows] / np.max(abs(error[:rows]))
        for true, other in permutations(DEFINITIONS[key], 2):
            apart = np.max(abs(m[true.name] - m[other.name])[:rows])
            # Skip definitions that differ in the first row, because then the first row alone
            # decides.
            if apart == 0 or m[true.name][0] != m[other.name][0]:
                continue
            for size in SIZES:
                sample.values[key] = m[true.name][:rows] + size * apart * unit
                pair = [Understanding(c, c.unit) for c in (true, other)]
                likely = sample.log_likelihoods(key, pair)
                found.append((likely[1] - likely[0]) / np.log(10))
    return np.array(found)


@pytest.mark.parametrize("rows", ROWS)
def test_wrong_claims_are_as_rare_as_their_odds(reference, errors, rows):
    against = odds_against_the_truth(reference, errors, rows)
    assert len(against) > 2000
    for log10 in (0.5, 1.0, 1.3, 2.0):
        wrong, claims = np.sum(against > log10), np.sum(abs(against) > log10)
        assert claims > len(against) / 4, log10
        assert wrong <= 10**-log10 * claims


def test_claims_at_odds_above_100_hold_over_the_game_of_honest_files(honest_outcomes):
    """Some columns have an unknown definition. The 125 files contain about 270 claims."""
    wrong = [(o.number, x) for o in honest_outcomes for x in o.claims if x[0] > 2 and x[1]]
    claims = sum(x[0] > 2 for o in honest_outcomes for x in o.claims)
    assert claims > 240
    assert len(wrong) <= 0.01 * claims, wrong


def test_a_claim_against_the_truth_is_seen(monkeypatch):
    """With odds that ignore unknown definitions, the game finds wrong claims."""
    monkeypatch.setattr(definitions, "_LOG_ODDS_OF_KNOWN", 100.0)
    claims = (x for number in range(100) for x in play.play_honest(number).claims)
    assert any(log10 > 2 and is_wrong for log10, is_wrong in claims)
