"""A model is checked in single states: the first wrong level is named in every format."""

import csv
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import heyoka_bike as hb
from heyoka_bike.bicycle.instant_columns import COORDINATES, LEVELS, UNITS
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof.instants import as_csv, known_states
from heyoka_bike.scoring.instants.check import quantities_of_states
from heyoka_bike.showing.formats import check as shown

SCHEMA = Path(shown.__file__).with_name("check-1.schema.json")
SOME = 60  # number of a state in which the bicycle leans, is steered and moves


@pytest.fixture(scope="module")
def exact(bicycle):
    """Name and values of every column, for four of the known states."""
    states = known_states()
    chosen = [states[n - 1] for n in (1, 6, SOME, 90)]
    rows = list(csv.reader(as_csv(bicycle, chosen).decode().splitlines()))
    table = dict(zip(rows[0], np.array(rows[1:], float).T, strict=True))
    return table | {"state": np.array([1.0, 6.0, SOME, 90.0])}


def written(path, table):
    rows = zip(*(map(repr, map(float, x)) for x in table.values()), strict=True)
    path.write_text("\n".join(",".join(row) for row in (table, *rows)) + "\n", encoding="utf-8")
    return str(path)


def test_what_is_written_is_right(tmp_path, exact, capsys):
    assert main(["check", written(tmp_path / "a.csv", exact)]) == 0
    assert "All levels are right." in capsys.readouterr().out
    found = hb.check(exact)
    assert [x.passed for x in found.levels] == [True] * len(LEVELS)
    assert {c.key for x in found.levels for c in x.columns} == {
        c.name for x in LEVELS for c in x.columns
    }


