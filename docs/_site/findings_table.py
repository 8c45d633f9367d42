"""The table of findings in docs/reference/findings.md: codes, severities and what was seen.

Each class of evidence below `heyoka_bike.scoring` has its code. Run as a script, this writes the
table.
"""

import ast
import inspect
import pkgutil
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import heyoka_bike.scoring
from heyoka_bike.scoring.diagnosis.conclusions import BesideCause
from heyoka_bike.scoring.evidence.base import Evidence
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


@cache
def classes() -> list[type[Evidence]]:
    """The classes of evidence of all modules."""
    package = heyoka_bike.scoring
    found = pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    return [
        x
        for module in [import_module(info.name) for info in found]
        for x in vars(module).values()
        if isinstance(x, type) and issubclass(x, Evidence) and x.__module__ == module.__name__
        # The code of `BesideCause` is that of the finding that it contains.
        if x is not BesideCause
    ]


def findings() -> dict[type[Evidence], list[Code]]:
    """The codes of each class of evidence that has a sentence."""
    every = {x: [*dict.fromkeys(_codes_of_class(x))] for x in classes()}
    return {x: codes for x, codes in every.items() if codes}


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(inspect.getsource(sys.modules[module]))


def _codes_of_class(x: type) -> Iterator[Code]:
    """Yield the code of a class, or the codes that its own `_finding` makes."""
    if "_finding" in vars(x):
        yield from _codes(*_method(x, "_finding"))
    elif isinstance(x.code, str):
        # The numbers may be those of a base class.
        numbers, module = _method(next(c for c in x.__mro__ if "numbers" in vars(c)), "numbers")
        returned = [n for n in ast.walk(numbers) if isinstance(n, ast.Return)]
        keys = (k for n in returned for k in _returned_keys(n.value, numbers, module))
        severity = x.severity if isinstance(x.severity, str) else "info"
        yield Code(x.code, str(severity), tuple(dict.fromkeys(keys)))


def _method(x: type, name: str) -> tuple[ast.FunctionDef, ast.Module]:
    """Return the source of a method of a class, and that of its module."""
    module = _tree(x.__module__)
    node = next(n for n in module.body if isinstance(n, ast.ClassDef) and n.name == x.__name__)
    return next(n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == name), module


def _returned_keys(
    made: ast.expr | None, method: ast.FunctionDef, module: ast.Module
) -> Iterator[str]:
    """Yield the keys of a dictionary that a method returns, in order, with those added to it."""
    if isinstance(made, ast.Dict):
        for key, value in zip(made.keys, made.values, strict=True):
            passed = ast.keyword(arg=None if key is None else ast.literal_eval(key), value=value)
            yield from _keys(passed, method, module)
    elif made is not None:
        yield from _keys(ast.keyword(arg=None, value=made), method, module)


def _line(code: Code, x: type[Evidence]) -> str:
    about = inspect.getdoc(x).partition("\n\n")
    keys = ", ".join(f"`{key}`" for key in code.keys)
    return f"| `{code.code}` | {code.severity} | {' '.join(about[0].split())} | {keys} |"


def table() -> str:
    """The table in Markdown, in the order of the codes."""
    every = [(code, x) for x, codes in findings().items() for code in codes]
    lines = (_line(*each) for each in sorted(every, key=lambda each: (each[0], each[1].__name__)))
    head = ["| code | severity | what was seen | in JSON |", "|---|---|---|---|"]
    return "\n".join([*head, *lines])


def page(text: str) -> str:
    """The page with its table made anew."""
    return filled(text, "findings", table())


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
