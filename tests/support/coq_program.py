"""The equations of motion as Coq has them: the program of `Equations.v`, in any numbers."""

from __future__ import annotations

import operator
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from heyoka_bike.numbers.exact import Exact

FORMAL = Path(__file__).parents[1] / "checker" / "formal"
STATES = 7
_PI = Exact(0, 1)
_BINARY = {"Add": operator.add, "Sub": operator.sub, "Mul": operator.mul, "Div": operator.truediv}


class Program:
    """Operations on a growing stack, whose operands are counted from the top."""

    def __init__(self, text: str) -> None:
        integers, operations = (part.partition("\n")[2] for part in text.split("Definition ")[1:])
        self.integers = [int(n) for n in re.findall(r"\((-?\d+)\)", integers)]
        found = re.findall(r"(Forward|Unary \w+|Binary \w+) (\d+)(?: (\d+))?", operations)
        self.operations = [
            (kind.split()[-1], *(int(n) for n in places if n)) for kind, *places in found
        ]

    @classmethod
    def of_coq(cls) -> Program:
        """Return the program of the file that Coq compiles."""
        return cls((FORMAL / "Equations.v").read_text())

    def rates(self, state: Sequence[Any], number: Any) -> list[Any]:
        """Return the derivatives of the state's variables, with constants and functions of
        `number`."""
        unary = {"Forward": lambda x: x, "Neg": operator.neg, "Sin": number.sin, "Cos": number.cos}
        functions = unary | _BINARY
        constants = [*(number.exact(n) for n in self.integers), number.exact(_PI)]
        stack = [*reversed(constants), *reversed(state)]
        for name, *places in self.operations:
            stack.append(functions[name](*(stack[-1 - n] for n in places)))
        return stack[: -STATES - 1 : -1]
