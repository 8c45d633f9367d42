"""Rows of a simulation, maneuver by maneuver."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.reference.values import Values
from heyoka_bike.showing.views.card import card, folded, head, plain_table, remark
from heyoka_bike.showing.views.values import table

if TYPE_CHECKING:
    from heyoka_bike.motion.fast.simulate import Simulation


def html(run: Simulation) -> str:
    """The first and last rows of each maneuver; of several they unfold."""
    shown = []
    for columns in run.values:
        values = Values(dict(zip(BENCHMARK_COLUMNS, columns, strict=True)), {}, time=run.time)
        names, rows, said = table(values, len(BENCHMARK_COLUMNS))
        shown.append(plain_table(names, rows, "Rows", "numbers") + remark(said))
    if len(shown) > 1:
        shown = [folded(f"Maneuver {i}", part) for i, part in enumerate(shown, start=1)]
    return card(head(repr(run).strip("<>")), *shown)
