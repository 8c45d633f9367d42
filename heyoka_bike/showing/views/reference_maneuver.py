"""One maneuver of a reference: its start, its first and last rows, its columns."""

from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.values import Values
from heyoka_bike.showing.formats.wording import number, unit_text
from heyoka_bike.showing.views.card import card, folded, head, plain_table, remark
from heyoka_bike.showing.views.values import table

_SHOWN = 8


def html(m: ReferenceManeuver) -> str:
    """Its rows; the columns unfold."""
    facts = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in m.inputs.items())
    rows = Values({name: m.rows[name] for name in m.columns[:_SHOWN]}, {}, time=m.time)
    names, lines, said = table(rows, _SHOWN)
    columns = [(c, unit_text(m.units.get(c, "")), number(m.scale(c), 4)) for c in m.columns]
    return card(
        head(m.name, facts),
        plain_table(names, lines, "Rows", "numbers"),
        remark(said),
        folded(
            f"Columns ({len(columns)})",
            plain_table(("column", "unit", "largest value"), columns, "Columns"),
        ),
    )
