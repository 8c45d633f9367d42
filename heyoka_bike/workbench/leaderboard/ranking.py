"""Check and score submissions, and rank them by the worst value of their worst column.

Processor times are stated by the submissions, for their own machines; they are shown but do not
affect the rank. A submission is a small TOML file that describes how some result files were made.

    name = "Exudyn, trapezoidal rule, h = 0.001"
    problem = "H1"
    program = "Exudyn"
    version = "1.13.6"
    method = "implicit trapezoidal rule, index 2"
    coordinates = "Euler parameters of each body, constraints of rolling"
    precision = "binary64"
    step = "0.001"
    processor_time = "48.5"
    machine = "AMD EPYC 7763, 1 core, Linux, wheel of PyPI"
    licence = "CC0-1.0"
    contact = "https://github.com/jgerstmayr/EXUDYN"

    [[file]]
    path = "exudyn-h0.001.txt"
    sha256 = "..."

Paths are relative to the file and stay below its folder. The problems are those of
docs/harder-tier.md.
"""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path, PurePosixPath
from re import fullmatch
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import describe_inputs, read_bicycle, read_maneuvers
from heyoka_bike.bicycle.toml_source import TomlSource, kind
from heyoka_bike.errors import BicycleError, InputError, quoted
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.diagnosis.budget import USUAL
from heyoka_bike.scoring.diagnosis.diagnose import diagnosed_elsewhere
from heyoka_bike.scoring.evidence.as_compared import RowsOutside
from heyoka_bike.scoring.findings import named
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.verdict import is_own_energy
from heyoka_bike.system.files import open_regular, path_inside
from heyoka_bike.system.parallel import side_by_side
from heyoka_bike.system.resources import find_input

_REQUIRED_ENTRIES = (
    "name", "problem", "program", "version", "method", "coordinates", "precision",
    "processor_time", "machine", "licence", "contact",
)  # fmt: skip
_OPTIONAL_ENTRIES = ("step", "tolerance", "model", "wall_time", "steps", "calls")
_FILE = ("path", "sha256", "maneuver")
_LONGEST_ENTRY = 500


@dataclass(frozen=True, slots=True)
class RankedProblem:
    """A problem of the leaderboard.

    Attributes
    ----------
    inputs
        Names of the bicycle and the maneuvers in ``data`` from which the dataset is made.
    maneuver
        Number of the single maneuver of the dataset in the problem; None for all of them.
    """

    inputs: tuple[str, str]
    maneuver: int | None = None

    def numbers(self, count: int) -> tuple[int, ...]:
        """Return the numbers of the problem's maneuvers; its dataset contains `count` maneuvers."""
        return tuple(range(1, count + 1)) if self.maneuver is None else (self.maneuver,)


_EDGE_INPUTS = ("benchmark", "harder/edge-of-falling")

PROBLEMS: Mapping[str, RankedProblem] = {
    "H1": RankedProblem(("benchmark", "benchmark")),
    "H2": RankedProblem(("benchmark", "harder/longer")),
    **{f"H3{x}": RankedProblem(_EDGE_INPUTS, n) for n, x in enumerate("abcdefg", start=1)},
    "H4": RankedProblem(("browser-jason", "harder/another-bicycle")),
}
"""Problems of docs/harder-tier.md by name; in H3 each maneuver is a separate problem."""


@dataclass(frozen=True, slots=True)
class SubmittedFile:
    """A result file of a submission.

    Attributes
    ----------
    path : Path
    sha256
    maneuver
        Number of the file's only maneuver; None if the file or its values show the maneuvers.
    """

    path: Path
    sha256: str
    maneuver: int | None


@dataclass(frozen=True, slots=True)
class Submission:
    """A submission: the entries of its TOML file, and its result files.

    Attributes
    ----------
    source : Path
        File of the submission.
    problem
        A key of `PROBLEMS`.
    said : mapping of str to str
        Every entry as text.
    processor_time
        Processor time for all maneuvers of the problem [s].
    files : tuple of SubmittedFile
    """

    source: Path
    problem: str
    said: Mapping[str, str]
    processor_time: float
    files: tuple[SubmittedFile, ...]

    @property
    def name(self) -> str:
        """The entry ``name`` of the submission."""
        return self.said["name"]


