"""Words and numbers that the output formats have in common.

A grade, by the true error alone, is shown by a sign and a colour beside the digits; tables that
show the signs say what they mean.
"""

import math
import os
import shlex
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from heyoka_bike.errors import printable, shortened
from heyoka_bike.scoring.evidence.as_read import NotCompared
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import SensesOpposed
from heyoka_bike.scoring.evidence.contradictions import EnergyHidesError
from heyoka_bike.scoring.evidence.several_runs import ManeuversDiffer
from heyoka_bike.scoring.evidence.words import counted as counted
from heyoka_bike.scoring.evidence.words import open_words as open_words
from heyoka_bike.scoring.evidence.words import ratio_words as ratio_words
from heyoka_bike.scoring.evidence.words import unit_text as unit_text
from heyoka_bike.scoring.findings import Finding, Severity, named
from heyoka_bike.scoring.grades import CLOSE_DIGITS, MOST_DIGITS, RIGHT_DIGITS
from heyoka_bike.scoring.grades import Grade as Grade
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Run, Series
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.scoring.verdict import ALL_COLUMNS, WHOLE, DoesNotCount, claim
from heyoka_bike.version import __version__

_LONGEST_NAME_SHOWN = 30
_MOST_LEFT_OUT = 4

WORDS = {
    Grade.RIGHT: "right",
    Grade.UNTOLD: "cannot be told at the digits written",
    Grade.CLOSE: "close",
    Grade.WRONG: "wrong",
}
SIGNS = {Grade.RIGHT: "✓", Grade.UNTOLD: "?", Grade.CLOSE: "≈", Grade.WRONG: "✗"}
ASCII_SIGNS = {Grade.RIGHT: "+", Grade.UNTOLD: "?", Grade.CLOSE: "o", Grade.WRONG: "x"}
MEANINGS = {
    Grade.RIGHT: f"right: {RIGHT_DIGITS:g} correct digits or more",
    Grade.UNTOLD: "cannot be told at the digits written: they allow no more",
    Grade.CLOSE: f"close: {CLOSE_DIGITS:g} to {RIGHT_DIGITS:g} digits",
    Grade.WRONG: f"wrong: fewer than {CLOSE_DIGITS:g} digits, off by more than a thousandth of the "
    "column's largest value",
}
PHRASES = {
    "nothing": "nothing could be compared",
    "in_part": ", as far as it goes",
    "of_all": "of",
    "columns": "columns",
    "worst": "worst column",
    "no_digit": "worst column without a correct digit",
    "correct_digits": "correct digits",
    "maneuver": "maneuver",
    "bad_time": "cannot be judged: a time is not finite",
    "signs_of": ", for the signs of ",
    "contradict": " contradict each other; apart from that",
    "own_definition": ": a definition of its own? If not, ",
    "own_definitions": ": definitions of their own? If not, ",
}
"""Of the verdict, beside `WORDS`; the checker in C has both, see `workbench.checker.header`."""


DOES_NOT_COUNT = {
    DoesNotCount.NO_ENERGY: "there is no mechanical energy to judge",
    DoesNotCount.NOT_ITS_SUM: "its energy is not its own potential plus kinetic energy",
    DoesNotCount.NOT_TRUE: "its energy is not the true one, and its parts do not show otherwise",
    DoesNotCount.ANOTHER_START: "its energy does not begin with the true one",
    DoesNotCount.FEW_DIGITS: "it cannot be told at the digits written",
}
"""Why eq. (1) cannot be claimed."""


def sentence(text: str) -> str:
    """A message as one line: white space collapsed, then as `printable`."""
    return printable(" ".join(text.split()))


def number(x: float | None, digits: int = 2) -> str:
    """An error to a few significant digits, ``-`` if unknown."""
    if x is None or not math.isfinite(x):
        return "-"
    return "0" if x == 0 else f"{x:.{digits - 1}e}"


def readable(x: float | None) -> str:
    """A number within a sentence: a decimal where that is short, ``-`` if unknown."""
    if x is not None and 0.01 <= abs(x) < 1000:
        return f"{x:.2g}" if abs(x) < 100 else f"{x:.0f}"
    return number(x)


