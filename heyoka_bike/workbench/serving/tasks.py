"""Tasks on uploaded files; each runs in its own process, which ends if it exceeds limits.

The process reads ``files`` in a folder and writes ``made`` in the same folder. `Limits` contains
the limits of the server.
"""

import errno
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from heyoka_bike.errors import BicycleError, Exit, InputError, printable
from heyoka_bike.scoring.reading.given import results_of
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.series import score_files
from heyoka_bike.showing.formats import output
from heyoka_bike.showing.wording.finding_text import sentences
from heyoka_bike.showing.wording.origin_text import origin
from heyoka_bike.system.files import write_output
from heyoka_bike.system.jobs import ProcessLimits, reporting

_MB = 1_000_000


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a request, and of the storage of results.

    Attributes
    ----------
    upload : int
        Maximum size of a request [bytes].
    files
        Maximum number of result files in a request.
    score_seconds, diagnose_seconds : float
        Limits of a task, both for processor time and for elapsed time [s].
    upload_seconds : float
        Time for a request to arrive [s].
    memory : int
        Memory of the process of a task [bytes].
    workers
        Number of tasks at once.
    waiting
        Maximum number of waiting tasks.
    kept_seconds : float
        Time for which a result is stored [s].
    kept
        Maximum number of results; the oldest are removed first.
    kept_bytes : int
        Maximum size of all results and their files [bytes].
    arriving_bytes : int
        Maximum size of all requests that are not stored yet [bytes].
    field : int
        Maximum size of a form field that is not a file [bytes].
    page_seconds : float
        Time that a page waits for its task before it shows progress [s].
    look_seconds, sweep_seconds : float
        Intervals between checks that a waiting client is connected, and between sweeps of the
        storage [s].
    has_diagnosis
        True if the server offers ``diagnose``.
    """

    upload: int = 100 * _MB
    files: int = 20
    score_seconds: float = 60.0
    diagnose_seconds: float = 180.0
    upload_seconds: float = 600.0
    memory: int = 2000 * _MB
    workers: int = 2
    waiting: int = 100
    kept_seconds: float = 86400.0
    kept: int = 1000
    kept_bytes: int = 4000 * _MB
    arriving_bytes: int = 2000 * _MB
    field: int = 10_000_000
    page_seconds: float = 1.5
    look_seconds: float = 0.5
    sweep_seconds: float = 5.0
    has_diagnosis: bool = True

    def of_process(self, is_long: bool) -> ProcessLimits:
        """Return the limits of the process of a task; `is_long` is true for a diagnosis."""
        seconds = self.diagnose_seconds if is_long else self.score_seconds
        return ProcessLimits(seconds, self.memory)


Kind = Literal["score", "diagnose", "replay"]

FILES, MADE = "files", "made"
NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""Error numbers of a full disk, or of an exceeded quota."""
FULL = "the server's disk is full"
_STEMS: dict[Kind, str] = {"score": "report", "diagnose": "diagnosis", "replay": "replay"}
RENDERED = {"html": ".html", "json": ".json", "csv": ".csv", "junit": ".xml"}
"""Formats of a report, and the suffixes of their files."""

_LONGEST_LINE_TOLD = 500


@dataclass(frozen=True, slots=True)
class Task:
    """A request to score, diagnose or replay uploaded files.

    Attributes
    ----------
    kind
    folder : Path
        Folder that contains `FILES`; the task writes `MADE` there.
    files
        Names of the files, in the order of the request.
    maneuver
        Maneuver of a file with a single maneuver, if it was given.
    columns
        Names of the columns, if they were given.
    steps, tolerances
        Steps or tolerances of runs of one program, one for each file.
    names
        Names of the programs, one for each file.
    require
        Requirements to judge in addition.
    """

    kind: Kind
    folder: Path
    files: tuple[str, ...]
    maneuver: int | None = None
    columns: tuple[str, ...] | None = None
    steps: tuple[float, ...] | None = None
    tolerances: tuple[float, ...] | None = None
    names: tuple[str, ...] | None = None
    require: tuple[str, ...] = ()

    def made(self, suffix: str) -> Path:
        """Return the path of the file with this suffix that the task writes."""
        return self.folder / MADE / f"{_STEMS[self.kind]}{suffix}"


@dataclass(frozen=True, slots=True)
class TaskEnding:
    """How a task has ended.

    Attributes
    ----------
    state
    message
        Reason for a rejection or failure: one line for the user.
    code : int
        Exit code of the command.
    is_one_run
        True if the files belong to one run, which can be diagnosed.
    diagnosis
        Lines on the cause.
    is_full
        True if the task failed because the disk is full.
    """

    state: Literal["done", "refused", "failed"]
    message: str = ""
    code: int = 0
    is_one_run: bool = False
    diagnosis: Sequence[str] = ()
    is_full: bool = False


def is_long(kind: Kind) -> bool:
    """True if a task of this kind may take minutes."""
    return kind == "diagnose"


def work(task: Task, memory: int) -> dict[str, Any]:
    """Run a task in the present process; return the fields of a `TaskEnding`.

    Parameters
    ----------
    task
    memory
        Memory limit of the process [bytes].
    """
    try:
        os.chdir(task.folder / FILES)
        return asdict(_carry_out(task))
    except BicycleError as e:
        if isinstance(e.__context__, OSError) and e.__context__.errno in NO_ROOM:
            return asdict(TaskEnding("failed", FULL, Exit.INPUT, is_full=True))
        line = printable(" ".join(str(e).split()))
        return asdict(TaskEnding("refused", line[:_LONGEST_LINE_TOLD], e.exit_code))
    except MemoryError:
        said = f"needs more than {memory // 1_000_000} MB of memory, expected less"
        return asdict(TaskEnding("refused", said, Exit.INPUT))


def _carry_out(task: Task) -> TaskEnding:
    from heyoka_bike.workbench.serving.preload import REFERENCE

    report = reporting.get()
    results = results_of(
        list(task.files), len(REFERENCE), maneuver=task.maneuver, columns=task.columns
    )
    if task.kind == "replay":
        if len(results) > 1:
            raise InputError(f"found {len(results)} files, expected one to replay")
        from heyoka_bike.workbench.replay.page import render
        from heyoka_bike.workbench.replay.scenes import replay

        page = render(replay(REFERENCE, results[0], task.maneuver), task.files[0])
        write_output(task.made(".html"), page.encode())
        return TaskEnding("done")
    scored = score_files(
        results,
        REFERENCE,
        steps=task.steps,
        tolerances=task.tolerances,
        names=task.names,
        require=task.require,
    )
    if task.kind == "diagnose":
        if isinstance(scored, Series):
            raise InputError(f"found {len(scored.runs)} runs, expected the files of one run")
        from heyoka_bike.scoring.diagnosis.diagnose import diagnosed

        scored = diagnosed(scored, REFERENCE, lambda share: report(task.kind, round(share, 3)))
    made = origin((task.kind, *task.files))
    for name, suffix in RENDERED.items():
        write_output(task.made(suffix), output.render(scored, name, made).encode())
    if isinstance(scored, Series):
        return TaskEnding("done")
    said = tuple(map(printable, sentences(scored.diagnosis)))
    return TaskEnding("done", is_one_run=True, diagnosis=said)
