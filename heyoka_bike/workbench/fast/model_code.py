"""The model as LLVM's assembly: rates and columns of eight states at once."""

from collections.abc import Sequence

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.straight_line import StraightLine, needed
from heyoka_bike.workbench.fast.vector_code import Code, function

STATE = 6


def rates_source(equations: Equations) -> str:
    """Function ``rates(y, f)`` of eight states."""
    record, formulas, names = _recorded(equations)
    rates = [x.text for x in formulas.rates([record.variable(x) for x in names])]
    c = Code()
    given = {name: c.load("%y", i) for i, name in enumerate(names)}
    for i, x in enumerate(c.statements(given, needed(record.statements, rates), rates)):
        c.store(x, "%f", i)
    return function(
        "internal void @rates(ptr noalias %y, ptr noalias %f)", [*c.lines, "  ret void"]
    )


def column_values(c: Code, equations: Equations, values: Sequence[str]) -> list[str]:
    """The benchmark's columns of a state, then the mechanical trail over the front's radius."""
    record, formulas, names = _recorded(equations)
    state = [record.variable(x) for x in names]
    columns = formulas.columns([*state, record.variable("yaw")])
    o, _ = formulas.unfold(state)
    trail = o.trail / formulas.k.front.r
    results = [*(columns[name].text for name in BENCHMARK_COLUMNS), trail.text]
    given = dict(zip(names, values, strict=True))
    return c.statements(given, needed(record.statements, results), results)


def _recorded(equations: Equations) -> tuple[StraightLine, Equations, list[str]]:
    """A record, the equations that write to it, and the names of the state's variables in it."""
    code = StraightLine()
    return code, equations.convert(code.literal, code), [f"y{i}" for i in range(STATE)]
