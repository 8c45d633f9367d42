"""Rows of a simulation, maneuver by maneuver."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.reference.values import Values
from heyoka_bike.showing.document import Block, Chapter
from heyoka_bike.showing.document.notebook import head
from heyoka_bike.showing.views.values import table

if TYPE_CHECKING:
    from heyoka_bike.motion.fast.simulate import Simulation


def blocks(run: Simulation) -> tuple[Block, ...]:
    """The first and last rows of each maneuver; of several they unfold."""
    shown: list[Block] = []
    for i, columns in enumerate(run.values, start=1):
        values = Values(dict(zip(BENCHMARK_COLUMNS, columns, strict=True)), {}, time=run.time)
        rows = table(values, len(BENCHMARK_COLUMNS), "Rows")
        is_one = len(run.values) == 1
        shown.append(rows if is_one else Chapter(f"Maneuver {i}", (rows,), is_folded=True))
    return *head(repr(run).strip("<>")), *shown
