"""The figures of ``heyoka-bike plot`` and of `plot`: draw one by name, or write it to files.

Each figure is a function in a module of this package. It takes a `Reference` and the numbers of the
maneuvers to show, and returns a matplotlib figure. The module is imported when the figure is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from heyoka_bike.errors import InputError, unknown_word
from heyoka_bike.workbench.style import FORMATS, render, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from heyoka_bike.reference.load import Reference

DEFAULT, ALL = "maneuvers", "all"
ATLAS = "atlas"
"""Name of the figure that shows an atlas, not a dataset."""
_DEFAULT_FORMATS = ("png", "svg")


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of figure: the function that draws it, and what it shows.

    Attributes
    ----------
    module
        Module of this package.
    name
        Name of its function there, and of its files.
    about
        Content of the figure in a few words.
    shows
        ``each``: a figure for each maneuver; ``all``: a figure with all; ``none``: no motion.
    """

    module: str
    name: str
    about: str
    shows: Literal["each", "all", "none"]

    def draw(self, reference: Reference, numbers: Sequence[int]) -> Any:
        """Draw the maneuvers with these numbers as a matplotlib figure.

        Raises
        ------
        MissingPackageError
            matplotlib is not installed.
        """
        module = import_module(f"{__name__}.{self.module}")
        return getattr(module, self.name)(reference, numbers)


Plates = dict[str, Callable[[], Any]]
"""Figures to draw, by their file names without suffix."""


FIGURES: Mapping[str, Kind] = {
    DEFAULT: Kind("motions", "maneuver", "columns over time, one figure for each maneuver", "each"),
    "stability": Kind("eigenvalues", "stability", "eigenvalues over forward speed", "none"),
    "phase": Kind("motions", "phase", "phase portraits", "all"),
    "path": Kind("motions", "path", "paths of the rear wheel and their curvature", "all"),
}
"""The kinds by name."""


def plates(
    reference: Reference, name: str = DEFAULT, maneuver: int | None = None, *, dashes: str = "--"
) -> Plates:
    """Return the figures to draw for a name of `FIGURES` or for ``all``, by file name.

    Parameters
    ----------
    reference : Reference
    name
    maneuver
        Show only this maneuver in figures of motions.
    dashes
        Dashes before the name of an argument in messages (two on the command line).

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
        raise InputError(f"{dashes}maneuver does not apply: '{name}' shows no motion")
    every = tuple(reference) if maneuver is None else (maneuver,)
    found: Plates = {}
    for kind in kinds:
        if kind.shows == "none" or (kind.shows == "all" and maneuver is None):
            found[kind.name] = partial(kind.draw, reference, every)
        else:
            found |= {f"{kind.name}_{n}": partial(kind.draw, reference, (n,)) for n in every}
    return found


def plot(
    figure: str = DEFAULT,
    path: str | PathLike[str] | None = None,
    *,
    maneuver: int | None = None,
    reference: Reference | str | PathLike[str] | None = None,
) -> Figure | tuple[Figure, ...] | tuple[Path, ...]:
    """Draw a figure of a dataset, or write it to files.

    Parameters
    ----------
    figure
        Name of a figure: ``maneuvers``, ``stability``, ``phase``, ``path`` or ``all``; ``atlas``
        for an atlas.
    path
        A file (.png, .svg, .pdf) for one figure, or a folder for PNG and SVG files. By default
        nothing is written.
    maneuver
        Draw this maneuver; by default all.
    reference
        From `load_reference`, or the folder of a dataset (of an atlas for the figure ``atlas``); by
        default the published dataset.

    Returns
    -------
    matplotlib.figure.Figure, or tuple of Figure or Path
        The figure, or several if each maneuver has its own; the files if they are written.

    Raises
    ------
    InputError
        No such figure or maneuver, or a path that cannot be written.
    MissingPackageError
        matplotlib is not installed.
    """
    if path is not None and not isinstance(path, str | PathLike):
        raise InputError(f"path: found a {type(path).__name__}, expected the name of a file")
    if not isinstance(figure, str):
        raise InputError(
            f"figure: found a {type(figure).__name__}, expected the name of a figure of the "
            'reference; score(...).save("report.html") draws results'
        )
    if figure == ATLAS and (not isinstance(reference, str | PathLike) or maneuver is not None):
        raise InputError(
            "figure: the figure atlas needs the folder of an atlas as reference, and no maneuver"
        )
    every = drawn(figure, maneuver, reference, None if path is None else str(path))
    if path is not None:
        return tuple(written(every))
    figures = []
    for one, _ in every:
        # Notebooks show only figures that are registered with pyplot, or that have this method.
        vars(one)["_repr_png_"] = partial(render, one, "png")
        figures.append(one)
    return figures[0] if len(figures) == 1 else tuple(figures)


def written(every: Iterator[tuple[Figure, list[Path]]]) -> Iterator[Path]:
    """Write figures to their files, and yield the path of each file once it exists."""
    for figure, files in every:
        for file in files:
            save(figure, file)
            yield file


def drawn(
    figure: str, maneuver: int | None, reference: Any, output: str | None,
    formats: Sequence[str] | None = None, *, dashes: str = "",
) -> Iterator[tuple[Figure, list[Path]]]:  # fmt: skip
    """Yield each figure with its files; invalid arguments raise errors before any drawing.

    Parameters
    ----------
    reference
        An argument of `load_reference`, or the folder of an atlas.
    output
        A folder, or the file of a single figure; None for no files.
    formats
        Formats for a folder; None if not given.
    dashes
        See `plates`.
    """
    from heyoka_bike.reference.load import load_reference

    hint = ""
    if figure == ATLAS:
        from heyoka_bike.workbench.atlas.figure import atlas_figure

        chosen: Plates = {ATLAS: partial(atlas_figure, reference)}
    else:
        chosen = plates(load_reference(reference), figure, maneuver, dashes=dashes)
        if figure == DEFAULT:
            hint = ", or --maneuver N" if dashes else ", or maneuver=N"
    every = _files(output, list(chosen), formats, hint, dashes)
    return ((draw(), files) for draw, files in zip(chosen.values(), every, strict=True))


def _files(
    output: str | None, names: Sequence[str], formats: Sequence[str] | None, hint: str, dashes: str
) -> list[list[Path]]:
    """Return the files to write for each figure; `hint` is a part of an error message.

    Raises
    ------
    InputError
        A file of another format, or for several figures.
    """
    if output is None:
        return [[] for _ in names]
    out, option = Path(output), "--output" if dashes else "path"
    if out.is_dir() or not out.suffix or output.endswith("/"):
        chosen = dict.fromkeys(formats or _DEFAULT_FORMATS)
        return [[out / f"{name}.{f}" for f in chosen] for name in names]
    if out.suffix.removeprefix(".").lower() not in FORMATS:
        raise InputError(
            f"{option}: found '{out.name}', expected a file ending in "
            f"{', '.join(f'.{f}' for f in FORMATS)}, or a folder (end it with / if its name "
            "contains a dot)"
        )
    if formats is not None:
        raise InputError(
            "--format can be used only with a folder; the suffix of a file sets its format"
        )
    if len(names) > 1:
        raise InputError(
            f"{option}: found the file '{out.name}' for {len(names)} figures, expected a "
            f"folder{hint}"
        )
    return [[out]]
