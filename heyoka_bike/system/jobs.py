"""Jobs, which depend only on their arguments, and executors that run them.

The calls of these executors of `concurrent.futures` report progress, and end when nobody waits for
them. `ProcessExecutor` uses processes of this machine. Each process runs one call at a time, so the
end of a process affects no other call.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from contextvars import ContextVar
from dataclasses import dataclass
from math import inf
from multiprocessing import current_process, get_all_start_methods, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from threading import Thread
from traceback import format_exc
from typing import Any
from weakref import WeakSet

from heyoka_bike.system.log import VARIABLE, fault, shown

OnStage = Callable[[str, float], None]
"""Called by a job with its stage, and the time that the job has reached in the motion [s]."""

reporting: ContextVar[OnStage] = ContextVar("reporting", default=lambda stage, t: None)
"""Receiver of a job's progress; an executor that can forward progress sets it in its workers."""

_INTERVAL = 0.1  # [s], minimum time between two reports of progress in the same stage

_TRIES = 3
_SECONDS_BETWEEN_LOOKS = 0.05  # [s], time between two checks for a message from the process
# Maximum size [bytes] of a message from a process whose time and memory are limited, and of a file
# that such a process writes. A report of all columns has a few hundred kB, a replay at most 3 MB.
_LONGEST_MESSAGE = 1 << 16
_LARGEST_FILE = 100_000_000
_log = logging.getLogger(__name__)
_Call = tuple[Callable[..., Any], Sequence[Any], Mapping[str, Any]]


@dataclass(frozen=True, eq=False, slots=True)
class Job:
    """A piece of work that depends only on its arguments.

    Attributes
    ----------
    work
        A function at module level. It is called with a `OnStage` after its own arguments.
    arguments
        Arguments of the function; another job among them is replaced by its result.
    name
        Name of the motion that the job is about.
    duration
        Duration of that motion [s], for the progress.
    stages
        Stages that are over when the job ends.
    """

    work: Callable[..., Any]
    arguments: tuple[Any, ...]
    name: str = ""
    duration: float = 1.0
    stages: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """Description of the job for messages."""
        name = self.work.__name__.lstrip("_").replace("_", " ")
        return f"{name} of {self.name}" if self.name else name


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a job: its value or its error.

    Attributes
    ----------
    value
        The result.
    seconds : float
        Processor time of the job [s].
    error : Exception or None
        The error, if there is no value.
    """

    value: Any
    seconds: float = 0.0
    error: Exception | None = None

    def get(self) -> Any:
        """Return the value, or raise the error if there is one."""
        if self.error is not None:
            raise self.error
        return self.value


def throttled(report: OnStage) -> OnStage:
    """Return a report that forwards each new stage, and otherwise at most ten reports a second."""
    last, at = "", 0.0

    def passed_on(stage: str, t: float) -> None:
        nonlocal last, at
        now = time.monotonic()
        if stage != last or now > at + _INTERVAL:
            last, at = stage, now
            report(stage, t)

    return passed_on


class ProgressFuture(Future[Any]):
    """The future of a submitted call, with the progress of the call.

    Attributes
    ----------
    progress : tuple of (str, float), or None
        The stage and its progress in the latest report of the call.
    is_unwanted : bool
        True if nobody waits for the call any more.
    """

    progress: tuple[str, float] | None = None
    is_unwanted: bool = False

    def cancel(self) -> bool:
        """Cancel the call; a running call is ended and raises `CancelledError`."""
        self.is_unwanted = True
        return super().cancel()


class RemoteError(Exception):
    """Cause of an exception in a process: its traceback, or only its place in a limited process."""


@dataclass(frozen=True, slots=True)
class ProcessLimits:
    """Limits of a call: its time and its memory.

    Attributes
    ----------
    seconds : float
        Limit of processor time and of elapsed time [s].
    memory : int
        Memory of the process [bytes].
    """

    seconds: float
    memory: int

    def apply(self) -> None:
        """Apply the limits to this process, as far as the system supports them."""
        bounds = {
            "RLIMIT_CPU": int(self.seconds) + 2,
            "RLIMIT_AS": self.memory,
            "RLIMIT_FSIZE": _LARGEST_FILE,
            "RLIMIT_CORE": 0,
        }
        for name, bound in bounds.items():
            # macOS lacks some of these limits and rejects others. On macOS, too, the parent process
            # limits the elapsed time.
            with suppress(ImportError, AttributeError, OSError, ValueError):
                import resource

                kind = getattr(resource, name)
                _, most = resource.getrlimit(kind)
                found = bound if most == resource.RLIM_INFINITY else min(bound, most)
                resource.setrlimit(kind, (found, found))


class ProcessExecutor(Executor):
    """An executor with at most `max_workers` processes, started on demand.

    A call whose process ends unexpectedly is started again, three times in all. Then it raises
    `BrokenExecutor`.

    Parameters
    ----------
    max_workers
    limits : ProcessLimits or None
        If given, each call has a process of its own, which ends with the call or at its limits, and
        is not started twice. The call must return JSON values, so that this process never unpickles
        data that a damaged file could have produced. A call that takes too long raises
        `TimeoutError`. Other exceptions are reported as a `RemoteError` with only their kind and
        place.
    preload
        Modules that are imported once, in the process from which all others are forked, if the
        system supports this. The first executor with `preload` starts that process for all of them.
        Without `preload` each process is a fresh interpreter, because it is unsafe to fork one with
        threads and a JIT compiler.
    """

    def __init__(
        self, max_workers: int, limits: ProcessLimits | None = None, preload: Sequence[str] = ()
    ) -> None:
        if getattr(current_process(), "_inheriting", False):
            # A worker imports the script that started it. Without the guard
            # `if __name__ == "__main__"`, the import would start further workers, so end this one.
            os._exit(1)
        forks = bool(preload) and "forkserver" in get_all_start_methods()
        self._context: Any = get_context("forkserver" if forks else "spawn")
        if forks:
            self._context.set_forkserver_preload(list(preload))
        self._limits = limits
        self._threads = ThreadPoolExecutor(max_workers)
        self._futures: WeakSet[ProgressFuture] = WeakSet()
        self._idle: list[_Worker] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> ProgressFuture:
        """Run a call as soon as a process is free."""
        future = ProgressFuture()
        self._futures.add(future)
        self._threads.submit(self._run, future, (fn, args, kwargs))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes after all calls.

        Parameters
        ----------
        wait
            Wait for all calls; else the processes end with this one.
        cancel_futures
            End waiting and running calls.
        """
        if cancel_futures:
            for future in list(self._futures):
                future.cancel()
        self._threads.shutdown(wait)
        while wait and self._idle:
            self._idle.pop().end()

    def __exit__(self, exc_type: type[BaseException] | None, *_: object) -> None:
        """Wait for all calls; end them if an exception is raised."""
        self.shutdown(cancel_futures=exc_type is not None)

    def _run(self, future: ProgressFuture, call: _Call) -> None:
        """Run a call, in a thread of its own."""
        if not future.set_running_or_notify_cancel():
            return
        try:
            for _ in range(_TRIES if self._limits is None else 1):
                with suppress(BrokenExecutor):
                    future.set_result(self._result(future, call))
                    return
                _log.info("a process ended before its call was over")
            raise BrokenExecutor("its process ended")
        except Exception as e:
            future.set_exception(e)

    def _result(self, future: ProgressFuture, call: _Call) -> Any:
        """Return the result of a call from a free process, or else from a new one."""
        try:
            worker = self._idle.pop()
        except IndexError:
            worker = _Worker(self._context, self._limits)
        try:
            result = worker.result(future, call)
        except BaseException:
            worker.end()
            raise
        if self._limits is None:
            self._idle.append(worker)
        else:
            worker.end()
        return result


