"""What results depend on besides their inputs: versions of packages, and of this one's code."""

import hashlib
from functools import cache
from pathlib import Path

from heyoka_bike.system.machine import installed
from heyoka_bike.version import __version__

PACKAGES = ("heyoka", "python-flint", "h5py", "numpy", "mpmath")
"""Those whose version may change a digit."""


@cache
def versions() -> dict[str, str]:
    """Version by package; this one's has a hash of its code beside it."""
    found = {name: installed(name) or "none" for name in PACKAGES}
    return {"heyoka_bike": f"{__version__} ({_code()})", **found}


def _code() -> str:
    home = Path(__file__).parents[1]
    hashed = hashlib.sha256()
    for file in sorted(home.rglob("*.py")):
        hashed.update(str(file.relative_to(home)).encode())
        hashed.update(hashlib.sha256(file.read_bytes()).digest())
    return hashed.hexdigest()[:12]
