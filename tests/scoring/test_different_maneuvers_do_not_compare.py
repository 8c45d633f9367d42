"""If programs that are compared have different maneuvers, the report says so where it names the
best."""

from dataclasses import replace

from generators.made_results import made
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.series import compare


def rough(key, values, number):
    return values * (1 + 1e-4 * number)


def codes(series):
    return [f.code for f in series.findings]


def test_different_maneuvers_are_in_the_findings_and_the_verdict(reference):
    whole = made(reference, rough)
    part = replace(whole, maneuvers=whole.maneuvers[:1])
    series = compare({"whole": whole, "part": part}, reference=reference)
    (found,) = (f for f in series.findings if f.code == "maneuvers_differ")
    assert found.severity == Severity.WARNING
    assert found.evidence == {"maneuvers": {"whole": [1, 2, 3], "part": [1]}}
    assert "(whole: 1, 2, 3; part: 1)" in found.message
    said = "part is the best of 2 programs, which cover different maneuvers: "
    assert series.verdict.startswith(said)


def test_programs_of_the_same_maneuvers_are_not_warned_of(reference):
    series = compare({"fine": made(reference), "rough": made(reference, rough)},
                     reference=reference)  # fmt: skip
    assert "maneuvers_differ" not in codes(series)
    assert series.verdict.startswith("fine is the best of 2 programs: ")
