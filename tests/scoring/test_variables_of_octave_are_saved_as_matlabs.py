"""Files of Octave's ``save -text``: a single matrix is read as rows; several variables are
refused."""

import numpy as np
import pytest

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results

FIRST = "# Created by Octave 7.3.0, Mon Nov 23 03:29:03 2026 UTC <root@vm>\n"
END = "\n\n\n"


def matrix(name, values):
    """A matrix as Octave writes it; a vector becomes a column."""
    table = np.atleast_2d(np.asarray(values).T).T
    rows = "".join(f" {' '.join(f'{x:.17g}' for x in row)}\n" for row in table)
    shape = f"# rows: {table.shape[0]}\n# columns: {table.shape[1]}\n"
    return f"# name: {name}\n# type: matrix\n{shape}{rows}{END}"


def structure(name, *members):
    head = f"# name: {name}\n# type: scalar struct\n# ndims: 2\n 1 1\n# length: {len(members)}\n"
    return head + "".join(members) + END


TABLE = np.column_stack([np.arange(11.0), np.ones((11, 24))])
TIME, ROLL = matrix("t", range(9)), matrix("roll", range(9))
RANGE = "# name: t\n# type: double_range\n# base, limit, increment\n0 10 0.01\n" + END


def written(tmp_path, *parts):
    path = tmp_path / "results.txt"
    path.write_text(FIRST + "".join(parts))
    return path


def test_one_matrix_alone_is_rows_of_numbers(tmp_path):
    (first, *others) = read_results(written(tmp_path, matrix("x", TABLE))).maneuvers
    assert [first.maneuver, *(rows.maneuver for rows in others)] == [1, 2, 3]
    assert np.array_equal(first.time, TABLE[:, 0])


@pytest.mark.parametrize(
    "parts",
    [(TIME, ROLL), (structure("r", TIME, ROLL),), (RANGE, ROLL), (TIME,), (RANGE,),
     (matrix("x", TABLE), ROLL)],
)  # fmt: skip
def test_variables_are_refused_with_what_to_do(parts, tmp_path):
    with pytest.raises(InputError, match=r"variables of Octave's save -text.*save -v7") as caught:
        read_results(written(tmp_path, *parts))
    assert "\n" not in str(caught.value)
