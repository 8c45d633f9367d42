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


def _codes(function: ast.FunctionDef, module: ast.Module) -> Iterator[Code]:
    """The findings that a function makes."""
    for call in ast.walk(function):
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") in _SEVERITIES:
            keys = dict.fromkeys(x for k in call.keywords for x in _keys(k, function, module))
            yield Code(ast.literal_eval(call.args[0]), call.func.id, tuple(keys))


def _keys(passed: ast.keyword, function: ast.FunctionDef, module: ast.Module) -> Iterator[str]:
    """The key that is passed, or those of a dictionary: by its name there, or by who makes it."""
    if passed.arg:
        yield passed.arg
    elif isinstance(passed.value, ast.Name):
        for x in ast.walk(function):
            if isinstance(x, ast.Assign | ast.AnnAssign):
                targets = x.targets if isinstance(x, ast.Assign) else [x.target]
                if passed.value.id in map(ast.unparse, targets):
                    yield from _literal_keys(x.value)
    elif isinstance(passed.value, ast.Call):
        maker = next(x for x in module.body if getattr(x, "name", "") == passed.value.func.id)
        for x in ast.walk(maker):
            if isinstance(x, ast.Return):
                yield from _literal_keys(x.value)


def _literal_keys(made: ast.expr | None) -> Iterator[str]:
    """The keys of a dictionary that is written there, or of several joined."""
    if isinstance(made, ast.BinOp):
        yield from _literal_keys(made.left)
        yield from _literal_keys(made.right)
    elif isinstance(made, ast.Dict):
        yield from (key.value for key in made.keys if isinstance(key, ast.Constant))


def findings() -> dict[str, list[Code]]:
    """The codes of each class of evidence, in the order of its module."""
    every = {}
    for said, classes in ((sayings, evidence), (causes, found)):
        codes_of = {}
        module = ast.parse(inspect.getsource(said))
        for function in module.body:
            if not isinstance(function, ast.FunctionDef):
                continue
            if codes := dict.fromkeys(_codes(function, module)):
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