class _Worker:
    """A process that runs calls, and the pipe that connects to it."""

    def __init__(self, context: Any, limits: ProcessLimits | None) -> None:
        self._limits = limits
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, limits))
        self._process.start()
        theirs.close()

    def result(self, future: ProgressFuture, call: _Call) -> Any:
        """Return the result of a call, or raise its error; forward its progress to the future."""
        end = time.monotonic() + (self._limits.seconds if self._limits else inf)
        try:
            self._pipe.send(call)
            kind, said = self._heard()
            while kind in ("", "progress") and not future.is_unwanted and time.monotonic() < end:
                future.progress = said or future.progress
                kind, said = self._heard()
        except (EOFError, OSError) as e:
            raise BrokenExecutor from e
        if kind == "result":
            return said
        if kind == "error":
            error, text = said
            raise (error or RemoteError(text)) from RemoteError(text)
        raise CancelledError if future.is_unwanted else TimeoutError

    def _heard(self) -> tuple[str, Any]:
        """Return the kind and content of the next message; the kind is empty if none comes soon."""
        if not self._pipe.poll(_SECONDS_BETWEEN_LOOKS):
            return "", None
        if self._limits is None:
            kind, said = self._pipe.recv()
        else:
            kind, said = json.loads(self._pipe.recv_bytes(_LONGEST_MESSAGE))
        return kind, said

    def end(self) -> None:
        """End the process and the processes that it started."""
        if hasattr(os, "killpg") and hasattr(signal, "SIGKILL"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)
        # Windows lacks SIGKILL, but its terminate() ends the process just as surely.
        (self._process.kill if hasattr(signal, "SIGKILL") else self._process.terminate)()
        self._process.join()
        self._process.close()
        self._pipe.close()


def _work(pipe: Connection, limits: ProcessLimits | None) -> None:
    """Run calls in a worker, one after the other."""
    # A keyboard interrupt reaches all processes, but only the parent handles it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setsid"):
        # Start a new session, because ending it also ends the processes that this process starts.
        os.setsid()
    if limits is None:
        Thread(target=_end_with_parent, daemon=True).start()
        if level := os.environ.get(VARIABLE):
            shown(level).__enter__()
    else:
        limits.apply()

    def encoded(kind: str, said: Any) -> Any:
        message = kind, said
        return ForkingPickler.dumps(message) if limits is None else json.dumps(message).encode()

    reporting.set(throttled(lambda stage, t: pipe.send_bytes(encoded("progress", (stage, t)))))
    while True:
        try:
            fn, args, kwargs = pipe.recv()
        except EOFError:
            return
        try:
            answer = encoded("result", fn(*args, **kwargs))
        except Exception as e:
            error = (e, f"\n{format_exc()}") if limits is None else (None, fault(e))
            answer = encoded("error", error)
        try:
            pipe.send_bytes(answer)
        except OSError:
            # The parent process has ended, so nobody waits for the answer.
            return


def _end_with_parent() -> None:
    """End this worker if its parent is gone, because nobody waits for its results."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
