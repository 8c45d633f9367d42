"""Whether an installation works: packages, the reference that comes with it, a score, a run."""

import platform
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from heyoka_bike.errors import GENERATE, DatasetError, InputError, MissingPackageError
from heyoka_bike.reference.verification.checks import Check, all_passed
from heyoka_bike.system.machine import installed, machine
from heyoka_bike.system.resources import reference_folder
from heyoka_bike.version import __version__

SCHEMA_VERSION = 1
"""Of the JSON report."""

# Name to import, name to install, what it is for.
_REQUIRED = (
    ("numpy", "numpy", "everything"),
    ("h5py", "h5py", "everything"),
    ("flint", "python-flint", "generate, diagnose, verify, certify, linear"),
    ("mpmath", "mpmath", "generate, diagnose, verify, certify, linear"),
    ("rich", "rich", "progress on the screen"),
)
# The extra `generate`: without it everything but integrating works.
_INTEGRATE = (
    ("filelock", "filelock", "generate"),
    ("heyoka", "heyoka", "generate, bench, atlas, verify --rerun, all of diagnose"),
    ("llvmlite", "llvmlite", "simulate, Ensemble, bench"),
)
_OPTIONAL = (("matplotlib", "matplotlib", "plot"), ("scipy", "scipy", "bench, netCDF 3 files"))

MANEUVER = 1
"""That is integrated."""
PRECISIONS = ("binary64", "binary128")


