"""Threads of the linear algebra (BLAS), whose number a process has as a whole."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

_CHANGE = Lock()
# How many blocks are within, and the limit that the first of them set.
_within = 0
_limit: Any = None


@contextmanager
def one_thread_of_linear_algebra() -> Iterator[None]:
    """Let the linear algebra use one thread in a block; the last block that ends sets it back.

    Threads that share a system of a hundred unknowns wait for each other at full load: where other
    programs use the processors, too, that takes ten times the processor time of one thread.
    """
    global _within, _limit
    from threadpoolctl import threadpool_limits

    with _CHANGE:
        if _within == 0:
            _limit = threadpool_limits(1, user_api="blas")
        _within += 1
    try:
        yield
    finally:
        with _CHANGE:
            _within -= 1
            if _within == 0:
                _limit.restore_original_limits()
                _limit = None
