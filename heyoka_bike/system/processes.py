"""Jobs in processes of this machine, and in any executor that is given."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import current_process, get_context, parent_process
from queue import Empty
from typing import Any

from heyoka_bike.system.jobs import Hands, Outcome, Told, carried_out

# A fresh interpreter each: forking a process that holds threads and a JIT compiler is unsafe.
_context = get_context("spawn")
_queue: Any = None
_TRIES = 3


class Processes:
    """At most so many processes; a single job runs in this one."""

    def __init__(self, count: int) -> None:
        self.count = count

    @contextmanager
    def at_work(self, count: int, told: Told) -> Iterator[Hands]:
        """See `jobs.Crew`."""
        if min(count, self.count) == 1:
            yield _Here(told)
            return
        if getattr(current_process(), "_inheriting", False):
            # It still reads the script that began it, and would begin others, which would, too.
            os._exit(1)
        slots = _Slots(min(count, self.count), told)
        try:
            yield slots
        except BaseException:
            slots.end()
            raise
        finally:
            slots.close()


class Given:
    """An executor of somebody else; what its jobs tell on their way does not come here."""

    def __init__(self, executor: Executor) -> None:
        self.executor = executor

    @contextmanager
    def at_work(self, count: int, told: Told) -> Iterator[Hands]:
        """See `jobs.Crew`."""
        hands = _Elsewhere(self.executor)
        try:
            yield hands
        finally:
            for future in hands.begun:
                future.cancel()


class _Here:
    """The process that asks."""

    tries = 1

    def __init__(self, told: Told) -> None:
        self.told = told

    def free(self) -> bool:
        return True

    def submit(self, i: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Future[Any]:
        future: Future[Outcome] = Future()
        try:
            future.set_result(carried_out(work, arguments, lambda s, t: self.told(i, s, t)))
        except Exception as e:
            future.set_exception(e)
        return future

    def look(self) -> None:
        pass

    def is_lost(self, error: Exception) -> bool:
        return False


class _Elsewhere:
    """Another executor."""

    tries = 1

    def __init__(self, executor: Executor) -> None:
        self.executor = executor
        self.begun: list[Future[Any]] = []

    def free(self) -> bool:
        return True

    def submit(self, i: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Future[Any]:
        self.begun.append(self.executor.submit(carried_out, work, arguments, _nothing))
        return self.begun[-1]

    def look(self) -> None:
        pass

    def is_lost(self, error: Exception) -> bool:
        return False


class _Slots:
    """Pools of one process each, so that one that ends takes its own job with it and no other."""

    tries = _TRIES

    def __init__(self, count: int, told: Told) -> None:
        self.count, self.told = count, told
        self.idle: list[_Slot] = []
        self.busy: dict[Future[Any], _Slot] = {}

    def free(self) -> bool:
        return len(self.busy) < self.count

    def submit(self, i: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Future[Any]:
        slot = self.idle.pop() if self.idle else _Slot()
        try:
            future = slot.pool.submit(_run, i, work, arguments)
        except BrokenExecutor:
            # It ended while it was idle.
            slot.close()
            slot = _Slot()
            future = slot.pool.submit(_run, i, work, arguments)
        self.busy[future] = slot
        return future

    def look(self) -> None:
        for slot in self.busy.values():
            for i, (stage, t) in slot.heard().items():
                self.told(i, stage, t)
        for future in [f for f in self.busy if f.done()]:
            slot = self.busy.pop(future)
            if isinstance(future.exception(), BrokenExecutor):
                slot.close()
            else:
                self.idle.append(slot)

    def is_lost(self, error: Exception) -> bool:
        return isinstance(error, BrokenExecutor)

    def end(self) -> None:
        """End what runs."""
        for slot in self.busy.values():
            slot.end()

    def close(self) -> None:
        for slot in (*self.idle, *self.busy.values()):
            slot.close()


class _Slot:
    def __init__(self) -> None:
        # A queue of its own: one that is shared stays locked if a process is killed at it.
        self.queue = _context.Queue()
        self.pool = ProcessPoolExecutor(1, _context, initializer=_start, initargs=(self.queue,))

    def heard(self) -> dict[int, tuple[str, float]]:
        """What was told last."""
        last: dict[int, tuple[str, float]] = {}
        while True:
            try:
                i, stage, t = self.queue.get_nowait()
            except Empty:
                return last
            last[i] = (stage, t)

    def end(self) -> None:
        for process in list((self.pool._processes or {}).values()):
            process.terminate()

    def close(self) -> None:
        self.pool.shutdown(cancel_futures=True)
        self.queue.close()


def _start(queue: Any) -> None:
    import signal
    from threading import Thread

    global _queue
    _queue = queue
    Thread(target=_end_with_parent, daemon=True).start()
    if level := os.environ.get("HEYOKA_BIKE_LOG"):
        from heyoka_bike.system.log import shown

        shown(level).__enter__()
    # An interrupt from the keyboard reaches all processes; the parent answers it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end_with_parent() -> None:
    """A worker whose parent was ended, however, has nobody to work for."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run(i: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Outcome:
    return carried_out(work, arguments, lambda stage, t: _queue.put((i, stage, t)))


def _nothing(stage: str, t: float) -> None:
    pass
