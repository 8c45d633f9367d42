"""`heyoka-bike verify --rerun` counts the digits that a new run reproduces."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest

import heyoka_bike.reference.verification.numbers as rerun_module
from heyoka_bike.cli import main
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.layout import CANDIDATE, TEXT_50
from heyoka_bike.reference.verification.numbers import agreement, precisions
from heyoka_bike.reference.verification.verify import verify


@pytest.fixture(scope="module")
def part(small_set):
    (part,) = verify(small_set).parts
    return part


def compare(part, precision, **changes):
    """Compare a rerun of the part, with other contents of some files."""
    part = replace(part, files={**part.files, **changes})
    return agreement(part, Precision.of(precision), lambda stage, t: None)


@pytest.mark.proof
def test_digits_by_column_and_maneuver(small_set, capsys):
    assert main(["verify", str(small_set), "--rerun", "--quick", "--format", "json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    checks = [c for c in json.loads(out)["checks"] if c["check"] == "rerun"]
    assert [c["evidence"]["precision"] for c in checks] == ["binary128", "40 digits"]
    for check, digits in zip(checks, (30, 38), strict=True):
        evidence = check["evidence"]
        assert check["passed"] is True
        assert evidence["values"] == 2 * 11 * 38
        assert len(evidence["digits"]) == len(evidence["digits_of_candidate"]) == 38
        # The rerun agrees with the candidate to about the digits of its precision. The published
        # values themselves have at least 31 digits.
        assert min(evidence["digits_of_candidate"].values()) > digits - 2
        assert max(evidence["digits_of_candidate"].values()) < digits + 6
        assert min(evidence["digits"].values()) > 29
        for name, promised in evidence["digits_promised"].items():
            assert evidence["digits"][name] >= promised > 20


@pytest.mark.proof
def test_the_table_names_columns_and_precisions(small_set, capsys):
    assert main(["verify", str(small_set), "--rerun", "--quick", "--workers", "1"]) == 0
    out = capsys.readouterr().out
    for word in (
        "steer_rate",
        "binary128",
        "40 digits",
        "short 1",
        "expected, at least",
        "agreeing digits",
    ):
        assert word in out


@pytest.mark.proof
def test_the_precisions_are_those_of_the_set_and_20_digits_more(part):
    assert [p.name for p in precisions(part.run, is_quick=False)] == ["70 digits", "90 digits"]
    assert [p.name for p in precisions(part.run, is_quick=True)] == ["binary128", "40 digits"]


@pytest.mark.slow
def test_a_full_rerun_agrees_to_the_last_published_digit(part):
    for precision in precisions(part.run, is_quick=False):
        found = compare(part, precision.name.split()[0])
        assert found.tally.failures == 0
        assert found.published["steer_angle"] > 49
        assert min(found.candidate.values()) > 65


@pytest.mark.proof
def test_a_run_of_too_few_digits_is_seen(part, monkeypatch):
    """A tolerance a million times too large costs more digits than the promise allows."""

    def sloppy(*arguments, **options):
        return integrate(*arguments, **options, tolerance=1e-20)

    assert compare(part, 40).tally.failures == 0
    monkeypatch.setattr(rerun_module, "integrate", sloppy)
    found = compare(part, 40)
    assert found.tally.failures > 0
    assert found.check().passed is False
    assert "from the published value, expected at most" in found.check().message


@pytest.mark.proof
def test_a_published_value_that_is_wrong_is_seen(part):
    """A run with 40 digits shows a wrong 32nd digit; binary128 does not have enough digits."""
    columns = dict(part.long_text.columns)
    tokens = list(columns[1, "steer_rate"])
    wrong = Fraction(tokens[3]) * (1 + Fraction(1, 10**31))
    tokens[3] = f"{wrong.numerator * 10**60 // wrong.denominator}e-60"
    text = replace(part.long_text, columns=columns | {(1, "steer_rate"): tuple(tokens)})
    found = compare(part, 40, **{TEXT_50: text})
    assert found.tally.failures > 0
    assert "steer_rate, row 3" in found.tally.first
    assert compare(part, "binary128", **{TEXT_50: text}).tally.failures == 0


@pytest.mark.proof
def test_another_bicycle_is_seen(part):
    from heyoka_bike.numbers.exact import Exact

    other = part.run.bicycle.replace(g=Exact.parse("9.8100000000000000000000000001"))
    found = compare(part, 40, **{CANDIDATE: replace(part.run, bicycle=other)})
    assert found.tally.failures > 0


@pytest.mark.proof
def test_a_set_that_is_not_whole_is_not_run_again(small_set, tmp_path, capsys):
    import shutil

    copy = shutil.copytree(small_set, tmp_path / "copy")
    (copy / "uncontrolled-bicycle.txt").unlink()
    assert main(["verify", str(copy), "--rerun", "--quick", "--format", "json"]) == 3
    (last,) = [c for c in json.loads(capsys.readouterr().out)["checks"] if c["check"] == "rerun"]
    assert last["passed"] is None
    assert "another check failed" in last["message"]
