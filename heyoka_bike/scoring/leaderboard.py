"""Submissions checked, scored and ranked: by the worst value of the worst column, nothing else.

Processor times are those that the submissions state, of their own machines: they are shown, and
rank nothing.
"""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import describe_inputs, read_bicycle, read_maneuvers
from heyoka_bike.errors import BicycleError, InputError
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.findings import named
from heyoka_bike.scoring.reading import read_results
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.submission import PROBLEMS, Submission, read_submission
from heyoka_bike.system import jobs
from heyoka_bike.system.parallel import side_by_side
from heyoka_bike.system.resources import find_input

GRADES = (12, 9, 6, 3)
"""Correct digits for which a problem is solved, docs/harder-tier.md."""

_SCORING = 0.05  # of the time, where entries are finished

References = Mapping[tuple[str, str], Reference]
"""Sets by the names of their bicycle and maneuvers."""

Finish = Callable[[Report, Reference, jobs.Report], Report]
"""A job that makes more of a report."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A submission and what it reaches.

    Attributes
    ----------
    submission : Submission
    digits
        Correct digits of the worst value of the worst column of all maneuvers, its scd.
    worst : tuple of (int, str)
        The maneuver and column of it.
    grade
        The highest of `GRADES` that it reaches; None if there is none.
    performance
        Eq. (1) [%], of the maneuver that the benchmark judges by it; where there is none, the
        largest.
    definitions : mapping of str to str
        By which definition a column is taken, where that is not the default.
    report : Report
    """

    submission: Submission
    digits: float
    worst: tuple[int, str]
    grade: int | None
    performance: float | None
    definitions: Mapping[str, str]
    report: Report


@dataclass(frozen=True, slots=True)
class Leaderboard:
    """All submissions of a folder.

    Attributes
    ----------
    entries : mapping of str to tuple of Entry
        By problem, the best first; of equal digits by name.
    refused : tuple of str
        A line for each submission that breaks a rule.
    dataset_version
        Of the published reference.
    """

    entries: Mapping[str, tuple[Entry, ...]]
    refused: tuple[str, ...]
    dataset_version: str


def leaderboard(
    folder: str | Path,
    references: Sequence[Reference],
    progress: Callable[[float], None] = lambda _: None,
    finish: Finish | None = None,
) -> Leaderboard:
    """Score every submission ``*.toml`` of a folder.

    Parameters
    ----------
    folder
    references
        Sets of the problems; the published one, of H1, is the first.
    progress
        Called with the part of the work that is done, 0 to 1.
    finish
        Gives the report that is kept of an entry, and takes most of the time: a job, such as
        `diagnosis.diagnose.diagnosed_elsewhere`.

    Raises
    ------
    InputError
        No folder, no submission in it, or a reference that is of no problem.
    """
    files = sorted(Path(folder).glob("*.toml"))
    if not files:
        what = "no folder" if not Path(folder).is_dir() else "no submission (*.toml)"
        raise _refuse(what, "a folder of submissions", folder)
    known = _by_inputs(references)
    entries, refused = [], []
    for i, file in enumerate(files, start=1):
        try:
            entries.append(_entry(read_submission(file), known))
        except BicycleError as e:
            refused.append(str(e))
        progress(i / len(files) * (_SCORING if finish else 1.0))
    if finish:
        entries = _finished(entries, known, finish, progress)
    entries.sort(key=lambda e: (-e.digits, e.submission.name))
    by_problem = {p: tuple(e for e in entries if e.submission.problem == p) for p in PROBLEMS}
    held = {problem: found for problem, found in by_problem.items() if found}
    return Leaderboard(held, tuple(refused), references[0].dataset_version)


def _finished(
    entries: Sequence[Entry], known: References, finish: Finish, progress: Callable[[float], None]
) -> list[Entry]:
    def done(count: int) -> None:
        progress(_SCORING + (1.0 - _SCORING) * count / len(entries))

    asked = [(e.report, known[PROBLEMS[e.submission.problem].inputs]) for e in entries]
    reports = side_by_side(finish, asked, done=done)
    return [replace(e, report=report) for e, report in zip(entries, reports, strict=True)]


def _refuse(found: str, expected: str, file: str | Path | None) -> InputError:
    return InputError(f"found {found}, expected {expected}", file=file)


def _by_inputs(references: Sequence[Reference]) -> References:
    """The sets by the inputs that they were made of, which are compared as they are."""
    asked = {names: _inputs(*names) for names in {p.inputs for p in PROBLEMS.values()}}
    found = {}
    for reference in references:
        made_of = reference.parameters, [dict(reference[n].inputs) for n in reference]
        names = next((names for names, inputs in asked.items() if inputs == made_of), None)
        if names is None:
            what = "that of a problem: see docs/harder-tier.md"
            raise _refuse("a reference of other inputs", what, reference.folder)
        found[names] = reference
    return found


