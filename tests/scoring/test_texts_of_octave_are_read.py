"""What Octave writes with ``save -text``: variables, structures and ranges, beside texts."""

import numpy as np
import pytest

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading import read_results
from heyoka_bike.scoring.score import score

FIRST = "# Created by Octave 7.3.0, Mon Nov 23 03:29:03 2026 UTC <root@vm>\n"
END = "\n\n\n"


def matrix(name, values):
    """As Octave writes a matrix; a vector is a column."""
    table = np.atleast_2d(np.asarray(values).T).T
    rows = "".join(f" {' '.join(f'{x:.17g}' for x in row)}\n" for row in table)
    shape = f"# rows: {table.shape[0]}\n# columns: {table.shape[1]}\n"
    return f"# name: {name}\n# type: matrix\n{shape}{rows}{END}"


def structure(name, *members):
    head = f"# name: {name}\n# type: scalar struct\n# ndims: 2\n 1 1\n# length: {len(members)}\n"
    return head + "".join(members) + END


TEXT = "# name: note\n# type: sq_string\n# elements: 1\n# length: 8\nmaneuver\n" + END
CELL = (
    "# name: c\n# type: cell\n# rows: 1\n# columns: 2\n"
    f"# name: <cell-element>\n# type: scalar\n1{END}"
    f"# name: <cell-element>\n# type: bool\n1{END}{END}"
)
COMPLEX = f"# name: z\n# type: complex matrix\n# rows: 1\n# columns: 2\n (1,2) (3,0)\n{END}"
EMPTY = f"# name: e\n# type: matrix\n# rows: 0\n# columns: 0\n{END}"
CUBE = f"# name: i\n# type: int32 matrix\n# ndims: 2\n 1 3\n 1\n 2\n 3\n{END}"
OTHERS = TEXT + CELL + COMPLEX + EMPTY + CUBE
RANGE = "# name: t\n# type: double_range\n# base, limit, increment\n0 10 0.01\n" + END


def written(tmp_path, *parts):
    path = tmp_path / "results.txt"
    path.write_text(FIRST + "".join(parts))
    return path


def forms(time, roll, steer):
    columns = matrix("roll", roll), matrix("steer", steer)
    return {
        "variables": (matrix("t", time), *columns),
        "beside others": (OTHERS, *columns, matrix("t", time), OTHERS),
        "structure": (structure("r", TEXT, matrix("t", time), *columns),),
        "structure in a structure": (CELL, structure("out", structure("r", RANGE, *columns)), TEXT),
        "range": (RANGE, *columns),
    }


@pytest.mark.parametrize("form", forms([0], [0], [0]))
def test_what_it_holds_is_scored(form, reference, tmp_path):
    m = reference[2]
    parts = forms(m.time, m.rows["roll_angle"], m.rows["steer_angle"])[form]
    report = score(written(tmp_path, *parts), reference)
    (scored,) = report.maneuvers
    assert [c.key for c in scored.columns] == ["roll_angle", "steer_angle"]
    assert scored.rows == len(m.time)
    # Seventeen digits are written.
    assert all(c.as_understood.measures.scd > 15 for c in scored.columns)


def test_the_times_of_a_range_are_decimals(reference, tmp_path):
    (rows,) = read_results(written(tmp_path, RANGE, matrix("roll", np.zeros(1001)))).maneuvers
    assert rows.time[29] == 0.29
    # 0.01 is no number of binary64.
    assert rows.time_lo[29] != 0


def test_one_matrix_alone_is_rows_of_numbers(tmp_path):
    table = np.column_stack([np.arange(11.0), np.ones((11, 24))])
    path = written(tmp_path, matrix("x", table))
    assert [rows.maneuver for rows in read_results(path).maneuvers] == [1, 2, 3]
    beside = written(tmp_path, matrix("x", table), TEXT)
    assert [rows.maneuver for rows in read_results(beside).maneuvers] == [1, 2, 3]


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ((matrix("t", range(9))[:60],), "found the end, expected the variables of Octave"),
        ((matrix("t", range(9)).replace(" 3\n", " 3 4\n"),), "found a damaged variable"),
        ((matrix("t", range(9)), RANGE.replace("0 10 0.01", "0 1e30 1e-9")), "damaged variable"),
        ((matrix("t", range(9)).replace("rows: 9", "rows: x"),), "results.txt:4: found a damaged"),
        ((matrix("t", range(9)), matrix("roll", range(8))),
         "found 9 values of 't' and 8 of 'roll'"),
        ((matrix("t", range(9)), matrix("roll", range(9)).replace(" 3\n", " NA\n")),
         "found 'NA'"),
        ((structure("r", RANGE).replace("# length: 1", "# length: 2"),), "found the end"),
        ((TEXT, "# name: s\n# type: scalar struct\n" * 40), "found"),
    ],
)  # fmt: skip
def test_damage_is_one_clear_line(parts, said, tmp_path):
    with pytest.raises(InputError, match=said) as caught:
        read_results(written(tmp_path, *parts))
    assert "\n" not in str(caught.value)
