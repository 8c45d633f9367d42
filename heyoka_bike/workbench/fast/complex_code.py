"""Four complex linear systems side by side, in the places of half a vector."""

from collections.abc import Sequence

from heyoka_bike.workbench.fast.vector_code import HALF, Code, constant

Pair = tuple[str, str]
"""Names of real and imaginary parts."""


def factor(c: Code, m: list[list[Pair]]) -> list[Pair]:
    """Factors of four complex matrices in their place; the inverses of the pivots.

    Without exchanges: a short step makes the diagonal large, and where the iteration does not
    converge the step is made shorter.
    """
    inverses = []
    for k in range(len(m)):
        re, im = m[k][k]
        square = c.fused(re, re, c.operation("*", im, im, HALF), HALF)
        over = c.operation("/", constant(HALF, 1.0), square, HALF)
        inverse = (
            c.operation("*", re, over, HALF),
            c.negative(c.operation("*", im, over, HALF), HALF),
        )
        inverses.append(inverse)
        for i in range(k + 1, len(m)):
            m[i][k] = _times(c, m[i][k], inverse)
            for j in range(k + 1, len(m)):
                m[i][j] = _minus_times(c, m[i][j], m[i][k], m[k][j])
    return inverses


def solve(
    c: Code, m: Sequence[Sequence[Pair]], inverses: Sequence[Pair], right: Sequence[Pair]
) -> list[Pair]:
    """Solutions of four complex systems, from what `factor` left of their matrices."""
    x = list(right)
    for k in range(len(m)):
        for i in range(k + 1, len(m)):
            x[i] = _minus_times(c, x[i], m[i][k], x[k])
    for k in reversed(range(len(m))):
        x[k] = _times(c, x[k], inverses[k])
        for i in range(k):
            x[i] = _minus_times(c, x[i], m[i][k], x[k])
    return x


def _times(c: Code, x: Pair, y: Pair) -> Pair:
    (a, b), (p, q) = x, y
    re = c.fused(a, p, c.negative(c.operation("*", b, q, HALF), HALF), HALF)
    im = c.fused(a, q, c.operation("*", b, p, HALF), HALF)
    return re, im


def _minus_times(c: Code, z: Pair, x: Pair, y: Pair) -> Pair:
    """What is left of z without the product."""
    (a, b), (p, q) = x, y
    minus = c.negative(a, HALF)
    re = c.fused(b, q, c.fused(minus, p, z[0], HALF), HALF)
    im = c.fused(c.negative(b, HALF), p, c.fused(minus, q, z[1], HALF), HALF)
    return re, im
