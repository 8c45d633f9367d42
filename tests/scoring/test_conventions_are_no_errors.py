"""Conventions other than the default are reported first, and reported as no errors."""

from types import SimpleNamespace

import pytest

from generators.made_results import codes, column, made, smooth_error
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.scoring.diagnosis import diagnose as diagnosis
from heyoka_bike.scoring.diagnosis import pursue
from heyoka_bike.scoring.diagnosis.conclusions import Explained, NoCauseFound
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.search import ONLY_OUTPUT
from heyoka_bike.scoring.score import score

TURNED = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")


def renamed(**names):
    return [names.get(key, key) for key in BENCHMARK_COLUMNS]


def of_the_left(key, values, number):
    """Axes to the left, and a potential energy that is zero in the first row."""
    if key in TURNED:
        return -values
    return values - 794.1195 if key in ("potential_energy", "mechanical_energy") else values


def test_all_of_them_are_in_the_first_finding(reference):
    names = renamed(roll_angle="roll_angle_tait_bryan_xyz")
    report = score(made(reference, of_the_left, names), reference)
    first = report.findings[0]
    assert first.code == "conventions"
    for said in (
        "which are not errors",
        "roll and steer are positive to the left",
        "the zero of potential_energy, mechanical_energy is 794.1195 J above that at the floor",
        "roll_angle is tait_bryan_xyz (over 10^6 times as likely as lean)",
    ):
        assert said in first.message
    assert first.evidence["signs"] == list(TURNED)
    assert first.evidence["definitions"] == {"roll_angle": "tait_bryan_xyz"}


def test_a_file_by_default_has_none(reference):
    assert "conventions" not in codes(score(made(reference), reference))


def test_signs_that_contradict_each_other_are_no_convention(reference):
    report = score(made(reference, lambda k, v, n: -v if k == "roll_rate" else v), reference)
    assert codes(report) == ["sign", "signs_disagree"]


def test_diagnose_says_them_first(reference, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(diagnosis, "diagnosed", lambda report, *_: report)
    rows = made(reference, of_the_left).maneuvers[0]
    lines = ["t " + " ".join(rows.values)]
    for i, t in enumerate(reference.times):
        lines.append(" ".join([f"{t:.2f}", *(f"{v[i]:.17g}" for v in rows.values.values())]))
    path = tmp_path / "left.txt"
    path.write_text("\n".join(lines))
    assert main(["diagnose", str(path), "--maneuver", "1"]) == 0
    verdict, first, *_ = capsys.readouterr().out.split("\n\n")
    assert "correct digits" in verdict
    assert "positive to the" in first
    assert "are not errors" in first


def test_without_any_diagnose_names_the_default_ones(reference, capsys, monkeypatch):
    monkeypatch.setattr(diagnosis, "diagnosed", lambda report, *_: report)
    assert main(["diagnose", str(reference.folder / "uncontrolled-bicycle.txt")]) == 0
    conventions = capsys.readouterr().out.split("\n\n")[1]
    assert "SI units, roll and steer positive to the right" in conventions


# The mean of two different speeds is not the speed of any point of the bicycle.
def of_no_point(reference, size=1e-12):
    def change(key, values, number):
        if key == "forward_speed":
            rows = reference[number].rows
            return (rows["forward_speed_hub_global_x"] + rows["forward_speed_hub_norm"]) / 2
        return values + smooth_error(reference, number, size * max(abs(values)))

    return made(reference, change)


def test_a_column_of_no_known_definition_is_named_as_that(reference):
    report = score(of_no_point(reference), reference)
    found = report.findings[0]
    assert found.code == "definition_unknown"
    assert "definition" not in codes(report)
    assert found.evidence["column"] == "forward_speed"
    assert 11 < found.evidence["digits_of_others"] < 13
    for m in report.maneuvers:
        assert [c.key for c in m.columns if not c.is_known] == ["forward_speed"]


@pytest.mark.parametrize("is_explained", [True, False])
def test_a_column_of_unknown_definition_is_left_out_of_the_search(
    reference, monkeypatch, is_explained
):
    """The column is left out of the search. If no mistake explains the others, output faults are
    tried."""
    asked = []

    def explain(parts, *_, plan, **__):
        asked.append((plan is ONLY_OUTPUT, [sorted(p.values) for p in parts]))
        curves = ("a curve",) if plan is ONLY_OUTPUT or is_explained else ()
        return SimpleNamespace(curves=curves, is_whole=True, edit=None, causes=None)

    def answers(found, *_):
        named = Explained(1, (Hypothesis(MISTAKES[:1], {}, {}, ()),), None, None, ())
        return (named if found.curves else NoCauseFound(1, 1, "roll_angle", 0.1, False),)

    for stub in (explain, answers):
        monkeypatch.setattr(pursue, stub.__name__, stub)
    report = diagnosis.diagnose(of_no_point(reference), reference)
    others = sorted(set(BENCHMARK_COLUMNS) - {"forward_speed"})
    every = [(False, [others] * 3), (True, [sorted(BENCHMARK_COLUMNS)] * 3)]
    assert asked == every[: 1 if is_explained else 2]
    assert ("definition_unknown" in codes(report)) == is_explained


def test_where_all_columns_are_as_bad_it_is_not_the_definition(reference):
    """The two speeds differ by at most 1e-2 of the speed; errors of 3e-3 may hide the
    difference."""
    report = score(of_no_point(reference, 3e-3), reference)
    assert "definition_unknown" not in codes(report)


def test_a_few_bad_rows_are_no_other_meaning(reference):
    def change(key, values, number):
        if key == "forward_speed":
            values[100:120] += 0.1
        return values

    report = score(made(reference, change), reference)
    assert "definition_unknown" not in codes(report)
    assert column(report, 1, "forward_speed").is_known


def test_a_bad_column_of_one_meaning_is_an_error(reference):
    def change(key, values, number):
        wrong = 1e-3 * max(abs(values))
        return values + (smooth_error(reference, number, wrong) if key == "steer_angle" else 0.0)

    assert "definition_unknown" not in codes(score(made(reference, change), reference))
