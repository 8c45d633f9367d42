"""A score in one of the formats, by its name or by the suffix of a file: text, or that file."""

from __future__ import annotations

from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from heyoka_bike.errors import InputError, quoted, unknown_word

if TYPE_CHECKING:
    from heyoka_bike.scoring.report import Report, Series
    from heyoka_bike.showing.document import Document
    from heyoka_bike.showing.formats.origin import Origin

FORMATS = ("table", "json", "csv", "junit", "html", "badge")
SUFFIXES = {
    ".txt": "table",
    ".json": "json",
    ".csv": "csv",
    ".xml": "junit",
    ".html": "html",
    ".htm": "html",
}
WIDTH = 100
"""Of a table that goes to a file or a pipe."""


def render(
    scored: Report | Series, name: str, made: Origin | None = None, *,
    width: int | None = WIDTH, has_colors: bool = False, has_details: bool = True,
) -> str:  # fmt: skip
    """The text of a score in a format, or its ``summary``.

    Parameters
    ----------
    name
        One of `FORMATS`, or ``summary``.
    made
        When and how; by default now.
    width, has_colors, has_details
        Of text, see `document.text.render`.
    """
    if name == "html":
        from heyoka_bike.showing.document import html

        return html.render(document_of(scored, made))
    if name == "table":
        from heyoka_bike.showing.document import text

        shown = text.render(document_of(scored, made), width, has_colors, has_details=has_details)
        if has_details:
            return shown
        from heyoka_bike.showing.formats.summary import closing

        return shown + closing(scored, width, has_colors)
    if name == "summary":
        from heyoka_bike.showing.formats import summary

        return summary.render(scored, width, has_colors)
    return str(import_module(f"heyoka_bike.showing.formats.{name}").render(scored))


def document_of(scored: Report | Series, made: Origin | None = None) -> Document:
    """All that is said of a file or of a series; by default made now."""
    from heyoka_bike.errors import printable
    from heyoka_bike.scoring.report import Report
    from heyoka_bike.showing import wording as words
    from heyoka_bike.showing.document import Document
    from heyoka_bike.showing.formats import report, series
    from heyoka_bike.showing.formats.origin import origin, origin_words

    if isinstance(scored, Report):
        title = heading = printable(Path(scored.file.path).name or scored.file.path)
        blocks = report.blocks(scored)
    else:
        names = ", ".join(words.run_name(scored, run) for run in scored.runs)
        is_one = scored.is_one_program
        heading = (
            f"{len(scored.runs)} {'runs of one program' if is_one else 'programs side by side'}"
        )
        title = f"{len(scored.runs)} {'runs' if is_one else 'programs'}: {names}"
        blocks = series.blocks(scored)
    first = words.reports(scored)[0]
    return Document(
        f"{title} – uncontrolled bicycle", heading, "Uncontrolled bicycle: score of", tuple(blocks),
        origin_words(
            made or origin(), first.bicycle, first.dataset_version, first.reference_sha256
        ),
    )  # fmt: skip


def save(scored: Report | Series, path: str | PathLike[str], name: str | None = None) -> Path:
    """Write a score to a file, in the format of that name or of the suffix.

    Raises
    ------
    InputError
        No such format, a file that cannot be written, or one of the files that were scored.
    """
    from heyoka_bike.showing.wording import reports
    from heyoka_bike.system.files import refuse_overwriting, write_output

    file = Path(path)
    found = SUFFIXES.get(file.suffix.lower()) if name is None else name
    if found is None:
        raise InputError(
            f"save: found {quoted(file.name)}, expected a name ending in {', '.join(SUFFIXES)}, or "
            "its format beside it"
        )
    if found not in FORMATS:
        raise InputError(f"save: {unknown_word(found, FORMATS, 'format ')}")
    scored_files = [f for r in reports(scored) for f in r.file.path.split(", ")]
    refuse_overwriting(scored_files, [file])
    write_output(file, render(scored, found).encode())
    return file


def verdict(scored: Report | Series) -> str:
    """One line that says what the results are worth."""
    from heyoka_bike.scoring.report import Report
    from heyoka_bike.showing import wording

    return wording.verdict(scored) if isinstance(scored, Report) else wording.series_verdict(scored)
