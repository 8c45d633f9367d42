"""A correct motion has no residual in the exact equations; a wrong one has what it lacks."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("heyoka")

from scipy.integrate import solve_ivp

from generators.correct_programs import adaptive, fixed_step
from generators.fixed_steps import Equations as Discretised
from generators.made_results import made
from generators.mistaken_programs import correct, results_of
from generators.simulated_tables import right_program, simulated
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, apply
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.forces import Moving
from heyoka_bike.scoring.diagnosis.programs.program import initial_state, other_values
from heyoka_bike.scoring.diagnosis.residual.observed import observe
from heyoka_bike.scoring.diagnosis.residual.residual import Residual, Visibility
from heyoka_bike.scoring.reading.results import Results, Rows

LINEAR = {m.code for m in LINEAR_PROGRAMS}
LIBRARY = [m for m in MISTAKES if m.kind == "model" and m.code not in LINEAR]
BY_CODE = {m.code: m for m in MISTAKES}


@pytest.fixture(scope="module")
def equations(reference):
    return Equations.binary64(correct(reference).motion.bicycle)


def likely(found):
    """Causes of the library that are likely according to the equations."""
    return [h for h in found.known if h.log_odds > THRESHOLDS.report_log_odds]


def causes_of(results, reference, equations, *, understood=None):
    parts = align(results, reference).parts
    known = understood or understand(parts)
    motions = [observe(part, known, equations) for part in parts]
    library = [*LIBRARY, *EQUATION_MISTAKES]
    return Residual(motions, correct(reference), library)


def test_the_reference_leaves_nothing(reference, equations):
    found = causes_of(made(reference), reference, equations)
    # The limit is the accuracy of derivatives from binary64 rows that are 0.01 s apart, averaged
    # over 0.3 s.
    assert max(found.shares["roll"], found.shares["steer"]) < 1e-9
    assert found.visibility is Visibility.EQUATIONS
    assert not found.is_open
    assert found.fitted == ()
    assert not likely(found)


@pytest.mark.parametrize(
    "code",
    [
        "offset_d1_by_front_radius",
        *(pytest.param(x, marks=pytest.mark.proof) for x in ("sign_IHxz", "gravity_9.80665")),
    ],
)
def test_a_mistake_of_the_model_is_what_remains(reference, equations, code):
    found = causes_of(results_of(reference, [BY_CODE[code]]), reference, equations)
    assert [m.code for m in found.known[0].mistakes] == [code]
    # The mistake was visible in four digits or more. The residual of 1e-8 that remains needs no
    # cause.
    assert found.known[0].relief > 1e4
    assert all(c.relief < 1e-2 * found.known[0].relief for c in found.known[1:])
    assert found.fitted == ()


@pytest.mark.parametrize("symbol", ["IFxx", pytest.param("IRxx", marks=pytest.mark.proof)])
def test_a_parameter_is_found_where_nothing_of_it_is_left(reference, equations, symbol):
    """An inertia of zero changes the accelerations three times as much as the first order
    predicts."""
    right = float(correct(reference).motion.bicycle[symbol])
    zero = other_values({symbol: -right}, {symbol: 0.0}, correct(reference))
    found = causes_of(results_of(reference, [zero]), reference, equations)
    changes = found.fitted[0].mistakes[0].changes
    assert list(changes) == [symbol]
    assert changes[symbol] == pytest.approx(-right, rel=1e-6)
    assert not found.is_open


@pytest.mark.parametrize("code", ["steer_rate_as_roll_rate", "speed_by_front_radius"])
def test_another_start_leaves_nothing(reference, equations, code):
    results = results_of(reference, [BY_CODE[code]])
    found = causes_of(results, reference, equations)
    assert not likely(found)
    assert not found.is_open


def without_speed(results, numbers=(1, 2, 3)):
    """Results without the speed and the energies in some maneuvers."""
    lateral = {"roll_angle", "roll_rate", "steer_angle", "steer_rate"}
    return replace(
        results,
        maneuvers=tuple(
            replace(m, values={k: v for k, v in m.values.items() if k in lateral})
            if m.maneuver in numbers
            else m
            for m in results.maneuvers
        ),
    )


@pytest.mark.proof
@pytest.mark.parametrize("code", ["speed_by_front_radius", "sign_IHxz"])
def test_a_file_without_a_speed_is_explained_by_no_force(reference, code):
    """The speed follows from the other columns, but its initial value is free."""
    results = without_speed(results_of(reference, [BY_CODE[code]]))
    said = diagnose(results, reference).diagnosis
    assert said[0].evidence["mistakes"] == [code]
    assert not {"direction", "term_unexplained"} & {f.code for f in said}


def test_a_speed_that_one_maneuver_lacks_is_asked_of_none(reference, equations):
    results = without_speed(results_of(reference, [BY_CODE["sign_IHxz"]]), (2,))
    found = causes_of(results, reference, equations)
    assert found.equations == ("roll", "steer")
    assert found.visibility is not Visibility.EQUATIONS
    assert not found.is_open
    assert found.methods == ()
    assert found.known[0].codes == ("sign_IHxz",)


@pytest.mark.parametrize("alone", [pytest.param(False, marks=pytest.mark.proof), True])
@pytest.mark.parametrize(
    ("method", "step"),
    [
        ("explicit Euler", 0.005),
        pytest.param("Heun", 0.01, marks=pytest.mark.proof),
        ("RK4", 0.01),
        ("trapezoidal", 0.01),
        pytest.param("RK23", 1e-4, marks=pytest.mark.proof),
        ("LSODA", 1e-4),
    ],
)
def test_errors_of_integrators_are_explained_by_nothing(reference, equations, method, step, alone):
    program = Discretised(reference, is_regular=True)
    is_adaptive = step < 1e-3
    run = adaptive(program, method, step) if is_adaptive else fixed_step(program, method, step)
    if alone:
        run = replace(run, maneuvers=run.maneuvers[1:2])
    found = causes_of(run, reference, equations)
    assert found.fitted == ()
    assert not likely(found)
    # An integrator causes errors of the rates as large as the errors of the rates' derivatives, so
    # their ratio `above` is small.
    assert found.above < 10


def test_digits_that_were_not_written_are_no_force(reference, equations):
    def rounded(key, v, number):
        return np.array([float(f"{x:.6g}") for x in v])

    found = causes_of(made(reference, rounded), reference, equations)
    assert found.fitted == ()
    assert not likely(found)


def test_other_definitions_of_the_columns_are_other_motions_no_forces(reference, equations):
    """With the contact point's speed along x and the roll rate about the tilted axis, the yaw is
    needed."""
    names = {
        "forward_speed": "forward_speed_contact_global_x",
        "roll_rate": "roll_rate_steer_axes_x",
    }

    def written(key, v, number):
        return reference[number].rows[names.get(key, key)]

    found = causes_of(made(reference, written), reference, equations)
    assert max(found.shares["roll"], found.shares["steer"]) < 1e-8


@pytest.mark.parametrize(
    ("changes", "speed"),
    [({"steer_damping": 0.05}, "contact"),
     pytest.param({"g": -0.01, "c": 0.005}, "hub_heading", marks=pytest.mark.proof)],
)  # fmt: skip
def test_definitions_that_an_error_of_the_motion_hides_are_found(
    bicycle, reference, simulator, changes, speed
):
    """With the definitions that fit the correct motion best, no cause explains the residual."""
    program = right_program(bicycle, reference)
    program = apply(program, (other_values(changes, dict.fromkeys(changes, 0.0), program),))
    names = {"roll_angle": "tait_bryan_xyz", "roll_rate": "tait_bryan_xyz_rate",
             "forward_speed": speed}  # fmt: skip
    meant = {k: next(c.name for c in COMPARED[k] if c.definition == d) for k, d in names.items()}
    keys = [meant.get(key, key) for key in BENCHMARK_COLUMNS]
    made = simulated(simulator, program, keys)
    table = {"time": made["time"]}
    for n in reference:
        table |= {f"{key}_{n}": made[f"{meant.get(key, key)}_{n}"] for key in BENCHMARK_COLUMNS}
    (found, *_) = diagnose(table, reference).diagnosis
    assert found.code == "parameters"
    told = {x["unknown"]: x["value"] for of in found.evidence["changes"] for x in of}
    right = {"g": 9.81, "c": 0.08}
    assert told == pytest.approx({k: x + right.get(k, 0.0) for k, x in changes.items()}, rel=1e-6)


def test_velocities_of_the_bodies_obey_the_equations_of_motion(equations):
    """The Newton-Euler equations of four bodies give the same rates as the reduced equations."""
    random = np.random.default_rng(7)
    roll, steer = random.uniform(-0.3, 0.3, (2, 50))
    rates, spin = random.uniform(-1.0, 1.0, (2, 50)), random.uniform(5.0, 20.0, 50)
    pitch = pitch_on_the_floor(equations.k, roll, 0 * roll, steer)
    m = Moving(equations, [roll, pitch, steer, *rates, spin, 0 * roll])
    for found, right in zip(m.added(m.free()), m.rates[3:6], strict=True):
        # The accelerations are up to 40 1/s^2, so the limit is roundoff.
        assert np.max(np.abs(found - right)) < 1e-12


def pushed(reference, equations, force, missing=()):
    """Maneuver 2 with a torque in the roll equation and one on the steer axis, integrated by
    SciPy, without some columns."""
    program = correct(reference)
    start = np.array(initial_state(program.motion.bicycle, program.motion.starts[2]))
    start[5] /= equations.k.length

    def slope(t, y):
        moving = Moving(equations, list(y))
        speed = y[5] * equations.k.length
        added = moving.added([*force(t, *y[[0, 2, 3, 4]], speed), 0.0])
        rates = moving.rates
        return [*rates[:3], *(a + b for a, b in zip(rates[3:6], added, strict=True)), rates[6]]

    time = np.arange(151) / 100
    run = solve_ivp(slope, (0, 1.5), [*start, 0.0], "DOP853", t_eval=time, rtol=1e-8, atol=1e-11)
    columns = equations.columns(list(run.y))
    keys = [key for key in BENCHMARK_COLUMNS if key not in missing]
    rows = Rows(2, time, 0 * time, {key: columns[key] for key in keys})
    return diagnose(Results("made", "text", (rows,), 17), reference).diagnosis


LAWS = {
    "steer_by_steer_angle_steer_angle_steer_angle": lambda t, r, s, rr, sr, v: (0, -4e3 * s**3),
    "steer_by_roll_angle": lambda t, r, s, rr, sr, v: (0, 3.0 * r),
    "roll_by_roll_rate_speed": lambda t, r, s, rr, sr, v: (-0.5 * rr * v, 0),
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("steer_by_steer_angle_steer_angle_steer_angle", -4e3),
        pytest.param("steer_by_roll_angle", 3.0, marks=pytest.mark.proof),
        pytest.param("roll_by_roll_rate_speed", -0.5, marks=pytest.mark.proof),
    ],
)
def test_a_force_of_the_state_is_named_with_its_law(reference, equations, name, value):
    """The laws: a stiffening spring, a controller, and a damping that grows with the speed."""
    said = pushed(reference, equations, LAWS[name])
    assert said[0].code == "parameters"
    every = [c for changes in said[0].evidence["changes"] for c in changes]
    assert every[0]["unknown"].startswith(name.removesuffix("_speed"))
    found = next(c for c in every if c["unknown"] == name)
    assert found["value"] == pytest.approx(value, rel=1e-4)


@pytest.mark.proof
@pytest.mark.parametrize("place", ["roll", "steer"])
def test_a_term_that_nobody_knows_is_told_as_such(reference, equations, place):
    """A torque depends on the time. In the roll equation it mostly moves the light fork."""

    def force(t, *_):
        size = np.sin(7.0 * t)
        return (3.0 * size, 0.0) if place == "roll" else (0.0, 0.3 * size)

    said = pushed(reference, equations, force)
    told = next(f for f in said if f.code == "term_unexplained")
    assert told.evidence["shares"]["steer"] > told.evidence["shares"]["roll"]
    assert told.evidence["acts_in"] == place
    # The torque does the work, so an integrator does not change the energy.
    assert told.evidence["loads"]
    assert not {"energy_varies", "mistake", "parameters"} & {f.code for f in said}


COMPUTED = (("steer_rate",), ("roll_rate",), ("forward_speed",), ("forward_speed", "steer_rate"))
"""Columns that follow from the others: rates are slopes, and the kinetic energy shows the speed."""


@pytest.mark.parametrize(
    "missing", [COMPUTED[0], *(pytest.param(x, marks=pytest.mark.proof) for x in COMPUTED[1:])]
)
def test_columns_that_follow_from_the_others_hide_no_force(reference, equations, missing):
    said = pushed(reference, equations, LAWS["steer_by_roll_angle"], missing)
    (found,) = said[0].evidence["changes"][0]
    assert found["unknown"] == "steer_by_roll_angle"
    assert found["value"] == pytest.approx(3.0, rel=1e-3)
    unknown = pushed(reference, equations, lambda t, *_: (0.0, 0.3 * np.sin(7.0 * t)), missing)
    told = next(f for f in unknown if f.code == "term_unexplained")
    assert told.evidence["acts_in"] == "steer"
    # Without the equation of the speed, any place explains the force.
    assert bool(told.evidence["loads"]) == ("forward_speed" not in missing)


@pytest.mark.parametrize("missing", COMPUTED)
@pytest.mark.parametrize(
    ("method", "step"),
    [
        ("RK4", 0.01),
        pytest.param("explicit Euler", 0.005, marks=pytest.mark.proof),
        pytest.param("trapezoidal", 0.01, marks=pytest.mark.proof),
    ],
)
def test_an_integrator_is_no_force_if_columns_are_computed(
    reference, equations, method, step, missing
):
    """A rate that is in the file has the same error as the accelerations."""
    run = fixed_step(Discretised(reference, is_regular=True), method, step)
    parts = tuple(
        replace(m, values={k: x for k, x in m.values.items() if k not in missing})
        for m in run.maneuvers
    )
    found = causes_of(replace(run, maneuvers=parts), reference, equations)
    assert found.visibility is Visibility.EQUATIONS
    assert not found.is_open


def test_a_kinetic_energy_that_contradicts_the_initial_speed_shows_no_speed(reference, equations):
    def changed(key, v, number):
        return 1.01 * v if key == "kinetic_energy" else v

    keys = [key for key in BENCHMARK_COLUMNS if key != "forward_speed"]
    found = causes_of(made(reference, changed, keys), reference, equations)
    assert found.visibility is Visibility.EQUATIONS_PARTLY
    right = causes_of(made(reference, names=keys), reference, equations)
    assert right.visibility is Visibility.EQUATIONS
    assert max(right.shares.values()) < 1e-9
