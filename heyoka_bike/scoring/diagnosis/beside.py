"""Columns beside the benchmark's: no program is simulated for them, but some errors are plain.

Where the columns of the benchmark are right, a column beside them that is not is written wrongly:
the same number in every row, or the right one times a factor or with another zero, is seen.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, info, named, warning
from heyoka_bike.scoring.judge.unknown import RIGHT, is_far
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import ManeuverScore, Report

# Worse than every column of the benchmark, and explained to a hundredth by one number or two.
_WORSE, _MOSTLY = 10.0, 100.0
_AT_FLOOR = 4.0
_ADVICE = "look at how it is computed and written"

Place = tuple[ManeuverScore, ColumnScore]


@dataclass(frozen=True, slots=True)
class Scaled:
    """Values are a factor times the right ones, and an offset [SI]."""

    factor: float
    offset: float

    def says(self, unit: str) -> str:
        times = f"{self.factor:.6g} times the right one" if self.factor != 1.0 else "the right one"
        sign = "minus" if self.offset < 0 else "plus"
        return times + (f" {sign} {_in(abs(self.offset), unit)}" if self.offset else "")


def beside(report: Report, left_out: Collection[str] = ()) -> tuple[Finding, ...]:
    """Return findings about the columns that are not the benchmark's and not right.

    Parameters
    ----------
    left_out
        Keys of columns of unknown meaning; those are not held to be right, and only named here if
        a factor or an offset explains them.
    """
    found: list[Finding] = []
    others = []
    for key, places in report.by_column().items():
        wrong = [(m, c) for m, c in places if not (c.is_right or c.is_at_floor(_AT_FLOOR))]
        if key in BENCHMARK_COLUMNS or not wrong:
            continue
        if all(_is_alone(m, c, left_out) for m, c in wrong):
            found += _seen(key, wrong, key in left_out)
        elif key not in left_out:
            others.append(key)
    return (*found, *_not_diagnosed(others))


def _is_alone(m: ManeuverScore, c: ColumnScore, left_out: Collection[str]) -> bool:
    """True if the benchmark's columns of the maneuver are right, and this one far from that."""
    errors = [
        other.max_rel_error or 0.0
        for other in m.columns
        if other.values and other.key in BENCHMARK_COLUMNS and other.key not in left_out
    ]
    limit = max(errors, default=1.0)
    return limit < RIGHT and is_far(c, limit, _WORSE)


def _seen(key: str, places: Sequence[Place], is_unknown: bool) -> Iterator[Finding]:
    """Yield the finding about a column that is wrong alone."""
    numbers = [m.maneuver for m, _ in places]
    worst = max(c.max_rel_error or 0.0 for _, c in places)
    evidence: dict[str, object] = {"column": key, "maneuvers": numbers, "max_rel_error": worst}
    where = f"{key} of maneuver {', '.join(map(str, numbers))}"
    alone = "while the benchmark's columns here are right"
    unit = places[0][1].unit
    constants = [x for _, c in places if (x := _constant(c)) is not None]
    if len(constants) == len(places):
        held = " / ".join(_in(x, unit) for x in dict.fromkeys(constants))
        said = f"holds the same number in every row, {held}, {alone}: "
        said += "it was not computed, or not written"
        evidence["constant"] = constants
    elif fit := scaled([c for _, c in places]):
        said = f"is {fit.says(unit)}, {alone}: {_ADVICE}"
        evidence |= {"factor": fit.factor, "offset": fit.offset}
    elif is_unknown:
        return
    else:
        said = (
            f"is wrong by up to {worst:.2g} of its scale, {alone}, and neither a factor nor an "
            f"offset explains it: {_ADVICE}. Programs with mistakes are simulated for the "
            "benchmark's columns only"
        )
    yield warning("column_beside", f"{where} {said}", **evidence)


def _not_diagnosed(keys: Sequence[str]) -> Iterator[Finding]:
    if keys:
        yield info(
            "not_diagnosed",
            f"{named(keys)}: not right either, and not diagnosed, as programs with mistakes are "
            "simulated for the benchmark's columns only; begin with those",
            columns=list(keys),
        )


def _in(x: float, unit: str) -> str:
    return f"{x:.6g}" + ("" if unit == "1" else " " + unit.replace(" s-1", "/s"))


def _constant(c: ColumnScore) -> float | None:
    """The number that a column holds in every row, where the right one moves."""
    value = c.trace.value
    is_held = not np.ptp(value) and bool(np.ptp(c.trace.reference))
    return float(value[0]) if is_held else None


def scaled(columns: Sequence[ColumnScore]) -> Scaled | None:
    """The factor, the offset or both, the same in all maneuvers, that explain a column."""
    sizes = [rms(c.trace.reference) or 1.0 for c in columns]
    value = np.concatenate([c.trace.value / s for c, s in zip(columns, sizes, strict=True)])
    right = np.concatenate([c.trace.reference / s for c, s in zip(columns, sizes, strict=True)])
    one = np.concatenate([np.full(c.values, 1 / s) for c, s in zip(columns, sizes, strict=True)])
    forms: Mapping[str, Array] = {
        "factor": right[:, None],
        "offset": one[:, None],
        "both": np.column_stack([right, one]),
    }
    for form, matrix in forms.items():
        goal = value - right if form == "offset" else value
        if len(goal) <= matrix.shape[1]:
            continue
        found = [float(x) for x in np.linalg.lstsq(matrix, goal, rcond=None)[0]]
        factor = 1.0 if form == "offset" else found[0]
        fit = Scaled(factor, 0.0 if form == "factor" else found[-1])
        if all(_explains(fit, c) for c in columns):
            return fit
    return None


def _explains(fit: Scaled, c: ColumnScore) -> bool:
    left = c.trace.value - fit.factor * c.trace.reference - fit.offset
    return _MOSTLY * rms(left) < rms(c.trace.error)
