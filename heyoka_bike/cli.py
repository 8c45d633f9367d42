"""The command line: ``heyoka-bike`` and ``python -m heyoka_bike``.

Each command is a module, see `commands.registry`, with ``add_parser`` and ``run``; heavy imports
happen in ``run``, so that ``--help`` is quick.
"""

import argparse
import gc
import os
import sys
from collections.abc import Iterable, Sequence
from io import TextIOWrapper
from typing import Any, NoReturn

from heyoka_bike.commands import options
from heyoka_bike.commands.citation import Cite
from heyoka_bike.commands.registry import COMMANDS, GROUPS, command
from heyoka_bike.errors import BicycleError, Exit, InputError, did_you_mean, printable, unknown_word
from heyoka_bike.version import __version__

# These spread their work over threads themselves; those of the linear algebra would only spin.
_THREADED = ("score", "diagnose")

EXIT_CODES = {
    Exit.OK: "fine",
    Exit.INPUT: "usage, unreadable input or unwritable output",
    Exit.NOTHING_SCORED: "nothing could be scored",
    Exit.CHECK_FAILED: "a check failed",
    Exit.STOPPED_EARLY: "stopped early, the partial result kept and marked",
    Exit.INTERNAL: "internal error",
    Exit.INTERRUPTED: "interrupted",
}
ENVIRONMENT = {
    "CC": "the C compiler of 'bench'",
    "FORCE_COLOR": "if it is set, colours even where there is no terminal",
    "HEYOKA_BIKE_LOG": "info or debug: as -v or -vv of every command",
    "HEYOKA_BIKE_TRACEBACK": "if it is set, an internal error is shown with its traceback",
    "NO_COLOR": "if it is set, no colours",
    "OPENBLAS_NUM_THREADS": "threads of the linear algebra; 1 in 'score' and 'diagnose' if not set",
    "SOURCE_DATE_EPOCH": "time of reports [s since 1970], so that they can be made again",
}
"""Variables of the environment that the program reads."""

DESCRIPTION = """\
Reference solutions for the IFToMM benchmark "Uncontrolled bicycle".

three jobs:
  compare a result file with the exact motion
      heyoka-bike score my-results.txt
  keep its digits: exit code 3 if a requirement is not met
      heyoka-bike score my-results.txt --require 'scd >= 6'
  make the reference anew, with its proof
      heyoka-bike generate"""

WELCOME = """\
How many digits of your bicycle are right? To begin:

  heyoka-bike score my-results.txt       compare a result file with the exact motion
  heyoka-bike diagnose my-results.txt    say why it differs
  heyoka-bike animate my-results.txt     see your bicycle beside the exact one

What a result file is: heyoka-bike score --help. All commands: heyoka-bike --help."""
"""Of a call without words."""


def _epilog() -> str:
    codes = "".join(f"  {code:<3} {said}\n" for code, said in EXIT_CODES.items())
    variables = "".join(f"  {name:<21} {said}\n" for name, said in ENVIRONMENT.items())
    return f"exit codes:\n{codes}\nenvironment:\n{variables}"


class _Grouped(argparse.RawDescriptionHelpFormatter):
    """Lists the commands in their groups, each with its example."""

    def _format_action(self, action: argparse.Action) -> str:
        if not isinstance(action, argparse._SubParsersAction):
            return super()._format_action(action)
        known = {command.dest: command for command in action._get_subactions()}
        parts = []
        for group in GROUPS:
            commands = [known[name] for name in group.commands if name in known]
            if commands:
                space = " " * self._current_indent
                parts.append(f"{space}{group.title}, for example: {group.example}\n")
                self._indent()
                parts += [self._format_action(command) for command in commands]
                self._dedent()
                parts.append("\n")
        return self._join_parts(parts)


