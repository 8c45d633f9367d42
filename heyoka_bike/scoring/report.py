"""The report of a scored result file: numbers and findings, behind every output format."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import floor, inf, log10
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from heyoka_bike.display import Displayed, Held
from heyoka_bike.errors import unknown_word
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring import verdict
from heyoka_bike.scoring.findings import Finding, grouped
from heyoka_bike.scoring.reading.headings import recognise
from heyoka_bike.scoring.scored import Scored
from heyoka_bike.scoring.verdict import WHOLE as WHOLE
from heyoka_bike.scoring.verdict import Grade

if TYPE_CHECKING:
    from heyoka_bike.scoring.alignment import FileInfo, Part

# Decimal logarithm of the odds that are put into words: nobody has tried more files than that.
_SUREST = 6
_CLAIMED = 20.0


@dataclass(frozen=True, slots=True)
class Measures:
    """Distances of a column from the reference; None where nothing could be compared.

    Formulas and sources are in docs/measures.md.

    Attributes
    ----------
    max_abs_error
        Largest absolute error over the rows [SI unit of the column].
    time_of_max
        When it occurs [s].
    rms_error
        Root of the mean squared error of the rows [SI unit].
    max_rel_error
        Largest absolute error divided by the column's scale, the largest absolute value of the
        reference over its whole run.
    scd
        Significant correct digits, -log10 of the former, at most 32.
    mescd
        Mixed-error significant correct digits, -log10 max abs(e) / (1 + abs(reference)) in SI
        units, at most 32.
    time_to_tolerance
        First time at which the error exceeds 1e-3 of the scale [s]; None if it never does.
    """

    max_abs_error: float | None
    time_of_max: float | None
    rms_error: float | None
    max_rel_error: float | None
    scd: float | None
    mescd: float | None
    time_to_tolerance: float | None


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to take a written column, and the errors that follow.

    Attributes
    ----------
    definition
        Which definition of the quantity it is compared with.
    sign
        1, or -1 if the written values have the other sign.
    unit
        Unit of the written values.
    offset
        What the written values have too much, in the SI unit of the column.
    measures : Measures
    """

    definition: str
    sign: int
    unit: str
    offset: float
    measures: Measures


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another definition of a column, and how far the file is from it.

    Attributes
    ----------
    definition
    max_abs_error
        [SI unit]
    log10_odds
        Odds of the definition that the column turned out to have against this one, over all
        maneuvers of the file together, as a decimal logarithm; below zero if this one is likelier,
        but not enough to give up the default. None where nothing tells.
    """

    definition: str
    max_abs_error: float | None
    log10_odds: float | None = None


@dataclass(frozen=True, slots=True)
class Growth:
    """Largest error in one part of the run.

    Attributes
    ----------
    t_start, t_end
        The part [s].
    max_abs_error
        [SI unit]; None without rows there.
    """

    t_start: float
    t_end: float
    max_abs_error: float | None


@dataclass(frozen=True, eq=False, slots=True)
class Trace:
    """A column over time, for figures; SI units, as understood.

    Attributes
    ----------
    time, value, error : ndarray, shape (n,)
        Rows with a finite value only; the error is exact to a few digits even where it is far
        below the last digit of the value.
    """

    time: Array
    value: Array
    error: Array

    @property
    def reference(self) -> Array:
        """The reference, to binary64."""
        return self.value - self.error


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class ColumnScore:
    """Verdict on one column of one maneuver: ``column.scd``, ``column.max_abs_error``.

    Its measures are those as understood.

    Attributes
    ----------
    key
        Name of the column (``roll_angle``).
    unit
        SI unit of all errors, UDUNITS spelling.
    as_written : Reading
        Taken as the default definition in SI units, with the default sign and zero.
    as_understood : Reading
        Taken as the definition, sign, unit and offset that fit.
    floor
        What the digits written allow at best [SI unit]: the largest error of correctly rounded
        values; None if unknown.
    alternatives : tuple of Alternative
        The other definitions, with the same sign, unit and offset.
    indistinguishable : tuple of str
        Definitions that fit as well, so that none is claimed.
    growth : tuple of Growth
        Largest error in each tenth of the reference's run.
    values, missing
        How many values were compared, and how many were not finite.
    trace : Trace
    scale
        Largest value of the reference over its whole run [SI unit].
    unexplained
        Largest error beyond what rounding to the digits of its own row explains [SI unit].
    resolution
        Largest error of a value rounded to the digits of its own row [SI unit]; of rows with
        different digits it is more than the floor.
    is_contradicted
        True if its sign and those of other columns are of no choice of axes.
    none_odds
        Odds of the definition against every one that is not known here, as a decimal logarithm, see
        `definitions`; None of a column with one definition.
    """

    key: str
    unit: str
    as_written: Reading
    as_understood: Reading
    floor: float | None
    alternatives: tuple[Alternative, ...]
    indistinguishable: tuple[str, ...]
    growth: tuple[Growth, ...]
    values: int
    missing: int
    trace: Trace
    scale: float
    unexplained: float
    resolution: float
    is_contradicted: bool = False
    none_odds: float | None = None

    @property
    def is_known(self) -> bool:
        """True if the odds of the definition against one that is not known are 20 to 1 or more.

        If they are not, the one that the column is compared with is the nearest.
        """
        return self.none_odds is None or self.none_odds >= log10(_CLAIMED)

    @property
    def definition(self) -> str:
        """The definition that the column turned out to have."""
        return self.as_understood.definition

    @property
    def scd(self) -> float | None:
        """Significant correct digits, see `Measures`."""
        return self.as_understood.measures.scd

    @property
    def mescd(self) -> float | None:
        """Mixed-error significant correct digits, see `Measures`."""
        return self.as_understood.measures.mescd

    @property
    def max_abs_error(self) -> float | None:
        """Largest absolute error [SI unit]."""
        return self.as_understood.measures.max_abs_error

    @property
    def time_of_max(self) -> float | None:
        """When it occurs [s]."""
        return self.as_understood.measures.time_of_max

    @property
    def rms_error(self) -> float | None:
        """Root of the mean squared error [SI unit]."""
        return self.as_understood.measures.rms_error

    @property
    def max_rel_error(self) -> float | None:
        """Largest absolute error divided by the column's scale."""
        return self.as_understood.measures.max_rel_error

    @property
    def time_to_tolerance(self) -> float | None:
        """First time at which the error exceeds 1e-3 of the scale [s]; None if it never does."""
        return self.as_understood.measures.time_to_tolerance

    @property
    def grade(self) -> Grade:
        """Right, not to be told at the digits written, close or wrong, see `verdict.grade`."""
        return verdict.grade(
            self.max_abs_error,
            unexplained=self.unexplained,
            resolution=self.resolution,
            scale=self.scale,
            is_contradicted=self.is_contradicted,
        )

    @property
    def is_right(self) -> bool:
        """True if it has six correct digits, and is written with as many."""
        return self.grade == Grade.RIGHT

    def shown(self, metric: str) -> float | None:
        """A measure as far as the digits written can show it: no better than they are."""
        found: float | None = getattr(self.as_understood.measures, metric)
        least = self.resolution
        if metric == "time_to_tolerance":
            found = inf if found is None else found
            return 0.0 if least > verdict.TOLERANCE * self.scale else found
        if found is None or metric == "rms_error":
            return found
        if metric in ("scd", "mescd"):
            size = self.scale if metric == "scd" else 1.0 + self.scale
            return min(found, verdict.digits_of(least, size))
        return max(found, least / (self.scale or inf) if metric == "max_rel_error" else least)

    def __repr__(self) -> str:
        if self.scd is None:
            return f"<{self.key}: nothing compared>"
        found = f"{self.scd:.1f} correct digits, largest error {self.max_abs_error:.2g} {self.unit}"
        return f"<{self.key} ({self.definition}): {found}>"

    def is_at_floor(self, times: float = 1.0) -> bool:
        """True if the error is no more than so many times what the digits written allow."""
        error = self.as_understood.measures.max_abs_error
        return error is not None and self.floor is not None and error <= times * self.floor


