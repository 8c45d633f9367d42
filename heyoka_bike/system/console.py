"""Progress bars on a terminal, and a notice while something takes long.

rich draws them; it is imported on first use.
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
    """Return whether text may be coloured; see ``NO_COLOR`` (https://no-color.org).

    Parameters
    ----------
    is_terminal
        True if the text goes to a terminal, which decides if neither ``NO_COLOR`` nor
        ``FORCE_COLOR`` is set.
    """
    if os.environ.get("NO_COLOR"):
        return False
    return is_terminal or bool(os.environ.get("FORCE_COLOR"))


def patience(doing: str) -> AbstractContextManager[Any]:
    """Show a notice on the terminal while something takes long."""
    if not sys.stderr.isatty():
        return nullcontext()
    from rich.console import Console

    return Console(stderr=True).status(doing)


@contextmanager
def notice_if_slow(seconds: float, said: str) -> Iterator[None]:
    """Print a line on standard error if the block takes longer than this."""
    timer = Timer(seconds, lambda: print(said, file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@contextmanager
def progress_bar(doing: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on a terminal until the block ends; yield a function that sets its progress."""
    with _progress(transient=True) as bars:
        bar = bars.add_task(doing, total=1.0)
        yield lambda done: bars.update(bar, completed=done)


@contextmanager
def stage_bar() -> Iterator[Callable[[str, float], None]]:
    """Show a permanent bar; yield a function that sets its stage and completed fraction.

    The bar is drawn only during calls, because a drawing thread would disturb timings.
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
    """Show a bar for each motion on a terminal, from its first report on.

    Parameters
    ----------
    shares
        Fraction of the work by stage; stages may run at the same time.
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
    """Return progress bars on standard error, which are drawn only on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Versions of rich before 15 write an empty line even if they draw no bars.
    console.quiet = not console.is_terminal
    return Progress(*view, console=console, disable=console.quiet, **options)
