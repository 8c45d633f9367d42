"""Figures about the published set that pages show; those of any set are `heyoka-bike plot`.

Each is a module with ``draw(reference, numbers)``, which takes a `Reference` and the numbers of the
maneuvers to show, and gives a matplotlib figure. Run as a script, the folder draws one::

    python docs/_site/figures errors errors.svg [--maneuver 1]
"""

from importlib import import_module

from heyoka_bike.reference.load import load_reference

FIGURES = {
    "errors": "true_errors",
    "definitions": "definition_distances",
    "certificate": "certified_bounds",
    "after": "after",
    "bicycle": "dimensions",
    "overview": "overview",
}
"""The modules by the names of the figures."""

OF_ONE = ("errors", "definitions")
"""Those that show one maneuver, by default the first."""


def draw(name, maneuver=None, reference=None):
    """A figure of a set, by default of the published one; of one maneuver if a number is given."""
    known = load_reference(reference)
    numbers = tuple(known) if maneuver is None else (maneuver,)
    if name in OF_ONE:
        numbers = numbers[:1]
    return import_module(f"figures.{FIGURES[name]}").draw(known, numbers)
