"""The manifest of a reference folder: which files belong to it, and what makes them whole.

A set is written file by file, each beside its place and renamed into it, the manifest last. A
reader accepts only what the manifest says, so a run that was interrupted shows as files that the
old manifest (or none) does not match; running again repairs it.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import describe_limits, read_maneuvers
from heyoka_bike.errors import DatasetError
from heyoka_bike.reference.layout import AFTER_FILES, as_json
from heyoka_bike.system.files import UNFINISHED, replace_file
from heyoka_bike.system.resources import benchmark_maneuvers, reference_folder

MANIFEST = "manifest.json"
SCHEMA_VERSION = 1

DATASET_VERSION = "2.0.0"
"""Version of the set that this package makes of the benchmark."""

DATASET_DATE = "2026-11-24"
"""Day of that version. It belongs to the version, not to a run: whoever makes the set writes it."""

_HDF5_VERSION = "2.0.0"

PUBLISHED_MANIFESTS = {
    "1.0.0": "a7d78b3c2ada41809800cd61c104e341091defa82be935d1644c277c8081d796",
    "1.1.0": "6b228c1bf199b25514c5107763725ae1018ad7182707361af1c11187dd6f8d49",
    "1.2.0": "e04aac71d666541e02812a116e340219b7c1851f44402372040c0590847932a6",
    "1.3.0": "4439ff3838aa21363afee0039a7bc4eba6ad1f0e96177092047903476f42a220",
    "1.4.0": "8ec0d7570157b423d758a1b56d39b4e42f7797d0654aacb1a265a48bd1f31dbb",
    "1.5.0": "1d8bd8ea16f79f6d8f9dc06b35e6b602b490aba33544ad22ea2482a8692f3b07",
    "2.0.0": "2a0d29d8da22a2ef65ab428a62a01c606eaec196f225e3b040c719b03ac641e3",
}
"""Hashes of the manifests of the published sets, by version."""

PUBLISHED_VERSION, PUBLISHED_MANIFEST_SHA256 = list(PUBLISHED_MANIFESTS.items())[-1]
"""The last one, which comes with this package."""

BESIDE_1_5_0: Mapping[str, tuple[int, str]] = {
    AFTER_FILES[0]: (4312, "b1b3b50409e593e3af03a2b28980d20cc5b4af4d6374f58312861e3f3c610f56"),
    AFTER_FILES[1]: (951421, "89bf65df610e93fa1df1e228f119b1a498b647050dcc740fd2cbf472131cc180"),
}
"""Bytes and sha256 of `AFTER_FILES` with the set 1.5.0, whose manifest lacks them."""

CUSTOM = "custom"
"""Dataset version of a set made from other inputs than the benchmark's."""


@dataclass(frozen=True)
class Manifest:
    """A parsed manifest.json.

    Attributes
    ----------
    dataset_version, content_sha256
        Version of the set, and the hash of its numbers.
    made_by : mapping
        Digits of the integration, and versions of the packages.
    inputs : mapping
        Bicycle and maneuvers, as exact text.
    performance_limits : mapping of int to Fraction
        What eq. (1) of the benchmark must be less than [%], by number of those maneuvers that are
        judged by it.
    files : mapping of str to (int, str)
        Bytes and sha256 by file name.
    sha256 : str
        Hash of the manifest itself.
    """

    dataset_version: str
    content_sha256: str
    made_by: Mapping[str, Any]
    inputs: Mapping[str, Any]
    performance_limits: Mapping[int, Fraction]
    files: Mapping[str, tuple[int, str]]
    sha256: str


def hdf5_version(dataset_version: str) -> str:
    """The version that last changed the HDF5 files of a set: they name it.

    What a later version adds thus leaves their bytes as they are.
    """
    return _HDF5_VERSION if dataset_version == DATASET_VERSION else dataset_version


def render(
    *, dataset_version: str, content_sha256: str, inputs: Mapping[str, Any],
    made_by: Mapping[str, Any], files: Mapping[str, bytes],
    performance_limits: Mapping[str, str] | None = None,
) -> bytes:  # fmt: skip
    """Bytes of the manifest of the given files; no date, host or time in it.

    Published sets do not name the limit of eq. (1): it is that of the benchmark's own maneuvers.
    """
    limits = {} if dataset_version != CUSTOM else performance_limits
    document = {
        "schema_version": SCHEMA_VERSION,
        "dataset_version": dataset_version,
        "content_sha256": content_sha256,
        "made_by": made_by,
        "inputs": inputs,
        **({"performance_limits": dict(limits)} if limits else {}),
        "files": [
            {"file": name, "bytes": len(data), "sha256": sha256(data)}
            for name, data in sorted(files.items())
        ],
    }
    return as_json(document)


def read_manifest(folder: str | Path) -> Manifest:
    """Read the manifest of a folder.

    Raises
    ------
    DatasetError
        It is missing, unreadable, or not a manifest this version understands.
    """
    path = Path(folder) / MANIFEST
    try:
        raw = path.read_bytes()
    except FileNotFoundError:
        raise DatasetError(
            f"{folder}: no {MANIFEST} found, expected a folder written by 'heyoka-bike generate' "
            "(if a run was interrupted, run it again)"
        ) from None
    except OSError as e:
        raise DatasetError(f"{path}: cannot be read: {e.strerror or e}") from None
    return parse(raw, path)


