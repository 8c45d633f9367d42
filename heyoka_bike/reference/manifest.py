"""The manifest of a reference folder: the list of its files, and their hashes.

A dataset is written file by file, each under a temporary name and then renamed, the manifest last.
A reader accepts only files that match the manifest. After an interrupted run the files do not match
the old manifest, or there is none; running again repairs this.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import describe_limits, read_maneuvers
from heyoka_bike.errors import DatasetError, NotCertifiedError, printable
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.hdf5 import DAMAGE
from heyoka_bike.reference.layout import AFTER_FILES, as_json
from heyoka_bike.system.files import UNFINISHED, path_inside, read_regular, replace_file
from heyoka_bike.system.resources import benchmark_maneuvers, reference_folder

MANIFEST = "manifest.json"
SCHEMA_VERSION = 1

DATASET_VERSION = "2.0.0"
"""Version of the benchmark's dataset that this package makes."""

DATASET_DATE = "2026-11-24"
"""Date of the dataset version. It belongs to the version, not to a run: everybody who makes the
dataset writes this date."""

DATASET_PACKAGE_VERSION = "1.0.0"
"""Version of this package that first made the dataset version. It belongs to the dataset version,
too: later versions of the package make the same bytes."""

_HDF5_VERSION = "2.0.0"

PUBLISHED_MANIFESTS = {
    "1.0.0": "a7d78b3c2ada41809800cd61c104e341091defa82be935d1644c277c8081d796",
    "1.1.0": "6b228c1bf199b25514c5107763725ae1018ad7182707361af1c11187dd6f8d49",
    "1.2.0": "e04aac71d666541e02812a116e340219b7c1851f44402372040c0590847932a6",
    "1.3.0": "4439ff3838aa21363afee0039a7bc4eba6ad1f0e96177092047903476f42a220",
    "1.4.0": "8ec0d7570157b423d758a1b56d39b4e42f7797d0654aacb1a265a48bd1f31dbb",
    "1.5.0": "1d8bd8ea16f79f6d8f9dc06b35e6b602b490aba33544ad22ea2482a8692f3b07",
    "2.0.0": "8ee477e4525cb506cecbcad08aefbc2d006af08a08ee0043018b13d5d82ee88c",
}
"""Hashes of the manifests of the published datasets, by version."""

PUBLISHED_VERSION, PUBLISHED_MANIFEST_SHA256 = list(PUBLISHED_MANIFESTS.items())[-1]
"""The latest published dataset, which comes with this package."""

UNLISTED_FILES_1_5_0: Mapping[str, tuple[int, str]] = {
    AFTER_FILES[0]: (4312, "b1b3b50409e593e3af03a2b28980d20cc5b4af4d6374f58312861e3f3c610f56"),
    AFTER_FILES[1]: (951421, "89bf65df610e93fa1df1e228f119b1a498b647050dcc740fd2cbf472131cc180"),
}
"""Bytes and sha256 of `AFTER_FILES` in the dataset 1.5.0, whose manifest lacks them."""

CUSTOM = "custom"
"""Version of a dataset made from other inputs than the benchmark's."""

_MOST_BYTES = 10_000_000
"""Maximum length of a manifest; that of the published dataset is below 4000."""

MOST_BYTES_OF_SET = 1_000_000_000
"""Maximum total length of a dataset's files, which are read into memory. The published ones have 24
million bytes for 30 s of motion."""


