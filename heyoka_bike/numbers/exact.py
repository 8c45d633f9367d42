"""Exact numbers: a rational plus a rational multiple of pi.

Every constant of the problem is held in this form, from the TOML file to the moment a precision is
chosen, so that no binary approximation is made on the way.

Expressions are read by a small parser of their own. Python's would turn decimals into floats, and
it accepts, or chokes on, much that is not a number.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from math import pi

from heyoka_bike.errors import InputError, quoted

_TOKEN = re.compile(
    r"[ \t]*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?![0-9A-Za-z_.])"
    r"|(?P<pi>pi)(?![0-9A-Za-z_.(])|(?P<sign>[-+*/()]))"
)
# Python may be told to convert no integers of more than 640 digits.
_MAX_LENGTH = 600
_MAX_INTEGER = 10**640
_MAX_BRACKETS = 50
_MAX_EXPONENT = 400
# Where binary64 is normal.
_SMALLEST, _LARGEST = Fraction(1, 10**300), Fraction(10**300)
_EXAMPLE = 'expected a decimal number or an expression such as "pi/10"'


@dataclass(frozen=True, repr=False, slots=True)
class Exact:
    """The number ``rational + pi_multiple * pi``.

    Integers are taken as fractions; anything else, a float above all, is refused with `TypeError`.

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
            value = _Parser(text).parse()
        except _ExpressionError as e:
            raise ValueError(f"found {quoted(text)}, {e}") from None
        if not value.is_moderate:
            raise ValueError(
                f"found {quoted(text)}, expected zero or a magnitude between 1e-300 and 1e300, "
                "a fraction of at most 640 digits"
            )
        return value

    @classmethod
    def read(cls, name: str, text: str) -> Exact:
        """`parse` what a user gives, with an `InputError` that says what it is.

        Raises
        ------
        InputError
            `parse` refuses it.
        """
        try:
            return cls.parse(text)
        except ValueError as e:
            raise InputError(f"{name}: {e}") from None

    def __add__(self, other: Exact) -> Exact:
        return Exact(self.rational + other.rational, self.pi_multiple + other.pi_multiple)

    def __mul__(self, other: Exact) -> Exact:
        """Return the product; raise `ValueError` where both contain pi."""
        x, by = (self, other) if other.is_rational else (other, self)
        return Exact(by.fraction() * x.rational, by.rational * x.pi_multiple)

    @property
    def is_rational(self) -> bool:
        return self.pi_multiple == 0

    @property
    def is_zero(self) -> bool:
        return self.rational == 0 and self.pi_multiple == 0

    @property
    def is_moderate(self) -> bool:
        """True if both parts are zero or from 1e-300 to 1e300, of at most 640 digits."""
        return all(
            part == 0
            or (
                _SMALLEST <= abs(part) <= _LARGEST
                and max(abs(part.numerator), part.denominator) < _MAX_INTEGER
            )
            for part in (self.rational, self.pi_multiple)
        )

    @property
    def sign(self) -> int:
        """-1, 0 or 1, decided exactly however close to zero the number is."""
        if self.is_rational:
            return (self.rational > 0) - (self.rational < 0)
        # The number is pi_multiple * (pi - root), and pi is irrational: enough digits decide.
        root = -self.rational / self.pi_multiple
        bits = 64
        while True:
            low, high = _around_pi(bits)
            if not low <= root <= high:
                above = 1 if root < low else -1
                return above if self.pi_multiple > 0 else -above
            bits *= 2

    def fraction(self) -> Fraction:
        """The value as a `Fraction`; raises `ValueError` if it contains pi."""
        if not self.is_rational:
            raise ValueError(f"{self} is not rational")
        return self.rational

    def __float__(self) -> float:
        """Nearest-ish binary64, for display only, never for the model."""
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
_SIGNS = {"+": Exact(Fraction(1)), "-": Exact(Fraction(-1))}


def shortest_decimal(x: Fraction, digits: int) -> str:
    """The shortest decimal that is exactly x; with `digits` digits if there is none."""
    denominator = x.denominator
    for p in (2, 5):
        while denominator % p == 0:
            denominator //= p
    if denominator == 1:
        digits = len(str(x.numerator)) + x.denominator.bit_length() + 1
    text = f"{Context(prec=digits).divide(Decimal(x.numerator), Decimal(x.denominator)):f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


