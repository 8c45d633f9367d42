"""The sentences of what was seen in a result file: evidence becomes findings here, last.

A finding has a stable code, one or two sentences for people, and the numbers behind it for JSON.
One function makes that of one class of evidence; nothing is decided here, and nothing that decides
reads a finding.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import singledispatch
from math import floor, inf
from typing import Any

from heyoka_bike.bicycle.columns import COMPARED, FREE_ZERO
from heyoka_bike.errors import quoted, shortened
from heyoka_bike.scoring import evidence as seen
from heyoka_bike.scoring.findings import Finding, Severity, info, maneuvers, named, warning
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
from heyoka_bike.scoring.reading.names.columns import TIME
from heyoka_bike.scoring.reading.names.words import ALMOST, listed
from heyoka_bike.scoring.verdict import ALL_COLUMNS, DoesNotCount
from heyoka_bike.showing.wording import (
    DOES_NOT_COUNT,
    counted,
    errors_words,
    odds_words,
    open_words,
    ratio_words,
    taken_words,
    time_beside,
    unit_text,
)

# How to see what falls.
_BOTH_STEPS = "heyoka-bike score A B --step 0.01,0.005"
_BOTH_TOLERANCES = "heyoka-bike score A B --tolerance 1e-8,1e-9"
_KEYS_NAMED = 6
"""Columns that a sentence about conventions names."""
_PART_OF_A_ROW = 0.05
"""A shift by less is not told in rows."""
_NAMES_OF_EVIDENCE = 100
"""Names that the evidence of a finding has, each cut as in a message."""

DEFAULT_CONVENTIONS = (
    "Conventions: as by default (SI units, roll and steer positive to the right, V from the floor)"
)


def findings(evidence: Iterable[seen.Evidence]) -> tuple[Finding, ...]:
    """What is said of each, in the same order."""
    return tuple(map(finding, evidence))


def finding(evidence: seen.Evidence) -> Finding:
    """What is said of one thing that was seen; of a run of several files with the file's name."""
    found = _finding(evidence)
    if not evidence.file:
        return found
    return Finding(found.code, f"{evidence.file}: {found.message}", found.severity, found.evidence)


def sentences(found: Iterable[Finding]) -> list[str]:
    """The sentences of findings."""
    return [f.message for f in found]


def warnings(found: Iterable[Finding]) -> list[str]:
    """The sentences of those findings that are warnings."""
    return sentences(f for f in found if f.severity == Severity.WARNING)


def cause(diagnosis: Sequence[Finding]) -> str:
    """The first sentence of a diagnosis that names a cause, or else the first; empty without."""
    told = [f for f in diagnosis if f.code not in ("no_mistake_found", "stopped_early")]
    return next(iter(sentences(told or diagnosis)), "")


@singledispatch
def _finding(evidence: seen.Evidence) -> Finding:
    raise TypeError(f"found {evidence!r:.60}, expected evidence that has a sentence")


register = _finding.register
"""Makes a function that of a class of evidence, as in `causes`."""


# How a file was read.

_WHY_LEFT_OUT = {
    seen.Reason.BESIDE_A_TABLE: "A table beside them has all columns.",
    seen.Reason.NO_COLUMN: "They have more than one axis: write one value for each time.",
}


@_finding.register
def _(e: seen.NotCompared) -> Finding:
    names = [column.name for column in e.columns]
    evidence: dict[str, Any] = {"names": _names(names), "count": len(names)}
    if e.reason == seen.Reason.SET_ASIDE:
        return warning(
            "known_columns_left_out",
            f"Columns that are known by name are left out: {listed(names)}. A number in a name is "
            "that of a maneuver only if the other names have one, and if the reference has that "
            f"maneuver; {e.how_to_tell}.",
            **evidence,
        )
    if e.reason == seen.Reason.CONTRADICTS:
        return warning(
            "known_columns_left_out",
            f"{listed(names)}: other values than those of the column of the same quantity that is "
            "compared. Write each quantity once, or name the column by what else it is.",
            **evidence,
        )
    if e.reason in _WHY_LEFT_OUT:
        return warning(
            "known_columns_left_out",
            f"Columns that are known by name are left out: {listed(names)}. "
            f"{_WHY_LEFT_OUT[e.reason]}",
            **evidence,
        )
    if e.reason == seen.Reason.NOT_UNDERSTOOD:
        keys = list(dict.fromkeys(column.key for column in e.columns if column.key))
        were = "was" if len(names) == 1 else "were"
        return warning(
            "columns_not_understood",
            f"{listed(names)} {were} not understood; did you mean {named(keys)}? "
            f"{e.how_to_tell[:1].upper()}{e.how_to_tell[1:]}.",
            **evidence,
            columns=keys,
        )
    message = f"Columns of other names are left out: {listed(names, ALMOST)}."
    return info("columns_left_out", message, **evidence)


@_finding.register
def _(e: seen.LastRowIncomplete) -> Finding:
    said = f"The last row (line {e.line}) is not complete and left out."
    return warning("last_row_incomplete", said, line=e.line)


@_finding.register
def _(e: seen.CommonFactor) -> Finding:
    said = (
        f"All numbers were multiplied by 1e{e.power}, the common factor that MATLAB displays above "
        "them; writematrix writes all digits"
    )
    return info("common_factor", said, factor=10.0**e.power)


@_finding.register
def _(e: seen.LinesNotRead) -> Finding:
    lines = ", ".join(f"line {number}: {quoted(text)}" for number, text in e.first)
    more = e.count - len(e.first)
    said = "A line with numbers was" if e.count == 1 else f"{e.count} lines with numbers were"
    return warning(
        "lines_not_read",
        f"{said} not read: {lines}{f', and {more} more' if more else ''}.",
        count=e.count,
        lines=[{"line": number, "text": shortened(text)} for number, text in e.first],
    )


@_finding.register
def _(e: seen.NotFinite) -> Finding:
    where = f"first in {e.counted_by} {e.line}, column {e.column}"
    said = f"{counted(e.count, 'value is', 'values are')} not finite and not used ({where})."
    return warning("not_finite", said, count=e.count, line=e.line, column=e.column)


@_finding.register
def _(e: seen.NamesNotUsed) -> Finding:
    said = (
        f"Not all column names are known ({listed(e.unknown)}), so the columns are taken in the "
        f"benchmark's order, although column {e.columns[0]} is named {quoted(e.name)}."
    )
    unknown = _names(e.unknown)
    return warning("names_not_used", said, columns=list(e.columns), unknown=unknown)


@_finding.register
def _(e: seen.UnknownUnit) -> Finding:
    taken = "it is taken for seconds" if e.key == TIME else "only the usual units are tried"
    said = f"The unit {quoted(e.unit)} of the column {quoted(e.name)} is not known, so {taken}."
    (name,), (unit,) = _names([e.name]), _names([e.unit])
    return warning("unit_unknown", said, name=name, unit=unit, column=e.key)


