"""One maneuver of a reference: its start, its first and last rows, its columns."""

from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.values import Values
from heyoka_bike.showing.document import Block, Chapter, TableBlock
from heyoka_bike.showing.document.notebook import head
from heyoka_bike.showing.views.values import table
from heyoka_bike.showing.wording import number, unit_text

_SHOWN = 8


def blocks(m: ReferenceManeuver) -> tuple[Block, ...]:
    """Its rows; the columns unfold."""
    facts = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in m.inputs.items())
    rows = Values({name: m.rows[name] for name in m.columns[:_SHOWN]}, {}, time=m.time)
    columns = [(c, unit_text(m.units.get(c, "")), number(m.scale(c), 4)) for c in m.columns]
    listed = TableBlock(("column", "unit", "largest value"), columns, "Columns")
    return (
        *head(m.name, facts),
        table(rows, _SHOWN, "Rows"),
        Chapter(f"Columns ({len(columns)})", (listed,), is_folded=True),
    )
