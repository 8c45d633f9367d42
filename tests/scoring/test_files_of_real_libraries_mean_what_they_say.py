"""A file of a real library is judged like the plain text with the same content, or refused by name.

`games/library_game.py` draws motions, names, paths, units, times and layouts, and real libraries
write them. For each of its writers it saved one file in `drawn`, and the plain text with the same
content.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from games.library_game import FINE, play
from games.library_writers import WRITERS
from heyoka_bike import read_results, score
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.as_read import NotCompared
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.reading.not_read import NOT_READ, PRINT_ALL

HERE = Path(__file__).parent / "drawn"
FILES = sorted(p.name for p in HERE.iterdir() if p.suffix != ".plain")
OF_ARROW = (".parquet", ".feather", ".arrow")
_ARITHMETIC = 1e-12


def columns(report):
    return {(m.maneuver, c.key): c for m in report.maneuvers for c in m.columns}


@pytest.mark.parametrize("name", FILES)
def test_a_kept_file_is_judged_as_its_plain_text(name, reference):
    if name.endswith(OF_ARROW):
        pytest.importorskip("pyarrow")
    plain = HERE / f"{name.partition('.')[0]}.plain"
    found, expected = (score(path, reference, "scd >= 6") for path in (HERE / name, plain))
    assert found.is_right == expected.is_right
    assert found.passed == expected.passed
    mine, meant = columns(found), columns(expected)
    assert mine.keys() == meant.keys()
    sizes = {
        key: np.nanmax(np.abs(values))
        for rows in read_results(plain).maneuvers for key, values in rows.values.items()
    }  # fmt: skip
    for at, c in meant.items():
        error = mine[at].max_abs_error
        size = max(sizes[at[1]], 1e-3)
        assert error == pytest.approx(c.max_abs_error, rel=1e-6, abs=_ARITHMETIC * size), at


def outcomes(count):
    for name in ("pandas", "scipy", "openpyxl", "xarray"):
        pytest.importorskip(name, reason=f"pip install {name} writes files for this")
    found = [x for number in range(count) if (x := play(11, number))]
    return [x for x in found if x.kind not in FINE]


@pytest.mark.proof
@pytest.mark.filterwarnings("ignore")
def test_files_drawn_at_random():
    assert outcomes(60) == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_thousand_files_drawn_at_random():
    if missing := sorted({x for of in WRITERS.values() for x in of.needs if of.missing}):
        print(f"pip install {' '.join(missing)} would write more of them")
    assert outcomes(1000) == []


@pytest.mark.parametrize(
    ("name", "content", "fragment"),
    [
        ("r.md", "| time | roll |\n|---:|---:|\n| 0 | 1 |\n", "a table of Markdown"),
        ("r.tex", "\\begin{tabular}{ll}\ntime & roll \\\\\n", "a table of LaTeX"),
        ("r.html", '<table border="1" class="dataframe">\n', "found HTML"),
        ("r.xml", "<?xml version='1.0'?>\n<data>", "found XML"),
        ("r.txt", "structure(list(time = c(0, 1)))", "R's dput"),
        ("r.csv", "time|roll|v\n0|1|4\n1|2|4\n", "fields separated by |"),
        ("r.csv", '"time"|"status"|"v"\n"0"|"ok"|"4"\n', "fields separated by |"),
        ("r.csv", "|time|roll\n||deg\n0|0.0|map\n1|0.1|map\n", "fields separated by |"),
        ("r.txt", "{'time': {0: 0.0, 1: 0.1}}", "a dictionary as Python prints it"),
    ],
)
def test_a_refusal_has_the_command_that_writes_it_readably(name, content, fragment, tmp_path):
    (tmp_path / name).write_text(content)
    instead = next(x.instead for x in NOT_READ if x.found in fragment or fragment in x.found
                   or fragment.endswith(x.found))  # fmt: skip
    with pytest.raises(InputError) as caught:
        read_results(tmp_path / name)
    assert fragment in str(caught.value)
    assert str(caught.value).endswith(instead)


def test_an_orc_file_is_named_whatever_its_first_column_is(tmp_path):
    """The byte after the mark, here a length of 97, was once read as the letter of a text file."""
    (tmp_path / "r.orc").write_bytes(b"ORCa\x0a\x06\x08\x97\x02\x80" + bytes(range(256)))
    with pytest.raises(InputError, match=r"found an ORC file, .*; in pandas: "):
        read_results(tmp_path / "r.orc")


_JOINTS = r"ROS's JointState messages, .*; in PlotJuggler: "


@pytest.mark.parametrize(
    ("begins", "found"),
    [
        (b"TDSm\x0e\0\0\0i\x12\0\0", r"a TDMS file of LabVIEW, .*; in Python: nptdms"),
        (b"TDSh\x0e\0\0\0i\x12\0\0", r"a TDMS file of LabVIEW, .*; in Python: nptdms"),
        (b"MDF     4.10    ", r"an MDF measurement file, .*; in Python: asammdf"),
        (b"UnFinMF 3.30    ", r"an MDF measurement file, .*; in Python: asammdf"),
        (b"#ROSBAG V2.0\nE\0\0\0", r"a ROS bag, .*; in PlotJuggler: "),
        (b"\x89MCAP0\r\n\x01\x1e", r"a ROS bag, .*; in PlotJuggler: "),
        (b"\x0e\x03\x13\x01\0\xc8", r"an HDF4 file, .*; h4toh5 "),
        (b"$FL2@(#) SPSS DATA FILE", r"a file of SPSS, .*; in pandas: "),
        (b"\0" * 12 + b"\xc2\xea\x81\x60\xb3\x14", r"a file of SAS, .*; in pandas: "),
        (b"HEADER RECORD*******LIBRARY HEADER", r"a file of SAS, .*; in pandas: "),
        (b"\x04\x22\x4d\x18\x64\x40\xa7", r"an lz4 file, .*; unlz4 "),
        (b"header: \n  seq: 1\n  stamp: \n    secs: 0\n", r"ROS messages, .*; in PlotJuggler: "),
        (b'{"header": {"stamp": 0}, "name": ["roll"], "position": [0.1]}\n', _JOINTS),
        (b'[{"position": [0.1, 2], "name": [ "roll", "steer" ]}]', _JOINTS),
        (b"%time,field.name0,field.name1,field.position0,field.position1\n0,a,b,1,2\n", _JOINTS),
        (b"time,name,position\n0,\"['roll', 'steer']\",\"[0.1, 0.2]\"\n", _JOINTS),
        (b"---\nheader:\n  stamp:\n    sec: 0\n", r"ROS messages, .*; in PlotJuggler: "),
    ],
)
def test_a_measurement_file_is_named_with_a_way_to_convert_it(begins, found, tmp_path):
    is_text = b"name" in begins
    (tmp_path / "r.dat").write_bytes(begins + (b"" if is_text else bytes(200)))
    with pytest.raises(InputError, match=f"found {found}"):
        read_results(tmp_path / "r.dat")


def test_columns_of_paths_in_json_by_the_index_of_their_rows(tmp_path):
    """pandas writes this layout by default."""
    columns = {"field.time [s]": [0, 1], "field.roll_angle": [0, 0.1], "field.steer_angle": [0, 2]}
    by_row = {name: dict(enumerate(values)) for name, values in columns.items()}
    (tmp_path / "r.json").write_text(json.dumps(by_row))
    (rows,) = read_results(tmp_path / "r.json").maneuvers
    assert {key: x.tolist() for key, x in rows.values.items()} == {
        "roll_angle": [0, 0.1], "steer_angle": [0, 2],
    }  # fmt: skip


def test_a_sheet_with_words_and_empty_cells_is_a_table(tmp_path):
    """Cells that are true, a row of units and empty rows once gave "a damaged file"."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (
        [None, None], ["time", "is_stable", "roll_angle", "step"], ["s", None, "rad", None], [],
        *([i / 10, i % 2 == 0, 0.01 * i, i] for i in range(5)),
    ):  # fmt: skip
        book.active.append(row)
    book.save(tmp_path / "r.xlsx")
    (rows,) = read_results(tmp_path / "r.xlsx").maneuvers
    assert rows.values["roll_angle"].tolist() == [0, 0.01, 0.02, 0.03, 0.04]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("  time roll ... v\n0 0.0 0.1 ... 4.0\n9 0.9 0.2 ... 4.0\n\n[99 rows]\n", ":2:4: found"),
        ("time roll\n0 1\n1 2\n... ...\n9 1\n", ":4:1: found '...'"),
        ("[[0. 1. 4.]\n [1. 2. 4.]\n ...\n [9. 1. 4.]]\n", ": found '...'"),
    ],
)
def test_a_table_that_is_shortened_for_printing_is_told_so(text, place, tmp_path):
    path = tmp_path / "r.txt"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_results(path)
    assert str(caught.value).startswith(f"{path}{place}")
    assert str(caught.value).endswith(PRINT_ALL)


