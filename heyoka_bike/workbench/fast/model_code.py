"""Generate LLVM code of the model: rates and columns of eight states at once."""

import operator
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.straight_line import Recorded, StraightLine, needed
from heyoka_bike.workbench.fast.vector_code import STATE_SIZE, Code, Memory, Register, turns

ENERGY = BENCHMARK_COLUMNS.index("mechanical_energy")
_NAMES_OF_STATE = [f"y{i}" for i in range(STATE_SIZE)]
_OPERATORS_OF_CODE = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}


def rates_code(equations: Equations) -> Code:
    """Return the LLVM function ``rates(y, f)``: the time derivatives f of eight states y."""
    code = StraightLine()
    rates = equations.convert(code.literal, code).rates([code.variable(x) for x in _NAMES_OF_STATE])
    c = Code("internal void @rates(ptr, ptr)")
    y, f = c.arguments
    f.vectors().store(_computed(code, y.vectors().load(), rates))
    c.do("ret void")
    return c


def call_rates(y: Memory, f: Memory) -> None:
    """Call ``rates`` for eight states in memory, where each variable is a vector."""
    y.code.call("void", "rates", y.address, f.address)


def columns_and_trail(equations: Equations, values: Iterable[Register]) -> list[Any]:
    """Return the benchmark's columns of a state, and mechanical trail / front wheel radius."""
    code = StraightLine()
    formulas = equations.convert(code.literal, code)
    state = [code.variable(x) for x in _NAMES_OF_STATE]
    columns = formulas.columns([*state, code.variable("yaw")])
    trail = formulas.unfold(state)[0].trail / formulas.k.front.r
    return _computed(code, values, [*(columns[name] for name in BENCHMARK_COLUMNS), trail])


def _computed(
    code: StraightLine, values: Iterable[Register], results: Sequence[Recorded]
) -> list[Any]:
    """Translate recorded formulas to LLVM code, for given values of the state variables."""
    found = dict(zip(_NAMES_OF_STATE, values, strict=True))
    pair = cache(turns)
    functions: dict[str, Callable[[Register], Register]] = {"sqrt": Register.sqrt}
    functions |= {"sin": lambda x: pair(x)[0], "cos": lambda x: pair(x)[1]}

    def value(text: str) -> Any:
        if text in found:
            return found[text]
        return -found[text[1:]] if text[1:] in found else float(text)

    texts = [x.text for x in results]
    for name, text in needed(code.statements, texts).items():
        function, _, rest = text.partition("(")
        if rest:
            found[name] = functions[function](value(rest[:-1]))
        else:
            x, sign, y = text.split(" ")
            found[name] = _OPERATORS_OF_CODE[sign](value(x), value(y))
    return [value(x) for x in texts]
