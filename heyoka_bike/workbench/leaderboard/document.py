"""The leaderboard as a document, for text and pages, and as JSON."""

import json
from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from typing import Any

from heyoka_bike.showing import document as doc
from heyoka_bike.showing.charts.chart import Guide, Mark, chart, linear, spread, wide
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.finding_text import cause
from heyoka_bike.showing.wording.number_text import number, readable
from heyoka_bike.showing.wording.origin_text import reference_words
from heyoka_bike.version import __version__
from heyoka_bike.workbench.leaderboard.ranking import Entry, Leaderboard

SCHEMA_VERSION = 1

_ABOUT_RANKING = (
    "Digits: correct digits of the worst value of the worst column, -log10 of its error relative "
    "to the column's largest value; the worst column is named with its maneuver. Grade: the "
    "highest of 3, 6, 9 and 12 digits that is reached. Eq. (1), the benchmark's own measure, shows "
    "only whether a program's own energy stays constant. Times are stated by the submissions, for "
    "their own machines; they do not affect the rank."
)
_COLUMNS_OF_RANKING = (
    doc.Words("place", ""), doc.TableColumn("submission", is_prose=True), "digits", "grade",
    doc.TableColumn("worst column", is_prose=True), "eq. (1)\n[%]", "CPU\n[s]",
)  # fmt: skip
# Fields of a submission in the order in which the page shows them.
_SAID_OF_ENTRIES = ("program", "version", "method", "step", "tolerance", "coordinates", "precision",
         "steps", "calls", "machine", "wall_time", "model", "licence", "contact")  # fmt: skip
_FIGURE_HEIGHT = 420
# Lowest number of correct digits that the chart shows. It corresponds to an error of ten times the
# largest value. Larger errors all have the same meaning: the result is wrong.
_LOWEST_DIGITS_DRAWN = -1.0


def document(board: Leaderboard, made: Sequence[tuple[str, str]]) -> doc.Document:
    """Return the leaderboard: the ranked submissions to each problem.

    For `made` see `origin_text`.
    """
    count = sum(map(len, board.entries.values()))
    problems = (
        doc.Chapter(
            problem,
            (_table(entries), doc.Chart(partial(_picture, problem, entries)), _diagnoses(entries)),
            problem,
        )
        for problem, entries in board.entries.items()
    )
    refused = doc.Listing(tuple(map(doc.Item, board.refused)))
    return doc.Document(
        "Leaderboard – uncontrolled bicycle",
        f"{count} submission{'s' * (count != 1)}, by true error",
        "Uncontrolled bicycle: leaderboard",
        (
            doc.Paragraph(_ABOUT_RANKING, only=doc.HTML),
            *problems,
            doc.Paragraph(_ABOUT_RANKING if board.entries else "", only=doc.TEXT),
            doc.Chapter("Refused", (refused,), "refused", only=doc.HTML),
        ),
        [*made, *reference_words("benchmark bicycle", board.dataset_version)],
    )  # fmt: skip


def render_json(board: Leaderboard) -> str:
    """Return the leaderboard as JSON."""
    found = {
        "schema_version": SCHEMA_VERSION,
        "dataset_version": board.dataset_version,
        "version": __version__,
        "problems": [
            {"problem": problem, "entries": [_as_json(p, e) for p, e in _places(entries)]}
            for problem, entries in board.entries.items()
        ],
        "refused": list(board.refused),
    }
    return json.dumps(found, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _table(entries: Sequence[Entry]) -> doc.TableBlock:
    """Return a table with a row for each submission; those with equal digits share a rank."""
    rows: list[doc.TableRow] = [
        [
            str(place),
            doc.Cell(entry.submission.name, facts=_facts(entry)),
            f"{entry.digits:.1f}",
            str(entry.grade or "-"),
            f"{label(entry.worst[1])}, {entry.worst[0]}",
            number(entry.performance),
            readable(entry.submission.processor_time),
        ]
        for place, entry in _places(entries)
    ]
    return doc.TableBlock(_COLUMNS_OF_RANKING, rows, "submissions", "board", left=2)


def _diagnoses(entries: Sequence[Entry]) -> doc.Listing:
    found = ((place, e, diagnosis(e)) for place, e in _places(entries))
    items = (doc.Item(f"{e.submission.name}. {said}", mark=f"{n}.") for n, e, said in found if said)
    return doc.Listing(tuple(items), doc.TEXT)


def _picture(problem: str, entries: Sequence[Entry]) -> str:
    """Draw the correct digits of the submissions over their stated processor times."""
    times = [e.submission.processor_time for e in entries]
    digits = [max(e.digits, _LOWEST_DIGITS_DRAWN) for e in entries]
    found = list(zip(_places(entries), times, digits, strict=True))
    marks = [Mark(x, y, "mark", str(place), f"{place}. {e.submission.name}: {e.digits:.1f} digits")
             for (place, e), x, y in found]  # fmt: skip
    programs = dict.fromkeys(e.submission.said["program"] for e in entries)
    guides = []
    for program in programs:
        same = sorted((x, y) for (_, e), x, y in found if e.submission.said["program"] == program)
        guides += [Guide((a[0], b[0]), (a[1], b[1]), "") for a, b in pairwise(same)]
    drawn = chart(
        spread(min(times), max(times)), linear(min(digits) - 0.5, max(digits)), (),
        about=f"Correct digits of the submissions to {problem} over their processor times",
        title="correct digits", x_title="processor time [s]", height=_FIGURE_HEIGHT, guides=guides,
        marks=marks,
    )  # fmt: skip
    return wide(
        drawn,
        "Correct digits over processor time: higher is more accurate, further left is faster. "
        "Numbers are ranks in the table, and lines join runs of one program. Results below −1 are "
        "drawn at −1. Each time was measured on the machine that its submission names.",
    )


def _facts(entry: Entry) -> doc.Facts:
    said = entry.submission.said
    facts = {key: said[key] for key in _SAID_OF_ENTRIES if key in said}
    taken = ", ".join(f"{label(key)}: {name}" for key, name in entry.definitions.items())
    facts["definitions"] = taken or "the default ones"
    if found := diagnosis(entry):
        facts["diagnosis"] = found
    return doc.Facts(tuple((key.replace("_", " "), text, "") for key, text in facts.items()))


def diagnosis(entry: Entry) -> str:
    """Return the first sentence of the diagnosis that names a cause; empty if there is none."""
    return cause(entry.report.diagnosis)


def _places(entries: Sequence[Entry]) -> list[tuple[int, Entry]]:
    shown = [f"{e.digits:.1f}" for e in entries]
    return [(shown.index(digits) + 1, e) for digits, e in zip(shown, entries, strict=True)]


def _as_json(place: int, entry: Entry) -> dict[str, Any]:
    maneuver, key = entry.worst
    return {
        "place": place,
        "source": entry.submission.source.name,
        **entry.submission.said,
        "scd": entry.digits,
        "grade": entry.grade,
        "worst": {"maneuver": maneuver, "column": key},
        "performance": entry.performance,
        "definitions": dict(entry.definitions),
        "diagnosis": diagnosis(entry) or None,
    }
