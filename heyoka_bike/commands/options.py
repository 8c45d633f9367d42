"""Commands as the command line takes them, their options, and the completion of both in a shell."""

import argparse
import os
import textwrap
from argparse import Action, ArgumentError, ArgumentParser, HelpFormatter, Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from string import Template
from typing import Any

from heyoka_bike.errors import Exit, unknown_word
from heyoka_bike.scoring.diagnosis.budget import DEFAULT_BUDGET

SHELLS = ("bash", "zsh", "fish", "tcsh")
_FILES = ("FILE", "NAME|FILE", "FILE_OR_DIR", "FILE_OR_FOLDER")
_FOLDERS = ("DIR", "FOLDER")


def add_command(
    subparsers: Any, run: Callable[[Namespace], int], said: str | None,
    arguments: Mapping[str, str] | None = None, **fields: str,
) -> ArgumentParser:  # fmt: skip
    """Add a command to the command line; it is called like the module of `run`.

    Parameters
    ----------
    arguments
        See `add_arguments`.
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
    add_arguments(parser, arguments or {})
    return parser


class _Paragraphs(HelpFormatter):
    """Folds paragraphs of prose; those that begin with a small letter keep their lines."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.split("\n\n")
        return "\n\n".join(p if p[:1].islower() else textwrap.fill(p, width) for p in paragraphs)


def add_arguments(parser: Any, said: Mapping[str, str], **settings: Mapping[str, object]) -> None:
    """Add arguments and options, in their order.

    Parameters
    ----------
    said
        The help of each by its usage. ``FILE`` is an argument, ``[FILE]`` one that may be missing,
        ``FILE...`` one or more. ``--force`` is a switch, ``-o --output FILE`` takes a text,
        ``--speeds LIST 0:10:1`` has a default, ``--require EXPR...`` may be repeated.
    settings
        Arguments of ``add_argument``, such as ``{"type": int}``, by the name of an option with
        underscores.
    """
    for usage, text in said.items():
        words = usage.split()
        flags = [word for word in words if word.startswith("-")]
        value, default, *_ = *words[len(flags) :], "", ""
        metavar = value.strip("[]").removesuffix("...")
        kind: dict[str, Any] = {"metavar": metavar} if metavar else {"action": "store_true"}
        if flags and value.endswith("..."):
            kind |= {"action": "append", "default": []}
        elif value.endswith(("...", "]")):
            kind["nargs"] = "?" if value.endswith("]") else "+"
        if default:
            kind["default"] = default
        names = flags or [metavar.lower()]
        kind |= settings.get(names[-1].strip("-").replace("-", "_"), {})
        parser.add_argument(*names, help=text, **kind)


FOLDER = {"[DIR]": "folder (default: the published set)"}
BICYCLE = {
    "--bicycle NAME|FILE benchmark": "a bicycle of the collection, or a TOML file (default: "
    "benchmark)"
}
COLUMNS = {
    "--columns NAMES": "what the columns of a file are, in its order, whatever their names there: "
    "time,roll_angle,m2_steer_angle,...; - for one that is left out",
    "--max-bytes N": "bytes that a packed file may unpack to (default: 500000000)",
}
BUDGET = {
    "--budget S": "processor time that the diagnosis may take [s]; then what was found until then "
    f"is said, with exit code 4 (default: {DEFAULT_BUDGET:g})",
    "--thorough": "try two mistakes at once also where a force is left that nothing explains",
}
REFERENCE = {"--reference DIR": "folder of a reference set (default: the published one)"}
"""Arguments that several commands have."""


def add_workers(parser: ArgumentParser) -> None:
    """Add ``--workers`` and ``--cluster``, which `using_workers` takes."""
    options = {
        "--workers N": "do the work in N processes of this machine (default: one for each "
        "processor)",
        "--cluster ADDRESS": "do the work on the workers of a running Dask scheduler, such as "
        "tcp://node7:8786, or of a scheduler file; needs heyoka_bike[cluster]",
    }
    add_arguments(parser.add_mutually_exclusive_group(), options, workers={"type": int})


def using_workers(args: Namespace) -> AbstractContextManager[None]:
    """For the time of a command, what was asked for by the options of `add_workers`."""
    workers, cluster = getattr(args, "workers", None), getattr(args, "cluster", None)
    if workers is None and cluster is None:
        return nullcontext()
    from heyoka_bike.system.parallel import using

    return using(workers, cluster=cluster)


def lists(parser: ArgumentParser, dest: str, words: Iterable[str]) -> None:
    """Let a shell complete the words of an option that takes several, or checks them itself."""
    (action,) = (x for x in parser._actions if x.dest == dest)
    vars(action)["words"] = tuple(words)


VERBOSE = {"-v --verbose": "say on standard error what is done; twice, why so"}
"""Which `telling` takes."""


def verbose_logging(args: Namespace) -> AbstractContextManager[None]:
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
    parser.add_argument(
        "--format", metavar="FORMAT", dest="formats", action=_Formats, nargs=nargs,
        help=f"one of {', '.join(formats)}; {said}",
    )  # fmt: skip
    lists(parser, "formats", formats)


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


class PrintCompletion(Action):
    """Prints what a shell reads to complete words of the command line, and ends."""

    def __call__(
        self, parser: ArgumentParser, namespace: Any, values: Any, option: Any = None
    ) -> None:
        try:
            print(completion(parser, values))
        except ModuleNotFoundError:
            said = "shtab is not installed, expected it: pip install 'heyoka_bike[completion]'"
            parser.exit(Exit.INPUT, f"{parser.prog}: {said}\n")
        parser.exit(Exit.OK)


def completion(parser: ArgumentParser, shell: str) -> str:
    """Return a completion script: commands, options and formats by name, files and folders.

    The parser is of no other use afterwards.
    """
    import shtab

    kinds = dict.fromkeys(_FILES, shtab.FILE) | dict.fromkeys(_FOLDERS, shtab.DIRECTORY)
    for action in _actions(parser):
        if (kind := kinds.get(str(action.metavar))) is not None:
            vars(action)["complete"] = kind
        action.choices = action.choices or getattr(action, "words", None)
    text: str = shtab.complete(parser, shell=shell)
    return text


def _actions(parser: ArgumentParser) -> Iterator[Action]:
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action._choices_actions:
                # A shell shows it beside the name.
                action.choices[command.dest].description = command.help
                yield from _actions(action.choices[command.dest])
