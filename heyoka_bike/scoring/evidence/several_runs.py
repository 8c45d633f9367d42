"""Evidence that several files show together: how errors fall, and who covers what."""

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
    """No two of the programs or files have a column of one maneuver in common."""

    of: Grouping

    code = "no_shared_columns"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.of == Grouping.PROGRAMS:
            return (
                "no maneuver has a column that two of the programs share: nothing is side by side"
            )
        return (
            "no maneuver has a column that two of the files share; those of one run go in one file"
        )


@dataclass(frozen=True, slots=True)
class StepsUnknown(Evidence):
    """Nothing tells the runs of one program apart; `is_told` if equal steps were given."""

    is_told: bool

    code = "steps_unknown"
    severity = Severity.WARNING

    def message(self) -> str:
        apart = "the rows of several files are equally far apart"
        return (
            f"{'several files are given as alike' if self.is_told else apart}, so the step sizes "
            "do not tell the runs apart; give those of the integrator (--step) to see the order "
            "of convergence, or the tolerances of its solver (--tolerance)"
        )


@dataclass(frozen=True, slots=True)
class ManeuversDiffer(Evidence):
    """Programs that hold different maneuvers, by their names."""

    maneuvers: Mapping[str, tuple[int, ...]]

    code = "maneuvers_differ"
    severity = Severity.WARNING

    def message(self) -> str:
        who: dict[str, list[str]] = {}
        for name, numbers in self.maneuvers.items():
            who.setdefault(", ".join(map(str, numbers)) or "none", []).append(name)
        held = "; ".join(f"{', '.join(names)}: {numbers}" for numbers, names in who.items())
        return (
            f"the programs cover different maneuvers ({held}), so that the digits of their worst "
            "columns do not compare: look at the maneuvers that they share"
        )

    def numbers(self) -> Mapping[str, Any]:
        of_each = {name: list(numbers) for name, numbers in self.maneuvers.items()}
        return {"maneuvers": of_each}


@dataclass(frozen=True, slots=True)
class DefinitionsOfPrograms(Evidence):
    """A column that programs define in different ways: the programs of each definition."""

    key: str
    programs: Mapping[str, tuple[str, ...]]

    code = "definitions_differ"

    def message(self) -> str:
        each = "; ".join(f"{name} in {', '.join(who)}" for name, who in self.programs.items())
        return (
            f"{self.key} is {each}: each is compared with its own definition, so this is no error"
        )

    def numbers(self) -> Mapping[str, Any]:
        by = {name: list(who) for name, who in self.programs.items()}
        return {"column": self.key, "definitions": by}


@dataclass(frozen=True, slots=True)
class DefinitionsOfRuns(Evidence):
    """Columns that files of one program seem to define in different ways."""

    keys: tuple[str, ...]

    code = "definitions_differ"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{', '.join(self.keys)} of these files have different definitions, signs or units; "
            "are they of one program?"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class ErrorFalls(Evidence):
    """How the errors of a program fall with its step or its tolerance.

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
            said = f"observed order of convergence {_two_decimals(self.exponent)} ({spread})"
            return info("order", said, order=self.exponent, least=self.least, most=self.most)
        how = "in proportion to the tolerance"
        if abs(self.exponent - 1) > _IN_PROPORTION:
            how = f"like the tolerance to the power {self.exponent:.1f}"
        said = f"the error falls {how}: exponent {self.exponent:.2f} ({spread})"
        return info("tolerance", said, exponent=self.exponent, least=self.least, most=self.most)


@dataclass(frozen=True, slots=True)
class OrderNotSettled(Evidence):
    """Columns (``2.roll_angle``) whose order still changes from step to step."""

    places: tuple[str, ...]

    code = "order_not_settled"

    def message(self) -> str:
        return (
            f"the order of {', '.join(self.places)} still changes from step to step: the steps are "
            "too large, or rounding has been reached, for one power law"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places)}


class Staying(Enum):
    """Kinds of errors that do not fall with the step or the tolerance."""

    ROUNDING = "it is as small as rounding of binary64"
    NOISE = "it is another curve in each run"
    SAME_CURVE = "it is the same curve in both runs"


@dataclass(frozen=True, slots=True)
class ErrorStays(Evidence):
    """Columns whose error does not fall.

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
                f"{places}: the error, {size} of the scale or less, does not fall with the "
                f"{self.by}, and need not: at this size it is rounding of binary64 arithmetic, not "
                "the model; only longer numbers make it smaller"
            )
            return info("limited_by_rounding", said, **numbers)
        if self.how == Staying.NOISE:
            said = (
                f"{places}: the error, up to {size} of the scale, does not fall with the "
                f"{self.by}, but is another curve in each run: it is noise, of single-precision "
                "numbers (1e-7), of iterations that stop early, or of rough interpolation, and "
                "not the model"
            )
            return warning("noise_does_not_fall", said, **numbers)
        said = (
            f"{places}: the error, up to {size} of the scale, is the same curve in both runs and "
            f"does not fall with the {self.by}: it is not the integrator's, but that of the model, "
            "its parameters, the start or the output; ask heyoka-bike diagnose"
        )
        return warning("error_stays", said, **numbers)


def _two_decimals(order: float) -> str:
    return f"{round(order, 2) + 0.0:.2f}"  # no -0