def read_submission(path: str | Path) -> Submission:
    """Read the TOML file of a submission.

    Raises
    ------
    InputError
        Unreadable, or an entry is missing, unknown or not as it should be. The error names the file
        and the key.
    """
    source = TomlSource.load(path)
    tree = source.tree
    source.refuse_unknown(
        tree, {*_REQUIRED_ENTRIES, *_OPTIONAL_ENTRIES, "file"}, (), _REQUIRED_ENTRIES
    )
    said = {
        key: source.line_of_text(tree, key, (), limit=_LONGEST_ENTRY)
        for key in tree
        if key != "file"
    }
    if said["problem"] not in PROBLEMS:
        raise source.error(
            f"found {quoted(said['problem'])}, expected one of {', '.join(PROBLEMS)}",
            ("problem",),
        )
    if ("step" in said) == ("tolerance" in said):
        found = "both" if "step" in said else "neither"
        raise source.error(f"found {found} of step and tolerance, expected one of them")
    times = {
        key: source.positive(said, key, ())
        for key in ("processor_time", "wall_time", "step", "tolerance")
        if key in said
    }
    files = tuple(
        _read_file(source, table, i, Path(path).parent)
        for i, table in enumerate(source.tables("file"))
    )
    return Submission(Path(path), said["problem"], said, times["processor_time"], files)


def _read_file(
    source: TomlSource, table: dict[str, Any], index: int, folder: Path
) -> SubmittedFile:
    where = ("file", index)
    source.refuse_unknown(table, _FILE, where, ("path", "sha256"))
    path = PurePosixPath(source.line_of_text(table, "path", where))
    if path.is_absolute() or ".." in path.parts or "\\" in str(path):
        raise source.error(
            f"found {quoted(str(path))}, expected a path below the folder of this file",
            (*where, "path"),
        )
    sha256 = source.line_of_text(table, "sha256", where)
    if not fullmatch("[0-9a-f]{64}", sha256):
        raise source.error(
            f"found {quoted(sha256)}, expected 64 hexadecimal digits, as sha256sum prints them",
            (*where, "sha256"),
        )
    number = table.get("maneuver")
    if number is not None and (type(number) is not int or number < 1):
        found = str(number) if type(number) is int else kind(number)
        raise source.error(f"found {found}, expected a number from 1", (*where, "maneuver"))
    return SubmittedFile(folder / path, sha256, number)


GRADES = (12, 9, 6, 3)
"""Numbers of correct digits for which a problem counts as solved, see docs/harder-tier.md."""

_SCORING = 0.05  # fraction of the progress bar for scoring, if entries are diagnosed

References = Mapping[tuple[str, str], Reference]
"""Datasets by the names of their bicycle and maneuvers."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A submission and its score.

    Attributes
    ----------
    submission : Submission
    digits
        Correct digits of the worst value of the worst column of all maneuvers (scd).
    worst : tuple of (int, str)
        Maneuver and column of the worst value.
    grade
        The highest of `GRADES` that the submission reaches; None if it reaches none.
    performance
        Eq. (1) [%] of the maneuver that the benchmark judges by it, or else the largest.
    definitions : mapping of str to str
        Definitions of the columns that do not follow the default one.
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
    """The ranked submissions in a folder, and the rejected ones.

    Attributes
    ----------
    entries : mapping of str to tuple of Entry
        Entries by problem, the best first; entries with equal digits are sorted by name.
    refused : tuple of str
        A line for each submission that breaks a rule.
    dataset_version
        Version of the published reference.
    """

    entries: Mapping[str, tuple[Entry, ...]]
    refused: tuple[str, ...]
    dataset_version: str


def leaderboard(
    folder: str | Path,
    references: Sequence[Reference],
    progress: Callable[[float], None] = lambda _: None,
    *,
    is_diagnosed: bool = False,
) -> Leaderboard:
    """Score every submission ``*.toml`` of a folder.

    Parameters
    ----------
    folder
    references
        Datasets of the problems; the published one, for H1, is the first.
    progress
        Called with the completed fraction of the work, 0 to 1.
    is_diagnosed
        True to diagnose each submission, which takes most of the time.

    Raises
    ------
    InputError
        The folder does not exist or contains no submission, or a reference belongs to no problem.
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
        progress(i / len(files) * (_SCORING if is_diagnosed else 1.0))
    if is_diagnosed:
        inputs = [(e.report, known[PROBLEMS[e.submission.problem].inputs], USUAL) for e in entries]
        share = 1.0 - _SCORING
        reports = side_by_side(
            diagnosed_elsewhere, inputs, done=lambda n: progress(_SCORING + share * n / len(inputs))
        )
        entries = [replace(e, report=r) for e, r in zip(entries, reports, strict=True)]
    entries.sort(key=lambda e: (-e.digits, e.submission.name))
    by_problem = {p: tuple(e for e in entries if e.submission.problem == p) for p in PROBLEMS}
    held = {problem: found for problem, found in by_problem.items() if found}
    return Leaderboard(held, tuple(refused), references[0].dataset_version)


