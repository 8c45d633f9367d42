"""Render a score in any format, or write it to a file whose suffix selects the format."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from heyoka_bike.errors import InputError, quoted, unknown_word

if TYPE_CHECKING:
    from heyoka_bike.scoring.report import Report
    from heyoka_bike.scoring.runs import Series

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
"""Width of a table that goes to a file or a pipe, in characters."""


def render(
    scored: Report | Series, name: str, made: Sequence[tuple[str, str]] | None = None, *,
    width: int | None = WIDTH, has_colors: bool = False, has_details: bool = True,
    written: Sequence[str] = (),
) -> str:  # fmt: skip
    """Render a score as text in one of the formats, or as its ``summary``.

    Parameters
    ----------
    name
        One of `FORMATS`, or ``summary``.
    made
        When and how the score was made; by default now, see `wording.origin_text`.
    width, has_colors, has_details
        Options of text, see `document.text.render`.
    written
        Files that were also written, which a table without details lists.
    """
    if name in ("html", "table"):
        from heyoka_bike.showing.document import html, text
        from heyoka_bike.showing.formats.report_document import document

        found = document(scored, made)
        if name == "html":
            return html.render(found)
        shown = text.render(found, width, has_colors, has_details=has_details)
        if has_details:
            return shown
    from heyoka_bike.showing.formats import summary

    if name == "table":
        return shown + summary.closing(scored, width, has_colors, written)
    if name == "summary":
        return summary.render(scored, width, has_colors)
    return str(import_module(f"heyoka_bike.showing.formats.{name}").render(scored))


def save(scored: Report | Series, path: str | PathLike[str], name: str | None = None) -> Path:
    """Write a score to a file; the format is `name`, or else depends on the file's suffix.

    Raises
    ------
    InputError
        The format is unknown, the file cannot be written, or it is one of the scored files.
    """
    from heyoka_bike.showing.wording.run_text import reports
    from heyoka_bike.system.files import refuse_overwriting, write_output

    file = Path(path)
    found = SUFFIXES.get(file.suffix.lower()) if name is None else name
    if found is None:
        raise InputError(
            f"save: found {quoted(file.name)}, expected a name ending in "
            f"{', '.join(SUFFIXES)}, or the format as well"
        )
    if found not in FORMATS:
        raise InputError(f"save: {unknown_word(found, FORMATS, 'format ')}")
    scored_files = [f for r in reports(scored) for f in r.file.path.split(", ")]
    refuse_overwriting(scored_files, [file])
    write_output(file, render(scored, found).encode())
    return file
