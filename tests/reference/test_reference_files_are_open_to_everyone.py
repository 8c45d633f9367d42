"""The files open with common tools and describe their contents."""

import json
from fractions import Fraction

import h5py
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS

FILE = "uncontrolled-bicycle.h5"


def test_text_loads_as_plain_numbers(folder, reference):
    lines = (folder / "uncontrolled-bicycle.txt").read_text().splitlines()
    assert len(lines) == 1001
    table = np.array([[float(x) for x in line.split(" ")] for line in lines])
    assert table.shape == (1001, 25)
    for number, maneuver in reference.items():
        for j, name in enumerate(BENCHMARK_COLUMNS):
            assert np.array_equal(table[:, 1 + 8 * (number - 1) + j], maneuver.rows.hi[name])
    # The times in the text are the shortest exact decimals.
    assert lines[7].split()[0] == "0.07"
    assert all(Fraction(line.split()[0]) == Fraction(i, 100) for i, line in enumerate(lines))


def test_time_is_the_rational_in_hi_and_lo(reference):
    for maneuver in reference.values():
        for i, (hi, lo) in enumerate(zip(maneuver.time, maneuver.time_lo, strict=True)):
            exact = Fraction(i, 100)
            assert hi == float(exact)
            assert lo == float(exact - Fraction(float(hi)))


@pytest.mark.parametrize("number", [1, *(pytest.param(n, marks=pytest.mark.proof) for n in (2, 3))])
def test_xarray_opens_each_group(folder, number):
    import xarray

    with xarray.open_dataset(folder / FILE, group=f"maneuver_{number}", engine="h5netcdf") as data:
        assert dict(data.sizes) == {"time": 1001}
        assert "time" in data.coords
        assert data["time"].attrs["units"] == "s"
        for column in COLUMNS:
            assert data[column.name].dims == ("time",)
            assert data[column.name].attrs["units"] == column.unit
            assert data[column.name + "_lo"].dims == ("time",)
    group = f"maneuver_{number}/dense"
    with xarray.open_dataset(folder / FILE, group=group, engine="h5netcdf") as data:
        pieces = data.sizes["piece"]
        assert data.sizes["breaks"] == pieces + 1
        assert data["roll_angle"].dims == ("piece", "order")


def test_every_dataset_is_described_compressed_and_checked(folder):
    with h5py.File(folder / FILE) as f:
        seen = []

        def visit(path, item):
            if isinstance(item, h5py.Dataset):
                seen.append(path)
                assert item.dtype.kind in "fi", path
                if item.name.rpartition("/")[2] in ("piece", "order"):
                    return
                for attribute in ("units", "long_name", "definition"):
                    assert item.attrs[attribute], (path, attribute)
                assert (item.compression, item.shuffle, item.fletcher32) == ("gzip", True, True)

        f.visititems(visit)
        assert len(seen) == 3 * (2 + 3 * 38 + 3 + 3 * 38)
        assert f["maneuver_1"].attrs["name"] == "maneuver 1"


def test_manifest_names_no_date_host_or_time(folder):
    document = json.loads((folder / "manifest.json").read_text())
    assert set(document) == {
        "schema_version", "dataset_version", "content_sha256", "made_by", "inputs", "files",
    }  # fmt: skip
    assert set(document["made_by"]) == {"digits", "packages"}


def test_content_hash_is_that_of_the_numbers_in_the_file(folder, reference):
    """Recompute the hash from the HDF5 file alone, by the recipe in the documentation."""
    import hashlib

    h = hashlib.sha256()
    with h5py.File(folder / FILE) as f:
        for i in (1, 2, 3):
            group = f[f"maneuver_{i}"]
            names = [n for n in group if n != "dense"]
            names += [f"dense/{n}" for n in group["dense"] if n not in ("piece", "order")]
            names = [n for n in names if not n.endswith("_bound")]
            for name in sorted(names):
                x = group[name][:].astype("<f8")
                h.update(f"maneuver_{i}/{name} {x.shape}\n".encode() + x.tobytes())
    assert h.hexdigest() == reference.content_sha256
