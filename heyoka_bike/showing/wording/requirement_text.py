"""Sentences about the requirements: whether each is met, and why not."""

from math import inf

from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.findings import maneuvers, named
from heyoka_bike.scoring.outcomes import (
    EnergyDoesNotCount,
    InPart,
    LeftOut,
    NeverFilledIn,
    NoSuchColumn,
    NoSuchManeuver,
    NothingCompared,
    Outcome,
    SignContradicted,
    ValuesMissing,
    WorstValue,
)
from heyoka_bike.scoring.verdict import ALL_COLUMNS, DoesNotCount
from heyoka_bike.showing.wording.verdict_text import DOES_NOT_COUNT


def outcome(found: Outcome) -> str:
    """Return the outcome of a requirement: the worst value and its place, or why it is not met."""
    match found:
        case WorstValue():
            value = "never" if found.value == inf else f"{found.value:.3g}"
            where = f"maneuver {found.maneuver}"
            where += f", {found.key}" if found.key else ""
            where += ", limited by the rounding of the values" if found.is_by_digits else ""
            return f"{value} ({where})"
        case NoSuchManeuver():
            return f"no maneuver {found.maneuver} in the file"
        case NoSuchColumn():
            where = "file" if found.has_reference else "reference"
            return f"no {found.key or 'column'} in the {where}"
        case LeftOut():
            return f"columns that were not compared: {named([x.name for x in found.columns])}"
        case NeverFilledIn():
            numbers = dict.fromkeys(x.maneuver for x in found.columns if x.maneuver is not None)
            keys = dict.fromkeys(str(x.key) for x in found.columns)
            where = f" in {maneuvers(list(numbers))}" if numbers else ""
            return f"columns that were never filled in: {', '.join(keys)}{where}"
        case ValuesMissing():
            where = f"maneuver {found.maneuver}, {found.key}"
            return f"{found.missing} of {counted(found.values, 'value')} not finite ({where})"
        case SignContradicted():
            return f"a contradiction in maneuver {found.maneuver}: {found.contradiction.message()}"
        case InPart():
            return in_part(found)
        case NothingCompared():
            where = f"maneuver {found.maneuver}, {found.key}"
            return f"no {found.metric}, because nothing could be compared ({where})"
        case EnergyDoesNotCount(reason=DoesNotCount.NO_ENERGY):
            return f"no mechanical energy in maneuver {found.maneuver}"
        case EnergyDoesNotCount():
            return f"no valid eq. (1) in maneuver {found.maneuver}: {DOES_NOT_COUNT[found.reason]}"


def in_part(found: InPart) -> str:
    """Return a sentence: how much was compared, and which requirements would accept this."""
    covered = None if found.coverage is None else f"{100 * found.coverage:g} % of the run"
    columns = None if found.columns is None else f"{found.columns} of {ALL_COLUMNS} columns"
    what = " and ".join(filter(None, (columns, covered)))
    where = maneuvers(found.maneuvers)
    options = " ".join(f"--require '{text}'" for text in found.enough)
    return f"only {what} compared ({where}); if that is intended, add {options}"
