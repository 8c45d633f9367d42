"""Figures of the paper, drawn by the code of the package and of the site, as vectors."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from field_page import figures
from paper_fact import ROOT, document

from heyoka_bike.reference.load import load_reference
from heyoka_bike.showing.figures import plates
from heyoka_bike.showing.figures.style import render


@dataclass(frozen=True)
class Drawn:
    """A figure of the paper.

    Attributes
    ----------
    svg
        The function that draws it, to the bytes of a file.
    source
        What it reads.
    command
        What anybody may give to draw the same.
    """

    svg: Callable[[], bytes]
    source: str
    command: str


def plot(name):
    """A figure of `heyoka-bike plot`."""
    reference = load_reference()
    (plate,) = plates(reference, name)
    return render(plate.draw(reference), "svg")


def field():
    """Correct digits of the programs over their time."""
    return figures(document("docs/field.json"))["field.svg"]


def atlas():
    """The map of falling, as its long run drew it."""
    return (ROOT / "docs" / "atlas.svg").read_bytes()


FIGURES = {
    "bicycle": Drawn(
        partial(plot, "bicycle"), "data/bicycles/benchmark.toml",
        "heyoka-bike plot --figure bicycle",
    ),
    "errors": Drawn(partial(plot, "errors"), "data/peers", "heyoka-bike plot --figure errors"),
    "field": Drawn(field, "docs/field.json", "python docs/_site/field_page.py"),
    "atlas": Drawn(atlas, "docs/atlas.svg", "python docs/_site/atlas_page.py --store FOLDER"),
}  # fmt: skip
"""By the names of their files."""
