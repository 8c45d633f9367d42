"""What an unfinished run has finished, in a folder beside the one that it writes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError
from heyoka_bike.system.versions import versions

SUFFIX = ".unfinished"
_LOCK = "lock"


@contextmanager
def unfinished(folder: Path) -> Iterator[Unfinished]:
    """Keep results beside a folder, while nobody else does.

    Raises
    ------
    InputError
        Another run writes the folder, or there is no place beside it.
    """
    # Installed with what makes a set.
    from filelock import FileLock, Timeout

    place = folder.absolute()
    place = place.with_name(place.name + SUFFIX)
    try:
        place.mkdir(parents=True, exist_ok=True)
        with FileLock(place / _LOCK, timeout=0):
            results = Unfinished(place)
            try:
                yield results
            finally:
                if not len(results):
                    # Windows lets nobody remove a file that is open: there the lock does it.
                    with suppress(PermissionError):
                        (place / _LOCK).unlink()
        with suppress(OSError):
            place.rmdir()
    except Timeout:
        raise InputError(
            f"{folder}: found another run that writes it, expected one at a time"
        ) from None
    except PermissionError as e:
        raise InputError(f"{place}: cannot be written: {e.strerror}") from None


class Unfinished:
    """Results by key, each a file."""

    def __init__(self, place: Path) -> None:
        self.place = place

    def at(self, *parts: Any) -> Path:
        """The file of a result that follows from these parts, which JSON can write."""
        # And from versions.
        text = json.dumps([versions(), *parts], sort_keys=True)
        return self.place / hashlib.sha256(text.encode()).hexdigest()

    def clear(self) -> None:
        """Nothing of it is needed any more, nor what other inputs or versions have left."""
        for file in self.place.iterdir():
            if file.name != _LOCK:
                with suppress(OSError):
                    file.unlink()

    def __len__(self) -> int:
        """How many results there are."""
        return sum(file.name != _LOCK for file in self.place.iterdir())
