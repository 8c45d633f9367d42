"""A result file that cannot be used gives one line: where, what was found, and what was expected.

Each case changes one thing in a good file. Only `InputError` may be raised.
"""

import gzip
import io
import os
import pickle
import struct
import zipfile
import zlib
from contextlib import suppress

import h5py
import numpy as np
import pytest
import scipy.io

from heyoka_bike.errors import InputError, MissingPackageError
from heyoka_bike.scoring.reading import result_file
from heyoka_bike.scoring.reading.formats import listed
from heyoka_bike.scoring.reading.given import results_of
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.reading.text import rows as text_rows

ROW = [f"{i}.5" for i in range(25)]
NAMES = "time roll_angle roll_rate forward_speed"


def good(count=5, width=25, separator=" "):
    """Lines of a good file."""
    return [separator.join([str(i), *ROW[1:width]]) for i in range(count)]


def with_token(line, column, token, separator=" ", width=25):
    """A good file with one value replaced; line and column count from 1."""
    lines = good(width=width, separator=separator)
    fields = lines[line - 1].split(separator)
    fields[column - 1] = token
    lines[line - 1] = separator.join(fields)
    return "\n".join(lines) + "\n"


def with_line(line, text):
    """A good file with one line inserted."""
    lines = good()
    lines.insert(line - 1, text)
    return "\n".join(lines) + "\n"


def the_one_error(content, tmp_path, name="results.txt", **options):
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError) as caught:
        read_results(path, **options)
    error = caught.value
    assert error.file == str(path)
    assert str(error).isprintable()
    assert len(error.message) < 400
    return error


SHORT = " ".join(ROW[:24])
BOTH = "expected 9 or 25 columns, or columns named time"
NOTHING = f"found no column whose name is known, {BOTH}"

