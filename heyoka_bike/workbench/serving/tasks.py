"""Work on uploaded files, in a process of its own that is ended when it takes too much.

The process reads ``files`` in a folder and writes ``made`` beside them. `Limits` are those of one
request to a server.
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
from heyoka_bike.showing.sayings import sentences
from heyoka_bike.showing.wording import origin
from heyoka_bike.system.files import write_output
from heyoka_bike.system.jobs import ProcessLimits, reporting

_MB = 1_000_000


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of one request, and of what is stored of it.

    Attributes
    ----------
    upload : int
        Of all that one request holds [bytes].
    files
        Result files in one request.
    score_seconds, diagnose_seconds : float
        For a piece of work, processor time and time on the clock [s].
    upload_seconds : float
        For a request to arrive [s].
    memory : int
        Of the process of a piece of work [bytes].
    workers
        Pieces of work at once.
    waiting
        That wait for one of them.
    kept_seconds : float
        How long a result is kept [s].
    kept
        Results at once; the oldest make room.
    kept_bytes : int
        Of all results and their files [bytes].
    arriving_bytes : int
        Of all requests that are not kept yet [bytes].
    field : int
        Of a field of a form that is no file [bytes].
    page_seconds : float
        How long a page waits for its work before it says that it waits [s].
    look_seconds, sweep_seconds : float
        Between two looks whether a waiting client is there, and between two sweeps of what is
        stored [s].
    has_diagnosis
        Whether ``diagnose`` is offered.
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
        """Of the process of a piece of work; a diagnosis is long."""
        seconds = self.diagnose_seconds if is_long else self.score_seconds
        return ProcessLimits(seconds, self.memory)


Kind = Literal["score", "diagnose", "replay"]

FILES, MADE = "files", "made"
NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""Errors of a disk that is full, or of a quota."""
FULL = "the server's disk is full"
_STEMS: dict[Kind, str] = {"score": "report", "diagnose": "diagnosis", "replay": "replay"}
RENDERED = {"html": ".html", "json": ".json", "csv": ".csv", "junit": ".xml"}
"""Formats of a report, and how the names of their files end."""

_LONGEST_LINE_TOLD = 500


@dataclass(frozen=True, slots=True)
class Task:
    """A piece of work.

    Attributes
    ----------
    kind
    folder : Path
        That holds `FILES`; `MADE` is put there.
    files
        Names in it, in the order in which they were given.
    maneuver
        That a file of one maneuver holds, if that is told.
    columns
        What the columns are, if that is told.
    steps, tolerances
        Of runs of one program, one for each file.
    names
        Of the programs, one for each file.
    require
        Requirements that are judged, too.
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
        """The result in a format with this suffix."""
        return self.folder / MADE / f"{_STEMS[self.kind]}{suffix}"


@dataclass(frozen=True, slots=True)
class TaskEnding:
    """The outcome of a task.

    Attributes
    ----------
    state
    message
        Why it was refused or failed: one line for the user.
    code : int
        Exit code that the command ends with.
    is_one_run
        Whether the files are those of one run, which can be diagnosed.
    diagnosis
        What is said of the cause.
    is_full
        Whether it failed as the disk has no room.
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
    """Carry out a task in a process of its own; gives the parts of an `TaskEnding`.

    Parameters
    ----------
    task
    memory
        That the process is limited to [bytes].
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
            raise InputError(f"found {len(scored.runs)} runs, expected the files of one")
        from heyoka_bike.scoring.diagnosis.diagnose import diagnosed

        scored = diagnosed(scored, REFERENCE, lambda share: report(task.kind, round(share, 3)))
    made = origin((task.kind, *task.files))
    for name, suffix in RENDERED.items():
        write_output(task.made(suffix), output.render(scored, name, made).encode())
    if isinstance(scored, Series):
        return TaskEnding("done")
    said = tuple(map(printable, sentences(scored.diagnosis)))
    return TaskEnding("done", is_one_run=True, diagnosis=said)