def odds(c: ColumnScore) -> str:
    """Return the odds of a column's definition against the likeliest other one, in words."""
    told = [
        (a.log10_odds, a.definition)
        for a in c.alternatives
        if a.log10_odds is not None and a.definition not in c.indistinguishable
    ]
    if not told:
        return ""
    sure, definition = min(told)
    if c.none_odds is not None and c.none_odds < min(sure, _SUREST):
        return f"{odds_words(c.none_odds)} against one that is not known here"
    return f"{odds_words(sure)} against {definition}"


def open_words(columns: Sequence[ColumnScore]) -> str:
    """Name the other definitions that the maneuvers leave open; empty if there is none."""
    names = dict.fromkeys(name for c in columns for name in c.indistinguishable)
    others = [name for name in names if name != columns[0].definition]
    return f"may also be {' or '.join(others)}" if others else ""


def odds_words(power: float) -> str:
    """Odds of which the decimal logarithm is given, as "300 to 1"."""
    if power > _SUREST:
        return f"over 10^{_SUREST} to 1"
    if power < 0.0:
        return f"1 to {10**-power:.2g}" if power > -_SUREST else f"1 to over 10^{_SUREST}"
    return f"10^{floor(power)} to 1" if power >= 3 else f"{10**power:.0f} to 1"


