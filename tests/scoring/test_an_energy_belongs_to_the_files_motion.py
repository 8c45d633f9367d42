"""An energy that is computed wrongly is found besides an integrator's larger error."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("heyoka")

from generators.correct_programs import fixed_step
from generators.fixed_steps import Equations as Discretised
from heyoka_bike.scoring.diagnosis.diagnose import diagnose

pytestmark = pytest.mark.proof

CODE = "energy_of_other_motion"


@pytest.fixture(scope="module")
def results(reference):
    """RK4 with a step of 0.01 s: the steer rate is wrong by up to 1e-5 of its largest value."""
    return fixed_step(Discretised(reference, is_regular=True), "RK4", 0.01)


def changed(results, key, off, maneuvers=(1, 2, 3)):
    parts = []
    for n, m in enumerate(results.maneuvers, 1):
        values = dict(m.values)
        if n in maneuvers:
            values[key] = values[key] + off(m.time)
        parts.append(replace(m, values=values))
    return replace(results, maneuvers=tuple(parts))


def found(results, reference):
    return [f for f in diagnose(results, reference).diagnosis if f.code == CODE]


def test_an_integrators_error_is_in_the_energies_as_in_the_motion(results, reference):
    assert not found(results, reference)


def test_a_wheel_that_leaves_the_floor_a_little_is_no_wrong_energy(results, reference):
    """Programs with constraints for the velocities drift: 1e-7 m of the mass of the rider."""
    drifted = changed(results, "potential_energy", lambda time: -1e-5 * time)
    drifted = changed(drifted, "mechanical_energy", lambda time: -1e-5 * time)
    assert not found(drifted, reference)


@pytest.mark.parametrize("key", ["potential_energy", "kinetic_energy"])
def test_an_energy_that_is_computed_wrongly_is_named(results, reference, key):
    wrong = changed(results, key, lambda time: 0.1 * np.sin(3.0 * time), (1, 2))
    (one,) = found(wrong, reference)
    assert one.evidence["column"] == key
    assert one.evidence["maneuvers"] == [1, 2]
    assert one.evidence["off"] == pytest.approx(0.1, rel=1e-2)
