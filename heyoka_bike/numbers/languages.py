"""Languages in which recorded formulas are written as functions, see `straight_line`.

A language is a table of texts. A function takes vectors and gives one vector or matrix; indices
begin where those of the language do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.straight_line import StraightLine, needed

_INDENT = "    "


@dataclass(frozen=True, slots=True)
class Language:
    """The syntax of functions in a language.

    Attributes
    ----------
    opening, closing
        Of a function: its ``{name}``, its ``{arguments}``, and what it gives, ``{result}``, with
        its ``{sizes}``, its ``{shape}`` in the brackets of an array, its ``{type}`` and as many
        ``{zeros}``. In ``{declared}`` stand the `declaration` of all vectors that are given.
    statement
        Gives a ``{name}`` to a ``{value}``.
    argument, declaration
        A vector that is given, its ``{name}`` and ``{size}``.
    output
        The result as the last argument, where it is one.
    time
        The arguments of a right-hand side, ``{}``, as the language's solvers give them.
    brackets, joint
        Of indices, and what stands between them.
    nest
        From an array of a size the array of one dimension more: ``{0}`` and how many of them.
    end
        Of a statement.
    first
        The first index.
    literal
        Ends a number.
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
        """A number of an array; indices count from 0."""
        return name + self._bracketed([i + self.first for i in indices])

    def _bracketed(self, numbers: Sequence[int]) -> str:
        return self.brackets[0] + self.joint.join(map(str, numbers)) + self.brackets[1]

    def function(
        self, name: str, inputs: Mapping[str, int], result: str,
        formulas: Callable[..., Sequence[Number]], is_timed: bool = False,
    ) -> str:  # fmt: skip
        """A function's text.

        Parameters
        ----------
        name
        inputs
            Names and sizes of the vectors it takes.
        result
            Name of what it gives.
        formulas
            From a `StraightLine` and the vectors to the numbers of the result, or to its rows.
        is_timed
            Whether solvers call it as a right-hand side.
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
        """A line for each recorded operation."""
        return [self.statement.format(name=x, value=text) + self.end for x, text in named.items()]


def _flat(values: Sequence[Number]) -> dict[tuple[int, ...], Number]:
    """The numbers of a vector or of the rows of a matrix by their indices."""
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
RUST = Language(
    opening="pub fn {name}({arguments}) -> {type} {{\n    let mut {result} = {zeros};",
    closing="    {result}\n}}",
    statement="let {name} = {value}",
    argument="{name}: &[f64; {size}]",
    nest="[{}; {}]",
)
