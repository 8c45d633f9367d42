"""What a report says of one maneuver."""

from heyoka_bike.scoring.report import ManeuverScore
from heyoka_bike.showing.formats import tables
from heyoka_bike.showing.formats.charts import all_errors
from heyoka_bike.showing.formats.html_parts import capital
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.formats.table import render_maneuver
from heyoka_bike.showing.formats.wording import heading
from heyoka_bike.showing.views.card import card, head


def text(m: ManeuverScore) -> str:
    """Its table."""
    return render_maneuver(m, WIDTH).strip("\n")


def html(m: ManeuverScore) -> str:
    """Its table, and its errors over time."""
    return card(head(capital(heading(m))), parts(m))


def parts(m: ManeuverScore) -> str:
    """The same within something else."""
    return tables.scores(m, explained=False) + all_errors(m)