@dataclass(frozen=True, slots=True)
class Selfcheck:
    """What was found out about an installation.

    Attributes
    ----------
    versions : mapping of str to str
        Or why a package cannot be used.
    machine : mapping
    folder, dataset_version, manifest_sha256 : str or None
        Of the reference.
    checks : tuple of Check
    """

    versions: Mapping[str, str]
    machine: Mapping[str, Any]
    folder: str
    dataset_version: str | None
    manifest_sha256: str | None
    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return all_passed(self.checks)

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON values."""
        return {
            "schema_version": SCHEMA_VERSION,
            "versions": dict(self.versions),
            "machine": dict(self.machine),
            "folder": self.folder,
            "dataset_version": self.dataset_version,
            "manifest_sha256": self.manifest_sha256,
            "passed": self.passed,
            "checks": [asdict(c) for c in self.checks],
        }


def selfcheck() -> Selfcheck:
    """Look at the installation; nothing that is missing or broken stops it."""
    versions = {"heyoka_bike": __version__, "python": platform.python_version()}
    checks = []
    for package in (*_REQUIRED, *_INTEGRATE):
        module, name, what = package
        versions[name], is_usable = _usable(module, name)
        if not is_usable:
            passed = None if package in _INTEGRATE else False
            how = f" ({GENERATE})" if package in _INTEGRATE else ""
            message = f"{name}: {versions[name]}; needed for {what}{how}"
            checks.append(Check("package", passed, "", message, {"values": 1, "package": name}))
    for _, name, _ in _OPTIONAL:
        versions[name] = installed(name) or "not installed"
    folder = reference_folder()
    files, dataset_version, sha256 = _reference(folder)
    checks.append(files)
    if files.passed:
        checks.append(_attempt("score", _score, folder))
        checks += _runs(folder)
    return Selfcheck(versions, machine(), str(folder), dataset_version, sha256, tuple(checks))


def _usable(module: str, name: str) -> tuple[str, bool]:
    """Version of a package that can be imported, or why it cannot."""
    try:
        import_module(module)
    except ModuleNotFoundError as e:
        missing = e.name or module
        return f"not installed{'' if missing == module else f': it needs {missing}'}", False
    except Exception as e:  # whatever a broken package raises
        return f"not usable: {type(e).__name__}: {' '.join(str(e).split()):.200}", False
    return installed(name) or "unknown", True


def _reference(folder: Path) -> tuple[Check, str | None, str | None]:
    """The files of the published set against the manifest, and this against its known hash."""
    from heyoka_bike.reference.verification.hashes import check_files

    try:
        files, checks = check_files(folder, is_published=True)
    except DatasetError as e:
        return Check("reference", False, "", str(e), {"values": 0}), None, None
    values = sum(len(data) for data in files.data.values())
    wrong = next((c for c in checks if c.passed is False), None)
    manifest = files.manifest
    if manifest is None or wrong is not None:
        message, file = (wrong.message, wrong.file) if wrong else ("", "")
        return Check("reference", False, file, message, {"values": values}), None, None
    message = (
        f"dataset version {manifest.dataset_version}, {len(files.data)} files, {values} bytes, "
        f"manifest sha256 {manifest.sha256[:12]}..."
    )
    check = Check("reference", True, "", message, {"values": values})
    return check, manifest.dataset_version, manifest.sha256


def _attempt(name: str, look: Callable[..., Check], *arguments: Any) -> Check:
    """A check; not made for want of a package, and failed if anything else goes wrong."""
    try:
        return look(*arguments)
    except (MissingPackageError, ModuleNotFoundError) as e:
        return Check(name, None, "", f"not made: {e}", {"values": 0})
    except Exception as e:  # in an installation of unknown state, anything may
        what = f"{type(e).__name__}: {' '.join(str(e).split()):.300}"
        return Check(name, False, "", what, {"values": 0})


def _score(folder: Path) -> Check:
    """The published text, scored like any other file: it has to be at the floor of its digits."""
    from heyoka_bike import load_reference, read_results, score

    name = "uncontrolled-bicycle.txt"
    report = score(read_results(folder / name), load_reference())
    columns = [(m, c) for m in report.maneuvers for c in m.columns]
    far = [f"{m.maneuver}.{c.key}" for m, c in columns if not c.is_at_floor()]
    message = f"{len(columns)} columns, all at the floor of the digits written"
    if far:
        message = f"{', '.join(far)}: not at the floor of the digits written"
    values = sum(c.values for _, c in columns)
    return Check("score", not far, name, message, {"values": values, "failures": len(far)})


def _runs(folder: Path) -> Iterator[Check]:
    """A maneuver integrated here, in two precisions, against the reference."""
    for precision in PRECISIONS:
        yield _attempt(f"run_{precision}", _run, folder, precision)


def _run(folder: Path, precision: str) -> Check:
    from heyoka_bike.motion.expressions import require_heyoka

    require_heyoka()
    from heyoka_bike.numbers.precision import Precision
    from heyoka_bike.reference.layout import HDF5
    from heyoka_bike.reference.verification.hashes import check_files
    from heyoka_bike.reference.verification.outcome import BOUNDS
    from heyoka_bike.reference.verification.rerun import agreement
    from heyoka_bike.reference.verification.verify import read_content

    files, _ = check_files(folder, is_published=True)
    if files.manifest is None:
        raise DatasetError("the manifest is gone")
    content, _ = read_content(folder, files.manifest, files.data)
    part = content.parts[MANEUVER - 1]
    if not part.files.keys() >= {HDF5, BOUNDS}:
        raise DatasetError("a file of the reference cannot be read")
    try:
        found = agreement(part, Precision.of(precision), lambda stage, t: None)
    except InputError as e:
        # A build of heyoka may lack a format.
        return Check(f"run_{precision}", None, "", f"not made: {e}", {"values": 0})
    worst = min(found.candidate, key=found.candidate.__getitem__)
    message = (
        f"{found.maneuver}: {found.candidate[worst]:.1f} digits or more in every column, at least "
        f"{min(found.promised.values()):.1f} expected; {found.steps} steps, {found.seconds:.1f} s "
        "with building"
    )
    tally = replace(found.tally, check=f"run_{precision}", file="")
    return tally.done(
        message, digits=dict(found.candidate), steps=found.steps, seconds=round(found.seconds, 3)
    )
