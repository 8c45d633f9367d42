"""The equations as heyoka expressions."""

import os
from collections.abc import Iterable
from fractions import Fraction
from functools import cache
from typing import Any

from heyoka_bike.errors import GENERATE, required
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.exact import Exact

CACHE_LIMIT = 2**30
"""Bytes of compiled code that heyoka keeps on the disk at most; its own limit is 20 times that."""


class Expressions(Arithmetic):
    """heyoka expressions whose constants are exact in one precision.

    Constants come in from `Constants.convert`; in the equations themselves only the integers 0, 1
    and 2 are written, which are exact in every format.
    """

    def number(self, value: Exact | Fraction | int) -> Number:
        raise TypeError("constants of an expression are made by Constants.convert")

    def elementary(self, name: str, x: Number) -> Number:
        return getattr(require_heyoka(), name)(x)

    def atan2(self, y: Number, x: Number) -> Number:
        return require_heyoka().atan2(y, x)

    def sum(self, terms: Iterable[Number]) -> Number:
        hy = require_heyoka()
        return hy.sum(
            [x if isinstance(x, hy.expression) else hy.expression(float(x)) for x in terms]
        )


def require_heyoka() -> Any:
    """The module heyoka, which keeps compiled code on the disk where it can.

    Raises
    ------
    MissingPackageError
        It is not installed.
    """
    heyoka = required(
        "heyoka",
        f"heyoka is not installed; integrating needs it ({GENERATE} on Linux, or conda install "
        "heyoka.py)",
    )
    _limit_cache(heyoka)
    return heyoka


@cache
def _limit_cache(heyoka: Any) -> None:
    """Bound the cache; one that cannot be written is off, or heyoka tells of it amid a report."""
    state = heyoka.llvm_state
    folder = state.get_diskcache_path()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_usable = os.access(folder, os.W_OK)
    except OSError:
        is_usable = False
    if is_usable:
        state.set_diskcache_limit(min(state.get_diskcache_limit(), CACHE_LIMIT))
    else:
        state.set_diskcache_enabled(False)