# Each case: the content, the line and column of the error, and a part of its message.
TEXTS = [
    # Texts without rows
    ("", None, None, "found an empty file, expected rows of numbers"),
    ("\n \t\r\n", None, None, "found an empty file, expected rows of numbers"),
    ("# nothing\n", None, None, f"found no row of numbers, {BOTH}"),
    ("Lorem ipsum dolor\nsit amet\n" * 500, None, None, f"found no row of numbers, {BOTH}"),
    ("<html><body>404</body></html>", None, None, "found HTML, expected text"),
    ("0 (1+0j) 1 2 3 4 5 6 7\n", 1, 2, f"found '(1+0j)' as value 2 and no row of numbers, {BOTH}"),
    ("0x1p-3 2 1 2 3 4 5 6 7\n", 1, 1, f"found '0x1p-3' as value 1 and no row of numbers, {BOTH}"),
    ("0;1,837.03\n1;1,9.0\n", 1, 2, f"found '1,837.03' as value 2 and no row of numbers, {BOTH}"),
    ("1\n2\n3\n", None, None, f"found no row of numbers, {BOTH}"),
    (" ".join(str(i) for i in range(1, 26)), None, None, f"found no row of numbers, {BOTH}"),
    # Texts with a wrong number of columns
    ("\n".join(good(width=12)), 1, None,
     "found 12 columns, expected 9 or 25 columns, or columns named time"),
    ("# x\n\n" + "\n".join(good(width=24)), 3, None,
     "found 24 columns (is the time missing?), expected 9 or 25"),
    ("\n".join(good(width=2, separator=";")), 1, None, "found 2 columns, expected 9 or 25"),
    ("\n".join([*good(width=12), *good(width=9)[:3]]), 1, None, "found 12 columns"),
    ("a b c d\n" + "\n".join(good(width=4)), 1, None,
     "found column names 'a', 'b', 'c', 'd' not understood, expected 9 or 25"),
    ("time x y z\n" + "\n".join(good(width=4)), 1, None,
     "found column names 'x', 'y', 'z' not understood, expected 9 or 25"),
    # Texts with wrong names of columns
    ("time roll_angle roll steer\n" + "\n".join(good(width=4)), 1, None,
     "found 'roll_angle' and 'roll', expected one column of roll angle"),
    ("#\ntime\troll_angle_2\tm2 roll\tm1 roll\n" + "\n".join(good(width=4, separator="\t")), 2,
     None, "found 'roll_angle_2' and 'm2 roll', expected one column of roll angle for maneuver 2"),
    ("time t roll steer\n" + "\n".join(good(width=4)), 1, None,
     "found 'time' and 't', expected one column of time"),
    # Texts with rows of different lengths
    (with_line(3, SHORT), 3, 25, "found 24 values, expected 25"),
    (with_line(3, " ".join([*ROW, "1"])), 3, 26, "found 26 values, expected 25"),
    (with_line(3, "7.5"), 3, 2, "found 1 values, expected 25"),
    ("\n".join(good()) + "\n" + " ".join([*ROW, "1"]), 6, 26, "found 26 values, expected 25"),
    (f"# a\n\n{with_line(3, SHORT)}", 5, 25, "found 24 values"),
    (f"# a\r\r{with_line(3, SHORT)}".replace("\n", "\r"), 5, 25, "found 24 values"),
    (with_line(3, SHORT).replace("\n", "\r\n"), 3, 25, "found 24 values"),
    # Two short rows at the end cannot both be the last row of an interrupted run.
    ("\n".join([*good(), SHORT, SHORT]), 6, 25, "found 24 values"),
    ("\n".join([*good(), SHORT, *good()]), 6, 25, "found 24 values"),
    ("\n".join([*good(3), *[SHORT] * 4]), 4, 25, "found 24 values, expected 25"),
    # Texts with missing values
    (with_token(2, 4, "", ","), 2, 4, "found no value between two separators as value 4"),
    (with_token(2, 4, "  ", ";"), 2, 4, "found no value between two separators"),
    (with_token(2, 4, "", "\t"), 2, 4, "found no value between two separators"),
    (with_token(2, 1, "", ","), 2, 1, "found no value between two separators"),
    (with_token(5, 4, "", ","), 5, 4, "found no value between two separators"),
    (with_token(2, 25, "1.5,,", ","), 2, 26, "found 26 values, expected 25"),
    (with_token(2, 4, "", " "), 2, 25, "found 24 values, expected 25"),
    (with_token(2, 4, ",1.5 2.5", ","), 2, 4, "found no value between two separators"),
    (with_token(2, 4, "1.5 2.5", ","), 2, 4, "found '1.5 2.5' as value 4, expected a number"),
    # Texts with words that are not numbers
    (with_token(2, 4, "abc"), 2, 4, "found 'abc' as value 4, expected a number"),
    (with_token(2, 1, "abc"), 2, 1, "found 'abc' as value 1"),
    (with_token(2, 4, "NA"), 2, 4, "found 'NA'"),
    (with_token(2, 4, "********"), 2, 4, "found '********'"),
    (with_token(2, 4, "1_0.5"), 2, 4, "found '1_0.5'"),
    (with_token(2, 4, "１.5"), 2, 4, "found '１.5'"),
    (with_token(2, 4, "٣"), 2, 4, "found '٣'"),
    (with_token(2, 4, "0x1p3"), 2, 4, "found '0x1p3'"),
    (with_token(2, 4, "1,5"), 2, 4, "found '1,5'"),
    (with_token(2, 4, "1.5,"), 2, 4, "found '1.5,'"),
    (with_token(2, 4, "1.2.3"), 2, 4, "found '1.2.3'"),
    (with_token(2, 4, "1e5.5"), 2, 4, "found '1e5.5'"),
    (with_token(2, 4, "1e"), 2, 4, "found '1e'"),
    (with_token(2, 4, "e5"), 2, 4, "found 'e5'"),
    (with_token(2, 4, "1e5e5"), 2, 4, "found '1e5e5'"),
    (with_token(2, 4, "--1"), 2, 4, "found '--1'"),
    (with_token(2, 4, "+-1"), 2, 4, "found '+-1'"),
    (with_token(2, 4, "-"), 2, 4, "found '-'"),
    (with_token(2, 4, "."), 2, 4, "found '.'"),
    (with_token(2, 4, "-."), 2, 4, "found '-.'"),
    (with_token(2, 4, "1-2"), 2, 4, "found '1-2'"),
    (with_token(2, 4, "12-101"), 2, 4, "found '12-101'"),
    (with_token(2, 4, "1.5-1011"), 2, 4, "found '1.5-1011'"),
    (with_token(2, 4, "1.5j"), 2, 4, "found '1.5j'"),
    (with_token(2, 4, "1nan"), 2, 4, "found '1nan'"),
    (with_token(2, 4, "5-nan"), 2, 4, "found '5-nan'"),
    (with_token(2, 4, "nano"), 2, 4, "found 'nano'"),
    (with_token(2, 4, "infinite"), 2, 4, "found 'infinite'"),
    (with_token(2, 4, "True"), 2, 4, "found 'True'"),
    (with_token(2, 4, '"1.5'), 2, 4, "found '\"1.5'"),
    (with_token(2, 4, '"1.5\''), 2, 4, "found '\"1.5''"),
    (with_token(2, 4, "1.'5'"), 2, 4, "found '1.'5''"),
    (with_token(2, 4, '"1.5"6'), 2, 4, "found '\"1.5\"6'"),
    (with_token(2, 4, '"1.""5"'), 2, 4, "found '\"1.\"\"5\"'"),
    (with_token(2, 4, '""'), 2, 4, "found '\"\"'"),
    (with_token(2, 4, "1.5\0"), 2, 4, "found '1.5\\x00'"),
    (with_token(2, 4, "\x1b[31m1"), 2, 4, "found '\\x1b[31m1'"),
    (with_token(2, 4, "\u202e1"), 2, 4, "found '\\u202e1'"),
    (with_token(2, 4, "x" * 99), 2, 4, f"found '{'x' * 40}...' (99 characters)"),
    (with_token(2, 4, "x" * 200_000), 2, 4, "(200000 characters) as value 4, expected a number"),
    ("1" * 4_100_000, 1, None, "found a line of more than 4000000 characters, expected rows"),
    # Two mistakes in one row must not cancel each other out.
    (with_line(3, " ".join(["9", "1.5", "-", "5", "1-2", *ROW[5:]])), 3, 3, "found '-' as value"),
    (with_line(3, " ".join(["9", "1.5", "e5", "1-2", *ROW[4:]])), 3, 3, "found 'e5' as value 3"),
    (with_line(3, "Simulation finished"), 3, 1, "found 'Simulation' as value 1"),
    ("\n".join([*good(), "Simulation finished"]), 6, 1, "found 'Simulation' as value 1"),
    ("\n".join([*good(), "done"]), 6, 1, "found 'done' as value 1"),
    (with_line(3, " ".join(f"x{i}" for i in range(25))), 3, 1, "found 'x0' as value 1"),
    (with_token(5, 25, "2.5e-"), 5, 25, "found '2.5e-'"),
    # If the first row is damaged, it is not read as a heading.
    (with_token(1, 4, "abc"), 1, 4, "found 'abc' as value 4, expected a number"),
    (with_line(1, SHORT), 1, 25, "found 24 values, expected 25"),
    ("My program\n\n" + with_line(1, "1 2 4"), 3, 4, "found 3 values, expected 25"),
    # Texts with wrong times
    (with_token(3, 1, "nan"), 3, 1, "found a time that is not finite, expected seconds"),
    (with_token(3, 1, "-inf", ";"), 3, 1, "found a time that is not finite"),
    (with_token(3, 1, "1e400"), 3, 1, "found a time that is not finite"),
    ("roll time steer\n1 2 3\n1 3 3\n1 nan 3\n", 4, 2, "found a time that is not finite"),
]  # fmt: skip


