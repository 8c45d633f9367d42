"""A small file that unpacks to a large one is refused, at once if it says how large it is."""

import gzip
import zlib
from io import BytesIO

import numpy as np
import pytest

from heyoka_bike import read_results
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
        with pytest.raises(InputError, match=f"found {len(text)} bytes packed, expected at most"):
            read_results(path, maneuver=1, max_bytes=most)
    else:
        assert len(read_results(path, maneuver=1, max_bytes=most).maneuvers[0].time) == 100


def test_a_length_that_is_not_true_is_found_out(tmp_path):
    """The length at the end is that of another text."""
    text = rows(10_000)
    packed = zlib.compressobj(9, zlib.DEFLATED, 31)
    data = packed.compress(text) + packed.flush()
    path = tmp_path / "r.gz"
    path.write_bytes(data[:-4] + (7).to_bytes(4, "little"))
    with pytest.raises(InputError, match="found more than 100000 bytes packed"):
        read_results(path, maneuver=1, max_bytes=100_000)


def test_what_says_that_it_is_too_long_is_refused_before_it_is_read(tmp_path):
    packed = zlib.compressobj(1, zlib.DEFLATED, 31)
    block = rows(1000) * 20
    data = b"".join(packed.compress(block) for _ in range(20)) + packed.flush()
    path = tmp_path / "r.gz"
    # Whoever unpacks it meets what is damaged.
    half = len(data) // 2
    path.write_bytes(data[:half] + b"\xff" * half + (6 * 10**8).to_bytes(4, "little"))
    with pytest.raises(InputError, match="found 600000000 bytes packed") as caught:
        read_results(path)
    assert f"expected at most {MOST_UNPACKED}; --max-bytes N allows more" in str(caught.value)
    path.write_bytes(data[:half] + b"\xff" * half + (10**6).to_bytes(4, "little"))
    with pytest.raises(InputError, match="cannot be read"):
        read_results(path)


def test_an_archive_says_how_long_it_is(tmp_path):
    path = tmp_path / "r.npz"
    np.savez_compressed(path, run=np.zeros((1000, 9)))
    with pytest.raises(InputError, match="bytes packed, expected at most 5000"):
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
