"""Conditions of a measurement or result: the computer, and versions of packages and code."""

import hashlib
import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from heyoka_bike.version import __version__

PACKAGES = ("heyoka", "python-flint", "h5py", "numpy", "mpmath")
"""Packages whose version may change digits of a result."""


def machine() -> dict[str, Any]:
    """Return processor, number of cores, operating system and architecture."""
    cpu = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                cpu = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    system = f"{platform.system()} {platform.machine()}"
    return {"cpu": cpu, "cores": os.cpu_count(), "system": system}


def installed(package: str) -> str | None:
    """Return the version of an installed package; None if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


@cache
def versions() -> dict[str, str]:
    """Return versions by package; that of this package includes a hash of its code."""
    found = {name: installed(name) or "none" for name in PACKAGES}
    return {"heyoka_bike": f"{__version__} ({_code()})", **found}


def _code() -> str:
    home = Path(__file__).parents[1]
    hashed = hashlib.sha256()
    for file in sorted(home.rglob("*.py")):
        hashed.update(str(file.relative_to(home)).encode())
        hashed.update(hashlib.sha256(file.read_bytes()).digest())
    return hashed.hexdigest()[:12]
