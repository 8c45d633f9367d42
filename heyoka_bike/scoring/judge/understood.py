"""How each column was understood, where that is not as by default: definition, sign, unit, zero."""

from collections.abc import Iterator, Sequence

from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, info, warning
from heyoka_bike.scoring.judge.conventions import errors_words, odds
from heyoka_bike.scoring.report import Place, Report

# Units differ by more than that, so that a column nearer than this tells its own.
_UNIT_TOLD = 0.05


def understood(report: Report) -> Iterator[Finding]:
    """Column by column, with the errors that each choice leaves."""
    for key, places in report.by_column().items():
        columns = [c for _, c in places]
        taken, written = columns[0].as_understood, columns[0].as_written
        evidence = {
            "column": key,
            "max_abs_error": [c.max_abs_error for c in columns],
            "max_abs_error_as_written": [c.as_written.measures.max_abs_error for c in columns],
        }
        errors = errors_words(columns)
        if taken.definition != written.definition and columns[0].is_known:
            said = _definition(key, columns, errors)
            yield info("definition", said, **evidence, definition=taken.definition)
        if taken.sign < 0:
            said = f"{key} has the other sign: errors {errors} with it turned round"
            yield info("sign", said, **evidence)
        if taken.unit != written.unit:
            said = f"{key} is in {taken.unit}, not {written.unit}: errors {errors} in the latter"
            yield info("unit", said, **evidence, unit=taken.unit)
        yield from _unit_contradicted(key, places)
        if taken.offset:
            said = f"{key} has another zero, {taken.offset:+.9g} J: errors {errors} without that "
            yield info("offset", said + "constant", **evidence, offset=taken.offset)


def _definition(key: str, columns: Sequence[ColumnScore], errors: str) -> str:
    first = columns[0]
    default = first.as_written.definition
    far = [a for c in columns for a in c.alternatives if a.definition == default]
    sure = f", {said}" if (said := odds(first)) else ""
    also = ", ".join(first.indistinguishable)
    open_ones = f" (cannot be told apart from {also})" if also else ""
    return (
        f"{key} is {first.definition}{sure}: errors {errors}, against {errors_words(far)} for the "
        f"default {default}{open_ones}"
    )


def _unit_contradicted(key: str, places: Sequence[Place]) -> Iterator[Finding]:
    (m, first), *_ = places
    unit = first.as_understood.unit
    heading = m.part.units.get(key, unit)
    far = [c.max_rel_error for _, c in places]
    if heading != unit and all(x is not None and x < _UNIT_TOLD for x in far):
        said = (
            f"{key}: its heading says {heading}, but its values are in {unit}. One of them is "
            "wrong; here they are taken as what they fit"
        )
        yield warning("unit_contradicted", said, column=key, named=heading, unit=unit)
