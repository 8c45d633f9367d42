"""Dense output: every column as piecewise Chebyshev polynomials, as ephemerides are shipped.

Each piece interpolates the columns at the N Chebyshev nodes of the first kind. A piece is halved
until its last coefficients are far below what the dense output promises, so the interpolation error
(about the first coefficient left out) is smaller still. Coefficients are rounded to a multiple of
2^-112 of the column's scale and stored as hi + lo.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import frexp
from typing import Protocol

import flint
import numpy as np

from heyoka_bike.errors import UndecidedError
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.rounding import Enclosure, hi_lo
from heyoka_bike.reference.layout import NODES
from heyoka_bike.reference.values import Dense

_TAIL_BITS = 97  # last coefficients below 2^-97 = 6e-30 of the scale
_GRID_BITS = 112
_FIRST_WIDTH = Fraction(1, 2)
_MIN_WIDTH = Fraction(1, 2**24)


class Source(Protocol):
    """What is interpolated: columns that can be evaluated at any time up to an end."""

    @property
    def balls(self) -> Balls: ...

    @property
    def end(self) -> Fraction: ...

    def near(self, t: flint.arb, about: Fraction) -> Mapping[str, flint.arb]:
        """Columns by name at `t`, on the piece that holds the time `about`."""


def interpolate(
    source: Source,
    scales: Mapping[str, float],
    constant: Mapping[str, flint.arb | Fraction],
    progress: Callable[[float], None] | None = None,
) -> Dense:
    """Chebyshev pieces of some columns from 0 to the end.

    Parameters
    ----------
    scales
        Largest absolute value over the run of each column to be interpolated; zero for one that
        vanishes.
    constant
        Columns known to be constant, with their value.
    """
    names = list(scales)
    grids = [_GRID_BITS - frexp(scales[name])[1] for name in names]
    fit = _ColumnFit(source, names, constant)
    end = source.end
    breaks, rows, widths = [Fraction(0)], [], [_FIRST_WIDTH]
    with source.balls.precision():
        while breaks[-1] < end:
            a, width = breaks[-1], widths[-1]
            b = min(a + width, end)
            coefficients = fit(a, b)
            if width > _MIN_WIDTH and not _is_resolved(coefficients, scales, names):
                widths[-1:] = [width / 2, width / 2]
                continue
            widths.pop()
            if not widths:
                widths = [_FIRST_WIDTH]
            breaks.append(b)
            rows.append(_rounded(coefficients, grids, names, float(a)))
            if progress is not None:
                progress(float(b))
    table = np.array(rows, dtype=np.float64)  # piece, column, order, hi or lo
    return Dense(
        breaks=np.array([float(t) for t in breaks]),
        hi={name: np.ascontiguousarray(table[:, i, :, 0]) for i, name in enumerate(names)},
        lo={name: np.ascontiguousarray(table[:, i, :, 1]) for i, name in enumerate(names)},
    )


class _ColumnFit:
    """Interpolation at the Chebyshev nodes, as a matrix product in ball arithmetic."""

    def __init__(
        self,
        source: Source,
        names: Sequence[str],
        constant: Mapping[str, flint.arb | Fraction],
    ) -> None:
        self.source, self.names = source, names
        with source.balls.precision():
            self.constant = {
                name: source.balls.number(x) if isinstance(x, Fraction) else x
                for name, x in constant.items()
            }
            angle = [flint.fmpq(2 * j + 1, 2 * NODES) for j in range(NODES)]
            self.nodes = [flint.arb.cos_pi_fmpq(x) for x in angle]
            self.transform = flint.arb_mat(
                [
                    [flint.arb.cos_pi_fmpq(k * x) * (1 if k == 0 else 2) / NODES for x in angle]
                    for k in range(NODES)
                ]
            )

    def __call__(self, a: Fraction, b: Fraction) -> list[list[flint.arb]]:
        """Coefficients on [a, b] by column and order."""
        middle, half = (a + b) / 2, (b - a) / 2
        mid_ball, half_ball = (exact_ball(x) for x in (middle, half))
        values = []
        for x in self.nodes:
            t = mid_ball + half_ball * x
            row = self.source.near(t, middle + half * Fraction(float(x.mid())))
            values.append([self.constant.get(name, row[name]) for name in self.names])
        product = self.transform * flint.arb_mat(values)
        table = [[product[k, i] for k in range(NODES)] for i in range(len(self.names))]
        for i, name in enumerate(self.names):
            if name in self.constant:
                table[i] = [self.constant[name], *[flint.arb(0)] * (NODES - 1)]
        return table


def _is_resolved(
    table: Sequence[Sequence[flint.arb]], scales: Mapping[str, float], names: Sequence[str]
) -> bool:
    for name, row in zip(names, table, strict=True):
        tail = sum(abs(float(c.mid())) for c in row[-3:])
        if tail > scales[name] * 2.0**-_TAIL_BITS:
            return False
    return True


def _rounded(
    table: Sequence[Sequence[flint.arb]], grids: Sequence[int], names: Sequence[str], t: float
) -> list[list[tuple[float, float]]]:
    """Coefficients rounded to the column's grid, as hi and lo."""
    out = []
    for name, row, grid in zip(names, table, grids, strict=True):
        pairs = []
        for order, c in enumerate(row):
            scaled = c * flint.arb(2) ** grid
            n = (scaled + flint.arb(0.5)).floor().unique_fmpz()
            if n is None:
                raise UndecidedError(
                    f"{name}: Chebyshev coefficient {order} of the piece at t = {t:g} s "
                    "is not decided by the digits at hand"
                )
            up = max(-grid, 0)
            exact = Enclosure(int(n) << up, int(n) << up, grid + up)
            pairs.append(hi_lo(exact, name))
        out.append(pairs)
    return out
