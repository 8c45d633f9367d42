"""Checks of the manifest of a reference folder, and of the sizes and hashes of its files."""

import json
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from heyoka_bike.errors import DatasetError
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.layout import AFTER_FOLDER, HDF5
from heyoka_bike.reference.manifest import BESIDE_1_5_0, MANIFEST, PUBLISHED_MANIFESTS, Manifest
from heyoka_bike.reference.verification.checks import Check

_INSIDE = re.compile(r"[\w-][\w.-]*(/[\w-][\w.-]*)?")
"""Names of files in the folder of a set, or in one in it."""


@dataclass(frozen=True, slots=True)
class Files:
    """The manifest of a folder and the contents of its intact files.

    Attributes
    ----------
    manifest : Manifest or None
        None if it is not usable.
    data : mapping of str to bytes
        Contents by name of the files that are what the manifest says.
    """

    manifest: Manifest | None
    data: Mapping[str, bytes] = field(default_factory=dict)


def check_files(folder: Path, *, is_published: bool = False) -> tuple[Files, list[Check]]:
    """Compare the files of a folder with its manifest, and the manifest with what is known of it.

    Parameters
    ----------
    folder
    is_published
        True if it has to be the published set; else its own manifest decides.

    Raises
    ------
    DatasetError
        The folder cannot be read, or is no reference set at all.
    """
    try:
        present = sorted(os.listdir(folder))
    except OSError as e:
        raise DatasetError(f"{folder}: cannot be read: {e.strerror or e}") from None
    try:
        manifest = manifest_file.read_manifest(folder)
        raw = (folder / MANIFEST).read_bytes()
    except (DatasetError, OSError) as e:
        # A folder that holds this file is a set, whatever is wrong with its manifest.
        if HDF5 not in present:
            raise DatasetError(str(e)) from None
        return Files(None), [Check("manifest", False, MANIFEST, str(e), {"values": 0})]
    checks = [_form(raw), _known(manifest, is_published=is_published)]
    data, expected = {}, dict(manifest.files)
    if manifest.sha256 == PUBLISHED_MANIFESTS["1.5.0"] and (
        is_published or AFTER_FOLDER in present
    ):
        expected |= BESIDE_1_5_0
    for name, size_and_digest in expected.items():
        check, content = _file(folder, name, *size_and_digest)
        checks.append(check)
        if content is not None:
            data[name] = content
    checks.append(_extra(sorted(_others(folder, {*expected, MANIFEST}))))
    return Files(manifest, data), checks


def _form(raw: bytes) -> Check:
    """The manifest is as `generate` writes it: nothing else could go unnoticed in it."""
    document = json.loads(raw)
    expected = ["schema_version", "dataset_version", "content_sha256", "made_by", "inputs", "files"]
    names = [str(f["file"]) for f in document.get("files", ())]
    problem = ""
    if list(document) != expected:
        problem = f"found the entries {', '.join(document)}; expected {', '.join(expected)}"
    elif raw != (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode():
        problem = "is not written the way 'heyoka-bike generate' writes it"
    elif sorted(set(names)) != names:
        problem = "its files are not in order, each once"
    message = problem or "is written the way 'heyoka-bike generate' writes it"
    return Check("manifest", not problem, MANIFEST, message, {"values": len(raw)})


def _known(manifest: Manifest, *, is_published: bool) -> Check:
    """The manifest of a published set is the one whose hash the package knows."""
    version, found = manifest.dataset_version, manifest.sha256
    short, last = f"sha256 {found[:12]}...", manifest_file.PUBLISHED_VERSION
    passed = True
    if found == manifest_file.PUBLISHED_MANIFEST_SHA256:
        message = f"{short} is that of the published set {version}"
    elif found == PUBLISHED_MANIFESTS.get(version) and not is_published:
        message = (
            f"{short} is that of the published set {version}; this version of the package has "
            f"{last}"
        )
    elif version == manifest_file.CUSTOM and not is_published:
        message = f"a set of your own: the package knows no hash to expect (found {short})"
    else:
        passed = False
        expected = f"{manifest_file.PUBLISHED_MANIFEST_SHA256[:12]}... of the published set {last}"
        message = f"found {short} of dataset version {version!r:.40}, expected {expected}"
    return Check("manifest_hash", passed, MANIFEST, message, {"values": 1, "sha256": found})


def _file(folder: Path, name: str, size: int, digest: str) -> tuple[Check, bytes | None]:
    """The check of a file, and its contents if they are what the manifest says."""
    path = folder / name
    about, passed, values, data = name, False, 0, None
    try:
        if not _INSIDE.fullmatch(name) or name == MANIFEST:
            about = MANIFEST
            message = f"lists the file {name!r:.60}, expected a name inside the folder"
        # The size is looked at first: what is far too long is not read.
        elif (found := path.stat().st_size) != size:
            values, message = found, f"found {found} bytes, expected {size}"
        elif (other := manifest_file.sha256(raw := path.read_bytes())) != digest:
            values, message = size, f"found sha256 {other[:12]}..., expected {digest[:12]}..."
        else:
            passed, values, data = True, size, raw
            message = f"sha256 {digest[:12]}... as in the manifest"
    except FileNotFoundError:
        message = "is missing"
    except (OSError, ValueError) as e:
        message = f"cannot be read: {getattr(e, 'strerror', None) or e}"
    return Check("file", passed, about, message, {"values": values}), data


def _others(folder: Path, known: Collection[str], inside: str = "") -> Iterator[str]:
    """Yield the names of unknown files; of a folder with no known file, the name of the folder."""
    where = folder / inside
    for entry in os.listdir(where) if where.is_dir() else ():
        name = inside + entry
        if any(other.startswith(f"{name}/") for other in known):
            yield from _others(folder, known, f"{name}/")
        elif name not in known:
            yield name


def _extra(extra: Sequence[str]) -> Check:
    message = "no other files"
    if extra:
        shown = ", ".join(f"{name!r:.60}" for name in extra[:5])
        message = f"also there, not part of the set: {shown}" + (", ..." if extra[5:] else "")
    evidence = {"values": len(extra), "files": list(extra)}
    return Check("other_files", True, MANIFEST, message, evidence)
