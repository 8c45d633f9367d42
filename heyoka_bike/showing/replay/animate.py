"""The replay in Python, as the command ``animate`` makes it: to look at, or as a file."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.reading.source import ARRAY, results_of
from heyoka_bike.showing.replay import check_suffix, page
from heyoka_bike.showing.replay.scenes import Replay, replay
from heyoka_bike.system.files import refuse_overwriting, write_output

_HEIGHT = 720  # of the page in a notebook [px]


@dataclass(frozen=True, repr=False, slots=True)
class Page:
    """A replay that a notebook shows; ``page.save("replay.html")`` writes it.

    Attributes
    ----------
    html
        The whole page.
    """

    html: str

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the page to a file, whole or not at all."""
        write_output(Path(path), self.html.encode())
        return Path(path)

    def __repr__(self) -> str:
        return f"<replay of {len(self.html) / 1e6:.1f} MB, for a notebook or .save(...)>"

    def _repr_html_(self) -> str:
        # In a frame of its own, where its script sees nothing of the notebook.
        return (
            f'<iframe sandbox="allow-scripts" srcdoc="{escape(self.html)}" title="replay" '
            f'style="width: 100%; height: {_HEIGHT}px; border: 0"></iframe>'
        )


def animate(
    results: Any = None,
    path: str | PathLike[str] | None = None,
    *,
    maneuver: int | None = None,
    reference: Reference | str | PathLike[str] | None = None,
    **named: Any,
) -> Page | Path:
    """Replay the maneuvers in 3D, results beside the reference.

    Parameters
    ----------
    results
        Results as `score` takes them; without any the reference is shown alone.
    path
        The file to write, .html; by default nothing is written.
    maneuver
        Show this one, which results of one maneuver then hold; by default all.
    reference
        From `load_reference`, or the folder of a set; the published one by default.
    named
        Columns by name, as in `score`.

    Returns
    -------
    Page or Path
        The page for a notebook, or the file that is written.

    Raises
    ------
    InputError, NothingScoredError
        See `score`; or a path of another format, or that cannot be written.
    """
    known = load_reference(reference)
    if path is not None:
        check_suffix(Path(path))
    if maneuver is not None and maneuver not in known:
        raise InputError(f"found maneuver {maneuver!r:.40}, expected 1 to {len(known)}")
    given = None
    if results is not None or named:
        given = results_of(results, len(known), maneuver=maneuver, named=named, is_only=False)
    if path is not None:
        refuse_overwriting([r.path for r in given or ()], [Path(path)])
    found = replay(known, given, maneuver)
    shown = Page(page.render(found, _name(found)))
    return shown if path is None else shown.save(path)


def _name(found: Replay) -> str:
    if found.report is None:
        return ""
    return "results" if found.report.file.path == ARRAY else found.report.file.path
