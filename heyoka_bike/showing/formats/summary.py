"""A report of at most ten lines for a terminal, and a diagnosis as text.

The lines show how good the results are, and what to do next.
"""

import json
import math
import shlex
import textwrap
from collections.abc import Iterator, Sequence

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DERIVATIVES
from heyoka_bike.errors import printable
from heyoka_bike.scoring.evidence.as_compared import ConstantColumns, ManeuverNamedOtherwise
from heyoka_bike.scoring.evidence.column_meaning import (
    Conventions,
    DefinitionUnknown,
    SensesOpposed,
    SignContradiction,
    WholeTurns,
    default_conventions,
)
from heyoka_bike.scoring.evidence.contradictions import StoppedEarly
from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.findings import Severity, named
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.reading.source import ARRAY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.verdict import MIN_COVERAGE
from heyoka_bike.showing.document import Paragraph, text
from heyoka_bike.showing.formats.report_document import conventions
from heyoka_bike.showing.wording import number_text, run_text, verdict_text
from heyoka_bike.showing.wording.finding_text import findings
from heyoka_bike.showing.wording.grade_text import file_grade

_MOST_RUNS_SHOWN = 4  # maximum number of runs of a series that are listed, one per line
_LETTERS_OF_NAMES = 14  # width of the names at the start of lines [characters]
# Largest number of correct digits that is suggested as a requirement. A correct program in binary64
# easily reaches this number.
_MOST_REQUIRED = 12
_WIDTH_OF_DIAGNOSIS = 96  # width of a diagnosis [characters]
_MOST_LINES = 12  # maximum number of lines, not counting empty ones, if no cause is named
_NAMES_A_CAUSE = ("mistake", "parameters", "linearised")


_Entry = tuple[str, str, int]
"""Name, text, and maximum number of lines."""


def render(
    scored: Report | Series, width: int | None, has_colors: bool, *, in_python: bool = False
) -> str:
    """Render a summary of at most ten lines; long texts are cut (the table shows them in full).

    Parameters
    ----------
    width, has_colors
        See `document.text.render`.
    in_python
        True to suggest the next step for Python, not for the command line.
    """
    page = text.TextPage(width, has_colors)
    if isinstance(scored, Report):
        page.brief("", _verdict(scored), 2, f"verdict {file_grade(scored).style}")
        entries = [*_report(scored), ("next", _next(scored, in_python), 1)]
    else:
        page.brief("", verdict_text.series_verdict(scored), 2, "verdict")
        entries = [*_series(scored), ("next", _next_of_series(scored, in_python), 1)]
    for name, said, lines in entries:
        if said:
            page.brief(f"  {name:<{_LETTERS_OF_NAMES - 2}}", said, lines)
    return page.text()


def closing(
    scored: Report | Series, width: int | None, has_colors: bool, written: Sequence[str] = ()
) -> str:
    """Return the lines after a report without details: the next step, and the files written."""
    step = _next(scored, False) if isinstance(scored, Report) else _next_of_series(scored, False)
    pages = "" if written else "; -o report.html writes a report with charts"
    more = f"options: --details adds the errors of each maneuver{pages}"
    blocks = [Paragraph(f"next: {step}"), Paragraph(more, "facts")]
    if written:
        blocks.append(Paragraph(f"written: {', '.join(map(printable, written))}", "facts"))
    return "\n" + text.render(blocks, width, has_colors)