def _inputs(bicycle: str, maneuvers: str) -> tuple[dict[str, str], list[dict[str, str]]]:
    """Parameters, and what each maneuver is given."""
    said = describe_inputs(
        read_bicycle(find_input("bicycles", bicycle)),
        read_maneuvers(find_input("maneuvers", maneuvers)),
    )
    given = [{key: x for key, x in m.items() if key != "name"} for m in said["maneuvers"]]
    return said["bicycle"]["parameters"], given


def _entry(submission: Submission, known: References) -> Entry:
    problem = PROBLEMS[submission.problem]
    reference = known.get(problem.inputs)
    if reference is None:
        what = f"problem {submission.problem}, whose reference is not here"
        how = "--reference with its folder: docs/harder-tier.md has the line that makes it"
        raise _refuse(what, how, submission.source)
    results = []
    for file in submission.files:
        try:
            sha256 = hashlib.sha256(file.path.read_bytes()).hexdigest()
        except OSError as e:
            raise InputError(f"cannot be read: {e.strerror}", file=file.path) from None
        if sha256 != file.sha256:
            said = f"{file.sha256[:16]}... of {submission.source.name}"
            raise _refuse(f"sha256 {sha256[:16]}...", said, file.path)
        read = read_results(file.path, maneuver=file.maneuver, count=len(reference))
        held = [rows.maneuver for rows in read.maneuvers]
        if file.maneuver is not None and held != [file.maneuver]:
            found = f"maneuver {', '.join(map(str, held))}"
            raise _refuse(found, f"{file.maneuver} alone", file.path)
        results.append(read)
    report = score(results, reference)
    _check_rules(submission, report, reference)
    scores = correct_digits(report)
    worst = min(scores, key=scores.__getitem__)
    judged = [m for m in report.maneuvers if m.performance_limit is not None] or report.maneuvers
    drifts = [m.performance for m in judged if m.performance is not None and m.is_own_energy]
    return Entry(
        submission=submission,
        digits=scores[worst],
        worst=worst,
        grade=next((g for g in GRADES if scores[worst] >= g), None),
        performance=max(drifts, default=None),
        definitions=other_definitions(report),
        report=report,
    )


def correct_digits(report: Report) -> dict[tuple[int, str], float]:
    """The scd of each maneuver and column of the benchmark, as far as the digits show it."""
    return {
        (m.maneuver, c.key): c.shown("scd") or 0.0
        for m in report.maneuvers
        for c in m.columns
        if c.key in BENCHMARK_COLUMNS
    }


def other_definitions(report: Report) -> dict[str, str]:
    """By which definition each column is taken, where that is not the default."""
    columns = (c for m in report.maneuvers for c in m.columns)
    return {c.key: c.definition for c in columns if c.definition != c.as_written.definition}


def _check_rules(submission: Submission, report: Report, reference: Reference) -> None:
    """All maneuvers of the problem, all their rows at their times, all columns."""
    numbers = PROBLEMS[submission.problem].numbers
    refuse = partial(_refuse, file=submission.source)
    held = sorted(m.maneuver for m in report.maneuvers)
    if held != list(numbers):
        raise refuse(
            f"maneuver {', '.join(map(str, held))} in its files",
            f"{', '.join(map(str, numbers))} for problem {submission.problem}",
        )
    if odd := sorted({c.key for m in report.maneuvers for c in m.columns if c.is_contradicted}):
        raise refuse(f"{named(odd)} of signs that contradict each other", "those of some axes")
    if lost := named(list(report.not_compared)):
        raise refuse(f"{lost} beside what is compared", "columns that were computed, each once")
    for m in report.maneuvers:
        asked, part = reference[m.maneuver], m.part
        if len(part.time) != len(asked.time):
            raise refuse(f"{len(part.time)} rows of maneuver {m.maneuver}", f"{len(asked.time)}")
        if not np.array_equal(part.time, asked.time):
            row = int(np.argmin(part.time == asked.time))
            raise refuse(
                f"row {row} of maneuver {m.maneuver} at {part.time[row]:.17g} s",
                f"{asked.time[row]:.17g} s",
            )
        here = {c.key: c for c in m.columns}
        for key in BENCHMARK_COLUMNS:
            if key not in here or here[key].missing:
                what = "no" if key not in here else f"{here[key].missing} rows without"
                raise refuse(f"{what} {key} in maneuver {m.maneuver}", "a number in every row")
