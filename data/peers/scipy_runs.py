"""The uncontrolled bicycle with SciPy's solve_ivp, on this project's equations in binary64.

Run from the root of the repository with ``python data/peers/scipy_runs.py``. It integrates the
three maneuvers with DOP853 at each relative tolerance of `TOLERANCES` and writes
``scipy-rtol<tolerance>.txt`` and ``scipy.toml`` beside itself.

The columns have their default definitions. Rows come from solve_ivp's own interpolation
(``t_eval``), at the binary64 nearest to each multiple of the spacing.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.outputs import columns
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.motion.heyoka_adapter import Compiled
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision

HERE = Path(__file__).resolve().parent
BICYCLE = HERE.parent / "bicycles" / "benchmark.toml"
MANEUVERS = HERE.parent / "maneuvers" / "benchmark.toml"

METHOD = "DOP853"
TOLERANCES = ("1e-4", "1e-7", "1e-10")
"""Relative tolerances."""
ATOL_OVER_RTOL = 1e-2
"""Angles and rates are some hundredths: this keeps them from vanishing beside the wheel's spin."""

_BITS = 256
Array = np.ndarray[Any, np.dtype[np.float64]]
Slope = Callable[[float, Array], Array]


class Arrays:
    """NumPy arrays of binary64, to evaluate the columns of all rows at once."""

    def number(self, value: Exact | Fraction | int) -> float:
        raise TypeError("constants come from `float_constants`")

    def sin(self, x: Array) -> Array:
        return np.sin(x)

    def cos(self, x: Array) -> Array:
        return np.cos(x)

    def sqrt(self, x: Array) -> Array:
        return np.sqrt(x)

    def atan2(self, y: Array, x: Array) -> Array:
        return np.arctan2(y, x)

    def sum(self, terms: Iterable[Any]) -> Any:
        return sum(terms)


def slope(bicycle: Bicycle) -> Slope:
    """The right-hand side as solve_ivp calls it, compiled; state without the yaw."""
    equations = right_hand_side(bicycle, Precision.of("binary64"), with_yaw=False)
    compiled = Compiled([rate for _, rate in equations], [x for x, _ in equations])

    def call(_: float, state: Array) -> Array:
        return compiled(state)

    return call


def start(bicycle: Bicycle, maneuver: Maneuver) -> Array:
    """Initial state, without the yaw."""
    equations = Equations.of(bicycle, Balls(_BITS), is_regular=False)
    state = initial_state(equations, maneuver)[:6]
    with equations.precision():
        return np.array([float(x.mid()) for x in state])


def benchmark_columns(bicycle: Bicycle, state: Array) -> Array:
    """Eight columns of the benchmark from states of shape (6, rows)."""
    balls, a = Balls(_BITS), Arrays()
    with balls.precision():
        k = constants(bicycle, balls).convert(lambda x: float(x.mid()))
    o, u = unfold(k, a, state, is_regular=False)
    roll, pitch, steer = state[:3]
    # None of the eight depends on the yaw.
    found = columns(k, a, o, u, roll, pitch, steer, np.zeros_like(roll))
    return np.column_stack([found[name] for name in BENCHMARK_COLUMNS])


def run(bicycle: Bicycle, call: Slope, maneuver: Maneuver, rtol: float) -> tuple[Array, float]:
    """Columns of a maneuver, and the CPU time of the solver [s]."""
    times = np.array([float(maneuver.time(i)) for i in range(maneuver.rows)])
    state = start(bicycle, maneuver)
    begin = time.process_time()
    found = solve_ivp(
        call,
        (times[0], times[-1]),
        state,
        method=METHOD,
        t_eval=times,
        rtol=rtol,
        atol=ATOL_OVER_RTOL * rtol,
    )
    cpu = time.process_time() - begin
    if not found.success:
        raise RuntimeError(found.message)
    return benchmark_columns(bicycle, found.y), cpu


def write_whole(path: Path, text: str) -> None:
    """Write a file so that it is never seen half written."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8", newline="\n")
    os.replace(part, path)


def file_text(times: Sequence[str], values: Array) -> str:
    """One line for each time."""
    lines = (
        " ".join([t, *(f"{x:.17g}" for x in row)]) for t, row in zip(times, values, strict=True)
    )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Integrate everything and write the files."""
    bicycle, maneuvers = read_bicycle(BICYCLE), read_maneuvers(MANEUVERS)
    times = [f"{float(maneuvers[0].time(i)):.12g}" for i in range(maneuvers[0].rows)]
    call = slope(bicycle)
    entries = []
    for tolerance in TOLERANCES:
        runs = [run(bicycle, call, maneuver, float(tolerance)) for maneuver in maneuvers]
        name, cpu = f"scipy-rtol{tolerance}.txt", sum(seconds for _, seconds in runs)
        write_whole(HERE / name, file_text(times, np.hstack([values for values, _ in runs])))
        entries.append(f'[[run]]\nfile = "{name}"\ntolerance = "{tolerance}"\ncpu = "{cpu:.3f}"\n')
        print(f"{name}: {cpu:.3f} s")
    write_whole(HERE / "scipy.toml", "\n".join(entries))


if __name__ == "__main__":
    main()
