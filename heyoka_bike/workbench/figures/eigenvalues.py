"""Eigenvalues of the linearised bicycle over forward speed, and where it is stable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import floor
from typing import TYPE_CHECKING, Any

import numpy as np

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.bicycle.stability.linear import Linearisation, linearise
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference
from heyoka_bike.workbench.style import BLACK, BLUE, GREEN, VERMILLION, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FASTEST = 10.0
"""Largest speed in the figure [m/s]."""

_HEIGHT_OF_FIGURE = 5.0  # [inch]
_DIGITS_OF_SPEEDS = 15
_DECIMALS = 5
_POINTS_OF_BRANCH = 100
# Distance of the first and last point of a branch from its ends, as a fraction of its length. Two
# eigenvalues meet at an end and differ there by the square root of this distance: by 1e-4 of the
# width of the figure, which is enough to distinguish them.
_SPEEDS_APART = 1e-8
# Range of real parts that is shown [1/s]. Outside this range there is only the castering mode.
_REAL = (-8.5, 8.5)
_SHADE = "#e4efe7"
_NOTE: dict[str, Any] = {"fontsize": 7.5, "linespacing": 1.25}


_LOOKS: dict[str, Any] = {
    "weave": {"color": BLUE, "linestyle": "-", "linewidth": 1.8},
    "capsize": {"color": VERMILLION, "linestyle": (0, (5, 1.5))},
    "castering": {"color": GREEN, "linestyle": (0, (7, 1.5, 1.2, 1.5))},
    "complex": {"color": BLUE, "linestyle": "-", "linewidth": 1.8},
    "real": {"color": VERMILLION, "linestyle": (0, (5, 1.5))},
}
_WITHOUT_PAIR = ("castering", "capsize", "weave", "weave")
_WITH_PAIR = ("castering", "capsize", "weave")
# Names of the modes. Eigenvalues meet at certain speeds, which divide the speeds into ranges. The
# outer key lists the number of complex pairs in each range, the inner key is the number of pairs in
# one range. The value lists the names of the real eigenvalues in ascending order, then those of the
# pairs.
_MODES: dict[tuple[int, ...], dict[int, tuple[str, ...]]] = {
    (0, 1): {0: _WITHOUT_PAIR, 1: _WITH_PAIR},
    (1,): {1: _WITH_PAIR},
}


def stability(reference: Reference, numbers: Sequence[int] = ()) -> Figure:
    """Draw the real and imaginary parts of the eigenvalues of a dataset's bicycle against speed.

    Units are 1/s and rad/s.

    Speeds of the maneuvers are marked, and the stable range is shaded between the exact speeds of
    weave and capsize.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    linear = linearise(Bicycle.parse(reference.bicycle, reference.parameters), _DIGITS_OF_SPEEDS)
    with drawing(_HEIGHT_OF_FIGURE) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1))
        for low, high in linear.stable_ranges:
            _shade((upper, lower), float(low), FASTEST if high is None else float(high))
        for mode, speed, values in _branches(linear):
            upper.plot(speed, values.real, label=mode, **_LOOKS[mode])
            if values.imag.any():
                lower.plot(speed, values.imag, **_LOOKS[mode])
        for weave, _ in linear.weave_speeds:
            _mark_critical_speed(upper, "weave speed", float(weave), -1)
        for capsize in linear.capsize_speeds:
            _mark_critical_speed(upper, "capsize speed", float(capsize), 1)
        _mark_maneuvers((upper, lower), reference)
        upper.axhline(0.0, color=BLACK, linewidth=0.6)
        upper.set(xlim=(0.0, FASTEST), ylim=_REAL, ylabel="real part [1/s]")
        lower.set(ylabel="imaginary part [rad/s]", xlabel="forward speed [m/s]")
        lower.set_ylim(bottom=0.0)
        figure.align_ylabels([upper, lower])
        named = {line.get_label(): line for line in upper.lines if line.get_label() in _LOOKS}
        upper.legend(
            named.values(), named, loc="lower right", handlelength=3.2, framealpha=1.0,
            edgecolor="none",
        )  # fmt: skip
    return figure


