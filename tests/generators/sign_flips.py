"""Functions with one flipped sign: every plus and minus of a module's code in turn."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import CodeType, FunctionType, ModuleType
from typing import Any


@dataclass(frozen=True)
class Flip:
    """A function, and its code with one flipped sign.

    Attributes
    ----------
    function
    code
    text
        Position and original text of the changed code.
    """

    function: FunctionType
    code: CodeType
    text: str

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Apply the change for all users of the function, however they imported it."""
        own = self.function.__code__
        self.function.__code__ = self.code
        try:
            yield
        finally:
            self.function.__code__ = own


def changed(module: ModuleType, old: str, new: str) -> Flip:
    """Return a function of the module with one piece of its source text replaced."""
    (function,) = (f for f in _functions(module) if old in inspect.getsource(f))
    source = textwrap.dedent(inspect.getsource(function))
    code = _compiled(ast.parse(source.replace(old, new)), function)
    return Flip(function, code, f"{function.__qualname__}: {old}")


def flips(module: ModuleType) -> Iterator[Flip]:
    """Yield all flips of a module."""
    for function in dict.fromkeys(_functions(module)):
        source = textwrap.dedent(inspect.getsource(function))
        for i in range(len(_signs(ast.parse(source)))):
            tree = ast.parse(source)
            node = _signs(tree)[i]
            text = f"{module.__name__}.{function.__qualname__}: {ast.unparse(node)}"
            turned = ast.fix_missing_locations(_Turn(node).visit(tree))
            yield Flip(function, _compiled(turned, function), text)


def _signs(tree: ast.AST) -> list[ast.BinOp | ast.UnaryOp]:
    return [
        x
        for x in ast.walk(tree)
        if (isinstance(x, ast.BinOp) and isinstance(x.op, ast.Add | ast.Sub))
        or (isinstance(x, ast.UnaryOp) and isinstance(x.op, ast.USub))
    ]


class _Turn(ast.NodeTransformer):
    """Flips the sign at one node."""

    def __init__(self, node: ast.AST) -> None:
        self.node = node

    def visit(self, x: ast.AST) -> Any:
        if x is not self.node:
            return self.generic_visit(x)
        if isinstance(x, ast.UnaryOp):
            return x.operand
        assert isinstance(x, ast.BinOp)
        op = ast.Sub() if isinstance(x.op, ast.Add) else ast.Add()
        return ast.BinOp(x.left, op, x.right)


def _functions(module: ModuleType) -> Iterator[FunctionType]:
    for x in vars(module).values():
        if getattr(x, "__module__", None) != module.__name__:
            continue
        if isinstance(x, FunctionType):
            yield x
        elif isinstance(x, type):
            for y in vars(x).values():
                f = getattr(y, "fget", None) or getattr(y, "__func__", y)
                # Methods that dataclass generates have no source code.
                if isinstance(f, FunctionType) and f.__code__.co_filename == module.__file__:
                    yield f


def _compiled(tree: ast.Module, function: FunctionType) -> CodeType:
    code = compile(tree, function.__code__.co_filename, "exec", dont_inherit=True)
    return next(
        x
        for x in code.co_consts
        if isinstance(x, CodeType) and x.co_name == function.__code__.co_name
    )