@_finding.register
def _(e: seen.Transposed) -> Finding:
    said = (
        f"The table has {counted(e.rows, 'row')} and {counted(e.columns, 'column')}; its rows are "
        "taken as columns."
    )
    return info("transposed", said, shape=[e.rows, e.columns])


@_finding.register
def _(e: seen.TimesAsDecimals) -> Finding:
    said = (
        f"the times are binary numbers next to multiples of 1e-{e.places} {e.unit}, and are read "
        f"as these decimals ({e.example:.{e.places}f} {e.unit} is exactly that)"
    )
    return info("times_read_as_multiples", said, places=e.places, changed=e.changed)


@_finding.register
def _(e: seen.TimeUnitContradicted) -> Finding:
    said = (
        f"time: its heading says {e.named}, but the times span {e.span:.6g}, as the run does in "
        "seconds. They are taken as seconds"
    )
    return warning("time_unit_contradicted", said, named=e.named, span=e.span)


@_finding.register
def _(e: seen.TimesFromFirst) -> Finding:
    said = (
        f"the times begin at {e.first:.17g} {e.unit}, as those of a clock do; they are counted "
        "from the first row, which is taken for the start"
    )
    return warning("times_from_first", said, first=e.first, unit=e.unit)


@_finding.register
def _(e: seen.TimesOfDay) -> Finding:
    said = (
        f"The times are those of a day: seconds are counted from the first row, {quoted(e.first)}"
    )
    return warning("times_of_day", said, first=shortened(e.first))


@_finding.register
def _(e: seen.TimesUnsorted) -> Finding:
    where = f"first in {e.counted_by} {e.line}"
    said = f"Times go back ({where}); the rows are sorted by time."
    return warning("times_unsorted", said, line=e.line, count=e.count)


@_finding.register
def _(e: seen.TimesRepeated) -> Finding:
    if e.are_identical:
        repeat = counted(e.count, "row repeats", "rows repeat")
        said = f"{repeat} another row, with the same time and the same values"
        return info("times_repeated", said, count=e.count, identical=True)
    repeat = counted(e.count, "row repeats", "rows repeat")
    said = f"{repeat} the time of another row: the time column has too few digits"
    return warning("times_repeated", said, count=e.count, identical=False)


def _names(names: Sequence[str]) -> list[str]:
    return [shortened(name) for name in names[:_NAMES_OF_EVIDENCE]]


# How it lies beside the reference.


@_finding.register
def _(e: seen.ManeuverRecognised) -> Finding:
    said = f"the columns are those of maneuver {e.maneuver}, recognised by their values"
    return info("maneuver_recognised", said, maneuver=e.maneuver)


@_finding.register
def _(e: seen.ManeuverGuessed) -> Finding:
    others = " or ".join(map(str, e.may_be))
    said = (
        f"the file does not name its maneuver. It is compared with maneuver {e.maneuver}, which is "
        f"a guess: it may also be maneuver {others}. To choose: {e.option}"
    )
    return warning("maneuver_guessed", said, maneuver=e.maneuver, may_be=list(e.may_be))


@_finding.register
def _(e: seen.NoReference) -> Finding:
    lacks = f"no {e.lacks}" if e.lacks else "no such columns"
    said = f"{', '.join(e.keys)}: left out, for the reference in {e.folder} has {lacks}"
    return warning("columns_without_reference", said, columns=list(e.keys))


@_finding.register
def _(e: seen.MeantByValues) -> Finding:
    said = (
        f"the name of a column may mean {' or '.join(e.may_be)}; by its values it is "
        f"{e.key or 'none of them and left out'}"
    )
    return info("meant_by_values", said, column=e.key, may_be=list(e.may_be))


@_finding.register
def _(e: seen.WheelRate) -> Finding:
    said = f"forward_speed is the rate of a wheel [rad/s]; its speed is that times {e.radius}"
    return info("wheel_rate", said, radius=e.radius)


@_finding.register
def _(e: seen.OtherOrder) -> Finding:
    said = f"the columns seem to be in another order: {', '.join(e.keys)}"
    if e.told:
        said += f"; {e.told} tells it"
    return warning("columns_in_another_order", said, columns=list(e.keys))


@_finding.register
def _(e: seen.OtherManeuver) -> Finding:
    said = (
        f"the values in the place of maneuver {e.maneuver} are nearer to maneuver {e.nearest} "
        f"(relative distance {e.distance:.2g}, against {e.own_distance:.2g})"
    )
    return warning("another_maneuver", said, maneuver=e.maneuver, nearest=e.nearest)


@_finding.register
def _(e: seen.TimesInLargerUnit) -> Finding:
    said = (
        f"The times span {e.span:.4g} s, in which the angles change far more than their rates "
        f"allow. Are the times in {e.unit}? Write seconds, or the unit in the heading"
    )
    return warning("time_in_larger_unit", said, unit=e.unit, span=e.span)


@_finding.register
def _(e: seen.RowsOutside) -> Finding:
    first, last = (time_beside(t, e.duration) for t in (e.t_first, e.t_last))
    question = f"; are they in {e.may_be_in}?" if e.may_be_in else ""
    said = (
        f"{counted(e.rows, 'row')} with times from {first} to {last} s left out: the reference "
        f"covers 0 to {e.duration:g} s and nothing is extrapolated{question}"
    )
    return warning("time_outside", said, rows=e.rows, t_first=e.t_first, t_last=e.t_last)


@_finding.register
def _(e: seen.TooLarge) -> Finding:
    are = "is" if e.values == 1 else "are"
    said = (
        f"maneuver {e.maneuver}: {counted(e.values, 'value')} of {e.key} {are} beyond 1e150 and "
        "left out"
    )
    return warning("too_large", said, maneuver=e.maneuver, column=e.key, values=e.values)


@_finding.register
def _(e: seen.NeverFilled) -> Finding:
    held: dict[tuple[str, str], list[int]] = {}
    for x in e.columns:
        held.setdefault((x.key, repr(x.number)), []).append(x.maneuver)
    alike: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for (key, number), where in held.items():
        alike.setdefault((number, tuple(where)), []).append(key)
    said = []
    for (number, numbers), keys in alike.items():
        of = f" of maneuver {', '.join(map(str, numbers))}" if len(numbers) < e.maneuvers else ""
        what = _NO_NUMBERS.get(number, f"{float(number):.9g}")
        said.append(f"{', '.join(keys)}{of} hold{'s' if len(keys) == 1 else ''} {what}")
    return warning(
        "never_filled",
        f"{', '.join(said)}: one number in every row of what varies, so never filled in; left out "
        "of the result",
        columns=[f"{x.maneuver}.{x.key}" for x in e.columns],
    )