@dataclass(frozen=True, slots=True)
class Consistency:
    """Agreement of the file with itself; None where that cannot be asked of it.

    Attributes
    ----------
    energy_sum
        Largest abs(potential + kinetic - mechanical energy) [J].
    energy_sum_floor
        What rounding of the written values explains of it [J].
    roll_rate, steer_rate
        Difference of the rate from the derivative of its own angle, root mean square over the steps
        [rad/s], only where the two columns as recognised are such a pair.
    contradicted
        Rates that their own angles contradict: the difference is more than rounding, and three
        times what the angle's error amounts to.
    """

    energy_sum: float | None
    energy_sum_floor: float | None
    roll_rate: float | None
    steer_rate: float | None
    contradicted: tuple[str, ...] = ()


class Worst(NamedTuple):
    """The column with the fewest correct digits.

    Attributes
    ----------
    maneuver
        Its number.
    column
        Its key.
    scd
        Its digits.
    """

    maneuver: int
    column: str
    scd: float


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class ManeuverScore(Displayed, Held[str, ColumnScore]):
    """Verdict on one maneuver: ``maneuver["roll_angle"]`` is that on one of its columns.

    Attributes
    ----------
    maneuver
        Number from 1.
    name
    rows
        Rows compared.
    t_start, t_end
        First and last time with a value in every column [s].
    coverage
        Part of the reference's run that such rows cover: that lies between two of them that are no
        farther apart than its longest dense piece. 0 without such rows.
    gap
        The longest stretch of the run that none of these rows falls in [s].
    step
        Median distance of the rows [s]; None of a single row.
    performance
        Eq. (1) of the benchmark, 100 (max E - min E) / E0 [%], E the file's own mechanical energy
        from the floor and E0 its first value; None of fewer than two rows, or with E0 = 0.
    performance_limit
        What the benchmark allows [%] for the maneuver it judges; None for the others.
    consistency : Consistency
    columns : tuple of ColumnScore
        In the order of `columns.COMPARED`, those in the file.
    part : Part
        The rows that were compared, as written.
    """

    maneuver: int
    name: str
    rows: int
    t_start: float
    t_end: float
    coverage: float
    gap: float
    step: float | None
    performance: float | None
    performance_limit: float | None
    consistency: Consistency
    columns: tuple[ColumnScore, ...]
    part: Part

    _view: ClassVar[str] = "maneuver"

    def __getitem__(self, key: str) -> ColumnScore:
        for column in self.columns:
            if column.key == key:
                return column
        # As people write it in a file: roll, phi.
        meant = recognise(str(key))
        if meant is not None and meant[0] != key and meant[0] in list(self):
            return self[meant[0]]
        raise KeyError(unknown_word(str(key), list(self), "column "))

    def __iter__(self) -> Iterator[str]:
        return (column.key for column in self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def worst(self) -> Worst | None:
        """The column with the fewest correct digits; None if nothing was compared."""
        found = (Worst(self.maneuver, c.key, c.scd) for c in self.columns if c.scd is not None)
        return min(found, key=lambda w: w.scd, default=None)

    def claim(self, limit: float) -> tuple[float, str]:
        """Eq. (1) [%] as it may be claimed against a limit, and why it is not what was measured."""
        columns = {c.key: c for c in self.columns if c.values}
        total = columns.get("mechanical_energy")
        parts = [columns[k] for k in ("potential_energy", "kinetic_energy") if k in columns]
        energy = [total] if total else parts
        scale = self.part.reference.scale("mechanical_energy")
        apart, floor = self.consistency.energy_sum, self.consistency.energy_sum_floor
        rounding = inf if floor is None else floor
        explained = verdict.SUM_ROUNDING * rounding + verdict.ARITHMETIC * scale
        if total is None:
            apart = 0.0
        elif apart is not None and apart <= explained:
            # Parts that are written more coarsely than the limit do not tell.
            apart = 0.0 if 100 * rounding <= limit * scale else None
        true_error = (total and total.max_abs_error) or 0.0
        if total and "potential_energy" not in columns:
            # Any constant has another zero, if its parts do not show which.
            true_error += abs(total.as_understood.offset)
        return verdict.performance(
            self.performance,
            limit,
            resolution=200 * sum(c.resolution for c in energy) / scale,
            sum_error=apart,
            true_error=100 * true_error / scale,
            start=abs(float(sum(c.trace.value[0] for c in energy))) / scale,
        )

    @property
    def is_own_energy(self) -> bool:
        """True if eq. (1) is of the file's own energy, or of the true one, whatever the limit."""
        return not self.claim(inf)[1]

    @property
    def meets_limit(self) -> bool | None:
        """The benchmark's verdict by eq. (1); None if it has none, or there is no energy."""
        if self.performance is None or self.performance_limit is None:
            return None
        return self.claim(self.performance_limit)[0] < self.performance_limit


Place = tuple[ManeuverScore, ColumnScore]
"""A column, and the maneuver it is of."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """One ``--require`` and what came of it.

    Attributes
    ----------
    text
        As given (``2.roll_angle.scd >= 6``).
    met
    found
        The worst value; None if there is none or it is infinite.
    message
        One sentence: where the worst is, or why nothing could be compared.
    """

    text: str
    met: bool
    found: float | None
    message: str


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """The error of one column before and after an explanation.

    Attributes
    ----------
    maneuver, key, unit
    time : ndarray, shape (n,)
        [s]
    before, after : ndarray, shape (n,)
        Absolute error against the reference, and against what explains the file [unit].
    """

    maneuver: int
    key: str
    unit: str
    time: Array
    before: Array
    after: Array


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """The first of what a diagnosis found, for the figure; its words are among the findings.

    Attributes
    ----------
    says
        One sentence without a full stop.
    curves : tuple of Curve
        In each maneuver the column that it explains best.
    """

    says: str
    curves: tuple[Curve, ...]


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Report(Scored, Held[int, ManeuverScore]):
    """Everything that is said about a result file: ``report[2]["roll_angle"].scd``.

    Attributes
    ----------
    dataset_version
        Of the reference.
    bicycle
        Name of the reference's bicycle.
    file : FileInfo
    maneuvers : tuple of ManeuverScore
    findings : tuple of Finding
        How the file was understood, and what is odd about it.
    requirements : tuple of Requirement
    diagnosis : tuple of Finding
        Why the file differs, the likeliest first; empty if that was not asked.
    explanation : Explanation or None
        Of a diagnosis, if it found something.
    reference_sha256
        Hash of the reference's numbers, its ``content_sha256``; empty if unknown.
    """

    dataset_version: str
    bicycle: str
    file: FileInfo
    maneuvers: tuple[ManeuverScore, ...]
    findings: tuple[Finding, ...]
    requirements: tuple[Requirement, ...] = ()
    diagnosis: tuple[Finding, ...] = ()
    explanation: Explanation | None = None
    reference_sha256: str = ""

    def __getitem__(self, number: int) -> ManeuverScore:
        for maneuver in self.maneuvers:
            if maneuver.maneuver == number:
                return maneuver
        raise KeyError(f"found maneuver {number!r}, expected one of {', '.join(map(str, self))}")

    def __iter__(self) -> Iterator[int]:
        return (maneuver.maneuver for maneuver in self.maneuvers)

    def __len__(self) -> int:
        return len(self.maneuvers)

    @property
    def worst(self) -> Worst | None:
        """The column with the fewest correct digits; None if nothing was compared."""
        found = (m.worst for m in self.maneuvers)
        return min((w for w in found if w), key=lambda w: w.scd, default=None)

    def by_column(self) -> dict[str, list[Place]]:
        """The columns that hold a value, by key, in every maneuver that has them."""
        return grouped((c.key, (m, c)) for m in self.maneuvers for c in m.columns if c.values)

    @property
    def said(self) -> tuple[Finding, ...]:
        """All findings, those of the diagnosis first; none of them twice."""
        return self.diagnosis + tuple(f for f in self.findings if f not in self.diagnosis)

    @property
    def passed(self) -> bool:
        """True if every requirement is met: without any too, however wrong the file is.

        Whether it is right is said by `is_right`.
        """
        return all(r.met for r in self.requirements)

    @property
    def is_right(self) -> bool:
        """True if the verdict is that the file is right, over the whole run.

        Every column has six correct digits and is written with as many, and no signs contradict
        each other. Columns that are not in the file are not asked for.
        """
        return verdict.is_right(self.grades, is_whole=self.is_whole)

    @property
    def grades(self) -> list[Grade]:
        """Grades of all columns; a file has the worst of them."""
        return [c.grade for m in self.maneuvers for c in m.columns]

    @property
    def is_whole(self) -> bool:
        """True if all of the run was compared, and all that the file has under known names."""
        has_gaps = any(c.missing for m in self.maneuvers for c in m.columns)
        is_covered = all(m.coverage >= WHOLE for m in self.maneuvers)
        return is_covered and not has_gaps and not self.not_compared

    @property
    def not_compared(self) -> dict[str, str]:
        """The columns never filled in, and those beside another of the same quantity.

        By its name in the file, or its place (``2.roll_angle``), the key of the column.
        """
        keys = {c.key for m in self.maneuvers for c in m.columns}
        found: dict[str, str] = {}
        for f in self.findings:
            if f.code == "never_filled":
                found |= {place: place.partition(".")[2] for place in f.evidence["columns"]}
            elif f.code == "known_columns_left_out":
                # Those of a name with a number.
                meant = {n: recognise(n.rstrip("0123456789 _")) for n in f.evidence["names"]}
                found |= {name: m[0] for name, m in meant.items() if m and m[0] in keys}
        return found


@dataclass(frozen=True, slots=True)
class Convergence:
    """One column over several runs of one program at different step sizes.

    Attributes
    ----------
    maneuver, key, unit
    definition
        Of the last run that has the column; another one of a run is said in the findings.
    errors : tuple of float or None
        Largest absolute error of each run, in the order of the runs [SI unit].
    orders : tuple of float or None
        Observed order between neighbouring runs, log(e1 / e2) / log(h1 / h2); None where an error
        is at its floor or the step sizes are unknown.
    richardson_error
        Largest error of the Richardson extrapolation of the two finest runs, on their common
        times [SI unit]: what is reachable with them; None without an order.
    floor
        What the digits written by the finest run allow [SI unit]; None of several programs.
    """

    maneuver: int
    key: str
    unit: str
    definition: str
    errors: tuple[float | None, ...]
    orders: tuple[float | None, ...]
    richardson_error: float | None
    floor: float | None


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """One run of a program, or one of several programs, in a series.

    Attributes
    ----------
    report : Report
    step
        Step size [s]; None if unknown.
    cpu
        Processor time [s]; None if not given.
    name
        Of the program or of the run; empty for the name of its file.
    tolerance
        Of a solver that chooses its steps; None if unknown.
    """

    report: Report
    step: float | None
    cpu: float | None
    name: str = ""
    tolerance: float | None = None


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Series(Scored):
    """Several runs of one program, the coarsest first, or several programs side by side.

    ``series[0]`` is the report of the first, ``series["name"]`` that of a program.

    Attributes
    ----------
    runs : tuple of Run
    convergence : tuple of Convergence
    findings : tuple of Finding
        About the series; those about a run are in its report.
    is_one_program
        Whether the runs are of one program at different steps or tolerances: it has one choice of
        definitions, and an order of convergence. Programs are judged each by itself.
    """

    runs: tuple[Run, ...]
    convergence: tuple[Convergence, ...]
    findings: tuple[Finding, ...]
    is_one_program: bool = True

    def __getitem__(self, which: int | str) -> Report:
        if not isinstance(which, str):
            return self.runs[which].report
        for run in self.runs:
            if run.name == which:
                return run.report
        names = [run.name for run in self.runs if run.name] or ["the number of a run"]
        raise KeyError(unknown_word(which, names, "program "))

    def __iter__(self) -> Iterator[Report]:
        return (run.report for run in self.runs)

    def __len__(self) -> int:
        return len(self.runs)

    @property
    def passed(self) -> bool:
        """True if every requirement is met by every run."""
        return all(run.report.passed for run in self.runs)
