"""sensitivities.h5 agrees with differences of runs, at high precision and by another integrator."""

from dataclasses import replace
from fractions import Fraction

import flint
import h5py
import numpy as np
import pytest

from generators.mistaken_programs import correct, motion
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import load_sensitivities
from heyoka_bike.reference.structure import UNKNOWNS

ORDER = list(UNKNOWNS)
NAMES = [c.name for c in COLUMNS]


@pytest.fixture(scope="module")
def sensitivities():
    return load_sensitivities()


def test_every_column_has_every_unknown(sensitivities, reference):
    assert [*PARAMETERS, *(f"initial_{key}" for key in START)] == ORDER
    assert len(sensitivities) == len(reference)
    found = sensitivities[1].evaluate(reference[1].time)
    assert list(found) == NAMES
    for values in found.values():
        assert values.shape == (1001, 31)
        assert np.isfinite(values).all()


@pytest.mark.parametrize("number", [1, 2, 3])
@pytest.mark.parametrize("symbol", ["w", "lam", "IHxz", "rF", "zB"])
def test_they_predict_what_another_integrator_finds(sensitivities, reference, number, symbol):
    """Central differences extrapolated to fourth order; SciPy's output is accurate to 1e-7."""
    program = correct(reference).motion
    time = reference[number].time[::20]
    start = program.starts[number]
    state = (0.0, 0.0, 0.0, start.roll_rate, 0.0, start.speed)
    value = program.bicycle[symbol]
    step = abs(float(value)) / 1000

    def moved(times):
        rational = value.rational + times * Exact.parse(repr(step)).rational
        changed = Exact(rational, value.pi_multiple)
        return motion(Bicycle("moved", {**program.bicycle.values, symbol: changed}), state, time)

    far, near, here, there = (moved(times) for times in (-2, -1, 1, 2))
    found = sensitivities[number].evaluate(time)
    for name in NAMES:
        expected = (8 * (here[name] - near[name]) - (there[name] - far[name])) / (12 * step)
        row = found[name][:, ORDER.index(symbol)]
        noise = 1e-7 * np.max(np.abs(reference[number].rows[name])) / step
        assert np.max(np.abs(row - expected)) < 3e-4 * np.max(np.abs(row)) + noise, name


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_energy_changes_as_the_start_says(sensitivities, reference, number):
    """E = V0 + E_kin(start) by the formula of a rolling body, at all times."""
    m = reference[number]
    p = {s: float(Exact.parse(x)) for s, x in reference.parameters.items()}
    speed = float(Exact.parse(m.inputs["speed"]))
    found = sensitivities[number].evaluate(m.time)["mechanical_energy"]
    mass = p["mR"] + p["mB"] + p["mH"] + p["mF"]
    rolling = mass + p["IRyy"] / p["rR"] ** 2 + p["IFyy"] / p["rF"] ** 2
    weight = p["mR"] * p["rR"] - p["mB"] * p["zB"] - p["mH"] * p["zH"] + p["mF"] * p["rF"]
    rate = float(Exact.parse(m.inputs["roll_rate"]))
    expected = {
        "initial_speed": rolling * speed,
        "g": weight,
        "IBxx": rate**2 / 2,
        "IByy": 0.0,
        "initial_roll": 0.0,
    }
    for unknown, value in expected.items():
        row = found[:, ORDER.index(unknown)]
        # The stored coefficients are multiples of 2^-50 of the largest value.
        assert np.max(np.abs(row - value)) <= 2e-14 * max(abs(value), 1e-300), unknown


def test_the_start_of_a_column_is_itself(sensitivities):
    for number in (1, 2, 3):
        at_start = sensitivities[number].evaluate([0.0])
        for unknown, column in (
            ("initial_roll", "roll_angle"), ("initial_steer", "steer_angle"),
            ("initial_steer_rate", "steer_rate"), ("initial_speed", "forward_speed"),
        ):  # fmt: skip
            row = at_start[column][0]
            expected = np.zeros(31)
            expected[ORDER.index(unknown)] = 1.0
            largest = np.max(
                np.abs(sensitivities[number].evaluate(np.linspace(0, 10, 201))[column]), axis=0
            )
            assert np.all(np.abs(row - expected) <= 2e-14 * np.maximum(largest, 1e-300))


def test_times_outside_the_run_are_refused(sensitivities):
    with pytest.raises(InputError, match="expected 0 to 10 s"):
        sensitivities[1].evaluate([10.5])
    with pytest.raises(InputError):
        sensitivities[1].evaluate([float("nan")])
    with pytest.raises(KeyError, match="expected 1 to 3"):
        sensitivities[4]


def test_a_set_without_them_says_so(tmp_path):
    with pytest.raises(DatasetError, match=r"manifest\.json"):
        load_sensitivities(tmp_path)


