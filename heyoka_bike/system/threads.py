"""Threads of the linear algebra (BLAS), whose number a process has as a whole."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

_IS_SET = Lock()


@contextmanager
def one_thread_of_linear_algebra() -> Iterator[None]:
    """Let the linear algebra use one thread in a block; after it there are as many as before.

    Threads that share a system of a hundred unknowns wait for each other at full load: where other
    programs use the processors, too, that takes five times the processor time of one thread.

    Of blocks in several threads the first one sets the number and sets it back. One that goes on
    after it takes longer.
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
