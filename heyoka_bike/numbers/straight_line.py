"""Source code of formulas, made by evaluating them with numbers that record statements.

The source is a list of assignments to names, one operation each, in a syntax that C and JavaScript
share; ``sin``, ``cos``, ``sqrt`` and ``atan2`` are functions. An operation that occurs again on the
same operands is written only once. Operations on two literals are evaluated immediately, in
binary64. Products with 0 and 1 and sums with 0 vanish, as they do in heyoka's expressions.

A `Language` is a table of texts for writing such formulas as functions. A function takes vectors
and returns one vector or matrix; indices start at the language's first index.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partialmethod, reduce
from operator import add, mul, sub, truediv

from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.exact import Exact

_PATTERN_OF_NAME = re.compile(r"\bv\d+\b")
_OPERATIONS_OF_CODE = {"+": add, "-": sub, "*": mul, "/": truediv}


class Recorded:
    """A value in the source code: a name or a literal."""

    __slots__ = ("code", "text", "value")

    def __init__(self, code: StraightLine, text: str, value: float | None = None) -> None:
        self.code, self.text, self.value = code, text, value

    @property
    def is_negative(self) -> bool:
        """True for a negative literal and for the negative of a name."""
        return self.text.startswith("-")

    def _with(self, sign: str, other: Operand) -> Recorded:
        if not isinstance(other, Operand):
            return NotImplemented
        return self.code.operation(sign, self, other)

    def _after(self, sign: str, other: Fraction | int) -> Recorded:
        if not isinstance(other, Fraction | int):
            return NotImplemented
        return self.code.operation(sign, self.code.literal(float(other)), self)

    def __neg__(self) -> Recorded:
        return self.code.negative(self)

    __add__ = partialmethod(_with, "+")
    __radd__ = partialmethod(_after, "+")
    __sub__ = partialmethod(_with, "-")
    __rsub__ = partialmethod(_after, "-")
    __mul__ = __rmul__ = partialmethod(_with, "*")
    __truediv__ = partialmethod(_with, "/")
    __rtruediv__ = partialmethod(_after, "/")


Operand = Recorded | Fraction | int
"""Types that a recorded number can be combined with."""


class StraightLine(Arithmetic):
    """An `Arithmetic` that records assignments.

    Parameters
    ----------
    literal_end
        Suffix for the type of a literal, in languages that need one.

    Attributes
    ----------
    statements
        Right-hand sides by the name they are assigned to, in order.
    """

    def __init__(self, literal_end: str = "") -> None:
        self._literal_end = literal_end
        self.statements: dict[str, str] = {}
        self._names: dict[str, Recorded] = {}

    def variable(self, text: str) -> Recorded:
        """Return a value that stands for the variable of this name."""
        return Recorded(self, text)

    def literal(self, value: float) -> Recorded:
        # repr returns the shortest decimal that rounds to the value.
        return Recorded(self, repr(float(value)) + self._literal_end, float(value))

    def number(self, value: Exact | Fraction | int | Recorded) -> Number:
        return value if isinstance(value, Recorded) else self.literal(float(value))

    def elementary(self, name: str, x: Recorded) -> Recorded:
        return self._assign(f"{name}({x.text})")

    def atan2(self, y: Recorded, x: Recorded) -> Recorded:
        return self._assign(f"atan2({y.text}, {x.text})")

    def sum(self, terms: Iterable[Operand]) -> Recorded:
        """Add in pairs, which shortens the chain of operations that depend on each other."""
        found = [x if isinstance(x, Recorded) else self.literal(float(x)) for x in terms]
        while len(found) > 1:
            pairs = [found[i] + found[i + 1] for i in range(0, len(found) - 1, 2)]
            found = [*pairs, *found[2 * len(pairs) :]]
        return found[0]

    def operation(self, sign: str, x: Recorded, y: Operand) -> Recorded:
        """Record one of ``+ - * /``, or evaluate it if both operands are literals."""
        if not isinstance(y, Recorded):
            y = self.literal(float(y))
        if x.value is not None and y.value is not None:
            return self.literal(_OPERATIONS_OF_CODE[sign](x.value, y.value))
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

    def _product(self, sign: str, x: Recorded, y: Recorded) -> Recorded:
        if sign == "*" and y.value is not None:
            x, y = y, x
        if x.value == 0 or y.value == 1:
            return x
        if sign == "*" and x.value == 1:
            return y
        if x.is_negative or y.is_negative:
            # Move signs outside, so that a product and its negative share one statement.
            plain = self._product(sign, self._magnitude(x), self._magnitude(y))
            return plain if x.is_negative == y.is_negative else self.negative(plain)
        if sign == "*" and x.value is None and y.text < x.text:
            x, y = y, x
        return self._assign(f"{x.text} {sign} {y.text}")

    def _magnitude(self, x: Recorded) -> Recorded:
        return self.negative(x) if x.is_negative else x

    def negative(self, x: Recorded) -> Recorded:
        """Change the sign without a statement: the sign becomes part of the operand."""
        if x.value is not None:
            return self.literal(-x.value)
        return Recorded(self, x.text[1:] if x.text.startswith("-") else f"-{x.text}")

    def _assign(self, text: str) -> Recorded:
        if text not in self._names:
            name = f"v{len(self.statements)}"
            self.statements[name] = text
            self._names[text] = Recorded(self, name)
        return self._names[text]


def needed(statements: Mapping[str, str], results: Sequence[str]) -> dict[str, str]:
    """Return, in order, the statements on which the results depend."""
    wanted = set(_PATTERN_OF_NAME.findall(" ".join(results)))
    for name, text in reversed(list(statements.items())):
        if name in wanted:
            wanted.update(_PATTERN_OF_NAME.findall(text))
    return {name: text for name, text in statements.items() if name in wanted}


_INDENT = "    "


@dataclass(frozen=True, slots=True)
class Language:
    """The syntax of functions in a programming language.

    Attributes
    ----------
    opening, closing
        First and last lines of a function, with its ``{name}``, its ``{arguments}`` and its
        ``{result}``. The result has ``{sizes}``, ``{shape}`` (in the brackets of an array),
        ``{type}`` and ``{zeros}``. ``{declared}`` is the `declaration` of all arguments.
    statement
        Assigns a ``{value}`` to a ``{name}``.
    argument, declaration
        An argument, with its ``{name}`` and ``{size}``.
    output
        The result as the last argument, in languages where it is an argument.
    time
        The arguments ``{}`` of a right-hand side in the order of the language's solvers.
    brackets, joint
        Brackets of indices, and the text between indices.
    nest
        Type of an array with one more dimension: ``{0}`` is the inner type, followed by the number
        of entries.
    end
        End of a statement.
    first
        The first index.
    literal
        Suffix of a number.
    """

    opening: str
    closing: str
    statement: str
    argument: str = "{name}"
    declaration: str = ""
    output: str = ""
    time: str = "{}"
    brackets: str = "[]"
    joint: str = "]["
    nest: str = ""
    end: str = ";"
    first: int = 0
    literal: str = ""

    def at(self, name: str, *indices: int) -> str:
        """Return the code of an entry of an array; indices count from 0."""
        return name + self._bracketed([i + self.first for i in indices])

    def _bracketed(self, numbers: Sequence[int]) -> str:
        return self.brackets[0] + self.joint.join(map(str, numbers)) + self.brackets[1]

    def function(
        self, name: str, inputs: Mapping[str, int], result: str,
        formulas: Callable[..., Sequence[Number]], is_timed: bool = False,
    ) -> str:  # fmt: skip
        """Return the text of a function.

        Parameters
        ----------
        name
        inputs
            Names and sizes of the vector arguments.
        result
            Name of the result.
        formulas
            Function from a `StraightLine` and the vectors to the numbers of the result, or to its
            rows.
        is_timed
            True if solvers call the function as a right-hand side.
        """
        code = StraightLine(self.literal)
        given = [[code.variable(self.at(x, i)) for i in range(n)] for x, n in inputs.items()]
        found = _flat(formulas(code, *given))
        sizes = [1 + max(axis) for axis in zip(*found, strict=True)]
        texts = {at: code.number(x).text for at, x in found.items()}
        lines = self.statements(needed(code.statements, list(texts.values())))
        lines += [f"{self.at(result, *at)} = {text}{self.end}" for at, text in texts.items()]
        words = {
            "name": name,
            "result": result,
            "sizes": ", ".join(map(str, sizes)),
            "shape": self._bracketed(sizes),
            "type": reduce(self.nest.format, reversed(sizes), "f64"),
            "zeros": reduce(self.nest.format, reversed(sizes), "0.0"),
            "declared": "".join(self.declaration.format(name=x, size=inputs[x]) for x in inputs),
        }
        arguments = [self.argument.format(name=x, size=n) for x, n in inputs.items()]
        if is_timed:
            arguments = [self.time.format(", ".join(arguments))]
        if self.output:
            arguments.append(self.output.format_map(words))
        words["arguments"] = ", ".join(arguments)
        opening, closing = (x.format_map(words) for x in (self.opening, self.closing))
        return "\n".join([opening, *(_INDENT + line for line in lines), closing, ""])

    def statements(self, named: Mapping[str, str]) -> list[str]:
        """Return a line of code for each recorded operation."""
        return [self.statement.format(name=x, value=text) + self.end for x, text in named.items()]


def _flat(values: Sequence[Number]) -> dict[tuple[int, ...], Number]:
    """Return the entries of a vector, or of a matrix given by rows, by their indices."""
    if not isinstance(values[0], Sequence):
        return {(i,): x for i, x in enumerate(values)}
    return {(i, j): x for i, row in enumerate(values) for j, x in enumerate(row)}


C = Language(
    opening="void {name}({arguments})\n{{",
    closing="}}",
    statement="const double {name} = {value}",
    argument="const double {name}[{size}]",
    output="double {result}{shape}",
)
FORTRAN = Language(
    opening=(
        "pure subroutine {name}({arguments})\n    implicit real(real64) (v)\n"
        "{declared}    real(real64), intent(out) :: {result}{shape}"
    ),
    closing="end subroutine {name}",
    statement="{name} = {value}",
    declaration="    real(real64), intent(in) :: {name}({size})\n",
    output="{result}",
    brackets="()",
    joint=", ",
    end="",
    first=1,
    literal="_real64",
)
MATLAB = Language(
    opening="function {result} = {name}({arguments})\n    {result} = zeros([{sizes}, 1]);",
    closing="end",
    statement="{name} = {value}",
    time="t, {}",
    brackets="()",
    joint=", ",
    first=1,
)
JULIA = Language(
    opening="function {name}({arguments})\n    {result} = zeros({sizes})",
    closing="    return {result}\nend",
    statement="{name} = {value}",
    time="{}, p, t",
    joint=", ",
    end="",
    first=1,
)
PYTHON = Language(
    opening="def {name}({arguments}):\n    {result} = {zeros}",
    closing="    return {result}\n",
    statement="{name} = {value}",
    time="t, {}",
    nest="[{} for _ in range({})]",
    end="",
)
JAVASCRIPT = Language(
    opening="const {name} = ({arguments}) => {{",
    closing="}};",
    statement="const {name} = {value}",
    output="{result}",
)
RUST = Language(
    opening="pub fn {name}({arguments}) -> {type} {{\n    let mut {result} = {zeros};",
    closing="    {result}\n}}",
    statement="let {name} = {value}",
    argument="{name}: &[f64; {size}]",
    nest="[{}; {}]",
)
