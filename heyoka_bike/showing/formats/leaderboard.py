"""The leaderboard in every format: rows of a table, JSON, an HTML page."""

import json
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from typing import Any

from heyoka_bike.scoring.leaderboard import Entry, Leaderboard
from heyoka_bike.showing.formats import axis
from heyoka_bike.showing.formats.chart import Guide, Mark, chart
from heyoka_bike.showing.formats.html import SCRIPT
from heyoka_bike.showing.formats.markup import PAGE_STYLE, page, prose
from heyoka_bike.showing.formats.origin import Origin, reference_words
from heyoka_bike.showing.formats.wording import label, number, readable
from heyoka_bike.version import __version__

SCHEMA_VERSION = 1

HEADINGS = ("", "submission", "digits", "grade", "worst column", "eq. (1)\n[%]", "CPU\n[s]")
WORDS = (1, 4)
"""The columns of words, which may be folded."""

ABOUT = (
    "Digits: the correct ones of the worst value of the worst column, which is named with its "
    "maneuver: -log10 of its error over the column's largest value. Grade: the highest of 3, 6, 9, "
    "12 that they reach. Eq. (1), the benchmark's own measure, sees only whether a program's own "
    "energy stays constant. Times are those that the submissions state, of their own machines; "
    "they rank nothing."
)

# What a submission says of itself, in the order in which it is shown.
_SAID = ("program", "version", "method", "step", "tolerance", "coordinates", "precision",
         "steps", "calls", "machine", "wall_time", "model", "licence", "contact")  # fmt: skip
_HEIGHT = 420
# What a problem's picture can tell apart: an error of ten times the largest value is no motion.
_LOWEST = -1.0


def rows(entries: Sequence[Entry]) -> list[list[str]]:
    """A row of text for each entry; equal digits share their place."""
    return [
        [
            str(place),
            entry.submission.name,
            f"{entry.digits:.1f}",
            str(entry.grade or "-"),
            _place(entry),
            number(entry.performance),
            readable(entry.submission.processor_time),
        ]
        for place, entry in _places(entries)
    ]


def render_json(board: Leaderboard) -> str:
    """The leaderboard as JSON."""
    document = {
        "schema_version": SCHEMA_VERSION,
        "dataset_version": board.dataset_version,
        "version": __version__,
        "problems": [
            {"problem": problem, "entries": [_as_json(p, e) for p, e in _places(entries)]}
            for problem, entries in board.entries.items()
        ],
        "refused": list(board.refused),
    }
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def render_html(board: Leaderboard, made: Origin) -> str:
    """The leaderboard as a page that needs nothing else."""
    count = sum(map(len, board.entries.values()))
    body = [
        '<header><p class="kicker">Uncontrolled bicycle: leaderboard</p>',
        f'<h1 class="verdict">{count} submission{"s" * (count != 1)}, by true error</h1>',
        f"<p>{prose(ABOUT)}</p></header>",
    ]
    for problem, entries in board.entries.items():
        body += [f'<section id="{problem}"><h2>{problem}</h2>{_table(entries)}']
        body += [_picture(problem, entries), "</section>"]
    if board.refused:
        lines = "".join(f"<li>{escape(line)}</li>" for line in board.refused)
        body.append(
            f'<section id="refused"><h2>Refused</h2><ul class="said">{lines}</ul></section>'
        )
    said = [("made", made.date), ("command", made.command)]
    origin = [(a, b) for a, b in said if b]
    origin += reference_words("benchmark bicycle", board.dataset_version)
    return page(
        "Leaderboard – uncontrolled bicycle", "\n".join(body), origin,
        styles=(PAGE_STYLE,), script=SCRIPT,
    )  # fmt: skip


def _table(entries: Sequence[Entry]) -> str:
    heads = "".join(f'<th scope="col">{escape(h) or "place"}</th>' for h in HEADINGS)
    body = []
    for cells, entry in zip(rows(entries), entries, strict=True):
        facts = "".join(
            f"<dt>{escape(key.replace('_', ' '))}</dt><dd>{escape(text)}</dd>"
            for key, text in _facts(entry)
        )
        place, name, *others = cells
        body.append(
            f'<tr><th scope="row">{place}</th><td><details><summary>{escape(name)}'
            f'</summary><dl class="facts">{facts}</dl></details></td>'
            + "".join(f"<td>{escape(x)}</td>" for x in others)
            + "</tr>"
        )
    return (
        '<div class="scroll" tabindex="0" role="group" aria-label="submissions"><table '
        f'class="board"><thead><tr>{heads}</tr></thead><tbody>{"".join(body)}</tbody></table></div>'
    )


def _picture(problem: str, entries: Sequence[Entry]) -> str:
    """Correct digits over the processor times that are stated."""
    times = [e.submission.processor_time for e in entries]
    digits = [max(e.digits, _LOWEST) for e in entries]
    found = list(zip(_places(entries), times, digits, strict=True))
    marks = [Mark(x, y, "mark", str(place), f"{place}. {e.submission.name}: {e.digits:.1f} digits")
             for (place, e), x, y in found]  # fmt: skip
    programs = dict.fromkeys(e.submission.said["program"] for e in entries)
    guides = []
    for program in programs:
        same = sorted((x, y) for (_, e), x, y in found if e.submission.said["program"] == program)
        guides += [Guide((a[0], b[0]), (a[1], b[1]), "") for a, b in pairwise(same)]
    drawn = chart(
        axis.spread(min(times), max(times)), axis.values(min(digits) - 0.5, max(digits)), (),
        about=f"Correct digits of the submissions to {problem} over their processor times",
        title="correct digits", x_title="processor time [s]", height=_HEIGHT, guides=guides,
        marks=marks,
    )  # fmt: skip
    return (
        f'<figure class="wide">{drawn}<figcaption>What digits cost: further up is more right, '
        "further left is cheaper. Numbers are the places in the table, lines join runs of one "
        "program; what is below −1 is drawn there. Each time is of the machine that its submission "
        "names.</figcaption></figure>"
    )


def _facts(entry: Entry) -> list[tuple[str, str]]:
    said = entry.submission.said
    facts = [(key, said[key]) for key in _SAID if key in said]
    taken = ", ".join(f"{label(key)}: {name}" for key, name in entry.definitions.items())
    facts.append(("definitions", taken or "the default ones"))
    said_of_it = diagnosis(entry)
    return [*facts, ("diagnosis", said_of_it)] if said_of_it else facts


def diagnosis(entry: Entry) -> str:
    """What goes wrong, in the first words that say it; empty without a diagnosis."""
    found = entry.report.diagnosis
    telling = (f.message for f in found if f.code != "no_mistake_found")
    return next(telling, found[0].message if found else "")


def _places(entries: Sequence[Entry]) -> list[tuple[int, Entry]]:
    shown = [f"{e.digits:.1f}" for e in entries]
    return [(shown.index(digits) + 1, e) for digits, e in zip(shown, entries, strict=True)]


def _place(entry: Entry) -> str:
    maneuver, key = entry.worst
    return f"{label(key)}, {maneuver}"


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
