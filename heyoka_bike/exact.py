"""Exact numbers: a rational plus a rational multiple of pi.

Every constant of the problem is held in this form, from the TOML file to the moment a precision is
chosen, so that no binary approximation is made on the way.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from fractions import Fraction
from math import pi

_LITERAL = re.compile(r"[0-9]*\.?[0-9]*(?:[eE][+-]?[0-9]+)?\Z")
_MAX_EXPONENT = 400


@dataclass(frozen=True, slots=True)
class Exact:
    """The number ``rational + pi_multiple * pi``."""

    rational: Fraction
    pi_multiple: Fraction = Fraction(0)

    @classmethod
    def parse(cls, text: str) -> Exact:
        """Read a decimal string or an expression in decimals, ``pi``, ``+ - * /`` and brackets.

        Raises
        ------
        ValueError
            The text is not such an expression, or is not linear in pi.
        """
        try:
            tree = ast.parse(text.strip(), mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise ValueError(_expected(text)) from None
        try:
            return _evaluate(tree.body, text.strip())
        except ZeroDivisionError:
            raise ValueError(f"found '{text}', a division by zero") from None
        except RecursionError:
            raise ValueError(_expected(text)) from None

    @property
    def is_rational(self) -> bool:
        return self.pi_multiple == 0

    @property
    def is_zero(self) -> bool:
        return self.rational == 0 and self.pi_multiple == 0

    def fraction(self) -> Fraction:
        """The value as a `Fraction`; raises `ValueError` if it contains pi."""
        if not self.is_rational:
            raise ValueError(f"{self} is not rational")
        return self.rational

    def __float__(self) -> float:
        """Nearest-ish binary64, for display and range checks only, never for the model."""
        return float(self.rational) + float(self.pi_multiple) * pi

    def __str__(self) -> str:
        if self.is_rational:
            return str(self.rational)
        if self.rational == 0:
            return f"{self.pi_multiple}*pi"
        return f"{self.rational}+{self.pi_multiple}*pi"


def _expected(text: str) -> str:
    return f"found '{text}', expected a decimal number or an expression such as \"pi/10\""


def _evaluate(node: ast.expr, text: str) -> Exact:
    if isinstance(node, ast.Constant):
        # The literal's own text, not the float that Python made of it.
        literal = (ast.get_source_segment(text, node) or "").replace("_", "?")
        if not _LITERAL.match(literal) or not any(ch.isdigit() for ch in literal):
            raise ValueError(_expected(text))
        mantissa, _, exponent = literal.lower().partition("e")
        if exponent and abs(int(exponent)) > _MAX_EXPONENT:
            raise ValueError(f"found '{text}', expected an exponent between -400 and 400")
        return Exact(Fraction(literal))
    if isinstance(node, ast.Name) and node.id == "pi":
        return Exact(Fraction(0), Fraction(1))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        x = _evaluate(node.operand, text)
        return x if isinstance(node.op, ast.UAdd) else Exact(-x.rational, -x.pi_multiple)
    if isinstance(node, ast.BinOp):
        a, b = _evaluate(node.left, text), _evaluate(node.right, text)
        if isinstance(node.op, ast.Add):
            return Exact(a.rational + b.rational, a.pi_multiple + b.pi_multiple)
        if isinstance(node.op, ast.Sub):
            return Exact(a.rational - b.rational, a.pi_multiple - b.pi_multiple)
        if isinstance(node.op, ast.Mult) and (a.is_rational or b.is_rational):
            scale, x = (a.rational, b) if a.is_rational else (b.rational, a)
            return Exact(scale * x.rational, scale * x.pi_multiple)
        if isinstance(node.op, ast.Div) and b.is_rational:
            return Exact(a.rational / b.rational, a.pi_multiple / b.rational)
    raise ValueError(_expected(text))


ZERO = Exact(Fraction(0))
