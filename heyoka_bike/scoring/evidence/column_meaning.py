"""Evidence about the meaning of columns: definitions, signs, units and zeros."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import floor
from typing import Any

from heyoka_bike.bicycle.columns import COMPARED, FREE_ZERO
from heyoka_bike.scoring.evidence.base import Errors, Evidence, Odds
from heyoka_bike.scoring.evidence.words import (
    KEYS_NAMED,
    counted,
    errors_words,
    its_errors,
    odds_words,
    open_words,
    ratio_words,
    unit_text,
)
from heyoka_bike.scoring.findings import Severity, named, together

_COLUMNS_OF_SIDE: Mapping[str, tuple[str, ...]] = {
    "roll": ("roll_angle", "roll_rate"),
    "steer": ("steer_angle", "steer_rate"),
    "yaw": ("yaw", "yaw_rate"),
}

_TURNED = {"forward_speed": "the speed is positive backward", "pitch": "nose down is positive"}


def default_conventions(keys: Collection[str]) -> str:
    """State the default conventions of the columns with these keys."""
    said = ["Conventions: SI units"]
    if sides := [
        side for side, of_side in _COLUMNS_OF_SIDE.items() if not {*of_side}.isdisjoint(keys)
    ]:
        said.append(f"{together(sides)} positive to the right")
    if not {"potential_energy", "mechanical_energy"}.isdisjoint(keys):
        said.append("potential energy zero on the floor")
    return ", ".join(said)


@dataclass(frozen=True, slots=True)
class TakenDefinition:
    """A column, and the definition by which it is read.

    Attributes
    ----------
    key, definition
    odds : Odds or None
        None if the odds are unknown.
    may_also_be
        Other definitions that fit as well.
    """

    key: str
    definition: str
    odds: Odds | None
    may_also_be: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class WholeTurns(Evidence):
    """Angles were written within one turn; the whole turns between their rows were added."""

    keys: tuple[str, ...]

    code = "whole_turns"

    def message(self) -> str:
        are = "is" if len(self.keys) == 1 else "are"
        return (
            f"{named(self.keys, KEYS_NAMED)} {are} written modulo 2 pi. This is not an error: "
            "heyoka_bike adds the missing multiples of 2 pi where the values jump"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class ScalarLast(Evidence):
    """The quaternion of a frame, ``rear`` or ``front``, was written with its scalar last."""

    end: str

    code = "scalar_last"

    def message(self) -> str:
        return (
            f"The quaternion of the {self.end} frame has its scalar last (x, y, z, w). This is not "
            "an error: the quaternion was read in this order"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"frame": self.end}


@dataclass(frozen=True, slots=True)
class PathTurned(Evidence):
    """The path on the floor starts at a heading [rad] other than zero; it was rotated to zero."""

    heading: float

    code = "path_turned"

    def message(self) -> str:
        return (
            f"The path on the floor starts at a heading of {self.heading:.6g} rad. This is not an "
            "error: the positions were rotated to a heading of zero"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"heading": self.heading}


@dataclass(frozen=True, slots=True)
class Conventions(Evidence):
    """The file follows conventions other than the default ones.

    Attributes
    ----------
    turned
        Columns with the opposite sign.
    units, offsets
        Unit, and offset of the zero [SI unit], by column key.
    definitions : tuple of TakenDefinition
        Columns with other definitions than the default.
    are_signs_contradicted
        True if the signs of further columns contradict each other.
    has_others
        True if the file has several columns.
    """

    turned: tuple[str, ...]
    units: Mapping[str, str]
    offsets: Mapping[str, float]
    definitions: tuple[TakenDefinition, ...]
    are_signs_contradicted: bool
    has_others: bool = True

    code = "conventions"

    def message(self) -> str:
        said = [
            *_senses(self.turned),
            *in_units(self.units),
            *_zeros(self.offsets),
            *(f"{d.key} is {d.definition}{_in_brackets(taken_words(d))}" for d in self.definitions),
        ]
        but = ", except the signs in the warning," if self.are_signs_contradicted else ""
        others = f"Everything else{but} follows the default conventions. "
        return (
            f"The file uses its own conventions, which are not errors: {'; '.join(said)}. "
            f"{others if self.has_others else ''}All errors are computed with these conventions"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "signs": list(self.turned),
            "units": dict(self.units),
            "offsets": dict(self.offsets),
            "definitions": {d.key: d.definition for d in self.definitions},
        }


@dataclass(frozen=True, slots=True)
class Convention(Evidence):
    """Base of the conventions of one column.

    Attributes
    ----------
    key
    errors, errors_as_written
        Errors with the convention applied, and errors if the column is read by the default
        definition in SI units.
    """

    key: str
    errors: Errors
    errors_as_written: Errors


@dataclass(frozen=True, slots=True)
class OtherDefinition(Convention):
    """A column follows a definition other than the default.

    Attributes
    ----------
    taken : TakenDefinition
    default
        Name of the default definition.
    errors_of_default
        Errors if the column is read by the default definition.
    """

    taken: TakenDefinition
    default: str
    errors_of_default: Errors

    code = "definition"

    def message(self) -> str:
        taken = self.taken
        sure = f", {odds_words(taken.odds)}" if taken.odds else ""
        return (
            f"{self.key} is {taken.definition}{sure}{_in_brackets(open_words(taken.may_also_be))}. "
            f"{_largest(self)}; with the default {self.default} "
            f"{'it' if len(self.errors) == 1 else 'they'} would be "
            f"{errors_words(self.errors_of_default)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {**_of_convention(self), "definition": self.taken.definition}


@dataclass(frozen=True, slots=True)
class OtherSign(Convention):
    """A column has the opposite sign."""

    code = "sign"

    def message(self) -> str:
        return f"{self.key} has the opposite sign. {_largest(self)} after the sign is flipped"

    def numbers(self) -> Mapping[str, Any]:
        return _of_convention(self)


@dataclass(frozen=True, slots=True)
class OtherUnit(Convention):
    """A column is in a unit other than the default."""

    unit: str
    default: str

    code = "unit"

    def message(self) -> str:
        unit, default = unit_text(self.unit), unit_text(self.default)
        return f"{self.key} is in {unit}, not {default}. {_largest(self)}"

    def numbers(self) -> Mapping[str, Any]:
        return {**_of_convention(self), "unit": self.unit}


@dataclass(frozen=True, slots=True)
class OtherZero(Convention):
    """A column has a different zero level: its values are too large by a constant [SI unit]."""

    offset: float

    code = "offset"

    def message(self) -> str:
        return (
            f"{self.key} is shifted by {_off(self.key, self.offset)}. {_largest(self)} "
            "after this constant is subtracted"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {**_of_convention(self), "offset": self.offset}


@dataclass(frozen=True, slots=True)
class UnitContradicted(Evidence):
    """The heading of a column names one unit, but its values are in another."""

    key: str
    heading: str
    unit: str

    code = "unit_contradicted"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key}: the heading names the unit {unit_text(self.heading)}, but the values fit "
            f"{unit_text(self.unit)} and are read in this unit. Correct the heading or the values"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "named": self.heading, "unit": self.unit}


@dataclass(frozen=True, slots=True)
class SignContradiction(Evidence):
    """The signs of columns contradict each other: no choice of axes gives these signs."""

    keys: tuple[str, ...]

    code = "signs_disagree"
    severity = Severity.WARNING

    def message(self) -> str:
        if len(self.keys) == 2:
            one, other = self.keys
            return f"{one} and {other} have opposite signs: the sign of one of them is wrong"
        said = f"No choice of axes gives these signs of {named(self.keys)}: some signs are wrong"
        return said + (", or the attitude is inverse" if "frame_" in self.keys[0] else "")

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class SensesOpposed(Evidence):
    """Roll is positive to the left but steer to the right, as in only a few sets of axes."""

    keys: tuple[str, ...]

    code = "senses_opposed"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            "Roll is positive to the left, but steer to the right. Right-handed axes give this "
            "only if one points backward and another down. If x points forward, roll has a sign "
            "error. If z points up, steer has a sign error"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class DefinitionUnknown(Evidence):
    """A column fits no known definition, while the other columns are right.

    Attributes
    ----------
    key
    nearest
        The nearest known definition.
    log10_odds
        Decimal logarithm of the odds of that definition against all unknown definitions.
    errors : Errors
        Errors with the nearest definition.
    digits_of_others
        Correct digits of the worst other column.
    """

    key: str
    nearest: str
    log10_odds: float
    errors: Errors
    digits_of_others: float

    code = "definition_unknown"
    severity = Severity.WARNING

    def message(self) -> str:
        sure = ""
        if self.log10_odds < 0.0:
            sure = f" (odds {ratio_words(-self.log10_odds)})"
        others = ""
        if self.digits_of_others >= 1.0:
            digits = floor(self.digits_of_others)
            others = (
                f", although the other columns have at least {counted(digits, 'correct digit')}"
            )
        return (
            f"{self.key} fits no known definition{sure}{others}. The nearest definition is "
            f"{self.nearest}. {_largest(self)} with that definition. Check to which point and axis "
            "the column refers, and how it is computed and written"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "column": self.key,
            "nearest": self.nearest,
            "max_abs_error": list(self.errors),
            "digits_of_others": self.digits_of_others,
        }


def _senses(turned: Sequence[str]) -> Iterable[str]:
    """State the positive direction of the columns with the opposite sign."""
    left = [name for name, keys in _COLUMNS_OF_SIDE.items() if set(keys) & set(turned)]
    if left:
        yield f"{together(left)} {'is' if len(left) == 1 else 'are'} positive to the left"
    yield from (text for key, text in _TURNED.items() if key in turned)
    known = {*_TURNED, *(key for keys in _COLUMNS_OF_SIDE.values() for key in keys)}
    if others := [key for key in turned if key not in known]:
        have = "has" if len(others) == 1 else "have"
        yield f"{named(others, KEYS_NAMED)} {have} the opposite sign, as with flipped axes"


def in_units(units: Mapping[str, str]) -> Iterable[str]:
    """Format the units of columns, as "roll_angle, steer_angle are in degrees"."""
    for unit in dict.fromkeys(units.values()):
        keys = [key for key, u in units.items() if u == unit]
        are = "is" if len(keys) == 1 else "are"
        yield f"{named(keys, KEYS_NAMED)} {are} in {unit_text(unit)}"


def _zeros(zeros: Mapping[str, float]) -> Iterable[str]:
    for offset in dict.fromkeys(zeros.values()):
        keys = [key for key, x in zeros.items() if x == offset]
        which = named(keys, KEYS_NAMED)
        if keys[0] in FREE_ZERO:
            yield f"{which} {'is' if len(keys) == 1 else 'are'} shifted by {_off(keys[0], offset)}"
        else:
            where = "above" if offset < 0 else "below"
            yield f"the zero of {which} is {abs(offset):.9g} J {where} that at the floor"


def _largest(e: Convention | DefinitionUnknown) -> str:
    """Begin a sentence on the largest errors of a column, as "Its largest error is 0.17 rad"."""
    unit = COMPARED[e.key][0].unit
    return its_errors(e.errors) + ("" if unit == "1" else f" {unit_text(unit)}")


def _off(key: str, offset: float) -> str:
    """Format an offset with its sign and the unit of the column."""
    return f"{offset:+.9g} {unit_text(COMPARED[key][0].unit)}"


def _in_brackets(said: str) -> str:
    return f" ({said})" if said else ""


def _of_convention(e: Convention) -> dict[str, Any]:
    return {
        "column": e.key,
        "max_abs_error": list(e.errors),
        "max_abs_error_as_written": list(e.errors_as_written),
    }


def taken_words(taken: TakenDefinition) -> str:
    """Format the odds of a definition, and the other definitions that fit as well."""
    odds = odds_words(taken.odds) if taken.odds else ""
    return ", ".join(x for x in (odds, open_words(taken.may_also_be)) if x)
