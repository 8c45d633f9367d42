"""Progress bars of a terminal, and a word while something takes long.

rich draws them, and is imported when there is something to draw.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from threading import Timer
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

    from heyoka_bike.system import parallel


def has_colors(is_terminal: bool) -> bool:
    """True if text may be coloured, by ``NO_COLOR`` (https://no-color.org) or ``FORCE_COLOR``.

    Parameters
    ----------
    is_terminal
        True if it goes to one, which decides if neither is set.
    """
    if os.environ.get("NO_COLOR"):
        return False
    return is_terminal or bool(os.environ.get("FORCE_COLOR"))


def patience(doing: str) -> AbstractContextManager[Any]:
    """A word on the terminal while something takes long."""
    if not sys.stderr.isatty():
        return nullcontext()
    from rich.console import Console

    return Console(stderr=True).status(doing)


@contextmanager
def told_after(seconds: float, said: str) -> Iterator[None]:
    """A line on standard error if something that others decide on takes so long."""
    timer = Timer(seconds, lambda: print(said, file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@contextmanager
def progress_bar(doing: str) -> Iterator[Callable[[float], None]]:
    """A bar on a terminal until the work ends; to be called with the part that is done, 0 to 1."""
    with _progress(transient=True) as bars:
        bar = bars.add_task(doing, total=1.0)
        yield lambda done: bars.update(bar, completed=done)


@contextmanager
def stage_bar() -> Iterator[Callable[[str, float], None]]:
    """A bar that stays; to be called with what is done now, and the part of all that is done.

    It is drawn only then: a thread that draws at its own times would disturb a timing.
    """
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

    view = (
        TextColumn("{task.description:<38}"), BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"), TimeElapsedColumn(),
    )  # fmt: skip
    with _progress(*view, auto_refresh=False) as bars:
        bar = bars.add_task("", total=1.0)
        yield lambda doing, done: bars.update(bar, description=doing, completed=done, refresh=True)


@contextmanager
def progress_bars(shares: Mapping[str, float]) -> Iterator[parallel.Progress]:
    """A bar for each motion on a terminal, from the first word of it.

    Parameters
    ----------
    shares
        Of the work, by stage; stages may go on side by side.
    """
    from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn

    from heyoka_bike.system.parallel import WAITING

    view = (
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[stage]:>9}"),
        TextColumn("{task.percentage:>3.0f} %"), TimeElapsedColumn(),
    )  # fmt: skip
    bars = _progress(*view)
    tasks: dict[str, TaskID] = {}
    done: dict[str, dict[str, float]] = {}

    def progress(name: str, stage: str, share: float) -> None:
        if name not in tasks:
            bars.start()
            tasks[name] = bars.add_task(name, total=sum(shares.values()), stage=stage)
            done[name] = {WAITING: 0.0}
        done[name][stage] = shares.get(stage, 0.0) * share
        bars.update(tasks[name], completed=sum(done[name].values()), stage=stage)

    try:
        yield progress
    finally:
        bars.stop()


def _progress(*view: ProgressColumn, **options: Any) -> Progress:
    """Bars on standard error; nothing when that is not a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Of bars that are not drawn rich before version 15 writes an empty line all the same.
    console.quiet = not console.is_terminal
    return Progress(*view, console=console, disable=console.quiet, **options)
