"""`simulate` meets the requested accuracy, with any rows, and `Ensemble` agrees with it."""

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike import simulate
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.workbench.fast.ensemble import TOLERANCES, Ensemble
from heyoka_bike.workbench.fast.simulate import prepare

pytest.importorskip("heyoka")

STATE_COLUMNS = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
# Energies near 1e3 J have an error of at most this multiple of the error of the state.
ENERGY = 1e4


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory):
    """A cache for these tests only, so that they use newly compiled code."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HEYOKA_BIKE_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def errors(result, reference):
    """Return the largest error of each column, over maneuvers and rows."""
    right = np.array([[m.rows.hi[name] for name in BENCHMARK_COLUMNS] for m in reference.values()])
    return dict(zip(BENCHMARK_COLUMNS, np.abs(result.values - right).max(axis=(0, 2)), strict=True))


def eq1(result):
    energy = result["mechanical_energy"].reshape(-1, len(result.time))
    return (100 * (energy.max(axis=1) - energy.min(axis=1)) / energy[:, 0]).max()


@pytest.mark.parametrize(
    "accuracy",
    [
        1e-4,
        1e-6,
        *(pytest.param(x, marks=pytest.mark.slow) for x in (1e-8, 1e-10, 1e-12, 1e-13)),
    ],
)
def test_error_is_below_what_was_asked_for(reference, accuracy):
    found = errors(simulate(accuracy=accuracy), reference)
    assert all(found[name] < accuracy for name in STATE_COLUMNS)
    assert all(found[name] < ENERGY * accuracy for name in BENCHMARK_COLUMNS if "energy" in name)
    # The run must not be much more accurate than requested, because it would then take longer than
    # needed.
    assert max(found[name] for name in STATE_COLUMNS) > accuracy / 100


def test_eq1_is_kept(reference):
    result = simulate(accuracy="eq1")
    assert 1e-5 < eq1(result) < 1e-3
    found = errors(result, reference)
    assert all(found[name] < 1e-3 for name in STATE_COLUMNS)  # docs/speed.md states this limit


def test_one_maneuver_is_the_same_as_among_three():
    three = simulate(accuracy=1e-6)
    for number in (1, 2, 3):
        one = simulate(number, accuracy=1e-6)
        assert one["roll_angle"].shape == (1001,)
        # The results of vector and scalar code differ only by rounding.
        assert np.abs(one.values[0] - three.values[number - 1]).max() < 1e-9
    assert three["roll_angle"].shape == (3, 1001)


def test_table_is_that_of_the_benchmark(reference):
    table = simulate(accuracy=1e-6).table()
    assert table.shape == (1001, 25)
    assert np.array_equal(table[:, 0], reference.times)
    assert np.abs(table[:, 9] - reference[2].rows.hi["roll_angle"]).max() < 1e-6


def test_rows_anywhere(reference):
    # Test more rows than are evaluated at once, and times that are not multiples of the steps.
    for given, count in (({"rows": 3001}, 3001), ({"spacing": "0.0025"}, 4001), ({"rows": 2}, 2)):
        result = simulate(2, accuracy=1e-6, **given)
        assert len(result.time) == count
        right = reference[2].evaluate(result.time, "steer_rate").hi["steer_rate"]
        assert np.abs(result["steer_rate"] - right).max() < 1e-6
    assert not result.time.flags.writeable


def test_runs_are_repeatable():
    run = prepare(2)
    first, second = run(), run()
    assert np.array_equal(first.values, second.values)
    assert run.steps[0] > 10


def test_zero_trail_takes_the_other_form(bicycle, maneuvers):
    # The equations with few products divide by the mechanical trail, which is c cos(lam) for the
    # upright bicycle. It is zero here, so the other form of the equations is needed.
    other = bicycle.replace(c=Exact(Fraction(0)))
    short = dataclasses.replace(maneuvers[1], duration=Fraction(1))
    result = simulate(short, bicycle=other, accuracy=1e-6)
    right = integrate(other, short)
    for row in (10, 50, 100):
        state = right.state(short.time(row))
        assert result["roll_angle"][row] == pytest.approx(float(state[0]), abs=1e-6)
        assert result["steer_angle"][row] == pytest.approx(float(state[2]), abs=1e-6)


def test_a_fall_is_told(maneuvers):
    fall = dataclasses.replace(
        maneuvers[0], speed=Exact(Fraction(1, 2)), roll_rate=Exact(Fraction(1))
    )
    with pytest.raises(SingularMotionError) as e:
        simulate(fall)
    assert 0 < e.value.time < 10


def test_no_run_steps_over_a_singularity(maneuvers):
    # At 0.76 s, roll and steer rate no longer determine the turn rate. A long step would pass this
    # time without noticing it.
    fall = dataclasses.replace(
        maneuvers[0], speed=Exact(Fraction(565, 1000)), roll_rate=Exact(Fraction(-537, 1000))
    )
    for accuracy in ("eq1", 1e-6, 1e-10):
        with pytest.raises(SingularMotionError) as e:
            simulate(fall, accuracy=accuracy)
        assert e.value.time == pytest.approx(0.76, abs=0.01)
    starts = np.zeros((200, 5))
    starts[:, 2], starts[:, 4] = np.linspace(-2, 2, 200), np.tile(np.linspace(0.2, 4, 20), 10)
    energy = BENCHMARK_COLUMNS.index("mechanical_energy")
    for accuracy, drift in (("eq1", 2e-4), (1e-6, 1e-5)):
        begin = Ensemble(accuracy=accuracy).ends(starts, 1e-6)[:, energy]
        end = Ensemble(accuracy=accuracy).ends(starts, 10.0)[:, energy]
        alive = np.isfinite(end)
        assert 0 < alive.sum() < len(starts)
        assert np.abs(end / begin - 1)[alive].max() < drift


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"maneuvers": 4}, "found maneuver 4, expected 1 to 3"),
        ({"maneuvers": []}, "found no maneuver"),
        ({"accuracy": 1e-14}, "found accuracy 1e-14"),
        ({"accuracy": "best"}, "found accuracy best"),
        ({"rows": 1}, "found 1 rows"),
        ({"rows": 10, "spacing": 1}, "found both rows and spacing"),
        ({"spacing": 0}, "found spacing 0 s"),
        ({"spacing": "0.000001"}, "found 10000001 rows"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        simulate(**arguments)


def test_maneuvers_of_different_lengths_are_refused(maneuvers):
    longer = dataclasses.replace(maneuvers[1], duration=Fraction(11))
    with pytest.raises(InputError, match="different durations"):
        simulate([maneuvers[0], longer])


def test_an_ensemble_ends_where_single_runs_do(reference):
    starts = np.array([[0, 0, 0.05, 0, 4.0], [0, 0, 0.5, 0, 4.6], [0, 0, 0.05, 0, 8.0]])
    right = np.array([[m.rows.hi[c][-1] for c in BENCHMARK_COLUMNS] for m in reference.values()])
    places = [BENCHMARK_COLUMNS.index(c) for c in STATE_COLUMNS]
    for threads in (1, 2):
        ends = Ensemble(accuracy=1e-6, threads=threads).ends(np.tile(starts, (7, 1)), 10.0)
        assert np.abs(ends - np.tile(right, (7, 1)))[:, places].max() < 1e-6


@pytest.mark.parametrize("accuracy", [x for x in TOLERANCES if x not in ("eq1", "roundoff")])
def test_an_ensemble_keeps_its_accuracy(accuracy):
    random = np.random.default_rng(3)
    # The number of starts is the same as in the test of `simulate`. Among thousands of starts, one
    # in a hundred has an error above the limit.
    starts = np.zeros((20, 5))
    for column, limits in ((2, (-0.5, 0.5)), (3, (-0.4, 0.4)), (4, (4.3, 9.0))):
        starts[:, column] = random.uniform(*limits, len(starts))
    right = [
        simulate(
            Maneuver(
                "other", Exact(Fraction(v)), Exact(Fraction(w)), Fraction(10), Fraction(10),
                steer_rate=Exact(Fraction(s)),
            ),
            accuracy="roundoff",
        ).values[0, :, -1]
        for _, _, w, s, v in starts
    ]  # fmt: skip
    places = [BENCHMARK_COLUMNS.index(c) for c in STATE_COLUMNS]
    wrong = np.abs(Ensemble(accuracy=accuracy).ends(starts, 10.0) - right)[:, places].max()
    assert accuracy / 100 < wrong < accuracy


def test_an_ensemble_starts_on_the_floor(maneuvers):
    turned = Maneuver(
        "turned", Exact(Fraction(5)), Exact(Fraction(1, 10)), Fraction(1), Fraction(1, 10),
        roll=Exact(Fraction(1, 10)), steer=Exact(Fraction(1, 20)), steer_rate=Exact(Fraction(1, 5)),
    )  # fmt: skip
    end = Ensemble(accuracy=1e-6).ends(np.array([[0.1, 0.05, 0.1, 0.2, 5.0]]), 1.0)[0]
    assert np.abs(end - simulate(turned, accuracy=1e-6).values[0, :, -1]).max() < 1e-4


def test_a_fall_in_an_ensemble_is_alone():
    starts = np.array([[0, 0, 0.5, 0, 4.6], [0, 0, 1.0, 0, 0.5], [0, 0, 0.05, 0, 8.0]])
    ends = Ensemble(accuracy=1e-4).ends(starts, 10.0)
    assert np.isnan(ends[1]).all()
    assert np.isfinite(ends[[0, 2]]).all()
