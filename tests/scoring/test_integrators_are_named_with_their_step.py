"""Each integration method has a residual of its own in the equations, proportional to its step."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.correct_programs import METHODS, adaptive
from generators.fixed_steps import Equations as Discretised
from generators.made_results import made
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.conclusions import IntegratedBy
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.programs.forces import rates_altered
from heyoka_bike.scoring.diagnosis.residual.methods import find_methods
from heyoka_bike.scoring.diagnosis.residual.observed import observe, state_vector


@pytest.fixture(scope="module")
def equations(reference):
    return Equations.binary64(Bicycle.parse(reference.bicycle, reference.parameters))


@pytest.fixture(scope="module")
def program(reference):
    """A program in the coordinates roll, pitch, steer and two angular velocities."""
    return Discretised(reference)


def motions_of(results, reference, equations):
    parts = align(results, reference).parts
    understood = understand(parts)
    return [observe(part, understood, equations) for part in parts]


def named(results, reference, equations):
    found = find_methods(equations, motions_of(results, reference, equations))
    return {m.says: m.step for m in found}


@pytest.mark.parametrize("step", [0.01, 0.0025])
@pytest.mark.parametrize(
    ("method", "name"),
    [
        ("explicit Euler", "explicit Euler"),
        ("implicit Euler", "implicit Euler"),
        ("Heun", "Heun's method"),
        ("implicit midpoint", "the implicit midpoint rule"),
    ],
)
def test_the_method_and_its_step_are_found(reference, equations, program, method, name, step):
    run = program.run(METHODS[method](program), step)
    assert named(run, reference, equations) == {name: step}


def test_new_speeds_first_is_told_from_both_euler_methods(reference, equations):
    """The program uses the coordinates of the regular form: in others it drifts off the floor."""
    program = Discretised(reference, is_regular=True)
    run = program.run(program.symplectic_euler, 0.005)
    assert named(run, reference, equations) == {"semi-implicit Euler": 0.005}


def test_two_methods_of_the_same_term_are_both_named(reference, equations, program):
    run = program.run(program.bdf2, 0.005)
    assert named(run, reference, equations) == {"BDF2": 0.005, "the trapezoidal rule": 0.01}


@pytest.mark.parametrize("solver", ["RK23", "LSODA"])
def test_steps_of_varying_size_are_no_method(reference, equations, program, solver):
    assert named(adaptive(program, solver, 1e-4), reference, equations) == {}


def test_a_force_is_no_method(reference, equations):
    """A force causes no residual in the rates of the angles."""
    (motion, *_) = motions_of(made(reference), reference, equations)
    state = state_vector(equations, motion.state.__getitem__)
    altered = np.array(rates_altered(equations, state, {"steer_damping": 0.3})[3:6])
    altered[2] *= equations.k.length
    pushed = replace(motion, accelerations=altered @ motion.windows.T)
    assert find_methods(equations, [pushed]) == ()


@pytest.mark.proof
def test_a_diagnosis_begins_with_it(reference, program):
    first, *_ = diagnose(program.run(METHODS["Heun"](program), 0.005), reference).diagnosis
    assert first.code == "integrator"
    # The program uses coordinates that differ from those of the simulated methods, so the named
    # method is only the nearest.
    begins = "The error is nearest to that of Heun's method with a step of 0.005 s. A run"
    assert first.message.startswith(begins)
    assert first.evidence["methods"] == [{"method": "Heun's method", "step": 0.005}]


@pytest.mark.parametrize(("is_next", "begins"), [
    (False, "The error is nearest to that of Heun's method with"),
    (True, "The error also resembles that of Heun's method with"),
])  # fmt: skip
def test_only_one_method_is_called_the_nearest(is_next, begins):
    method = SimpleNamespace(method="Heun's method", step=0.01)
    seen = IntegratedBy(SimpleNamespace(relief=50.0), (method,), None, is_next=is_next)
    assert seen.message().startswith(begins)
