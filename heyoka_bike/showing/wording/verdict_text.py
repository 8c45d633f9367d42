"""The verdict on a file or a series in one line, and the phrases that it consists of."""

from collections.abc import Sequence

from heyoka_bike.errors import printable, shortened
from heyoka_bike.scoring.evidence.as_read import NotCompared
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import SensesOpposed
from heyoka_bike.scoring.evidence.contradictions import EnergyHidesError
from heyoka_bike.scoring.evidence.several_runs import ManeuversDiffer
from heyoka_bike.scoring.evidence.words import counted, scale_words
from heyoka_bike.scoring.findings import Finding, Severity, maneuvers, named
from heyoka_bike.scoring.grades import MOST_DIGITS, Grade, digits_text
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.scores import ManeuverScore, Place
from heyoka_bike.scoring.verdict import ALL_COLUMNS, MIN_COVERAGE, DoesNotCount, claim
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.grade_text import WORDS, file_grade
from heyoka_bike.showing.wording.number_text import in_unit, limit_words, percent, plain, readable
from heyoka_bike.showing.wording.run_text import chosen, order_words, reports, run_name

_MOST_LEFT_OUT = 4

PHRASES = {
    "nothing": "nothing could be compared",
    "in_part": ", compared only in part",
    "of_all": "of",
    "columns": "columns",
    "worst": "the worst column has",
    "no_digit": "the worst column has no correct digits",
    "correct_digits": "correct digits",
    "maneuver": "maneuver",
    "bad_time": "cannot be judged: a time is not finite",
    "signs_of": ", because the signs of ",
    "contradict": " contradict each other; apart from the signs",
    "own_definition": " has a definition of its own, or the file is ",
    "own_definitions": " have definitions of their own, or the file is ",
}
"""Phrases of the verdict; `workbench.checker.header` copies them and `WORDS` for the C checker."""

DOES_NOT_COUNT = {
    DoesNotCount.NOT_ITS_SUM: "the energy is not the file's own potential plus kinetic energy",
    DoesNotCount.NOT_TRUE: "the energy is not the exact one, and the file's potential and kinetic "
    "energies do not confirm it",
    DoesNotCount.ANOTHER_START: "the energy does not begin with the exact value",
    DoesNotCount.FEW_DIGITS: "the energy is written with too few digits to be judged",
}
"""Reasons why the result of eq. (1) does not count."""


def by_severity(findings: Sequence[Finding]) -> list[Finding]:
    """Sort findings: the conventions first, then warnings, then the others as they were."""
    return sorted(findings, key=lambda f: (f.code != "conventions", f.severity != Severity.WARNING))


def warnings_words(report: Report) -> str:
    """Return the number of warnings in words; empty if there are none."""
    count = sum(f.severity == Severity.WARNING for f in report.said)
    return counted(count, "warning") if count else ""


def worst_place(report: Report) -> Place | None:
    """Return the maneuver and the column with the fewest digits; None if nothing was compared."""
    found = report.worst
    if found is None:
        return None
    m = report[found.maneuver]
    return m, m[found.column]


def worst_words(report: Report) -> str:
    """Return the correct digits of the worst column."""
    found = report.worst
    if found is None:
        return PHRASES["nothing"]
    c = report[found.maneuver][found.column]
    where = f"{printable(c.key)} in {PHRASES['maneuver']} {found.maneuver}"
    if found.scd >= MOST_DIGITS:
        return "no column has an error"
    shown = digits_text(found.scd)
    if float(shown) <= 0.0:
        return f"{PHRASES['no_digit']} ({where}, wrong by {scale_words(c.error)})"
    limit = ", limited by the rounding of the values" if c.is_at_floor() else ""
    return f"{PHRASES['worst']} {shown} {PHRASES['correct_digits']} ({where}{limit})"


