"""The equations as C: written by evaluating the model itself with numbers that record statements.

What is written is a list of assignments to constants, one operation each. The same operation on
the same operands is written once; operations on two literals are carried out here, in binary64;
products with 0 and 1 and sums with 0 vanish, as they do in heyoka's expressions.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.exact import Exact

_BITS = 256  # each constant is the exact one, rounded once
_INDENT = "    "
_STATE = 6
_TRIGONOMETRIC = ("sin", "cos")
_NAME = re.compile(r"\bv\d+\b")
_BLOCK = 128  # rows; a block and its sines stay in the first level of the cache


class CNumber:
    """A value in C: a name or a literal."""

    __slots__ = ("code", "text", "value")

    def __init__(self, code: CCode, text: str, value: float | None = None) -> None:
        self.code, self.text, self.value = code, text, value

    @property
    def is_negative(self) -> bool:
        """Whether it is a negative literal or the negative of a name."""
        return self.text.startswith("-")

    def __add__(self, other: CNumber | int) -> CNumber:
        return self.code.operation("+", self, other)

    def __radd__(self, other: int) -> CNumber:
        return self.code.operation("+", self.code.literal(other), self)

    def __sub__(self, other: CNumber | int) -> CNumber:
        return self.code.operation("-", self, other)

    def __rsub__(self, other: int) -> CNumber:
        return self.code.operation("-", self.code.literal(other), self)

    def __mul__(self, other: CNumber | int) -> CNumber:
        return self.code.operation("*", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: CNumber | int) -> CNumber:
        return self.code.operation("/", self, other)

    def __neg__(self) -> CNumber:
        return self.code.negative(self)


class CCode:
    """An `Arithmetic` that records assignments.

    Attributes
    ----------
    statements
        Right-hand sides by the name they are assigned to, in order.
    """

    def __init__(self) -> None:
        self.statements: dict[str, str] = {}
        self._names: dict[str, CNumber] = {}

    def variable(self, text: str) -> CNumber:
        """A value that exists in C already."""
        return CNumber(self, text)

    def literal(self, value: float) -> CNumber:
        # repr gives the shortest decimal that rounds to the value.
        return CNumber(self, repr(float(value)), float(value))

    def number(self, value: Exact | Fraction | int) -> Number:
        return self.literal(float(value))

    def sin(self, x: CNumber) -> CNumber:
        return self._call("sin", x)

    def cos(self, x: CNumber) -> CNumber:
        return self._call("cos", x)

    def sqrt(self, x: CNumber) -> CNumber:
        return self._call("sqrt", x)

    def atan2(self, y: CNumber, x: CNumber) -> CNumber:
        return self._assign(f"atan2({y.text}, {x.text})")

    def sum(self, terms: Iterable[CNumber]) -> CNumber:
        """Added in pairs, which shortens the chain of operations that wait for each other."""
        found = [x if isinstance(x, CNumber) else self.literal(x) for x in terms]
        while len(found) > 1:
            pairs = [found[i] + found[i + 1] for i in range(0, len(found) - 1, 2)]
            found = [*pairs, *found[2 * len(pairs) :]]
        return found[0]

    def operation(self, sign: str, x: CNumber, y: CNumber | int) -> CNumber:
        """One of ``+ - * /``, recorded unless it can be done here."""
        if not isinstance(y, CNumber):
            y = self.literal(y)
        if x.value is not None and y.value is not None:
            return self.literal(_folded(sign, x.value, y.value))
        if sign in "*/":
            return self._product(sign, x, y)
        if y.value == 0:
            return x
        if x.value == 0:
            return y if sign == "+" else self.negative(y)
        if y.is_negative:
            return self.operation("-" if sign == "+" else "+", x, self.negative(y))
        if x.is_negative and sign == "+":
            return self.operation("-", y, self.negative(x))
        if sign == "+" and y.text < x.text:
            x, y = y, x
        return self._assign(f"{x.text} {sign} {y.text}")

    def _product(self, sign: str, x: CNumber, y: CNumber) -> CNumber:
        if sign == "*" and y.value is not None:
            x, y = y, x
        if x.value == 0 or y.value == 1:
            return x
        if sign == "*" and x.value == 1:
            return y
        if x.is_negative or y.is_negative:
            # Signs are moved out, so that a product and its negative are one.
            plain = self._product(sign, self._magnitude(x), self._magnitude(y))
            return plain if x.is_negative == y.is_negative else self.negative(plain)
        if sign == "*" and x.value is None and y.text < x.text:
            x, y = y, x
        return self._assign(f"{x.text} {sign} {y.text}")

    def _magnitude(self, x: CNumber) -> CNumber:
        return self.negative(x) if x.is_negative else x

    def negative(self, x: CNumber) -> CNumber:
        """A change of sign costs nothing: it is not assigned to a name."""
        if x.value is not None:
            return self.literal(-x.value)
        return CNumber(self, x.text[1:] if x.text.startswith("-") else f"-{x.text}")

    def _call(self, function: str, x: CNumber) -> CNumber:
        return self._assign(f"{function}({x.text})")

    def _assign(self, text: str) -> CNumber:
        if text not in self._names:
            name = f"v{len(self.statements)}"
            self.statements[name] = text
            self._names[text] = CNumber(self, name)
        return self._names[text]


def _folded(sign: str, x: float, y: float) -> float:
    if sign == "+":
        return x + y
    if sign == "-":
        return x - y
    return x * y if sign == "*" else x / y


def slope_source(bicycle: Bicycle) -> str:
    """Function ``slope(y, f)``: the time derivatives f of the state y, six numbers each.

    The form is `model.few_products`, the one that heyoka integrates.
    """
    code = CCode()
    state = [code.variable(f"y[{i}]") for i in range(_STATE)]
    rates = _equations(bicycle, code).rates(state)
    return _function(
        "static void slope(const double *restrict y, double *restrict f)",
        [
            *_assignments(code.statements),
            *(f"f[{i}] = {x.text};" for i, x in enumerate(rates)),
        ],
    )


def columns_source(bicycle: Bicycle) -> str:
    """Function ``columns(n, y, out)``: the benchmark's eight columns of n rows, SI units.

    Both arrays hold one variable after the other, n numbers each. Sines and cosines go before the
    rest, in blocks of rows, so that a compiler can work on several rows at once.
    """
    code = CCode()
    names = ("roll", "pitch", "steer", "w1", "w3", "spin")
    state = [code.variable(name) for name in names]
    found = _equations(bicycle, code).columns([*state, code.variable("yaw")])
    results = {f"out[{i} * n + r]": found[c] for i, c in enumerate(BENCHMARK_COLUMNS)}
    needed = _needed(code.statements, [x.text for x in results.values()])
    first = {n: t for n, t in needed.items() if t.startswith(_TRIGONOMETRIC)}
    before = _needed(needed, list(first))
    rest = _needed(
        {n: t for n, t in needed.items() if n not in first}, [x.text for x in results.values()]
    )
    loads = [f"const double {name} = y[{i} * n + r];" for i, name in enumerate(names)]
    loop = "for (long b = 0, r = start; r < stop; b++, r++) {"
    return _function(
        "static void columns(long n, const double *restrict y, double *restrict out)",
        [
            f"for (long start = 0; start < n; start += {_BLOCK}) {{",
            f"const long stop = start + {_BLOCK} < n ? start + {_BLOCK} : n;",
            f"double {', '.join(f't_{n}[{_BLOCK}]' for n in first)};",
            loop,
            *loads[:3],
            *_assignments(before),
            *(f"t_{name}[b] = {name};" for name in first),
            "}",
            loop,
            *loads,
            *(f"const double {name} = t_{name}[b];" for name in first),
            *_assignments(rest),
            *(f"{place} = {x.text};" for place, x in results.items()),
            "}",
            "}",
        ],
    )


def operations(bicycle: Bicycle) -> dict[str, int]:
    """How often each operation occurs in the time derivatives of the state."""
    code = CCode()
    _equations(bicycle, code).rates([code.variable(f"y[{i}]") for i in range(_STATE)])
    count: dict[str, int] = {}
    for text in code.statements.values():
        kind = text.split("(")[0] if text.startswith(_TRIGONOMETRIC) else text.split()[1]
        count[kind] = count.get(kind, 0) + 1
    return count


def _equations(bicycle: Bicycle, code: CCode) -> Equations:
    return Equations.binary64(bicycle, is_regular=False).convert(code.literal, code)


def _needed(statements: Mapping[str, str], results: Sequence[str]) -> dict[str, str]:
    """The statements that the results depend on, in order."""
    wanted = set(_NAME.findall(" ".join(results)))
    for name, text in reversed(list(statements.items())):
        if name in wanted:
            wanted.update(_NAME.findall(text))
    return {name: text for name, text in statements.items() if name in wanted}


def _assignments(statements: Mapping[str, str]) -> list[str]:
    return [f"const double {name} = {text};" for name, text in statements.items()]


def _function(head: str, lines: Sequence[str]) -> str:
    return "\n".join([head, "{", *(_INDENT + line for line in lines), "}", ""])
