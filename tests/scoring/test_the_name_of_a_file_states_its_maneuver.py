"""The name of a file states its maneuver, unless its rows, an option or its values contradict."""

import io
from dataclasses import replace

import numpy as np
import pytest

from generators.mistaken_programs import correct
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.diagnosis.programs.program import changed, initial_state
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.scoring.evidence.as_compared import (
    ManeuverGuessed,
    ManeuverNamedOtherwise,
    ManeuverRecognised,
    OtherManeuver,
)
from heyoka_bike.scoring.reading.names.heading import number_of_file
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.series import score_files

KINDS = (ManeuverGuessed, ManeuverNamedOtherwise, ManeuverRecognised)


def file(reference, path, held, *, columns=None, keys=BENCHMARK_COLUMNS, told=None):
    """Return a file with the columns of the maneuver `held`, by default the exact ones."""
    m = reference[held]
    values = {key: np.array((columns or m)[key]) for key in keys}
    return Results(path, "text", (Rows(told, m.time, m.time_lo, values),))


def seen(report):
    return [replace(x, file="") for x in report.seen if isinstance(x, KINDS)]


def write(reference, folder, held):
    """Write text files with exact columns; `held` contains the maneuver of each name."""
    for name, n in held.items():
        m = reference[n]
        table = np.column_stack([m.time, *(m[key] for key in BENCHMARK_COLUMNS)])
        np.savetxt(folder / name, table, fmt="%.17g")
    return [str(folder / name) for name in held]


@pytest.fixture(scope="module")
def lateral(reference):
    """Angles and rates of a wrong program in maneuver 1, which also fit maneuver 3."""
    program = changed(correct(reference), {"IFxx": -0.07})
    start = initial_state(program.motion.bicycle, program.motion.starts[1])
    asked = MotionRequest(program.motion.bicycle, start, reference[1].time)
    (columns,) = Simulator().run_all([asked])
    return columns


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("m1.csv", 1), ("M2.DAT", 2), ("m_3", 3), ("maneuver_2.txt", 2), ("manoeuvre-3.csv.gz", 3),
        ("Maneuver 2.xlsx", 2), ("man2.npy", 2), ("runs/7/m01.csv", 1), ("result_m2.csv", 2),
        ("run-maneuver3.h5", 3), ("dt_0.01_m2.csv", 2), ("rk4 maneuver_1.csv", 1),
        ("run1.csv", None), ("test2.csv", None), ("T1.csv", None), ("1.csv", None), ("-", None),
        ("m1/run.csv", None), ("m1/m2.csv", 2), ("m1.5.csv", None), ("m1_rk4.csv", None),
        ("am2.csv", None), ("item3.csv", None), ("x_m_2.csv", None), ("IFxx_0.28_kg_m2.csv", None),
        ("m1_m2.csv", None), ("m2 (1).csv", None), ("x.m2.csv", None), ("m1234.csv", None),
    ],
)  # fmt: skip
def test_only_sure_names_state_a_maneuver(name, number):
    assert number_of_file(name) == number


def test_the_name_decides_between_maneuvers_that_fit(reference, lateral):
    for path, n, expected in (
        ("m3.csv", 3, ManeuverRecognised(3, is_by_name=True)),
        ("m1.csv", 1, ManeuverRecognised(1, is_by_name=True)),
        ("one.csv", 1, ManeuverGuessed(1, (3,), "--maneuver N")),
        ("m4.csv", 1, ManeuverGuessed(1, (3,), "--maneuver N")),
        ("m2.csv", 1, ManeuverNamedOtherwise(1, 2, (1, 3))),
    ):
        report = score(file(reference, path, 1, columns=lateral, keys=LATERAL), reference)
        assert ([*report], seen(report)) == ([n], [expected]), path


@pytest.mark.parametrize("name", ["m2.csv", "one.csv", "run1.csv"])
def test_certain_values_are_recognised_as_before(reference, name):
    report = score(file(reference, name, 2), reference)
    assert report.is_right
    assert seen(report) == [ManeuverRecognised(2)]


def test_a_right_file_with_a_misleading_name_stays_right(reference):
    report = score(file(reference, "runs/m1.csv", 2), reference, require="scd >= 15")
    assert report.is_right
    assert report.passed
    assert [*report] == [2]
    assert seen(report) == [ManeuverNamedOtherwise(2, 1, (2,))]