def _shade(axes: Sequence[Axes], low: float, high: float) -> None:
    """Shade a range of speeds in which the bicycle is stable."""
    end = min(high, FASTEST)
    if low >= end:
        return
    for ax in axes:
        ax.axvspan(low, end, color=_SHADE, linewidth=0, zorder=0)
    axes[0].text(
        (low + end) / 2, 0.03, "stable", ha="center", transform=axes[0].get_xaxis_transform(),
        **_NOTE,
    )  # fmt: skip


def _mark_critical_speed(ax: Axes, what: str, speed: float, side: int) -> None:
    """Mark a critical speed on the zero line; its name is to the left (-1) or right (1) of it."""
    if speed > FASTEST:
        return
    ax.plot(speed, 0.0, "o", markersize=5, color=BLACK, markerfacecolor="white", zorder=3)
    # Truncate the speed instead of rounding it, because dots after its digits indicate that more
    # digits follow.
    digits = floor(speed * 10**_DECIMALS) / 10**_DECIMALS
    ax.annotate(
        f"{what}\n{digits:.{_DECIMALS}f}\N{HORIZONTAL ELLIPSIS} m/s", (speed, 0.0),
        xytext=(26 * side, 50), textcoords="offset points", va="center",
        ha="right" if side < 0 else "left",
        arrowprops={"arrowstyle": "-", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 3.5}, **_NOTE,
    )  # fmt: skip


def _mark_maneuvers(axes: Sequence[Axes], reference: Reference) -> None:
    for maneuver in reference.maneuvers:
        speed = float(Exact.parse(maneuver.inputs["speed"]))
        if not 0.0 <= speed <= FASTEST:
            continue
        for ax in axes:
            ax.axvline(speed, color=BLACK, linewidth=0.8, linestyle=(0, (1, 2)))
        axes[0].annotate(
            maneuver.name, (speed, 1.0), xycoords=("data", "axes fraction"), xytext=(2, -2),
            textcoords="offset points", rotation=90, va="top", parse_math=False, **_NOTE,
        )  # fmt: skip


def _branches(linear: Linearisation) -> Iterator[tuple[str, Array, Any]]:
    """Yield mode, speeds [m/s] and values [1/s] of each eigenvalue, cut where two meet.

    Between two cuts the number of real eigenvalues is the same at every speed. A pair is
    represented by the eigenvalue with positive imaginary part. Modes are named weave, capsize and
    castering, or real and complex if the eigenvalues of a bicycle meet in another way than the
    benchmark's.
    """
    meet = [float(v) for v, _ in linear.double_roots]
    edges = [0.0, *(v for v in meet if v < FASTEST), FASTEST]
    ranges = [_eigenvalues(linear, a, b) for a, b in pairwise(edges)]
    names = _MODES.get(tuple(pairs.shape[1] for _, _, pairs in ranges), {})
    for speed, singles, pairs in ranges:
        count = pairs.shape[1]
        modes = names.get(count, ("real",) * singles.shape[1] + ("complex",) * count)
        for mode, values in zip(modes, [*singles.T, *pairs.T], strict=True):
            yield mode, speed, values


def _eigenvalues(linear: Linearisation, a: float, b: float) -> tuple[Array, Array, Any]:
    """Return speeds, and the real eigenvalues and complex pairs at each speed, ascending."""
    # Points are closer together near both ends, where a branch may be steep.
    inside = (1 - np.cos(np.linspace(0.0, np.pi, _POINTS_OF_BRANCH))) / 2
    speed = a + (b - a) * np.clip(inside, _SPEEDS_APART, 1 - _SPEEDS_APART)
    found = [linear.eigenvalues(linear.g.context.mpf(float(v))) for v in speed]
    singles = np.array([[z.real for z in values if z.imag == 0] for values in found], float)
    pairs = np.array([[z for z in values if z.imag > 0] for values in found], complex)
    return speed, singles, pairs