_NO_NUMBERS = {"nan": "nothing but NaN", "0.0": "nothing but zeros", "-0.0": "nothing but zeros"}


# What its columns mean.


@_finding.register
def _(e: seen.WholeTurns) -> Finding:
    keys = named(e.keys, _KEYS_NAMED)
    said = (
        f"{keys} {'is' if len(e.keys) == 1 else 'are'} written within one turn, which is no error"
    )
    return info(
        "whole_turns", f"{said}: whole turns were added where the values jump", columns=list(e.keys)
    )


@_finding.register
def _(e: seen.ScalarLast) -> Finding:
    return info(
        "scalar_last",
        f"The quaternion of the {e.end} frame has its scalar last (x, y, z, w), which is no error: "
        "it was read in this order",
        frame=e.end,
    )


@_finding.register
def _(e: seen.PathTurned) -> Finding:
    return info(
        "path_turned",
        f"The path on the floor starts at a heading of {e.heading:.6g} rad, which is no error: the "
        "positions were turned back",
        heading=e.heading,
    )


@_finding.register
def _(e: seen.Conventions) -> Finding:
    said = [
        *_senses(e.turned),
        *in_units(e.units),
        *_zeros(e.offsets),
        *(f"{d.key} is {d.definition}{_in_brackets(taken_words(d))}" for d in e.definitions),
    ]
    others = "else but the signs that are warned of" if e.are_signs_contradicted else "else"
    return info(
        "conventions",
        f"The file follows conventions of its own, which are no errors: {'; '.join(said)}. All "
        f"{others} is as by default. Errors are stated with these conventions applied",
        signs=list(e.turned),
        units=dict(e.units),
        offsets=dict(e.offsets),
        definitions={d.key: d.definition for d in e.definitions},
    )


_COLUMNS_OF_SIDE: Mapping[str, tuple[str, ...]] = {
    "roll": ("roll_angle", "roll_rate"),
    "steer": ("steer_angle", "steer_rate"),
    "yaw": ("yaw", "yaw_rate"),
}
_TURNED = {"forward_speed": "the speed counts backward", "pitch": "nose down is positive"}


def _senses(turned: Sequence[str]) -> Iterable[str]:
    """Say which way is positive, of the columns with the other sign."""
    left = [name for name, keys in _COLUMNS_OF_SIDE.items() if set(keys) & set(turned)]
    if left:
        yield f"{' and '.join(left)} {'is' if len(left) == 1 else 'are'} positive to the left"
    yield from (text for key, text in _TURNED.items() if key in turned)
    known = {*_TURNED, *(key for keys in _COLUMNS_OF_SIDE.values() for key in keys)}
    if others := [key for key in turned if key not in known]:
        yield f"{named(others, _KEYS_NAMED)} with the other sign, as in other axes"


def in_units(units: Mapping[str, str]) -> Iterable[str]:
    """Units of columns, as "roll_angle, steer_angle in degree"."""
    for unit in dict.fromkeys(units.values()):
        keys = [key for key, u in units.items() if u == unit]
        yield f"{named(keys, _KEYS_NAMED)} in {unit}"


def _zeros(zeros: Mapping[str, float]) -> Iterable[str]:
    for offset in dict.fromkeys(zeros.values()):
        keys = [key for key, x in zeros.items() if x == offset]
        which = named(keys, _KEYS_NAMED)
        if keys[0] in FREE_ZERO:
            verb = "starts" if len(keys) == 1 else "start"
            yield f"{which} {verb} elsewhere, {_off(keys[0], offset)}"
        else:
            where = "above" if offset < 0 else "below"
            yield f"the zero of {which} is {abs(offset):.9g} J {where} that at the floor"


def _off(key: str, offset: float) -> str:
    """A constant with its sign and the unit of the column."""
    return f"{offset:+.9g} {unit_text(COMPARED[key][0].unit)}"


def _in_brackets(said: str) -> str:
    return f" ({said})" if said else ""


def _of_convention(e: seen.Convention) -> dict[str, Any]:
    return {
        "column": e.key,
        "max_abs_error": list(e.errors),
        "max_abs_error_as_written": list(e.errors_as_written),
    }


@_finding.register
def _(e: seen.OtherDefinition) -> Finding:
    taken = e.taken
    sure = f", {odds_words(taken.odds)}" if taken.odds else ""
    said = (
        f"{e.key} is {taken.definition}{sure}: errors {errors_words(e.errors)}, against "
        f"{errors_words(e.errors_of_default)} for the default {e.default}"
        f"{_in_brackets(open_words(taken.may_also_be))}"
    )
    return info("definition", said, **_of_convention(e), definition=taken.definition)


@_finding.register
def _(e: seen.OtherSign) -> Finding:
    said = f"{e.key} has the other sign: errors {errors_words(e.errors)} with it turned round"
    return info("sign", said, **_of_convention(e))


@_finding.register
def _(e: seen.OtherUnit) -> Finding:
    errors = errors_words(e.errors)
    said = f"{e.key} is in {e.unit}, not {e.default}: errors {errors} in the latter"
    return info("unit", said, **_of_convention(e), unit=e.unit)


@_finding.register
def _(e: seen.OtherZero) -> Finding:
    errors = errors_words(e.errors)
    said = (
        f"{e.key} has another zero, {_off(e.key, e.offset)}: errors {errors} without that constant"
    )
    return info("offset", said, **_of_convention(e), offset=e.offset)


@_finding.register
def _(e: seen.UnitContradicted) -> Finding:
    said = (
        f"{e.key}: its heading says {e.heading}, but its values are in {e.unit}. One of them is "
        "wrong; here they are taken as what they fit"
    )
    return warning("unit_contradicted", said, column=e.key, named=e.heading, unit=e.unit)


@_finding.register
def _(e: seen.SignContradiction) -> Finding:
    return warning("signs_disagree", contradiction_words(e), columns=list(e.keys))


def contradiction_words(e: seen.SignContradiction) -> str:
    """Return the sentence of signs that contradict each other, without a full stop."""
    if len(e.keys) == 2:
        return f"{e.keys[0]} and {e.keys[1]} have opposite signs: one of them is turned round"
    said = f"{named(e.keys)} have signs that no axes give together: some are turned round"
    return said + (", or they are of an inverse attitude" if "frame_" in e.keys[0] else "")


@_finding.register
def _(e: seen.SensesOpposed) -> Finding:
    return warning(
        "senses_opposed",
        "roll and steer have opposite senses: roll is positive to the left, steer to the right. "
        "Right-handed axes give this only if one points backward and another down (with x forward "
        "and z up it is steer that turns round): if yours are not so, one of the two has a sign "
        "error",
        columns=list(e.keys),
    )


