"""An atlas' numbers in few bytes, for a page: two of each, in base64."""

from base64 import b64encode
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array

_LAST, _NONE = 65534, 65535


@dataclass(frozen=True, slots=True)
class Packed:
    """Numbers as integers k of 16 bits.

    A number is ``low + (high - low) k / 65534``, or ten to the power of that; of powers k = 0 means
    zero. 65535 means that there is none.

    Attributes
    ----------
    low, high
        Of the numbers, or of their decimal logarithms.
    is_log
        Whether they are powers of ten.
    codes : ndarray of uint16
    """

    low: float
    high: float
    is_log: bool
    codes: NDArray[np.uint16]

    @classmethod
    def of(cls, values: Array, *, is_log: bool) -> "Packed":
        """Numbers packed; what is not finite is none, and of powers what is not positive zero."""
        flat = np.asarray(values, dtype=float).ravel()
        is_there = np.isfinite(flat)
        kept = is_there & (flat > 0) if is_log else is_there
        scaled = np.log10(flat[kept]) if is_log else flat[kept]
        low, high = (float(scaled.min()), float(scaled.max())) if len(scaled) else (0.0, 0.0)
        codes = np.where(is_there, 0, _NONE).astype(np.uint16)
        places = (scaled - low) / ((high - low) or 1.0) * _LAST
        codes[kept] = np.maximum(np.rint(places), 1 if is_log else 0)
        return cls(low, high, is_log, codes)

    @property
    def precision(self) -> float:
        """The largest error of a number: absolute, or relative for powers."""
        half = (self.high - self.low) / _LAST / 2
        # The lowest power has the code of the one above it.
        return float(10 ** (2 * half) - 1) if self.is_log else half

    def text(self) -> str:
        """The codes in base64, little-endian."""
        return b64encode(self.codes.astype("<u2").tobytes()).decode()
