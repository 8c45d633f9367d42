"""The numbers of one maneuver, rounded and ready to be written.

From the trajectory to rows (each value the correctly rounded exact one, with its rest), decimal
text and dense output.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import flint
import numpy as np
from numpy.typing import NDArray

from heyoka_bike.dense import Dense, interpolate
from heyoka_bike.exact_field import exact_columns
from heyoka_bike.initial import initial_state
from heyoka_bike.integration import integrate
from heyoka_bike.outputs import BENCHMARK_COLUMNS, COLUMNS, energies, unfold
from heyoka_bike.parameters import Bicycle, Maneuver
from heyoka_bike.precision import Precision
from heyoka_bike.rounding import Enclosure, decimal_digits, hi_lo
from heyoka_bike.trajectory import Drift, Evaluator, Trajectory, evaluator, row_times

TEXT_DIGITS = 50
_EVALUATION_BITS = 64
_LOST_DIGITS = 8

Progress = Callable[[str, float], None]
"""Called with the stage and the time reached in it [s]."""

STAGES = ("integrate", "rows", "dense")


@dataclass(frozen=True)
class Table:
    """Everything published about one maneuver.

    Attributes
    ----------
    trajectory : Trajectory
    drift : Drift
    time, time_lo : ndarray, shape (rows,)
        Time of the rows [s] as hi + lo.
    hi, lo : mapping of str to ndarray, shape (rows,)
        Columns by name (see `outputs.COLUMNS`), SI units.
    text : mapping of str to tuple of str
        The eight benchmark columns with 50 significant digits.
    dense : Dense
    """

    trajectory: Trajectory
    drift: Drift
    time: NDArray[np.float64]
    time_lo: NDArray[np.float64]
    hi: Mapping[str, NDArray[np.float64]]
    lo: Mapping[str, NDArray[np.float64]]
    text: Mapping[str, tuple[str, ...]]
    dense: Dense

    @property
    def maneuver(self) -> Maneuver:
        return self.trajectory.maneuver


def tabulate(
    bicycle: Bicycle, maneuver: Maneuver, digits: int, progress: Progress | None = None
) -> Table:
    """Integrate a maneuver at `digits` decimal digits and round everything that is published.

    Raises
    ------
    SingularMotionError
        The motion meets a singularity before its end.
    UndecidedError
        A rounding that the digits do not decide, named.
    """
    report = progress or (lambda stage, t: None)
    run = integrate(
        bicycle, maneuver, Precision.of(digits), progress=lambda t: report("integrate", t)
    )
    at = evaluator(run, run.bits + _EVALUATION_BITS)
    exact = exact_columns(bicycle, maneuver)
    is_constant = maneuver.is_straight and len(exact) == len(COLUMNS)
    constant = exact if is_constant else {}
    with at.balls.precision():
        energy = _initial_energy(at, bicycle, maneuver, exact)
        rows = _rows(at, exact, constant, energy, report)
        scales = _scales(rows)
        margins = {
            name: Fraction(max(scale, 1.0)) / 10 ** (digits - _LOST_DIGITS)
            for name, scale in scales.items()
        }
        enclosed = [
            {
                name: x if isinstance(x, Fraction) else Enclosure.of(x, margins[name])
                for name, x in row.items()
            }
            for row in rows
        ]
    hi, lo = _hi_lo(enclosed)
    text = {
        name: tuple(
            decimal_digits(row[name], TEXT_DIGITS, f"{name}, row {i}")
            for i, row in enumerate(enclosed)
        )
        for name in BENCHMARK_COLUMNS
    }
    with at.balls.precision():
        fixed = {name: at.balls.number(x) for name, x in constant.items()}
        fixed["mechanical_energy"] = (
            at.balls.number(energy) if isinstance(energy, Fraction) else energy
        )
    dense = interpolate(at, scales, fixed, lambda t: report("dense", t))
    times = [hi_lo(t, "time") for t in row_times(maneuver)]
    return Table(
        trajectory=run,
        drift=at.drift(),
        time=np.array([t[0] for t in times]),
        time_lo=np.array([t[1] for t in times]),
        hi=hi,
        lo=lo,
        text=text,
        dense=dense,
    )


_Value = flint.arb | Fraction


def _initial_energy(
    at: Evaluator, bicycle: Bicycle, maneuver: Maneuver, exact: Mapping[str, Fraction]
) -> _Value:
    """The mechanical energy, which the exact motion keeps, from the initial state alone."""
    if "mechanical_energy" in exact:
        return exact["mechanical_energy"]
    k, balls = at.constants, at.balls
    state = initial_state(bicycle, maneuver, k, balls)
    o, u = unfold(k, balls, state, is_regular=True)
    e = energies(k, o, u)
    total: flint.arb = e.potential + e.kinetic
    return total


def _rows(
    at: Evaluator, exact: Mapping[str, Fraction], constant: Mapping[str, Fraction],
    energy: _Value, report: Progress,
) -> list[dict[str, _Value]]:  # fmt: skip
    rows: list[dict[str, _Value]] = []
    for i, t in enumerate(row_times(at.trajectory.maneuver)):
        row: dict[str, _Value] = dict(at.columns(t))
        row["mechanical_energy"] = energy
        row |= exact if i == 0 else constant
        rows.append(row)
        report("rows", float(t))
    return rows


def _scales(rows: list[dict[str, _Value]]) -> dict[str, float]:
    """Largest absolute value of each column."""

    def size(x: _Value) -> float:
        return abs(float(x)) if isinstance(x, Fraction) else abs(float(x.mid()))

    return {c.name: max(size(row[c.name]) for row in rows) for c in COLUMNS}


def _hi_lo(
    rows: list[dict[str, Enclosure | Fraction]],
) -> tuple[dict[str, NDArray[np.float64]], dict[str, NDArray[np.float64]]]:
    hi, lo = {}, {}
    for column in COLUMNS:
        name = column.name
        pairs = np.array([hi_lo(row[name], f"{name}, row {i}") for i, row in enumerate(rows)])
        hi[name], lo[name] = np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1])
    return hi, lo