@_finding.register
def _(e: seen.DefinitionUnknown) -> Finding:
    sure = ""
    if e.log10_odds < 0.0:
        sure = f", {ratio_words(-e.log10_odds)}"
    return warning(
        "definition_unknown",
        f"{e.key}: a definition of its own? None that is known here gives this column{sure}; the "
        f"other columns have {floor(e.digits_of_others)} digits or more. The nearest definition is "
        f"{e.nearest}, with errors {errors_words(e.errors)}. This column is of another point or "
        "axis, or written wrongly: say what it is",
        column=e.key,
        nearest=e.nearest,
        max_abs_error=list(e.errors),
        digits_of_others=e.digits_of_others,
    )


# What contradicts the rest of it, or the exact motion.


@_finding.register
def _(e: seen.TimeShift) -> Finding:
    starts = f"; the first row, at {e.shift:.6g} s, holds the initial state"
    return warning(
        "time_shifted",
        f"All times are {abs(e.shift):.9g} s too {'late' if e.shift > 0 else 'early'}: with that "
        f"taken {'off' if e.shift > 0 else 'into account'} the motion fits"
        f"{starts if e.begins_at_start else ''}. The errors here are those at the times as written",
        shift=e.shift,
    )


@_finding.register
def _(e: seen.StoppedEarly) -> Finding:
    return warning(
        "stopped_early",
        f"Stopped early: {e.seconds:g} s of processor time were spent before every cause was "
        "tried. One that was not tried may explain the file as well or better. For more time: "
        "--budget, or budget= in Python",
        seconds=e.seconds,
    )


@_finding.register
def _(e: seen.CoveredInPart) -> Finding:
    rows = f"complete rows of maneuver {', '.join(map(str, e.maneuvers))}"
    said = f"{rows} cover {e.t_start:.6g} to {e.t_end:.6g} s only; the rest of the run is"
    if e.has_holes:
        said = f"{rows} are up to {e.gap:.3g} s apart; what the motion does meanwhile is"
    return warning(
        "coverage",
        f"{said} not judged",
        maneuvers=list(e.maneuvers),
        t_start=e.t_start,
        t_end=e.t_end,
        gap=e.gap,
    )


@_finding.register
def _(e: seen.EnergyHidesError) -> Finding:
    worst = e.max_rel_error
    part = f"{100 * worst:.0f}" if worst >= 0.1 else f"{100 * worst:.2g}"
    return warning(
        "energy_hides_error",
        f"{maneuvers(e.maneuvers)}: the energy is within the limit of eq. (1), and yet {e.key} is "
        f"wrong by up to {part} % of its scale; energy alone does not show this error",
        maneuvers=list(e.maneuvers),
        maneuver=e.maneuver,
        performance=e.performance,
        column=e.key,
        max_rel_error=worst,
    )


@_finding.register
def _(e: seen.EnergySum) -> Finding:
    said = (
        f"{maneuvers(e.maneuvers)}: potential plus kinetic energy differs from the mechanical "
        f"energy by up to {e.energy_sum:.2g} J; rounding explains {e.floor:.2g} J"
    )
    numbers = list(e.maneuvers)
    return warning("energy_sum", said, maneuvers=numbers, energy_sum=e.energy_sum, floor=e.floor)


@_finding.register
def _(e: seen.RateContradiction) -> Finding:
    return warning(
        "rate_is_not_the_derivative",
        f"{maneuvers(e.maneuvers)}: {e.key} is not the derivative of its own angle, which is much "
        f"better than it: up to {e.rms_difference:.2g} rad/s apart (root mean square)",
        maneuvers=list(e.maneuvers),
        column=e.key,
        rms_difference=e.rms_difference,
    )


@_finding.register
def _(e: seen.SinglePrecision) -> Finding:
    said = (
        "The values jump from row to row by some 1e-7 of their size, as numbers of single "
        "precision on the way leave them: this is the arithmetic and not the model; compute in "
        "double precision throughout"
    )
    if e.is_written:
        said = (
            f"{'All' if e.are_all else 'Most'} values are single-precision numbers, good to seven "
            "digits, however many are written: an error of 1e-7 of a value, or one that grows from "
            "that, is the arithmetic and not the model; compute and store in double precision"
        )
    return warning("single_precision", said, columns=list(e.keys))


@_finding.register
def _(e: seen.FewDigits) -> Finding:
    digits = e.significant_digits
    said = (
        f"{named(e.keys)}: the error is that of the digits written ({digits} in the column with "
        "the fewest); write 17 to show what the program can do"
    )
    return info("digits_written", said, columns=list(e.keys), significant_digits=digits)


# What several files tell together.


@_finding.register
def _(e: seen.NoSharedColumns) -> Finding:
    said = "no maneuver has a column that two of the files share; those of one run go in one file"
    if e.of == seen.Grouping.PROGRAMS:
        said = "no maneuver has a column that two of the programs share: nothing is side by side"
    return warning("no_shared_columns", said)


@_finding.register
def _(e: seen.StepsUnknown) -> Finding:
    apart = "the rows of several files are equally far apart"
    said = (
        f"{'several files are given as alike' if e.is_told else apart}, so the step sizes do not "
        "tell the runs apart; give those of the integrator (--step) to see the order of "
        "convergence, or the tolerances of its solver (--tolerance)"
    )
    return warning("steps_unknown", said)


@_finding.register
def _(e: seen.ManeuversDiffer) -> Finding:
    who: dict[str, list[str]] = {}
    for name, numbers in e.maneuvers.items():
        who.setdefault(", ".join(map(str, numbers)) or "none", []).append(name)
    held = "; ".join(f"{', '.join(names)}: {numbers}" for numbers, names in who.items())
    said = (
        f"the programs cover different maneuvers ({held}), so that the digits of their worst "
        "columns do not compare: look at the maneuvers that they share"
    )
    of_each = {name: list(numbers) for name, numbers in e.maneuvers.items()}
    return warning("maneuvers_differ", said, maneuvers=of_each)


@_finding.register
def _(e: seen.DefinitionsOfPrograms) -> Finding:
    each = "; ".join(f"{name} in {', '.join(who)}" for name, who in e.programs.items())
    said = f"{e.key} is {each}: each is compared with its own definition, so this is no error"
    by = {name: list(who) for name, who in e.programs.items()}
    return info("definitions_differ", said, column=e.key, definitions=by)


@_finding.register
def _(e: seen.DefinitionsOfRuns) -> Finding:
    said = (
        f"{', '.join(e.keys)} of these files have different definitions, signs or units; are they "
        "of one program?"
    )
    return warning("definitions_differ", said, columns=list(e.keys))


