"""How far apart the definitions of a column are: alternates minus the default, over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.scoring.evidence.words import unit_text
from heyoka_bike.workbench.style import LINES, WIDTH, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = tuple(key for key, definitions in DEFINITIONS.items() if len(definitions) > 1)
"""Columns with more than one definition."""

_HEIGHT = 2.1  # [inch] of a panel
# A panel begins at so much of the smallest of its differences at the end, all of which it shows.
_BELOW = 1e-2


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """Panels for each column with several definitions, named as in the scorer's report.

    At each row the largest absolute difference from the default up to there, in rad, rad/s and m/s;
    the differences themselves go through zero again and again.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    (number,) = numbers
    maneuver = reference[number]
    with style():
        from matplotlib.figure import Figure

        definitions = maneuver.definitions
        panels = [(key, others) for key in COLUMNS for others in _batched(definitions[key][1:])]
        figure = Figure(figsize=(WIDTH, _HEIGHT * len(panels)), layout="constrained")
        figure.suptitle(
            f"{maneuver.name}: how far apart definitions are, the largest difference so far",
            parse_math=False,
        )
        axes = figure.subplots(len(panels), 1, sharex=True)
        for ax, (key, others) in zip(axes, panels, strict=True):
            default, last = definitions[key][0], []
            for other, look in zip(others, LINES, strict=False):
                apart = largest_so_far(maneuver, other.name, default.name)
                last.append(float(apart[-1]))
                ax.plot(maneuver.time, apart, label=other.definition, **look)
            if any(last):
                ax.set_yscale("log", nonpositive="mask")
                ax.set_ylim(_BELOW * min(x for x in last if x), 3 * max(last))
            said = key.replace("_", " ")
            ax.set_ylabel(f"{said}\nminus {default.definition} [{unit_text(maneuver.units[key])}]")
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=3)
        axes[-1].set_xlim(float(maneuver.time[0]), float(maneuver.time[-1]))
        axes[-1].set_xlabel("time [s]")
        figure.align_ylabels(axes)
    return figure


def _batched(columns: Sequence[Column]) -> Iterator[Sequence[Column]]:
    """As many at a time as there are looks to tell them apart."""
    for start in range(0, len(columns), len(LINES)):
        yield columns[start : start + len(LINES)]


def largest_so_far(maneuver: ReferenceManeuver, name: str, other: str) -> Array:
    """Largest absolute difference of two columns up to each row, from hi + lo."""
    # Some definitions are in no dataset: they follow from others.
    rows = maneuver.continued((maneuver.time, maneuver.time_lo), (name, other))
    apart = np.abs((rows[name] - rows[other]) + (rows.lo[name] - rows.lo[other]))
    found: Array = np.maximum.accumulate(apart)
    return found