@dataclass(frozen=True)
class Manifest:
    """A parsed manifest.json.

    Attributes
    ----------
    dataset_version, content_sha256
        Version of the dataset, and the hash of its numbers.
    made_by : mapping
        Digits of the integration, and versions of the packages.
    inputs : mapping
        Bicycle and maneuvers, as exact text.
    performance_limits : mapping of int to Fraction
        Upper limits for eq. (1) of the benchmark [%], by number of the maneuvers that are judged by
        it.
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
    """Return the version that the HDF5 files of a dataset state: the one that last changed them.

    Additions in a later version therefore do not change their bytes.
    """
    return _HDF5_VERSION if dataset_version == DATASET_VERSION else dataset_version


def render(
    *, dataset_version: str, content_sha256: str, inputs: Mapping[str, Any],
    made_by: Mapping[str, Any], files: Mapping[str, bytes],
    performance_limits: Mapping[str, str] | None = None,
) -> bytes:  # fmt: skip
    """Return the bytes of the manifest of these files, which contains no date, host or time.

    Published datasets do not state the limit of eq. (1), which is that of the benchmark's own
    maneuvers.
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
        The manifest is missing, unreadable, or not one that this version understands.
    """
    return parse(read_raw(folder), Path(folder) / MANIFEST)


def read_raw(folder: str | Path) -> bytes:
    """Read the bytes of the manifest of a folder.

    Raises
    ------
    DatasetError
        The manifest is missing, or cannot be read.
    """
    try:
        return read_inside(Path(folder), MANIFEST, _MOST_BYTES)
    except FileNotFoundError:
        raise DatasetError(
            f"{folder}: no {MANIFEST} found, expected a folder written by 'heyoka-bike generate' "
            "(if a run was interrupted, run it again)"
        ) from None
    except (OSError, ValueError) as e:
        reason = getattr(e, "strerror", None) or e
        raise DatasetError(f"{Path(folder) / MANIFEST}: cannot be read: {reason}") from None


def parse(raw: bytes, path: str | Path = MANIFEST) -> Manifest:
    """Parse the bytes of a manifest; `path` is for errors.

    Raises
    ------
    DatasetError
        The bytes are not a manifest that this version understands.
    """
    try:
        document = json.loads(raw)
        version = document["schema_version"]
        if version != SCHEMA_VERSION:
            newer = isinstance(version, int) and version > SCHEMA_VERSION
            advice = "use a newer heyoka_bike" if newer else "generate the dataset again"
            raise DatasetError(
                f"{path}: found schema version {version}, expected {SCHEMA_VERSION} ({advice})"
            )
        dataset_version = str(document["dataset_version"])
        limits = document.get("performance_limits", {})
        if dataset_version != CUSTOM:
            limits = describe_limits(read_maneuvers(benchmark_maneuvers()))
        files = {str(f["file"]): (int(f["bytes"]), str(f["sha256"])) for f in document["files"]}
        if (total := sum(size for size, _ in files.values())) > MOST_BYTES_OF_SET:
            raise DatasetError(
                f"{path}: lists files of {total} bytes in total, expected at most "
                f"{MOST_BYTES_OF_SET}"
            )
        return Manifest(
            dataset_version=dataset_version,
            content_sha256=str(document["content_sha256"]),
            made_by=dict(document["made_by"]),
            inputs=dict(document["inputs"]),
            performance_limits={int(n): Exact.parse(str(x)).fraction() for n, x in limits.items()},
            files=files,
            sha256=sha256(raw),
        )
    except DatasetError:
        raise
    except DAMAGE as e:
        reason = f"{type(e).__name__}: {e}"
        raise DatasetError(f"{path}: is not a manifest ({printable(reason)[:200]})") from None


def problem_of_form(raw: bytes) -> str:
    """Return how a manifest differs from the form that `generate` writes; empty if it does not.

    Parsing does not show these differences: duplicate keys or files, spaces, and the order.
    """
    document = json.loads(raw)
    expected = ["schema_version", "dataset_version", "content_sha256", "made_by", "inputs", "files"]
    if "performance_limits" in document and document["dataset_version"] == CUSTOM:
        # Only the manifest of maneuvers to which eq. (1) applies contains their limits.
        expected.insert(-1, "performance_limits")
    names = [str(f["file"]) for f in document.get("files", ())]
    if list(document) != expected:
        return f"found the entries {', '.join(document):.200}, expected {', '.join(expected)}"
    if raw != as_json(document):
        return "the layout of the text is not the one that 'heyoka-bike generate' writes"
    if sorted(set(names)) != names:
        return "the files are not listed in alphabetical order, or one is listed twice"
    return ""


def check_published(folder: str | Path) -> Manifest:
    """Return the manifest of a folder; reject any other dataset than the latest published one.

    Raises
    ------
    DatasetError
        The manifest is missing or a different one.
    """
    manifest = read_manifest(folder)
    if manifest.sha256 != PUBLISHED_MANIFEST_SHA256:
        raise DatasetError(
            f"{folder}: the manifest is not that of the published dataset {PUBLISHED_VERSION}; "
            "to use your own dataset, name its folder"
        )
    return manifest


def read_file(folder: str | Path, name: str, manifest: Manifest) -> bytes:
    """Return the contents of a file of the dataset, checked against the manifest.

    Raises
    ------
    DatasetError
        The file is not in the manifest, missing, or differs from it.
    """
    if name not in manifest.files:
        raise DatasetError(f"{folder}: {MANIFEST} has no entry for {name}")
    try:
        return contents(Path(folder), name, *manifest.files[name])
    except MemberError as e:
        if e.is_of_manifest:
            raise DatasetError(f"{Path(folder) / MANIFEST}: {e}") from None
        if e.is_readable:
            raise DatasetError(
                f"{Path(folder) / name}: does not match {MANIFEST} ({e}): the file is damaged or "
                "'heyoka-bike generate' was interrupted; run it again"
            ) from None
        raise DatasetError(f"{Path(folder) / name}: {e}") from None


class MemberError(DatasetError):
    """A file differs from its entry in the manifest; the message does not name the file.

    Attributes
    ----------
    size : int
        Length of the file, as far as it is known.
    is_readable : bool
        True if the file exists and can be read.
    is_of_manifest : bool
        True if the entry of the manifest is wrong.
    """

    def __init__(
        self, message: str, size: int = 0, *, is_readable: bool = False,
        is_of_manifest: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(message)
        self.size, self.is_readable, self.is_of_manifest = size, is_readable, is_of_manifest


_INSIDE = re.compile(r"[\w-][\w.-]*(/[\w-][\w.-]*)?")
"""Names of files in the folder of a dataset or in a direct subfolder."""


def contents(folder: Path, name: str, size: int, digest: str) -> bytes:
    """Return the contents of a file, after checking length and hash against the manifest.

    Raises
    ------
    MemberError
        The contents differ from the manifest, or there is no such file.
    """
    if not _INSIDE.fullmatch(name) or name == MANIFEST:
        said = f"lists the file {name!r:.60}, expected a name inside the folder"
        raise MemberError(said, is_of_manifest=True)
    try:
        path = _inside(folder, name)
        found = path.stat().st_size
        # Do not read a regular file of the wrong length. `read_regular` rejects a path that is not
        # a regular file.
        is_read = found == size or not path.is_file()
        data = read_regular(path, size) if is_read else b""
    except FileNotFoundError:
        raise MemberError("is missing") from None
    except (OSError, ValueError) as e:
        raise MemberError(f"cannot be read: {getattr(e, 'strerror', None) or e}") from None
    if len(data) != size:
        raise MemberError(f"found {found} bytes, expected {size}", found, is_readable=True)
    if (other := sha256(data)) != digest:
        said = f"found sha256 {other[:12]}..., expected {digest:.12}..."
        raise MemberError(said, size, is_readable=True)
    return data


def read_inside(folder: Path, name: str, most: int) -> bytes:
    """Return the contents of a regular file in a folder, of at most `most` bytes.

    Raises
    ------
    OSError, ValueError
        There is no such file, or a link to it leads out of the folder.
    """
    return read_regular(_inside(folder, name), most)


def _inside(folder: Path, name: str) -> Path:
    """Return the path of a file in a folder, without following a link out of the folder.

    The folders of the package are an exception, because some installers make every file a link.
    """
    if folder.is_relative_to(reference_folder()):
        return folder / name
    return path_inside(folder, name)


def load_file(folder: str | Path | None, name: str) -> tuple[Path, Manifest, bytes]:
    """Check and return the folder, manifest and one file of a dataset (default: the published one).

    Raises
    ------
    DatasetError
        The dataset is missing, incomplete or damaged, or the published one does not have the hash
        that this version of the package knows.
    """
    where = reference_folder() if folder is None else Path(folder)
    manifest = check_published(where) if folder is None else read_manifest(where)
    return where, manifest, read_file(where, name, manifest)


@contextmanager
def reading(path: Path, what: str) -> Iterator[None]:
    """Convert errors of reading an HDF5 file to a message of one line.

    Raises
    ------
    DatasetError
        The block cannot read the file as `what`, for example "a candidate file".
    """
    try:
        yield
    except NotCertifiedError:
        raise
    except DatasetError as e:
        raise DatasetError(f"{path}: {e}") from None
    except DAMAGE as e:
        raise DatasetError(f"{path}: is not {what} ({printable(str(e))[:200]})") from None


def write_set(folder: str | Path, files: Mapping[str, bytes], manifest: bytes) -> list[str]:
    """Write the files of a dataset, the manifest last; return the names of the changed files.

    Files of equal content are not touched.

    Raises
    ------
    DatasetError
        The folder cannot be written.
    """
    return write_files(folder, {**dict(sorted(files.items())), MANIFEST: manifest})


def write_files(folder: str | Path, files: Mapping[str, bytes]) -> list[str]:
    """Write the files whose content changed, in the given order; return their names.

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
    """Return the SHA-256 in hexadecimal."""
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
