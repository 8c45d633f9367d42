"""Figures in Python, as the command ``plot`` draws them: to look at, or as files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import InputError
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.registry import addition
from heyoka_bike.showing.figures import ATLAS, DEFAULT, plates
from heyoka_bike.showing.figures.style import FORMATS, render, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFAULT_FORMATS = ("png", "svg")


def plot(
    figure: str = DEFAULT,
    path: str | PathLike[str] | None = None,
    *,
    maneuver: int | None = None,
    reference: Reference | str | PathLike[str] | None = None,
) -> Figure | tuple[Figure, ...] | tuple[Path, ...]:
    """Draw a figure of a reference set, or write it to files.

    Parameters
    ----------
    figure
        Name of a figure: ``maneuvers``, ``stability``, ``phase``, ``path``, or ``all``; ``atlas``
        of an atlas.
    path
        A file (.png, .svg, .pdf) for one figure, or a folder, which gets PNG and SVG. By default
        nothing is written.
    maneuver
        Draw this one; by default all.
    reference
        From `load_reference`, or the folder of a set, of the figure ``atlas`` that of an atlas; the
        published set by default.

    Returns
    -------
    matplotlib.figure.Figure, or tuple of Figure or Path
        The figure, several if there is one for each maneuver; the files if they are written.

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
        raise InputError("reference, maneuver: expected the folder of an atlas, and none")
    every = drawn(figure, maneuver, reference, None if path is None else str(path))
    if path is None:
        figures = tuple(_for_notebooks(one) for one, _ in every)
        return figures[0] if len(figures) == 1 else figures
    written: list[Path] = []
    for one, files in every:
        for file in files:
            save(one, file)
        written += files
    return tuple(written)


def drawn(
    figure: str, maneuver: int | None, reference: Any, output: str | None,
    formats: Sequence[str] | None = None, *, dashes: str = "",
) -> Iterator[tuple[Figure, list[Path]]]:  # fmt: skip
    """Each figure with its files; what does not do is refused before anything is drawn.

    Parameters
    ----------
    reference
        As `load_reference` takes it, or the folder of an atlas.
    output
        A folder, or the file of a single figure; None for no files.
    formats
        For a folder; None if they are not told.
    dashes
        See `plates`.
    """

    def files(names: Sequence[str]) -> list[list[Path]]:
        if output is None:
            return [[] for _ in names]
        hint = (", or --maneuver N" if dashes else ", or maneuver=N") if figure == DEFAULT else ""
        option = "--output" if dashes else "path"
        return paths_of(output, names, formats, option=option, hint=hint)

    if figure == ATLAS:
        (one,) = files([ATLAS])
        return iter([(addition("atlas_figure")(reference), one)])
    known = load_reference(reference)
    chosen = plates(known, figure, maneuver, dashes=dashes)
    every = files([plate.name for plate in chosen])
    return ((plate.draw(known), one) for plate, one in zip(chosen, every, strict=True))


def _for_notebooks(figure: Figure) -> Figure:
    """The figure, which a notebook shows although pyplot does not know it."""
    vars(figure)["_repr_png_"] = partial(render, figure, "png")
    return figure


def paths_of(
    output: str, names: Sequence[str], formats: Sequence[str] | None, *, option: str, hint: str
) -> list[list[Path]]:
    """Files to write of each figure.

    Parameters
    ----------
    output
        A folder, or the file of a single figure.
    names
        Of the figures.
    formats
        For a folder; None if they are not told.
    option, hint
        Name of the output in a message, and another way to a single figure.

    Raises
    ------
    InputError
        A file of another format, or for several figures.
    """
    out = Path(output)
    if out.is_dir() or not out.suffix or output.endswith("/"):
        chosen = dict.fromkeys(formats or DEFAULT_FORMATS)
        return [[out / f"{name}.{f}" for f in chosen] for name in names]
    if out.suffix.removeprefix(".").lower() not in FORMATS:
        raise InputError(
            f"{option}: found '{out.name}', expected a file ending in "
            f"{', '.join(f'.{f}' for f in FORMATS)}, or a folder (with a final / if it has a dot)"
        )
    if formats is not None:
        raise InputError("--format: expected only with a folder, a file's suffix is its format")
    if len(names) > 1:
        raise InputError(
            f"{option}: found the file '{out.name}' for {len(names)} figures, expected a "
            f"folder{hint}"
        )
    return [[out]]
