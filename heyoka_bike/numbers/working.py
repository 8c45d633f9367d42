"""flint's working precision, which the whole process shares: one thread at a time owns it.

If another thread changed it during a computation, the result would have too few digits, and no
error would show it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

import flint

_OF_ONE_THREAD = RLock()


@contextmanager
def working_bits(bits: int) -> Iterator[None]:
    """Set flint to this many bits for this thread alone, then restore the old precision."""
    with _OF_ONE_THREAD, flint.ctx.workprec(bits):
        yield
