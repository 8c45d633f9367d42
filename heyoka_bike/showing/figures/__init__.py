"""The figures that ``heyoka-bike plot`` draws, by name.

A figure is a module of this package with a function ``draw(reference, numbers)``, which takes a
`Reference` and the numbers of the maneuvers to show, and gives a matplotlib figure. It is imported
when it is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

from heyoka_bike.errors import InputError, unknown_word

if TYPE_CHECKING:
    from heyoka_bike.reference.load import Reference

DEFAULT, ALL = "maneuvers", "all"
ATLAS = "atlas"
"""The figure that is not of a reference set but of an atlas."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of figure.

    Attributes
    ----------
    module
        Of this package.
    file
        Name of its files.
    about
        Its content, in a few words.
    shows
        ``each``: a figure for each maneuver; ``all``: a figure with all; ``none``: no motion.
    """

    module: str
    file: str
    about: str
    shows: Literal["each", "all", "none"]


FIGURES: Mapping[str, Kind] = {
    DEFAULT: Kind(
        "maneuver", "maneuver", "figures 2 to 4 of the benchmark, one for each maneuver", "each"
    ),
    "stability": Kind("eigenvalues", "stability", "eigenvalues over forward speed", "none"),
    "phase": Kind("phase", "phase", "phase portraits", "all"),
    "path": Kind("path", "path", "paths of the rear wheel and their curvature", "all"),
}
"""The kinds by name."""


@dataclass(frozen=True, slots=True)
class Plate:
    """A figure to draw.

    Attributes
    ----------
    name
        Of its file, without suffix.
    kind : Kind
    numbers : tuple of int
        Maneuvers to show.
    """

    name: str
    kind: Kind
    numbers: tuple[int, ...]

    def draw(self, reference: Reference) -> Any:
        """The matplotlib figure.

        Raises
        ------
        MissingPackageError
            matplotlib is not installed.
        """
        return import_module(f"{__name__}.{self.kind.module}").draw(reference, self.numbers)


def plates(
    reference: Reference, name: str = DEFAULT, maneuver: int | None = None, *, dashes: str = "--"
) -> list[Plate]:
    """Figures to draw for a name of `FIGURES`, or for ``all``.

    Parameters
    ----------
    reference : Reference
    name
    maneuver
        Only this one, in figures of motions.
    dashes
        Dashes before the name of an argument in a message; on the command line two.

    Raises
    ------
    InputError
        No such figure or maneuver.
    """
    if name not in FIGURES and name != ALL:
        raise InputError(f"{dashes}figure: {unknown_word(name, [*FIGURES, ATLAS, ALL])}")
    if maneuver is not None and maneuver not in reference:
        raise InputError(f"{dashes}maneuver: found {maneuver}, expected 1 to {len(reference)}")
    kinds = list(FIGURES.values()) if name == ALL else [FIGURES[name]]
    if maneuver is not None and all(kind.shows == "none" for kind in kinds):
        raise InputError(
            f"{dashes}maneuver: found {maneuver}, expected none: '{name}' shows no motion"
        )
    return [plate for kind in kinds for plate in _plates(kind, reference, maneuver)]


def _plates(kind: Kind, reference: Reference, maneuver: int | None) -> list[Plate]:
    if kind.shows == "none":
        return [Plate(kind.file, kind, ())]
    if kind.shows == "all" and maneuver is None:
        return [Plate(kind.file, kind, tuple(reference))]
    numbers = tuple(reference) if maneuver is None else (maneuver,)
    return [Plate(f"{kind.file}_{n}", kind, (n,)) for n in numbers]
