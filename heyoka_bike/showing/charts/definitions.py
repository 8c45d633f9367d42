"""The error of a column against each of its definitions, as a table with a dot for each."""

import math
from html import escape

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.errors import printable
from heyoka_bike.scoring.report import ColumnScore, ManeuverScore, odds_words
from heyoka_bike.showing.charts.chart import wide
from heyoka_bike.showing.wording import label, number, unit_text


def definitions(m: ManeuverScore) -> str:
    """Errors of a maneuver's columns against each of their definitions; empty without a choice."""
    tables = [_table(c, m.maneuver) for c in m.columns if c.alternatives and c.values]
    return wide(
        "".join(tables),
        "Honest programs mean different things by the same name: the full dot is the definition "
        "that the file follows, as far as its errors tell, and the open ones show how far it is "
        "from the others, on a logarithmic scale.",
    )


def _table(c: ColumnScore, maneuver: int) -> str:
    r = c.as_understood
    found: list[tuple[str, float | None, float | None]]
    found = [(r.definition, r.measures.max_abs_error, None)]
    found += [(a.definition, a.max_abs_error, a.log10_odds) for a in c.alternatives]
    found.sort(key=lambda x: math.inf if x[1] is None else x[1])
    errors = [e for _, e, _ in found if e]
    low = math.floor(math.log10(min(errors))) if errors else 0
    high = max(math.ceil(math.log10(max(errors))), low + 1) if errors else 1
    unit = escape(unit_text(c.unit))
    rows = "".join(_row(c, name, error, odds, low, high) for name, error, odds in found)
    return (
        f'<div class="scroll" tabindex="0" role="group" aria-label="Definitions of the '
        f'{escape(label(c.key))}, maneuver {maneuver}"><table class="dots">'
        f"<caption>{escape(label(c.key))}</caption>"
        f'<thead><tr><th scope="col">definition</th><th scope="col">max error [{unit}]</th>'
        f'<th scope="col" class="ends"><span>1e{low}</span><span>1e{high}</span></th>'
        '<th scope="col">odds against</th><th scope="col">meaning</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _row(
    c: ColumnScore, name: str, error: float | None, odds: float | None, low: int, high: int
) -> str:
    is_it = name == c.as_understood.definition
    dot = ""
    if error is not None:
        at = (math.log10(error) - low) / (high - low) if error > 0 else 0.0
        style = "full" if is_it else "open"
        dot = f'<circle class="{style}" cx="{100 * at:.4g}%" cy="9" r="4.5"/>'
    count = high - low
    places = (f"{100 * n / count:.4g}%" for n in range(0, count + 1, 1 if count <= 20 else 5))
    ticks = "".join(f'<line x1="{at}" x2="{at}" y1="0" y2="18"/>' for at in places)
    said = escape(printable(name.replace("_", " ")))
    if name == c.as_written.definition:
        said += " <i>(default)</i>"
    if name in c.indistinguishable and not is_it:
        said += " <i>(fits as well)</i>"
    meaning = next((d.meaning for d in DEFINITIONS.get(c.key, ()) if d.definition == name), "")
    return (
        f'<tr{" class=chosen" if is_it else ""}><th scope="row">{said}</th>'
        f'<td class="n">{number(error, 3)}</td><td class="dot"><svg width="100%" height="18" '
        f'aria-hidden="true"><g class="grid">{ticks}</g>{dot}</svg></td>'
        f'<td class="n">{"" if odds is None else odds_words(odds)}</td>'
        f'<td class="prose">{escape(meaning)}</td></tr>'
    )