def plain(x: float | None, digits: int = 4) -> str:
    """A time or a step to a few digits without padding, ``-`` if unknown."""
    return "-" if x is None or not math.isfinite(x) else f"{x:.{digits}g}"


def one_decimal(x: float | None) -> str:
    """Correct digits, or an order; ``-`` if unknown."""
    # No digits are not minus none.
    return "-" if x is None or not math.isfinite(x) else f"{round(x, 1) + 0.0:.1f}"


def in_unit(said: str, unit: str) -> str:
    """A number with its unit behind it, if it has one."""
    return said if unit == "1" else f"{said} {unit_text(unit)}"


def label(key: str) -> str:
    """A column's key in words."""
    return printable(key.replace("_", " "))


def heading(m: ManeuverScore) -> str:
    """Number of a maneuver, and its name if that says more."""
    return f"maneuver {m.maneuver}" + (
        "" if m.name == f"maneuver {m.maneuver}" else f", {printable(m.name)}"
    )


def reports(scored: Report | Series) -> tuple[Report, ...]:
    """The report, or those of all runs."""
    return (scored,) if isinstance(scored, Report) else tuple(r.report for r in scored.runs)


def is_default(column: ColumnScore) -> bool:
    """True if a column is understood as the default definition."""
    return column.as_understood.definition == column.as_written.definition


def mark(column: ColumnScore) -> str:
    """``*`` if the definition is not the default one, ``~`` if others fit as well."""
    return ("" if is_default(column) else "*") + ("~" if column.indistinguishable else "")


def mark_meanings(columns: Sequence[ColumnScore]) -> list[str]:
    """Return the meanings of the marks that occur in some columns."""
    found = []
    if not all(map(is_default, columns)):
        found.append("* is not the default definition")
    if open_ones := [c for c in columns if c.indistinguishable]:
        others = (
            f"{' or '.join(map(printable, c.indistinguishable))} of {label(c.key)}"
            for c in open_ones
        )
        found.append(f"~ others fit as well: {', '.join(others)}")
    return found


def notes(column: ColumnScore) -> tuple[str, ...]:
    """Return sign, unit and offset of a column that are not the default ones."""
    r = column.as_understood
    found = []
    if not column.is_known:
        found.append("definition unknown")
    if r.sign != column.as_written.sign:
        found.append(f"sign {r.sign}")
    if r.unit != column.as_written.unit:
        found.append(unit_text(r.unit))
    if r.offset != column.as_written.offset:
        found.append(f"offset {plain(r.offset, 5)}")
    return tuple(found)


def first_above(column: ColumnScore) -> str:
    """First time above the tolerance [s], ``never`` or ``-``."""
    m = column.as_understood.measures
    if m.max_abs_error is None:
        return "-"
    return "never" if m.time_to_tolerance is None else plain(m.time_to_tolerance)


def by_severity(findings: Sequence[Finding]) -> list[Finding]:
    """The conventions, then warnings, otherwise in the order given."""
    return sorted(findings, key=lambda f: (f.code != "conventions", f.severity != Severity.WARNING))


def warnings_words(report: Report) -> str:
    """Return the number of warnings in words; empty without any."""
    count = sum(f.severity == Severity.WARNING for f in report.said)
    return counted(count, "warning") if count else ""


def worst_words(report: Report) -> str:
    """Return the correct digits of the worst column."""
    found = report.worst
    if found is None:
        return PHRASES["nothing"]
    c = report[found.maneuver][found.column]
    where = f"{PHRASES['maneuver']} {found.maneuver} {printable(c.key)}"
    if found.scd >= MOST_DIGITS:
        return "no error in any column"
    if found.scd < 0:
        wrong = f"{readable(c.max_rel_error)} times its scale"
        return f"{PHRASES['no_digit']} ({where}, wrong by {wrong})"
    limit = ", all its digits allow" if c.is_at_floor() else ""
    said = f"{PHRASES['worst']} {found.scd:.1f} {PHRASES['correct_digits']}"
    return f"{said} ({where}{limit})"