@_finding.register
def _(e: seen.ErrorFalls) -> Finding:
    columns = f"{e.columns} column{'s' if e.columns > 1 else ''}"
    spread = f"median of {columns}, from {_two_decimals(e.least)} to {_two_decimals(e.most)}"
    if e.by == "step":
        said = f"observed order of convergence {_two_decimals(e.exponent)} ({spread})"
        return info("order", said, order=e.exponent, least=e.least, most=e.most)
    how = "in proportion to the tolerance"
    if abs(e.exponent - 1) > _IN_PROPORTION:
        how = f"like the tolerance to the power {e.exponent:.1f}"
    said = f"the error falls {how}: exponent {e.exponent:.2f} ({spread})"
    return info("tolerance", said, exponent=e.exponent, least=e.least, most=e.most)


_IN_PROPORTION = 0.25
"""Exponents within this of 1 are called "in proportion"."""


def _two_decimals(order: float) -> str:
    return f"{round(order, 2) + 0.0:.2f}"  # no -0


@_finding.register
def _(e: seen.OrderNotSettled) -> Finding:
    said = (
        f"the order of {', '.join(e.places)} still changes from step to step: the steps are too "
        "large, or rounding has been reached, for one power law"
    )
    return info("order_not_settled", said, columns=list(e.places))


@_finding.register
def _(e: seen.ErrorStays) -> Finding:
    places, size = named(e.places, _KEYS_NAMED), f"{e.max_rel_error:.1g}"
    numbers = {"columns": list(e.places), "max_rel_error": e.max_rel_error}
    if e.how == seen.Staying.ROUNDING:
        said = (
            f"{places}: the error, {size} of the scale or less, does not fall with the {e.by}, and "
            "need not: at this size it is rounding of binary64 arithmetic, not the model; only "
            "longer numbers make it smaller"
        )
        return info("limited_by_rounding", said, **numbers)
    if e.how == seen.Staying.NOISE:
        said = (
            f"{places}: the error, up to {size} of the scale, does not fall with the {e.by}, but "
            "is another curve in each run: it is noise, of single-precision numbers (1e-7), of "
            "iterations that stop early, or of rough interpolation, and not the model"
        )
        return warning("noise_does_not_fall", said, **numbers)
    said = (
        f"{places}: the error, up to {size} of the scale, is the same curve in both runs and does "
        f"not fall with the {e.by}: it is not the integrator's, but that of the model, its "
        "parameters, the start or the output; ask heyoka-bike diagnose"
    )
    return warning("error_stays", said, **numbers)


# What was done to what is written.


@_finding.register
def _(e: seen.CoarseGrid) -> Finding:
    said = (
        f"{e.key} of {maneuvers(e.maneuvers)}: every value is a multiple of {e.step:.6g} (SI), far "
        "coarser than the digits written, as of an encoder, a table or a rounded number. Smaller "
        "errors are not judged"
    )
    return warning("coarse_grid", said, column=e.key, maneuvers=list(e.maneuvers), step=e.step)


@_finding.register
def _(e: seen.HalfPrecision) -> Finding:
    which = "All values" if e.are_all else f"The values of {named(e.keys)}"
    said = (
        f"{which} are half-precision numbers (11 bits), good to three digits, however many are "
        "written. Store them in double precision"
    )
    return warning("half_precision", said, columns=list(e.keys))


@_finding.register
def _(e: seen.RowsReversed) -> Finding:
    said = (
        f"The rows of {maneuvers(e.maneuvers)} are written from the last to the first: the last "
        "row is the start of the motion. Reverse the values or the times"
    )
    return warning("rows_reversed", said, maneuvers=list(e.maneuvers))


@_finding.register
def _(e: seen.SingleRows) -> Finding:
    many = "1 single row" if e.rows == 1 else f"{e.rows} single rows"
    what = "hold the value of the row before" if e.is_held else "are far from the rows around them"
    if e.rows == 1:
        what = what.replace("hold", "holds").replace("are far", "is far").replace("them", "it")
    said = (
        f"{e.key} of {maneuvers(e.maneuvers)}: {many} {what}, the first at {e.time:.6g} s. Look at "
        "how this column is written or measured there"
    )
    where = {"column": e.key, "maneuvers": list(e.maneuvers)}
    return warning("single_rows", said, **where, rows=e.rows, time=e.time, is_held=e.is_held)


@_finding.register
def _(e: seen.RateOfDifferences) -> Finding:
    said = (
        f"{e.key} is the {e.how} difference of its own angle in this file, in every maneuver, and "
        "not the rate of the motion. Write the rate that your program integrates; the rest is "
        "diagnosed without it"
    )
    return warning("rate_of_differences", said, column=e.key, how=e.how)


@_finding.register
def _(e: seen.Mirrored) -> Finding:
    is_are = "is" if len(e.maneuvers) == 1 else "are"
    said = (
        f"{maneuvers(e.maneuvers).capitalize()} {is_are} the right motion to the other side: all "
        "columns of roll and steer are turned round, as if it began with the opposite roll rate. "
        "Check the sign of the initial roll rate there"
    )
    return warning("mirrored", said, maneuvers=list(e.maneuvers))


@_finding.register
def _(e: seen.RateOfOtherRow) -> Finding:
    row = "half a row" if abs(e.rows) < 1.0 else "one row"
    said = (
        f"{e.key} is the rate of its own angle {row} {'before' if e.rows > 0.0 else 'after'}, in "
        "every maneuver. Write both at the same time; the rest is diagnosed without it"
    )
    return warning("rate_of_other_row", said, column=e.key, rows=e.rows)


@_finding.register
def _(e: seen.OtherClock) -> Finding:
    if e.scale == 1.0:
        when = f"{abs(e.shift):.6g} s {'later' if e.shift > 0.0 else 'earlier'}"
        rows = e.rows and round(e.rows, 2)
        if rows and abs(e.rows or 0.0) >= _PART_OF_A_ROW:
            distances = "the distance" if abs(rows) == 1 else f"{abs(rows):g} times the distance"
            when += f", {distances} of its rows"
    else:
        more = f" and {e.shift:+.3g} s more" if e.shift else ""
        when = f"{e.scale:.7g} times those written{more}"
    rows_of, times_of = "The rows", "the times"
    if e.keys:
        rows_of = f"The rows of {', '.join(e.keys)}"
    if e.maneuver is not None:
        rows_of, times_of = f"{rows_of} of maneuver {e.maneuver}", f"{times_of} of this maneuver"
    said = (
        f"{rows_of} are the right ones of other times: {when}. Look at how {times_of} are written, "
        "and at when the rows are"
    )
    numbers = {"scale": e.scale, "shift": e.shift, "rows": e.rows}
    return warning("other_clock", said, maneuver=e.maneuver, columns=list(e.keys), **numbers)


