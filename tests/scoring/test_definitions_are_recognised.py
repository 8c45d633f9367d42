"""Each definition, sign, unit and zero is recognised where the values show it, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from generators.made_results import codes, column, made, rows, smooth_error
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.score import score

ALTERNATES = [c for columns in DEFINITIONS.values() for c in columns[1:]]


def with_alternate(c):
    return [c.name if key == c.key else key for key in BENCHMARK_COLUMNS]


def test_the_reference_scores_at_its_floor_without_a_word(reference):
    report = score(made(reference), reference)
    assert report.findings == ()
    for m in report.maneuvers:
        assert m.performance == 0.0
        for c in m.columns:
            assert c.as_understood is c.as_written
            assert c.as_understood.definition == DEFINITIONS[c.key][0].definition
            assert 0 < c.as_understood.measures.max_abs_error <= c.floor


@pytest.mark.parametrize("alternate", ALTERNATES, ids=lambda c: c.name)
def test_every_definition_is_named(reference, alternate):
    report = score(made(reference, names=with_alternate(alternate)), reference)
    assert codes(report) == ["conventions", "definition"]
    for number in reference:
        c = column(report, number, alternate.key)
        assert c.as_understood.definition == alternate.definition
        assert c.as_understood.measures.max_abs_error <= c.floor
        assert c.as_written.definition == DEFINITIONS[alternate.key][0].definition
        # With the default definition, the error is the difference between the two definitions.
        m = reference[number]
        distance = np.max(np.abs(m[alternate.name] - m.rows[alternate.key]))
        assert c.as_written.measures.max_abs_error == pytest.approx(distance, rel=1e-3)
        by_name = {a.definition: a.max_abs_error for a in c.alternatives}
        assert by_name[c.as_written.definition] == pytest.approx(distance, rel=1e-2)
        assert alternate.definition not in by_name


@pytest.mark.parametrize("alternate", ALTERNATES, ids=lambda c: c.name)
def test_none_is_claimed_below_the_error_of_the_file(reference, alternate):
    """Each maneuver has, after the first row, an error three times the difference of the
    definitions."""

    def change(key, values, number):
        if key != alternate.key:
            return values
        m = reference[number]
        distance = np.max(np.abs(m[alternate.name] - m.rows[alternate.key]))
        return values + smooth_error(reference, number, 3 * distance)

    written = made(reference, change, with_alternate(alternate), keep=slice(1, None))
    report = score(written, reference)
    assert column(report, 1, alternate.key).as_understood.definition == (
        DEFINITIONS[alternate.key][0].definition
    )
    assert alternate.definition in column(report, 1, alternate.key).indistinguishable
    assert "definition" not in codes(report)


@pytest.mark.parametrize("definition", ["hub_norm", "com_norm"])
def test_the_first_row_tells_what_the_others_cannot(reference, definition):
    """A hub moves sideways at the start, so the magnitude of its velocity differs from the given
    speed."""

    def change(key, values, number):
        return values + (smooth_error(reference, number, 0.1) if key == "forward_speed" else 0.0)

    names = with_alternate(
        next(c for c in DEFINITIONS["forward_speed"] if c.definition == definition)
    )
    found = column(score(made(reference, change, names), reference), 1, "forward_speed")
    assert found.as_understood.definition == definition
    odds = {a.definition: a.log10_odds for a in found.alternatives}
    # The prior probability that one row differs from all other rows is one in a thousand.
    before = np.log10(5)
    assert 8 < odds["hub_heading"] + before < 10


def test_odds_are_those_of_the_definition_taken(reference):
    """One maneuver is exact; the error of another exceeds the difference of the definitions."""

    def change(key, values, number):
        if key != "roll_angle" or number == 2:
            return values
        return values + smooth_error(reference, number, 1.0)

    names = ["roll_angle_tait_bryan_xyz", *BENCHMARK_COLUMNS[1:]]
    found = column(score(made(reference, change, names), reference), 1, "roll_angle")
    assert found.as_understood.definition == "tait_bryan_xyz"
    assert found.indistinguishable == ()
    odds = {a.definition: a.log10_odds for a in found.alternatives}
    # Only maneuver 2 gives evidence. The odds are the cube of a ratio: the difference between the
    # two definitions, divided by the smallest error that counts.
    rows = reference[2].rows
    apart = np.sort(abs(rows["roll_angle"] - rows["roll_angle_tait_bryan_xyz"]))[:-10]
    most = 3 * np.log10(np.sqrt(np.mean(apart**2)) / (1e-15 * np.max(abs(rows["roll_angle"]))))
    before = np.log10(5)
    assert odds["lean"] == pytest.approx(most - before, abs=0.1)


def test_one_bad_row_does_not_hide_the_definition(reference):
    def change(key, values, number):
        if key == "roll_angle":
            values[500] = 7.0
        return values

    names = ["roll_angle_tait_bryan_xyz", *BENCHMARK_COLUMNS[1:]]
    report = score(made(reference, change, names), reference)
    found = column(report, 1, "roll_angle").as_understood
    assert found.definition == "tait_bryan_xyz"
    assert found.measures.time_of_max == 5.0


@pytest.mark.parametrize("flipped", [("roll_angle", "roll_rate"), ("steer_angle", "steer_rate"),
                                     ("forward_speed",)])  # fmt: skip
def test_the_other_sign_is_recognised_and_scored_both_ways(reference, flipped):
    def change(key, values, number):
        return -values if key in flipped else values

    report = score(made(reference, change), reference)
    # If only the roll has a flipped sign, this may be a mistake. So it is a warning and not a
    # convention.
    is_odd = "roll_angle" in flipped
    expected = ["sign"] * len(flipped)
    assert codes(report) == (
        [*expected, "senses_opposed"] if is_odd else ["conventions", *expected]
    )
    for key in flipped:
        c = column(report, 2, key)
        assert c.as_understood.sign == -1
        assert c.as_understood.measures.max_abs_error <= c.floor
        assert c.as_written.sign == 1
        assert c.as_written.measures.max_rel_error == pytest.approx(2.0)


def test_signs_that_disagree_are_a_warning(reference):
    report = score(made(reference, lambda k, v, n: -v if k == "roll_rate" else v), reference)
    assert codes(report) == ["sign", "signs_disagree"]


@pytest.mark.parametrize(
    ("keys", "unit", "in_si"),
    [
        (("roll_angle", "steer_angle"), "degree", np.pi / 180),
        (("roll_rate", "steer_rate"), "degree s-1", np.pi / 180),
        (("forward_speed",), "km h-1", 5 / 18),
        (("forward_speed",), "mm s-1", 1e-3),
        (("potential_energy", "kinetic_energy", "mechanical_energy"), "kJ", 1e3),
        (("potential_energy", "kinetic_energy", "mechanical_energy"), "mJ", 1e-3),
    ],
)
def test_units_are_recognised_and_scored_both_ways(reference, keys, unit, in_si):
    report = score(made(reference, lambda k, v, n: v / in_si if k in keys else v), reference)
    assert codes(report) == ["conventions"] + ["unit"] * len(keys)
    for key in keys:
        c = column(report, 1, key)
        assert c.as_understood.unit == unit
        # The error consists of three roundings: of the reference's row, of the factor and of the
        # quotient.
        largest = np.max(np.abs(reference[1][key]))
        assert c.as_understood.measures.max_abs_error <= 1.5 * np.spacing(largest)
        assert c.as_written.unit == c.unit
        assert c.as_written.measures.max_rel_error == pytest.approx(abs(1 - 1 / in_si), rel=1e-6)


@pytest.mark.parametrize("offset", [-794.1195, 120.0, -276.6])
def test_another_zero_of_the_potential_energy_is_recognised(reference, offset):
    def change(key, values, number):
        return values + offset if key in ("potential_energy", "mechanical_energy") else values

    report = score(made(reference, change), reference)
    assert codes(report) == ["conventions", "offset", "offset"]
    for key in ("potential_energy", "mechanical_energy"):
        c = column(report, 3, key)
        assert c.as_understood.offset == pytest.approx(offset, rel=1e-9)
        assert c.as_understood.measures.max_abs_error < 1e-11
        assert c.as_written.measures.max_abs_error == pytest.approx(abs(offset), rel=1e-6)


def test_a_zero_that_the_mechanical_energy_does_not_share_is_none(reference):
    report = score(
        made(reference, lambda k, v, n: v - 200.0 if k == "potential_energy" else v), reference
    )
    assert codes(report).count("energy_sum") == 1
    assert "offset" not in codes(report)
    assert column(report, 1, "potential_energy").as_understood.offset == 0.0


@pytest.mark.parametrize("wrong", [0.0, 500.0])
def test_a_column_of_one_number_is_no_potential_energy(reference, wrong):
    def change(key, values, number):
        return np.full_like(values, wrong) if key == "potential_energy" else values

    results = made(reference, change)
    for part in results.maneuvers:
        part.values.pop("mechanical_energy")
    assert not {"offset", "unit"} & set(codes(score(results, reference)))


@pytest.mark.parametrize("rows_kept", [1, 3])
def test_a_few_wrong_rows_are_given_no_meaning(reference, rows_kept):
    random = np.random.default_rng(2)

    def change(key, values, number):
        return values + random.standard_normal(len(values)) * np.max(np.abs(values))

    report = score(made(reference, change, keep=slice(5, 5 + rows_kept)), reference)
    assert not {"offset", "unit", "sign", "definition"} & set(codes(report))


def test_a_constant_mechanical_energy_alone_is_an_error_not_a_zero(reference):
    # A wrong initial speed would also shift the energy by a constant.
    report = score(
        made(reference, lambda k, v, n: v + 5.0 if k == "mechanical_energy" else v), reference
    )
    c = column(report, 1, "mechanical_energy")
    assert c.as_understood.offset == 0.0
    assert c.as_understood.measures.max_abs_error == pytest.approx(5.0)
    assert codes(report) == ["energy_sum"]


def test_a_mechanical_energy_alone_is_in_no_smaller_unit_with_another_zero(reference):
    """Interpreted in millijoules, every error would be a thousand times smaller."""

    def change(key, values, number):
        rounded = np.round(values + 0.01 * np.sin(3.0 * reference[number].time), 6)
        return rounded if key == "mechanical_energy" else values

    part = made(reference, change)
    kept = tuple(
        replace(x, values={k: v for k, v in x.values.items()
                           if k not in ("kinetic_energy", "potential_energy")})
        for x in part.maneuvers if x.maneuver == 2
    )  # fmt: skip
    c = column(score(replace(part, maneuvers=kept), reference), 2, "mechanical_energy")
    assert (c.as_understood.unit, c.as_understood.offset) == ("J", 0.0)
    assert c.as_understood.measures.max_abs_error == pytest.approx(0.01, rel=0.01)


def test_drifting_energy_is_no_offset(reference):
    def change(key, values, number):
        drift = 1e-2 * reference[number].time
        return values + drift if key == "potential_energy" else values

    report = score(made(reference, change), reference)
    assert column(report, 1, "potential_energy").as_understood.offset == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_noise_is_not_given_a_meaning(reference, seed):
    random = np.random.default_rng(seed)

    def change(key, values, number):
        return random.standard_normal(len(values)) * np.max(np.abs(values))

    report = score(made(reference, change), reference)
    assert not {"sign", "unit", "definition", "offset"} & set(codes(report))


def test_the_choice_is_joint_over_the_maneuvers(reference):
    # With this error, maneuver 3 alone cannot distinguish the definitions of speed, but the other
    # maneuvers can.
    def change(key, values, number):
        return values + (smooth_error(reference, number, 1e-9) if key == "forward_speed" else 0.0)

    names = [
        "forward_speed_hub_body_x" if key == "forward_speed" else key for key in BENCHMARK_COLUMNS
    ]
    report = score(made(reference, change, names), reference)
    assert column(report, 3, "forward_speed").as_understood.definition == "hub_body_x"


WRONG_MODELS = [{"mB": "80"}, {"mB": "84.99"}, {"g": "9.8"}, {"zB": "-0.91"}]


@pytest.fixture(scope="module")
def wrong_motions(reference, bicycle, maneuvers):
    """The motions of each wrong model in all maneuvers."""
    pytest.importorskip("heyoka")
    wrong = [bicycle.replace(**{s: Exact.parse(x) for s, x in c.items()}) for c in WRONG_MODELS]
    starts = [(0.0, 0.0, 0.0, float(m.roll_rate), 0.0, float(m.speed)) for m in maneuvers]
    asked = [
        MotionRequest(b, start, m.time)
        for b in wrong
        for start, m in zip(starts, reference.maneuvers, strict=True)
    ]
    made = iter(Simulator().run_all(asked))
    return [[next(made) for _ in starts] for _ in wrong]


@pytest.mark.parametrize("model", range(len(WRONG_MODELS)), ids=map(str, WRONG_MODELS))
@pytest.mark.parametrize("numbers", [(1, 2, 3), (3,)])
def test_a_wrong_model_is_not_excused_by_another_zero(reference, wrong_motions, model, numbers):
    """A wrong mass or height changes the potential and the total energy by nearly a constant."""
    motions = dict(enumerate(wrong_motions[model], start=1))
    parts = [rows(reference, n, {k: motions[n][k] for k in BENCHMARK_COLUMNS}) for n in numbers]
    report = score(Results("x", "text", tuple(parts)), reference)
    assert not {"offset", "unit", "sign"} & set(codes(report))


def test_the_zero_is_taken_where_the_motion_disturbs_it_least(reference):
    """A wrong potential energy in maneuver 1 does not affect the zero found from maneuver 3."""

    def change(key, values, number):
        error = smooth_error(reference, number, {1: 0.5, 2: 0.1, 3: 1e-9}[number])
        if key == "potential_energy":
            return values - 794.1195 + error
        return values - 794.1195 if key == "mechanical_energy" else values

    report = score(made(reference, change), reference)
    c = column(report, 3, "potential_energy")
    assert c.as_understood.offset == pytest.approx(-794.1195, abs=1e-8)
    assert c.as_understood.measures.max_abs_error < 1e-8


def test_a_first_row_without_a_value_says_nothing_of_the_start(reference):
    """The row after the missing one is not the start: there, the speed of a wrong model may have
    any value."""
    names = [
        "forward_speed_com_norm" if key == "forward_speed" else key for key in BENCHMARK_COLUMNS
    ]

    def change(key, values, number):
        if key == "forward_speed":
            values[0] = np.nan
            # Row 0 is missing, and row 1 after it is the only bad row.
            values[1] = reference[number]["forward_speed"][1]
        return values

    report = score(made(reference, change, names), reference)
    assert column(report, 1, "forward_speed").as_understood.definition == "com_norm"


def test_the_known_start_speaks_against_a_definition(reference):
    """A linear model has a constant speed. It is nearer to com_norm than to the default, but not at
    0 s."""

    def change(key, values, number):
        return np.full_like(values, values[0]) if key == "forward_speed" else values

    report = score(made(reference, change), reference)
    assert column(report, 2, "forward_speed").as_understood.definition == "hub_heading"


@pytest.mark.parametrize("factor", [1 / 0.3048], ids=["ft/s"])
def test_units_that_are_not_tried_are_not_taken_for_others(reference, factor):
    report = score(
        made(reference, lambda k, v, n: v * factor if k == "forward_speed" else v), reference
    )
    assert "unit" not in codes(report)
