"""Conventions of the columns: axes, units, the zero of the energy, definitions.

Conventions are no errors: they are said in one sentence, and column by column with the errors that
each choice leaves.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from heyoka_bike.scoring.column_score import Alternative, ColumnScore, odds, open_words
from heyoka_bike.scoring.findings import Finding, info, named, warning
from heyoka_bike.scoring.judge.signs import odd_signs
from heyoka_bike.scoring.report import Place, Report

DEFAULT = (
    "The file follows the conventions that are taken by default: SI units, roll and steer positive "
    "to the right, potential energy from the floor, and the first definition of each column"
)

UNITS_BESIDE = "units_beside"
"""Finding of a diagnosis that the file has other units than those that were scored."""

_SIDES: Mapping[str, tuple[str, ...]] = {
    "roll": ("roll_angle", "roll_rate"),
    "steer": ("steer_angle", "steer_rate"),
    "yaw": ("yaw", "yaw_rate"),
}
_TURNED = {"forward_speed": "the speed counts backward", "pitch": "nose down is positive"}
# Named in one sentence.
_MOST = 6
# Units differ by more than that, so that a column nearer than this tells its own.
_UNIT_TOLD = 0.05


def conventions(report: Report) -> Iterator[Finding]:
    """Say the conventions of a file in one sentence; nothing if they are those by default."""
    columns = {key: places[0][1] for key, places in report.by_column().items()}
    # Signs that may be errors are no convention.
    contradicted = {key for f in odd_signs(report) for key in f.evidence["columns"]}
    turned = [k for k, c in columns.items() if c.as_understood.sign < 0 and k not in contradicted]
    taken = {key: c.as_understood for key, c in columns.items()}
    units = {k: x.unit for k, x in taken.items() if x.unit != columns[k].as_written.unit}
    zeros = {k: x.offset for k, x in taken.items() if x.offset}
    meant = {k: c for k, c in columns.items() if _is_another(c)}
    said = [*_senses(turned), *in_units(units), *_zeros(zeros), *_definitions(meant)]
    if not said:
        return
    others = "else but the signs that are warned of" if contradicted else "else"
    yield info(
        "conventions",
        f"The file follows conventions of its own, which are no errors: {'; '.join(said)}. All "
        f"{others} is as by default. Errors are stated with these conventions applied",
        signs=turned,
        units=units,
        offsets=zeros,
        definitions={key: c.definition for key, c in meant.items()},
    )


def errors_words(found: Iterable[ColumnScore | Alternative]) -> str:
    """Largest errors, one for each maneuver."""
    errors = (x.max_abs_error for x in found)
    return " / ".join("-" if x is None else f"{x:.2g}" for x in errors)


def _senses(turned: Sequence[str]) -> Iterator[str]:
    """Say which way is positive, of the columns with the other sign."""
    left = [name for name, keys in _SIDES.items() if set(keys) & set(turned)]
    if left:
        yield f"{' and '.join(left)} {'is' if len(left) == 1 else 'are'} positive to the left"
    yield from (text for key, text in _TURNED.items() if key in turned)
    known = {*_TURNED, *(key for keys in _SIDES.values() for key in keys)}
    if others := [key for key in turned if key not in known]:
        yield f"{named(others, _MOST)} with the other sign, as in other axes"


def in_units(units: Mapping[str, str]) -> Iterator[str]:
    """Units of columns, as "roll_angle, steer_angle in degree"."""
    for unit in dict.fromkeys(units.values()):
        keys = [key for key, u in units.items() if u == unit]
        yield f"{named(keys, _MOST)} in {unit}"


def _definitions(meant: Mapping[str, ColumnScore]) -> Iterator[str]:
    for key, c in meant.items():
        sure = ", ".join(x for x in (odds(c), open_words([c])) if x)
        yield f"{key} is {c.definition}" + (f" ({sure})" if sure else "")


def _is_another(c: ColumnScore) -> bool:
    """True if a column is known to have another definition than the default."""
    return c.definition != c.as_written.definition and c.is_known


def _zeros(zeros: Mapping[str, float]) -> Iterator[str]:
    for offset in dict.fromkeys(zeros.values()):
        keys = [key for key, x in zeros.items() if x == offset]
        where = "above" if offset < 0 else "below"
        yield f"the zero of {named(keys, _MOST)} is {abs(offset):.9g} J {where} that at the floor"


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
        if _is_another(columns[0]):
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
    open_ones = f" ({also})" if (also := open_words(columns)) else ""
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