@pytest.mark.parametrize("reader", ["quick", "careful"])
@pytest.mark.parametrize(("content", "line", "column", "fragment"), TEXTS)
def test_bad_text(content, line, column, fragment, reader, tmp_path, monkeypatch):
    if reader == "careful":
        monkeypatch.setattr(text_rows, "parse_block", lambda *_: None)
    error = the_one_error(content, tmp_path)
    assert fragment in error.message
    if line is not None or "more than" in fragment or "no row" in fragment:
        assert (error.line, error.column) == (line, column)


@pytest.mark.parametrize("size", [1, 100, 1000])
def test_lines_are_counted_over_blocks(size, tmp_path, monkeypatch):
    monkeypatch.setattr(result_file, "_BYTES_AT_ONCE", size)
    monkeypatch.setattr(result_file, "_BYTES_OF_HEAD", 600)
    lines = good(100)
    lines[77] = lines[77].replace("9.5", "x")
    for end in ("\n", "\r\n", "\r"):
        error = the_one_error(end.join(lines) + end, tmp_path)
        assert (error.line, error.column) == (78, 10)
    cut = "\n".join([*lines[:50], SHORT, *lines[50:70]])
    error = the_one_error(cut, tmp_path)
    assert (error.line, error.column) == (51, 25)


def test_the_reference_decides_how_many_columns_are_expected(tmp_path):
    error = the_one_error("\n".join(good()), tmp_path, count=2)
    assert error.message.startswith("found 25 columns, expected 9 or 17 columns, or columns named")
    error = the_one_error("\n".join(good()), tmp_path, count=1)
    assert error.message.startswith("found 25 columns, expected 9 columns, or columns named")