def test_a_folder_of_zarr_is_named(tmp_path):
    (tmp_path / "zarr.json").write_text("{}")
    with pytest.raises(InputError, match=r"a folder of Zarr, .*; in xarray: data\.to_netcdf"):
        read_results(tmp_path)


def test_a_path_with_bars_is_no_separator(tmp_path):
    (tmp_path / "r.csv").write_text("time,bike|roll_angle,bike|roll_rate\n0,1,2\n1,2,3\n")
    assert sorted(read_results(tmp_path / "r.csv").maneuvers[0].values) == [
        "roll_angle",
        "roll_rate",
    ]


# Small examples of the faults that the game with real libraries has found.


@pytest.mark.parametrize(
    ("text", "values"),
    [
        # The time of a long table keeps the unit in its name.
        ("t_ms,variable,value\n0,roll_angle,1\n0,v,4\n500,roll_angle,2\n500,v,4\n", [1, 2]),
        # A heading with units above an index column is not one longer name.
        ("   time [ms]  roll_angle\n0  0  1\n1  500  2\n", [1, 2]),
        # A table with two levels of names, and with a column of words.
        (",bike,bike,\ntime,roll_angle,forward_speed,phase\n0,1,4,a\n0.5,2,4,b\n", [1, 2]),
        # The nanoseconds of a time stamp, whose path is separated by double colons.
        ("stamp::sec,stamp::nanosec,phi,word\n7,0,1,a\n7,500000000,2,a\n", [1, 2]),
        # A unit in the form in which R writes it.
        ("time..ms.,roll..rad.\n0,1\n500,2\n", [1, 2]),
    ],
)
def test_times_and_names_are_those_that_are_meant(text, values, tmp_path):
    (tmp_path / "r.csv").write_text(text)
    (rows,) = read_results(tmp_path / "r.csv").maneuvers
    assert rows.values["roll_angle"].tolist() == values
    assert np.diff(rows.time).tolist() == [0.5]


