"""The inputs, tables and edge in docs/harder-tier.md agree with the files and the program."""

import json
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from harder_tier import (
    CODES,
    FOUND,
    GRADES,
    PAGE,
    PROBLEMS,
    TABLES,
    TIGHT,
    growth,
    inputs,
    judge,
    pages,
    run,
    write,
)
from heyoka_bike.cli import main
from heyoka_bike.errors import SingularMotionError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.layout import CERTIFICATE
from heyoka_bike.reference.load import load_reference
from heyoka_bike.system.resources import data_folder

# Roll rates on the page: below the first one the bicycle recovers, above the second one it falls.
RECOVERS, FALLS = "2.46491144053243234304", "2.46491144053243234306"
# Sensitivities agree with differences over STEP up to the square of STEP, and up to a few digits of
# binary64.
STEP, NEAR = Fraction(1, 2**20), 1e-4


@pytest.fixture(scope="module")
def found():
    return json.loads(FOUND.read_text())


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A dataset of two short maneuvers of another bicycle, with rows of their own."""
    where = tmp_path_factory.mktemp("small")
    (where / "m.toml").write_text(
        'name = "small"\n'
        + "".join(
            f'[[maneuver]]\nname = "{name}"\nspeed = "{speed}"\nroll_rate = "0.5"\n'
            f'duration = "{duration}"\nspacing = "{spacing}"\n'
            for name, speed, duration, spacing in (
                ("p", 6, "0.02", "0.01"), ("q", 8, "0.04", "0.002"),
            )
        )
    )  # fmt: skip
    out = where / "set"
    arguments = ["--bicycle", "browser-jason", "--maneuvers", str(where / "m.toml")]
    assert main(["generate", *arguments, "--out", str(out)]) == 0
    return out


@pytest.mark.proof
def test_tables_are_those_of_the_json(found):
    committed = {page: page.read_text(encoding="utf-8") for page in (PAGE, TABLES)}
    assert pages(found) == committed
    for key, value in (
        ("roll", 2.0),
        ("codes", {c: {"scd": 1, "coverage": 1, "performance": 1} for c in CODES}),
    ):
        other = json.loads(FOUND.read_text())
        next(iter(other["H1"]["maneuvers"].values()))[key] = value
        assert pages(other) != committed


@pytest.mark.proof
def test_every_maneuver_and_code_was_run(found):
    assert list(found) == list(PROBLEMS)
    for name in found:
        _, maneuvers = inputs(PROBLEMS[name])
        assert list(found[name]["maneuvers"]) == [m.name for m in maneuvers]
        for m in maneuvers:
            said = found[name]["maneuvers"][m.name]
            assert said["rows"] == m.rows
            assert list(said["codes"]) == list(CODES)


@pytest.mark.proof
def test_a_hash_is_claimed_only_of_what_is_made_again(found):
    """Hashes of H1 and H4 are compared below; other datasets state how they were made."""
    hashed = {name for name in found if "content_sha256" in found[name]}
    assert hashed == {"H1", "H4"}
    assert {name for name in found if "made" in found[name]} == set(PROBLEMS) - hashed
    shas = re.findall(r"`[0-9a-f]{64}`", PAGE.read_text())
    assert shas == [f"`{found[name]['content_sha256']}`" for name in ("H1", "H4")]


@pytest.mark.proof
def test_inputs_are_the_decimals_that_the_page_names():
    _, longer = inputs(PROBLEMS["H2"])
    _, benchmark = inputs(PROBLEMS["H1"])
    stretched = replace(benchmark[0], name="H2", duration=Fraction(100), spacing=Fraction(1, 10))
    assert longer == (stretched,)
    bicycle, others = inputs(PROBLEMS["H4"])
    assert bicycle.name == "Batavus Browser with rider Jason"
    assert [m.speed for m in others] == [Exact(Fraction(v)) for v in ("4.5", "6", "8")]
    assert {(m.roll_rate, m.duration, m.rows) for m in others} == {(Exact.parse("0.5"), 10, 1001)}


@pytest.mark.proof
def test_the_edge_is_cut_after_so_many_decimals():
    _, maneuvers = inputs(PROBLEMS["H3"])
    cut = [Fraction(int(Fraction(RECOVERS) * 10**n), 10**n) for n in (4, 8, 12, 20)]
    wanted = [Fraction("1.0"), Fraction("2.0"), Fraction("2.4"), *cut]
    assert [m.roll_rate.rational for m in maneuvers] == wanted
    assert {(m.speed, m.duration, m.rows) for m in maneuvers} == {(Exact.parse("4.6"), 10, 1001)}
    # The last speed is not a binary64 number, as the page says.
    assert Fraction(float(cut[-1])) != cut[-1]
    for decimals in (RECOVERS, FALLS):
        assert decimals in PAGE.read_text()


@pytest.mark.proof
def test_the_published_set_is_the_first_problem(found, reference, folder):
    assert found["H1"]["content_sha256"] == reference.content_sha256
    certificate = json.loads((folder / CERTIFICATE).read_text())["maneuvers"]
    for number, said in enumerate(found["H1"]["maneuvers"].values(), start=1):
        assert said["roll"] == np.abs(reference[number].rows["roll_angle"]).max()
        assert said["bound"] == certificate[number - 1]["bound"]


@pytest.mark.proof
def test_condition_is_what_a_disturbed_start_makes(reference, folder):
    bicycle, maneuvers = inputs(PROBLEMS["H1"])
    m = maneuvers[1]
    times = reference[2].time
    moved = []
    for sign in (1, -1):
        other = replace(m, roll_rate=Exact(m.roll_rate.rational + sign * STEP))
        columns, _, _ = run(bicycle, other, "heyoka binary64")
        moved.append(columns[[0, 6, 1, 7, 2]])
    change = np.linalg.norm((moved[0] - moved[1]) / float(2 * STEP), axis=0)
    bound = growth(folder, 2, times)
    # Only one direction of the start is changed. So the change is at most the norm of the
    # sensitivity, and equals 1 at t = 0.
    assert change[0] == pytest.approx(1, abs=NEAR)
    assert np.all(change <= bound * (1 + NEAR) + NEAR)
    assert bound[0] == pytest.approx(1, abs=NEAR)
    assert change.max() > bound.max() / 10


@pytest.mark.proof
@pytest.mark.parametrize("code", ["LSODA tight", "heyoka binary64"])
def test_a_run_scores_as_the_page_says(found, reference, tmp_path, code):
    bicycle, maneuvers = inputs(PROBLEMS["H1"])
    columns, _, _ = run(bicycle, maneuvers[2], code)
    write(tmp_path / "run.txt", maneuvers[2], columns, 17)
    again = judge(tmp_path / "run.txt", 3, reference)
    said = found["H1"]["maneuvers"]["maneuver 3"]["codes"][code]
    # Recompiled code rounds differently, which changes the last of 15 digits.
    assert again["scd"] == pytest.approx(said["scd"], abs=1)
    assert again["coverage"] == said["coverage"] == 1


@pytest.mark.proof
def test_the_command_grades_another_bicycle_and_other_rows(small, tmp_path, capsys):
    text = small / "uncontrolled-bicycle-2.txt"
    rows = [line.split() for line in text.read_text().splitlines()]
    assert len(rows) == 21
    assert len(rows[0]) == 9
    # Add an error of 1e-7 of the largest steer angle, which leaves 7 correct digits.
    steer = max(abs(float(row[7])) for row in rows)
    for row in rows:
        row[7] = repr(float(row[7]) + 1e-7 * steer)
    wrong, part = tmp_path / "wrong.txt", tmp_path / "part.txt"
    wrong.write_text("\n".join(map(" ".join, rows)))
    part.write_text("\n".join(map(" ".join, rows[:-1])))
    more = ["--reference", str(small), "--maneuver", "2", "--require", "coverage >= 1", "--require"]
    assert main(["score", str(text), *more, "scd >= 12"]) == 0
    assert main(["score", str(wrong), *more, "scd >= 6"]) == 0
    assert main(["score", str(wrong), *more, "scd >= 9"]) == 3
    assert main(["score", str(part), *more, "scd >= 6"]) == 3
    assert "coverage" in capsys.readouterr().err


@pytest.mark.proof
def test_grades_and_tolerances_are_those_of_the_page():
    page, tables = PAGE.read_text(), TABLES.read_text()
    grades = ", ".join(map(str, GRADES[:-1])) + f" and {GRADES[-1]}."
    assert f"**Grades.** The grades are {grades}" in page
    assert f"rtol = atol = {TIGHT['DOP853']:g}, Radau {TIGHT['Radau']:g}" in tables
    assert TIGHT["DOP853"] == TIGHT["LSODA"]


@pytest.mark.proof
def test_commands_of_the_page_name_every_set():
    commands = re.findall(r"^heyoka-bike generate (.*?) *#", PAGE.read_text(), re.MULTILINE)
    assert len(commands) == len(PROBLEMS)
    for command, entry in zip(commands, PROBLEMS.values(), strict=True):
        words = command.split()
        given = dict(zip(words[::2], words[1::2], strict=True))
        assert given.pop("--out") == f"sets/{entry.maneuvers}"
        assert given.get("--bicycle", "benchmark") == entry.bicycle
        assert given.get("--maneuvers", "benchmark") == entry.maneuvers
        assert (data_folder() / "maneuvers" / f"{entry.maneuvers}.toml").exists()


@pytest.mark.slow
def test_beyond_the_edge_the_bicycle_falls():
    bicycle, maneuvers = inputs(PROBLEMS["H3"])
    integrate(bicycle, maneuvers[-1], "binary128")
    beyond = replace(maneuvers[-1], roll_rate=Exact.parse(FALLS))
    with pytest.raises(SingularMotionError):
        integrate(bicycle, beyond, "binary128")


@pytest.mark.slow
def test_errors_grow_near_the_edge_as_the_page_says():
    bicycle, maneuvers = inputs(PROBLEMS["H3"])
    one, other = (
        run(bicycle, replace(maneuvers[-1], roll_rate=rate), "heyoka binary128")[0]
        for rate in (maneuvers[-1].roll_rate, Exact(Fraction(RECOVERS) - Fraction(1, 10**27)))
    )
    grown = np.linalg.norm((other - one)[[0, 6, 1, 7, 2]].astype(float), axis=0)
    # The factor per second is averaged from 1 s to 6 s, while the motion follows the unstable
    # weave.
    assert 1000 < (grown[600] / grown[100]) ** (1 / 5) < 2500


@pytest.mark.slow
def test_the_set_of_another_bicycle_is_made_again(found, tmp_path):
    entry, out = PROBLEMS["H4"], tmp_path / "set"
    arguments = ["--bicycle", entry.bicycle, "--maneuvers", entry.maneuvers]
    assert main(["generate", *arguments, "--out", str(out)]) == 0
    assert load_reference(out).content_sha256 == found["H4"]["content_sha256"]
