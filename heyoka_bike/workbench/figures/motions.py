"""Figures of the motions: over time (as figures 2 to 4 of the benchmark), phases, paths."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from heyoka_bike.bicycle.parameters import STATE_INPUTS
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.scoring.evidence.words import unit_text
from heyoka_bike.workbench.style import BLACK, BLUE, LINES, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = (
    ("roll_angle", "roll angle"),
    ("roll_rate", "roll rate"),
    ("steer_angle", "steer angle"),
    ("steer_rate", "steer rate"),
    ("forward_speed", "forward speed"),
)
_ENERGY_COLUMNS = ("kinetic_energy", "potential_energy", "mechanical_energy")
_ENERGY_LABEL = "change of energy [J]"
_HEIGHT_OF_FIGURE = 6.4  # [inch]

PORTRAITS = (
    ("roll_angle", "roll_rate"),
    ("steer_angle", "steer_rate"),
    ("roll_angle", "steer_angle"),
)
"""Columns along the horizontal and the vertical axis."""

PORTRAIT_POINTS = 2001
"""Points of a curve: the benchmark's fastest oscillation turns less than 2 degrees between two."""

_PORTRAYED = tuple(dict.fromkeys(name for pair in PORTRAITS for name in pair))
_ROW_HEIGHT, _REST_HEIGHT, _PAD = 2.1, 0.35, 0.06  # [inch]
_STYLE_OF_START = {
    "marker": "o",
    "markersize": 4.5,
    "markerfacecolor": "white",
    "markeredgecolor": BLACK,
}
_END = {"marker": "s", "markersize": 3.5, "markerfacecolor": BLACK, "markeredgecolor": BLACK}

PATH_POINTS = 1001
_PATH = ("rear_contact_x", "rear_contact_y")
_TURNING = ("yaw_rate", "forward_speed_contact")
_PATH_HEIGHT, _PATH_REST = 1.9, 0.3  # [inch]


