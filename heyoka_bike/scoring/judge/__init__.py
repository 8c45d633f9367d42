"""Rules that derive evidence from the numbers of a report: each rule is a function of the report.

Each module answers one question, which its docstring states.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace

from heyoka_bike.scoring.evidence.as_compared import OtherOrder
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import SignContradiction
from heyoka_bike.scoring.judge.contradicted_units import headings_contradicted
from heyoka_bike.scoring.judge.conventions import conventions, each_convention
from heyoka_bike.scoring.judge.coverage import covered_in_part
from heyoka_bike.scoring.judge.energy_alone import errors_hidden
from heyoka_bike.scoring.judge.energy_sum import energies_apart
from heyoka_bike.scoring.judge.own_definitions import unknown_definitions
from heyoka_bike.scoring.judge.precision import digits_written, single_precision
from heyoka_bike.scoring.judge.rates import rates_contradicted
from heyoka_bike.scoring.judge.signs import odd_signs
from heyoka_bike.scoring.judge.time_shift import time_shifted
from heyoka_bike.scoring.judge.unread import names_not_understood
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ManeuverScore

RULES: tuple[Callable[[Report], Iterable[Evidence]], ...] = (
    names_not_understood,
    conventions,
    each_convention,
    headings_contradicted,
    odd_signs,
    unknown_definitions,
    time_shifted,
    covered_in_part,
    errors_hidden,
    energies_apart,
    rates_contradicted,
    digits_written,
    single_precision,
)
"""The rules, in the order in which their evidence is reported."""


def judged(report: Report) -> Report:
    """Add the evidence of every rule to a report."""
    # If columns are exchanged, all rules but one would judge the wrong quantities.
    is_moved = any(isinstance(x, OtherOrder) for x in report.seen)
    rules = (names_not_understood,) if is_moved else RULES
    found = tuple(evidence for rule in rules for evidence in rule(report))
    contradicted = {key for x in found if isinstance(x, SignContradiction) for key in x.keys}

    def marked(m: ManeuverScore) -> ManeuverScore:
        columns = (replace(c, is_contradicted=c.key in contradicted) for c in m.columns)
        return replace(m, columns=tuple(columns))

    maneuvers = tuple(map(marked, report.maneuvers)) if contradicted else report.maneuvers
    return replace(report, seen=report.seen + found, maneuvers=maneuvers)
