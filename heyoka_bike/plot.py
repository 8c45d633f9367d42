"""Figures of the reference: one for each maneuver, as figures 2 to 4 of the benchmark."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import InputError, MissingPackageError
from heyoka_bike.exact import Exact
from heyoka_bike.output_files import write_output
from heyoka_bike.parameters import STATE_INPUTS
from heyoka_bike.reference import ReferenceManeuver

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")

_PANELS = (
    ("roll_angle", "roll angle"),
    ("roll_rate", "roll rate"),
    ("steer_angle", "steer angle"),
    ("steer_rate", "steer rate"),
    ("forward_speed", "forward speed"),
)
_ENERGIES = ("kinetic_energy", "potential_energy", "mechanical_energy")
_ENERGY_LABEL = "change of energy [J]"
_UNITS = {"rad": "rad", "rad s-1": "rad/s", "m s-1": "m/s", "J": "J"}

# Okabe and Ito's palette, https://jfly.uni-koeln.de/color/; dashes tell the lines apart without it.
_BLUE, _VERMILLION, _BLACK = "#0072B2", "#D55E00", "#000000"
_ENERGY_LINES: Mapping[str, Any] = {
    "kinetic_energy": {"color": _BLUE, "linestyle": "-"},
    "potential_energy": {"color": _VERMILLION, "linestyle": (0, (4, 1.5))},
    "mechanical_energy": {"color": _BLACK, "linestyle": (0, (1, 1.2))},
}

_STYLE = {
    "axes.grid": True,
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "axes.formatter.useoffset": False,
    "figure.titlesize": 10,
    "font.size": 8.5,
    "grid.color": "#d5d5d5",
    "grid.linewidth": 0.5,
    "legend.fontsize": 7.5,
    "lines.linewidth": 1.3,
    "pdf.fonttype": 42,
    "svg.hashsalt": "heyoka_bike",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
}
_SIZE = (7.0, 6.4)  # [inch]; the width of a printed page of text
_DPI = 200
# No date and no version: the same set gives the same file.
_METADATA: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def draw(maneuver: ReferenceManeuver) -> Figure:
    """Figure of a maneuver: roll, steer and their rates, forward speed and energies over time.

    Units are rad, rad/s, m/s, J and s. Energies are drawn as their change from the initial value,
    which the legend gives: the change is a small part of them. The columns are the default
    definitions (see `columns`).

    Parameters
    ----------
    maneuver : ReferenceManeuver
        From `reference.load_reference`.

    Returns
    -------
    matplotlib.figure.Figure
        Not registered with pyplot; `render` gives the bytes of a file.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE, layout="constrained")
        figure.suptitle(_title(maneuver), parse_math=False)
        axes = figure.subplots(3, 2, sharex=True).ravel()
        for ax, (name, label) in zip(axes, _PANELS, strict=False):
            ax.plot(maneuver.time, maneuver.rows[name], color=_BLUE)
            ax.set_ylabel(f"{label} [{_unit(maneuver, name)}]")
        _draw_energies(figure, axes[-1], maneuver)
        for ax in axes:
            ax.set_xlim(float(maneuver.time[0]), float(maneuver.time[-1]))
        for ax in axes[-2:]:
            ax.set_xlabel("time [s]")
        figure.align_ylabels(axes)
    return figure


def render(figure: Figure, file_format: str) -> bytes:
    """Bytes of a figure as a file: ``png``, ``svg`` or ``pdf``.

    Raises
    ------
    InputError
        Another format.
    """
    check_format(file_format)
    buffer = io.BytesIO()
    with style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        FigureCanvasAgg(figure)
        figure.savefig(buffer, format=file_format, dpi=_DPI, metadata=_METADATA[file_format])
    return buffer.getvalue()


def save(figure: Figure, path: Path) -> None:
    """Write a figure to a file, in the format of its suffix; folders on the way are made.

    Raises
    ------
    InputError
        The suffix is not one of `FORMATS`, or the file cannot be written.
    """
    data = render(figure, path.suffix.removeprefix(".").lower())
    write_output(path, data)


def check_format(file_format: str) -> None:
    """Raise `InputError` for a format other than `FORMATS`."""
    if file_format not in FORMATS:
        raise InputError(f"found format '{file_format}', expected {', '.join(FORMATS)}")


def _draw_energies(figure: Figure, ax: Axes, maneuver: ReferenceManeuver) -> None:
    for name in _ENERGIES:
        values = maneuver.rows[name]
        label = f"{name.replace('_', ' ')}, initially {values[0]:.1f} J"
        ax.plot(maneuver.time, values - values[0], label=label, **_ENERGY_LINES[name])
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


def _unit(maneuver: ReferenceManeuver, name: str) -> str:
    unit = maneuver.units[name]
    return _UNITS.get(unit, unit)


def style() -> Any:
    """Context of this module's style on top of matplotlib's own, whatever the user's is."""
    try:
        import matplotlib.style
    except ImportError:
        raise MissingPackageError(
            'matplotlib is not installed; drawing needs it (pip install "heyoka_bike[plot]")'
        ) from None
    return matplotlib.style.context(["default", _STYLE])
