"""How to cite the program, its data and what they rest on; CITATION.cff says the same."""

import argparse
from dataclasses import dataclass
from textwrap import fill
from typing import Any

from heyoka_bike.errors import Exit
from heyoka_bike.version import __version__


@dataclass(frozen=True, slots=True)
class Work:
    """Something to cite.

    Attributes
    ----------
    what : str
        What it is to the reader.
    kind, key : str
        As BibTeX has them.
    authors : tuple of str
        ``Family, Given``, or the name of a group.
    title : str
    fields : dict of str to str
        Other fields of BibTeX.
    """

    what: str
    kind: str
    key: str
    authors: tuple[str, ...]
    title: str
    fields: dict[str, str]


_DEVELOPERS = ("The heyoka_bike developers",)


def works() -> tuple[Work, ...]:
    """The program and its data in this version, and what they rest on."""
    from heyoka_bike.reference.description.facts import CREATOR, TITLE
    from heyoka_bike.reference.manifest import (
        DATASET_DATE,
        DATASET_VERSION,
        PUBLISHED_MANIFEST_SHA256,
    )

    return (
        Work(
            "the program", "software", "heyoka_bike", _DEVELOPERS,
            "heyoka_bike: high-precision reference solutions and scoring for the IFToMM benchmark "
            "Uncontrolled bicycle",
            {"version": __version__},
        ),
        Work(
            "its data", "misc", "heyoka_bike_data", (CREATOR,), TITLE,
            {
                "year": DATASET_DATE[:4],
                "howpublished": f"Dataset, version {DATASET_VERSION}",
                "note": f"SHA-256 of its manifest {PUBLISHED_MANIFEST_SHA256}",
            },
        ),
        Work(
            "the bicycle of the benchmark", "article", "meijaard_2007",
            ("Meijaard, J. P.", "Papadopoulos, Jim M.", "Ruina, Andy", "Schwab, A. L."),
            "Linearized dynamics equations for the balance and steer of a bicycle: a benchmark and "
            "review",
            {
                "journal": "Proceedings of the Royal Society A", "year": "2007",
                "doi": "10.1098/rspa.2007.1857",
            },
        ),
        Work(
            "the integrator", "article", "biscani_izzo_2021", ("Biscani, Francesco", "Izzo, Dario"),
            "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
            {
                "journal": "Monthly Notices of the Royal Astronomical Society", "year": "2021",
                "doi": "10.1093/mnras/stab1032",
            },
        ),
    )  # fmt: skip


class Cite(argparse.Action):
    """Prints what to cite, for a text and for BibTeX, and ends."""

    def __init__(self, option_strings: Any, dest: str, help: str | None = None) -> None:
        super().__init__(option_strings, dest, nargs=0, help=help)

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: Any, values: Any, option: Any = None
    ) -> None:
        print("\n".join(map(plain, works())), end="\n\n")
        print("\n\n".join(map(bibtex, works())))
        parser.exit(Exit.OK)


def plain(work: Work) -> str:
    """The work in a line of text, folded."""
    fields = dict(work.fields)
    if "version" in fields:
        fields["version"] = f"Version {fields['version']}"
    if "doi" in fields:
        fields["doi"] = f"https://doi.org/{fields['doi']}"
    said = ". ".join(("; ".join(work.authors).rstrip("."), work.title, *fields.values()))
    return fill(f"{work.what}: {said}", 100, subsequent_indent="    ", break_long_words=False)


def bibtex(work: Work) -> str:
    """The work as an entry of BibTeX."""
    # A group's name in braces of its own is no family name.
    authors = [name if "," in name else f"{{{name}}}" for name in work.authors]
    fields = {"author": " and ".join(authors), "title": f"{{{work.title}}}", **work.fields}
    lines = "".join(f"  {name} = {{{text}}},\n" for name, text in fields.items())
    return f"@{work.kind}{{{work.key},\n{lines}}}"
