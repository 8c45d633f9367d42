"""The precisions in which a trajectory can be computed."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2, log10

from heyoka_bike.errors import InputError

_BITS_OF_GUARD = 4
MAX_DIGITS = 1000


@dataclass(frozen=True, slots=True)
class Precision:
    """A floating-point format: its name and the bits of its significand."""

    name: str
    bits: int

    @property
    def digits(self) -> float:
        """Number of decimal digits that correspond to the bits of the significand."""
        return self.bits * log10(2)

    @classmethod
    def of(cls, what: str | int) -> Precision:
        """Read ``binary64``, ``longdouble``, ``binary128``, or a number of decimal digits (MPFR).

        Raises
        ------
        InputError
            The text is anything else, or the digits are outside 10 to 1000.
        """
        if what in _FORMAT_BITS:
            return _FORMAT_BITS[str(what)]
        try:
            digits = int(what)
        except ValueError:
            raise InputError(
                f"found precision '{what}', expected {', '.join(_FORMAT_BITS)} or a number of "
                "digits"
            ) from None
        if not 10 <= digits <= MAX_DIGITS:
            raise InputError(f"found {digits} digits, expected 10 to {MAX_DIGITS}")
        return cls(f"{digits} digits", ceil(digits * log2(10)) + _BITS_OF_GUARD)


_FORMAT_BITS = {
    "binary64": Precision("binary64", 53),
    "longdouble": Precision("longdouble", 64),
    "binary128": Precision("binary128", 113),
}
