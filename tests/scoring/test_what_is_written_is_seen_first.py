"""Faults in writing columns or rows are detected in the numbers and named with their size.

The files are the published rows with one fault. What remains after it is undone is diagnosed like
any file. Files whose columns have only small errors get no such finding.
"""

import numpy as np
import pytest

pytest.importorskip("heyoka")

from scipy.interpolate import CubicSpline
from scipy.signal import StateSpace, lfilter, lsim

from generators.mistaken_programs import columns_of, correct, motion
from generators.published_columns import side_by_side
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.mistakes.in_output import misspaced
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, apply
from heyoka_bike.scoring.diagnosis.programs.program import initial_state
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.row_checks import ROW_CHECKS
from heyoka_bike.scoring.rows.bounds import bounded
from heyoka_bike.scoring.rows.grids import coarse_grids
from heyoka_bike.scoring.score import score

ROWS = slice(0, 1001, 2)


def columns(reference):
    """Columns by maneuver and key, at the published rows."""
    return {n: {k: reference[n].rows[k][ROWS].copy() for k in KEYS} for n in reference}


def table(reference, by_maneuver):
    return side_by_side(by_maneuver, reference[1].time[ROWS])


def said(reference, by_maneuver):
    return diagnose(table(reference, by_maneuver), reference).diagnosis


def said_of_text(reference, by_maneuver, folder):
    """Findings on the file as text, where multiples of a step are rounded."""
    path, made = folder / "r.csv", table(reference, by_maneuver)
    lines = zip(*([f"{x:.12g}" for x in v] for v in made.values()), strict=True)
    path.write_text("\n".join([",".join(made), *map(",".join, lines)]) + "\n")
    return diagnose(path, reference).diagnosis


@pytest.mark.parametrize("step", [2 * np.pi / 4096, 2 * np.pi / 1000])
def test_a_coarse_grid(step, reference, tmp_path):
    held = columns(reference)
    for n in held:
        held[n]["steer_angle"] = step * np.rint(held[n]["steer_angle"] / step)
    (found,) = said_of_text(reference, held, tmp_path)
    assert found.code == "coarse_grid"
    assert (found.evidence["column"], found.evidence["maneuvers"]) == ("steer_angle", [1, 2, 3])
    assert found.evidence["step"] == pytest.approx(step, rel=1e-9)


def test_a_grid_begins_with_a_given_row_and_tells_nothing_beside_right_columns(reference, tmp_path):
    """Counts of an encoder, offset by half a step, which cannot be the rounding of the correct
    speed."""
    held, step = columns(reference), 2 * np.pi * 0.3 / 4096 / 0.01
    for n in held:
        speed = held[n]["forward_speed"]
        speed[1:] = step * np.floor(speed[1:] / step - 0.7)
    (found,) = said_of_text(reference, held, tmp_path)
    assert found.code == "coarse_grid"
    assert found.evidence["column"] == "forward_speed"
    assert found.evidence["step"] == pytest.approx(step, rel=1e-9)


@pytest.mark.parametrize(("scale", "shift"), [(1.0, -0.01), (1.0, 0.0037), (0.998, 0.0)])
def test_the_clock_of_one_maneuver(scale, shift, reference):
    held = columns(reference)
    time = reference[1].time[ROWS]
    meant = np.clip(scale * time + shift, 0.0, 10.0)
    held[3] = {key: reference[3].approximate(meant, [key])[key] for key in KEYS}
    first, *rest = said(reference, held)
    assert first.code == "other_clock"
    assert first.evidence["maneuver"] == 3
    assert first.evidence["scale"] == pytest.approx(scale, abs=1e-7)
    assert first.evidence["shift"] == pytest.approx(shift, abs=1e-7)
    # Clipping puts the first row of the shifted clock at 0 s, which is also the time of the start.
    # So the diagnosis may also report a remainder.
    assert {f.code for f in rest} <= {"remainder"}


def few(reference, keys, times):
    """Some columns of all maneuvers, evaluated at times other than the written ones."""
    return {
        f"m{n}_{key}": reference[n].approximate(times, [key])[key]
        for n in reference
        for key in keys
    }


