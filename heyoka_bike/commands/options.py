"""Define commands and options of the command line, and their completion in a shell."""

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
    """Add a command to the command line. Its name is that of the module of `run`.

    Parameters
    ----------
    arguments
        See `add_arguments`.
    said
        Docstring of that module. Its summary is the command's line in the list of commands. The
        paragraphs after the summary are printed above the options. From the first paragraph that
        begins with a small letter (``examples: ...``), they are printed below the options.
    fields
        Texts that replace ``$name`` in the docstring.
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
    """Help formatter that wraps paragraphs, except those that begin with a small letter."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.split("\n\n")
        return "\n\n".join(p if p[:1].islower() else textwrap.fill(p, width) for p in paragraphs)


def add_arguments(parser: Any, said: Mapping[str, str], **settings: Mapping[str, object]) -> None:
    """Add arguments and options to a parser, in the order of their help texts.

    Parameters
    ----------
    said
        Help text of each argument by its usage. ``FILE`` is a required argument, ``[FILE]`` an
        optional one, ``FILE...`` one or more. ``--force`` is a switch, ``-o --output FILE`` takes
        a text, ``--speeds LIST 0:10:1`` has a default, ``--require EXPR...`` may be repeated.
    settings
        Further arguments of ``add_argument``, such as ``{"type": int}``, by the option's name
        without leading dashes and with underscores.
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


FOLDER = {"[DIR]": "folder of the dataset (default: the published dataset)"}
BICYCLE = {
    "--bicycle NAME|FILE benchmark": "name of a bundled bicycle, or a TOML file (default: "
    "benchmark)"
}
COLUMNS = {
    "--columns NAMES": "names of the columns in the order of the file; they override its header: "
    "time,roll_angle,m2_steer_angle,...; use - to skip a column",
    "--max-bytes N": "largest size that a compressed file may expand to [bytes] (default: "
    "500000000)",
}
BUDGET = {
    "--budget S": "limit of the diagnosis in processor time [s] (default: "
    f"{DEFAULT_BUDGET:g}); at the limit the causes found so far are reported, with exit code 4",
    "--thorough": "also try pairs of mistakes if the file shows a force that no single mistake "
    "explains",
}
REFERENCE = {"--reference DIR": "folder of a reference dataset (default: the published one)"}
"""Arguments that several commands have."""


def add_workers(parser: ArgumentParser) -> None:
    """Add ``--workers`` and ``--cluster``, which `using_workers` applies."""
    options = {
        "--workers N": "use N processes of this machine (default: one for each processor)",
        "--cluster ADDRESS": "use the workers of a running Dask scheduler instead: its address, "
        "such as tcp://node7:8786, or its scheduler file; needs heyoka_bike[cluster]",
    }
    add_arguments(parser.add_mutually_exclusive_group(), options, workers={"type": int})


def using_workers(args: Namespace) -> AbstractContextManager[None]:
    """Return a context that uses the processes that the options of `add_workers` request."""
    workers, cluster = getattr(args, "workers", None), getattr(args, "cluster", None)
    if workers is None and cluster is None:
        return nullcontext()
    from heyoka_bike.system.parallel import using

    return using(workers, cluster=cluster)


def lists(parser: ArgumentParser, dest: str, words: Iterable[str]) -> None:
    """Let a shell complete an option with these words, if it has no ``choices`` of argparse."""
    (action,) = (x for x in parser._actions if x.dest == dest)
    vars(action)["words"] = tuple(words)


VERBOSE = {"-v --verbose": "log progress to standard error; -vv also logs the reasons"}
"""Option of every command, which `verbose_logging` applies."""


def verbose_logging(args: Namespace) -> AbstractContextManager[None]:
    """Return a context that logs at the level of ``--verbose`` or ``HEYOKA_BIKE_LOG``."""
    asked = ("info", "debug")[min(args.verbose, 2) - 1] if args.verbose else ""
    level = asked or os.environ.get("HEYOKA_BIKE_LOG", "")
    if not level:
        return nullcontext()
    from heyoka_bike.system.log import shown

    return shown(level)


def add_format(parser: Any, formats: Sequence[str], said: str | None = None) -> None:
    """Add the option ``--format`` to a parser.

    Parameters
    ----------
    said
        Text about the default. If it is given, the option itself has no default; otherwise the
        default is the first format.
    """
    default = formats[0] if said is None else None
    about = f"default {default}" if said is None else said
    text = f"one of {', '.join(formats)}{f' ({about})' if about else ''}"
    parser.add_argument("--format", metavar="FORMAT", choices=formats, default=default, help=text)


def add_formats(
    parser: ArgumentParser, formats: Sequence[str], said: str, *, nargs: str | None = None
) -> None:
    """Add a ``--format`` that accepts several formats; its attribute is named ``formats``."""
    parser.add_argument(
        "--format", metavar="FORMAT", dest="formats", action=_Formats, nargs=nargs,
        help=f"one of {', '.join(formats)}; {said}",
    )  # fmt: skip
    lists(parser, "formats", formats)


class _Formats(Action):
    """Action that collects formats, which are separated by commas or in repeated options."""

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
    """Action that prints a script for completion in a shell, and exits."""

    def __call__(
        self, parser: ArgumentParser, namespace: Any, values: Any, option: Any = None
    ) -> None:
        try:
            print(completion(parser, values))
        except ModuleNotFoundError:
            said = "the package 'shtab' is not installed: pip install 'heyoka_bike[completion]'"
            parser.exit(Exit.INPUT, f"{parser.prog}: {said}\n")
        parser.exit(Exit.OK)


def completion(parser: ArgumentParser, shell: str) -> str:
    """Return a script that completes commands, options, formats, files and folders.

    The parser cannot be used for anything else afterwards, because its actions are changed.
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
                # shtab shows a command's description next to its name, so make that the short help.
                action.choices[command.dest].description = command.help
                yield from _actions(action.choices[command.dest])
