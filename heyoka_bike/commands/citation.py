"""Citations of the program, its data and the works that they build on, as in CITATION.cff.

``citation.bib`` contains a BibTeX entry for each work, below a line with the work's role.
"""

import argparse
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template
from textwrap import fill
from typing import Any

from heyoka_bike.errors import Exit
from heyoka_bike.version import __version__

_ENTRY_OF_README = re.compile(r"^(.+):\n((?:[@ ].*\n)+\})$", re.MULTILINE)
_FIELD = re.compile(r"^  (\w+) = \{+(.+?)\}+,$", re.MULTILINE)
# Templates for the fields that a citation as text shows differently from BibTeX.
_IN_TEXT = {"version": "Version {}", "doi": "https://doi.org/{}"}


@dataclass(frozen=True, slots=True)
class Work:
    """A work to cite: the program, its data, or a publication that they build on.

    Attributes
    ----------
    what : str
        Role of the work, such as program or data.
    bibtex : str
        BibTeX entry.
    fields : mapping of str to str
        Fields of the entry; author and title come first.
    """

    what: str
    bibtex: str
    fields: Mapping[str, str]

    @property
    def authors(self) -> tuple[str, ...]:
        """The authors, each as ``Family, Given`` or as the name of a group."""
        return tuple(self.fields["author"].split(" and "))

    def text(self) -> str:
        """Return the citation as text, wrapped at 100 characters."""
        author, *others = (_IN_TEXT.get(k, "{}").format(x) for k, x in self.fields.items())
        said = ". ".join((author.replace(" and ", "; ").rstrip("."), *others))
        return fill(f"{self.what}: {said}", 100, subsequent_indent="    ", break_long_words=False)


def works() -> tuple[Work, ...]:
    """Return the program and its data in this version, and the works that they build on."""
    from heyoka_bike.reference import manifest
    from heyoka_bike.reference.description import CREATOR, TITLE

    template = Template(Path(__file__).with_name("citation.bib").read_text(encoding="utf-8"))
    entries = template.substitute(
        version=__version__, creator=CREATOR, title=TITLE, year=manifest.DATASET_DATE[:4],
        dataset=manifest.PUBLISHED_VERSION, manifest=manifest.PUBLISHED_MANIFEST_SHA256,
    )  # fmt: skip
    found = _ENTRY_OF_README.findall(entries)
    return tuple(Work(what, entry, dict(_FIELD.findall(entry))) for what, entry in found)


class Cite(argparse.Action):
    """Action that prints the citations as text and as BibTeX, and exits."""

    def __init__(self, option_strings: Any, dest: str, help: str | None = None) -> None:
        super().__init__(option_strings, dest, nargs=0, help=help)

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: Any, values: Any, option: Any = None
    ) -> None:
        cited = works()
        print("\n".join(work.text() for work in cited), end="\n\n")
        print("\n\n".join(work.bibtex for work in cited))
        parser.exit(Exit.OK)