@_finding.register
def _(e: seen.TimesAddedUp) -> Finding:
    how = "that are added up in single precision" if e.is_single else "that are added up or rounded"
    said = (
        f"The rows are the right ones of the multiples of {e.step:g} s. The times written creep "
        f"away from these by up to {e.creep:.2g} s, as times {how} do. Write the number of the row "
        "times the step"
    )
    return warning("times_added_up", said, step=e.step, creep=e.creep, is_single=e.is_single)


@_finding.register
def _(e: seen.ColumnRatio) -> Finding:
    times = "" if e.factor == 1.0 else f"{e.factor:.7g} times "
    more = "" if not e.offset else f" {'+-'[e.offset < 0]} {abs(e.offset):.6g} (SI)"
    unit = f", as in {e.unit}" if e.unit else ""
    said = (
        f"{e.key} of {maneuvers(e.maneuvers)} is {times}the right one{more}{unit}. Look at how "
        "this column is computed and written"
    )
    numbers = {"factor": e.factor, "offset": e.offset, "unit": e.unit}
    where = {"column": e.key, "maneuvers": list(e.maneuvers)}
    return warning("column_ratio", said, **where, **numbers)


@_finding.register
def _(e: seen.OtherColumn) -> Finding:
    of = f" of maneuver {e.of_maneuver}" if e.of_maneuver is not None else ""
    said = (
        f"{e.key} of {maneuvers(e.maneuvers)} has the values of {e.other}{of}. Check the order in "
        "which columns are written there"
    )
    where = {"column": e.key, "maneuvers": list(e.maneuvers)}
    return warning("other_column", said, **where, other=e.other, of_maneuver=e.of_maneuver)


@_finding.register
def _(e: seen.UnsignedColumn) -> Finding:
    said = (
        f"{e.key} of {maneuvers(e.maneuvers)} has the right values without their signs: look for "
        "an absolute value, or a square root of a square, where it is written"
    )
    return warning("unsigned_column", said, column=e.key, maneuvers=list(e.maneuvers))


@_finding.register
def _(e: seen.ClippedColumn) -> Finding:
    at = " and ".join(f"{x:.6g}" for x in (e.low, e.high) if x is not None)
    where_else = (
        "clipped: the right one goes beyond, and is what is written elsewhere"
        if e.is_right_within
        else "clipped where it is written, or held by a stop in the model. The rest is diagnosed "
        "without it"
    )
    said = f"{e.key} of {maneuvers(e.maneuvers)} stays at {at} (SI), {where_else}"
    where = {"column": e.key, "maneuvers": list(e.maneuvers)}
    bounds = {"low": e.low, "high": e.high}
    return warning("clipped_column", said, **where, **bounds, is_right_within=e.is_right_within)


@_finding.register
def _(e: seen.SmoothedColumns) -> Finding:
    said = (
        f"{named(e.places)}: each value is the mean of {e.rows} rows about its own, a moving "
        "average of the right column. Write the rows as they are computed, without a filter"
    )
    return warning("smoothed_columns", said, columns=list(e.places), rows=e.rows)


@_finding.register
def _(e: seen.Remainder) -> Finding:
    said = (
        f"Nothing else is wrong: with this taken back, the largest error is {e.max_rel_error:.1g} "
        f"of the scale ({e.place})"
    )
    return info("remainder", said, max_rel_error=e.max_rel_error, place=e.place)


# What came of a requirement.


def outcome(found: Outcome) -> str:
    """What came of a requirement in one sentence: where the worst is, or why it is not met."""
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
            return f"maneuver {found.maneuver}, {contradiction_words(found.contradiction)}"
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
    """How much was compared, and what says that this is enough."""
    covered = None if found.coverage is None else f"{100 * found.coverage:g} % of the run"
    columns = None if found.columns is None else f"{found.columns} of {ALL_COLUMNS} columns"
    what = " and ".join(filter(None, (columns, covered)))
    where = f"maneuver {', '.join(map(str, found.maneuvers))}"
    options = " ".join(f"--require '{text}'" for text in found.enough)
    return f"only {what} compared ({where}); if that is intended, add {options}"


# What an error looks like where no cause is known.


@_finding.register
def _(_: seen.TooFar) -> Finding:
    said = (
        "Half of the columns or more are off by half their own size, so that their error says "
        "nothing: look at the first rows, whether the columns are those of the benchmark, in its "
        "order and units, and at a run that is short"
    )
    return info("too_far", said)


@_finding.register
def _(e: seen.BlownUp) -> Finding:
    said = (
        f"The motion blows up: {e.key} of maneuver {e.maneuver} is off by {e.max_rel_error:.2g} "
        f"times its size, and by half of it from {e.time:.3g} s on. Compare the rows before: what "
        "follows says nothing"
    )
    return warning(
        "blown_up",
        said,
        maneuver=e.maneuver,
        column=e.key,
        time=e.time,
        max_rel_error=e.max_rel_error,
    )


@_finding.register
def _(e: seen.ErrorOfRounding) -> Finding:
    said = (
        f"The error is {e.max_rel_error:.1g} of the scale at the most: that is what rounding "
        "leaves of a run in binary64 arithmetic. If it does not fall with the tolerance or the "
        f"step ({_BOTH_TOLERANCES}), it is the arithmetic, and not the model"
    )
    return info("limited_by_rounding", said, max_rel_error=e.max_rel_error)


@_finding.register
def _(_: seen.TooFewRows) -> Finding:
    return info("cannot_tell", "So few rows do not show what the error looks like")


@_finding.register
def _(e: seen.SmoothError) -> Finding:
    said = (
        "The error is smooth. Halve the step or divide the tolerance by ten: if the error falls, "
        "it is the integrator's; if it stays, it is not"
    )
    if e.missing:
        said += f". With {named(e.missing)} in the file, the equations of motion could be checked"
    return info("smooth_error", said, missing=list(e.missing))


@_finding.register
def _(e: seen.WorkFromStart) -> Finding:
    each = ", ".join(f"{x:.3g} W in maneuver {n}" for n, x in e.powers.items())
    forces = ", ".join(f"{x:.3g} N" for x in e.forces.values())
    said = (
        f"From the first row on the kinetic energy changes by {each}, where gravity does no work, "
        f"as a force of {forces} along the motion does: drag, wind, a slope or a drive. An "
        "integrator's share falls with its step"
    )
    numbers = {
        "powers": {str(n): x for n, x in e.powers.items()},
        "forces": {str(n): x for n, x in e.forces.items()},
    }
    return warning("work_from_start", said, **numbers)


