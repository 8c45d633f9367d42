"""Long work for several maneuvers at once, one process each, with progress bars."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from queue import Empty
from typing import Any, TypeVar

T = TypeVar("T")
Report = Callable[[int, str, float], None]
"""Called with the number of the job, its stage, and the time reached in the motion [s]."""

_queue: Any = None


def side_by_side(
    work: Callable[..., T], jobs: Sequence[tuple[Any, ...]], report: Report
) -> list[T]:
    """``[work(*job, progress) for job in jobs]`` in as many processes as there are processors.

    The first exception of a job ends the others and is raised. A single job runs in this process.
    """
    if len(jobs) == 1:
        return [work(*jobs[0], lambda stage, t: report(0, stage, t))]
    # A fresh interpreter each: forking a process that holds threads and a JIT compiler is unsafe.
    context = get_context("spawn")
    queue = context.Queue()
    workers = min(len(jobs), os.cpu_count() or 1)
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_start, initargs=(queue,))
    try:
        futures = [pool.submit(_run, work, i, job) for i, job in enumerate(jobs)]
        waiting = set(futures)
        while waiting:
            done, waiting = wait(waiting, timeout=0.1, return_when=FIRST_EXCEPTION)
            _drain(queue, report)
            for future in done:
                future.result()
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


def _drain(queue: Any, report: Report) -> None:
    latest: dict[int, tuple[str, float]] = {}
    while True:
        try:
            i, stage, t = queue.get_nowait()
        except Empty:
            break
        latest[i] = (stage, t)
    for i, (stage, t) in latest.items():
        report(i, stage, t)


@contextmanager
def progress_bars(
    names: Sequence[str], durations: Sequence[float], shares: Mapping[str, float]
) -> Iterator[Report]:
    """A bar for each maneuver on standard error; nothing when that is not a terminal.

    Parameters
    ----------
    shares
        Stages in their order, with their share of the work.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    view = (
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[stage]:>9}"),
        TextColumn("{task.percentage:>3.0f} %"), TimeElapsedColumn(),
    )  # fmt: skip
    before, total = {}, 0.0
    for stage, share in shares.items():
        before[stage] = total
        total += share
    with Progress(*view, console=console, disable=not console.is_terminal) as bars:
        tasks = [bars.add_task(name, total=total, stage="waiting") for name in names]

        def report(i: int, stage: str, t: float) -> None:
            done = before[stage] + shares[stage] * min(t / durations[i], 1.0)
            bars.update(tasks[i], completed=done, stage=stage)

        yield report