@pytest.mark.parametrize("maneuver", [0, 4, -1])
def test_a_maneuver_that_the_reference_does_not_have(maneuver, tmp_path):
    with pytest.raises(InputError, match=f"found maneuver {maneuver}, expected 1 to 3"):
        read_results(tmp_path / "x", maneuver=maneuver)


def test_names_of_another_maneuver_than_told(tmp_path):
    content = "time m2_roll\n0 1\n1 2\n2 3\n"
    error = the_one_error(content, tmp_path, maneuver=3)
    assert (error.line, error.message) == (1, "found columns of maneuver 2, expected maneuver 3")
    with pytest.raises(InputError, match="found maneuver 2, expected maneuver 3"):
        read_results({"maneuver_2": {"time": [0, 1], "roll": [0, 1]}}, maneuver=3)


def test_a_number_for_maneuvers_without_numbers():
    rows = Rows(None, np.arange(3.0), np.zeros(3), {"roll_angle": np.arange(3.0)})
    expected = "found the number of maneuver 2 for results of 2 maneuvers without numbers"
    with pytest.raises(InputError, match=expected):
        results_of(Results("x", "text", (rows, rows), 17), 3, maneuver=2)


def test_files_that_cannot_be_opened(tmp_path):
    for path, fragment in (
        (tmp_path, "found a directory, expected a result file"),
        (tmp_path / "none", "cannot be read (No such file or directory), expected a result file"),
        ("a\0b", "cannot be read"),
        ("x" * 5000, "cannot be read (File name too long)"),
    ):
        with pytest.raises(InputError) as caught:
            read_results(path)
        assert fragment in caught.value.message
        assert str(caught.value).isprintable()


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = tmp_path / "x"
    path.write_text("\n".join(good()))

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.open", refuse)
    with pytest.raises(InputError, match=r"cannot be read \(Permission denied\)"):
        read_results(path)


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/urandom", "/dev/null"])
def test_endless_devices_end(device, monkeypatch):
    if not os.path.exists(device):
        pytest.skip(f"no {device}")
    taken = 0

    class Counted(io.FileIO):
        def read(self, size=-1):
            nonlocal taken
            raw = super().read(size)
            taken += len(raw)
            # A reader may read the beginning of a file to find out that it is not text.
            assert taken < 1 << 23
            return raw

    monkeypatch.setattr("pathlib.Path.open", lambda path, mode: Counted(path, mode))
    with pytest.raises(InputError):
        read_results(device)


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def npz(**arrays):
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def mat(version="5", is_packed=True, **arrays):
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, arrays, format=version, do_compression=version == "5" and is_packed)
    return buffer.getvalue()


def hdf5(**arrays):
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as f:
        for name, array in arrays.items():
            f[name] = array
    return buffer.getvalue()


def archive(*names):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as z:
        for name in names:
            z.writestr(name, "<xml/>")
    return buffer.getvalue()


def header(shape):
    """Bytes of an .npy header that announces an array of this shape, without the array."""
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + b"\0" * 64


