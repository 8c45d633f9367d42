"""A small file that unpacks to a large one is refused, at once if it states its size."""

import gzip
import zlib
from io import BytesIO

import h5py
import numpy as np
import pytest

from heyoka_bike import read_results
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.commands.options import COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.request import MOST_UNPACKED
from heyoka_bike.scoring.reading.text.opening import MOST_COLUMNS


def rows(count, width=9):
    return "".join(f"{i / 1000!r} " + "1.5 " * (width - 1) + "\n" for i in range(count)).encode()


@pytest.mark.parametrize("most", [100, 10_000])
def test_a_packed_text_is_read_to_the_limit(most, tmp_path):
    text = rows(100)
    path = tmp_path / "r.gz"
    path.write_bytes(gzip.compress(text))
    if most < len(text):
        with pytest.raises(
            InputError, match=f"found {len(text)} bytes after unpacking, expected at most"
        ):
            read_results(path, maneuver=1, max_bytes=most)
    else:
        assert len(read_results(path, maneuver=1, max_bytes=most).maneuvers[0].time) == 100


def test_a_length_that_is_not_true_is_found_out(tmp_path):
    """The length at the end of the file belongs to another text."""
    text = rows(10_000)
    packed = zlib.compressobj(9, zlib.DEFLATED, 31)
    data = packed.compress(text) + packed.flush()
    path = tmp_path / "r.gz"
    path.write_bytes(data[:-4] + (7).to_bytes(4, "little"))
    with pytest.raises(InputError, match="found more than 100000 bytes after unpacking"):
        read_results(path, maneuver=1, max_bytes=100_000)


def test_what_says_that_it_is_too_long_is_refused_before_it_is_read(tmp_path):
    packed = zlib.compressobj(1, zlib.DEFLATED, 31)
    block = rows(1000) * 20
    data = b"".join(packed.compress(block) for _ in range(20)) + packed.flush()
    path = tmp_path / "r.gz"
    # The message must come before unpacking, which would show that the file is damaged.
    half = len(data) // 2
    path.write_bytes(data[:half] + b"\xff" * half + (6 * 10**8).to_bytes(4, "little"))
    with pytest.raises(InputError, match="found 600000000 bytes after unpacking") as caught:
        read_results(path)
    assert f"expected at most {MOST_UNPACKED}; --max-bytes N allows more" in str(caught.value)
    path.write_bytes(data[:half] + b"\xff" * half + (10**6).to_bytes(4, "little"))
    with pytest.raises(InputError, match="cannot be read"):
        read_results(path)


def test_an_archive_says_how_long_it_is(tmp_path):
    path = tmp_path / "r.npz"
    np.savez_compressed(path, run=np.zeros((1000, 9)))
    with pytest.raises(InputError, match="bytes after unpacking, expected at most 5000"):
        read_results(path, maneuver=1, max_bytes=5000)


def test_the_option_allows_more_and_less(tmp_path, capsys):
    path = tmp_path / "r.gz"
    path.write_bytes(gzip.compress(rows(100)))
    assert main(["score", str(path), "--maneuver", "1", "--max-bytes", "500"]) == 1
    assert f"(default: {MOST_UNPACKED})" in COLUMNS["--max-bytes N"]
    assert "expected at most 500; --max-bytes N allows more" in capsys.readouterr().err
    assert main(["score", str(path), "--maneuver", "1", "--max-bytes", "50000"]) == 0
    capsys.readouterr()
    assert main(["score", str(path), "--max-bytes", "many"]) == 1
    assert "--max-bytes: found many, expected a whole number" in capsys.readouterr().err