def diagnosis(report: Report, *, has_details: bool = False) -> str:
    """Return the verdict, the conventions, and the causes of the differences, likeliest first.

    If the diagnosis names no cause, remarks beyond twelve lines appear only with `has_details`.
    """
    # The diagnosis does not contain the findings of these classes, so list them before the
    # diagnosis.
    odd_signs = (SignContradiction, SensesOpposed)
    contradicted = [
        f.evidence["columns"] for f in report.diagnosis if f.code == SignContradiction.code
    ]
    beside = [
        x
        for x in report.seen
        if isinstance(
            x, (ManeuverNamedOtherwise, DefinitionUnknown, ConstantColumns, WholeTurns, *odd_signs)
        )
        and not (isinstance(x, SignContradiction) and [*x.keys] in contradicted)
    ]
    own = [x for x in report.seen if isinstance(x, Conventions)]
    is_usual = not own and not any(isinstance(x, odd_signs) for x in report.seen)
    is_usual &= not any(f.code == "units_beside" for f in report.diagnosis)
    usual = [default_conventions(report.by_column())] if is_usual else []
    paragraphs = [verdict_text.verdict(report), *usual]
    paragraphs += [f.message for f in findings([*own, *beside])]
    head = "\n\n".join(map(_filled, paragraphs)) + "\n"
    causes = [f for f in report.diagnosis if f.message not in paragraphs]
    if has_details or any(f.code in _NAMES_A_CAUSE for f in causes):
        return "\n".join([head, "\n\n".join(_filled(f.message) for f in causes)])
    # Always show that a search ended early, because this makes the other findings less certain.
    stops = [_filled(f.message) for f in causes if f.code == StoppedEarly.code]
    is_first = any(isinstance(x, StoppedEarly) and not x.has_cause for x in report.seen)
    told = [f for f in causes if f.code != StoppedEarly.code]
    # If `term_unexplained` is shown, `no_mistake_found` would only repeat that no known cause
    # explains the error.
    is_said = any(f.code == "term_unexplained" for f in told)
    shown: list[str] = []
    room = _MOST_LINES - _lines("\n".join([head, *stops]))
    for f in told:
        said = _filled(f.message)
        lines = _lines(said)
        if not shown or (lines <= room and not (is_said and f.code == "no_mistake_found")):
            shown.append(said)
            room -= lines
    left = len(told) - len(shown)
    more = [f"--details shows {counted(left, 'more finding')}"] if left else []
    below = [*stops, *shown, *more] if is_first else [*shown, *more, *stops]
    return "\n".join([head, "\n\n".join(below)])


def _lines(said: str) -> int:
    """Count the lines of a text that are not empty."""
    return sum(bool(line) for line in said.split("\n"))


def _filled(paragraph: str) -> str:
    return textwrap.fill(paragraph, _WIDTH_OF_DIAGNOSIS, break_long_words=False)


def _report(report: Report) -> Iterator[_Entry]:
    digits = (
        f"maneuver {m.maneuver}: {number_text.correct_digits(m.worst and m.worst.scd)}"
        for m in report.maneuvers
    )
    judged = "; ".join(
        f"maneuver {m.maneuver}: {verdict_text.performance_words(m)}"
        for m in report.maneuvers
        if m.performance_limit is not None
    )
    yield "digits", ", ".join(digits), 1
    yield "worst", verdict_text.worst_error_words(report), 1
    yield "conventions", conventions(report), 2
    yield "eq. (1)", f"{judged}; checks only the energy" if judged else "", 1
    yield "required", _unmet(report), 1
    yield "warnings", _warnings(report), 1


def _series(series: Series) -> Iterator[_Entry]:
    shown = (
        series.runs if len(series.runs) <= _MOST_RUNS_SHOWN else series.runs[: _MOST_RUNS_SHOWN - 1]
    )
    names = [run_text.run_name(series, run) for run in shown]
    wide = max(map(len, names))
    for name, run in zip(names, shown, strict=True):
        yield "", f"{name:<{wide}}  {verdict_text.graded(run.report)}", 1
    if len(shown) < len(series.runs):
        yield "", f"and {len(series.runs) - len(shown)} more", 1
    yield "required", verdict_text.requirement_words(series), 1
    found = verdict_text.by_severity(series.findings)
    yield "found", number_text.sentence(found[0].message) if found else "", 2


def _verdict(report: Report) -> str:
    """Return the verdict, except for the requirements, which have their own line."""
    said = "; ".join([verdict_text.graded(report), *verdict_text.caveats(report)])
    return f"{printable(report.file.path)}: {said}"


def _unmet(report: Report) -> str:
    first = next((r for r in report.requirements if not r.met), None)
    said = verdict_text.requirement_words(report)
    return (
        f"{said}: {printable(first.text)}, found {number_text.sentence(first.message)}"
        if first
        else said
    )