def caveats(report: Report) -> list[str]:
    """Return the caveats to the verdict: fraction compared, columns left out, opposite signs."""
    signs, covered, left_out = "", "", _lost_names(report)
    least = min(report.maneuvers, key=lambda m: m.coverage, default=None)
    if least is not None and least.coverage < 1:
        parts = {percent(m.coverage) for m in report.maneuvers}
        is_of_all = len(parts) == 1 and len(report.maneuvers) > 1
        which = "each maneuver" if is_of_all else f"maneuver {least.maneuver}"
        covered = f"the file covers {percent(least.coverage)} of {which}"
    for x in report.seen:
        if isinstance(x, SensesOpposed):
            signs = "roll and steer are positive to opposite sides, see the warning"
        elif isinstance(x, NotCompared):
            left_out += [column.name for column in x.columns]
    # Skip columns without a name, such as an index, because no reader will miss them.
    names = [shortened(name) for name in dict.fromkeys(left_out) if name.strip(" \"'")]
    are = "is" if len(names) == 1 else "are"
    lost = f"{named(names, _MOST_LEFT_OUT)} {are} not compared" if names else ""
    return [said for said in (covered, lost, signs) if said]


def _lost_names(report: Report) -> list[str]:
    """Name the columns that were not compared; columns without a name by quantity and maneuver."""
    every = [m.maneuver for m in report.maneuvers]
    lost = report.not_compared
    places = {x for x in lost if x.maneuver is not None and x.name == f"{x.maneuver}.{x.key}"}
    found = [x.name for x in lost if x not in places]
    for key, numbers in grouped((x.key, x.maneuver) for x in lost if x in places).items():
        is_everywhere = set(numbers) >= set(every)
        found.append(f"{key}" if is_everywhere else f"{key} of {maneuvers(filter(None, numbers))}")
    return found


def performance_words(m: ManeuverScore) -> str:
    """Return eq. (1) of a maneuver, and whether it meets the limit of the benchmark."""
    if m.performance is None:
        return "no energy to judge"
    outcome = _outcome(m)
    return f"{readable(m.performance)} %{f' ({outcome})' if outcome else ''}"


def _outcome(m: ManeuverScore) -> str:
    """Return the benchmark's verdict on eq. (1) of a maneuver; empty if it has no limit."""
    if m.performance_limit is None:
        return ""
    if doubt := _why_not_counted(m, m.performance_limit):
        return f"does not count: {doubt}"
    return f"{_passes(m)}: the limit is {limit_words(m.performance_limit)}"


def _why_not_counted(m: ManeuverScore, limit: float) -> str:
    """Return why the result of eq. (1) does not count, whatever its value is; empty if it does."""
    reason = claim(m, limit).reason
    return DOES_NOT_COUNT[reason] if reason else ""


def _passes(m: ManeuverScore) -> str:
    so_far = " so far" if m.meets_limit and m.coverage < MIN_COVERAGE else ""
    return f"{'passes' if m.meets_limit else 'FAILS'}{so_far}"


def requirement_words(scored: Report | Series) -> str:
    """Return how many requirements are met or failed; empty if there are none."""
    every = [r for report in reports(scored) for r in report.requirements]
    if not every:
        return ""
    failed = sum(not r.met for r in every)
    if len(every) == 1:
        return "the requirement FAILED" if failed else "the requirement is met"
    if not failed:
        return f"{'both' if len(every) == 2 else f'all {len(every)}'} requirements are met"
    return f"{failed} of {len(every)} requirements FAILED"


