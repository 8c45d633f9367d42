"""The table of formats in docs/files.md, from `heyoka_bike.scoring.reading.formats`.

Run as a script, this writes it.
"""

from pathlib import Path

from heyoka_bike.scoring.reading.formats import table

PAGE = Path(__file__).parent.parent / "files.md"
BEGIN, END = "<!-- formats: begin -->", "<!-- formats: end -->"


def page(text: str) -> str:
    """The page with its table made anew."""
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{table()}\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
