"""Requirements on a report: ``[maneuver.][column.]metric op number``.

The worst value over what is not named counts: the largest for ``<`` and ``<=``, the smallest for
``>`` and ``>=``. A column with values that are not finite fails whatever the others are, and so
does one that contradicts another of the file by its sign, one that was never filled in, and a
requirement on something that the file does not have.
"""

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.errors import InputError, did_you_mean, unknown_word
from heyoka_bike.scoring.findings import named
from heyoka_bike.scoring.report import ColumnScore, ManeuverScore, Report, Requirement

OF_COLUMN = (
    "scd", "mescd", "max_abs_error", "rms_error", "max_rel_error", "time_to_tolerance",
)  # fmt: skip
"""Metrics of a column, see `report.Measures`; as understood."""

OF_MANEUVER = ("performance", "coverage", "gap")
"""Metrics of a maneuver, see `report.ManeuverScore`."""

_OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
_FORM = re.compile(
    r"\s*(?:(?:maneuver_|m)?(?P<maneuver>[0-9]{1,4})\s*\.\s*)?"
    r"(?:(?P<column>[A-Za-z_][A-Za-z_0-9]*)\s*\.\s*)?(?P<metric>[A-Za-z_]+)\s*"
    r"(?P<op><=|>=|<|>)\s*(?P<number>[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?)\s*",
    re.ASCII,
)
_EXAMPLE = 'expected [maneuver.][column.]metric op number, such as "2.roll_angle.scd >= 6"'


@dataclass(frozen=True, slots=True)
class Parsed:
    """A requirement that was read.

    Attributes
    ----------
    maneuver, column
        Number from 1 and key of what it is about; None for all of them.
    metric, op, number
        As in ``scd >= 6``.
    """

    maneuver: int | None
    column: str | None
    metric: str
    op: str
    number: float


def parse(text: str) -> Parsed:
    """Read a requirement.

    Raises
    ------
    InputError
        It has another form, or names an unknown column or metric.
    """
    match = _FORM.fullmatch(text)
    if match is None:
        raise InputError(f"require: found {text!r:.60}, {_EXAMPLE}")
    column, metric = match["column"], match["metric"]
    if metric not in OF_COLUMN + OF_MANEUVER:
        found = unknown_word(metric, OF_COLUMN + OF_MANEUVER, "metric ")
        raise InputError(f"require: {found}")
    if column is not None and column not in COMPARED:
        raise InputError(
            f"require: found column '{column:.40}', expected one of "
            f"{', '.join(BENCHMARK_COLUMNS)}, pitch, yaw, yaw_rate, or of those of motion.h5"
            f"{did_you_mean(column, COMPARED)}"
        )
    if column is not None and metric in OF_MANEUVER:
        raise InputError(
            f"require: found column '{column}' with '{metric}', which is of a whole maneuver"
        )
    number = float(match["number"])
    if not isfinite(number):
        raise InputError(f"require: found {match['number']}, expected a finite number")
    maneuver = None if match["maneuver"] is None else int(match["maneuver"])
    return Parsed(maneuver, column, metric, match["op"], number)


def check(text: str, report: Report) -> Requirement:
    """Hold a requirement against a report.

    Raises
    ------
    InputError
        See `parse`.
    """
    r = parse(text)
    try:
        value, where = (max if r.op in ("<", "<=") else min)(_values(r, report))
    except _NotMetError as e:
        return Requirement(text, False, None, str(e))
    found = value if isfinite(value) else None
    shown = "never" if found is None else f"{found:.3g}"
    return Requirement(text, _OPERATORS[r.op](value, r.number), found, f"{shown} ({where})")


class _NotMetError(Exception):
    """Why a requirement is not met, whatever the numbers are."""


def _values(r: Parsed, report: Report) -> list[tuple[float, str]]:
    """Each value that a requirement speaks of, as far as the digits show it, and where it is."""
    if left_out := _left_out(r, report):
        raise _NotMetError(left_out)
    maneuvers = [m for m in report.maneuvers if r.maneuver in (None, m.maneuver)]
    if not maneuvers:
        raise _NotMetError(f"maneuver {r.maneuver} is not in the file")
    if r.metric in OF_MANEUVER:
        return [(_of_maneuver(m, r), f"maneuver {m.maneuver}") for m in maneuvers]
    values = [
        _of_column(m.maneuver, c, r, report)
        for m in maneuvers
        for c in m.columns
        if r.column in (None, c.key)
    ]
    if not values:
        said = (f for f in report.findings if f.code == "columns_without_reference")
        is_known = any(r.column in f.evidence["columns"] for f in said)
        where = "reference" if is_known else "file"
        raise _NotMetError(f"{r.column or 'no column'} is not in the {where}")
    return values


def _of_column(number: int, c: ColumnScore, r: Parsed, report: Report) -> tuple[float, str]:
    if c.missing:
        raise _NotMetError(f"maneuver {number}, {_why_missing(c)}")
    if c.is_contradicted:
        said = (f for f in report.findings if f.code == "signs_disagree")
        why = next(f.message for f in said if c.key in f.evidence["columns"])
        raise _NotMetError(f"maneuver {number}, {why}")
    where = f"maneuver {number}, {c.key}"
    value = c.shown(r.metric) if c.values else None
    if value is None:
        raise _NotMetError(f"{where}: {r.metric} is not defined, nothing could be compared")
    measured = getattr(c.as_understood.measures, r.metric)
    by_digits = "" if measured is None or value == measured else ", at the digits written"
    return value, where + by_digits


def _of_maneuver(m: ManeuverScore, r: Parsed) -> float:
    for c in m.columns:
        if c.missing and (r.metric != "performance" or c.key.endswith("energy")):
            raise _NotMetError(f"maneuver {m.maneuver}, {_why_missing(c)}")
    if r.metric != "performance":
        value: float = getattr(m, r.metric)
        return value
    if m.performance is None:
        raise _NotMetError(f"maneuver {m.maneuver} has no mechanical energy to judge")
    value, why = m.claim(r.number)
    if why:
        raise _NotMetError(f"maneuver {m.maneuver}: {why}")
    return value


def _left_out(r: Parsed, report: Report) -> str:
    """Why a requirement is not met that speaks of what the file has and was not compared."""
    unfilled, beside = [], []
    for name, key in report.not_compared.items():
        number = name.removesuffix(f".{key}")
        is_place = number != name
        if r.column not in (None, key) or (is_place and r.maneuver not in (None, int(number))):
            continue
        if is_place and (r.metric != "performance" or key.endswith("energy")):
            unfilled.append((number, key))
        elif not is_place and r.metric in OF_COLUMN:
            beside.append(name)
    if unfilled:
        numbers, keys = (", ".join(dict.fromkeys(x)) for x in zip(*unfilled, strict=True))
        return f"maneuver {numbers}, {keys}: never filled in"
    return f"{named(beside)}: one too many, and not compared" if beside else ""


def _why_missing(c: ColumnScore) -> str:
    return f"{c.key}: {c.missing} of {c.missing + c.values} values are not finite"
