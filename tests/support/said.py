"""The text about the results of a diagnosis."""

from heyoka_bike.scoring.diagnosis import visible_faults
from heyoka_bike.scoring.diagnosis.answers import answers
from heyoka_bike.showing.wording import finding_text


def said_of(found, report):
    """Return the findings about the causes in a report."""
    return finding_text.findings(answers(found, report, visible_faults.shown(report)))
