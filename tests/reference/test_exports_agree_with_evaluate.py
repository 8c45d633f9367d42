"""The exported C, Fortran and Octave code, compiled and run, agrees with `evaluate`."""

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from support.export_programs import c_values, export, fortran_values, octave_values

EVERY_COLUMN = tuple(c.name for c in COLUMNS)

# Tolerance in units of the last place of a column's scale. The largest difference of the 22 columns
# at 16000 times was one unit, from the last sum of Clenshaw's rule. The second unit allows for the
# rounded argument and for fused products.
ULPS = 2
# Tolerance relative to a column's scale. Sums of double-double numbers with fused operations differ
# in their last bits, by 2^-104 of a term. The largest difference was 3e-32.
LAST_BITS = 1e-31


@pytest.fixture(scope="module")
def times(reference):
    """Random times, rows, breaks and their neighbours, as hi + lo, for each maneuver."""
    random = np.random.default_rng(7)
    breaks = np.unique(np.concatenate([m.breaks for m in reference.values()]))
    inside = breaks[1:-1]
    plain = np.concatenate(
        [random.uniform(0, 10, 2500), breaks, np.nextafter(inside, 0), np.nextafter(inside, 10),
         [np.nextafter(0, 1), np.nextafter(10, 0), 1e-20, 0.07]]
    )  # fmt: skip
    split = random.uniform(0.1, 9.9, 500)
    hi = [plain, split, reference[1].time, inside, inside]
    tiny = np.full_like(inside, 2.0**-80)
    lo = [np.zeros_like(plain), np.spacing(split) * random.uniform(-0.5, 0.5, 500),
          reference[1].time_lo, tiny, -tiny]  # fmt: skip
    return np.concatenate(hi), np.concatenate(lo)


def plain_clenshaw(maneuver, name, t):
    """Compute the sum of the exports in NumPy: products and sums in the same order."""
    piece = np.minimum(
        np.searchsorted(maneuver.breaks, t, side="right") - 1, len(maneuver.breaks) - 2
    )
    a, b = maneuver.breaks[piece], maneuver.breaks[piece + 1]
    x = ((t - a) - (b - t)) / (b - a)
    c = maneuver.dense[name][piece].T
    b1 = b2 = np.zeros_like(x)
    for k in range(len(c) - 1, 0, -1):
        b1, b2 = c[k] + (2 * x * b1 - b2), b1
    return c[0] + (x * b1 - b2)


def check_plain(found, reference, columns, t):
    for i, m in enumerate(reference.values()):
        expected = m.evaluate(t, columns)
        for j, name in enumerate(columns):
            ulp = np.spacing(m.scale(name))
            assert np.max(np.abs(found[i, j] - expected[name])) <= ULPS * ulp, (m.name, name)
            # The values are identical, so no coefficient has lost a bit by conversion to text.
            assert np.array_equal(found[i, j], plain_clenshaw(m, name, t)), (m.name, name)


of_some_and_all = pytest.mark.parametrize(
    ("options", "columns"),
    [
        ((), BENCHMARK_COLUMNS),
        pytest.param(("--columns", "all"), EVERY_COLUMN, marks=pytest.mark.proof),
    ],
)


@of_some_and_all
def test_c_agrees_to_the_last_bit(reference, tmp_path, times, options, columns):
    export(tmp_path, "c", *options)
    found = c_values(tmp_path, times, len(reference), columns)
    check_plain(found[..., 0], reference, columns, times[0])
    for i, m in enumerate(reference.values()):
        expected = m.evaluate(times, columns)
        for j, name in enumerate(columns):
            assert np.array_equal(found[i, j, :, 1], expected[name]), (m.name, name)
            assert np.array_equal(found[i, j, :, 2], expected.lo[name]), (m.name, name)


def test_optimised_c_agrees_to_its_arithmetic(reference, tmp_path, times):
    export(tmp_path, "c")
    flags = ("-O3", "-march=native", "-ffp-contract=fast")
    found = c_values(tmp_path, times, len(reference), BENCHMARK_COLUMNS, flags)
    for i, m in enumerate(reference.values()):
        expected = m.evaluate(times, BENCHMARK_COLUMNS)
        expected_plain = m.evaluate(times[0], BENCHMARK_COLUMNS)
        for j, name in enumerate(BENCHMARK_COLUMNS):
            plain, hi, lo = found[i, j].T
            scale = m.scale(name)
            assert np.max(np.abs(plain - expected_plain[name])) <= ULPS * np.spacing(scale), name
            difference = (hi - expected[name]) + (lo - expected.lo[name])
            assert np.max(np.abs(difference)) <= LAST_BITS * scale, name
            # hi is the rounded sum. It differs from the expected number only if the sum is nearly
            # halfway between two numbers.
            assert np.mean(hi == expected[name]) > 0.999, name


@of_some_and_all
def test_fortran_agrees(reference, tmp_path, times, options, columns):
    export(tmp_path, "fortran", *options)
    found = fortran_values(tmp_path, times, len(reference), columns)
    check_plain(found, reference, columns, times[0])


@of_some_and_all
def test_octave_agrees(reference, tmp_path, times, options, columns):
    export(tmp_path, "matlab", *options)
    found = octave_values(tmp_path, times, len(reference), columns)
    check_plain(found, reference, columns, times[0])


@pytest.mark.parametrize(
    ("kind", "values"), [("c", c_values), ("fortran", fortran_values), ("matlab", octave_values)]
)
def test_times_outside_the_run_give_nan(reference, tmp_path, kind, values):
    export(tmp_path, kind)
    hi = np.array([-0.0, 10.0, -1e-300, np.nextafter(10, 11), np.inf, -np.inf, np.nan, 10.0])
    lo = np.array([0, 0, 0, 0, 0, 0, 0, 1e-20])
    found = values(tmp_path, (hi, lo), len(reference), BENCHMARK_COLUMNS)
    found = found.reshape(len(reference), len(BENCHMARK_COLUMNS), len(hi), -1)
    assert np.isfinite(found[:, :, :2]).all()
    assert np.isnan(found[:, :, 2:7]).all()
    # The time 10 + 1e-20 is outside the run if hi + lo is used, but inside if only hi is used.
    assert np.isfinite(found[:, :, 7, 0]).all()
    assert np.isnan(found[:, :, 7, 1:]).all()


@pytest.mark.parametrize(("kind", "values"), [("c", c_values), ("fortran", fortran_values)])
def test_what_is_not_exported_is_nan(reference, tmp_path, kind, values):
    export(tmp_path, kind, "--maneuver", "2", "--columns", "yaw")
    t = np.array([0.5, 10.0])
    found = values(tmp_path, (t, 0 * t), len(reference), ("yaw",))
    found = found.reshape(len(reference), 1, len(t), -1)
    assert np.isnan(found[[0, 2]]).all()
    assert found[1, 0, :, 0] == pytest.approx(reference[2].evaluate(t)["yaw"], rel=1e-14)


def test_fast_math_is_refused(tmp_path):
    export(tmp_path, "c")
    with pytest.raises(AssertionError, match="compile without -ffast-math"):
        c_values(tmp_path, (np.zeros(1), np.zeros(1)), 3, BENCHMARK_COLUMNS, ("-Ofast",))
