"""A computed motion: what was integrated, how, and its state at a few times."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from heyoka_bike.showing.document import Block, TableBlock
from heyoka_bike.showing.document.notebook import head
from heyoka_bike.showing.wording import plain

if TYPE_CHECKING:
    from heyoka_bike.motion.trajectory import Trajectory

_TIMES = 6


def blocks(run: Trajectory) -> tuple[Block, ...]:
    """States at even times, the last the end of the run."""
    end = run.breaks[-1] if run.maneuver.duration > run.breaks[-1] else run.maneuver.duration
    times = [end * Fraction(i, _TIMES - 1) for i in range(_TIMES)]
    rows = [(plain(float(t)), *(f"{float(x.mid()):.10g}" for x in run.state(t))) for t in times]
    title, facts = run.words
    return *head(title, facts), TableBlock(("time [s]", *run.states), rows, "States", "numbers")
