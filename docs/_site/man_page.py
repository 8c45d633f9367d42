"""The manual page, docs/reference/heyoka-bike.1, from the parser of the command line.

Run as a script, this writes it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from textwrap import wrap

from heyoka_bike.cli import ENVIRONMENT, EXIT_CODES, parser
from heyoka_bike.version import __version__

PAGE = Path(__file__).parent.parent / "reference" / "heyoka-bike.1"


def page() -> str:
    """The page in the language of man."""
    top = parser()
    return "\n".join([
        f'.TH HEYOKA-BIKE 1 "" "heyoka_bike {__version__}" "User Commands"',
        ".SH NAME", _text("heyoka-bike - exact motions of the benchmark Uncontrolled bicycle"),
        ".SH SYNOPSIS", ".B heyoka-bike", r"[\fB\-\-help\fR] \fICOMMAND\fR ...",
        ".SH DESCRIPTION", *_description(top),
        ".SH OPTIONS", *_options(top),
        ".SH COMMANDS", *_commands(top),
        ".SH EXIT STATUS", *_table({str(int(code)): said for code, said in EXIT_CODES.items()}),
        ".SH ENVIRONMENT", *_table(ENVIRONMENT),
        "",
    ])  # fmt: skip


def _description(top: argparse.ArgumentParser) -> Iterator[str]:
    said, *lists = (top.description or "").split("\n\n")
    yield _text(said)
    for lines in lists:
        yield from (".PP", ".nf", _text(lines, fold=False), ".fi")


def _commands(top: argparse.ArgumentParser) -> Iterator[str]:
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield f".SS {_plain(name)}"
                yield _text(command.description or "")
                # --help is said once.
                yield from _options(command, but=("-h",))
                if command.epilog:
                    yield from (".PP", ".nf", _text(command.epilog, fold=False), ".fi")


def _options(command: argparse.ArgumentParser, but: tuple[str, ...] = ()) -> Iterator[str]:
    for action in command._actions:
        if isinstance(action, argparse._SubParsersAction) or {*but} & {*action.option_strings}:
            continue
        names = ", ".join(rf"\fB{_plain(name)}\fR" for name in action.option_strings)
        value = "" if action.nargs == 0 else str(action.metavar or action.dest.upper())
        if isinstance(action.metavar, tuple):
            value = " ".join(action.metavar)
        elif action.metavar is None and action.choices is not None and action.option_strings:
            value = "{" + ",".join(map(str, action.choices)) + "}"
        more = " ..." if action.nargs in ("*", "+") else ""
        said = (action.help or "") % {**vars(action), "prog": command.prog}
        both = " ".join(x for x in (names, rf"\fI{_plain(value)}\fR{more}" if value else "") if x)
        yield from (".TP", both, _text(said))


def _table(lines: dict[str, str]) -> Iterator[str]:
    for name, said in lines.items():
        yield from (".TP", f".B {_plain(name)}", _text(said))


def _text(text: str, *, fold: bool = True) -> str:
    """Text, in which no line is taken for a request."""
    lines = wrap(text, 70, break_on_hyphens=False) if fold else text.splitlines()
    return "\n".join(_plain(line) if line.strip() else ".sp" for line in lines)


def _plain(text: str) -> str:
    escaped = text.replace("\\", r"\e").replace("-", r"\-").replace("^", r"\(ha")
    return rf"\&{escaped}" if escaped.startswith((".", "'")) else escaped


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
