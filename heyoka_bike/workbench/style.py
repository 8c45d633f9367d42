"""Colours, dashes, fonts and sizes of all figures, and their rendering as a file."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import InputError, required
from heyoka_bike.system.files import write_output

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")

WIDTH = 7.0
"""Width of a figure [inch]: that of the text on a printed page."""

# The palette of Okabe and Ito, which the colour-blind can distinguish:
# https://jfly.uni-koeln.de/color/.
BLUE, VERMILLION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
PURPLE, BLACK = "#CC79A7", "#000000"
SKY, GREY = "#56B4E9", "#999999"

LINES: tuple[Mapping[str, Any], ...] = (
    {"color": BLUE, "linestyle": "-"},
    {"color": VERMILLION, "linestyle": (0, (4, 1.5))},
    {"color": BLACK, "linestyle": (0, (1, 1.2))},
    {"color": GREEN, "linestyle": (0, (7, 1.5, 1.2, 1.5))},
    {"color": ORANGE, "linestyle": (0, (3, 1, 1, 1, 1, 1))},
    {"color": PURPLE, "linestyle": (0, (10, 2.5))},
)
"""Styles of lines in one panel. The dashes distinguish them without colour."""

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
_DPI = 200
# Omit the date and the version of matplotlib, so that the same dataset gives the same file.
_METADATA: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def style() -> Any:
    """Return a context in which matplotlib has the project's style, whatever the user's settings.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    said = 'matplotlib is not installed; drawing needs it (pip install "heyoka_bike[plot]")'
    return required("matplotlib.style", said).context(["default", _STYLE])


@contextmanager
def drawing(height: float) -> Iterator[Figure]:
    """Provide a new figure of this height [inch], for drawing in the project's `style`."""
    with style():
        from matplotlib.figure import Figure

        yield Figure(figsize=(WIDTH, height), layout="constrained")


def render(figure: Figure, file_format: str) -> bytes:
    """Return the bytes of a figure as ``png``, ``svg`` or ``pdf``.

    Raises
    ------
    InputError
        The format is none of these.
    """
    if file_format not in FORMATS:
        raise InputError(f"found format '{file_format}', expected {', '.join(FORMATS)}")
    buffer = io.BytesIO()
    with style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        FigureCanvasAgg(figure)
        figure.savefig(buffer, format=file_format, dpi=_DPI, metadata=_METADATA[file_format])
    return buffer.getvalue()


def save(figure: Figure, path: Path) -> None:
    """Write a figure to a file, in the format of its suffix; missing folders are created.

    Raises
    ------
    InputError
        The suffix is not one of `FORMATS`, or the file cannot be written.
    """
    write_output(path, render(figure, path.suffix.removeprefix(".").lower()))
