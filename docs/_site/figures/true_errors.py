"""Errors of other programs over time, and beside them what the benchmark's eq. (1) says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.scores import ColumnScore
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.style import BLACK, BLUE, GREEN, ORANGE, VERMILLION, WIDTH, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RUNS: Mapping[str, str] = {
    "exudyn-h0.01.txt": "Exudyn, step 0.01 s",
    "exudyn-h0.001.txt": "Exudyn, step 0.001 s",
    "scipy-rtol1e-4.txt": "SciPy DOP853, rtol 1e-4",
    "scipy-rtol1e-7.txt": "SciPy DOP853, rtol 1e-7",
    "scipy-rtol1e-10.txt": "SciPy DOP853, rtol 1e-10",
}
"""Files of data/peers and what they are."""

STATE = ("roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate")
"""Columns whose errors are drawn: all of the motion, no energy."""

_LOOKS: tuple[Mapping[str, Any], ...] = (
    {"color": VERMILLION, "linestyle": "-"},
    {"color": ORANGE, "linestyle": (0, (5, 1.5))},
    {"color": BLUE, "linestyle": (0, (7, 1.5, 1.2, 1.5))},
    {"color": BLACK, "linestyle": (0, (1, 1))},
    {"color": GREEN, "linestyle": (0, (10, 2.5))},
)
_SIZE = (WIDTH, 4.1)  # [inch]
# [%]: from below the rounding of binary64 to a motion that has nothing to do with the reference.
_RANGE = (2e-15, 100.0)
_ROUNDING = 100 * 2.0**-53
_NOTE: Mapping[str, Any] = {"fontsize": 7, "va": "bottom", "color": "#404040"}


@dataclass(frozen=True, eq=False, slots=True)
class ProgramErrors:
    """A run of a program over time.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    error : ndarray, shape (n,)
        The largest error of `STATE` so far, each in its own definition [% of the column's scale].
    energy : ndarray, shape (n,)
        Eq. (1) of the rows up to each time [%].
    floor
        What the digits written allow `error` to be at best [%]; None if unknown.
    limit
        What the benchmark allows of eq. (1) [%], in the maneuver that it judges.
    """

    time: Array
    error: Array
    energy: Array
    floor: float | None
    limit: float


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """True errors (left) and eq. (1) (right) of the runs of data/peers, on one scale in percent.

    Parameters
    ----------
    reference : Reference
        Of the benchmark.
    numbers
        Of one maneuver.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    (number,) = numbers
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE, layout="constrained")
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        traces = {label: trace(reference, number, name) for name, label in RUNS.items()}
        for (label, run), look in zip(traces.items(), _LOOKS, strict=True):
            left.plot(run.time, run.error, label=label, **look)
            right.plot(run.time, run.energy, **look)
        end = float(reference[number].duration)
        left.set(xlim=(0.0, end), ylim=_RANGE, yscale="log")
        left.set_title(f"{reference[number].name}: true error so far", fontsize=9, parse_math=False)
        right.set_title("what energy says: eq. (1) so far", fontsize=9)
        left.set_ylabel("largest error of roll, steer, their rates\nand speed [% of their scale]")
        right.set_ylabel("100 (max E - min E) / E$_0$ [%]")
        right.tick_params(labelleft=True)
        for ax in (left, right):
            ax.set_xlabel("time [s]")
            ax.locator_params(axis="y", numticks=10)
        written = [run.floor for run in traces.values() if run.floor is not None]
        _level(left, max(written), "best that 12 digits allow (Exudyn)")
        _level(left, _ROUNDING, "rounding of binary64")
        limit = next(iter(traces.values())).limit
        _level(right, limit, f"limit of the benchmark, {limit:g} %")
        figure.legend(loc="outside lower center", ncols=3, frameon=False, handlelength=3)
    return figure


def trace(reference: Reference, number: int, name: str) -> ProgramErrors:
    """One maneuver of a file of data/peers, each column in the definition that it follows."""
    report = score(read_results(data_folder() / "peers" / name), reference)
    found = next(m for m in report.maneuvers if m.maneuver == number)
    columns = {c.key: c for c in found.columns}
    scales = {key: _scale(reference[number], columns[key]) for key in STATE}
    errors = [np.abs(columns[key].trace.error) / scales[key] for key in STATE]
    floors = [(columns[key].floor, scales[key]) for key in STATE]
    energy = columns["mechanical_energy"].trace.value
    spread = np.maximum.accumulate(energy) - np.minimum.accumulate(energy)
    return ProgramErrors(
        time=columns["roll_angle"].trace.time,
        error=100 * np.maximum.accumulate(np.max(errors, axis=0)),
        energy=100 * spread / energy[0],
        floor=max((100 * floor / scale for floor, scale in floors if floor), default=None),
        limit=next(m.performance_limit for m in report.maneuvers if m.performance_limit),
    )


def _scale(maneuver: ReferenceManeuver, column: ColumnScore) -> float:
    definition = column.as_understood.definition
    return maneuver.scale(
        next(c.name for c in DEFINITIONS[column.key] if c.definition == definition)
    )


def _level(ax: Axes, level: float, what: str) -> None:
    ax.axhline(level, color=BLACK, linewidth=0.6)
    ax.text(0.985, level * 1.3, what, transform=ax.get_yaxis_transform(), ha="right", **_NOTE)
