"""Check an installation: its packages and reference, a score, and an integration."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import GENERATE, DatasetError, InputError, MissingPackageError
from heyoka_bike.reference.verification.outcome import Check, all_passed
from heyoka_bike.system.machine import installed, machine
from heyoka_bike.system.resources import reference_folder
from heyoka_bike.version import __version__

if TYPE_CHECKING:
    from heyoka_bike.reference.manifest import Manifest

SCHEMA_VERSION = 1
"""Version of the JSON report."""

# The required packages, each with its purpose.
_REQUIRED_PACKAGES = {
    "numpy": "everything",
    "h5py": "everything",
    "python-flint": "generate, diagnose, verify, certify, linear",
    "mpmath": "generate, diagnose, verify, certify, linear",
    "rich": "progress on the screen",
    "threadpoolctl": "diagnose",
}
# Packages of the extra `generate`, each with its purpose. Without them everything but integration
# works.
_INTEGRATE = {
    "heyoka": "generate, bench, atlas, verify --rerun, all of diagnose",
    "llvmlite": "simulate, Ensemble, bench",
}
_OPTIONAL_PACKAGES = ("matplotlib", "scipy")

MANEUVER = 1
"""Number of the maneuver that is integrated."""
PRECISIONS = ("binary64", "binary128")


@dataclass(frozen=True, slots=True)
class Selfcheck:
    """Result of checking an installation.

    Attributes
    ----------
    versions : mapping of str to str
        Versions by package, or the reason why a package cannot be used.
    machine : mapping
    folder, dataset_version, manifest_sha256 : str or None
        Folder, version and hash of the reference.
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
        """True if no check failed."""
        return all_passed(self.checks)

    def as_dict(self) -> dict[str, Any]:
        """Return the result of the checks as JSON values."""
        found = asdict(self)
        checks = list(found.pop("checks"))
        return {"schema_version": SCHEMA_VERSION, **found, "passed": self.passed, "checks": checks}


def selfcheck() -> Selfcheck:
    """Check the installation; missing or broken parts do not stop the check."""
    versions = {"heyoka_bike": __version__, "python": platform.python_version()}
    checks = []
    for name, use in (_REQUIRED_PACKAGES | _INTEGRATE).items():
        versions[name], is_usable = _usable(name)
        if not is_usable:
            passed, how = (None, f" ({GENERATE})") if name in _INTEGRATE else (False, "")
            message = f"{name}: {versions[name]}; needed for {use}{how}"
            checks.append(Check("package", passed, "", message, {"values": 1, "package": name}))
    for name in _OPTIONAL_PACKAGES:
        versions[name] = installed(name) or "not installed"
    folder = reference_folder()
    found, manifest, data = _reference(folder)
    checks.append(found)
    if manifest is None:
        return Selfcheck(versions, machine(), str(folder), None, None, tuple(checks))
    checks.append(_attempt("score", _score, folder))
    checks += [_attempt(f"run_{x}", _run, folder, manifest, data, x) for x in PRECISIONS]
    return Selfcheck(
        versions, machine(), str(folder), manifest.dataset_version, manifest.sha256, tuple(checks)
    )


def _usable(name: str) -> tuple[str, bool]:
    """Return the version of a package and True, or why it cannot be imported and False."""
    module = "flint" if name == "python-flint" else name
    try:
        import_module(module)
    except ModuleNotFoundError as e:
        missing = e.name or module
        return f"not installed{'' if missing == module else f': it needs {missing}'}", False
    except Exception as e:  # a broken package may raise anything
        return f"not usable: {type(e).__name__}: {' '.join(str(e).split()):.200}", False
    return installed(name) or "unknown", True


def _reference(folder: Path) -> tuple[Check, Manifest | None, Mapping[str, bytes]]:
    """Compare the published dataset's files with its manifest, and the manifest with its hash.

    If there are no differences, also return the manifest and the contents of the files.
    """
    from heyoka_bike.reference.verification.verify import check_files

    try:
        manifest, data, checks = check_files(folder, is_published=True)
    except DatasetError as e:
        return Check("reference", False, "", str(e), {"values": 0}), None, {}
    values = sum(map(len, data.values()))
    wrong = [c for c in checks if c.passed is False]
    if manifest is None or wrong:
        said = wrong[0].file, wrong[0].message
        return Check("reference", False, *said, {"values": values}), None, {}
    message = (
        f"dataset version {manifest.dataset_version}, {len(data)} files, {values} bytes, "
        f"manifest sha256 {manifest.sha256[:12]}..."
    )
    return Check("reference", True, "", message, {"values": values}), manifest, data


def _attempt(name: str, look: Callable[..., Check], *arguments: Any) -> Check:
    """Run a check; it is skipped if a package is missing, and fails on any other error."""
    try:
        return look(*arguments)
    except (MissingPackageError, ModuleNotFoundError) as e:
        return Check(name, None, "", f"not made: {e}", {"values": 0})
    except Exception as e:  # an installation in an unknown state may raise anything
        what = f"{type(e).__name__}: {' '.join(str(e).split()):.300}"
        return Check(name, False, "", what, {"values": 0})


def _score(folder: Path) -> Check:
    """Score the published text like any result file; its errors must be due to rounding only."""
    from heyoka_bike import load_reference, read_results, score

    name = "uncontrolled-bicycle.txt"
    report = score(read_results(folder / name), load_reference())
    columns = [(m, c) for m in report.maneuvers for c in m.columns]
    far = [f"{m.maneuver}.{c.key}" for m, c in columns if not c.is_at_floor()]
    message = f"{len(columns)} columns, all as exact as the digits written allow"
    if far:
        message = f"{', '.join(far)}: less exact than the digits written allow"
    values = sum(c.values for _, c in columns)
    return Check("score", not far, name, message, {"values": values, "failures": len(far)})


def _run(folder: Path, manifest: Manifest, data: Mapping[str, bytes], precision: str) -> Check:
    """Integrate a maneuver on this machine, and compare the result with the reference."""
    from heyoka_bike.motion.heyoka_adapter import require_heyoka

    require_heyoka()
    from heyoka_bike.numbers.precision import Precision
    from heyoka_bike.reference.verification.numbers import agreement
    from heyoka_bike.reference.verification.verify import read_content

    content, _ = read_content(folder, manifest, data)
    part = content.parts[MANEUVER - 1]
    try:
        found = agreement(part, Precision.of(precision), lambda stage, t: None)
    except InputError as e:
        # Some builds of heyoka do not support every number format.
        return Check(f"run_{precision}", None, "", f"not made: {e}", {"values": 0})
    worst = min(found.candidate, key=found.candidate.__getitem__)
    message = (
        f"{found.maneuver}: {found.candidate[worst]:.1f} digits or more in every column, at least "
        f"{min(found.promised.values()):.1f} expected; {found.steps} steps, {found.seconds:.1f} s "
        "including compilation"
    )
    tally = replace(found.tally, check=f"run_{precision}", file="")
    return tally.done(
        message, digits=dict(found.candidate), steps=found.steps, seconds=round(found.seconds, 3)
    )
