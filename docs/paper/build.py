"""Make the paper: put the numbers into paper.md, draw its figures, set it as PDF.

``pip install -e '.[paper]'`` installs all that this needs, on any system.
"""

import argparse
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path += [str(HERE), str(HERE.parent / "_site")]

import paper_facts  # noqa: E402, F401  (declares placeholders)
import paper_field  # noqa: E402, F401
from paper_fact import FACTS, filled  # noqa: E402
from paper_figures import FIGURES  # noqa: E402
from speed_page import table  # noqa: E402

OUTPUT = HERE.parent / "_build" / "paper" / "paper.pdf"


def source():
    """Where each number and figure comes from, as the table of README.md."""
    return table(
        ("placeholder or figure", "read from", "made by"),
        [(f"`{name}`", f.source, f"`{f.command}`") for name, f in FACTS.items()]
        + [(f"`{name}.svg`", f.source, f"`{f.command}`") for name, f in FIGURES.items()],
        left=3,
    )


def typeset(text, folder):
    """The filled text as Typst, in a folder that has the figures and the bibliography."""
    import pypandoc

    found = pypandoc.convert_text(
        text, "typst", format="markdown",
        # Lines of a table longer than these columns would give it widths in proportion.
        extra_args=["--standalone", "--columns=1000", f"--template={HERE / 'template.typ'}"],
    )  # fmt: skip
    # Pandoc takes @fig:... for a citation; to Typst it is a reference to a figure.
    found = re.sub(r'#cite\(<((?:fig|tab):[^>]+)>, form: "prose"\)', r"@\1", found)
    path = folder / "paper.typ"
    path.write_text(found, encoding="utf-8")
    return path


def build(output):
    """Write the PDF, and beside it all that it was made of."""
    import typst

    folder = output.parent
    folder.mkdir(parents=True, exist_ok=True)
    text = filled((HERE / "paper.md").read_text(encoding="utf-8"))
    (folder / "paper.md").write_text(text, encoding="utf-8")
    (folder / "paper.bib").write_bytes((HERE / "paper.bib").read_bytes())
    for name, figure in FIGURES.items():
        (folder / f"{name}.svg").write_bytes(figure.svg())
    path = typeset(text, folder)
    typst.compile(str(path), output=str(output), format=output.suffix.removeprefix("."))


def main():
    """Read the command line."""
    p = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    p.add_argument("-o", "--output", type=Path, default=OUTPUT, help="default: %(default)s")
    p.add_argument("--sources", action="store_true", help="print where the numbers come from")
    asked = p.parse_args()
    if asked.sources:
        print(source())
    else:
        build(asked.output.resolve())
        print(asked.output)


if __name__ == "__main__":
    main()
