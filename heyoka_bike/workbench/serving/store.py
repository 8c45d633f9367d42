"""Store the files of each result on the server, until they expire."""

import re
import secrets
import shutil
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import time
from unicodedata import normalize

from heyoka_bike.workbench.serving.queue import BusyError, QueuedTask
from heyoka_bike.workbench.serving.tasks import FILES, Kind, Limits, Task

# Maximum length of the name of a stored file, in characters and in bytes. File systems allow 255
# bytes.
_LONGEST_FILE_NAME, _MOST_NAME_BYTES = 80, 240
_NO_NAME = "results.txt"
# Time after which a client may try again if too many bytes are arriving [s].
_ROOM_IN = 5
_UNUSUAL = re.compile(r"[^\w .()+=,@~-]")


@dataclass(eq=False, slots=True)
class StoredResult:
    """A stored result: its files, and the tasks that were requested for them.

    Attributes
    ----------
    key
        Key in the address of the result; anybody who knows it may see the result.
    until : float
        Time when the result is removed [s since 1970].
    task
        Task that scores the files.
    has_diagnosis
        True if the result can be diagnosed here.
    jobs
        Requested tasks by kind.
    """

    key: str
    until: float
    task: Task
    has_diagnosis: bool
    jobs: dict[Kind, QueuedTask]

    def of(self, kind: Kind) -> Task:
        """Return the task of another kind for the same files."""
        return replace(self.task, kind=kind)


class ResultStore:
    """The stored results, each in its own subfolder of a folder.

    Parameters
    ----------
    folder
        Folder for the server's exclusive use.
    limits
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder, self._limits = folder, limits
        self._results: dict[str, StoredResult] = {}
        # Size of the files of each request that has not become a stored result yet, by folder
        # [bytes].
        self._arrived: dict[Path, int] = {}

    def __len__(self) -> int:
        return len(self._results)

    def is_full(self) -> bool:
        """True if the disk has no room for another request of the maximum size."""
        return shutil.disk_usage(self._folder).free < self._limits.upload

    def room(self) -> Path:
        """Create a new folder for the files of a request."""
        folder = self._folder / secrets.token_urlsafe(12)
        self._arrived[folder] = 0
        (folder / FILES).mkdir(parents=True, mode=0o700)
        return folder

    def grow(self, folder: Path, size: int) -> None:
        """Count bytes that have arrived for a folder that `room` created.

        Raises
        ------
        BusyError
            All requests together exceed their limit.
        """
        self._arrived[folder] += size
        if sum(self._arrived.values()) > self._limits.arriving_bytes:
            raise BusyError(_ROOM_IN)

    def drop(self, folder: Path) -> None:
        """Remove a folder that `room` created, if it does not become a stored result."""
        _remove(folder)
        self._arrived.pop(folder, None)

    def keep(self, job: QueuedTask) -> StoredResult:
        """Make the folder of a task, which `room` created, a stored result until it expires."""
        task, limits = job.task, self._limits
        until = time() + limits.kept_seconds
        result = StoredResult(task.folder.name, until, task, limits.has_diagnosis, {task.kind: job})
        self._results[result.key] = result
        self._arrived.pop(task.folder, None)
        return result

    def get(self, key: str) -> StoredResult | None:
        """Return the result with this key; None if there is none, or if it has expired."""
        result = self._results.get(key)
        return None if result is None or result.until < time() else result

    def remove(self, result: StoredResult) -> None:
        """Remove a result, and cancel its tasks."""
        for job in list(result.jobs.values()):
            job.cancel()
        self._results.pop(result.key, None)
        _remove(result.task.folder)

    def sweep(self) -> None:
        """Remove expired results, and the oldest ones if there are too many."""
        sizes = {result: _size(result.task.folder) for result in list(self._results.values())}
        size = sum(sizes.values())
        for result in sorted(sizes, key=lambda result: result.until):
            if (
                result.until >= time()
                and len(self) <= self._limits.kept
                and size <= self._limits.kept_bytes
            ):
                break
            size -= sizes[result]
            self.remove(result)
        # A process may still write files after its result was removed. So delete folders without a
        # result.
        for folder in self._folder.iterdir():
            # The order of the checks matters: `keep` adds the result before it removes the folder
            # from `_arrived`.
            if folder not in self._arrived and folder.name not in self._results:
                _remove(folder)


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)


def file_name(given: str, taken: set[str]) -> str:
    """Return a safe and unique name for an uploaded file, similar to the given one."""
    name = normalize("NFC", given.replace("\\", "/").rsplit("/", 1)[-1])
    name = _UNUSUAL.sub("_", name).strip(" .-_~")[-_LONGEST_FILE_NAME:]
    name = name.encode()[-_MOST_NAME_BYTES:].decode(errors="ignore").lstrip(" .-_~") or _NO_NAME
    stem, dot, suffix = name.rpartition(".")
    if not dot:
        stem, suffix = name, ""
    found, n = name, 1
    while found.lower() in taken:
        n += 1
        found = f"{stem} ({n}){dot}{suffix}"
    taken.add(found.lower())
    return found


def _size(folder: Path) -> int:
    size = 0
    # Another thread may remove a file in the meantime.
    with suppress(OSError):
        for path in folder.rglob("*"):
            with suppress(OSError):
                size += path.stat().st_size
    return size