def caveats(report: Report) -> list[str]:
    """Return restrictions of the verdict: part covered, columns left out, contradictory signs."""
    signs, covered, left_out = "", "", [x.name for x in report.not_compared]
    least = min(report.maneuvers, key=lambda m: m.coverage, default=None)
    if least is not None and least.coverage < 1:
        parts = {percent(m.coverage) for m in report.maneuvers}
        is_of_all = len(parts) == 1 and len(report.maneuvers) > 1
        which = "each maneuver" if is_of_all else f"maneuver {least.maneuver}"
        covered = f"covers {percent(least.coverage)} of {which}"
    for x in report.seen:
        if isinstance(x, SensesOpposed):
            signs = "roll and steer have opposite senses, see the warning"
        elif isinstance(x, NotCompared):
            left_out += [column.name for column in x.columns]
    # A column without a name, as of an index, is nothing that anybody looks for.
    names = [shortened(name) for name in dict.fromkeys(left_out) if name.strip(" \"'")]
    lost = f"{named(names, _MOST_LEFT_OUT)} not compared" if names else ""
    return [said for said in (covered, lost, signs) if said]


def percent(part: float) -> str:
    """A part of the whole, rounded down: what is not complete does not read as 100 %."""
    return f"{math.floor(1000 * part) / 10:g} %"


def performance_words(m: ManeuverScore) -> str:
    """Eq. (1) of a maneuver and what the benchmark says to it."""
    if m.performance is None:
        return "no energy to judge"
    outcome = _outcome(m)
    return f"{readable(m.performance)} %{f' ({outcome})' if outcome else ''}"


def _outcome(m: ManeuverScore) -> str:
    """Return the benchmark's verdict on eq. (1) of a maneuver; empty if it has no limit."""
    if m.performance_limit is None:
        return ""
    # Eq. (1) may not count, whatever it is.
    if reason := claim(m, m.performance_limit).reason:
        return f"does not count: {DOES_NOT_COUNT[reason]}"
    so_far = " so far" if m.meets_limit and m.coverage < WHOLE else ""
    limit = limit_words(m.performance_limit)
    return f"{'passes' if m.meets_limit else 'FAILS'}{so_far}: less than {limit} is asked for"


def limit_words(limit: float) -> str:
    """What eq. (1) must be less than, as "1e-3 %", with all its digits: "2.5e-3 %"."""
    if limit >= 1:
        return f"{limit:.12g} %"
    # Twelve digits are more than anybody gives; a third is not written with sixteen.
    digits, exponent = f"{limit:.11e}".split("e")
    return f"{digits.rstrip('0').rstrip('.')}e{int(exponent)} %"


def requirement_words(scored: Report | Series) -> str:
    """Return the number of requirements that are met; empty without any."""
    every = [r for report in reports(scored) for r in report.requirements]
    if not every:
        return ""
    failed = sum(not r.met for r in every)
    if len(every) == 1:
        return "the requirement FAILED" if failed else "the requirement is met"
    if not failed:
        return f"all {len(every)} requirements met"
    return f"{failed} of {len(every)} requirements FAILED"


def graded(report: Report) -> str:
    """Return the verdict by true error: the judgement, and the worst column.

    First goes what may be said of a file whose motion is right: signs that contradict each other,
    and a definition that is not known here.
    """
    word, worst = judgement(report), worst_words(report)
    every = [c for _, c in report.places]
    odd = dict.fromkeys(c.key for c in every if c.is_contradicted)
    own = own_definitions(report)
    if odd:
        word += f"{PHRASES['signs_of']}{named(list(odd))}{PHRASES['contradict']}"
    if own:
        what = PHRASES["own_definition" if len(own) == 1 else "own_definitions"]
        word = f"{named(own)}{what}{word}"
    return f"{word}, {worst}" if word else worst


def own_definitions(report: Report) -> list[str]:
    """Columns of definitions that are not known here, where without them the file is better."""
    every = [c for _, c in report.places]
    own = list(dict.fromkeys(c.key for c in every if not c.is_known))
    others = max((c.grade for c in every if c.key not in own), default=Grade.UNKNOWN)
    found = file_grade(report)
    return own if found in (Grade.CLOSE, Grade.WRONG) and others < found else []


