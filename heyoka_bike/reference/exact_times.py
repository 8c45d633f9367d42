"""Times as they are given to the reference: exact, in any form."""

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array, Double, two_sum
from heyoka_bike.numbers.exact import Exact

Time = float | Fraction | str | tuple[ArrayLike, ArrayLike] | ArrayLike
"""A time [s]: a float (meaning exactly that binary64), an exact `Fraction` or decimal string, an
array or sequence of these, or a pair (hi, lo) of floats or arrays."""


def as_double(t: Time | object) -> Double:
    """A time in any accepted form as hi + lo.

    Raises
    ------
    InputError
        It is not a number, or would be rounded on the way.
    """
    if isinstance(t, tuple) and len(t) == 2:
        hi, lo = _plain(t[0]), _plain(t[1])
        if hi.shape != lo.shape or not (np.abs(lo) <= np.spacing(np.abs(hi))).all():
            raise InputError(
                f"time: found the pair {t!r:.60}, expected (hi, lo) of one shape with lo below the "
                "last digit of hi; times of their own go in a list or an array"
            )
        return two_sum(hi, lo)
    try:
        exact = np.asarray(t)
        if exact.dtype.kind in "fiu" and exact.dtype.itemsize <= 8:
            return _plain(exact), np.zeros(exact.shape)
        # Mixed lists keep their members as they are.
        exact = exact if isinstance(t, np.ndarray) else np.asarray(t, dtype=object)
    except ValueError:
        raise InputError("time: found a ragged sequence, expected numbers of one shape") from None
    pairs = np.array([_split(x) for x in exact.ravel()], dtype=np.float64).reshape(-1, 2)
    return pairs[:, 0].reshape(exact.shape), pairs[:, 1].reshape(exact.shape)


def _split(t: object) -> tuple[float, float]:
    """One time as hi + lo: a string, an exact number, or a float."""
    if isinstance(t, bytes):
        t = t.decode("utf-8", "replace")
    if isinstance(t, str):
        try:
            exact = Exact.parse(t).fraction()
        except ValueError as e:
            raise InputError(f"time: {e}") from None
    elif isinstance(t, bool | np.bool_ | None.__class__):
        raise InputError(f"time: found {t!r}, expected numbers or decimal strings")
    else:
        try:
            exact = Fraction(*t.as_integer_ratio())  # type: ignore[attr-defined]
        except (ValueError, OverflowError):
            return float("nan"), 0.0
        except (AttributeError, TypeError):
            raise InputError(
                f"time: found {t!r:.60}, expected numbers or decimal strings"
            ) from None
    try:
        hi = float(exact)
    except OverflowError:
        return float("inf"), 0.0
    return hi, float(exact - Fraction(hi))


def _plain(x: object) -> Array:
    """Floats, as floats; nothing that would be rounded on the way."""
    values = np.asarray(x)
    if values.dtype.kind not in "fiu" or values.dtype.itemsize > 8:
        raise InputError(f"time: found {x!r:.60}, expected floats")
    return values.astype(np.float64)
