"""MATLAB files are read as written, and no file is unpacked to more than the limit."""

import io
import struct
import zlib
from collections.abc import Mapping

import numpy as np
import pytest
import scipy.io

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.formats import matlab
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.source import read_results
from support.without_packages import python

MOST = 10**7
RECORDS = np.array([(1, 2.5), (3, 4.5)], dtype=[("p", int), ("q", float)])
# For each kind: the values as they are written, and as they are read.
KINDS = {
    "matrix": (np.arange(12.0).reshape(3, 4) / 7,) * 2,
    "long": (np.arange(30000.0), np.arange(30000.0)[None]),
    "cube": (np.arange(24.0).reshape(2, 3, 4),) * 2,
    "complex": (np.array([[1 + 2j, 3 - 4j]]),) * 2,
    "integers": (np.arange(5, dtype="u2"), np.arange(5.0)[None]),
    "single": (np.float32(0.1), np.float32([[0.1]])),
    "truth": (np.array([True, False]), np.array([[1.0, 0.0]])),
    "empty": (np.zeros((0, 5)),) * 2,
    "text": ("hello", np.array(["hello"])),
    "lines": (np.array(["abc", "def"]),) * 2,
    "accents": ("lean φ, ü", np.array(["lean φ, ü"])),
    "structure": (
        {"x": np.arange(3), "y": "abc", "inner": {"m": np.eye(2)}},
        {"x": np.array([[0, 1, 2]]), "y": np.array(["abc"]), "inner": {"m": np.eye(2)}},
    ),
    "structures": (RECORDS, [{"p": np.array([[p]]), "q": np.array([[q]])} for p, q in RECORDS]),
    "cells": (
        np.array([1.5, "b", np.eye(2)], dtype=object),
        [np.array([[1.5]]), np.array(["b"]), np.eye(2)],
    ),
}
IN_VERSION_4 = ("matrix", "complex", "integers", "text", "lines")


def matlab_variables(data, most=MOST):
    return matlab.matlab_variables(data, Request("r.mat", 3, most_bytes=most))


def written(version="5", packed=False, **values):
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, values, format=version, do_compression=packed)
    return buffer.getvalue()


def assert_same(found, expected, where=""):
    if isinstance(expected, Mapping):
        assert found.keys() == expected.keys(), where
        for name, x in expected.items():
            assert_same(found[name], x, f"{where}.{name}")
    elif isinstance(expected, list):
        found = found.ravel(order="F") if isinstance(found, np.ndarray) else found
        assert len(found) == len(expected), where
        for i, x in enumerate(expected):
            assert_same(found[i], x, f"{where}[{i}]")
    else:
        assert found.shape == expected.shape, where
        assert np.array_equal(found, expected), where


@pytest.mark.parametrize(("version", "packed"), [("5", False), ("5", True), ("4", False)])
def test_every_kind_is_read(version, packed):
    kinds = {n: x for n, x in KINDS.items() if version == "5" or n in IN_VERSION_4}
    data = written(version, packed, **{name: x for name, (x, _) in kinds.items()})
    assert_same(matlab_variables(data), {name: x for name, (_, x) in kinds.items()})