def test_a_maneuver_in_a_path_is_that_and_not_its_place(tmp_path):
    names = [f"field.man{n}.{k}" for k in ("roll_angle", "steer_rate") for n in (3, 1, 2)]
    (tmp_path / "r.csv").write_text(",".join(["time", *names]) + "\n0,3,1,2,3,1,2\n1,3,1,2,3,1,2\n")
    found = {r.maneuver: r.values for r in read_results(tmp_path / "r.csv").maneuvers}
    assert {n: v["steer_rate"][0] for n, v in found.items()} == {1: 1, 2: 2, 3: 3}


def test_columns_may_be_split_over_groups(reference):
    m = reference[2]
    state = {k: m[k] for k in ("roll_angle", "roll_rate", "forward_speed")}
    energy = {k: m[k] for k in ("potential_energy", "kinetic_energy")}
    given = {"time": m.time, "state": state, "energy": energy}
    report = score(given, reference, maneuver=2)
    assert {c.key for c in report[2].columns} == {*state, *energy}
    assert {*report.grades} == {Grade.RIGHT}
    # If an energy is the only one in its group, it may be that of a part. It is named as not
    # compared, and the file is not called correct.
    one = {"time": m.time, "state": state, "energy": {"potential_energy": m["potential_energy"]}}
    report = score(one, reference, maneuver=2)
    assert not report.is_right
    left_out = [x.name for e in report.seen if isinstance(e, NotCompared) for x in e.columns]
    assert {*left_out} == {"energy.potential_energy"}
    given["energy"] = {k: 1.1 * x for k, x in energy.items()}
    assert not score(given, reference, maneuver=2).is_right
