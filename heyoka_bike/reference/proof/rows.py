"""The rows of a table: enclosures of the exact values, and their correct rounding."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Evaluator, Trajectory, evaluator, row_times
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.numbers.exact import shortest_decimal
from heyoka_bike.numbers.rounding import Enclosure, Value, decimal_digits, hi_lo, upward
from heyoka_bike.reference.layout import text_files
from heyoka_bike.reference.proof.first_row import exact_columns
from heyoka_bike.reference.values import RoundedRows

TEXT_DIGITS = 50
EVALUATION_BITS = 64
"""Bits that evaluation uses beyond those of the run."""

Progress = Callable[[float], None]


def constant_columns(run: Trajectory) -> dict[str, Value]:
    """Columns whose exact value does not change: the energy, and all of a steady motion.

    The energy follows from the initial state alone.
    """
    exact = exact_columns(run.bicycle, run.maneuver)
    if "mechanical_energy" in exact and not run.maneuver.is_straight:
        return {"mechanical_energy": exact["mechanical_energy"]}
    equations = Equations.of(run.bicycle, Balls(run.bits + EVALUATION_BITS))
    with equations.precision():
        start = equations.columns(initial_state(equations, run.maneuver))
    if run.maneuver.is_straight:
        return {**start, **exact}
    return {"mechanical_energy": start["mechanical_energy"]}


def round_rows(
    run: Trajectory, certificate: Certificate, progress: Progress = lambda _: None
) -> RoundedRows:
    """Round every entry of the rows.

    Row 0 follows from the initial state in exact arithmetic, as far as it is rational; the others
    from the candidate and the certified bound on its distance from the exact motion.

    Raises
    ------
    UndecidedError
        Enclosures that do not decide a rounding, named.
    """
    at = evaluator(run, run.bits + EVALUATION_BITS, certificate)
    first = exact_columns(run.bicycle, run.maneuver)
    constant = constant_columns(run)
    enclosed = enclose_rows(at, first, constant, progress)
    names = [c.name for c in COLUMNS]
    rounded = round_columns(run.maneuver, names, enclosed, _nearest)
    text = {
        name: tuple(
            decimal_digits(row[name], TEXT_DIGITS, f"{run.maneuver.name}: {name}, row {i}")
            for i, row in enumerate(enclosed)
        )
        for name in BENCHMARK_COLUMNS
    }
    return RoundedRows(*rounded, text=text)


def round_columns(
    maneuver: Maneuver, names: Sequence[str], rows: Iterable[Mapping[str, Any]],
    rounded: Callable[[Any, str], tuple[float, float, float]],
) -> Sequence[dict[str, Array]]:  # fmt: skip
    """Columns of hi, lo and bound, by `rounded` of a value and what it is called."""
    table = np.array(
        [
            [rounded(row[name], f"{maneuver.name}: {name}, row {i}") for name in names]
            for i, row in enumerate(rows)
        ]
    ).transpose(2, 1, 0)
    return [dict(zip(names, np.ascontiguousarray(part), strict=True)) for part in table]


def _nearest(x: Enclosure | Fraction, name: str) -> tuple[float, float, float]:
    hi, lo = hi_lo(x, name)
    return hi, lo, distance(x, hi, lo)


def render_texts(maneuvers: Sequence[Maneuver], rows: Sequence[RoundedRows]) -> dict[str, bytes]:
    """The text files: one of 25 columns, or one of 9 for each maneuver on a grid of its own."""
    files = {}
    for file in text_files(maneuvers):
        first = maneuvers[file.numbers[0] - 1]
        times = [shortest_decimal(first.time(i), TEXT_DIGITS) for i in range(first.rows)]
        columns = [
            r.text[name] if file.is_long else [f"{x:.17g}" for x in r.hi[name]]
            for r in (rows[number - 1] for number in file.numbers)
            for name in BENCHMARK_COLUMNS
        ]
        lines = (" ".join(row) for row in zip(times, *columns, strict=True))
        files[file.name] = ("\n".join(lines) + "\n").encode()
    return files


def distance(x: Enclosure | Fraction, hi: float, lo: float) -> float:
    """Upper bound, as binary64, of the distance of an exact number from hi + lo."""
    if isinstance(x, Fraction):
        return upward(abs(x - Fraction(hi) - Fraction(lo)))
    return x.minus(hi).minus(lo).size()


def enclose_rows(
    at: Evaluator, first: Mapping[str, Fraction], constant: Mapping[str, Value],
    progress: Progress = lambda _: None, *, is_proof: bool = True,
) -> Sequence[dict[str, Enclosure | Fraction]]:  # fmt: skip
    """Every column of every row as far as it is known: row 0 and constants, then the others.

    In a proof what is constant has to meet its enclosure by the state.
    """
    rows = []
    with at.balls.precision():
        for i, t in enumerate(row_times(at.trajectory.maneuver)):
            columns = at.columns(t)
            for name, x in constant.items() if is_proof else ():
                if not columns[name].overlaps(x if isinstance(x, flint.arb) else exact_ball(x)):
                    raise NotCertifiedError(
                        f"{at.trajectory.maneuver.name}: {name}, row {i}: is {columns[name]} by "
                        f"the state, and {x} by its being constant"
                    )
            row: dict[str, Value] = {**columns, **constant}
            if i == 0:
                row |= first
            rows.append(
                {name: x if isinstance(x, Fraction) else Enclosure.of(x) for name, x in row.items()}
            )
            progress(float(t))
    return rows


def rounded_times(maneuver: Maneuver) -> Double:
    """Times of the rows [s], of shape (rows,)."""
    hi, lo = np.array([hi_lo(t, "time") for t in row_times(maneuver)]).T
    return hi.copy(), lo.copy()