class _CommandParser(argparse.ArgumentParser):
    """argparse, with one line and exit code 1 for a usage error, and what may have been meant."""

    given: Sequence[str] = ()

    def error(self, message: str) -> NoReturn:
        said = message.removeprefix("argument ")
        like_options = [x for x in self.given if x.startswith("-") and os.path.isfile(x)]
        if like_options:
            said += f"; {printable(like_options[0])} is a file: write -- before it"
        self.exit(Exit.INPUT, f"{self.prog}: {said} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        self.given = sys.argv[1:] if args is None else args
        found, rest = super().parse_known_args(args, namespace)
        if rest:
            # Said by the command that does not know it, not by the program.
            option = next((word.partition("=")[0] for word in rest if word.startswith("--")), "")
            hint = did_you_mean(option, self._option_string_actions) if option else ""
            self.error(f"unrecognized arguments: {' '.join(map(printable, rest))}{hint}")
        return found, rest

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            message = unknown_word(str(value), list(action.choices))
            raise argparse.ArgumentError(action, message)


def parser(commands: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """The parser of the command line, of all commands or of some."""
    top = _CommandParser(
        prog="heyoka-bike",
        description=DESCRIPTION,
        epilog=_epilog(),
        formatter_class=_Grouped,
    )
    top.add_argument("--version", action="version", version=f"heyoka-bike {__version__}")
    top.add_argument("--cite", action=Cite, help="show how to cite the program and its data")
    top.add_argument(
        "--print-completion",
        action=options.PrintCompletion,
        metavar="SHELL",
        choices=options.SHELLS,
        help=f"print what completes words in a shell: {', '.join(options.SHELLS)}; needs shtab",
    )
    subparsers = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name in commands:
        command(name).add_parser(subparsers)
        counted = {"action": "count", "default": 0}
        options.add_arguments(subparsers.choices[name], options.VERBOSE, verbose=counted)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    if argv is None:
        _prepare(words)
    if not words:
        return _greet()
    # If a command is named, the others need not be imported.
    asked = [word for word in words[:1] if word in COMMANDS]
    top = parser(asked or COMMANDS)
    try:
        try:
            arguments = top.parse_args(words, argparse.Namespace(words=words))
        except SystemExit:
            if sys.stdout is not None:
                sys.stdout.flush()
            raise
    except BrokenPipeError:
        return _unread()
    try:
        return _carry_out(arguments)
    except SystemExit:
        # Only rich raises it here: when the reader of our output went away.
        return Exit.OK
    except BrokenPipeError:
        return _unread()
    except (Exception, KeyboardInterrupt) as e:
        code, message = _stopped_by(e)
        if code == Exit.INTERNAL and os.environ.get("HEYOKA_BIKE_TRACEBACK"):
            raise
        print(f"heyoka-bike: {' '.join(message.split())}", file=sys.stderr)
        return code


def _greet() -> Exit:
    try:
        print(WELCOME, flush=True)
    except BrokenPipeError:
        return _unread()
    return Exit.OK


def _prepare(words: Sequence[str]) -> None:
    """Settings of a process that runs the program and nothing else."""
    if isinstance(sys.stdout, TextIOWrapper):
        # A file's name may have letters that a code page does not.
        sys.stdout.reconfigure(errors="backslashreplace")
    # Nothing of what is imported is garbage: looking for it takes a thirtieth of a score.
    gc.set_threshold(50_000)
    if words[:1] and words[0] in _THREADED:
        # Read when NumPy is imported.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _carry_out(arguments: argparse.Namespace) -> int:
    if sys.stdout is None:
        raise InputError("standard output is closed")
    with options.verbose_logging(arguments), options.using_workers(arguments):
        code: int = arguments.run(arguments)
    sys.stdout.flush()
    return code


def _stopped_by(e: BaseException) -> tuple[Exit, str]:
    """Exit code, and the line that says what stopped a command."""
    match e:
        case BicycleError():
            return e.exit_code, str(e)
        case KeyboardInterrupt():
            return Exit.INTERRUPTED, "interrupted"
        case ModuleNotFoundError():
            message = f"the package '{e.name}' is not installed, expected it with heyoka_bike"
            return Exit.INPUT, message
        case OSError():
            place = e.filename or "standard output"
            return Exit.INPUT, f"{place}: cannot be written: {e.strerror or e}"
        case MemoryError():
            return Exit.INTERNAL, "out of memory"
    where = "".join(f", {note}" for note in getattr(e, "__notes__", ()))
    said = f"internal error: {type(e).__name__}: {e}{where}"
    return Exit.INTERNAL, f"{said} (set HEYOKA_BIKE_TRACEBACK=1 for details)"


def _unread() -> Exit:
    """The reader of our output went away (head, less): not an error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return Exit.OK
