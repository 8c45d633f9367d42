"""An HDF5 file may refer to other files in several ways; none of the other files is opened."""

import h5py
import numpy as np
import pytest

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.formats import hdf5
from heyoka_bike.scoring.reading.source import read_results

ROWS = np.column_stack([np.linspace(0.0, 1.0, 20), np.random.default_rng(1).random((20, 8))])
SECRET = b"secret"


def link(f, other, text):
    f["rows"] = h5py.ExternalLink(other, "/rows")


def link_by_way_of_another(f, other, text):
    f["away"] = h5py.ExternalLink(other, "/")
    f["rows"] = h5py.SoftLink("/away/rows")


def name_that_is_a_place(f, other, text):
    f["away"] = h5py.ExternalLink(other, "/")
    # A placeholder of the same length as the other name. Its bytes are replaced below.
    f["away|rows"] = h5py.ExternalLink(other, "/rows")


def variable_of_octave(f, other, text):
    f["y/type"] = np.bytes_("matrix")
    f["y/value"] = h5py.ExternalLink(other, "/rows")


def stored_elsewhere(f, other, text):
    f.create_dataset("rows", ROWS.shape, "f8", external=[(text, 0, ROWS.nbytes)])


def virtual(f, other, text):
    layout = h5py.VirtualLayout(ROWS.shape, "f8")
    layout[:] = h5py.VirtualSource(other, "rows", ROWS.shape)
    f.create_virtual_dataset("rows", layout)


def field_of_a_structure(f, other, text):
    f["s/a"] = h5py.ExternalLink(other, "/rows")


def label_of_a_signal(f, other, text):
    f["out/time"] = ROWS[:, :1].T
    f["out/signals/values"] = ROWS[:, 1:2].T
    label = f.create_dataset("out/signals/label", (len(SECRET), 1), "u1", external=[(text, 0, 6)])
    label.attrs["MATLAB_class"] = np.bytes_("char")


def references_elsewhere(f, other, text):
    f.create_dataset("s/a", (1,), h5py.ref_dtype, external=[(text, 0, 8)])


@pytest.mark.parametrize("userblock", [0, 512])
@pytest.mark.parametrize(
    "names",
    [
        link, link_by_way_of_another, name_that_is_a_place, variable_of_octave, stored_elsewhere,
        virtual, field_of_a_structure, label_of_a_signal, references_elsewhere,
    ],
)  # fmt: skip
def test_nothing_of_another_file_is_read(tmp_path, names, userblock):
    other, text, path = tmp_path / "other.h5", tmp_path / "text", tmp_path / "results.mat"
    with h5py.File(other, "w") as f:
        f["rows"] = ROWS
    text.write_bytes(SECRET * 1000)
    with h5py.File(path, "w", userblock_size=userblock) as f:
        names(f, str(other), str(text))
    content = path.read_bytes().replace(b"away|rows", b"away/rows")
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(userblock)[:userblock] + content[userblock:])
    with pytest.raises(InputError) as refused:
        read_results(path)
    assert SECRET.decode() not in str(refused.value)


def test_groups_that_are_in_many_others_are_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(hdf5, "MOST_MEMBERS", 1000)
    path = tmp_path / "x.h5"
    with h5py.File(path, "w") as f:
        group = f.create_group("last")
        for i in range(4):
            above = f.create_group(str(i))
            for j in range(20):
                above[str(j)] = group
            group = above
    with pytest.raises(InputError, match="found more than 1000 arrays and groups"):
        read_results(path)
