"""The mechanical energy of a file alone shows whether its error does work."""

import numpy as np
import pytest

from generators.simulated_tables import TIME, right_program, simulated
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.energies import (
    EnergyKept,
    EnergyTrend,
    EnergyVaries,
    is_of_motions,
    of_energy,
)
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, apply
from heyoka_bike.scoring.diagnosis.residual.observed import observe
from heyoka_bike.scoring.score import score

KEYS = ("roll_angle", "potential_energy", "kinetic_energy", "mechanical_energy")


@pytest.fixture(scope="module")
def right(bicycle, reference):
    return right_program(bicycle, reference)


def energy(table, reference):
    (found,) = of_energy(score(table, reference))
    return found


@pytest.mark.parametrize("code", ["sign_IHxz", "no_gyroscopic_R", "trail_normal"])
@pytest.mark.parametrize("keys", [KEYS, KEYS[1:3]])
def test_what_does_no_work_keeps_it(simulator, right, reference, code, keys):
    """A wrong bicycle, and a missing term that is orthogonal to the velocity, do no work."""
    program = apply(right, [m for m in (*MISTAKES, *EQUATION_MISTAKES) if m.code == code])
    found = energy(simulated(simulator, program, keys), reference)
    assert isinstance(found, EnergyKept)
    assert found.left < 1e-6 * max(found.exchanged.values())


def test_a_spring_stores_what_the_sum_lacks(simulator, right, reference):
    table = simulated(simulator, right, KEYS, steer_stiffness=0.5)
    found = energy(table, reference)
    assert isinstance(found, EnergyVaries)
    for n, (change, time) in found.largest.items():
        e = table[f"mechanical_energy_{n}"]
        row = int(np.argmax(np.abs(e - e[0])))
        assert time == TIME[row]
        assert change == pytest.approx(e[row] - e[0], rel=1e-6)


def test_a_damper_takes_it_steadily(simulator, right, reference):
    found = energy(simulated(simulator, right, KEYS, velocity_damping=0.01), reference)
    assert isinstance(found, EnergyTrend)
    assert max(found.changes) < 0.0


def test_an_energy_that_changes_while_the_motion_dies_away_shows_no_end(
    simulator, right, reference
):
    """In maneuver 3 the steer rate falls to a third within half a second, so a damper does most of
    its work before."""
    every = simulated(simulator, right, KEYS, steer_damping=5.0)
    table = {"time": TIME} | {key: every[f"{key}_3"] for key in KEYS}
    found = energy(table, reference)
    assert isinstance(found, EnergyVaries)
    assert found.until is None


def test_it_is_said_where_the_time_is_spent(simulator, right, reference):
    table = simulated(simulator, right, KEYS[1:], steer_stiffness=0.5)
    said = [f.code for f in diagnose(table, reference, budget=1e-3).diagnosis]
    assert said == ["energy_varies", "stopped_early"]


def test_an_energy_that_changes_at_first_only_falls_not_steadily(reference):
    """For example, gravity that is increased gradually at the start does no work afterwards."""
    lost = 5.0 * np.minimum(TIME / 0.3, 1.0)
    table = {"time": TIME} | {
        f"mechanical_energy_{n}": reference[n].approximate(TIME, ["mechanical_energy"])[
            "mechanical_energy"
        ]
        - lost
        for n in reference
    }
    found = energy(table, reference)
    assert isinstance(found, EnergyVaries)
    assert found.until == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize(("lost", "is_all"), [(0.0, True), (0.1, False)])
def test_a_force_explains_the_energy_that_belongs_to_its_motion(
    simulator, right, reference, lost, is_all
):
    """A spring does the work; a loss in the output does not belong to any motion."""
    table = simulated(simulator, right, BENCHMARK_COLUMNS, steer_stiffness=0.5)
    for n in reference:
        table[f"mechanical_energy_{n}"] = table[f"mechanical_energy_{n}"] - lost * TIME
    report = score(table, reference)
    parts = [m.part for m in report.maneuvers]
    equations = Equations.binary64(right.motion.bicycle)
    motions = [observe(part, understand(parts), equations) for part in parts]
    assert is_of_motions(report, motions, equations) is is_all