TABLE = np.arange(250.0).reshape(10, 25)
VECTOR = np.arange(10.0)
SHEET = "is a spreadsheet; save it as xlsx or CSV"
FORMATS = f"expected {listed()}"

# Each case: the name, the content, and a part of the message.
FILES = [
    ("r.xlsx", archive("[Content_Types].xml", "xl/workbook.xml"), "expected a spreadsheet"),
    ("r.txt", archive("[Content_Types].xml", "xl/workbook.xml"), "found a damaged file"),
    ("r.ods", archive("mimetype", "content.xml"), "save it as xlsx or CSV"),
    ("r.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600, SHEET),
    ("r.xls", b"\x09\x08\x10\0" + b"\0" * 600, SHEET),
    ("r.zip", archive("results.txt"), "found an archive without NumPy arrays"),
    ("r.npz", archive(), "found an archive without NumPy arrays"),
    ("r.pkl", pickle.dumps(TABLE), f"found a pickle, {FORMATS}"),
    ("r.pkl", pickle.dumps([1, 2, 3], protocol=0), "no row of numbers"),
    ("r.png", b"\x89PNG\r\n\x1a\n" + b"\0" * 99, f"found a picture, {FORMATS}"),
    ("r.pdf", b"%PDF-1.7\n1 0 obj\n", f"found a PDF document, {FORMATS}"),
    ("r.bin", bytes(range(256)) * 20, f"found bytes that are not text, {FORMATS}"),
    ("r.bin", np.arange(99.0).tobytes(), "found bytes that are not text"),
    ("r.nc", b"CDF\x01" + b"\0" * 99, NOTHING),
    ("r.nc", b"CDF\x01" + b"\x07" * 99, "expected a netCDF file"),
    # Damaged files
    ("r.gz", gzip.compress(b"1 2 3\n" * 999, mtime=0)[:-20], "cannot be read"),
    ("r.gz", b"\x1f\x8b\x08\0" + b"x" * 99, "cannot be read"),
    ("r.gz", b"\x1f\x8b" + b"\xff" * 9, "cannot be read"),
    ("r.npy", npy(TABLE)[:-8], "found a damaged file"),
    ("r.npy", npy(TABLE)[:60], "found a damaged file"),
    ("r.npy", npy(TABLE)[:7], "found a damaged file"),
    ("r.npy", header((10**15, 25)), "expected a NumPy array"),
    ("r.npy", header((10**6, 25)), "expected a NumPy array"),
    ("r.npy", header((2**62, 2**62)), "expected a NumPy array"),
    ("r.npy", header((-4, 25)), "expected a NumPy array"),
    ("r.npy", header("(1,"), "expected a NumPy array"),
    ("r.npy", header("__import__('os')"), "expected a NumPy array"),
    ("r.npz", npz(a=TABLE)[:-60], "found a damaged file"),
    ("r.npz", npz(a=TABLE)[:60], "found a damaged file"),
    ("r.npz", npz(a=TABLE)[:100] + b"\xff" * 40 + npz(a=TABLE)[140:], "found a damaged file"),
    ("r.mat", mat(a=TABLE)[:-40], "found a damaged file"),
    ("r.mat", mat(a=TABLE)[:150], "found a damaged file"),
    ("r.mat", mat(a=TABLE)[:140] + b"\xff" * 99 + mat(a=TABLE)[239:], "expected"),
    ("r.mat", b"\0" * 200, "expected"),
    ("r.h5", hdf5(a=TABLE)[:300], "found a damaged file"),
    ("r.h5", hdf5(a=TABLE)[:8], "found a damaged file"),
    ("r.h5", hdf5(a=TABLE)[:64] + b"\xff" * 999, "found a damaged file"),
    ("r.txt", "1 2\n".encode("utf-16") + b"\x00\xd8\x00\xd8", "damaged text, expected UTF-16"),
    # Files that do not contain columns of real numbers
    ("r.npy", npy(TABLE * 1j), "found complex numbers, expected real numbers"),
    ("r.npy", npy(TABLE.astype(str)), "found text, expected real numbers"),
    ("r.npy", npy(TABLE.astype("S9")), "found text, expected real numbers"),
    ("r.npy", npy(TABLE > 3), "found truth values, expected real numbers"),
    ("r.npy", npy(TABLE.astype("datetime64[s]")), "found dates, expected real numbers"),
    ("r.npy", npy(TABLE.astype(object)), "expected a NumPy array"),
    ("r.npz", npz(a=TABLE.astype(object)), "expected NumPy arrays"),
    ("r.npy", npy(np.zeros((0, 25))), "found an empty array, expected rows"),
    ("r.npy", npy(VECTOR), "found an array of shape (10,), expected 9 or 25 columns"),
    ("r.npy", npy(np.float64(3)), "found an array of shape ()"),
    ("r.npy", npy(np.zeros((3, 4, 5))), "found an array of shape (3, 4, 5)"),
    ("r.npy", npy(np.zeros((10, 12))), "found 12 columns, expected 9 or 25"),
    ("r.npz", npz(a=TABLE, b=TABLE), f"found column names 'a', 'b' not understood, {BOTH}"),
    ("r.npz", npz(time=VECTOR), "found column names 'time', expected 9 or 25"),
    ("r.npz", npz(time=VECTOR, roll=VECTOR[:9]),
     "found 10 values of 'time' and 9 of 'roll', expected the same number"),
    ("r.npz", npz(time=VECTOR, time_lo=VECTOR[:9], roll=VECTOR),
     "found 10 values and 9 low parts"),
    ("r.npz", npz(time=VECTOR, roll=VECTOR, lean=VECTOR), "found 'roll' and 'lean', expected one"),
    ("r.npz", npz(time=VECTOR, roll=VECTOR * 1j), "roll: found complex numbers"),
    ("r.npz", npz(maneuver_1=TABLE[:, :9], m1=TABLE[:, :9]), "found maneuver 1 a second time"),
    ("r.npz", npz(maneuver_4=TABLE[:, :9]), "found maneuver 4, expected 1 to 3"),
    ("r.npz", npz(maneuver_1=TABLE), "maneuver 1: found 25 columns, expected 9"),
    ("r.mat", mat(x=3.0), "found column names 'x' not understood, expected 9 or 25"),
    ("r.mat", mat(x=np.array(["a"], dtype=object)), BOTH),
    ("r.mat", mat(time=VECTOR, roll=np.array(["a"] * 10, dtype=object)), "roll: found"),
    ("r.h5", hdf5(), NOTHING),
    ("r.h5", hdf5(time=VECTOR, roll="x"), BOTH),
    ("r.h5", hdf5(time=VECTOR, roll=np.array([b"x"] * 10, dtype=object)), "roll: found"),
    ("r.h5", hdf5(**{"maneuver_1/roll": VECTOR}),
     "maneuver 1: found column names 'roll' without their times"),
    ("r.npz", npz(time=np.array([0, np.nan, 1]), roll=VECTOR[:3]),
     "row 2: found a time that is not finite, expected seconds"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content", "fragment"), FILES)
def test_bad_files(name, content, fragment, tmp_path):
    message = the_one_error(content, tmp_path, name).message
    assert fragment in message
    # A message must not contain an address in memory, which differs from run to run.
    assert " at 0x" not in message


@pytest.mark.parametrize(
    ("source", "fragment"),
    [
        ([[1.0, 2.0], [3.0]], "found a list that is not an array, expected real numbers"),
        ([["a"] * 9], "column 1: row 1: found 'a', expected a number"),
        (None, "found a NoneType, expected the path of a file, an array"),
        (3, "found an array of shape ()"),
        ({}, NOTHING),
        ({"time": [0, 1], "roll": ["a", "b"]}, "roll: row 1: found 'a', expected a number"),
        ({"time": [0, 1], "roll": [[1], [2, 3]]}, "roll: found a list that is not an array"),
        ({"time": [], "roll": []}, "time: found an empty array"),
        (np.ones((3, 9), dtype="V3"), "found records, expected real numbers"),
    ],
)
def test_bad_arrays(source, fragment):
    with pytest.raises(InputError) as caught:
        read_results(source)
    assert fragment in caught.value.message


def test_a_small_file_that_unpacks_to_a_large_one(tmp_path):
    content = npz(a=np.zeros((10**6, 25), dtype=np.int8))
    assert len(content) < 10**5
    path = tmp_path / "r.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match="bytes after unpacking, expected at most 1000000"):
        read_results(path, max_bytes=10**6)


def test_a_small_file_of_a_large_dataset(tmp_path):
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as f:
        f.create_dataset("x", shape=(10**12, 25), dtype="f8", chunks=(1000, 25))
    with pytest.raises(InputError, match="found an array of 200000000000000 bytes, expected"):
        read_results(path)


@pytest.mark.parametrize("kind", ["frame", "frame_table"])
def test_a_small_file_of_a_large_data_frame(kind, tmp_path):
    """The file looks like one of pandas, whose arrays are read by a separate path."""
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as f:
        frame = f.create_group("df")
        frame.attrs["pandas_type"] = np.bytes_(kind)
        frame["axis1"], frame["block0_items"] = np.arange(3), np.array([b"time", b"roll_angle"])
        row = np.dtype([("index", "i8"), ("values_block_0", "f8", (2,))])
        frame.create_dataset("block0_values", shape=(10**12, 2), dtype="f8", chunks=(1000, 2))
        frame.create_dataset("table", shape=(10**12,), dtype=row, chunks=(1000,))
    with pytest.raises(InputError, match=r"found an array of [0-9]+ bytes, expected at most"):
        read_results(path)


def test_a_missing_package(tmp_path, monkeypatch):
    path = tmp_path / "r.nc"
    path.write_bytes(b"CDF\x01" + b"\0" * 99)
    monkeypatch.setitem(__import__("sys").modules, "scipy.io", None)
    with pytest.raises(MissingPackageError, match="pip install scipy"):
        read_results(path)


KINDS = {
    "npy": npy(TABLE), "npz": npz(a=TABLE), "mat": mat(a=TABLE), "mat4": mat("4", a=TABLE),
    "mat5": mat("5", False, a=TABLE, b={"time": VECTOR, "roll": [1.0, "x"]}),
    "h5": hdf5(a=TABLE, b=VECTOR), "gz": gzip.compress("\n".join(good()).encode(), mtime=0),
    "txt": "\n".join(good()).encode(), "utf16": "\n".join(good()).encode("utf-16"),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_any_damage_gives_results_or_an_input_error(kind, tmp_path):
    """Change, cut out or insert bytes anywhere in a file."""
    content = KINDS[kind]
    seed = zlib.crc32(kind.encode())
    rng = np.random.default_rng(seed)
    path = tmp_path / f"r.{'mat' if kind.startswith('mat') else kind}"
    for _ in range(200):
        damaged = bytearray(content)
        at = int(rng.integers(len(content) if rng.random() < 0.5 else min(600, len(content))))
        size = int(rng.integers(1, 9))
        what = rng.integers(4)
        if what == 0:
            del damaged[at:]
        elif what == 1:
            damaged[at : at + size] = rng.bytes(size)
        elif what == 2:
            damaged[at:at] = rng.bytes(size)
        else:
            del damaged[at : at + size]
        path.write_bytes(damaged)
        with suppress(InputError):
            read_results(path)


JSON = [
    ('{"time": [0, 1],\n "roll": [0 1]}', 2, 13, "found damaged JSON (Expecting ',' delimiter)"),
    ('{"time": [0, 1]', 1, 16, "found damaged JSON"),
    ("[" * 100_000, None, None, "found arrays nested too deep, expected rows"),
    ("[" * 900 + "1" + "]" * 900, None, None, "found arrays nested too deep, expected rows"),
    ("[" * 70 + "1" + "]" * 70, None, None, "found arrays nested too deep, expected rows"),
    ('{"a":' * 700 + "1" + "}" * 700, None, None, "found arrays nested too deep, expected"),
    ("{}", None, None, "found JSON without a table"),
    ("[]", None, None, "found JSON without a table"),
    ('{"a": 1, "b": "x"}', None, None, "found JSON without a table"),
    ("[1, 2, 3]", None, None, "found an array of shape (3,), expected 9 or 25 columns"),
    ("[[1, 2, 3], [4, 5]]", None, None, "row 2: found 2 values, expected 3 as in the first"),
    ('{"time": [0, 1], "q4": [1, 2]}', None, None, "found column names 'q4' not understood"),
    ('{"time": [0, 1], "roll": [1]}', None, None,
     "found 2 values of 'time' and 1 of 'roll', expected the same number"),
    ('{"time": [0, 1], "roll": [1, "a"]}', None, None, "roll: row 2: found 'a', expected a number"),
    ('{"time": [0, 1], "roll": [1, true]}', None, None, "roll: found truth values"),
    ('{"time": [0, null], "roll": [1, 2]}', None, None, "row 2: found a time that is not finite"),
    ('{"time": [0, 1], "roll": []}', None, None, "found column names 'time', expected 9 or 25"),
    ('{"a": {"time": [0, 1], "roll": [0, 1]}, "b": {"time": [0, 1], "roll": [0, 1]}}', None, None,
     "found column names 'a', 'b' not understood"),
    ('[{"maneuver": 4, "time": [0, 1], "roll": [0, 1]}]', None, None, "found maneuver 4, expected"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "line", "column", "fragment"), JSON)
def test_bad_json(content, line, column, fragment, tmp_path):
    error = the_one_error(content, tmp_path, "r.json")
    assert fragment in error.message
    assert (error.line, error.column) == (line, column)


def test_bad_sheets(tmp_path):
    from openpyxl import Workbook

    def saved(**sheets):
        book = Workbook()
        book.remove(book.active)
        for name, rows in sheets.items():
            sheet = book.create_sheet(name)
            for row in rows:
                sheet.append(row)
        buffer = io.BytesIO()
        book.save(buffer)
        return buffer.getvalue()

    table = [["time", "roll"], [0, 1.5], [1, 2.5]]
    for sheets, fragment in [
        ({"a": table, "b": table}, "found results in the sheets 'a', 'b', expected them in one"),
        ({"a": [["nothing"]], "m1": [["time", "roll"]]}, "sheet 'm1': found no row of numbers"),
        ({"a": [["t", "q4"], [0, 1], [1, 2]]}, "found column names 'q4' not understood"),
        ({"a": [*table, [2, "x"], [3, 4]]}, "found 'x' as value 2, expected a number"),
        ({"a": []}, "found an empty sheet"),
        ({"a": [["t", "roll", "steer"], [0, None, 1], [1, None, 2]]}, "no value in column 2"),
    ]:
        assert fragment in the_one_error(saved(**sheets), tmp_path, "r.xlsx").message


@pytest.mark.parametrize(
    ("width", "per_line", "counts"),
    [
        (9, 4, "4, 4 and 1"),
        (9, 3, "3, 3 and 3"),
        (25, 9, "9, 9 and 7"),
        (25, 6, "6, 6, 6, 6 and 1"),
    ],
)
@pytest.mark.parametrize("separator", [" ", ", "])
def test_rows_that_are_wrapped_are_told(width, per_line, counts, separator, tmp_path):
    """Rows are wrapped as Fortran's list-directed output wraps them."""
    rows = [[i / 10, *(0.1 * j - i for j in range(width - 1))] for i in range(12)]
    lines = [
        separator.join(f"{x:.6g}" for x in row[at : at + per_line])
        for row in rows
        for at in range(0, width, per_line)
    ]
    path = tmp_path / "r.txt"
    path.write_text("\n".join(lines) + "\n")
    instead = "in Fortran" if "," in separator else "in NumPy"
    said = rf":1: found each row of {width} values on \d lines \({counts} values\), .*; {instead}"
    with pytest.raises(InputError, match=said):
        read_results(path)


def test_few_columns_are_no_wrapped_rows(tmp_path):
    path = tmp_path / "r.txt"
    path.write_text("".join(f"{i} {i + 1} {i - 1}\n" for i in range(30, 0, -1)))
    with pytest.raises(InputError, match="found 3 columns"):
        read_results(path)
