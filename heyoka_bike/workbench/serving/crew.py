"""A bounded queue of work, each piece in a process of its own, killed when it takes too long."""

import json
import os
import signal
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import get_all_start_methods, get_context
from threading import Condition, Thread
from time import monotonic
from typing import Any, Literal

from heyoka_bike.workbench.serving.limits import Limits
from heyoka_bike.workbench.serving.tasks import Kind, Task, fault, is_long, work

State = Literal["waiting", "working", "done", "refused", "failed"]

_LOOK = 0.05  # [s]
# Of one message of a worker [bytes].
_LONGEST = 1 << 16
# What the time of a piece of work is said to be before there is any [s].
_FIRST_GUESS = 1.0


class BusyError(Exception):
    """The queue is full.

    Parameters
    ----------
    seconds : int
        When to try again [s].
    """

    def __init__(self, seconds: int) -> None:
        self.seconds = seconds
        super().__init__(f"busy, try again in {seconds} s")


@dataclass(eq=False, slots=True)
class Job:
    """A task on its way; its thread writes it, anybody reads it.

    Attributes
    ----------
    task
    state
    share
        Of the work that is done, 0 to 1.
    message
        Why it was refused or failed: one line for the user.
    code
        Exit code that the command ends with.
    answer : dict
        What the task gave.
    is_unwanted
        Whether nobody waits for it any more.
    over : Future
        Done when nothing more will happen.
    """

    task: Task
    state: State = "waiting"
    share: float = 0.0
    message: str = ""
    code: int = 0
    answer: dict[str, Any] | None = None
    is_unwanted: bool = False
    over: Future[None] = field(default_factory=Future)

    @property
    def has_ended(self) -> bool:
        """Whether it is known how it ended."""
        return self.state in ("done", "refused", "failed")


class Crew:
    """Processes that carry out tasks, as many at once as `limits` says.

    Parameters
    ----------
    limits
    log
        Called with one line about what went wrong, without contents.
    """

    def __init__(self, limits: Limits, log: Callable[[str], None]) -> None:
        self.limits, self._log = limits, log
        self._waiting: deque[Job] = deque()
        self._changed = Condition()
        self._seconds: deque[float] = deque([_FIRST_GUESS], maxlen=50)
        self._is_open = True
        self._working: list[Any] = []
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        if "forkserver" in get_all_start_methods():
            self._context: Any = get_context("forkserver")
            self._context.set_forkserver_preload(["heyoka_bike.workbench.serving.warmed"])
        else:
            self._context = get_context("spawn")
        # One of several does no long work, so that a few diagnoses do not keep all files waiting.
        self._threads = [
            Thread(target=self._serve, args=(i > 0 or limits.workers == 1,), daemon=True)
            for i in range(limits.workers)
        ]
        for thread in self._threads:
            thread.start()

    def submit(self, task: Task) -> Job:
        """Put a task at the end of the queue.

        Raises
        ------
        BusyError
            So many wait already that one more would have to wait too long.
        """
        job = Job(task)
        with self._changed:
            self.check(task.kind)
            self._waiting.append(job)
            self._changed.notify_all()
        return job

    def check(self, kind: Kind) -> None:
        """Raise `BusyError` if a task of this kind could not be put there now."""
        most = self.limits.waiting
        waiting = list(self._waiting)
        # Half of the places at most are for diagnoses, each of which may take minutes.
        is_full = is_long(kind) and 2 * sum(is_long(job.task.kind) for job in waiting) >= most
        if is_full or len(waiting) >= most:
            raise BusyError(self.patience())

    def processes(self) -> list[int]:
        """Numbers of the processes that work now."""
        return [p.pid for p in list(self._working) if p.pid is not None]

    def waiting(self) -> int:
        """How many wait."""
        return len(self._waiting)

    def patience(self) -> int:
        """When a place will be free, by the last pieces of work [s]."""
        each = sum(self._seconds) / len(self._seconds)
        return max(1, round(each * len(self._waiting) / self.limits.workers / 2))

    def close(self) -> None:
        """End all work."""
        with self._changed:
            self._is_open = False
            self._changed.notify_all()
        for thread in self._threads:
            thread.join(timeout=5.0)

    def _next(self, takes_long: bool) -> Job | None:
        """The next piece of work, when there is one; None when there will be no more."""
        with self._changed:
            while self._is_open:
                for job in self._waiting:
                    if takes_long or not is_long(job.task.kind) or job.is_unwanted:
                        self._waiting.remove(job)
                        return job
                self._changed.wait()
        return None

    def _serve(self, takes_long: bool) -> None:
        while job := self._next(takes_long):
            start = monotonic()
            try:
                self._carry_out(job)
            except Exception as e:
                self._log(f"{job.task.kind}: {fault(e)} in the server")
                self._fail(job, "the server could not do it; this is a fault of the server")
            finally:
                self._seconds.append(monotonic() - start)
                job.over.set_result(None)

    def _carry_out(self, job: Job) -> None:
        if job.is_unwanted:
            self._fail(job, "given up")
            return
        ours, theirs = self._context.Pipe(duplex=False)
        process = self._context.Process(
            target=work, args=(theirs, job.task, self.limits), daemon=False
        )
        job.state = "working"
        try:
            process.start()
            self._working.append(process)
            theirs.close()
            self._follow(job, ours)
        finally:
            if process in self._working:
                self._working.remove(process)
            _end(process)
            ours.close()

    def _follow(self, job: Job, ours: Any) -> None:
        """Listen to a process until it has told how it ended."""
        seconds = self.limits.seconds(is_long(job.task.kind))
        end = monotonic() + seconds
        while not job.has_ended:
            if not self._is_open or job.is_unwanted:
                self._fail(job, "given up")
            elif monotonic() > end:
                self._refuse(job, f"takes more than {seconds:g} s, expected less", 1)
            elif ours.poll(_LOOK):
                try:
                    said = json.loads(ours.recv_bytes(_LONGEST))
                except (EOFError, OSError):
                    # Killed by the system, most likely for its memory or its time.
                    self._log(f"{job.task.kind}: its process ended by itself")
                    self._refuse(
                        job,
                        f"ended before it was done: it needs more than {seconds:g} s or "
                        f"{self.limits.memory // 1_000_000} MB of memory",
                        1,
                    )
                    return
                self._hear(job, said)

    def _hear(self, job: Job, said: dict[str, Any]) -> None:
        if "share" in said:
            job.share = float(said["share"])
        elif "done" in said:
            job.answer, job.share, job.state = said["done"], 1.0, "done"
        elif "refused" in said:
            self._refuse(job, str(said["refused"]), int(said["code"]))
        else:
            self._log(f"{job.task.kind}: {said.get('failed')}")
            self._fail(job, "an error of the program, not of the file; please report it")

    def _refuse(self, job: Job, message: str, code: int) -> None:
        job.message, job.code, job.state = message, code, "refused"

    def _fail(self, job: Job, message: str) -> None:
        job.message, job.code, job.state = message, 70, "failed"


def _end(process: Any) -> None:
    """End a process and what it started."""
    if process.pid is None:
        return
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    if process.is_alive():
        process.kill()
    process.join()
    process.close()
