"""The table of findings in docs/reference/findings.md: codes, severities and what was seen.

A function of `heyoka_bike.showing.sayings`, or of `causes` there, for each class of evidence has
the code. Run as a script, this writes the table.
"""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from heyoka_bike.scoring import evidence
from heyoka_bike.scoring.diagnosis import found
from heyoka_bike.showing import causes, sayings
from marked_parts import filled

PAGE = Path(__file__).parent.parent / "reference" / "findings.md"
_SEVERITIES = ("info", "warning")


class Code(NamedTuple):
    """A code, its severity, and the keys of its numbers in JSON that are its own."""

    code: str
    severity: str
    keys: tuple[str, ...]


def _codes(function: ast.FunctionDef) -> Iterator[Code]:
    """The findings that a function makes."""
    for call in ast.walk(function):
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") in _SEVERITIES:
            keys = tuple(keyword.arg for keyword in call.keywords if keyword.arg)
            yield Code(ast.literal_eval(call.args[0]), call.func.id, keys)


def findings() -> dict[str, list[Code]]:
    """The codes of each class of evidence, in the order of its module."""
    every = {}
    for said, classes in ((sayings, evidence), (causes, found)):
        codes_of = {}
        for function in ast.parse(inspect.getsource(said)).body:
            if isinstance(function, ast.FunctionDef) and (codes := dict.fromkeys(_codes(function))):
                seen = ast.unparse(function.args.args[0].annotation).removeprefix("seen.")
                codes_of[seen] = [*codes]
        every |= {name: codes_of[name] for name in vars(classes) if name in codes_of}
    return every


def _line(name: str, code: Code) -> str:
    about = inspect.getdoc(getattr(evidence, name, None) or getattr(found, name)).partition("\n\n")
    keys = ", ".join(f"`{key}`" for key in code.keys)
    return f"| `{code.code}` | {code.severity} | {' '.join(about[0].split())} | {keys} |"


def table() -> str:
    """The table in Markdown."""
    lines = (_line(name, code) for name, codes in findings().items() for code in codes)
    head = ["| code | severity | what was seen | in JSON |", "|---|---|---|---|"]
    return "\n".join([*head, *lines])


def page(text: str) -> str:
    """The page with its table made anew."""
    return filled(text, "findings", table())


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
