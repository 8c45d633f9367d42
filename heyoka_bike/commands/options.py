"""Commands as the command line takes them, and the options that several of them have."""

import os
import textwrap
from argparse import Action, ArgumentError, ArgumentParser, HelpFormatter, Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from string import Template
from typing import Any

from heyoka_bike.errors import unknown_word


def add_command(
    subparsers: Any, run: Callable[[Namespace], int], said: str | None, **fields: str
) -> ArgumentParser:
    """Add a command to the command line; it is called like the module of `run`.

    Parameters
    ----------
    said
        Docstring of that module. The summary is the command's line in the list of commands; the
        paragraphs after it stand above the options, those from the first on that begins with a
        small letter (``examples: ...``) below them.
    fields
        What ``$name`` stands for in it.
    """
    summary, _, text = Template(said or "").safe_substitute(fields).strip().partition("\n\n")
    paragraphs = text.split("\n\n")
    below = next((i for i, p in enumerate(paragraphs) if p[:1].islower()), len(paragraphs))
    parser: ArgumentParser = subparsers.add_parser(
        run.__module__.rpartition(".")[2],
        help=summary[:1].lower() + summary[1:].rstrip("."),
        description="\n\n".join(paragraphs[:below]),
        epilog="\n\n".join(paragraphs[below:]),
        formatter_class=_Paragraphs,
    )
    parser.set_defaults(run=run)
    return parser


class _Paragraphs(HelpFormatter):
    """Folds paragraphs of prose; those that begin with a small letter keep their lines."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.split("\n\n")
        return "\n\n".join(p if p[:1].islower() else textwrap.fill(p, width) for p in paragraphs)


def add_options(parser: Any, said: Mapping[str, str], **settings: Mapping[str, object]) -> None:
    """Add options, in their order.

    Parameters
    ----------
    said
        The help of each by its usage: ``--force`` is a switch, ``--until WHEN`` takes a text.
    settings
        Arguments of ``add_argument``, such as ``{"type": int}``, by the name of an option with
        underscores.
    """
    for usage, text in said.items():
        option, _, metavar = usage.partition(" ")
        kind: dict[str, Any] = {"metavar": metavar} if metavar else {"action": "store_true"}
        kind |= settings.get(option.strip("-").replace("-", "_"), {})
        parser.add_argument(option, help=text, **kind)


def add_reference(parser: ArgumentParser, of: str = "") -> None:
    """Add ``--reference``."""
    said = f"folder of a reference set{of} (default: the published one)"
    add_options(parser, {"--reference DIR": said})


def add_folder(parser: ArgumentParser) -> None:
    """Add the folder of a reference set as an argument."""
    said = "folder (default: the published set)"
    parser.add_argument("folder", nargs="?", metavar="DIR", help=said)


def add_bicycle(parser: ArgumentParser) -> None:
    """Add ``--bicycle``."""
    said = "a bicycle of the collection, or a TOML file (default: benchmark)"
    add_options(parser, {"--bicycle NAME|FILE": said}, bicycle={"default": "benchmark"})


def add_workers(parser: ArgumentParser) -> None:
    """Add ``--workers`` and ``--cluster``, which `using_workers` takes."""
    options = {
        "--workers N": "do the work in N processes of this machine (default: one for each "
        "processor)",
        "--cluster ADDRESS": "do the work on the workers of a running Dask scheduler, such as "
        "tcp://node7:8786, or of a scheduler file; needs heyoka_bike[cluster]",
    }
    add_options(parser.add_mutually_exclusive_group(), options, workers={"type": int})


def using_workers(args: Namespace) -> AbstractContextManager[None]:
    """For the time of a command, what was asked for by the options of `add_workers`."""
    workers, cluster = getattr(args, "workers", None), getattr(args, "cluster", None)
    if workers is None and cluster is None:
        return nullcontext()
    from heyoka_bike.system.parallel import using

    return using(workers, cluster=cluster)


def lists(action: Action, words: Iterable[str]) -> None:
    """Let a shell complete the words of an option that takes several, or checks them itself."""
    vars(action)["words"] = tuple(words)


def add_verbose(parser: ArgumentParser) -> None:
    """Add ``--verbose``, which `telling` takes."""
    said = "say on standard error what is done; twice, why so"
    parser.add_argument("-v", "--verbose", action="count", default=0, help=said)


def telling(args: Namespace) -> AbstractContextManager[None]:
    """For the time of a command, what ``--verbose`` or ``HEYOKA_BIKE_LOG`` asks for."""
    asked = ("info", "debug")[min(args.verbose, 2) - 1] if args.verbose else ""
    level = asked or os.environ.get("HEYOKA_BIKE_LOG", "")
    if not level:
        return nullcontext()
    from heyoka_bike.system.log import shown

    return shown(level)


def add_format(parser: Any, formats: Sequence[str], said: str | None = None) -> None:
    """Add ``--format``.

    Parameters
    ----------
    said
        About the format if none is asked for, where that depends on something else; by default it
        is the first one.
    """
    default = formats[0] if said is None else None
    about = f"default {default}" if said is None else said
    text = f"one of {', '.join(formats)}{f' ({about})' if about else ''}"
    parser.add_argument("--format", metavar="FORMAT", choices=formats, default=default, help=text)


def add_formats(
    parser: ArgumentParser, formats: Sequence[str], said: str, *, nargs: str | None = None
) -> None:
    """Add ``--format`` for several, as ``formats``."""
    action = parser.add_argument(
        "--format", metavar="FORMAT", dest="formats", action=_Formats, nargs=nargs,
        help=f"one of {', '.join(formats)}; {said}",
    )  # fmt: skip
    lists(action, formats)


class _Formats(Action):
    """Takes formats, separated by commas or not, as often as they are given."""

    words: tuple[str, ...]

    def __call__(
        self, parser: ArgumentParser, namespace: Namespace, values: Any, option: Any = None
    ) -> None:
        given = [values] if isinstance(values, str) else values
        found = [word for value in given for word in value.split(",")]
        for word in found:
            if word not in self.words:
                raise ArgumentError(self, unknown_word(word, self.words))
        setattr(namespace, self.dest, [*(getattr(namespace, self.dest) or ()), *found])


def add_output(parser: ArgumentParser, said: str, **options: Any) -> None:
    """Add ``-o`` and ``--output``, a file unless another ``metavar`` is given."""
    parser.add_argument("-o", "--output", help=said, **{"metavar": "FILE"} | options)
