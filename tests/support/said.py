"""What is said of what a diagnosis found."""

from heyoka_bike.scoring.diagnosis import plain
from heyoka_bike.scoring.diagnosis.answers import answers
from heyoka_bike.showing import causes


def said_of(found, report):
    """The findings that are made of the causes of a report."""
    return causes.findings(answers(found, report, plain.shown(report)))
