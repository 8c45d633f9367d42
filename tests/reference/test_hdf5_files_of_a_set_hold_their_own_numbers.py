"""An HDF5 file that refers to other files, or unpacks to far more bytes, is refused unread."""

import io
import subprocess
import sys
import zlib

import h5py
import numpy as np
import pytest

from heyoka_bike.errors import DatasetError
from heyoka_bike.reference.hdf5 import opened, read_array, why_unsafe

ROWS = np.linspace(0.0, 1.0, 101)
NAME = "roll_angle"


def external_link(group, other):
    group[NAME] = h5py.ExternalLink(f"{other}.h5", "/rows")


def soft_link(group, other):
    group["own"] = ROWS
    group[NAME] = h5py.SoftLink("/maneuver_1/own")


def loop(group, other):
    group[NAME] = group


def virtual(group, other):
    layout = h5py.VirtualLayout(ROWS.shape, "f8")
    layout[:] = h5py.VirtualSource(f"{other}.h5", "rows", ROWS.shape)
    group.create_virtual_dataset(NAME, layout)


def virtual_of_itself(group, other):
    layout = h5py.VirtualLayout(ROWS.shape, "f8")
    layout[:] = h5py.VirtualSource(".", "time", ROWS.shape)
    group.create_virtual_dataset(NAME, layout)


def external_storage(group, other):
    group.create_dataset(NAME, ROWS.shape, "f8", external=[(f"{other}.raw", 0, ROWS.nbytes)])


def huge(group, other):
    group.create_dataset(NAME, (2**40,), "f8", chunks=(2**16,))


def huge_together(group, other):
    for i in range(100):
        group.create_dataset(f"{NAME}_{i}", (10**6,), "f8", chunks=(2**16,))


def zeros(group, other):
    group.create_dataset(NAME, data=np.zeros(10**7), chunks=(10**6,), compression="gzip")


def huge_chunk(group, other):
    group.create_dataset(NAME, ROWS.shape, "f8", chunks=(2**27,), maxshape=(None,))


def longer_chunk(group, other):
    """The stream of a chunk of 808 bytes unpacks to 200 MB."""
    group.create_dataset(NAME, data=ROWS, chunks=ROWS.shape, compression="gzip")
    raw = zlib.compress(bytes(200_000_000), 9)
    group[NAME].id.write_direct_chunk((0,), raw)


