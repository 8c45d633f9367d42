"""Evidence from several files together: how errors fall, and what each program covers."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import KEYS_NAMED, counted
from heyoka_bike.scoring.findings import Finding, Severity, info, named, warning

_IN_PROPORTION = 0.25
"""Exponents within this of 1 are called "in proportion"."""


class Grouping(Enum):
    """The role of several files in a comparison."""

    PROGRAMS = "programs"
    FILES = "files"


@dataclass(frozen=True, slots=True)
class NoSharedColumns(Evidence):
    """No two of the programs or files share a column of the same maneuver."""

    of: Grouping

    code = "no_shared_columns"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.of == Grouping.PROGRAMS:
            return "No two programs share a column of the same maneuver, so nothing is compared"
        return (
            "No two files share a column of the same maneuver. Put the columns of one run in one "
            "file"
        )


@dataclass(frozen=True, slots=True)
class StepsUnknown(Evidence):
    """The steps do not distinguish the runs of one program.

    Attributes
    ----------
    is_told
        True if equal steps or tolerances were given; False if the spacing of the rows is equal.
    """

    is_told: bool

    code = "steps_unknown"
    severity = Severity.WARNING

    def message(self) -> str:
        apart = "The rows of several files have the same spacing"
        given = "Several files are given with the same step or tolerance"
        return (
            f"{given if self.is_told else apart}, so the steps do not distinguish the runs. To see "
            "the order of convergence, give the steps of the integrator (--step) or the "
            "tolerances of its solver (--tolerance)"
        )


@dataclass(frozen=True, slots=True)
class ManeuversDiffer(Evidence):
    """Programs cover different maneuvers.

    Attributes
    ----------
    maneuvers : mapping of str to tuple of int
        Numbers of the maneuvers, by the name of the program.
    """

    maneuvers: Mapping[str, tuple[int, ...]]

    code = "maneuvers_differ"
    severity = Severity.WARNING

    def message(self) -> str:
        who: dict[str, list[str]] = {}
        for name, numbers in self.maneuvers.items():
            who.setdefault(", ".join(map(str, numbers)) or "none", []).append(name)
        held = "; ".join(f"{', '.join(names)}: {numbers}" for numbers, names in who.items())
        return (
            f"The programs cover different maneuvers ({held}), so the digits of their worst "
            "columns cannot be compared. Look at the maneuvers that they share"
        )

    def numbers(self) -> Mapping[str, Any]:
        of_each = {name: list(numbers) for name, numbers in self.maneuvers.items()}
        return {"maneuvers": of_each}


@dataclass(frozen=True, slots=True)
class DefinitionsOfPrograms(Evidence):
    """Programs define a column in different ways.

    Attributes
    ----------
    key
    programs : mapping of str to tuple of str
        Names of the programs, by definition.
    """

    key: str
    programs: Mapping[str, tuple[str, ...]]

    code = "definitions_differ"

    def message(self) -> str:
        each = "; ".join(f"{name} in {', '.join(who)}" for name, who in self.programs.items())
        return (
            f"{self.key} is {each}. Each is compared with its own definition, so this is not an "
            "error"
        )

    def numbers(self) -> Mapping[str, Any]:
        by = {name: list(who) for name, who in self.programs.items()}
        return {"column": self.key, "definitions": by}


@dataclass(frozen=True, slots=True)
class DefinitionsOfRuns(Evidence):
    """Files of one program seem to define these columns in different ways."""

    keys: tuple[str, ...]

    code = "definitions_differ"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{', '.join(self.keys)}: the files differ in definition, sign or unit. Check that "
            "they are from one program"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class ErrorFalls(Evidence):
    """The errors of a program fall with its step or its tolerance as a power law.

    Attributes
    ----------
    by
        ``step`` or ``tolerance``.
    exponent
        Median over the columns; with steps it is the order of convergence.
    least, most, columns
        Range of the exponents of the columns, and the number of columns.
    """

    by: str
    exponent: float
    least: float
    most: float
    columns: int

    def _finding(self) -> Finding:
        ends = f"from {_two_decimals(self.least)} to {_two_decimals(self.most)}"
        spread = f"median of {counted(self.columns, 'column')}, {ends}"
        if self.by == "step":
            said = f"Observed order of convergence: {_two_decimals(self.exponent)} ({spread})"
            return info("order", said, order=self.exponent, least=self.least, most=self.most)
        how = "in proportion to the tolerance"
        if abs(self.exponent - 1) > _IN_PROPORTION:
            how = f"like the tolerance to the power {self.exponent:.1f}"
        said = f"The error falls {how}: exponent {self.exponent:.2f} ({spread})"
        return info("tolerance", said, exponent=self.exponent, least=self.least, most=self.most)


@dataclass(frozen=True, slots=True)
class OrderNotSettled(Evidence):
    """The order of convergence of these columns (``2.roll_angle``) changes from step to step."""

    places: tuple[str, ...]

    code = "order_not_settled"

    def message(self) -> str:
        return (
            f"The order of convergence of {', '.join(self.places)} still changes from one run to "
            "the next. Either the steps are too large for a power law, or rounding has been reached"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places)}


class Staying(Enum):
    """Kinds of errors that do not fall with the step or the tolerance."""

    ROUNDING = "it is as small as the accumulated rounding of binary64"
    NOISE = "it is a different curve in each run"
    SAME_CURVE = "it is the same curve in both runs"


@dataclass(frozen=True, slots=True)
class ErrorStays(Evidence):
    """The error of these columns does not fall with the step or the tolerance.

    Attributes
    ----------
    how : Staying
    places
        The columns (``2.roll_angle``).
    max_rel_error
        The largest of their errors, relative to the scale.
    by
        What should reduce the error: ``step`` or ``tolerance``.
    """

    how: Staying
    places: tuple[str, ...]
    max_rel_error: float
    by: str

    def _finding(self) -> Finding:
        places, size = named(self.places, KEYS_NAMED), f"{self.max_rel_error:.1g}"
        numbers = {"columns": list(self.places), "max_rel_error": self.max_rel_error}
        if self.how == Staying.ROUNDING:
            said = (
                f"{places}: the error, at most {size} of the largest value, does not fall with the "
                f"{self.by}. At this size it is accumulated rounding of binary64, not the model. "
                "Only a longer number format makes it smaller"
            )
            return info("limited_by_rounding", said, **numbers)
        if self.how == Staying.NOISE:
            said = (
                f"{places}: the error, up to {size} of the largest value, does not fall with the "
                f"{self.by} and is a different curve in each run. It is noise, not the model. It "
                "comes from single-precision numbers (1e-7), a loose tolerance in an iterative "
                "solver, or rough interpolation"
            )
            return warning("noise_does_not_fall", said, **numbers)
        said = (
            f"{places}: the error, up to {size} of the largest value, is the same curve in both "
            "runs, "
            f"whatever the {self.by}. It comes from the model, its parameters, the initial "
            "conditions or the output, not from the integrator. Run heyoka-bike diagnose"
        )
        return warning("error_stays", said, **numbers)


def _two_decimals(order: float) -> str:
    return f"{round(order, 2) + 0.0:.2f}"  # adding 0.0 turns -0.0 into 0.0