def maneuver(reference: Reference, numbers: Sequence[int]) -> Figure:
    """Draw a maneuver: roll, steer and their rates, forward speed and energies over time.

    Units are rad, rad/s, m/s, J and s. Energies are drawn as changes from the initial value, which
    the legend states, because the changes are small. The columns are the default
    definitions (see `columns`).

    Parameters
    ----------
    reference : Reference
        From `reference.load_reference`.
    numbers
        The number of one maneuver.

    Returns
    -------
    matplotlib.figure.Figure
        Not registered with pyplot; `style.render` gives the bytes of a file.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    (number,) = numbers
    shown = reference[number]
    with drawing(_HEIGHT_OF_FIGURE) as figure:
        figure.suptitle(_title(shown), parse_math=False)
        axes = figure.subplots(3, 2, sharex=True).ravel()
        for ax, (name, label) in zip(axes, _PANELS, strict=False):
            ax.plot(shown.time, shown.rows[name], color=BLUE)
            ax.set_ylabel(f"{label} [{unit_text(shown.units[name])}]")
        _draw_energies(figure, axes[-1], shown)
        for ax in axes:
            ax.set_xlim(float(shown.time[0]), float(shown.time[-1]))
        for ax in axes[-2:]:
            ax.set_xlabel("time [s]")
        figure.align_ylabels(axes)
    return figure


def _draw_energies(figure: Figure, ax: Axes, maneuver: ReferenceManeuver) -> None:
    for name, look in zip(_ENERGY_COLUMNS, LINES, strict=False):
        values = maneuver.rows[name]
        label = f"{name.replace('_', ' ')}, initially {values[0]:.1f} J"
        ax.plot(maneuver.time, values - values[0], label=label, **look)
    ax.set_ylabel(_ENERGY_LABEL)
    # Put the legend below the axes. Inside the axes it would cover the curves of some maneuver.
    figure.legend(
        *ax.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False,
        handlelength=2.2, columnspacing=1.5,
    )  # fmt: skip


def _title(maneuver: ReferenceManeuver) -> str:
    """Return the title of a figure: the name of a maneuver, and its nonzero initial values."""
    parts = []
    for key in ("speed", "roll", "steer", "roll_rate", "steer_rate"):
        value = Exact.parse(maneuver.inputs[key])
        if not value.is_zero:
            what = "forward speed" if key == "speed" else key.replace("_", " ")
            parts.append(f"{what} {float(value):g} {STATE_INPUTS[key].unit}")
    name = maneuver.name[:1].upper() + maneuver.name[1:]
    return f"{name}: initial {', '.join(parts) or 'state of rest'}"


def phase(reference: Reference, numbers: Sequence[int]) -> Figure:
    """Draw a row of phase portraits for each maneuver; angles in rad, rates in rad/s.

    A circle marks the start of the motion, a square its end.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with drawing(_ROW_HEIGHT * len(numbers) + _REST_HEIGHT) as figure:
        figure.set_layout_engine("constrained", w_pad=_PAD, h_pad=_PAD)
        grid = figure.subplots(len(numbers), len(PORTRAITS), squeeze=False)
        for number, row in zip(numbers, grid, strict=True):
            shown = reference[number]
            end = float(shown.duration)
            values = shown.approximate(np.linspace(0.0, end, PORTRAIT_POINTS), _PORTRAYED)
            for ax, (across, up) in zip(row, PORTRAITS, strict=True):
                x, y = values[across], values[up]
                ax.plot(x, y, color=BLUE, linewidth=1.0)
                ax.plot(x[:1], y[:1], linestyle="none", label="0 s", **_STYLE_OF_START)
                ax.plot(x[-1:], y[-1:], linestyle="none", label=f"{end:g} s", **_END)
                ax.set_xlabel(f"{across.replace('_', ' ')} [{unit_text(shown.units[across])}]")
                ax.set_ylabel(f"{up.replace('_', ' ')} [{unit_text(shown.units[up])}]")
                ax.locator_params(nbins=5)
            row[0].set_title(shown.name, loc="left", fontsize=9, parse_math=False)
        grid[0, -1].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
        figure.align_ylabels(grid)
    return figure


def curvature(reference: Reference, number: int, time: np.ndarray) -> np.ndarray:
    """Return the curvature of the rear contact point's path [1/m], positive to the right."""
    values = reference[number].approximate(time, _TURNING)
    return values["yaw_rate"] / values["forward_speed_contact"]


def path(reference: Reference, numbers: Sequence[int]) -> Figure:
    """Draw a row for each maneuver: the path from above [m], and its curvature over time [1/km].

    Both are positive to the right. The path has different scales along and across. Dots mark full
    seconds.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    DatasetError
        The dataset has no motion.h5.
    """
    with drawing(_PATH_HEIGHT * len(numbers) + _PATH_REST) as figure:
        grid = figure.subplots(len(numbers), 2, squeeze=False)
        for number, (above, over_time) in zip(numbers, grid, strict=True):
            shown = reference[number]
            end = float(shown.duration)
            time, seconds = np.linspace(0.0, end, PATH_POINTS), np.arange(0.0, np.floor(end) + 0.5)
            x, y = (reference.motion[number].approximate(time, _PATH)[name] for name in _PATH)
            above.plot(x, y, color=BLUE, linewidth=1.2)
            at = reference.motion[number].approximate(seconds, _PATH)
            above.plot(*at.values(), linestyle="none", marker="o", markersize=2.5, color=BLACK)
            above.invert_yaxis()
            above.set_ylabel("to the right [m]")
            above.set_title(shown.name, loc="left", fontsize=9, parse_math=False)
            over_time.axhline(0.0, color=BLACK, linewidth=0.5)
            bent = 1000 * curvature(reference, number, time)
            over_time.plot(time, bent, color=BLUE, linewidth=1.2)
            over_time.set_ylabel("curvature [1/km]")
        grid[-1, 0].set_xlabel("path, forward [m]; a dot every second")
        grid[-1, 1].set_xlabel("time [s]")
    return figure