def element(order, kind, data):
    return struct.pack(f"{order}II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def matrix(order, name, flags, shape, *parts):
    body = [
        element(order, 6, struct.pack(f"{order}II", flags, 0)),
        element(order, 5, struct.pack(f"{order}{len(shape)}i", *shape)),
        element(order, 1, name),
        *parts,
    ]
    return element(order, 14, b"".join(body))


def file_of(*elements, order="<"):
    end = b"\x00\x01IM" if order == "<" else b"\x01\x00MI"
    return b"MATLAB".ljust(124) + end + b"".join(elements)


def test_files_of_the_other_byte_order():
    numbers = element(">", 9, struct.pack(">6d", *range(6)))
    small = struct.pack(">HH4s", 3, 1, b"\1\2\3\0")
    data = file_of(
        matrix(">", b"x", 6, (2, 3), numbers), matrix(">", b"y", 6, (1, 3), small), order=">"
    )
    found = matlab_variables(data)
    assert np.array_equal(found["x"], np.arange(6.0).reshape(3, 2).T)
    assert np.array_equal(found["y"], [[1.0, 2.0, 3.0]])
    old = struct.pack(">5i2s2d", 1000, 1, 2, 0, 2, b"a\0", 1.5, 2.5)
    assert np.array_equal(matlab_variables(old)["a"], [[1.5, 2.5]])


@pytest.mark.parametrize("version", [4, 5])
def test_a_variable_twice_is_damage_in_each_version(version):
    """Neither of the two variables has precedence."""
    if version == 4:
        both = [struct.pack("<5i2sd", 0, 1, 1, 0, 2, b"a\0", x) for x in (1.5, 2.5)]
        once, twice = both[0], b"".join(both)
    else:
        both = [matrix("<", b"a", 6, (1, 1), element("<", 9, struct.pack("<d", x)))
                for x in (1.5, 2.5)]  # fmt: skip
        once, twice = file_of(both[0]), file_of(*both)
    assert matlab_variables(once)["a"] == 1.5
    with pytest.raises(ValueError, match="two variables a"):
        matlab_variables(twice)


NINE = element("<", 9, struct.pack("<9d", *range(9)))


def nested(depth):
    """Cell arrays nested `depth` levels deep."""
    inside = matrix("<", b"", 6, (1, 1), element("<", 9, bytes(8)))
    for _ in range(depth):
        inside = matrix("<", b"c", 1, (1, 1), inside)
    return inside


DAMAGED = {
    "a size that lies": file_of(element("<", 14, b"x" * 64)[:-8]),
    "fewer numbers than the shape says": file_of(matrix("<", b"x", 6, (10, 25), NINE)),
    "more numbers than the shape says": file_of(matrix("<", b"x", 6, (1, 8), NINE)),
    "a negative shape": file_of(matrix("<", b"x", 6, (-1, -9), NINE)),
    "no numbers": file_of(matrix("<", b"x", 6, (1, 9))),
    "cells that are not there": file_of(matrix("<", b"x", 1, (2**31 - 1, 2**31 - 1))),
    "fields that are not there": file_of(
        matrix("<", b"x", 2, (2**31 - 1, 2**31 - 1),
               element("<", 5, b"\2\0\0\0"), element("<", 1, b"a\0"))
    ),
    "fields of no length": file_of(
        matrix("<", b"x", 2, (1, 1), element("<", 5, b"\0\0\0\0"), element("<", 1, b"a\0"))
    ),
    "more lines than characters": file_of(
        matrix("<", b"x", 4, (2**31 - 1, 1), element("<", 4, b"a\0"))
    ),
    "an unknown type": file_of(matrix("<", b"x", 6, (1, 9), element("<", 99, bytes(72)))),
    "an array for a number": file_of(matrix("<", b"x", 6, (1, 1), nested(0))),
    "no imaginary part": file_of(
        matrix("<", b"c", 1, (1, 2), matrix("<", b"", 0x806, (1, 9), NINE), nested(0))
    ),
    "no dimensions": file_of(matrix("<", b"x", 4, (), element("<", 4, b"a\0"))),
    "arrays nested too deeply": file_of(nested(2000)),
    "arrays in too many others": file_of(*[struct.pack("<II", 14, 10**6)] * 9999),
    "bytes that do not unpack": file_of(element("<", 15, b"x\x9c" * 9)),
    "packed bytes that go on": file_of(
        element("<", 15, zlib.compress(struct.pack("<II", 14, 8) + bytes(9999)))
    ),
    "packed bytes that end": file_of(
        element("<", 15, zlib.compress(struct.pack("<II", 14, 9999) + bytes(8)))
    ),
    "an old matrix that is not there": struct.pack("<5i", 0, 2**31 - 1, 2**31 - 1, 0, 2),
}  # fmt: skip


@pytest.mark.parametrize("what", DAMAGED)
def test_damage_is_one_line(what, tmp_path):
    path = tmp_path / "r.mat"
    path.write_bytes(DAMAGED[what])
    with pytest.raises(InputError, match=r"found a damaged file .*, expected a MATLAB file"):
        read_results(path, max_bytes=MOST)


def zeros(kind, count):
    numbers = matrix("<", b"x", kind, (1, count), element("<", 2, bytes(count)))
    return element("<", 15, zlib.compress(numbers, 9))


@pytest.mark.parametrize(
    "bomb",
    [
        zeros(9, MOST),  # one array above the limit
        zeros(9, MOST // 4) * 4,  # four arrays, above the limit together
        zeros(6, MOST // 4),  # bytes, which become double precision
        zeros(4, MOST // 4),  # characters
        # an array with many empty cells
        element("<", 15, zlib.compress(
            matrix("<", b"x", 1, (1, MOST // 16), struct.pack("<II", 14, 0) * (MOST // 16)), 9)
        ),
    ],
    ids=["one", "four", "numbers", "text", "cells"],
)  # fmt: skip
def test_a_small_file_that_unpacks_to_a_large_one(bomb):
    data = file_of(bomb)
    assert len(data) < MOST / 90
    with pytest.raises(
        InputError, match=r"more than 10000000 bytes after unpacking.* --max-bytes N allows"
    ):
        matlab_variables(data)


def object_of(name, kind):
    """An object of a class as MATLAB saves it: a reference to its content, which is stored
    elsewhere."""
    where = matrix("<", b"", 13, (6, 1), element("<", 6, struct.pack("<6I", 0xDD000000, *[1] * 5)))
    parts = [element("<", 6, struct.pack("<II", 17, 0))]
    parts += [element("<", 1, word) for word in (name, b"MCOS", kind)]
    return element("<", 14, b"".join([*parts, where]))


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (b"table", r"writetable\(r, 'results.csv'\)"),
        (b"timetable", r"writetimetable\(r, 'results.csv'\)"),
        (b"timeseries", r"results = \[r.Time r.Data\]; save results.mat results"),
        (b"Simulink.SimulationOutput", "save results.mat with its times and values as arrays"),
    ],
)
def test_an_object_is_named_with_what_writes_it(kind, said, tmp_path):
    path = tmp_path / "r.mat"
    path.write_bytes(file_of(object_of(b"r", kind), matrix("<", b"x", 6, (3, 3), NINE)))
    with pytest.raises(InputError, match=f"found 'r', a {kind.decode()}, which MATLAB .*: {said}$"):
        read_results(path)


def test_an_object_beside_columns_is_left_out(tmp_path):
    path = tmp_path / "r.mat"
    columns = [matrix("<", name, 6, (1, 9), NINE) for name in (b"t", b"roll")]
    path.write_bytes(file_of(object_of(b"r", b"table"), *columns))
    assert [*read_results(path).maneuvers[0].values] == ["roll_angle"]


def test_what_is_left_out():
    """A file with a sparse matrix, a MATLAB function and an ordinary matrix."""
    parts = [
        element("<", 6, struct.pack("<II", 5, 1)),
        element("<", 5, struct.pack("<2i", 2, 1)),
        element("<", 1, b"s"),
        element("<", 5, struct.pack("<2i", 0, 1)),
        element("<", 5, struct.pack("<2i", 0, 1)),
        element("<", 9, struct.pack("<d", 7.0)),
    ]
    sparse = element("<", 14, b"".join(parts))
    function = matrix("<", b"f", 16, (1, 1), matrix("<", b"", 6, (3, 3), NINE))
    odd = [sparse, function]
    found = matlab_variables(file_of(*odd, matrix("<", b"x", 6, (1, 9), NINE)))
    assert list(found) == ["x"]


def test_without_scipy_its_installation_is_named(tmp_path):
    rows = np.column_stack([np.arange(5.0), np.ones((5, 8))])
    (tmp_path / "r.mat").write_bytes(written(packed=True, results=rows))
    code = f"""
from heyoka_bike import MissingPackageError, read_results
try:
    read_results({str(tmp_path / "r.mat")!r}, maneuver=2)
except MissingPackageError as e:
    print(e)
"""
    run = python(code, {"scipy"})
    said = "scipy, which reads .mat (or save it as text), is not installed: pip install scipy\n"
    assert run.stdout.endswith(said), run.stderr