def _refuse(found: str, expected: str, file: str | Path | None) -> InputError:
    return InputError(f"found {found}, expected {expected}", file=file)


def _by_inputs(references: Sequence[Reference]) -> References:
    """Return the datasets by the names of their inputs; inputs are compared as text."""
    asked = {names: _inputs(*names) for names in {p.inputs for p in PROBLEMS.values()}}
    found = {}
    for reference in references:
        made_of = reference.parameters, [dict(reference[n].inputs) for n in reference]
        names = next((names for names, inputs in asked.items() if inputs == made_of), None)
        if names is None:
            what = "the dataset of a problem in docs/harder-tier.md"
            raise _refuse("a dataset with other inputs", what, reference.folder)
        found[names] = reference
    return found


def _inputs(bicycle: str, maneuvers: str) -> tuple[dict[str, str], list[dict[str, str]]]:
    """Return the parameters of a bicycle and the inputs of each of its maneuvers, as texts."""
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
        what = f"problem {submission.problem} without its dataset"
        how = "--reference DIR; docs/harder-tier.md shows the command that generates the dataset"
        raise _refuse(what, how, submission.source)
    results = []
    for file in submission.files:
        try:
            path = path_inside(submission.source.parent, file.path.absolute())
            with open_regular(path) as opened:
                sha256 = hashlib.file_digest(opened, "sha256").hexdigest()
        except (OSError, ValueError) as e:
            reason = getattr(e, "strerror", None) or e
            raise InputError(f"cannot be read: {reason}", file=file.path) from None
        if sha256 != file.sha256:
            said = f"{file.sha256[:16]}... as in {submission.source.name}"
            raise _refuse(f"sha256 {sha256[:16]}...", said, file.path)
        read = read_results(file.path, maneuver=file.maneuver, count=len(reference))
        held = [rows.maneuver for rows in read.maneuvers]
        if file.maneuver is not None and held != [file.maneuver]:
            found = f"maneuver {', '.join(map(str, held))}"
            raise _refuse(found, f"only maneuver {file.maneuver}", file.path)
        results.append(read)
    report = score(results, reference)
    _check_rules(submission, report, reference)
    scores = correct_digits(report)
    worst = min(scores, key=scores.__getitem__)
    judged = [m for m in report.maneuvers if m.performance_limit is not None] or report.maneuvers
    drifts = [m.performance for m in judged if m.performance is not None and is_own_energy(m)]
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
    """Return the scd by maneuver and column of the benchmark, limited by the digits written."""
    return {
        (m.maneuver, c.key): c.shown("scd") or 0.0
        for m in report.maneuvers
        for c in m.columns
        if c.key in BENCHMARK_COLUMNS
    }


def other_definitions(report: Report) -> dict[str, str]:
    """Return the definitions of the columns that do not follow the default definition."""
    columns = (c for m in report.maneuvers for c in m.columns)
    return {c.key: c.definition for c in columns if c.definition != c.as_written.definition}


def _check_rules(submission: Submission, report: Report, reference: Reference) -> None:
    """Check that all maneuvers, all their rows at their times, and all columns are present."""
    numbers = PROBLEMS[submission.problem].numbers(len(reference))
    refuse = partial(_refuse, file=submission.source)
    held = sorted(m.maneuver for m in report.maneuvers)
    if held != list(numbers):
        raise refuse(
            f"maneuver {', '.join(map(str, held))} in its files",
            f"maneuver {', '.join(map(str, numbers))} for problem {submission.problem}",
        )
    if odd := sorted({c.key for m in report.maneuvers for c in m.columns if c.is_contradicted}):
        raise refuse(f"{named(odd)} with contradictory signs", "signs of one choice of axes")
    if lost := named([x.name for x in report.not_compared]):
        raise refuse(f"{lost}, which cannot be compared", "columns that were computed, each once")
    if outside := sum(x.rows for x in report.seen if isinstance(x, RowsOutside)):
        raise refuse(
            f"{outside} row{'' if outside == 1 else 's'} outside the run",
            "the rows of the reference, each once",
        )
    for m in report.maneuvers:
        asked, part = reference[m.maneuver], m.part
        if len(part.time) != len(asked.time):
            raise refuse(
                f"{len(part.time)} rows of maneuver {m.maneuver}", f"{len(asked.time)} rows"
            )
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