def test_rows_options_and_arrays_have_no_use_for_the_name(reference, lateral, monkeypatch):
    for told, n in ((1, 1), (3, 3)):
        given = file(reference, "m2.csv", 1, columns=lateral, keys=LATERAL, told=told)
        assert ([*score(given, reference)], seen(score(given, reference))) == ([n], [])
    rows = tuple(file(reference, "m1.csv", n).maneuvers[0] for n in (2, 3))
    both = score(Results("m1.csv", "text", rows), reference)
    assert seen(both) == [ManeuverRecognised(2), ManeuverRecognised(3)]
    array = replace(file(reference, "m1.csv", 2), format="array")
    assert seen(score(array, reference)) == [ManeuverRecognised(2)]
    m = reference[2]
    table = io.BytesIO()
    np.savetxt(table, np.column_stack([m.time, *(m[key] for key in BENCHMARK_COLUMNS)]))
    table.seek(0)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(table))
    assert seen(score("-", reference)) == [ManeuverRecognised(2)]


@pytest.mark.parametrize("held", [(1, 3, 3), (2, 3, 3), (1, 1, 1), (3, 1, 3)])
def test_names_decide_if_two_files_have_one_maneuver(reference, held):
    files = [file(reference, f"m{i}.csv", n) for i, n in enumerate(held, start=1)]
    report = score(files, reference)
    assert [*report] == [1, 2, 3]
    wrong = [(i, n) for i, n in enumerate(held, start=1) if i != n]
    named = {x.file: replace(x, file="") for x in report.seen if isinstance(x, KINDS[1])}
    assert named == {f"m{i}.csv": ManeuverNamedOtherwise(i, i, (n,)) for i, n in wrong}
    others = [(x.maneuver, x.nearest) for x in report.seen if isinstance(x, OtherManeuver)]
    assert others == wrong
    for m in report.maneuvers:
        assert (m.worst.scd > 15) == ((m.maneuver, held[m.maneuver - 1]) not in wrong)


def test_one_file_may_state_its_maneuver_in_its_rows(reference):
    files = [file(reference, "one.csv", 1, told=1), file(reference, "m2.csv", 1)]
    assert [*score(files, reference)] == [1, 2]


def test_exchanged_files_are_compared_by_their_values(reference):
    report = score([file(reference, f"m{i}.csv", n) for i, n in ((1, 3), (2, 2), (3, 1))])
    assert report.is_right
    assert [(x.file, x.named) for x in report.seen if isinstance(x, ManeuverNamedOtherwise)] == [
        ("m1.csv", 1), ("m3.csv", 3),
    ]  # fmt: skip


@pytest.mark.parametrize(
    "names", [("a.csv", "b.csv"), ("m2.csv", "b.csv"), ("a/m3.csv", "b/m3.csv")]
)
def test_without_a_name_for_each_file_two_of_one_maneuver_are_refused(reference, names):
    files = [file(reference, name, 3) for name in names]
    with pytest.raises(InputError, match="found maneuver 3 twice"):
        score(files, reference)
    assert isinstance(score_files(files, reference), Series)


@pytest.mark.parametrize(
    "options", [{}, {"names": ["A", "B"]}, {"steps": [0.1, 0.01]}, {"is_one_program": True}]
)
def test_programs_and_runs_with_such_names_are_compared_side_by_side(reference, options):
    """They may be the first and the second method of a user."""
    files = [file(reference, name, 3) for name in ("m2.csv", "m3.csv")]
    assert [[*run] for run in score_files(files, reference, **options)] == [[3], [3]]


@pytest.mark.parametrize("command", ["score", "diagnose"])
def test_both_commands_show_the_contradiction(reference, tmp_path, capsys, command):
    def said(*words):
        assert main([command, *words]) == 0
        return " ".join(capsys.readouterr().out.split())

    (alone,) = write(reference, tmp_path, {"m1.dat": 2})
    assert (
        "The name of the file states maneuver 1, but the rows are those of maneuver 2. They are "
        "compared with maneuver 2. If the name is right, use --maneuver 1"
    ) in said(alone)
    assert "states maneuver" not in said(alone, "--maneuver", "2")
    *_, two, three = run = write(reference, tmp_path, {"m1.dat": 1, "m2.dat": 3, "m3.dat": 3})
    shown = said(*run)
    if command == "diagnose":
        assert f"{two}: The name of the file states maneuver 2" in shown
        assert "They are compared with maneuver 2, because two files have rows of the same" in shown
        assert f"{three}: The name" not in shown
    write(reference, tmp_path, {"m2.dat": 1, "m1.dat": 2})
    assert "If the name is right, use --maneuver with a number for each file" in said(*run)