def test_the_file_describes_itself(folder):
    with h5py.File(folder / "sensitivities.h5") as f:
        assert "T_k" in f.attrs["comment"]
        assert f["maneuver_1/roll_angle"].attrs["units"] == "rad per unit of the unknown"
        assert len(f.attrs["content_sha256"]) == 64


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2, 3])
def test_differences_of_long_runs_are_within_the_bounds(
    sensitivities, reference, bicycle, maneuvers, number
):
    """Runs at 70 digits, 1e-25 apart; segments are evaluated exactly, rows as published."""
    step, bits = Fraction(1, 10**25), 300
    rows = [0, 1, 13, 50, 100]
    maneuver, found = maneuvers[number - 1], sensitivities[number]
    times = [maneuver.time(10 * i) for i in rows]

    def columns(b, m):
        at = evaluator(integrate(b, m, 70), bits)
        with at.balls.precision():
            return [at.columns(t) for t in times]

    def moved(x):
        return Exact(x.rational + step, x.pi_multiple)

    def ball(x):
        x = Fraction(x)
        return flint.arb(flint.fmpq(x.numerator, x.denominator))

    here = columns(bicycle, maneuver)
    for u, unknown in enumerate(ORDER):
        if unknown in PARAMETERS:
            there = columns(bicycle.replace(**{unknown: moved(bicycle[unknown])}), maneuver)
        else:
            key = unknown.removeprefix("initial_")
            there = columns(bicycle, replace(maneuver, **{key: moved(getattr(maneuver, key))}))
        with flint.ctx.workprec(bits):
            for i, (row, t) in enumerate(zip(rows, times, strict=True)):
                p = min(
                    int(np.searchsorted(found.breaks, float(t), "right")) - 1, len(found.breaks) - 2
                )
                a, b = (ball(float(x)) for x in found.breaks[p : p + 2])
                x = 2 * (ball(t) - a) / (b - a) - 1
                for name in NAMES:
                    difference = (there[i][name] - here[i][name]) / ball(step)
                    # A difference has an error of the step times the second derivative with respect
                    # to the unknown, which is below 1e6.
                    noise = flint.arb(1e-19)
                    c = found.coefficients[name][p, :, u]
                    value = sum((ball(y) * x.chebyshev_t(k) for k, y in enumerate(c)), flint.arb(0))
                    bound = ball(found.bound[name][p, u]) + noise
                    assert abs(value - difference) <= bound, (unknown, name, row)
                    if name in found.values:
                        bound = ball(found.values_bound[name][row, u]) + noise
                        value = ball(found.values[name][row, u])
                        assert abs(value - difference) <= bound, (unknown, name, row)


def test_nineteen_combinations_of_the_parameters_show(sensitivities, reference):
    """Frame and rear wheel, and fork and front wheel, each move as one body except for the spin."""
    time = np.linspace(0.0, 10.0, 401)
    sizes = np.array([abs(float(Exact.parse(reference.parameters[s]))) for s in PARAMETERS])
    rows = []
    for number in reference:
        found = sensitivities[number].evaluate(time, BENCHMARK_COLUMNS)
        for key, values in found.items():
            rows.append(values[:, : len(sizes)] * sizes / reference[number].scale(key))
    values = np.linalg.svd(np.concatenate(rows), compute_uv=False)
    assert np.sum(values > 1e-10 * values[0]) == 19
    # The singular values of visible combinations far exceed those of the other combinations, which
    # are only roundoff.
    assert values[18] > 1e8 * values[19]


def test_the_energy_stays_that_of_the_start(sensitivities):
    for found in sensitivities.values():
        coefficients = found.coefficients["mechanical_energy"]
        assert not coefficients[:, 1:].any()
        assert (coefficients[:, 0] == coefficients[0, 0]).all()
        values = found.values["mechanical_energy"]
        assert (values == values[0]).all()


def test_bounds_are_fourteen_digits(sensitivities):
    for found in sensitivities.values():
        for name in NAMES:
            largest = np.abs(found.coefficients[name]).max(axis=(0, 1))
            bound = found.bound[name].max(axis=0)
            assert (bound <= 24 * 2.0**-50 * largest + 1e-25).all(), name


def test_rows_are_the_pieces_within_the_bounds(sensitivities, reference):
    for number, found in sensitivities.items():
        assert np.array_equal(found.time, reference[number].time[::10])
        for name, values in found.evaluate(found.time, BENCHMARK_COLUMNS).items():
            largest = np.abs(found.coefficients[name]).max(axis=(0, 1))
            # Evaluating 24 terms in binary64 adds roundoff relative to the largest term.
            limit = found.bound[name].max(axis=0) + found.values_bound[name] + 2.0**-47 * largest
            assert (np.abs(values - found.values[name]) <= limit).all(), name
