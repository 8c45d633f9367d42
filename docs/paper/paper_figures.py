"""Figures of the paper, drawn by the code of the package and of the site, as vectors."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import figures
from field_page import figures as field_figures
from heyoka_bike.workbench.style import render
from paper_fact import ROOT, document


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
    """A figure of the pages."""
    return render(figures.draw(name), "svg")


def field():
    """Correct digits of the programs over their time."""
    return field_figures(document("docs/field.json"))["field.svg"]


def atlas():
    """The map of falling, as its long run drew it."""
    return (ROOT / "docs" / "atlas.svg").read_bytes()


FIGURES = {
    "bicycle": Drawn(
        partial(plot, "bicycle"), "data/bicycles/benchmark.toml",
        "python docs/_site/figures bicycle bicycle.svg",
    ),
    "errors": Drawn(
        partial(plot, "errors"), "data/peers", "python docs/_site/figures errors errors.svg"
    ),
    "field": Drawn(field, "docs/field.json", "python docs/_site/field_page.py"),
    "atlas": Drawn(atlas, "docs/atlas.svg", "python docs/_site/atlas_page.py --store FOLDER"),
}  # fmt: skip
"""By the names of their files."""
