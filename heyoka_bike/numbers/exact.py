"""Exact numbers: a rational plus a rational multiple of pi.

Every constant of the problem has this form, from the TOML file until a precision is chosen, so that
no binary approximation is made on the way.

Python's parser would turn the decimals of an expression into floats, and it accepts (or crashes on)
much that is not a number. So each number is replaced with a name before the expression is parsed,
and only a few kinds of expressions are accepted.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from math import pi

from heyoka_bike.errors import InputError, quoted

# Pattern of a number or pi that is not followed by a letter, a digit or a point.
_PATTERN_OF_NUMBER = re.compile(
    r"(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|pi)(?![0-9A-Za-z_.])"
)
_WITHOUT_NUMBERS = re.compile(r"(?:x[0-9]+|[-+*/() \t])*")
_SIGNS = re.compile(r"[-+][-+ \t]*[-+]")
_OPERATIONS_OF_EXACT: Mapping[type, Callable[..., Exact]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv, ast.UAdd: operator.pos, ast.USub: operator.neg,
}  # fmt: skip
# Maximum length of a formula [characters], and limit of the integers in it. Python can be
# configured to refuse integers of more than 640 digits.
_MAX_LENGTH = 600
_MAX_INTEGER = 10**640
_MAX_BRACKETS = 50
_MAX_EXPONENT = 400
# Range of magnitudes in which binary64 has full precision.
_SMALLEST, _LARGEST_MAGNITUDE = Fraction(1, 10**300), Fraction(10**300)
_EXPECTED_NUMBER = 'expected a decimal number or an expression such as "pi/10"'


@dataclass(frozen=True, repr=False, slots=True)
class Exact:
    """The number ``rational + pi_multiple * pi``.

    Integers become fractions; any other type, such as a float, raises `TypeError`.

    Attributes
    ----------
    rational, pi_multiple : Fraction
    """

    rational: Fraction
    pi_multiple: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        for name in ("rational", "pi_multiple"):
            part = getattr(self, name)
            if isinstance(part, bool) or not isinstance(part, int | Fraction):
                raise TypeError(f"{name}: found {type(part).__name__}, expected a Fraction")
            object.__setattr__(self, name, Fraction(part))

    @classmethod
    def parse(cls, text: str) -> Exact:
        """Read a decimal string or an expression in decimals, ``pi``, ``+ - * /`` and brackets.

        Raises
        ------
        ValueError
            The text is not such an expression, is not linear in pi, or its value is not moderate
            (see `is_moderate`). The message is one line.
        """
        try:
            value = _value(text)
        except ValueError as e:
            raise ValueError(f"found {quoted(text)}, {e}") from None
        if not value.is_moderate:
            raise ValueError(
                f"found {quoted(text)}, expected zero or a magnitude between 1e-300 and 1e300; "
                "fractions: at most 640 digits"
            )
        return value

    @classmethod
    def read(cls, name: str, text: str) -> Exact:
        """Parse a user's input; errors name the input.

        Raises
        ------
        InputError
            `parse` rejects the text.
        """
        try:
            return cls.parse(text)
        except ValueError as e:
            raise InputError(f"{name}: {e}") from None

    def __add__(self, other: Exact) -> Exact:
        return Exact(self.rational + other.rational, self.pi_multiple + other.pi_multiple)

    def __pos__(self) -> Exact:
        return self

    def __neg__(self) -> Exact:
        return Exact(-self.rational, -self.pi_multiple)

    def __sub__(self, other: Exact) -> Exact:
        return self + -other

    def __mul__(self, other: Exact) -> Exact:
        """Return the product; raise `ValueError` where both contain pi."""
        x, by = (self, other) if other.is_rational else (other, self)
        if not by.is_rational:
            raise ValueError("a product of pi and pi, expected an expression linear in pi")
        return Exact(by.rational * x.rational, by.rational * x.pi_multiple)

    def __truediv__(self, other: Exact) -> Exact:
        """Return the quotient; raise `ValueError` where the divisor is zero or contains pi."""
        if other.is_zero:
            raise ValueError("a division by zero, expected a nonzero divisor")
        if not other.is_rational:
            raise ValueError("a division by pi, expected an expression linear in pi")
        return self * Exact(1 / other.rational)

    @property
    def is_rational(self) -> bool:
        return self.pi_multiple == 0

    @property
    def is_zero(self) -> bool:
        return self.rational == 0 and self.pi_multiple == 0

    @property
    def is_moderate(self) -> bool:
        """True if each part is zero or from 1e-300 to 1e300, and has at most 640 digits."""
        return all(
            part == 0
            or (
                _SMALLEST <= abs(part) <= _LARGEST_MAGNITUDE
                and max(abs(part.numerator), part.denominator) < _MAX_INTEGER
            )
            for part in (self.rational, self.pi_multiple)
        )

    @property
    def sign(self) -> int:
        """Return -1, 0 or 1, decided exactly however close to zero the number is."""
        if self.is_rational:
            return (self.rational > 0) - (self.rational < 0)
        # The number is pi_multiple * (pi - root), and pi is irrational, so enough digits decide the
        # sign.
        root = -self.rational / self.pi_multiple
        bits = 64
        while True:
            low, high = _around_pi(bits)
            if not low <= root <= high:
                above = 1 if root < low else -1
                return above if self.pi_multiple > 0 else -above
            bits *= 2

    def fraction(self) -> Fraction:
        """Return the value as a `Fraction`; raise `ValueError` if it contains pi."""
        if not self.is_rational:
            raise ValueError(f"{self} is not rational")
        return self.rational

    def __float__(self) -> float:
        """Return a binary64 near the value, for display only, never for the model."""
        return float(self.rational) + float(self.pi_multiple) * pi

    def __repr__(self) -> str:
        return f"Exact.parse({str(self)!r})"

    def __str__(self) -> str:
        if self.is_rational:
            return str(self.rational)
        if self.rational == 0:
            return f"{self.pi_multiple}*pi"
        return f"{self.rational}+{self.pi_multiple}*pi"


ZERO = Exact(Fraction(0))


def shortest_decimal(x: Fraction, digits: int) -> str:
    """Return the shortest decimal equal to x, or x rounded to `digits` digits if there is none."""
    denominator = x.denominator
    for p in (2, 5):
        while denominator % p == 0:
            denominator //= p
    if denominator == 1:
        digits = len(str(x.numerator)) + x.denominator.bit_length() + 1
    text = f"{Context(prec=digits).divide(Decimal(x.numerator), Decimal(x.denominator)):f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def positive_numbers(name: str, text: str) -> tuple[float, ...]:
    """Read positive numbers, separated by commas.

    Parameters
    ----------
    name
        Name of the input, for errors.
    text
        Numbers in the syntax of `Exact.parse`.

    Raises
    ------
    InputError
        An entry is not a positive number.
    """
    found = []
    for part in text.split(","):
        value = float(Exact.read(name, part))
        if value <= 0:
            raise InputError(f"{name}: found {quoted(part)}, expected more than zero")
        found.append(value)
    return tuple(found)


def _value(text: str) -> Exact:
    """Return the value of an expression, or raise a `ValueError` that gives the reason.

    The numbers are replaced with names, Python parses the expression, and the names get their exact
    values.
    """
    if len(text) > _MAX_LENGTH:
        raise ValueError(f"expected at most {_MAX_LENGTH} characters")
    if text.count("(") > _MAX_BRACKETS:
        raise ValueError(f"expected at most {_MAX_BRACKETS} brackets")
    numbers: list[Exact] = []

    def named(number: re.Match[str]) -> str:
        is_pi = number[0] == "pi"
        numbers.append(Exact(Fraction(0), Fraction(1)) if is_pi else Exact(_decimal(number[0])))
        return f"x{len(numbers) - 1}"

    def evaluated(node: ast.AST) -> Exact:
        if isinstance(node, ast.Name):
            return numbers[int(node.id[1:])]
        operation = _OPERATIONS_OF_EXACT.get(type(getattr(node, "op", None)))
        if operation and isinstance(node, ast.UnaryOp):
            return operation(evaluated(node.operand))
        if operation and isinstance(node, ast.BinOp):
            return operation(evaluated(node.left), evaluated(node.right))
        raise ValueError(_EXPECTED_NUMBER)

    formula = _PATTERN_OF_NUMBER.sub(named, text.strip(" \t"))
    if not _WITHOUT_NUMBERS.fullmatch(formula):
        raise ValueError(_EXPECTED_NUMBER)
    # Merge a long run of signs into one sign.
    formula = _SIGNS.sub(lambda signs: "-" if signs[0].count("-") % 2 else "+", formula)
    try:
        return evaluated(ast.parse(formula, mode="eval").body)
    except SyntaxError:
        is_open = text.count("(") > text.count(")")
        raise ValueError("expected a closing bracket" if is_open else _EXPECTED_NUMBER) from None


def _decimal(literal: str) -> Fraction:
    _, _, exponent = literal.lower().partition("e")
    # Compare the exponent as text first, because it can be very long.
    digits = exponent.lstrip("+-").lstrip("0")
    if len(digits) > len(str(_MAX_EXPONENT)) or int(digits or 0) > _MAX_EXPONENT:
        raise ValueError(f"expected an exponent between -{_MAX_EXPONENT} and {_MAX_EXPONENT}")
    return Fraction(literal)


def _around_pi(bits: int) -> tuple[Fraction, Fraction]:
    """Return two fractions that enclose pi, about 2^-bits apart, by Machin's formula."""
    one = 1 << (bits + 16)

    def arctan_of_inverse(n: int) -> int:
        total, power, k = 0, one // n, 1
        while power:
            total += power // k if k % 4 == 1 else -(power // k)
            power //= n * n
            k += 2
        return total

    # An arctangent needs fewer than `bits` divisions, each of which loses less than one unit. The
    # formula multiplies these errors by at most 20.
    near, slack = 4 * (4 * arctan_of_inverse(5) - arctan_of_inverse(239)), 40 * (bits + 16)
    return Fraction(near - slack, one), Fraction(near + slack, one)
