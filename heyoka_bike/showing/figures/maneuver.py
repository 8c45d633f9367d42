"""Figures 2 to 4 of the benchmark: roll, steer, their rates, speed and energies of a maneuver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from heyoka_bike.bicycle.parameters import STATE_INPUTS
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.showing.figures.style import BLUE, LINES, drawing, unit

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
_ENERGIES = ("kinetic_energy", "potential_energy", "mechanical_energy")
_ENERGY_LABEL = "change of energy [J]"
_HEIGHT = 6.4  # [inch]


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """Figure of a maneuver: roll, steer and their rates, forward speed and energies over time.

    Units are rad, rad/s, m/s, J and s. Energies are drawn as their change from the initial value,
    which the legend gives: the change is a small part of them. The columns are the default
    definitions (see `columns`).

    Parameters
    ----------
    reference : Reference
        From `reference.load_reference`.
    numbers
        Of one maneuver.

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
    maneuver = reference[number]
    with drawing(_HEIGHT) as figure:
        figure.suptitle(_title(maneuver), parse_math=False)
        axes = figure.subplots(3, 2, sharex=True).ravel()
        for ax, (name, label) in zip(axes, _PANELS, strict=False):
            ax.plot(maneuver.time, maneuver.rows[name], color=BLUE)
            ax.set_ylabel(f"{label} [{unit(maneuver.units, name)}]")
        _draw_energies(figure, axes[-1], maneuver)
        for ax in axes:
            ax.set_xlim(float(maneuver.time[0]), float(maneuver.time[-1]))
        for ax in axes[-2:]:
            ax.set_xlabel("time [s]")
        figure.align_ylabels(axes)
    return figure


def _draw_energies(figure: Figure, ax: Axes, maneuver: ReferenceManeuver) -> None:
    for name, look in zip(_ENERGIES, LINES, strict=False):
        values = maneuver.rows[name]
        label = f"{name.replace('_', ' ')}, initially {values[0]:.1f} J"
        ax.plot(maneuver.time, values - values[0], label=label, **look)
    ax.set_ylabel(_ENERGY_LABEL)
    # Below the axes: inside, it would lie on the curves of one maneuver or another.
    figure.legend(
        *ax.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False,
        handlelength=2.2, columnspacing=1.5,
    )  # fmt: skip


def _title(maneuver: ReferenceManeuver) -> str:
    """Name and initial state, without what is zero there."""
    parts = []
    for key in ("speed", "roll", "steer", "roll_rate", "steer_rate"):
        value = Exact.parse(maneuver.inputs[key])
        if not value.is_zero:
            what = "forward speed" if key == "speed" else key.replace("_", " ")
            parts.append(f"{what} {float(value):g} {STATE_INPUTS[key].unit}")
    name = maneuver.name[:1].upper() + maneuver.name[1:]
    return f"{name}: initial {', '.join(parts) or 'state of rest'}"
