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

# These commands run their own threads, so further threads of the linear algebra library would only
# compete with them for the processors.
_THREADED = ("score", "diagnose")

EXIT_CODES = {
    Exit.OK: "success",
    Exit.INPUT: "usage error, unreadable input or unwritable output",
    Exit.NOTHING_SCORED: "nothing could be scored",
    Exit.CHECK_FAILED: "a check failed",
    Exit.STOPPED_EARLY: "stopped early; the result is partial and marked as such",
    Exit.INTERNAL: "internal error",
    Exit.INTERRUPTED: "interrupted",
}
ENVIRONMENT = {
    "CC": "C compiler that 'bench' uses",
    "FORCE_COLOR": "if set, use colours even if the output is not a terminal",
    "HEYOKA_BIKE_LOG": "info or debug: the same as -v or -vv, for every command",
    "HEYOKA_BIKE_TRACEBACK": "if set, print the traceback of an internal error",
    "NO_COLOR": "if set, use no colours",
    "OPENBLAS_NUM_THREADS": "threads of the linear algebra (default in 'score', 'diagnose': 1)",
    "SOURCE_DATE_EPOCH": "time stamp of reports [s since 1970], to reproduce them exactly",
}
"""Environment variables that the program reads."""

DESCRIPTION = """\
Reference solutions for the IFToMM benchmark "Uncontrolled bicycle".

three jobs:
  compare a result file with the exact motion
      heyoka-bike score my-results.txt
  require correct digits: exit code 3 if there are fewer
      heyoka-bike score my-results.txt --require 'scd >= 6'
  compute the reference again, with its proof
      heyoka-bike generate"""

WELCOME = """\
How many digits of your results are right? To begin:

  heyoka-bike score my-results.txt       compare a result file with the exact motion
  heyoka-bike diagnose my-results.txt    find out why it differs
  heyoka-bike animate my-results.txt     see your bicycle next to the exact one

Form of a result file: heyoka-bike score --help. All commands: heyoka-bike --help."""
"""Printed if the program is called without arguments."""


def _epilog() -> str:
    codes = "".join(f"  {code:<3} {said}\n" for code, said in EXIT_CODES.items())
    variables = "".join(f"  {name:<21} {said}\n" for name, said in ENVIRONMENT.items())
    return f"exit codes:\n{codes}\nenvironment:\n{variables}"


class _Grouped(argparse.RawDescriptionHelpFormatter):
    """Help formatter that lists the commands in groups, each group with an example."""

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
    """Argument parser that reports a usage error in one line, with a suggestion, as exit code 1."""

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
            # Report the error here, so that the message names the command, not only the program.
            option = next((word.partition("=")[0] for word in rest if word.startswith("--")), "")
            hint = did_you_mean(option, self._option_string_actions) if option else ""
            self.error(f"unrecognized arguments: {' '.join(map(printable, rest))}{hint}")
        return found, rest

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            message = unknown_word(str(value), list(action.choices))
            raise argparse.ArgumentError(action, message)


def parser(commands: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """Return the parser of the command line for all commands, or for the given ones."""
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
        help="print a script that lets a shell complete commands and options; one of "
        f"{', '.join(options.SHELLS)}; needs shtab",
    )
    subparsers = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name in commands:
        command(name).add_parser(subparsers)
        counted = {"action": "count", "default": 0}
        options.add_arguments(subparsers.choices[name], options.VERBOSE, verbose=counted)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    if argv is None:
        _prepare(words)
    if not words:
        return _greet()
    # If the first word is a command, import only its module.
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
        # Only rich raises SystemExit here, when the reader of our output has closed the pipe.
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
    """Configure the process, which runs only this program."""
    if isinstance(sys.stdout, TextIOWrapper):
        # Printed names of files may contain characters that the terminal's encoding lacks.
        sys.stdout.reconfigure(errors="backslashreplace")
    # Collect garbage less often: imported modules are never garbage, and searching for garbage
    # among them took 1/30 of the time of `score`.
    gc.set_threshold(50_000)
    if words[:1] and words[0] in _THREADED:
        # NumPy reads this variable when it is imported.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _carry_out(arguments: argparse.Namespace) -> int:
    if sys.stdout is None:
        raise InputError("standard output is closed")
    with options.verbose_logging(arguments), options.using_workers(arguments):
        code: int = arguments.run(arguments)
    sys.stdout.flush()
    return code


def _stopped_by(e: BaseException) -> tuple[Exit, str]:
    """Return the exit code and the error message for an exception that ended a command."""
    match e:
        case BicycleError():
            return e.exit_code, str(e)
        case KeyboardInterrupt():
            return Exit.INTERRUPTED, "interrupted"
        case ModuleNotFoundError():
            message = f"the package '{e.name}' is not installed, although heyoka_bike needs it"
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
    """Discard further output: its reader (head, less) has ended, which is no error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return Exit.OK