def verdict(scored: Report | Series) -> str:
    """One line that says what a file is worth, or a series; see `series_verdict`."""
    if isinstance(scored, Series):
        return series_verdict(scored)
    parts = [graded(scored), *caveats(scored), requirement_words(scored)]
    return f"{printable(scored.file.path)}: {'; '.join(p for p in parts if p)}"


def contents(report: Report) -> str:
    """Return rows, times, digits and format of a file."""
    f = report.file
    digits = f.significant_digits
    written = "unknown digits" if digits is None else f"{digits} digits written"
    times = f"{plain(f.t_start)} to {plain(f.t_end)} s"
    return f"{counted(f.rows, 'row')}, {times}, {written}, {printable(f.format)} file"


def worst_error_words(report: Report) -> str:
    """The largest error of the worst column, its time and its part of the scale."""
    found = report.worst
    if found is None:
        return ""
    c = report[found.maneuver][found.column]
    if not c.max_abs_error:
        return ""
    error = in_unit(readable(c.max_abs_error), c.unit)
    part = c.max_rel_error
    of_scale = f", {readable(100 * part)} % of its largest value" if part else ""
    where = f"{label(c.key)}, maneuver {found.maneuver}"
    return f"{where}: off by {error} at {plain(c.time_of_max)} s{of_scale}"


def performance_remark(report: Report) -> str:
    """Return eq. (1) of the maneuvers that the benchmark judges by it, and what it sees.

    Empty without such a maneuver that has an energy. What it sees is left out where the file is
    right, and where a warning says it.
    """
    said = [
        f"{readable(m.performance)} % in maneuver {m.maneuver}, which {_outcome(m)}"
        for m in report.maneuvers
        if m.performance_limit is not None and m.performance is not None
    ]
    if not said:
        return ""
    found = f"eq. (1), the benchmark's own measure, is {', and '.join(said)}"
    if report.is_right or _has(report.seen, EnergyHidesError):
        return found
    return (
        f"{found}. It sees only whether the file's own energy stays constant; angles, rates and "
        "speed may be wrong all the same"
    )


def _has(seen: Sequence[Evidence], kind: type[Evidence]) -> bool:
    return any(isinstance(x, kind) for x in seen)


def series_verdict(series: Series) -> str:
    """One line that says how a series converges, or which of several programs is the best."""
    name, run = chosen(series)
    if not series.is_one_program:
        best = f"{run_name(series, run)} is the best of {len(series.runs)} programs"
        if _has(series.seen, ManeuversDiffer):
            best += ", which cover different maneuvers"
        parts = [f"{best}: {graded(run.report)}", requirement_words(series)]
        return "; ".join(p for p in parts if p)
    steps = [r.step for r in series.runs if r.step is not None]
    parts = [f"{len(series.runs)} runs of one program"]
    if steps:
        parts[0] += f", steps {plain(max(steps))} to {plain(min(steps))} s"
    elif tolerances := [r.tolerance for r in series.runs if r.tolerance is not None]:
        parts[0] += f", tolerances {plain(max(tolerances))} to {plain(min(tolerances))}"
    parts += [f"the {name} one: {graded(run.report)}", order_words(series)]
    return "; ".join(p for p in [*parts, requirement_words(series)] if p)


def chosen(series: Series) -> tuple[str, Run]:
    """The run that is shown in full, and what makes it so: the finest, or else the best."""
    if series.is_one_program and all(size_text(run) for run in series.runs):
        return "finest", series.runs[-1]

    def digits(run: Run) -> float:
        found = run.report.worst
        return -math.inf if found is None else found.scd

    return "best", max(series.runs, key=digits)


def order_words(series: Series) -> str:
    """Observed orders of the finest pair of runs that has any."""
    for pair in reversed(range(len(series.runs) - 1)):
        orders = [c.orders[pair] for c in series.convergence if pair < len(c.orders)]
        known = [x for x in orders if x is not None]
        if known:
            low, high = f"{min(known):.1f}", f"{max(known):.1f}"
            between = low if low == high else f"{low} to {high}"
            return f"observed order {between}"
    return ""


def size_text(run: Run) -> str:
    """The step [s] of a run, or else its tolerance; empty if neither is known."""
    return plain(run.tolerance if run.step is None else run.step).strip("-")


