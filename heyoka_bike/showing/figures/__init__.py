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

from heyoka_bike.errors import InputError, MissingPackageError, unknown_word

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
        How its files are called.
    about
        What is drawn, in a few words.
    shows
        ``each``: a figure for each maneuver; ``one``: a figure of one, the first if none is chosen;
        ``all``: a figure with all; ``none``: no motion.
    is_of_benchmark
        Whether only a set of the benchmark itself can be drawn.
    needs_heyoka
        Whether motions are computed for it; without heyoka ``all`` leaves it out.
    """

    module: str
    file: str
    about: str
    shows: Literal["each", "one", "all", "none"]
    is_of_benchmark: bool = False
    needs_heyoka: bool = False


FIGURES: Mapping[str, Kind] = {
    DEFAULT: Kind(
        "maneuver", "maneuver", "figures 2 to 4 of the benchmark, one for each maneuver", "each"
    ),
    "stability": Kind("eigenvalues", "stability", "eigenvalues over forward speed", "none"),
    "phase": Kind("phase", "phase", "phase portraits", "all"),
    "errors": Kind(
        "true_errors", "errors", "errors of other programs, and what eq. (1) says", "one", True
    ),
    "definitions": Kind(
        "definition_distances",
        "definitions",
        "how far apart the definitions of a column are",
        "one",
    ),
    "certificate": Kind(
        "certified_bounds", "certificate", "certified bound and true error, in a minute", "all"
    ),
    "after": Kind(
        "after", "after", "what follows the ten seconds; needs heyoka", "all", True, True
    ),
    "bicycle": Kind("dimensions", "bicycle", "the parameters of the bicycle", "none"),
    "overview": Kind("overview", "overview", "a wide picture for a page on any background", "all"),
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
            matplotlib is not installed, or heyoka, if the figure needs it.
        DatasetError
            A file of the set that this figure needs is missing or damaged.
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
        What stands before the name of an argument in a message; on the command line two.

    Raises
    ------
    InputError
        No such figure or maneuver, or a figure that there is not of this set.
    """
    from heyoka_bike.reference.manifest import CUSTOM

    if name not in FIGURES and name != ALL:
        raise InputError(f"{dashes}figure: {unknown_word(name, [*FIGURES, ATLAS, ALL])}")
    if maneuver is not None and maneuver not in reference:
        raise InputError(f"{dashes}maneuver: found {maneuver}, expected 1 to {len(reference)}")
    is_benchmark = reference.dataset_version != CUSTOM
    if name == ALL:
        has_heyoka = _has_heyoka()
        kinds = [
            k for k in FIGURES.values()
            if (is_benchmark or not k.is_of_benchmark) and (has_heyoka or not k.needs_heyoka)
        ]  # fmt: skip
        return [plate for kind in kinds for plate in _plates(kind, reference, maneuver)]
    kind = FIGURES[name]
    if kind.is_of_benchmark and not is_benchmark:
        raise InputError(
            f"{dashes}figure: found '{name}' for a set of one's own, expected a set of the "
            "benchmark"
        )
    if kind.shows == "none" and maneuver is not None:
        raise InputError(
            f"{dashes}maneuver: found {maneuver}, expected none: '{name}' shows no motion"
        )
    return _plates(kind, reference, maneuver)


def _plates(kind: Kind, reference: Reference, maneuver: int | None) -> list[Plate]:
    if kind.shows == "none":
        return [Plate(kind.file, kind, ())]
    if kind.shows == "all" and maneuver is None:
        return [Plate(kind.file, kind, tuple(reference))]
    numbers = tuple(reference) if maneuver is None and kind.shows == "each" else (maneuver or 1,)
    return [Plate(f"{kind.file}_{n}", kind, (n,)) for n in numbers]


def _has_heyoka() -> bool:
    from heyoka_bike.motion.expressions import require_heyoka

    try:
        require_heyoka()
    except MissingPackageError:
        return False
    return True
