"""Compiled code kept on the disk between processes.

One file holds one object: a line that says what it is, the SHA-256 of the rest, and the rest. A
file that is damaged, of another key, or another user's is taken for absent, and so is everything if
the folder cannot be used. Files are written beside their place under a name of their own and
renamed, so that processes that write the same one at the same time do no harm.

The folder is `HEYOKA_BIKE_CACHE` (empty: no cache), else ``heyoka_bike`` in `XDG_CACHE_HOME` or in
``~/.cache``.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import pickle
import platform
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from heyoka_bike.version import __version__

_HEAD = b"heyoka_bike compiled code 1\n"
_SUFFIX = ".code"
_MOST_FILES = 64  # of a few megabytes each; the oldest go first
# What the compiled code follows from, besides what its key says.
_SOURCES = (
    "numbers/arithmetic", "bicycle/equations/constants", "motion/integrate", "motion/expressions",
    "bicycle/equations/kinematics", "bicycle/equations/model", "bicycle/equations/outputs",
    "motion/fast/taylor_code",
)  # fmt: skip


def cached(description: Mapping[str, Any], build: Callable[[], Any]) -> Any:
    """The object of a description, from the cache or built and put there.

    Parameters
    ----------
    description
        What the object depends on, in types of JSON. Versions of this package and its equations, of
        heyoka and Python, and the features of the processor are added to it.
    build
        Makes the object, which can be pickled.
    """
    folder = cache_folder()
    if folder is None:
        return build()
    key = _key(description)
    path = folder / (hashlib.sha256(key).hexdigest() + _SUFFIX)
    found = _read(path, key)
    if found is None:
        found = build()
        _write(path, key, pickle.dumps(found))
    return found


def cache_folder() -> Path | None:
    """Folder of the cache, or None for no cache."""
    chosen = os.environ.get("HEYOKA_BIKE_CACHE")
    if chosen is not None:
        return Path(chosen) if chosen else None
    base = os.environ.get("XDG_CACHE_HOME", "")
    # The specification has relative paths ignored.
    if os.path.isabs(base):
        return Path(base) / "heyoka_bike"
    try:
        return Path.home() / ".cache" / "heyoka_bike"
    except RuntimeError:
        return None


def _key(description: Mapping[str, Any]) -> bytes:
    from heyoka_bike.motion.expressions import require_heyoka

    home = Path(__file__).parent.parent.parent
    equations = hashlib.sha256(b"".join((home / f"{n}.py").read_bytes() for n in _SOURCES))
    whole = {
        **description,
        "heyoka_bike": __version__,
        "equations": equations.hexdigest(),
        "heyoka": require_heyoka().__version__,
        "python": platform.python_version(),
        "processor": _processor(),
    }
    return json.dumps(whole, sort_keys=True).encode()


def _processor() -> list[str]:
    """What compiled code may depend on: the architecture and the processor's instructions."""
    features = ""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith(("flags", "Features")):
                features = line.partition(":")[2].strip()
                break
    return [platform.machine(), features]


def _read(path: Path, key: bytes) -> Any:
    """The object in a file, None unless the file is whole and of this key."""
    try:
        with path.open("rb") as file:
            # Unpickling runs what a file says: one that another user put here is not believed.
            if os.fstat(file.fileno()).st_uid != os.geteuid():
                return None
            data = file.read()
    except OSError:
        return None
    body = data[len(_HEAD) + hashlib.sha256().digest_size :]
    if data != _HEAD + hashlib.sha256(body).digest() + body:
        return None
    found_key, _, pickled = body.partition(b"\n")
    return pickle.loads(pickled) if found_key == key else None


def _write(path: Path, key: bytes, pickled: bytes) -> None:
    """Put a file in its place, if that is possible."""
    body = key + b"\n" + pickled
    with contextlib.suppress(OSError):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        number, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
        try:
            with open(number, "wb") as file:
                file.write(_HEAD + hashlib.sha256(body).digest() + body)
            os.replace(name, path)
        except BaseException:
            os.unlink(name)
            raise
        files = sorted(path.parent.glob("*" + _SUFFIX), key=lambda x: x.stat().st_mtime)
        for old in files[:-_MOST_FILES]:
            old.unlink(missing_ok=True)
