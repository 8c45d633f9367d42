"""Evidence from aligning the rows with the reference: maneuvers, columns, the run's end."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.evidence.words import counted, time_beside
from heyoka_bike.scoring.findings import Severity

_NO_NUMBERS = {"nan": "nothing but NaN", "0.0": "nothing but zeros", "-0.0": "nothing but zeros"}


@dataclass(frozen=True, slots=True)
class ManeuverRecognised(Evidence):
    """The maneuver of a file that does not tell it was recognised by its values."""

    maneuver: int

    code = "maneuver_recognised"

    def message(self) -> str:
        return f"the columns are those of maneuver {self.maneuver}, recognised by their values"

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver}


@dataclass(frozen=True, slots=True)
class ManeuverGuessed(Evidence):
    """The values of a file that does not name its maneuver may be of several.

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
            f"the file does not name its maneuver. It is compared with maneuver {self.maneuver}, "
            f"which is a guess: it may also be maneuver {others}. To choose: {self.option}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "may_be": list(self.may_be)}


@dataclass(frozen=True, slots=True)
class NoReference(Evidence):
    """Columns that the reference does not have.

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
        return f"{', '.join(self.keys)}: left out, for the reference in {self.folder} has {lacks}"

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class MeantByValues(Evidence):
    """A name with several meanings was decided by its values; key None: it is none of them."""

    key: str | None
    may_be: tuple[str, ...]

    code = "meant_by_values"

    def message(self) -> str:
        return (
            f"the name of a column may mean {' or '.join(self.may_be)}; by its values it is "
            f"{self.key or 'none of them and left out'}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "may_be": list(self.may_be)}


@dataclass(frozen=True, slots=True)
class WheelRate(Evidence):
    """The forward speed is written as the rate of a wheel of this radius, with its unit."""

    radius: str

    code = "wheel_rate"

    def message(self) -> str:
        return (
            f"forward_speed is the rate of a wheel [rad/s]; its speed is that times {self.radius}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"radius": self.radius}


@dataclass(frozen=True, slots=True)
class OtherOrder(Evidence):
    """Columns of the benchmark that stand in the places of others.

    Attributes
    ----------
    keys
        The keys that the values fit, in the order of the file.
    told
        The option that states this order; empty without one.
    """

    keys: tuple[str, ...]
    told: str = ""

    code = "columns_in_another_order"
    severity = Severity.WARNING

    def message(self) -> str:
        said = f"the columns seem to be in another order: {', '.join(self.keys)}"
        if self.told:
            said += f"; {self.told} tells it"
        return said

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class OtherManeuver(Evidence):
    """Values in the place of a maneuver that are nearer to another one.

    Attributes
    ----------
    maneuver, nearest
    distance, own_distance
        Typical difference from the nearest maneuver and from their own, relative to the columns.
    """

    maneuver: int
    nearest: int
    distance: float
    own_distance: float

    code = "another_maneuver"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"the values in the place of maneuver {self.maneuver} are nearer to maneuver "
            f"{self.nearest} (relative distance {self.distance:.2g}, against "
            f"{self.own_distance:.2g})"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "nearest": self.nearest}


@dataclass(frozen=True, slots=True)
class TimesInLargerUnit(Evidence):
    """Times that are those of a run in minutes or hours, of angles too fast for seconds.

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
            f"The times span {self.span:.4g} s, in which the angles change far more than their "
            f"rates allow. Are the times in {self.unit}? Write seconds, or the unit in the heading"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"unit": self.unit, "span": self.span}


@dataclass(frozen=True, slots=True)
class RowsOutside(Evidence):
    """Rows outside the run of the reference, which are left out.

    Attributes
    ----------
    rows
        Number of these rows.
    t_first, t_last
        The earliest and the latest of their times [s].
    duration
        Duration of the reference [s].
    may_be_in
        The smaller unit that most times may have, in words; None if they fit none.
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
        question = f"; are they in {self.may_be_in}?" if self.may_be_in else ""
        return (
            f"{counted(self.rows, 'row')} with times from {first} to {last} s left out: the "
            f"reference covers 0 to {self.duration:g} s and nothing is extrapolated{question}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"rows": self.rows, "t_first": self.t_first, "t_last": self.t_last}


@dataclass(frozen=True, slots=True)
class TooLarge(Evidence):
    """Values that are too large to compute with, which are left out."""

    maneuver: int
    key: str
    values: int

    code = "too_large"
    severity = Severity.WARNING

    def message(self) -> str:
        are = "is" if self.values == 1 else "are"
        return (
            f"maneuver {self.maneuver}: {counted(self.values, 'value')} of {self.key} {are} beyond "
            "1e150 and left out"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "column": self.key, "values": self.values}


@dataclass(frozen=True, slots=True)
class Unfilled:
    """A column of a maneuver with one number in every row, where the quantity varies."""

    maneuver: int
    key: str
    number: float


@dataclass(frozen=True, slots=True)
class NeverFilled(Evidence):
    """Columns that were never filled in; `maneuvers` is how many the file has."""

    columns: tuple[Unfilled, ...]
    maneuvers: int

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        return (LostColumn(f"{x.maneuver}.{x.key}", x.key, x.maneuver) for x in self.columns)

    code = "never_filled"
    severity = Severity.WARNING

    def message(self) -> str:
        held: dict[tuple[str, str], list[int]] = {}
        for x in self.columns:
            held.setdefault((x.key, repr(x.number)), []).append(x.maneuver)
        alike: dict[tuple[str, tuple[int, ...]], list[str]] = {}
        for (key, number), where in held.items():
            alike.setdefault((number, tuple(where)), []).append(key)
        said = []
        for (number, numbers), keys in alike.items():
            of = (
                f" of maneuver {', '.join(map(str, numbers))}"
                if len(numbers) < self.maneuvers
                else ""
            )
            what = _NO_NUMBERS.get(number, f"{float(number):.9g}")
            said.append(f"{', '.join(keys)}{of} hold{'s' if len(keys) == 1 else ''} {what}")
        return (
            f"{', '.join(said)}: one number in every row of what varies, so never filled in; left "
            "out of the result"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": [f"{x.maneuver}.{x.key}" for x in self.columns]}