class _ExpressionError(Exception):
    """Why a text is not an expression."""


def positive_numbers(name: str, text: str) -> tuple[float, ...]:
    """Read numbers more than zero, separated by commas.

    Parameters
    ----------
    name
        What they are, for errors.
    text
        Each as of `Exact.parse`.

    Raises
    ------
    InputError
        One of them is no such number.
    """
    found = []
    for part in text.split(","):
        value = float(Exact.read(name, part))
        if value <= 0:
            raise InputError(f"{name}: found {quoted(part)}, expected more than zero")
        found.append(value)
    return tuple(found)


class _Parser:
    """Recursive descent over sums, products, signs and brackets, in bounded time and depth."""

    def __init__(self, text: str) -> None:
        if len(text) > _MAX_LENGTH:
            raise _ExpressionError(f"expected at most {_MAX_LENGTH} characters")
        self.text = text.rstrip(" \t")
        self.at = 0
        self.brackets = 0
        self.next: re.Match[str] | None = None
        self._advance()

    def parse(self) -> Exact:
        value = self._sum()
        if self.next is not None:
            raise _ExpressionError(_EXAMPLE)
        return value

    def _advance(self) -> None:
        if self.at == len(self.text):
            self.next = None
            return
        self.next = _TOKEN.match(self.text, self.at)
        if self.next is None:
            raise _ExpressionError(_EXAMPLE)
        self.at = self.next.end()

    def _take(self, signs: str) -> str:
        """The next sign if it is one of `signs`, else nothing."""
        sign: str = self.next["sign"] if self.next and self.next["sign"] else ""
        if not sign or sign not in signs:
            return ""
        self._advance()
        return sign

    def _sum(self) -> Exact:
        value = self._product()
        while sign := self._take("+-"):
            value += self._product() * _SIGNS[sign]
        return value

    def _product(self) -> Exact:
        value = self._signed()
        while sign := self._take("*/"):
            factor = self._signed()
            if sign == "/":
                if factor.is_zero:
                    raise _ExpressionError("a division by zero, expected a nonzero divisor")
                if not factor.is_rational:
                    raise _ExpressionError("a division by pi, expected an expression linear in pi")
                factor = Exact(1 / factor.rational)
            elif not (value.is_rational or factor.is_rational):
                raise _ExpressionError("a product of pi and pi, expected one linear in pi")
            value *= factor
        return value

    def _signed(self) -> Exact:
        factor = _SIGNS["+"]
        while sign := self._take("+-"):
            factor *= _SIGNS[sign]
        return self._atom() * factor

    def _atom(self) -> Exact:
        token = self.next
        if token is None:
            raise _ExpressionError(_EXAMPLE)
        if literal := token["number"]:
            self._advance()
            return Exact(_decimal(literal))
        if token["pi"]:
            self._advance()
            return Exact(Fraction(0), Fraction(1))
        if not self._take("("):
            raise _ExpressionError(_EXAMPLE)
        self.brackets += 1
        if self.brackets > _MAX_BRACKETS:
            raise _ExpressionError(f"expected at most {_MAX_BRACKETS} brackets")
        value = self._sum()
        if not self._take(")"):
            raise _ExpressionError("expected a closing bracket")
        return value


def _decimal(literal: str) -> Fraction:
    _, _, exponent = literal.lower().partition("e")
    # Compared as text first: the exponent itself can be long.
    digits = exponent.lstrip("+-").lstrip("0")
    if len(digits) > len(str(_MAX_EXPONENT)) or int(digits or 0) > _MAX_EXPONENT:
        raise _ExpressionError(f"expected an exponent between -{_MAX_EXPONENT} and {_MAX_EXPONENT}")
    return Fraction(literal)


def _around_pi(bits: int) -> tuple[Fraction, Fraction]:
    """Two fractions with pi between them, about 2^-bits apart, by Machin's formula."""
    one = 1 << (bits + 16)

    def arctan_of_inverse(n: int) -> int:
        total, power, k = 0, one // n, 1
        while power:
            total += power // k if k % 4 == 1 else -(power // k)
            power //= n * n
            k += 2
        return total

    # Each of the fewer than `bits` divisions loses less than one unit, and is counted 20 times.
    near, slack = 4 * (4 * arctan_of_inverse(5) - arctan_of_inverse(239)), 40 * (bits + 16)
    return Fraction(near - slack, one), Fraction(near + slack, one)