def _warnings(report: Report) -> str:
    first = next((f for f in report.said if f.severity == Severity.WARNING), None)
    return (
        f"{verdict_text.warnings_words(report)}: {number_text.sentence(first.message)}"
        if first
        else ""
    )


def _next(report: Report, in_python: bool) -> str:
    """Return a sentence that tells the user what to do next, according to a report."""
    if report.diagnosis:
        return number_text.sentence(report.diagnosis[0].message)
    found = file_grade(report)
    if found == Grade.UNKNOWN:
        return "check the headings and the times of the file: nothing in it could be compared"
    if own := verdict_text.own_definitions(report):
        meant = "which point or axis" if len(own) == 1 else "which points or axes"
        command = _call(report) if in_python else _command("diagnose", report)
        refers = "refers" if len(own) == 1 else "refer"
        usual = "it is the usual one" if len(own) == 1 else "they are the usual ones"
        return f"check {meant} {named(own)} {refers} to; if {usual}, run {command}"
    if found in (Grade.WRONG, Grade.CLOSE):
        said = _call(report) if in_python else _command("diagnose", report)
        is_step = found == Grade.CLOSE and _may_be_the_step(report)
        more = ", or try a smaller step" if is_step else ""
        return f"run {said} to find the cause{more}"
    if report.not_compared:
        return "name each column by its quantity, and leave out columns that are not computed"
    if missing := _missing(report):
        return f"write the missing columns too: {named(missing)}"
    covered = min(m.coverage for m in report.maneuvers)
    if covered < MIN_COVERAGE:
        return "write rows over the whole run, dense enough to resolve the motion"
    if not report.is_whole:
        return "check why some values are not finite: each column needs a number in every row"
    if found == Grade.UNTOLD:
        return "write the values unrounded, with 17 digits, to show the accuracy of the program"
    shown = (c.shown("scd") for m in report.maneuvers for c in m.columns)
    digits = math.floor(min(filter(None, shown), default=6.0))
    least = [f"scd >= {min(digits, _MOST_REQUIRED)}",
             f"coverage >= {math.floor(1000 * covered) / 1000:g}"]  # fmt: skip
    if in_python:
        return f"to test this, add to this call: require={json.dumps(least)}"
    options = " ".join(f"--require {shlex.quote(x)}" for x in least)
    return f"to test this, add to this command: {options}"


def _may_be_the_step(report: Report) -> bool:
    """True if an angle is not right and neither is its rate, as after too large steps.

    A wrong energy, or an angle beside a right rate, does not come from the step.
    """
    for m in report.maneuvers:
        grades = {c.key: c.grade for c in m.compared}
        for (rate, _), (angle, _) in DERIVATIVES.items():
            found = [grades[key] for key in (angle, rate) if key in grades]
            if found and all(g in (Grade.WRONG, Grade.CLOSE) for g in found):
                return True
    return False


def _missing(report: Report) -> list[str]:
    """Return the keys of those of the benchmark's columns that are missing in some maneuver."""
    held = [{c.key for c in m.compared} for m in report.maneuvers]
    return [key for key in BENCHMARK_COLUMNS if any(key not in keys for keys in held)]


def _next_of_series(series: Series, in_python: bool) -> str:
    if in_python:
        if series.is_one_program:
            return "series[-1] is the report of the finest run"
        return 'save("report.html") writes the whole report with charts'
    name, run = run_text.chosen(series)
    of = "run" if series.is_one_program else "program"
    return f"run {_command('score', run.report)} for the report of the {name} {of}"


def _call(report: Report) -> str:
    """Return the Python call that diagnoses the file (results in memory have no file name)."""
    is_file = report.file.format != ARRAY and ", " not in report.file.path
    return f"diagnose({report.file.path!r})" if is_file else "diagnose(...) with the same results"


def _command(name: str, report: Report) -> str:
    files = report.file.path.split(", ")
    return printable(shlex.join(["heyoka-bike", name, *files]))
