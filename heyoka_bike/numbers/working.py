"""flint's working precision, which is one for the whole process: a thread at a time has it.

Another thread that changed it amid a computation would leave it with too few digits, and nothing
would say so.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

import flint

_OF_ONE_THREAD = RLock()


@contextmanager
def working_bits(bits: int) -> Iterator[None]:
    """Flint works with so many bits, for this thread alone, and then as before."""
    with _OF_ONE_THREAD, flint.ctx.workprec(bits):
        yield
