"""Threads of the linear algebra (BLAS), whose number is a setting of the process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

_IS_SET = Lock()


@contextmanager
def one_thread_of_linear_algebra() -> Iterator[None]:
    """Let the linear algebra use one thread in a block, then restore the previous number.

    Threads that share a system of a hundred unknowns wait for each other in busy loops. If other
    programs use the processors too, that takes five times the processor time of one thread.

    If several threads have such blocks, the first one sets the number and restores it. A block that
    continues after that runs slower.
    """
    from threadpoolctl import threadpool_limits

    if not _IS_SET.acquire(blocking=False):
        yield
        return
    try:
        with threadpool_limits(1, user_api="blas"):
            yield
    finally:
        _IS_SET.release()