def parse(raw: bytes, path: str | Path = MANIFEST) -> Manifest:
    """Parse the bytes of a manifest; `path` is for errors.

    Raises
    ------
    DatasetError
        They are not a manifest this version understands.
    """
    try:
        document = json.loads(raw)
        version = document["schema_version"]
        if version != SCHEMA_VERSION:
            newer = isinstance(version, int) and version > SCHEMA_VERSION
            advice = "a newer heyoka_bike reads it" if newer else "generate the set again"
            raise DatasetError(
                f"{path}: found schema version {version}, expected {SCHEMA_VERSION} ({advice})"
            )
        dataset_version = str(document["dataset_version"])
        limits = document.get("performance_limits", {})
        if dataset_version != CUSTOM:
            limits = describe_limits(read_maneuvers(benchmark_maneuvers()))
        return Manifest(
            dataset_version=dataset_version,
            content_sha256=str(document["content_sha256"]),
            made_by=dict(document["made_by"]),
            inputs=dict(document["inputs"]),
            performance_limits={int(n): Fraction(str(x)) for n, x in limits.items()},
            files={str(f["file"]): (int(f["bytes"]), str(f["sha256"])) for f in document["files"]},
            sha256=sha256(raw),
        )
    except (ValueError, KeyError, TypeError, RecursionError) as e:
        if isinstance(e, DatasetError):
            raise
        raise DatasetError(f"{path}: is not a manifest ({type(e).__name__}: {e})") from None


def check_published(folder: str | Path) -> None:
    """Refuse a folder that does not hold the published set this version of the package knows.

    Raises
    ------
    DatasetError
        Its manifest is missing or another one.
    """
    if read_manifest(folder).sha256 != PUBLISHED_MANIFEST_SHA256:
        raise DatasetError(
            f"{folder}: its manifest is not that of the published set {PUBLISHED_VERSION}; "
            "name the folder to use a set of your own"
        )


def read_file(folder: str | Path, name: str, manifest: Manifest) -> bytes:
    """Contents of a file of the set, checked against the manifest.

    Raises
    ------
    DatasetError
        The file is not in the manifest, missing, or differs from it.
    """
    path = Path(folder) / name
    if name not in manifest.files:
        raise DatasetError(f"{folder}: {MANIFEST} has no entry for {name}")
    try:
        data = path.read_bytes()
    except OSError as e:
        raise DatasetError(f"{path}: cannot be read: {e.strerror or e}") from None
    size, digest = manifest.files[name]
    if len(data) != size or sha256(data) != digest:
        raise DatasetError(
            f"{path}: does not match {MANIFEST} (found {len(data)} bytes, sha256 "
            f"{sha256(data)[:12]}...; expected {size} bytes, {digest[:12]}...): the file is "
            "damaged or 'heyoka-bike generate' was interrupted; run it again"
        )
    return data


def load_file(folder: str | Path | None, name: str) -> tuple[Path, Manifest, bytes]:
    """Folder and manifest of a set, by default the published one, and a file of it, all checked.

    Raises
    ------
    DatasetError
        The set is missing, incomplete or damaged; the published one must also carry the hash that
        this version of the package knows.
    """
    where = reference_folder() if folder is None else Path(folder)
    manifest = read_manifest(where)
    if folder is None:
        check_published(where)
    return where, manifest, read_file(where, name, manifest)


@contextmanager
def reading(path: Path, what: str) -> Iterator[None]:
    """Have what a file of HDF5 is not said in one line.

    Raises
    ------
    DatasetError
        What is done meanwhile finds that the file is not `what` it should be.
    """
    try:
        yield
    except (OSError, KeyError, OverflowError, TypeError, ValueError) as e:
        raise DatasetError(f"{path}: is not {what} ({e})") from None


def write_set(folder: str | Path, files: Mapping[str, bytes], manifest: bytes) -> list[str]:
    """Put the files of a set in place, the manifest last; returns the names that changed.

    Files of equal content are left untouched.

    Raises
    ------
    DatasetError
        The folder cannot be written.
    """
    return write_files(folder, {**dict(sorted(files.items())), MANIFEST: manifest})


def write_files(folder: str | Path, files: Mapping[str, bytes]) -> list[str]:
    """Put files in place in their order; returns the names that changed.

    Raises
    ------
    DatasetError
        The folder cannot be written.
    """
    folder = Path(folder)
    changed = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            if _is_same(folder / name, data):
                continue
            (folder / name).parent.mkdir(exist_ok=True)
            replace_file(folder / name, data)
            changed.append(name)
        for place in {(folder / name).parent for name in files}:
            for stale in place.glob(f".*{UNFINISHED}"):
                stale.unlink(missing_ok=True)
            _sync_folder(place)
    except OSError as e:
        raise DatasetError(
            f"{e.filename or folder}: cannot be written: {e.strerror or e}"
        ) from None
    return changed


def sha256(data: bytes) -> str:
    """Hexadecimal SHA-256."""
    return hashlib.sha256(data).hexdigest()


def _is_same(path: Path, data: bytes) -> bool:
    try:
        return path.stat().st_size == len(data) and path.read_bytes() == data
    except FileNotFoundError:
        return False


def _sync_folder(folder: Path) -> None:
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