def test_columns_of_another_row_beside_right_ones_are_named(reference):
    """Velocities are those of the row before, but the positions are those of the row."""
    held, late = columns(reference), ("roll_rate", "forward_speed", "steer_rate")
    for key in late:
        held[2][key] = np.r_[held[2][key][:1], held[2][key][:-1]]
    first, *rest = said(reference, held)
    assert (first.code, first.evidence["columns"]) == ("other_clock", [*late])
    assert (first.evidence["maneuver"], first.evidence["shift"]) == (2, pytest.approx(-0.02))
    assert [f.code for f in rest] in ([], ["remainder"])


@pytest.mark.parametrize("keys", [("roll_angle",), KEYS])
@pytest.mark.parametrize("is_single", [True, False])
def test_times_that_are_added_up(keys, is_single, reference):
    """The times add up an inexact step; the motion is that of the exact multiples."""
    step = np.float32(0.01) if is_single else 0.01 + 3e-8
    written = np.add.accumulate(np.full(1000, step)).astype(np.float64)
    meant = 0.01 * np.arange(1, 1001)
    made = {"time": np.insert(written, 0, 0.0)}
    made |= few(reference, keys, np.insert(meant, 0, 0.0))
    first, *rest = diagnose(made, reference).diagnosis
    assert first.code == "times_added_up"
    assert first.evidence["step"] == 0.01
    assert first.evidence["is_single"] is is_single
    assert first.evidence["creep"] == pytest.approx(float(np.max(np.abs(written - meant))))
    assert {f.code for f in rest} <= {"remainder"}


@pytest.mark.parametrize("keys", [("roll_angle", "steer_angle"), ("forward_speed",)])
@pytest.mark.parametrize("scale", [0.99, 1.0001])
def test_the_clock_of_a_file_of_few_columns(keys, scale, reference):
    time = 0.0098 * np.arange(1001)
    made = {"time": time} | few(reference, keys, scale * time)
    first, *rest = diagnose(made, reference).diagnosis
    assert (first.code, first.evidence["maneuver"]) == ("other_clock", None)
    assert first.evidence["scale"] == pytest.approx(scale, abs=1e-7)
    assert {f.code for f in rest} <= {"remainder"}