@pytest.mark.parametrize("count", [MOST_COLUMNS + 1, 10 * MOST_COLUMNS])
def test_so_many_columns_are_refused_before_they_are_looked_at(count, tmp_path):
    names = ["time", "roll_angle", *(f"x{i}" for i in range(count - 2))]
    text = BytesIO()
    text.write(",".join(names).encode() + b"\n")
    for i in range(3):
        text.write(f"{i / 100},".encode() + b",".join([b"1"] * (count - 1)) + b"\n")
    path = tmp_path / "r.csv"
    path.write_bytes(text.getvalue())
    with pytest.raises(InputError, match=f"found {count} columns, expected at most {MOST_COLUMNS}"):
        read_results(path)


def hdf5(path, dtype="f8", **how):
    """Write a file of nine columns, with the options `how` for the dataset of the roll angle."""
    with h5py.File(path, "w") as f:
        for i, name in enumerate(("time", *BENCHMARK_COLUMNS)):
            if name != "roll_angle":
                f[name] = np.linspace(0, 1, 101) + i
        f.create_dataset("roll_angle", (101,), dtype, **how)


def test_a_chunk_that_unpacks_to_more_than_it_says_is_refused(tmp_path):
    """HDF5 itself unpacks a stream to its end, whatever the size of the chunk."""
    path = tmp_path / "r.h5"
    hdf5(path, chunks=(101,), compression="gzip")
    with h5py.File(path, "r+") as f:
        f["roll_angle"].id.write_direct_chunk((0,), zlib.compress(bytes(200_000_000), 9))
    with pytest.raises(InputError, match="/roll_angle: it has a chunk that unpacks to more than"):
        read_results(path, maneuver=1)


@pytest.mark.parametrize(
    "how",
    [
        {"chunks": (2**28,), "maxshape": (None,)}, {"chunks": (2**26,), "maxshape": (None,)},
    ],
    ids=["beyond the largest array", "beyond what may be packed"],
)  # fmt: skip
def test_a_chunk_far_longer_than_its_array_is_refused(how, tmp_path):
    path = tmp_path / "r.h5"
    hdf5(path, **how)
    with pytest.raises(InputError, match=r"a chunk of 2147483648 bytes|more than 500000000 bytes"):
        read_results(path, maneuver=1)


def test_arrays_of_a_file_unpack_to_the_limit_together(tmp_path):
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as f:
        for i, name in enumerate(("time", *BENCHMARK_COLUMNS)):
            x = np.arange(10_000) * (i == 0) / 1e4
            f.create_dataset(name, data=x, compression="gzip", shuffle=True)
    assert len(read_results(path, maneuver=1, max_bytes=10**6).maneuvers[0].time) == 10_000
    with pytest.raises(InputError, match="found more than 500000 bytes after unpacking"):
        read_results(path, maneuver=1, max_bytes=500_000)


def test_a_text_that_many_references_lead_to_is_counted_each_time(tmp_path):
    path = tmp_path / "r.mat"
    with h5py.File(path, "w", userblock_size=512) as f:
        text = f.create_dataset("#refs#/a", (100_000, 1), "u2")
        text.attrs["MATLAB_class"] = np.bytes_("char")
        cells = f.create_dataset("cells", (1, 10_000), h5py.ref_dtype)
        cells[:] = text.ref
        f["time"] = np.linspace(0, 1, 20)[None]
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")
    with pytest.raises(InputError, match="found more than 500000000 bytes after unpacking"):
        read_results(path)


def test_one_long_text_in_many_rows_is_counted_each_time(tmp_path):
    """All rows of an array or of an attribute may refer to the same bytes of the file."""
    path = tmp_path / "r.h5"
    hdf5(path, h5py.string_dtype())
    with h5py.File(path, "r+") as f:
        f["roll_angle"][0] = "x" * 100_000
        offset = f["roll_angle"].id.get_offset()
    with path.open("r+b") as file:
        file.seek(offset)
        one = file.read(16)
        file.seek(offset)
        file.write(one * 101)
    with pytest.raises(InputError, match="found more than 1000000 bytes after unpacking"):
        read_results(path, maneuver=1, max_bytes=10**6)
