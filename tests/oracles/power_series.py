"""Truncated Taylor series of balls as numbers of the equations."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import flint

from heyoka_bike.numbers.analytic import AtPoints
from heyoka_bike.numbers.arithmetic import Number


class PowerSeries(AtPoints):
    """Taylor series of a fixed length with ball coefficients.

    flint reads coefficients beyond a series' own precision as zero and stores the greatest length
    in a global variable; `coefficients` rejects a series that is too short.
    """

    def __init__(self, bits: int, length: int) -> None:
        super().__init__(bits)
        self.length = length

    @contextmanager
    def precision(self) -> Iterator[None]:
        """Set flint's precision and series length."""
        before = flint.ctx.cap
        with super().precision():
            flint.ctx.cap = self.length
            try:
                yield
            finally:
                flint.ctx.cap = before

    def series(self, coefficients: Iterable[Number]) -> flint.arb_series:
        """Return a polynomial as a series (it must not be longer than the series are)."""
        terms = list(coefficients)
        if len(terms) > self.length:
            raise ValueError(f"{len(terms)} coefficients do not fit a series of {self.length}")
        return flint.arb_series(terms, self.length)

    def coefficients(self, x: Number) -> list[flint.arb]:
        """Return all coefficients, `length` of them."""
        s = x if isinstance(x, flint.arb_series) else self.series([x])
        if s.prec != self.length:
            raise RuntimeError(f"a series of length {s.prec} where {self.length} is needed")
        found = list(s.coeffs())
        return found + [flint.arb(0)] * (self.length - len(found))
