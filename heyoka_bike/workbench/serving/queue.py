"""A bounded queue of tasks, each run in a process of its own with limits."""

import asyncio
import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError
from contextlib import nullcontext
from threading import Event
from time import monotonic
from typing import Literal

from starlette.exceptions import HTTPException

from heyoka_bike.system.jobs import ProcessExecutor, ProgressFuture, RemoteError
from heyoka_bike.system.log import fault
from heyoka_bike.workbench.serving.tasks import Kind, Limits, Task, TaskEnding, is_long, work

_PRELOAD = ("heyoka_bike.workbench.serving.tasks", "heyoka_bike.workbench.serving.preload")
# Time that a task is assumed to take before the first task has been measured [s].
_FIRST_GUESS = 1.0


class BusyError(HTTPException):
    """The queue of the server is full: the answer is 503 and a time to wait.

    Parameters
    ----------
    seconds : int
        Time after which to try again [s].
    """

    def __init__(self, seconds: int) -> None:
        # The connection is closed, so that the rest of the request need not be read.
        headers = {"retry-after": str(seconds), "connection": "close"}
        super().__init__(503, f"busy, try again in {seconds} s", headers)


class QueuedTask:
    """A task in the queue; only the server's event loop changes it, any thread may read it.

    Attributes
    ----------
    task
    ending : TaskEnding or None
        Ending of the task; None until it has ended.
    over : asyncio.Task
        asyncio task whose result is the ending.
    unwanted : threading.Event
        Set once nobody waits for the task any more.
    """

    over: asyncio.Task[TaskEnding]

    def __init__(self, task: Task) -> None:
        self.task = task
        self.ending: TaskEnding | None = None
        self.unwanted = Event()
        self.future: ProgressFuture | None = None

    @property
    def state(self) -> Literal["waiting", "working", "done", "refused", "failed"]:
        """Whether the task waits, works, or how it has ended."""
        if self.ending is not None:
            return self.ending.state
        return "waiting" if self.future is None else "working"

    @property
    def share(self) -> float:
        """Completed fraction of the work, 0 to 1."""
        if self.state == "done":
            return 1.0
        progress = self.future and self.future.progress
        return progress[1] if progress else 0.0

    def cancel(self) -> None:
        """End the task because nobody waits for it; may be called from any thread."""
        self.unwanted.set()
        if self.future is not None:
            self.future.cancel()


class TaskQueue:
    """The waiting and running tasks; at most `limits.workers` of them run at once.

    Parameters
    ----------
    limits
    log
        Called with one line about each failure, without contents.
    """

    def __init__(self, limits: Limits, log: Callable[[str], None]) -> None:
        self._limits, self._log = limits, log
        self._tasks: list[QueuedTask] = []
        self._seconds: deque[float] = deque([_FIRST_GUESS], maxlen=50)
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        # Long tasks have another time limit than short ones, so they have their own executor.
        self._executors = {
            is_long: ProcessExecutor(limits.workers, limits.of_process(is_long), _PRELOAD)
            for is_long in (False, True)
        }
        self._places = asyncio.Semaphore(limits.workers)
        # If there are several workers, at least one of them does no long tasks. So a few diagnoses
        # do not block all scoring.
        self._long_places = asyncio.Semaphore(max(1, limits.workers - 1))

    def submit(self, task: Task) -> QueuedTask:
        """Append a task to the queue.

        Raises
        ------
        BusyError
            The queue is full, so one more task would have to wait too long.
        """
        self.check(task.kind)
        queued = QueuedTask(task)
        self._tasks.append(queued)
        queued.over = asyncio.create_task(self._carry_out(queued))
        return queued

    def check(self, kind: Kind) -> None:
        """Raise `BusyError` if a task of this kind could not be appended now."""
        most = self._limits.waiting
        long = [x for x in self._tasks if x.state == "waiting" and is_long(x.task.kind)]
        # Diagnoses, each of which may take minutes, may use at most half of the places in the
        # queue.
        if self.waiting() >= most or (is_long(kind) and 2 * len(long) >= most):
            each = sum(self._seconds) / len(self._seconds)
            seconds = each * self.waiting() / self._limits.workers / 2
            raise BusyError(max(1, round(seconds)))

    def waiting(self) -> int:
        """Return the number of waiting tasks."""
        return sum(queued.state == "waiting" for queued in self._tasks)

    async def close(self) -> None:
        """End all tasks."""
        for queued in self._tasks:
            queued.cancel()
        await asyncio.gather(*(queued.over for queued in self._tasks))
        for executor in self._executors.values():
            await asyncio.to_thread(executor.shutdown)

    async def _carry_out(self, queued: QueuedTask) -> TaskEnding:
        kind = queued.task.kind
        async with self._long_places if is_long(kind) else nullcontext(), self._places:
            start = monotonic()
            queued.ending = await self._ending(queued)
            self._tasks.remove(queued)
            self._seconds.append(monotonic() - start)
            return queued.ending

    async def _ending(self, queued: QueuedTask) -> TaskEnding:
        """Run a task and return how it has ended, in words for the user; log details of errors."""
        task, kind = queued.task, queued.task.kind
        limits = self._limits.of_process(is_long(kind))
        try:
            if queued.unwanted.is_set():
                raise CancelledError
            queued.future = self._executors[is_long(kind)].submit(work, task, limits.memory)
            if queued.unwanted.is_set():
                # Another thread has cancelled the task in the meantime.
                queued.future.cancel()
            over = asyncio.wrap_future(queued.future)
            await asyncio.gather(over, return_exceptions=True)
            return TaskEnding(**queued.future.result())
        except CancelledError:
            return TaskEnding("failed", "given up", 70)
        except TimeoutError:
            return TaskEnding("refused", f"takes more than {limits.seconds:g} s, expected less", 1)
        except BrokenExecutor:
            # The system ended the process, most likely because it exceeded its memory or its time.
            self._log(f"{kind}: the process ended unexpectedly")
            said = (
                f"ended before it was done: it needs more than {limits.seconds:g} s or "
                f"{limits.memory // 1_000_000} MB of memory"
            )
            return TaskEnding("refused", said, 1)
        except RemoteError as e:
            self._log(f"{kind}: {e}")
            said = "an error of the program, not of the file; please report it"
        except Exception as e:
            self._log(f"{kind}: {fault(e)} in the server")
            said = "internal error of the server"
        return TaskEnding("failed", said, 70)
