"""The equations as C: the model evaluated with numbers that record statements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Multiprecision, Number
from heyoka_bike.numbers.straight_line import C, Recorded, StraightLine, needed

_STATE = 6
_QUADRUPLE_DIGITS = 50  # binary128 has 34
_TRIGONOMETRIC = ("sin", "cos")
_BLOCK = 128  # rows; a block and its sines stay in the first level of the cache


def slope_source(bicycle: Bicycle) -> str:
    """Function ``slope(y, f)``: the time derivatives f of the state y, six numbers each.

    The form is `model.few_products`, the one that heyoka integrates.
    """
    return _slope("double", lambda code, y: _equations(bicycle, code).rates(y))


def quadruple_source(bicycle: Bicycle) -> str:
    """The C source in binary128, type ``real``; constants are rounded once from 50 digits."""
    constants = list[str]()
    exact = Multiprecision(_QUADRUPLE_DIGITS)

    def rates(code: StraightLine, y: Sequence[Number]) -> Sequence[Number]:
        def constant(x: Number) -> Recorded:
            if x in (0, 1):
                return code.literal(float(x))
            constants.append(f"{exact.context.nstr(x, _QUADRUPLE_DIGITS)}Q")
            return code.variable(f"k[{len(constants) - 1}]")

        return Equations.of(bicycle, exact, is_regular=False).convert(constant, code).rates(y)

    slope = _slope("real", rates)
    return f"static const real k[] = {{{', '.join(constants)}}};\n{slope}"


def _slope(kind: str, rates: Callable[..., Sequence[Number]]) -> str:
    language = replace(
        C,
        opening="static void {name}({arguments})\n{{",
        statement=f"const {kind} {{name}} = {{value}}",
        argument=f"const {kind} *restrict {{name}}",
        output=f"{kind} *restrict {{result}}",
    )
    return language.function("slope", {"y": _STATE}, "f", rates)


def columns_source(bicycle: Bicycle) -> str:
    """Function ``columns(n, y, out)``: the benchmark's eight columns of n rows, SI units.

    Both arrays hold one variable after the other, n numbers each. Sines and cosines go before the
    rest, in blocks of rows, so that a compiler can work on several rows at once.
    """
    code = StraightLine()
    names = ("roll", "pitch", "steer", "w1", "w3", "spin")
    state = [code.variable(name) for name in names]
    found = _equations(bicycle, code).columns([*state, code.variable("yaw")])
    results = {f"out[{i} * n + r]": found[c] for i, c in enumerate(BENCHMARK_COLUMNS)}
    used = needed(code.statements, [x.text for x in results.values()])
    first = {n: t for n, t in used.items() if t.startswith(_TRIGONOMETRIC)}
    rest = needed(
        {n: t for n, t in used.items() if n not in first}, [x.text for x in results.values()]
    )
    loads = [f"const double {name} = y[{i} * n + r];" for i, name in enumerate(names)]
    # No array overlaps another; there are too many of them for a compiler to ask at run time.
    loop = '_Pragma("GCC ivdep") for (long b = 0, r = start; r < stop; b++, r++) {'
    return "\n".join(
        [
            "static void columns(long n, const double *restrict y, double *restrict out)",
            "{",
            f"for (long start = 0; start < n; start += {_BLOCK}) {{",
            f"const long stop = start + {_BLOCK} < n ? start + {_BLOCK} : n;",
            f"double {', '.join(f't_{n}[{_BLOCK}]' for n in first)};",
            # A loop for each: sine and cosine of one angle together would be taken one by one.
            *(
                line
                for name, text in first.items()
                for line in (
                    loop,
                    *loads[:3],
                    *C.statements(needed(used, [text])),
                    f"t_{name}[b] = {text};",
                    "}",
                )
            ),
            loop,
            *loads,
            *(f"const double {name} = t_{name}[b];" for name in first),
            *C.statements(rest),
            *(f"{place} = {x.text};" for place, x in results.items()),
            "}",
            "}",
            "}",
            "",
        ]
    )


def operations(bicycle: Bicycle) -> dict[str, int]:
    """Count each operation in the time derivatives; ``scale`` is one with a literal."""
    code = StraightLine()
    _equations(bicycle, code).rates([code.variable(f"y[{i}]") for i in range(_STATE)])
    count: dict[str, int] = {}
    for text in code.statements.values():
        kind = text.split("(")[0] if text.startswith(_TRIGONOMETRIC) else text.split()[1]
        # A literal goes first.
        kind = "scale" if kind == "*" and text[0].isdigit() else kind
        count[kind] = count.get(kind, 0) + 1
    return count


def _equations(bicycle: Bicycle, code: StraightLine) -> Equations:
    return Equations.binary64(bicycle, is_regular=False).convert(code.literal, code)