@pytest.mark.parametrize("count", [3, 11, 25])
def test_a_moving_average(count, reference):
    held = columns(reference)
    weights = np.full(count, 1.0 / count)
    for n in held:
        padded = {k: np.pad(x, count // 2, "edge") for k, x in held[n].items()}
        held[n] = {k: np.convolve(x, weights, "valid") for k, x in padded.items()}
    first, *rest = said(reference, held)
    assert (first.code, first.evidence["rows"]) == ("smoothed_columns", count)
    assert {f.code for f in rest} <= {"remainder"}


def with_filter(x, step, constant, way):
    """Return the output of a low-pass filter of first order, which starts with its input.

    The usual discrete filter, or the solution of T y' + y = x for an input that is linear from row
    to row.
    """
    if way == "usual":
        a = step / (constant + step)
        return lfilter([a], [1.0, a - 1.0], x, zi=[(1.0 - a) * x[0]])[0]
    time = step * np.arange(len(x))
    return lsim(StateSpace(-1.0 / constant, 1.0 / constant, 1.0, 0.0), x, time, X0=x[0])[1]


@pytest.mark.parametrize("way", ["usual", "exact"])
@pytest.mark.parametrize("keys", [KEYS, ("steer_rate",)])
def test_a_low_pass_filter(keys, way, reference):
    held = columns(reference)
    for n in held:
        held[n] |= {k: with_filter(held[n][k], 0.02, 0.03, way) for k in keys}
    first, *rest = said(reference, held)
    assert first.code == "filtered_columns"
    # Energies and speed hardly vary, so their digits may hide the filter.
    seen = {place.split(".")[1] for place in first.evidence["columns"]}
    assert {*keys} & {*LATERAL} <= seen <= {*keys}
    assert first.evidence["time_constant"] == pytest.approx(0.03, rel=1e-4)
    assert {f.code for f in rest} <= {"remainder"}


def test_counts_of_a_power_of_two_are_no_single_precision(reference):
    """Counts of an encoder have far fewer bits than single-precision numbers, in any binade."""
    held = columns(reference)
    for n in held:
        held[n]["steer_angle"] = np.floor(held[n]["steer_angle"] * 512) / 512
    codes = {f.code for f in said(reference, held)}
    assert "coarse_grid" in codes
    assert not codes & {"single_precision", "half_precision"}


@pytest.mark.parametrize("delay", [0.001, 0.01, 0.023])
def test_a_delay_is_no_filter(delay, reference):
    late = np.maximum(reference[1].time[ROWS] - delay, 0.0)
    held = columns(reference)
    for n in held:
        held[n] |= reference[n].approximate(late, ["steer_rate"])
    assert "filtered_columns" not in {f.code for f in said(reference, held)}


@pytest.mark.parametrize(
    ("key", "numbers", "factor", "offset", "unit"),
    [
        ("roll_angle", (1, 2, 3), 1.0005, 0.0, None),
        ("roll_angle", (2,), 180 / np.pi, 0.0, "degree"),
        ("steer_rate", (3,), 1.0, 0.02, None),
        ("kinetic_energy", (1, 2, 3), 1.01, 0.0, None),
    ],
)
def test_a_ratio_or_a_zero(key, numbers, factor, offset, unit, reference):
    held = columns(reference)
    for n in numbers:
        held[n][key] = factor * held[n][key] + offset
    found = [f for f in said(reference, held) if f.code == "column_ratio"]
    assert [f.evidence["column"] for f in found] == [key]
    (evidence,) = (f.evidence for f in found)
    assert evidence["maneuvers"] == list(numbers)
    assert evidence["factor"] == pytest.approx(factor, rel=1e-9)
    assert evidence["offset"] == pytest.approx(offset, abs=1e-9)
    assert evidence["unit"] == unit


def average_by_simpson(x):
    """Return the average over each step of 0.02 s, from rows 0.01 s apart."""
    return (x[:-2:2] + 4.0 * x[1:-1:2] + x[2::2]) / 6.0


def average_of_ends(x):
    return (x[:-2:2] + x[2::2]) / 2.0


@pytest.mark.parametrize("average", [average_by_simpson, average_of_ends])
@pytest.mark.parametrize("step", ["before", "after"])
@pytest.mark.parametrize(
    ("key", "name", "numbers"),
    [
        ("forward_speed", "forward_speed", (1, 2, 3)),
        ("forward_speed", "forward_speed_contact", (1, 2, 3)),
        ("kinetic_energy", "kinetic_energy", (2,)),
    ],
)
def test_the_average_over_a_step(key, name, numbers, step, average, reference):
    held = columns(reference)
    for n, of in held.items():
        of[key] = reference[n].rows[name][ROWS].copy()
        if n in numbers:
            of[key][slice(1, None) if step == "before" else slice(-1)] = average(
                reference[n].rows[name]
            )
    first, *rest = said(reference, held)
    assert first.code == "step_average"
    assert first.evidence == {"column": key, "maneuvers": list(numbers), "step": step}
    assert {f.code for f in rest} <= {"remainder"}


def test_a_value_half_a_step_late_is_no_average(reference):
    held = columns(reference)
    for n, of in held.items():
        of["forward_speed"][1:] = reference[n].rows["forward_speed"][1:-1:2]
    assert "step_average" not in {f.code for f in said(reference, held)}


@pytest.mark.parametrize("error", [0.0, 1e-9])
@pytest.mark.parametrize(
    ("key", "numbers", "factor", "offset", "since", "until"),
    [
        ("steer_angle", (1, 2, 3), 180 / np.pi, 0.0, 5.0, None),
        ("roll_rate", (2,), -1.0, 0.0, None, 3.0),
        ("forward_speed", (1, 3), 1.0, 0.02, 4.0, 6.0),
    ],
)
def test_a_ratio_or_a_zero_for_a_time(key, numbers, factor, offset, since, until, error, reference):
    """The rest of the column may have the error of an integrator."""
    held = columns(reference)
    time = reference[1].time[ROWS]
    for n in held:
        held[n] = {k: x * (1.0 + error * np.sin(time)) for k, x in held[n].items()}
    for n in numbers:
        within = (time >= (since or 0.0)) & (time <= (until or 10.0))
        held[n][key] = np.where(within, factor * held[n][key] + offset, held[n][key])
    first, *_ = said(reference, held)
    assert (first.code, first.evidence["column"]) == ("column_ratio", key)
    assert first.evidence["maneuvers"] == list(numbers)
    assert first.evidence["factor"] == pytest.approx(factor, abs=1e-5)
    assert first.evidence["offset"] == pytest.approx(offset, abs=1e-5)
    assert (first.evidence["since"], first.evidence["until"]) == (since, until)


def test_a_column_that_rests_from_some_row_on_has_no_ratio(reference):
    held = columns(reference)
    for of in held.values():
        of["steer_angle"][250:] = of["steer_angle"][250]
    assert "column_ratio" not in {f.code for f in said(reference, held)}


def test_a_ratio_of_two_columns_alone(reference):
    held = {n: {k: x for k, x in c.items() if k in ("roll_angle", "steer_angle")}
            for n, c in columns(reference).items()}  # fmt: skip
    for n in held:
        held[n]["roll_angle"] *= 1.0005
    found = said(reference, held)
    assert [f.code for f in found if f.severity == "warning"] == ["column_ratio"]


@pytest.mark.parametrize(("numbers", "pair"), [
    ((2,), ("potential_energy", "kinetic_energy")), ((1, 3), ("roll_angle", "steer_angle")),
    ((1,), ("roll_rate", "steer_rate")),
])  # fmt: skip
def test_columns_exchanged_in_some_maneuvers(numbers, pair, reference):
    """The parts of a constant sum are functions of each other, but each is also the other
    column."""
    held = columns(reference)
    for n in numbers:
        held[n] |= {key: held[n][other] for key, other in (pair, pair[::-1])}
    (found,) = (
        f for f in said(reference, held) if f.severity == "warning" and f.code != "another_start"
    )
    assert found.code == "other_column"
    assert found.evidence["is_exchanged"]
    assert {found.evidence["column"], found.evidence["other"]} == {*pair}
    assert found.evidence["maneuvers"] == list(numbers)


def test_energies_exchanged_in_all_maneuvers(reference):
    held = columns(reference)
    for n in held:
        potential, kinetic = held[n]["potential_energy"], held[n]["kinetic_energy"]
        held[n] |= {"potential_energy": kinetic, "kinetic_energy": potential}
    first = said(reference, held)[0]
    assert first.code == "mistake"
    assert "The kinetic energy is in the place of the potential energy" in first.message


def test_a_column_without_its_signs(reference):
    held = columns(reference)
    for n in held:
        held[n]["roll_angle"] = np.abs(held[n]["roll_angle"])
    found = next(f for f in said(reference, held) if f.code == "unsigned_column")
    # In maneuver 3 the bicycle leans only to the right, so its column does not change.
    assert (found.evidence["column"], found.evidence["maneuvers"]) == ("roll_angle", [1, 2])


@pytest.mark.parametrize("keys", [KEYS, ("roll_angle", "steer_rate")])
def test_a_maneuver_to_the_other_side_is_a_start(reference, keys):
    held = {n: {key: of[key] for key in keys} for n, of in columns(reference).items()}
    for key in {*keys} & {*LATERAL}:
        held[2][key] *= -1
    (found,) = said(reference, held)
    assert (found.code, found.evidence["maneuvers"]) == ("mirrored", [2])
    # If all maneuvers are mirrored, this counts as a convention.
    for n in (1, 3):
        for key in {*keys} & {*LATERAL}:
            held[n][key] *= -1
    assert "mirrored" not in [f.code for f in said(reference, held)]


def test_a_wrong_motion_that_stops_is_diagnosed_up_to_there(reference):
    held = of_another_bicycle(reference, IFyy="0.25")
    for of in held.values():
        for x in of.values():
            x[400:] = x[400]
    stopped, cause = said(reference, held)
    assert (stopped.code, stopped.evidence["rows"]) == ("rows_repeated", 101)
    assert stopped.evidence["maneuvers"] == [1, 2, 3]
    assert "From 8 s on, the rows of maneuvers 1, 2 and 3 do not change" in stopped.message
    ((change,),) = cause.evidence["changes"]
    assert (change["unknown"], change["value"]) == ("IFyy", pytest.approx(0.25))
    # The gyroscopic moment of the wheel acts most on the steer axis.
    assert cause.evidence["acceleration"]["equation"] == "steer"
    assert cause.evidence["acceleration"]["relief"] > 1e3
    assert "steer" not in cause.message


def test_rates_that_are_set_to_zero_are_not_held(reference):
    held = columns(reference)
    for n in held:
        x = held[n]["steer_rate"]
        held[n]["steer_rate"] = np.where(np.abs(x) < np.median(np.abs(x)), 0.0, x)
    assert "rows_between" not in [f.code for f in said(reference, held)]


@pytest.mark.parametrize("numbers", [(1, 2, 3), (2,)])
def test_an_energy_without_the_rotation_of_the_wheels_is_no_ratio(reference, numbers):
    """A ratio explains nearly all of each maneuver; in one maneuver alone, a ratio and an offset
    do."""
    mistake = next(m for m in MISTAKES if m.code == "energy_without_rotation_of_wheels")
    made = columns_of(reference, (mistake,))
    held = {n: {"kinetic_energy": made[n]["kinetic_energy"][ROWS]} for n in numbers}
    (found,) = said(reference, held)
    assert (found.code, found.evidence["mistakes"]) == ("mistake", [mistake.code])


def test_values_without_their_exponents_are_no_average(reference):
    """9.3e-05 was written as 9.3. Smoothing would explain most rows equally well, as these are
    right."""
    held = columns(reference)
    for n in held:
        x = held[n]["steer_angle"]
        held[n]["steer_angle"] = np.where(np.abs(x) < 1e-4, x * 1e5, x)
    assert "smoothed_columns" not in {f.code for f in said(reference, held)}


def test_a_ratio_in_one_maneuver_is_none_where_the_column_is_wrong_in_others(reference):
    """In maneuver 3 the potential energy hardly varies, so the difference of the energies resembles
    a ratio."""
    energies = {
        n: held["kinetic_energy"] - held["potential_energy"]
        for n, held in columns(reference).items()
    }
    first, *_ = said(reference, {n: {"mechanical_energy": x} for n, x in energies.items()})
    assert first.code == "mistake"
    assert "the mechanical energy is the kinetic minus the potential energy" in first.message


@pytest.mark.parametrize(
    "code",
    [
        "potential_energy_without_H",
        "energies_without_F",
        "kinetic_energy_without_B",
        "speed_written_by_front_radius",
    ],
)
def test_a_known_mistake_takes_the_place_of_a_ratio(code, reference):
    """If a maneuver hardly varies, a factor and an offset explain nearly all of it."""
    (mistake,) = (m for m in MISTAKES if m.code == code)
    program, time = apply(correct(reference), (mistake,)), reference[1].time[ROWS]
    simulator, held = Simulator(), {}
    for n in reference:
        start = initial_state(program.motion.bicycle, program.motion.starts[n])
        made = simulator.run(program.motion.bicycle, start, time)
        made = program.written(made, time)
        held[n] = {key: made[key] for key in KEYS}
        if code.startswith("speed"):
            held[n]["forward_speed"] = made["forward_speed_wheel_spin"]
    found = [f for f in said(reference, held) if f.code != "unknown_definition"]
    assert (found[0].code, found[0].evidence["mistakes"]) == ("mistake", [code])


def test_the_energies_of_the_bodies_are_those_of_their_masses(reference):
    """Energies [J] at the upright start: weight times height, and each mass's own kinetic
    energy."""
    program = correct(reference)
    start = initial_state(program.motion.bicycle, program.motion.starts[2])
    made = {k: x[0] for k, x in Simulator().run(program.motion.bicycle, start, np.zeros(1)).items()}
    g, speed, roll = 9.81, 4.6, 0.5
    heights = {"R": 0.3, "B": 0.9, "H": 0.7, "F": 0.35}
    masses = {"R": 2.0, "B": 85.0, "H": 4.0, "F": 3.0}
    about_x = {"R": 0.0603, "B": 9.2, "H": 0.05892, "F": 0.1405}
    spin = {"R": 0.12 * (speed / 0.3) ** 2, "F": 0.28 * (speed / 0.35) ** 2}
    for b, mass in masses.items():
        kinetic = mass * (speed**2 + (heights[b] * roll) ** 2) + about_x[b] * roll**2
        expected = (kinetic + spin.get(b, 0.0)) / 2
        assert made[f"kinetic_energy_of_{b}"] == pytest.approx(expected, rel=1e-12)
        weight = mass * g * heights[b]
        assert made[f"potential_energy_of_{b}"] == pytest.approx(weight, rel=1e-12)


def test_the_energies_of_the_bodies_are_all_there_is(reference):
    program, time = correct(reference), reference[1].time[ROWS]
    start = initial_state(program.motion.bicycle, program.motion.starts[2])
    made = Simulator().run(program.motion.bicycle, start, time)
    for kind in ("kinetic", "potential"):
        parts = sum(made[f"{kind}_energy_of_{b}"] for b in "RBHF")
        np.testing.assert_allclose(parts, made[f"{kind}_energy"], rtol=1e-12)


def of_another_bicycle(reference, **values):
    """Columns of a bicycle with other parameters, by maneuver and key."""
    found = {}
    program = correct(reference)
    changes = {k: Exact.parse(v) for k, v in values.items()}
    bicycle = Bicycle("other", {**program.motion.bicycle.values, **changes})
    for n, start in program.motion.starts.items():
        made = Simulator().run(bicycle, initial_state(bicycle, start), reference[n].time[ROWS])
        found[n] = {key: made[key].copy() for key in KEYS}
    return found


def test_a_wrong_motion_beside_an_angle_in_the_place_of_its_rate(reference):
    held = of_another_bicycle(reference, zB="-0.89")
    for n in held:
        held[n]["steer_angle"], held[n]["steer_rate"] = (
            held[n]["steer_rate"], held[n]["steer_angle"],
        )  # fmt: skip
    exchanged, cause = said(reference, held)
    assert exchanged.code == "other_column"
    assert exchanged.message.startswith("steer_rate and steer_angle of maneuvers 1, 2 and 3 are ex")
    ((change,),) = cause.evidence["changes"]
    assert (change["unknown"], change["value"]) == ("zB", pytest.approx(-0.89))


def test_a_wrong_motion_beside_a_clipped_column(reference):
    held = of_another_bicycle(reference, w="1.025")
    for n in held:
        held[n]["roll_rate"] = np.clip(held[n]["roll_rate"], -0.2, 0.2)
    clipped, cause = said(reference, held)
    assert clipped.code == "clipped_column"
    assert not clipped.evidence["is_right_within"]
    assert (clipped.evidence["low"], clipped.evidence["high"]) == (-0.2, 0.2)
    ((change,),) = cause.evidence["changes"]
    assert (change["unknown"], change["value"]) == ("w", pytest.approx(1.025))


def test_a_mistake_in_one_maneuver_alone_is_found_there(reference):
    """The parameter differs in the input of one maneuver only; no single program makes all
    maneuvers."""
    held = columns(reference)
    held[2] = of_another_bicycle(reference, IFyy="0.275")[2]
    cause, where = said(reference, held)
    ((change,),) = cause.evidence["changes"]
    assert (change["unknown"], change["value"]) == ("IFyy", pytest.approx(0.275))
    assert where.code == "right_elsewhere"
    assert (where.evidence["wrong"], where.evidence["right"]) == ([2], [1, 3])


def test_a_grid_is_not_all_where_a_column_is_off_by_more(reference, tmp_path):
    """Values wrap around beyond the range of 16 bits."""
    held, step = columns(reference), 0.2 / 2**15
    for n in held:
        counts = np.rint(held[n]["steer_angle"] / step) + 2**15
        held[n]["steer_angle"] = step * (np.mod(counts, 2**16) - 2**15)
    first, *rest = said_of_text(reference, held, tmp_path)
    assert first.code == "coarse_grid"
    assert "remainder" not in [f.code for f in rest]
    assert rest


@pytest.mark.parametrize("key", ["forward_speed", "steer_angle"])
def test_a_few_levels_are_no_bounds(reference, key):
    held = columns(reference)
    for n in held:
        size = np.ptp(held[n][key]) / 3
        held[n][key][20:] = size * np.rint(held[n][key][20:] / size)
    report = score(table(reference, held), reference)
    assert bounded(report) is None


def test_rows_that_are_held_stay_at_no_bound(reference):
    held = columns(reference)
    for n in held:
        for key in KEYS:
            held[n][key] = np.repeat(held[n][key][::6], 6)[: len(held[n][key])]
    report = score(table(reference, held), reference)
    assert bounded(report) is None


def test_a_clipped_column(reference):
    held = columns(reference)
    held[2]["roll_rate"] = np.clip(held[2]["roll_rate"], -0.2, 0.25)
    found = next(f for f in said(reference, held) if f.code == "clipped_column")
    assert (found.evidence["low"], found.evidence["high"]) == (-0.2, 0.25)
    assert found.evidence["maneuvers"] == [2]


def test_columns_that_are_all_clipped_in_their_first_and_last_rows(reference):
    held = columns(reference)
    of = {key: held[3][key].copy() for key in ("roll_angle", "steer_angle")}
    of["roll_angle"] = np.clip(of["roll_angle"], of["roll_angle"][2], of["roll_angle"][-13])
    of["steer_angle"] = np.clip(of["steer_angle"], -3.5e-4, 2.7e-3)
    assert [(f.code, f.evidence["column"]) for f in said(reference, {3: of})] == [
        ("clipped_column", "roll_angle"), ("clipped_column", "steer_angle"),
    ]  # fmt: skip


def test_each_maneuver_has_a_grid_of_its_own_digits(reference):
    """Ten digits of an energy are more decimal places in one maneuver than in another."""
    held = columns(reference)
    steps = {1: 1e-6, 2: 1e-6, 3: 1e-5}
    for n, step in steps.items():
        held[n]["kinetic_energy"] = np.rint(held[n]["kinetic_energy"] / step) * step
    report = score(table(reference, held), reference)
    seen = coarse_grids(report).seen
    found = {n: x.step for x in seen for n in x.maneuvers}
    assert found == pytest.approx(steps)


@pytest.mark.parametrize("how", ["backward", "forward", "central"])
def test_a_rate_of_differences_beside_another_mistake(how, reference):
    """The column is excluded, and the mistake of the model is found without it."""
    program = apply(correct(reference), [m for m in MISTAKES if m.code == "inertia_2_decimals"])
    time = reference[1].time[ROWS]
    held = {}
    for n in reference:
        made = motion(
            program.motion.bicycle,
            initial_state(program.motion.bicycle, program.motion.starts[n]),
            time,
        )
        held[n] = {key: made[key] for key in KEYS}
        slopes = np.diff(held[n]["steer_angle"]) / np.diff(time)
        rates = {
            "backward": np.insert(slopes, 0, slopes[0]),
            "forward": np.append(slopes, slopes[-1]),
            "central": np.gradient(held[n]["steer_angle"], time),
        }
        held[n]["steer_rate"] = rates[how]
    first, second, *_ = said(reference, held)
    # Backward differences are nearly equal to the rates half a row earlier. They are still
    # recognised as differences.
    assert (first.code, first.evidence["how"]) == ("rate_of_differences", how)
    assert (second.code, second.evidence["mistakes"]) == ("mistake", ["inertia_2_decimals"])


@pytest.mark.parametrize("rows", [1.0, -1.0, 0.5, -0.5])
def test_a_rate_of_another_row_beside_a_wrong_motion(reference, rows):
    held = of_another_bicycle(reference, IFyy="0.25")
    for n in held:
        slopes = CubicSpline(reference[n].time[ROWS], held[n]["roll_rate"])
        held[n]["roll_rate"] = slopes(reference[n].time[ROWS] - rows * 0.02)
    shifted, cause, *_ = said(reference, held)
    assert (shifted.code, shifted.evidence["column"]) == ("rate_of_other_row", "roll_rate")
    assert shifted.evidence["rows"] == rows
    ((change,),) = cause.evidence["changes"]
    assert (change["unknown"], change["value"]) == ("IFyy", pytest.approx(0.25))


def test_beside_a_right_rate_the_angle_is_that_of_another_row(reference):
    held = columns(reference)
    for n in held:
        x = held[n]["steer_angle"]
        held[n]["steer_angle"] = np.r_[x[:1], x[:-1]]
    first = said(reference, held)[0]
    assert (first.code, first.evidence["column"]) == ("other_moment", "steer_angle")
    assert first.evidence["rows"] == 1


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e-4])
def test_nothing_is_seen_in_files_of_integrators(size, reference):
    """All columns have errors that grow like an integrator's."""
    held = columns(reference)
    time = reference[1].time[ROWS]
    for n in held:
        for i, key in enumerate(KEYS):
            scale = size * reference[n].scale(key)
            held[n][key] += scale * (time / 10) ** 2 * np.sin((2 + i / 3) * time + n)
    report = score(table(reference, held), reference)
    assert not any(check.find(report) for check in ROW_CHECKS)


def test_rows_that_are_spread_are_those_of_the_file():
    """Stretched times contradict the findings that a row is missing or too many."""
    even = 0.01 * np.arange(1001)
    assert [m.code for m in misspaced(even, 10.0)] == ["end_left_out"]
    assert [m.code for m in misspaced(even[:-1], 10.0)] == ["one_row_less"]
    assert misspaced(0.999 * even, 10.0) == ()
    assert misspaced(even[:500], 10.0) == ()
    assert misspaced(even[:1], 10.0) == ()