def graded(report: Report) -> str:
    """Return the grade of a file in words, and the digits of its worst column.

    Remarks that may apply to a file with the right motion come first: contradictory signs, and
    columns of unknown definition.
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
    return f"{word}{',' if odd else ';'} {worst}" if word else worst


def own_definitions(report: Report) -> list[str]:
    """Return the columns of unknown definition, if the grade would be better without them."""
    every = [c for _, c in report.places]
    own = list(dict.fromkeys(c.key for c in every if not c.is_known))
    others = max((c.grade for c in every if c.key not in own), default=Grade.UNKNOWN)
    found = file_grade(report)
    return own if found in (Grade.CLOSE, Grade.WRONG) and others < found else []


def verdict(scored: Report | Series) -> str:
    """Return the verdict on a file or a series in one line; see also `series_verdict`."""
    if isinstance(scored, Series):
        return series_verdict(scored)
    parts = [graded(scored), *caveats(scored), requirement_words(scored)]
    return f"{printable(scored.file.path)}: {'; '.join(p for p in parts if p)}"


def contents(report: Report) -> str:
    """Return row count, times, number of digits and format of a file."""
    f = report.file
    digits = f.significant_digits
    written = "unknown digits" if digits is None else f"{digits} digits written"
    times = f"{plain(f.t_start)} to {plain(f.t_end)} s"
    return f"{counted(f.rows, 'row')}, {times}, {written}, {printable(f.format)} file"


def worst_error_words(report: Report) -> str:
    """Return the largest error of the worst column, its time, and its fraction of the scale."""
    place = worst_place(report)
    if place is None or not place[1].max_abs_error:
        return ""
    m, c = place
    error = in_unit(readable(c.max_abs_error), c.unit)
    of_scale = f", {scale_words(c.error)}" if c.error else ""
    where = f"{label(c.key)} in maneuver {m.maneuver}"
    return f"{where}: off by {error} at {plain(c.time_of_max)} s{of_scale}"


def performance_remark(report: Report) -> str:
    """Return eq. (1) of the maneuvers with a limit, and a remark on what it measures.

    The result is empty if no such maneuver has an energy. The remark is omitted if the file is
    right, or if a warning contains it.
    """
    judged = [
        (m, m.performance_limit)
        for m in report.maneuvers
        if m.performance_limit is not None and m.performance is not None
    ]
    if not judged:
        return ""
    where = maneuvers(m.maneuver for m, _ in judged)
    said = [f"eq. (1), the benchmark's own test, limits how much the energy varies in {where}"]
    for m, limit in judged:
        who = "The file" if len(judged) == 1 else f"Maneuver {m.maneuver}"
        value = f"{readable(m.performance)} %"
        if doubt := _why_not_counted(m, limit):
            said.append(f"{who} has {value}, which does not count: {doubt}")
        else:
            said.append(f"{who} {_passes(m)} with {value} (limit {limit_words(limit)})")
    found = ". ".join(said)
    is_doubted = all(_why_not_counted(m, limit) for m, limit in judged)
    if report.is_right or is_doubted or _has(report.seen, EnergyHidesError):
        return found
    if any(_has_varying_energy(m) for m in report.maneuvers):
        return f"{found}. The energy in the file is not constant"
    return (
        f"{found}. Eq. (1) checks only whether the file's own energy stays constant, not whether "
        "the angles, rates and speed are right"
    )


def _has_varying_energy(m: ManeuverScore) -> bool:
    """True if eq. (1) exceeds its limit, whether or not it counts."""
    limit = m.performance_limit
    return limit is not None and m.performance is not None and m.performance > limit


def _has(seen: Sequence[Evidence], kind: type[Evidence]) -> bool:
    return any(isinstance(x, kind) for x in seen)


def series_verdict(series: Series) -> str:
    """Return the verdict on a series: its convergence, or the best of several programs."""
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


def judgement(report: Report) -> str:
    """Return the grade of a file in a word or a few; empty if nothing was compared."""
    found = file_grade(report)
    word = WORDS.get(found, "")
    if not word or found == Grade.WRONG or report.is_whole:
        return word
    if not any(m.part.time.any() for m in report.maneuvers):
        return f"only the start of the motion, which the benchmark gives, is {word}"
    fewest = columns_words(report)
    return f"{word}{PHRASES['in_part']}{f' ({fewest})' if fewest else ''}"


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