@_finding.register
def _(e: seen.Unsymmetric) -> Finding:
    said = (
        f"The error of {e.key} begins in maneuver {e.large} with {e.times:.2g} times what it is in "
        f"maneuver {e.small}, whose roll rate is far smaller. So something moves the upright "
        "bicycle to one side (a mass, an axis, a torque, wind, a slope), or a friction has a size "
        "of its own"
    )
    numbers = {"column": e.key, "maneuvers": [e.small, e.large], "times": e.times}
    return warning("unsymmetric", said, **numbers)


@_finding.register
def _(e: seen.BeginsAs) -> Finding:
    power = {1: "the time", 2: "its square", 3: "its cube, or a higher power"}[e.order]
    rates = " or ".join(key.replace("angle", "rate") for key in e.keys)
    why = {
        1: f"another first {rates}, other times, or a stiff force that acts within the first rows",
        2: "a force or a term that acts from the first row on, or another speed",
        3: "a force or a term that is zero upright and straight, or one that sets in later",
    }[e.order]
    many = "errors of " if len(e.keys) > 1 else "error of "
    begin = "begin" if len(e.keys) > 1 else "begins"
    said = (
        f"The {many}{' and '.join(e.keys)} of {maneuvers(e.maneuvers)} {begin} in proportion to "
        f"{power}, as with {why}"
    )
    where = {"column": e.keys[0], "columns": list(e.keys), "maneuvers": list(e.maneuvers)}
    return warning("begins_as", said, **where, order=e.order)


@_finding.register
def _(e: seen.EnergyTrend) -> Finding:
    every = " in every maneuver" if len(e.maneuvers) > 1 else ""
    numbers, each = list(e.maneuvers), map(str, e.maneuvers)
    changes = dict(zip(each, e.changes, strict=True))
    if max(e.changes) > 0.0:
        said = (
            f"The mechanical energy grows steadily{every}, as with a drive in the model, or an "
            "explicit method of low order, whose share falls with its step"
        )
        return info("energy_grows", said, maneuvers=numbers, relative_change=changes)
    said = (
        f"The mechanical energy falls steadily{every}, as with a damper, drag or a contact that "
        "slips, or with numerical damping, which alone falls with the step or the tolerance"
    )
    return info("numerical_damping", said, maneuvers=numbers, relative_change=changes)


@_finding.register
def _(e: seen.EnergyVaries) -> Finding:
    each = ", ".join(f"{x:+.3g} J at {t:.4g} s in maneuver {n}" for n, (x, t) in e.largest.items())
    if e.until is not None:
        each = ", ".join(f"{x:+.3g} J in maneuver {n}" for n, (x, _) in e.largest.items())
        said = (
            f"The mechanical energy changes before {e.until:.3g} s only, by up to {each}, and then "
            "stays: look at what acts, or is ramped, in that time"
        )
    else:
        said = (
            f"The mechanical energy changes by up to {each}. A force does work, or stores energy "
            "that is not in the sum; or it is an integrator's error, which falls with its step"
        )
    changes = {str(n): x for n, (x, _) in e.largest.items()}
    times = {str(n): t for n, (_, t) in e.largest.items()}
    return info("energy_varies", said, changes=changes, times=times, until=e.until)


@_finding.register
def _(e: seen.EnergyKept) -> Finding:
    most = max(e.exchanged.values())
    said = (
        f"The mechanical energy keeps to {e.left:.2g} J, while its parts are off by up to "
        f"{most:.2g} J. A damper, drag, friction or a drive in the motion would change it"
    )
    exchanged = {str(n): x for n, x in e.exchanged.items()}
    return info("energy_kept", said, left=e.left, exchanged=exchanged)


@_finding.register
def _(e: seen.RoughError) -> Finding:
    whose = "The error" if e.are_all else f"A part of the error of {named(e.places)}"
    said = (
        f"{whose} jumps from row to row like noise, far above the digits written, which no step "
        "size makes: look for single-precision numbers on the way, random terms, or a loose "
        "tolerance of the iterations"
    )
    return info("rough_error", said, columns=list(e.places))


@_finding.register
def _(e: seen.StepRinging) -> Finding:
    said = (
        "The velocities alternate from row to row, as the trapezoidal rule leaves them where "
        "nothing damps the highest frequency: accelerations that are consistent at the start, or a "
        "little numerical damping"
    )
    return info("step_ringing", said, maneuvers=list(e.maneuvers))


@_finding.register
def _(e: seen.IterationNoise) -> Finding:
    said = (
        "The velocities jump from row to row, much more than the angles, as a loose tolerance of "
        "the Newton iterations in each step makes them, or impulses of a contact: tighten it until "
        "the energy's error is smooth (a smaller step does not help); if it stays rough, it is the "
        "contact or the friction, or, where the jumps are below 1e-8 of the scale, rounding "
        "divided by the step"
    )
    return info("iteration_noise", said, maneuvers=list(e.maneuvers))


@_finding.register
def _(e: seen.SinglePrecisionBeside) -> Finding:
    found = _finding(e.single)
    said = f"{found.message}. The error is far larger: another cause comes before this one"
    return info("single_precision", said, columns=list(e.single.keys))


# What is seen in the rows of a file without any simulation.


@_finding.register
def _(e: seen.FallsOver) -> Finding:
    times = " and ".join(f"at {t:.3g} s in maneuver {n}" for n, t in e.times.items())
    said = (
        f"The bicycle falls over: its lean passes 90 degrees {times}. Compare the first tenths of "
        "a second: contact, friction or step there, for what follows is another motion"
    )
    return warning("falls_over", said, times={str(n): t for n, t in e.times.items()})


@_finding.register
def _(e: seen.RowsRepeated) -> Finding:
    which = "rows" if e.are_all else f"rows of {named(e.keys)}"
    why = "the motion ended there, and its last row was" if e.are_all else "they were"
    said = (
        f"From {e.time:.6g} s on all {e.rows} {which} of maneuver {e.maneuver} hold the same "
        f"numbers: {why} written again"
    )
    return warning(
        "rows_repeated",
        said,
        maneuver=e.maneuver,
        time=e.time,
        rows=e.rows,
        columns=list(e.keys),
    )


@_finding.register
def _(e: seen.RowsBetween) -> Finding:
    if e.every:
        said = (
            f"Every {_ordinal(e.every)} row of {maneuvers(e.maneuvers)} is right, and the rows "
            "between are not: they were interpolated. Write the integrator's own rows, or its "
            "dense output"
        )
    else:
        what = "are on straight lines between rows" if e.order else "repeat the row before"
        where = named(e.keys) if e.keys else "most of its angles and rates"
        said = (
            f"At least {100 * e.share:.0f} % of the rows of {maneuvers(e.maneuvers)} {what}, in "
            f"{where}, as no motion does: they were held or interpolated. Write the integrator's "
            "own rows, or its dense output"
        )
    where_ = {"maneuver": e.maneuvers[0], "maneuvers": list(e.maneuvers)}
    numbers = {"order": e.order, "share": e.share, "columns": list(e.keys), "every": e.every}
    return warning("rows_between", said, **where_, **numbers)


