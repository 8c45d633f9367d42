"""The table of formats in docs/files.md, from `heyoka_bike.scoring.reading.formats`.

Run as a script, this writes it.
"""

from pathlib import Path

from heyoka_bike.scoring.reading.formats import TEXT_FIRST, Format
from marked_parts import filled

PAGE = Path(__file__).parent.parent / "files.md"


def _line(format_: Format) -> str:
    package = f". Through {format_.package}" if format_.package else ""
    return f"| {format_.label} | {format_.about}{package} |"


def table() -> str:
    """The table in Markdown."""
    return "\n".join(["| format | what is read |", "|---|---|", *map(_line, TEXT_FIRST)])


def page(text: str) -> str:
    """The page with its table made anew."""
    return filled(text, "formats", table())


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
