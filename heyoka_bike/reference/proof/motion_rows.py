"""The whole motion of a maneuver: every column of motion.h5 with its certified bounds."""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

import flint
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    NonnegativeRoots,
    dense_columns,
    motion_columns,
)
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.trajectory import Certificate, Trajectory, row_times
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.rounding import Enclosure, few_bits, hi_lo
from heyoka_bike.reference.proof.dense import interpolate
from heyoka_bike.reference.proof.dense_bound import (
    BITS,
    Expanded,
    Expansion,
    bound_pieces,
    expansions,
)
from heyoka_bike.reference.proof.integrals import Stretch, with_integrals
from heyoka_bike.reference.proof.rows import EVALUATION_BITS, distance
from heyoka_bike.reference.values import Dense, Values

Progress = Callable[[float], None]

_NOTHING_BITS = 166
"""An enclosure of zero is published as zero where it is narrower than 2^-166 = 1e-50."""

_SMALLEST_SCALE = 2.0**-40
"""Of the dense columns, so that one that vanishes (the longitudinal force on a rear wheel without
inertia, say) has coefficients of zero: its grid of 2^-152 is far above the width of its balls."""


def tabulate_motion(
    run: Trajectory, certificate: Certificate, progress: Progress | None = None
) -> tuple[Values, Dense]:
    """The whole motion along a certified candidate: rows, and dense output where there is.

    Raises
    ------
    NotCertifiedError
        A column is not shown to be analytic.
    UndecidedError
        Enclosures that do not decide a rounding, named.
    """
    stretches = list(with_integrals(run, certificate))
    rows = round_motion(run, stretches, progress)
    parts = list(motion_expansions(stretches))
    scales = {name: max(rows.scale(name), _SMALLEST_SCALE) for name in DENSE_COLUMNS}
    dense = interpolate(_Source(parts, Balls(BITS)), scales, {})
    return rows, bound_motion(run, parts, dense)


def motion_expansions(stretches: Sequence[Stretch]) -> Iterator[Expansion]:
    """Expansions of the dense columns along all pieces."""
    along = Expanded.of(stretches[0].piece.run, dense_columns)
    for stretch in stretches:
        yield from expansions(stretch.piece, stretch.bounds, along)


def bound_motion(run: Trajectory, parts: Sequence[Expansion], dense: Dense) -> Dense:
    """The dense output of a motion with its certified bounds."""
    return bound_pieces(run, parts, dense, DENSE_COLUMNS, {})


def round_motion(
    run: Trajectory, stretches: Sequence[Stretch], progress: Progress | None = None
) -> Values:
    """The rows of `MOTION_COLUMNS`, rounded.

    hi and lo are zero where the enclosure holds zero, and is so narrow that the bound says all
    there is to know.
    """
    names = [c.name for c in MOTION_COLUMNS]
    table = np.empty((run.maneuver.rows, len(names), 3))
    for i, row in enumerate(_enclosed(run, stretches)):
        for j, name in enumerate(names):
            table[i, j] = _rounded(row[name], f"{run.maneuver.name}: {name}, row {i}")
        if progress is not None:
            progress(float(run.maneuver.time(i)))
    return Values(
        *(
            {name: np.ascontiguousarray(table[:, j, part]) for j, name in enumerate(names)}
            for part in range(3)
        )
    )


def _enclosed(run: Trajectory, stretches: Sequence[Stretch]) -> Iterator[dict[str, flint.arb]]:
    """Enclosures of all columns at the rows."""
    balls = NonnegativeRoots(run.bits + EVALUATION_BITS)
    starts = [s.piece.t0 for s in stretches]
    at, polynomials = -1, [flint.arb_poly()]
    equations = Equations.of(run.bicycle, balls, is_regular=run.is_regular)
    with balls.precision():
        for t in row_times(run.maneuver):
            if (i := bisect_right(starts, t) - 1) != at:
                at, polynomials = i, [flint.arb_poly(list(row)) for row in stretches[i].piece.rows]
            piece = stretches[i].piece
            s, unit = exact_ball((t - piece.t0) / piece.h), flint.arb(2) ** -piece.grid
            state = [
                flint.arb(p(s) * unit, exact_ball(bound).upper())
                for p, bound in zip(polynomials, stretches[i].bounds, strict=True)
            ]
            if t == 0:
                # The integrals begin at zero, exactly, and the yaw with them.
                state[6:] = [balls.number(0)] * len(state[6:])
            yield motion_columns(equations, state)


def _rounded(x: flint.arb, name: str) -> tuple[float, float, float]:
    """hi, lo and bound."""
    if not x.is_finite():
        raise UndecidedError(f"{name}: the digits at hand do not enclose it")
    enclosed = Enclosure.of(x)
    hi, lo = 0.0, 0.0
    if not _is_nothing(enclosed):
        nearest = enclosed.binary64()
        if nearest is not None and _is_nothing(enclosed.minus(nearest)):
            hi = nearest
        else:
            hi, lo = hi_lo(enclosed, name)
    return hi, lo, few_bits(distance(enclosed, hi, lo))


def _is_nothing(x: Enclosure) -> bool:
    """Whether an enclosure is a narrow one of zero."""
    return x.low <= 0 <= x.high and (x.high - x.low) << _NOTHING_BITS <= 1 << x.grid


class _Source:
    """The expansions as something to interpolate."""

    def __init__(self, parts: Sequence[Expansion], balls: Balls) -> None:
        self.parts, self.balls = parts, balls
        self.end = parts[-1].t1
        self._starts = [part.t0 for part in parts]

    def near(self, t: flint.arb, about: Fraction) -> dict[str, flint.arb]:
        part = self.parts[max(bisect_right(self._starts, about) - 1, 0)]
        s = (t - exact_ball(part.t0)) / exact_ball(part.h)
        return {name: p(s) for name, p in zip(DENSE_COLUMNS, part.polynomials, strict=True)}
