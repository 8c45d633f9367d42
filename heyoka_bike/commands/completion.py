"""Completion of words in a shell, written by shtab from the parser."""

import argparse
from collections.abc import Iterator
from typing import Any

from heyoka_bike.errors import Exit

SHELLS = ("bash", "zsh", "fish", "tcsh")
_FILES = ("FILE", "NAME|FILE", "FILE_OR_DIR", "FILE_OR_FOLDER")
_FOLDERS = ("DIR", "FOLDER")


class PrintCompletion(argparse.Action):
    """Prints what a shell reads to complete words of the command line, and ends."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: Any, values: Any, option: Any = None
    ) -> None:
        try:
            print(completion(parser, values))
        except ModuleNotFoundError:
            said = "shtab is not installed, expected it: pip install 'heyoka_bike[completion]'"
            parser.exit(Exit.INPUT, f"{parser.prog}: {said}\n")
        parser.exit(Exit.OK)


def completion(parser: argparse.ArgumentParser, shell: str) -> str:
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


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action._choices_actions:
                # A shell shows it beside the name.
                action.choices[command.dest].description = command.help
                yield from _actions(action.choices[command.dest])
