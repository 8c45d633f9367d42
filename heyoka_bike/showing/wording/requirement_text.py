"""Sentences about the requirements: whether each is met, and why not."""

from math import inf

from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.findings import named
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
            return f"{value} ({where}{', at the digits written' if found.is_by_digits else ''})"
        case NoSuchManeuver():
            return f"maneuver {found.maneuver} is not in the file"
        case NoSuchColumn():
            where = "file" if found.has_reference else "reference"
            return f"{found.key or 'no column'} is not in the {where}"
        case LeftOut():
            return f"{named([x.name for x in found.columns])}: in the file, and not compared"
        case NeverFilledIn():
            numbers = dict.fromkeys(str(x.maneuver) for x in found.columns)
            keys = dict.fromkeys(str(x.key) for x in found.columns)
            return f"maneuver {', '.join(numbers)}, {', '.join(keys)}: never filled in"
        case ValuesMissing():
            where = f"maneuver {found.maneuver}, {found.key}"
            are = "is" if found.missing == 1 else "are"
            return f"{where}: {found.missing} of {counted(found.values, 'value')} {are} not finite"
        case SignContradicted():
            return f"maneuver {found.maneuver}, {found.contradiction.message()}"
        case InPart():
            return in_part(found)
        case NothingCompared():
            where = f"maneuver {found.maneuver}, {found.key}"
            return f"{where}: {found.metric} is not defined, nothing could be compared"
        case EnergyDoesNotCount(reason=DoesNotCount.NO_ENERGY):
            return f"maneuver {found.maneuver} has no mechanical energy to judge"
        case EnergyDoesNotCount():
            return f"maneuver {found.maneuver}: {DOES_NOT_COUNT[found.reason]}"


def in_part(found: InPart) -> str:
    """Return a sentence: how much was compared, and which requirements would accept this."""
    covered = None if found.coverage is None else f"{100 * found.coverage:g} % of the run"
    columns = None if found.columns is None else f"{found.columns} of {ALL_COLUMNS} columns"
    what = " and ".join(filter(None, (columns, covered)))
    where = f"maneuver {', '.join(map(str, found.maneuvers))}"
    options = " ".join(f"--require '{text}'" for text in found.enough)
    return f"only {what} compared ({where}); if that is intended, add {options}"