def size_heading(series: Series) -> str:
    """Return the quantity that `size_text` gives of the runs of a series; empty without any."""
    if any(run.step is not None for run in series.runs):
        return "step [s]"
    return "tolerance" if any(run.tolerance is not None for run in series.runs) else ""


def run_name(series: Series, run: Run) -> str:
    """A short name of a run: the program's, the step or tolerance, or the file's."""
    if series.is_one_program and run.step is not None:
        return f"step {plain(run.step)} s"
    if series.is_one_program and run.tolerance is not None:
        return f"tolerance {plain(run.tolerance)}"
    return printable(run.name or Path(run.report.file.path).name)


def short_name(name: str) -> str:
    """A name that leaves room for numbers: the end of a path tells more than its start."""
    return name if len(name) <= _LONGEST_NAME_SHOWN else f"...{name[3 - _LONGEST_NAME_SHOWN :]}"


def run_words(run: Run) -> str:
    """Name of a run's file, its step and its processor time."""
    path = printable(run.report.file.path)
    parts = [path if run.name in ("", Path(path).name) else f"{printable(run.name)}, {path}"]
    if run.step is not None:
        parts.append(f"step {plain(run.step)} s")
    if run.tolerance is not None:
        parts.append(f"tolerance {plain(run.tolerance)}")
    if run.cpu is not None:
        parts.append(f"{plain(run.cpu, 3)} s of processor time")
    return ", ".join(parts)


def file_grade(report: Report) -> Grade:
    """Grade of a file: that of its worst column."""
    return max(report.grades, default=Grade.UNKNOWN)


def judgement(report: Report) -> str:
    """Return the grade of a file in a word or a few; empty if nothing was compared."""
    found = file_grade(report)
    word = WORDS.get(found, "")
    if not word or found == Grade.WRONG or report.is_whole:
        return word
    if not any(m.part.time.any() for m in report.maneuvers):
        return f"only the start is there, which the benchmark gives: {word}"
    fewest = columns_words(report)
    return f"{word}{PHRASES['in_part']}{f': {fewest}' if fewest else ''}"


def columns_words(report: Report) -> str:
    """Return how many of the eight columns were compared; empty if all were.

    The maneuver with the fewest columns counts.
    """
    least = min(report.maneuvers, key=lambda m: m.column_count, default=None)
    if least is None or least.column_count >= ALL_COLUMNS:
        return ""
    is_everywhere = all(m.column_count == least.column_count for m in report.maneuvers)
    where = "" if is_everywhere else f" in {PHRASES['maneuver']} {least.maneuver}"
    return f"{least.column_count} {PHRASES['of_all']} {ALL_COLUMNS} {PHRASES['columns']}{where}"


def style_of(report: Report) -> str:
    """The grade for style sheets: what is right in part only is not shown as right."""
    found = file_grade(report)
    return (Grade.CLOSE if found == Grade.RIGHT and not report.is_right else found).style


def origin(words: Sequence[str] | None = None) -> list[tuple[str, str]]:
    """When and how a report is made that is made now: names, and what is said of them.

    ``SOURCE_DATE_EPOCH`` gives another time [s since 1970], so that reports can be made again
    byte for byte (https://reproducible-builds.org/specs/source-date-epoch/).

    Parameters
    ----------
    words
        Of the command line, without the program; None where there was no command.
    """
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    is_date = given.isascii() and given.isdigit() and len(given) <= 10
    now = datetime.fromtimestamp(int(given), UTC) if is_date else datetime.now(UTC)
    made = [("made", f"{now:%Y-%m-%d %H:%M} UTC")]
    if words is not None:
        made.append(("command", printable(shlex.join(("heyoka-bike", *words)))))
    return made


def reference_words(bicycle: str, dataset_version: str, sha256: str = "") -> list[tuple[str, str]]:
    """By which version a report is made, and against which numbers."""
    said = f"{printable(bicycle)}, data {printable(dataset_version)}"
    content = f", content sha256 {sha256}" if sha256 else ""
    return [("by", f"heyoka_bike {__version__}"), ("reference", said + content)]
