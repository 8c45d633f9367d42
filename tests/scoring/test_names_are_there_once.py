"""A name that occurs twice is refused: neither column has precedence.

If a JSON object had a wrong column and then a correct one of the same name, the last one was used,
and the file was called correct.
"""

import json
import zipfile
from io import BytesIO

import numpy as np
import pytest

from heyoka_bike import score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.request import Request

NAMES = ["time", *BENCHMARK_COLUMNS]


def columns(reference):
    m = reference[2]
    right = [m.time, *(m[k] for k in BENCHMARK_COLUMNS)]
    return [
        ("time", right[0]),
        ("roll_angle", 2 * right[1]),
        *zip(NAMES[1:], right[1:], strict=True),
    ]


def as_json(found):
    members = (f"{json.dumps(name)}: {json.dumps(x.tolist())}" for name, x in found)
    return f"{{{', '.join(members)}}}".encode()


def as_json_in_maneuver(found):
    return b'{"maneuver_2": ' + as_json(found) + b"}"


def as_records(found):
    rows = zip(*(x.tolist() for _, x in found), strict=True)
    objects = (
        "{" + ", ".join(f'"{n}": {x}' for (n, _), x in zip(found, row, strict=True)) + "}"
        for row in rows
    )
    return f"[{', '.join(objects)}]".encode()


def as_lines(found):
    return as_records(found)[1:-1].replace(b"}, {", b"}\n{")


def as_npz(found):
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, x in found:
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, x)
    return buffer.getvalue()


def as_csv(found):
    lines = [",".join(n for n, _ in found)]
    lines += [",".join(map(repr, row)) for row in zip(*(x.tolist() for _, x in found), strict=True)]
    return "\n".join(lines).encode()


def once(found):
    return [found[0], *found[2:]]


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize(
    "write", [as_json, as_json_in_maneuver, as_records, as_lines, as_npz, as_csv]
)
def test_a_name_twice_is_refused_by_its_name(write, tmp_path, reference):
    path = tmp_path / "r"
    path.write_bytes(write(columns(reference)))
    with pytest.raises(InputError, match=r"found 'roll_angle' (twice|and 'roll_angle')"):
        score(path, reference, maneuver=2)
    path.write_bytes(write(once(columns(reference))))
    assert score(path, reference, maneuver=2).is_right


class Table:
    """A table with the methods of pyarrow's."""

    def __init__(self, found):
        self.column_names = [name for name, _ in found]
        self._columns = [x for _, x in found]

    def itercolumns(self):
        return iter(self)

    def __iter__(self):
        for x in self._columns:
            yield type("Column", (), {"to_numpy": lambda self, x=x: x})()


def test_columns_of_arrow_are_there_once(reference):
    from heyoka_bike.scoring.reading.formats import libraries

    file = type("File", (), {"request": Request("r.parquet", 3)})()
    with pytest.raises(InputError, match=r"r\.parquet: found 'roll_angle' twice"):
        libraries._columns(Table(columns(reference)), file)
    assert list(libraries._columns(Table(once(columns(reference))), file)) == NAMES