def _ordinal(count: int) -> str:
    ends = {1: "st", 2: "nd", 3: "rd"}
    return f"{count}{'th' if 10 < count % 100 < 14 else ends.get(count % 10, 'th')}"


@_finding.register
def _(e: seen.RightElsewhere) -> Finding:
    is_are, it_they = ("is", "it") if len(e.wrong) == 1 else ("are", "them")
    said = (
        f"Only {maneuvers(e.wrong)} {is_are} wrong, and what is said here is about {it_they} "
        f"alone: the largest error of {maneuvers(e.right)} is {e.max_rel_error:.1g} of the scale. "
        "So look at what your program does, or is given, otherwise there"
    )
    numbers = {"wrong": list(e.wrong), "right": list(e.right)}
    return info("right_elsewhere", said, **numbers, max_rel_error=e.max_rel_error)


@_finding.register
def _(e: seen.Departs) -> Finding:
    if e.t_back is not None:
        what = f"to {e.t_back:.6g} s. All rows after these are right: look at these alone"
    elif e.shift is not None:
        why = "left out" if e.shift > 0.0 else "made twice"
        what = f"on, where it is the right motion {_later(e.shift)}: rows or steps were {why}"
    else:
        what = (
            "on: look at what happens there. A mistake in the model or at the start is seen from "
            "the first rows on"
        )
    by = f", by its {named(e.keys)}," if e.keys else ""
    said = (
        f"Maneuver {e.maneuver}{by} is right to {e.before:.1g} of the scales until "
        f"{e.t_right:.6g} s, and off by {e.after:.2g} from {e.time:.6g} s {what}"
    )
    numbers = {"before": e.before, "after": e.after, "shift": e.shift, "columns": list(e.keys)}
    return warning("departs", said, maneuver=e.maneuver, time=e.time, **numbers)


@_finding.register
def _(e: seen.OtherTimes) -> Finding:
    least, most = min(x for x, _ in e.ahead.values()), max(x for _, x in e.ahead.values())
    when = _later((least + most) / 2) if e.is_one else f"{_later(least)} to {_later(most)}"
    said = (
        f"Each row is the right motion, but at another time, {when} than is written. Look at how "
        "the times are written, and at when a row is: before or after the step, at the time asked "
        "for or at the step next to it"
    )
    ahead = {str(n): x for n, x in e.ahead.items()}
    return warning("other_times", said, ahead=ahead, relief=list(e.relief))


def _later(seconds: float) -> str:
    return f"{abs(seconds):.3g} s {'later' if seconds > 0.0 else 'earlier'}"


@_finding.register
def _(e: seen.ColumnOfAnotherManeuver) -> Finding:
    said = (
        f"{', '.join(e.keys)} of maneuver {e.maneuver}: the same numbers as in maneuver {e.of}, "
        "where they belong"
    )
    return warning(
        "column_of_another_maneuver", said, maneuver=e.maneuver, of=e.of, columns=list(e.keys)
    )


@_finding.register
def _(e: seen.AnotherStart) -> Finding:
    said = (
        f"Maneuver {e.maneuver} begins with a {e.key.replace('_', ' ')} of {e.found:.9g} "
        f"{e.unit.replace(' s-1', '/s')} in its first row, where {e.given:.9g} is given"
    )
    if e.told:
        said += f": that is {e.found / e.given:.6g} times as much, as in {e.told}"
    numbers = {"found": e.found, "given": e.given, "unit": e.told}
    return warning("another_start", said, maneuver=e.maneuver, column=e.key, **numbers)


@_finding.register
def _(e: seen.ColumnsApart) -> Finding:
    only = ", ".join(
        key if len(numbers) == e.every else f"{key} of {maneuvers(numbers)}"
        for key, numbers in e.columns.items()
    )
    with_sum = ", and mechanical_energy with it" if e.is_sum_with_it else ""
    scales = "".join(f": {key} is {_scaled(x, e.units[key])}" for key, x in e.fits.items())
    is_one = len(e.columns) == 1
    are, these = ("is", "this column is") if is_one else ("are", "these columns are")
    said = (
        f"Only {only} {are} wrong{with_sum}{scales}. All other columns are right to "
        f"{e.error_of_others:.1g} of their scales, so neither the integrator nor the equations are "
        f"to blame. Look at how {these} computed and written"
    )
    return warning(
        "columns_apart",
        said,
        columns={key: list(numbers) for key, numbers in e.columns.items()},
        max_rel_error_of_others=e.error_of_others,
        factors={key: x.factor for key, x in e.fits.items()},
    )


def _scaled(x: seen.Scaled, unit: str) -> str:
    """What values are, beside the right ones."""
    times = f"{x.factor:.6g} times the right one" if x.factor != 1.0 else "the right one"
    sign = "minus" if x.offset < 0 else "plus"
    return times + (f" {sign} {_in(abs(x.offset), unit)}" if x.offset else "")


def _in(x: float, unit: str) -> str:
    return f"{x:.6g}" + ("" if unit == "1" else " " + unit.replace(" s-1", "/s"))


@_finding.register
def _(e: seen.NotDiagnosed) -> Finding:
    said = (
        f"{named(e.keys)}: not right either, and not diagnosed, as programs with mistakes are "
        "simulated for the benchmark's columns only; begin with those"
    )
    return info("not_diagnosed", said, columns=list(e.keys))


@_finding.register
def _(e: seen.ColumnBeside) -> Finding:
    alone = "while the benchmark's columns here are right"
    advice = "look at how it is computed and written"
    more: dict[str, object] = {}
    if e.constant:
        numbers = " / ".join(_in(x, e.unit) for x in dict.fromkeys(e.constant))
        said = f"holds the same number in every row, {numbers}, {alone}: "
        said += "it was not computed, or not written"
        more = {"constant": list(e.constant)}
    elif e.fit is not None:
        said = f"is {_scaled(e.fit, e.unit)}, {alone}: {advice}"
        more = {"factor": e.fit.factor, "offset": e.fit.offset}
    else:
        said = (
            f"is wrong by up to {e.max_rel_error:.2g} of its scale, {alone}, and neither a factor "
            f"nor an offset explains it: {advice}. Programs with mistakes are simulated for the "
            "benchmark's columns only"
        )
    where = f"{e.key} of maneuver {', '.join(map(str, e.maneuvers))}"
    return warning(
        "column_beside",
        f"{where} {said}",
        column=e.key,
        maneuvers=list(e.maneuvers),
        max_rel_error=e.max_rel_error,
        **more,
    )
