"""What is done with uploaded files, in a process of its own that is ended when it takes too much.

The process reads ``files`` in a folder and writes ``made`` beside them. To its parent it tells
JSON, so that nothing that a file brought about in it is unpickled there.
"""

import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Literal

from heyoka_bike.errors import BicycleError, Exit, InputError, printable
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.reading.given import results_of
from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.scoring.series import score_files
from heyoka_bike.showing.formats import output
from heyoka_bike.showing.formats.origin import origin
from heyoka_bike.system.files import write_output
from heyoka_bike.workbench.serving.limits import Limits, keep_to

Kind = Literal["score", "diagnose", "replay"]

FILES, MADE = "files", "made"
RENDERED = {"html": ".html", "json": ".json", "csv": ".csv", "junit": ".xml"}
"""Formats of a report, and how the names of their files end."""

_LONGEST_LINE = 500


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


def is_long(kind: Kind) -> bool:
    """Whether a piece of work of this kind may take minutes."""
    return kind == "diagnose"


def stem(kind: Kind) -> str:
    """Name of what a piece of work makes, without the suffix."""
    return {"score": "report", "diagnose": "diagnosis", "replay": "replay"}[kind]


def warm() -> None:
    """Load what every piece of work needs, so that each process begins with it."""
    _reference()
    for name in ("array_files", "json_files", "matlab_files", "table_files", "text_table"):
        import_module(f"heyoka_bike.scoring.reading.{name}")
    for name in RENDERED:
        import_module(f"heyoka_bike.showing.formats.{name}")


def work(connection: Connection, task: Task, limits: Limits) -> None:
    """Carry out a task and tell how it went; the process ends with it."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    if hasattr(os, "setsid"):
        # What it starts is ended with it.
        os.setsid()
    keep_to(limits.seconds(is_long(task.kind)), limits.memory)

    def tell(**said: Any) -> None:
        connection.send_bytes(json.dumps(said).encode())

    try:
        os.chdir(task.folder / FILES)
        tell(done=_carry_out(task, lambda share: tell(share=round(share, 3))))
    except BicycleError as e:
        line = printable(" ".join(str(e).split()))
        tell(refused=line[:_LONGEST_LINE], code=int(e.exit_code))
    except MemoryError:
        tell(
            refused=f"needs more than {limits.memory // 1_000_000} MB of memory, expected less",
            code=int(Exit.INPUT),
        )
    except Exception as e:
        tell(failed=fault(e))
    finally:
        connection.close()
        sys.stderr.flush()
        # Nothing that was begun in the process keeps it alive.
        os._exit(0)


def fault(error: BaseException) -> str:
    """What an error is and where it was raised: nothing of what a file holds or is called."""
    place = error.__traceback__
    if place is None:
        return type(error).__name__
    while place.tb_next is not None:
        place = place.tb_next
    file = Path(place.tb_frame.f_code.co_filename).name
    return f"{type(error).__name__} at {file}:{place.tb_lineno}"


@cache
def _reference() -> Reference:
    return load_reference()


def _carry_out(task: Task, progress: Callable[[float], None]) -> dict[str, Any]:
    reference = _reference()
    results = results_of(
        list(task.files), len(reference), maneuver=task.maneuver, columns=task.columns
    )
    if task.kind == "replay":
        if len(results) > 1:
            raise InputError(f"found {len(results)} files, expected one to replay")
        from heyoka_bike.showing.replay.page import render
        from heyoka_bike.showing.replay.scenes import replay

        page = render(replay(reference, results[0], task.maneuver), task.files[0])
        _write(task, ".html", page)
        return {}
    scored = score_files(
        results,
        reference,
        steps=task.steps,
        tolerances=task.tolerances,
        names=task.names,
        require=task.require,
    )
    if task.kind == "diagnose":
        if isinstance(scored, Series):
            raise InputError(f"found {len(scored.runs)} runs, expected the files of one")
        from heyoka_bike.scoring.diagnosis.diagnose import diagnosed

        scored = diagnosed(scored, reference, progress)
    made = origin((task.kind, *task.files))
    for name, suffix in RENDERED.items():
        _write(task, suffix, output.render(scored, name, made))
    said = [] if isinstance(scored, Series) else [printable(f.message) for f in scored.diagnosis]
    return {"is_one_run": isinstance(scored, Report), "diagnosis": said}


def _write(task: Task, suffix: str, text: str) -> None:
    folder = task.folder / MADE
    folder.mkdir(exist_ok=True)
    write_output(folder / f"{stem(task.kind)}{suffix}", text.encode())