def store_chunk(group, raw, filters):
    """Store bytes as the only chunk of a dataset; `filters` adds filters to its properties."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk(ROWS.shape)
    filters(properties)
    space = h5py.h5s.create_simple(ROWS.shape)
    dataset = h5py.h5d.create(group.id, NAME.encode(), h5py.h5t.IEEE_F64LE, space, properties)
    dataset.write_direct_chunk((0,), raw)


def longer_chunk_shuffled(group, other):
    """The compressed stream of the long chunk is shuffled, so the stored bytes are not a stream."""

    def filters(properties):
        properties.set_deflate(9)
        properties.set_shuffle()

    raw = zlib.compress(bytes(200_000_000), 9)
    store_chunk(group, raw + bytes(-len(raw) % 8), filters)


def packed_twice(group, other):
    def filters(properties):
        properties.set_deflate(9)
        properties.set_deflate(9)

    store_chunk(group, zlib.compress(zlib.compress(bytes(10**9))), filters)


def other_filter(group, other):
    group.create_dataset(NAME, data=ROWS, chunks=ROWS.shape, compression="lzf")


def texts(group, other):
    group[NAME] = ["x" * 1000] * 101


def references(group, other):
    group[NAME] = np.array([group.ref] * 101, dtype=h5py.ref_dtype)


def many_texts(group, other):
    group[NAME] = ROWS
    group[NAME].attrs["units"] = ["rad"] * 1000


def named_type(group, other):
    group[NAME] = np.dtype("f8")


def made(change, other):
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as f:
        group = f.create_group("maneuver_1")
        group["time"] = ROWS
        change(group, other)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (external_link, "is a link"), (soft_link, "is a link"), (loop, "is a second name"),
        (virtual, "is stored in another file"), (virtual_of_itself, "is stored in another file"),
        (external_storage, "is stored in another file"), (huge, "unpacks to 8796093022208 bytes"),
        (huge_together, "unpacks to"), (zeros, "unpacks to 80000000 bytes"),
        (huge_chunk, "has a chunk of 1073741824 bytes"),
        (longer_chunk, "has a chunk that unpacks to more"),
        (longer_chunk_shuffled, "has a chunk that unpacks to more"),
        (packed_twice, "is compressed twice"), (other_filter, "is compressed by filter 32000"),
        (texts, "does not contain numbers"), (references, "does not contain numbers"),
        (many_texts, "has many strings"), (named_type, "is a named type"),
    ],
)  # fmt: skip
def test_it_is_refused_by_name(change, reason, tmp_path):
    other = tmp_path / "other"
    with h5py.File(f"{other}.h5", "w") as f:
        f["rows"] = ROWS
    (tmp_path / "other.raw").write_bytes(ROWS.tobytes())
    raw = made(change, other)
    for _ in range(2):
        with pytest.raises(DatasetError, match=rf"/maneuver_1/roll_angle.*{reason}"):
            opened(raw)


def test_a_name_with_a_slash_is_refused():
    raw = made(lambda group, _: group.create_dataset("roll|angle", data=ROWS), None)
    with pytest.raises(DatasetError, match="/maneuver_1/roll/angle is a link"):
        opened(raw.replace(b"roll|angle", b"roll/angle"))


def test_what_is_usual_is_read(folder):
    raw = made(
        lambda group, _: group.create_dataset(
            NAME, data=ROWS, compression="gzip", shuffle=True, fletcher32=True
        ), None,
    )  # fmt: skip
    with opened(raw) as f:
        assert np.array_equal(read_array(f["maneuver_1"], NAME), ROWS)
    with opened((folder / "candidate.h5").read_bytes()) as f:
        assert len(f) == 3


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (ROWS, r"found \(101,\) of float64, expected \(100,\)"),
        ([1, 2], r"found \(2,\) of int64, expected \(100,\) of float64"),
    ],
)
def test_numbers_of_another_type_or_shape_are_not_read(data, said):
    raw = made(lambda group, _: group.create_dataset(NAME, data=data), None)
    with opened(raw) as f, pytest.raises(ValueError, match=said):
        read_array(f["maneuver_1"], NAME, (100,))


@pytest.mark.parametrize("compression", ["gzip", "lzf"])
def test_long_chunks_that_unpack_to_their_length_are_read(tmp_path, compression):
    """The chunk is larger than `hdf5._USUAL_CHUNK`, so its unpacked size is checked."""
    with h5py.File(tmp_path / "x.h5", "w") as f:
        f.create_dataset(
            "x", data=np.zeros(9_000_000), chunks=(9_000_000,), compression=compression
        )
    with h5py.File(tmp_path / "x.h5") as f:
        assert why_unsafe(f["x"].id, 10**8) == ""


@pytest.mark.skipif(sys.platform != "linux", reason="measures memory as Linux counts it")
@pytest.mark.proof
def test_little_memory_is_used_for_a_bomb(tmp_path):
    path = tmp_path / "x.h5"
    path.write_bytes(made(longer_chunk, None))
    script = (
        "import sys\nfrom pathlib import Path\n"
        "from heyoka_bike.reference.hdf5 import opened\n"
        "try:\n    opened(Path(sys.argv[1]).read_bytes())\nexcept ValueError:\n"
        # VmHWM is the peak memory of this program alone. ru_maxrss also includes the peak of its
        # parent.
        "    status = Path('/proc/self/status').read_text()\n"
        "    print(status.partition('VmHWM:')[2].split()[0])"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, path], capture_output=True, text=True, check=True
    )
    assert int(run.stdout) * 1024 < 150_000_000
