"""Evidence from aligning the rows with the reference: maneuvers, columns, the run's end."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.evidence.words import counted, either, time_beside
from heyoka_bike.scoring.findings import Severity, maneuvers, together

_NO_NUMBERS = {"nan": "NaN", "0.0": "zero", "-0.0": "zero"}


@dataclass(frozen=True, slots=True)
class ManeuverRecognised(Evidence):
    """The file does not contain the maneuver's number; its values or its name show the maneuver.

    Attributes
    ----------
    maneuver
    is_by_name
        True if the values fit several maneuvers, and the name of the file states this one.
    """

    maneuver: int
    is_by_name: bool = False

    code = "maneuver_recognised"

    def message(self) -> str:
        by = "the name of the file" if self.is_by_name else "their values"
        return f"The columns are those of maneuver {self.maneuver}, recognised by {by}"

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "is_by_name": self.is_by_name}


@dataclass(frozen=True, slots=True)
class ManeuverNamedOtherwise(Evidence):
    """The values of a file exclude the maneuver that its name states.

    Attributes
    ----------
    maneuver
        The maneuver with which the file is compared. It is the named one if otherwise two files
        of a run would have the same maneuver.
    named
        The maneuver that the name of the file states.
    fits
        The maneuvers that the values fit, the nearest first.
    """

    maneuver: int
    named: int
    fits: tuple[int, ...]

    code = "maneuver_named_otherwise"
    severity = Severity.WARNING

    def message(self) -> str:
        value = "with a number for each file" if self.file else self.named
        why = f". If the name is right, use --maneuver {value}"
        if self.maneuver == self.named:
            why = ", because two files have rows of the same maneuver"
        return (
            f"The name of the file states maneuver {self.named}, but the rows are those of "
            f"maneuver {either([*map(str, self.fits)])}. They are compared with maneuver "
            f"{self.maneuver}{why}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "named": self.named, "fits": list(self.fits)}


@dataclass(frozen=True, slots=True)
class ManeuverGuessed(Evidence):
    """The file does not name its maneuver, and its values fit several maneuvers.

    Attributes
    ----------
    maneuver
        The nearest maneuver, with which the file is compared.
    may_be
        The other possible maneuvers, the nearest first.
    option
        The option that names the maneuver.
    """

    maneuver: int
    may_be: tuple[int, ...]
    option: str

    code = "maneuver_guessed"
    severity = Severity.WARNING

    def message(self) -> str:
        others = " or ".join(map(str, self.may_be))
        return (
            f"The file does not name its maneuver. It is compared with maneuver {self.maneuver}, "
            f"which is a guess: it may also be maneuver {others}. To choose the maneuver, use "
            f"{self.option}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "may_be": list(self.may_be)}


@dataclass(frozen=True, slots=True)
class NoReference(Evidence):
    """Columns were left out because the reference does not contain them.

    Attributes
    ----------
    keys
    folder
        Folder of the reference.
    lacks
        The file that the reference lacks; empty if that file exists without these columns.
    """

    keys: tuple[str, ...]
    folder: str
    lacks: str = ""

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        return (LostColumn(key, key) for key in self.keys)

    code = "columns_without_reference"
    severity = Severity.WARNING

    def message(self) -> str:
        lacks = f"no {self.lacks}" if self.lacks else "no such columns"
        where = f"the reference in {self.folder}"
        return f"{', '.join(self.keys)}: not compared, because {where} has {lacks}"

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class MeantByValues(Evidence):
    """The meaning of an ambiguous column name was chosen by the values of the column.

    Attributes
    ----------
    key
        Key of the column; None if the values fit no meaning, and the column is left out.
    may_be
        Keys of the possible columns.
    """

    key: str | None
    may_be: tuple[str, ...]

    code = "meant_by_values"

    def message(self) -> str:
        return (
            f"The name of a column may mean {either(self.may_be)}. Its values fit "
            f"{self.key or 'none of these, so it is left out'}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "may_be": list(self.may_be)}


@dataclass(frozen=True, slots=True)
class WheelRate(Evidence):
    """The forward speed is written as the rate of rotation of a wheel.

    Attributes
    ----------
    radius
        Radius of the wheel, with its unit.
    """

    radius: str

    code = "wheel_rate"

    def message(self) -> str:
        return (
            f"forward_speed is the rate of a wheel in rad/s; the speed is this rate times "
            f"{self.radius}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"radius": self.radius}


@dataclass(frozen=True, slots=True)
class OtherOrder(Evidence):
    """The columns of the benchmark are in another order.

    Attributes
    ----------
    keys
        The keys that the values fit, in the order of the file.
    told
        The option that states this order; empty if there is none.
    maneuvers : tuple of int
        The maneuvers in this order; empty if all of them are.
    """

    keys: tuple[str, ...]
    told: str = ""
    maneuvers: tuple[int, ...] = ()

    code = "columns_in_another_order"
    severity = Severity.WARNING

    def message(self) -> str:
        of = f" of {maneuvers(self.maneuvers)}" if self.maneuvers else ""
        said = f"The columns{of} seem to be in another order: {', '.join(self.keys)}"
        if self.told:
            said += f". To use this order: {self.told}"
        return said

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys), "maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class OtherManeuver(Evidence):
    """The values given for one maneuver are nearer to another maneuver.

    Attributes
    ----------
    maneuver, nearest
    distance, own_distance
        Typical difference from the nearest maneuver, and from the maneuver for which they are
        given, relative to the scales of the columns.
    """

    maneuver: int
    nearest: int
    distance: float
    own_distance: float

    code = "another_maneuver"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"The values given for maneuver {self.maneuver} are nearer to maneuver "
            f"{self.nearest}. They typically differ from maneuver {self.nearest} by "
            f"{self.distance:.2g} of a column's largest value, and from maneuver {self.maneuver} "
            f"by {self.own_distance:.2g}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "nearest": self.nearest}


@dataclass(frozen=True, slots=True)
class TimesInLargerUnit(Evidence):
    """The times seem to be in minutes or hours: read as seconds, the angles change too fast.

    Attributes
    ----------
    unit
        Name of the unit.
    seconds
        Seconds in the unit.
    span
        Span of the times, read as seconds [s].
    """

    unit: str
    seconds: float
    span: float

    code = "time_in_larger_unit"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"The times span {self.span:.4g} s, but the angles change far more in this time than "
            f"their rates allow. Are the times in {self.unit}? Write seconds, or put the unit in "
            "the heading"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"unit": self.unit, "span": self.span}


@dataclass(frozen=True, slots=True)
class RowsOutside(Evidence):
    """Rows with times outside the run of the reference are left out.

    Attributes
    ----------
    rows
        Number of these rows.
    t_first, t_last
        The earliest and the latest of their times [s].
    duration
        Duration of the reference [s].
    may_be_in
        The smaller unit that most times may have, in words; None if no such unit fits.
    """

    rows: int
    t_first: float
    t_last: float
    duration: float
    may_be_in: str | None = None

    code = "time_outside"
    severity = Severity.WARNING

    def message(self) -> str:
        first, last = (time_beside(t, self.duration) for t in (self.t_first, self.t_last))
        question = f"; are the times in {self.may_be_in}?" if self.may_be_in else ""
        rows = counted(self.rows, "row")
        rows += f" at {first} s is" if self.rows == 1 else f" from {first} to {last} s are"
        return (
            f"{rows} left out: the reference covers 0 to {self.duration:g} s and is not "
            f"extrapolated{question}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"rows": self.rows, "t_first": self.t_first, "t_last": self.t_last}


@dataclass(frozen=True, slots=True)
class TooLarge(Evidence):
    """Values are too large to compute with; they are left out."""

    maneuver: int
    key: str
    values: int

    code = "too_large"
    severity = Severity.WARNING

    def message(self) -> str:
        are = (
            "is larger than 1e150 and was" if self.values == 1 else "are larger than 1e150 and were"
        )
        return (
            f"Maneuver {self.maneuver}: {counted(self.values, 'value')} of {self.key} {are} left "
            "out"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "column": self.key, "values": self.values}


@dataclass(frozen=True, slots=True)
class Unfilled:
    """A column of a maneuver with the same number in every row, although the quantity varies."""

    maneuver: int
    key: str
    number: float


@dataclass(frozen=True, slots=True)
class ConstantColumns(Evidence):
    """Columns contain the same number in every row, so they are left out of the result.

    Attributes
    ----------
    columns : tuple of Unfilled
    maneuvers
        Number of maneuvers in the file.
    """

    columns: tuple[Unfilled, ...]
    maneuvers: int

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        return (LostColumn(f"{x.maneuver}.{x.key}", x.key, x.maneuver) for x in self.columns)

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": [f"{x.maneuver}.{x.key}" for x in self.columns]}

    def _held(self) -> str:
        """Describe the columns and their numbers: ``potential_energy of maneuver 1 is zero``."""
        held: dict[tuple[str, str], list[int]] = {}
        for x in self.columns:
            held.setdefault((x.key, repr(x.number)), []).append(x.maneuver)
        alike: dict[tuple[str, tuple[int, ...]], list[str]] = {}
        for (key, number), where in held.items():
            alike.setdefault((number, tuple(where)), []).append(key)
        said = []
        for (number, numbers), keys in alike.items():
            of = f" of {maneuvers(numbers)}" if len(numbers) < self.maneuvers else ""
            what = _NO_NUMBERS.get(number, f"{float(number):.9g}")
            said.append(f"{', '.join(keys)}{of} {'is' if len(keys) == 1 else 'are'} {what}")
        return together(said)


@dataclass(frozen=True, slots=True)
class NeverFilled(ConstantColumns):
    """Columns contain the same number in every row, although the quantity varies."""

    code = "never_filled"
    severity = Severity.WARNING

    def message(self) -> str:
        is_one = len(self.columns) == 1
        these, are = ("This column was", "it is") if is_one else ("These columns were", "they are")
        return (
            f"{self._held()} in every row, although the exact values vary. {these} never filled "
            f"in, or lost digits, so {are} left out of the result"
        )


@dataclass(frozen=True, slots=True)
class ConstantInMotion(ConstantColumns):
    """Columns contain the same number in every row, as in the motion of the cause found."""

    code = "constant_in_motion"
    severity = Severity.INFO

    def message(self) -> str:
        these = "This column is" if len(self.columns) == 1 else "These columns are"
        return (
            f"{self._held()} in every row, as in the motion of the cause that the diagnosis found. "
            f"{these} left out of the result"
        )
