"""A loaded dataset is reused while its files are unchanged, and nobody can modify it."""

import shutil

import pytest

from heyoka_bike.errors import DatasetError
from heyoka_bike.reference.following import FOLLOWS
from heyoka_bike.reference.layout import HDF5
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.manifest import MANIFEST


def test_a_set_is_read_again_when_its_manifest_changes(folder, tmp_path):
    for name in (MANIFEST, HDF5):
        shutil.copy(folder / name, tmp_path)
    first = load_reference(tmp_path)
    assert load_reference(tmp_path) is first
    assert load_reference(folder) is not first
    path = tmp_path / MANIFEST
    path.write_text(path.read_text().replace('"dataset_version": "', '"dataset_version": "9.', 1))
    assert load_reference(tmp_path).dataset_version == f"9.{first.dataset_version}"


def test_a_file_that_is_damaged_later_is_refused(folder, tmp_path):
    for name in (MANIFEST, HDF5):
        shutil.copy(folder / name, tmp_path)
    load_reference(tmp_path)
    with (tmp_path / HDF5).open("r+b") as f:
        f.write(b"\0")
    with pytest.raises(DatasetError, match="does not match"):
        load_reference(tmp_path)


def test_what_follows_from_columns_is_not_to_be_changed(reference):
    for name in reference[1].at_any_time & FOLLOWS.keys():
        with pytest.raises(ValueError, match="read-only"):
            reference[1][name][0] = 1.0
