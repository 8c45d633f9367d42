"""The figures of docs/field.md: what digits cost, and what eq. (1) says of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from field_harder import LEAST, largest
from heyoka_bike.workbench.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILLION,
    WIDTH,
    style,
)
from placed_labels import Label, place

_SIZE = (WIDTH, 5.4)  # [inch]
_LONGEST = 24  # of a line of a label
RIGHT, PASSES = 3, 1e-3
"""Digits of a motion that is right to a thousandth, and the benchmark's limit of eq. (1) [%]."""


def is_blind(run):
    """Whether a run passes eq. (1) in every maneuver and is not right to a thousandth."""
    return largest(run) < PASSES and run["digits"] < RIGHT


LOWEST = -1.0
"""Digits below which nothing is to be told apart: errors of ten times the largest value."""


@dataclass(frozen=True)
class Kind:
    """What a program is, in words, and how it is drawn."""

    words: str
    colour: str
    marker: str


KINDS: Mapping[str, Kind] = {
    "multibody": Kind("multibody, rolling as a constraint", BLUE, "o"),
    "algorithms": Kind("rigid-body algorithms, rolling by hand", GREEN, "s"),
    "symbolic": Kind("symbolic equations", PURPLE, "D"),
    "solver": Kind("solver of ODEs or DAEs", ORANGE, "^"),
    "engine": Kind("engine, contact and friction", VERMILLION, "v"),
    "linear": Kind("linearised equations", GREY, "X"),
    "own": Kind("of this project", BLACK, "h"),
}
OTHER = Kind("other", BLACK, "P")


def costs(programs):
    """Correct digits against processor time: a line for each program, to its best run.

    Parameters
    ----------
    programs : sequence of Shown
        Of field_page.
    """
    with style():
        figure = Figure(figsize=_SIZE, layout="constrained")
        ax = figure.subplots()
        labels, lines = [], []
        for p in programs:
            look = {"color": p.kind.colour, "marker": p.kind.marker}
            line = [(r["cpu"], _clipped(r)) for r in p.family]
            if line:
                ax.plot(*zip(*line, strict=True), markersize=3.5, linewidth=1.1, **look)
            if p.default and p.default not in p.family:
                first = p.default["cpu"], _clipped(p.default)
                way = [first, *line[:1]]
                ax.plot(
                    *zip(*way, strict=True), linewidth=0.7, linestyle=(0, (1, 2)),
                    color=p.kind.colour,
                )  # fmt: skip
                lines.append(way)
            if p.default:
                ax.plot(
                    p.default["cpu"], _clipped(p.default), markersize=4.5,
                    markerfacecolor="white", linestyle="", **look,
                )  # fmt: skip
            lines.append(line)
            if p.top:
                name = fill(p.name, _LONGEST)
                labels.append(Label(p.top["cpu"], _clipped(p.top), name, p.kind.colour))
        ax.set_xscale("log")
        ax.set_xlabel("processor time of the three maneuvers [s], beside other work")
        ax.margins(x=0.1, y=0.06)
        _finish(figure, ax, programs)
        place(figure, ax, labels, lines)
    return figure


def drifts(programs):
    """Correct digits against the largest eq. (1) of the maneuvers: a dot for each run."""
    with style():
        figure = Figure(figsize=_SIZE, layout="constrained")
        ax = figure.subplots()
        labels, dots = [], []
        for p in programs:
            for r in p.runs:
                x, y = max(largest(r), LEAST), _clipped(r)
                dots.append([(x, y)])
                ax.plot(
                    x, y, color=p.kind.colour, marker=p.kind.marker, linestyle="",
                    markerfacecolor="white" if r is p.default else p.kind.colour,
                    markersize=5 if r in (p.best, p.default) else 3,
                )  # fmt: skip
                if r in (p.best, p.default) and is_blind(r):
                    how = "default settings" if r is p.default else "best run"
                    labels.append(Label(x, y, f"{p.name}, {how}", p.kind.colour))
        ax.set_xscale("log")
        ax.margins(x=0.06, y=0.06)
        ends, top = np.array(ax.get_xlim()), ax.get_ylim()[1]
        as_energy = 2 - np.log10(ends)
        ax.plot(ends, as_energy, color=BLACK, linewidth=0.8, linestyle=(0, (4, 2)))
        ax.axvline(PASSES, color=BLACK, linewidth=0.7)
        ax.fill_between([ends[0], PASSES], LOWEST - 1, RIGHT, color=VERMILLION, alpha=0.09, lw=0)
        ax.set_xlim(ends)
        ax.set_ylim(None, top)
        ax.set_xlabel("eq. (1), largest of the maneuvers [%]")
        _finish(figure, ax, programs, [("small: other settings", {"markersize": 3})])
        ax.text(
            ends[0] * 2, LOWEST - 0.2, "passes eq. (1), and is not right to a thousandth",
            fontsize=7.5, va="bottom",
        )  # fmt: skip
        notes = {"fontsize": 7.5, "va": "top"}
        ax.text(PASSES * 1.4, top - 0.2, "the benchmark asks\nfor less than 1e-3 %", **notes)
        # Beside the dashed line, where it leaves the frame.
        ax.text(10 ** (3.3 - top), top - 0.2, "as right as the\nenergy is constant", **notes)
        place(figure, ax, labels, [*dots, list(zip(ends, as_energy, strict=True))])
    return figure


def _clipped(run):
    return max(run["digits"], LOWEST)


def _finish(figure, ax, programs, more=()):
    """Axis of the digits, and what the looks mean."""
    ax.set_ylim(LOWEST - 0.4, None)
    ticks = range(int(LOWEST), int(ax.get_ylim()[1]) + 1)
    ax.set_yticks(ticks, [f"−{-LOWEST:g} or\nless", *map(str, ticks[1:])])
    ax.set_ylabel("correct digits of the worst value")
    kinds = [k for k in (*KINDS.values(), OTHER) if any(p.kind is k for p in programs)]
    handles = [
        Line2D([], [], color=k.colour, marker=k.marker, markersize=4, linewidth=1.1, label=k.words)
        for k in kinds
    ]
    hollow = ("hollow: default settings", {"markersize": 4.5, "markerfacecolor": "white"})
    handles += [
        Line2D([], [], color=BLACK, marker="o", linestyle="", label=words, **look)
        for words, look in (hollow, *more)
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3, frameon=False)
