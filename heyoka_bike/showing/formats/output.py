"""A score in one of the formats, by its name or by the suffix of a file: text, or that file."""

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
"""Of a table that goes to a file or a pipe."""


def render(
    scored: Report | Series, name: str, made: Sequence[tuple[str, str]] | None = None, *,
    width: int | None = WIDTH, has_colors: bool = False, has_details: bool = True,
    written: Sequence[str] = (),
) -> str:  # fmt: skip
    """The text of a score in a format, or its ``summary``.

    Parameters
    ----------
    name
        One of `FORMATS`, or ``summary``.
    made
        When and how; by default now, see `wording.origin_text`.
    width, has_colors, has_details
        Of text, see `document.text.render`.
    written
        Files that were written beside it, which a table without details names.
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
    """Write a score to a file, in the format of that name or of the suffix.

    Raises
    ------
    InputError
        No such format, a file that cannot be written, or one of the files that were scored.
    """
    from heyoka_bike.showing.wording.run_text import reports
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