def test_the_known_states_are_written_for_any_bicycle(tmp_path, monkeypatch, capsys):
    few = known_states()[4:7]
    for module in ("heyoka_bike.reference.proof.instants", "heyoka_bike.scoring.instants.check"):
        monkeypatch.setattr(f"{module}.known_states", lambda: few)
    path = tmp_path / "new" / "states.csv"
    assert main(["check", "--states", str(path), "--bicycle", "pista"]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    assert main(["check", str(path), "--bicycle", "pista"]) == 0
    # The file contains a bicycle that differs from the benchmark.
    assert main(["check", str(path)]) == 3


@pytest.mark.proof
@pytest.mark.parametrize("level", LEVELS, ids=lambda x: x.name)
def test_the_first_level_that_is_wrong_is_named(tmp_path, exact, capsys, level):
    # In this table, the columns of one level (a group of quantities) and of all later levels are
    # wrong.
    wrong = {c.name for x in LEVELS[LEVELS.index(level) :] for c in x.columns[:2]}
    table = {n: x + (n.split(" ")[0] in wrong) for n, x in exact.items()}
    assert main(["check", written(tmp_path / "a.csv", table), "--format", "json"]) == 3
    said = capsys.readouterr()
    document = json.loads(said.out)
    assert document["failed"] == level.name
    assert said.err.count("\n") == 1
    assert (
        f"a.csv: {level.name}: {document['levels'][LEVELS.index(level)]['columns'][0]['key']}"
        in said.err
    )
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.validate(document, schema)


@pytest.mark.proof
def test_a_parameter_that_explains_the_table_is_found(bicycle, exact):
    states = {name: exact[f"{name} [{UNITS[name]}]"] for name in COORDINATES}
    mistaken = bicycle.replace(IBxz=Exact(-bicycle["IBxz"].rational))
    values = quantities_of_states(mistaken, states)
    table = {f"{n} [{UNITS[n]}]": values[n] for n in ("kinetic_energy", "roll_acceleration")}
    found = hb.check({"state": exact["state"], **table})
    assert found.failed.level.name == "energy"
    (one,) = [x for x in found.explained if x.symbol == "IBxz"]
    assert one.value == pytest.approx(-2.4, rel=1e-6)
    assert one.right == 2.4


def test_a_check_shows_itself_as_the_command_does(tmp_path, exact, capsys):
    path = written(tmp_path / "a.csv", {**exact, "mass [kg]": exact["mass [kg]"] + 1})
    assert main(["check", path]) == 3
    found = hb.check(path)
    assert repr(found) == capsys.readouterr().out.strip("\n")
    assert "The first wrong level is positions" in found._repr_html_()


def test_columns_without_names_are_refused():
    with pytest.raises(InputError, match="found 9 columns, expected columns by name"):
        hb.check(np.zeros((3, 9)))
    with pytest.raises(InputError, match="found 1 values of 'state' and 2 of 'mass"):
        hb.check({"state": [1], "mass [kg]": [94, 94]})


def test_one_wrong_value_is_not_explained():
    # Any parameter that affects the mass would explain the wrong value, so none is named. Several
    # rows with the same constant count as one value.
    for n in (1, 3):
        found = hb.check({"state": np.arange(1, n + 1), "mass [kg]": [90.0] * n})
        assert found.failed.level.name == "positions"
        assert found.explained == ()


def test_columns_that_are_not_known_are_named_with_what_they_are_like(tmp_path, capsys):
    path = tmp_path / "a.csv"
    path.write_text("state,mass [kg],M_rollroll [kg m2],qwerty\n1,94,80,0\n", encoding="utf-8")
    assert main(["check", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "1 state known by number" in said
    assert "Unknown columns: 'M_rollroll [kg m2]' (M_roll_roll?), 'qwerty'." in said


def test_states_of_ones_own_are_checked_in_any_unit(tmp_path, bicycle):
    own = dict(
        zip(COORDINATES, np.array([[0.3, -0.2, 0.5, 1.5, 4.6], [0, 0, 0, 0, 3]]).T, strict=True)
    )
    right = quantities_of_states(bicycle, own)
    table = {
        "Roll Angle (deg)": np.degrees(own["roll_angle"]), "steer_angle_rad": own["steer_angle"],
        "roll_rate [deg/s]": np.degrees(own["roll_rate"]), "steer_rate [1/s]": own["steer_rate"],
        "forward_speed [km/h]": own["forward_speed"] * 3.6, "com_z [mm]": right["com_z"] * 1000,
        "mass_roll_roll [kg mm^2]": right["mass_roll_roll"] * 1e6, "mine": own["roll_rate"],
    }  # fmt: skip
    found = hb.check(written(tmp_path / "own.csv", table))
    assert found.passed
    assert found.is_own
    assert found.left_out == ("mine",)
    assert sum(len(x.columns) for x in found.levels) == 2
    table["com_z [mm]"] = table["com_z [mm]"] + 0.001
    failed = hb.check(table).failed
    assert (failed.level.name, failed.columns[0].wrong) == ("positions", 2)


def as_json(path, table):
    names = list(table)
    rows = zip(*(x.tolist() for x in table.values()), strict=True)
    path.write_text(json.dumps([dict(zip(names, row, strict=True)) for row in rows]), "utf-8")


def as_npz(path, table):
    np.savez(path, **table)


def as_hdf5(path, table):
    import h5py

    with h5py.File(path, "w") as file:
        for name, x in table.items():
            file[name] = x


def as_matlab(path, table):
    savemat = pytest.importorskip("scipy.io").savemat
    # MATLAB's names have no spaces and no brackets.
    names = (name.rstrip("]").replace(" [", "_").replace(" ", "_") for name in table)
    savemat(path, dict(zip(names, table.values(), strict=True)))


def as_sheet(path, table):
    pytest.importorskip("openpyxl")
    pytest.importorskip("pandas").DataFrame(table).to_excel(path, index=False)


@pytest.mark.parametrize(
    ("suffix", "write"),
    [("json", as_json), ("npz", as_npz), ("h5", as_hdf5), ("mat", as_matlab), ("xlsx", as_sheet)],
)
def test_every_format_of_results_is_read(tmp_path, exact, suffix, write):
    names = ("state", "pitch [rad]", "com_z [m]", "mass_roll_roll [kg m2]", "M_roll_steer [kg m2]")
    table = {
        name.replace("kg m2", "kg_m2") if suffix == "mat" else name: exact[name] for name in names
    }
    path = tmp_path / f"a.{suffix}"
    write(path, table)
    found = hb.check(path)
    assert found.passed
    assert sum(len(x.columns) for x in found.levels) == 4
    assert found.left_out == ()


def test_few_digits_are_no_mistake(tmp_path, exact):
    path = tmp_path / "short.txt"
    path.write_text(f"state pitch_rad\n{SOME} {exact['pitch [rad]'][2]:.4f}\n", encoding="utf-8")
    assert hb.check(path).passed
    path.write_text(
        f"state pitch_rad\n{SOME} {exact['pitch [rad]'][2] + 2e-4:.4f}\n", encoding="utf-8"
    )
    assert not hb.check(path).passed


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("state,pitch [rad]\n1,0\n111,0\n", 1, "a.csv:3: found state 111, expected 1 to 110"),
        ("state,pitch [rad]\n1.5,0\n", 1, "a.csv:2: found state 1.5, expected 1 to 110"),
        ("state,pitch\n1,0\n", 1, "found the column 'pitch' without a unit, expected one such as"),
        ("state,pitch [kg]\n1,0\n", 1, "found the unit 'kg' of pitch, expected one such as rad"),
        ("pitch [rad],yaw_rate [rad/s]\n0,0\n", 1, "found no column 'state' and no roll_angle"),
        ("states,pitch [rad]\n1,0\n", 1, "did you mean state?"),
        ("1 2\n3 4\n", 1, "found no line of column names that are known"),
        ("state,com_z [m]\n", 1, "expected"),
        ("state,mine\n1,0\n", 2, "found only states, without a quantity"),
        ("state,pitch [rad],pitch [deg]\n1,0,0\n", 1, "found a second column of pitch"),
        ("state,roll_angle [rad],com_z [m]\n18,0.2,0\n", 1,
         "a.csv:2: found roll_angle 0.2 rad in state 18, expected 0.1 (the difference is 0.1)"),
        ("roll_angle [1],steer_angle [1],roll_rate [1/s],steer_rate [1/s],forward_speed [m/s],"
         "com_z [m]\n0,0,0,0,1,-0.8\n1.4,1.5,0,0,1,0\n", 1, "a.csv:3: found a state off the floor"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_used_is_refused_in_one_line(tmp_path, capsys, text, code, said):
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    assert main(["check", str(path)]) == code
    found = capsys.readouterr()
    assert found.out == ""
    assert found.err.count("\n") == 1
    assert said in found.err


def test_one_of_file_and_states_is_asked_for(tmp_path, capsys):
    assert main(["check"]) == 1
    assert main(["check", "a.csv", "--states", "b.csv"]) == 1
    assert main(["check", "a.csv", "--tolerance", "2"]) == 1
    assert capsys.readouterr().err.count("\n") == 3
