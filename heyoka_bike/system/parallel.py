"""Long work for several maneuvers at once, one process each."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ProcessPoolExecutor, wait
from functools import partial
from multiprocessing import get_context, parent_process
from queue import Empty
from typing import Any, TypeVar

T = TypeVar("T")
Progress = Callable[[str, str, float], None]
"""Called with the name of a job, its stage, and the share of that stage that is done, 0 to 1."""

Report = Callable[[str, float], None]
"""Called by a job with its stage, and the time that it has reached in the motion [s]."""

WAITING = "waiting"
"""Stage of a job that has not begun."""

_queue: Any = None


def side_by_side(
    work: Callable[..., T],
    jobs: Sequence[tuple[Any, ...]],
    motions: Sequence[tuple[str, float]] = (),
    progress: Progress | None = None,
    done: Callable[[int, T], None] = lambda i, result: None,
) -> list[T]:
    """``[work(*job, report) for job in jobs]`` in as many processes as there are processors.

    The first exception of a job ends the others and is raised. A single job runs in this process.

    Parameters
    ----------
    work
        Gets a `Report` after its own arguments.
    motions
        Name and duration [s] of the motion of each job, if its progress is asked for.
    done
        Called here with the number of a job and its result, as it ends.
    """

    def told(i: int, stage: str, t: float) -> None:
        if progress is not None:
            name, duration = motions[i]
            progress(name, stage, min(t / duration, 1.0))

    for i in range(len(motions)):
        told(i, WAITING, 0.0)
    if len(jobs) == 1:
        only = work(*jobs[0], partial(told, 0))
        done(0, only)
        return [only]
    # A fresh interpreter each: forking a process that holds threads and a JIT compiler is unsafe.
    context = get_context("spawn")
    queue = context.Queue()
    workers = min(len(jobs), os.cpu_count() or 1)
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_start, initargs=(queue,))
    try:
        futures = [pool.submit(_run, work, i, job) for i, job in enumerate(jobs)]
        numbers = {future: i for i, future in enumerate(futures)}
        waiting = set(futures)
        while waiting:
            ended, waiting = wait(waiting, timeout=0.1, return_when=FIRST_EXCEPTION)
            _drain(queue, told)
            for future in ended:
                done(numbers[future], future.result())
        return [future.result() for future in futures]
    except BaseException:
        for process in list((pool._processes or {}).values()):
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        queue.close()


def _start(queue: Any) -> None:
    import signal
    from threading import Thread

    global _queue
    _queue = queue
    Thread(target=_end_with_parent, daemon=True).start()
    # An interrupt from the keyboard reaches all processes; the parent answers it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end_with_parent() -> None:
    """A worker whose parent was ended, however, has nobody to work for."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run(work: Callable[..., T], i: int, job: tuple[Any, ...]) -> T:
    return work(*job, lambda stage, t: _queue.put((i, stage, t)))


def _drain(queue: Any, told: Callable[[int, str, float], None]) -> None:
    latest: dict[int, tuple[str, float]] = {}
    while True:
        try:
            i, stage, t = queue.get_nowait()
        except Empty:
            break
        latest[i] = (stage, t)
    for i, (stage, t) in latest.items():
        told(i, stage, t)
