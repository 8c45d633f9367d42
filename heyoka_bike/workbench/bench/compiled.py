"""Runge-Kutta integrators in C, built on the spot to compare with: see ``runge_kutta.c``.

The right-hand side and the columns are written from the model, for one bicycle, by evaluating it
with numbers that record statements. The compiler is that of `CC`, else gcc, else cc, with `FLAGS`.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Multiprecision, Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.straight_line import C, Recorded, StraightLine, needed
from heyoka_bike.workbench.fast.ensemble import FIFTH, STAGES, STEP, THIRD

_STATE_LENGTH = 6
_QUADRUPLE_DIGITS = 50  # binary128 has 34
_TRIGONOMETRIC = ("sin", "cos")
_ROWS_OF_BLOCK = 128  # rows; a block and its sines stay in the first level of the cache


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
    return language.function("slope", {"y": _STATE_LENGTH}, "f", rates)


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
            f"for (long start = 0; start < n; start += {_ROWS_OF_BLOCK}) {{",
            f"const long stop = start + {_ROWS_OF_BLOCK} < n ? start + {_ROWS_OF_BLOCK} : n;",
            f"double {', '.join(f't_{n}[{_ROWS_OF_BLOCK}]' for n in first)};",
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


def sums_source() -> str:
    """Macros of DOP853: the weighted sums of slopes that `ensemble` has, too."""
    rows = {f"STAGE_{n}": row for n, row in enumerate(STAGES, start=1)}
    rows |= {"STEP": STEP, "THIRD": THIRD, "FIFTH": FIFTH}
    sums = {
        name: " + ".join(f"{weight!r} * k[{stage}][i]" for stage, weight in row.items())
        for name, row in rows.items()
    }
    return "".join(f"#define {name} ({text})\n" for name, text in sums.items())


def operations(bicycle: Bicycle) -> dict[str, int]:
    """Count each operation in the time derivatives; ``scale`` is one with a literal."""
    code = StraightLine()
    _equations(bicycle, code).rates([code.variable(f"y[{i}]") for i in range(_STATE_LENGTH)])
    count: dict[str, int] = {}
    for text in code.statements.values():
        kind = text.split("(")[0] if text.startswith(_TRIGONOMETRIC) else text.split()[1]
        # A literal goes first.
        kind = "scale" if kind == "*" and text[0].isdigit() else kind
        count[kind] = count.get(kind, 0) + 1
    return count


def _equations(bicycle: Bicycle, code: StraightLine) -> Equations:
    return Equations.binary64(bicycle, is_regular=False).convert(code.literal, code)


METHODS = ("DOPRI5", "DOP853", "RK4")
"""In the order of the C file."""
FLAGS = ("-O3", "-march=native")
"""Without ``-ffast-math``: that would be another arithmetic than the model's."""

_POINTER, _LONG_INTEGER, _DOUBLE = ctypes.c_void_p, ctypes.c_long, ctypes.c_double
_SOLVE = ctypes.CFUNCTYPE(
    _LONG_INTEGER, ctypes.c_int, _POINTER, _LONG_INTEGER, _POINTER, _DOUBLE, _POINTER, _POINTER
)
_EVALUATE = ctypes.CFUNCTYPE(None, _POINTER, _POINTER, _POINTER)
_MOST_SECONDS = 120  # of compiling; it takes about one


class NoCompilerError(Exception):
    """There is no C compiler, or it does not compile; the text says it in a few words."""


class CompiledPeers:
    """The integrators, compiled for a bicycle.

    Raises
    ------
    NoCompilerError
        They cannot be compiled here.
    """

    def __init__(self, bicycle: Bicycle) -> None:
        source = sums_source() + slope_source(bicycle) + columns_source(bicycle)
        library = _built("runge_kutta.c", source, "-lm")
        # Their prototypes hold the library.
        self._solve = _SOLVE(("solve", library))
        self._evaluate = _EVALUATE(("evaluate", library))

    def solve(
        self, method: str, start: Array, times: Array, tolerance: float
    ) -> tuple[Array, Array, int]:
        """States and columns at ascending times, and the calls of the right-hand side.

        Parameters
        ----------
        method
            One of `METHODS`.
        tolerance
            Relative and absolute; for RK4 the longest step [s].

        Returns
        -------
        states : ndarray, shape (6, times)
        columns : ndarray, shape (8, times)
        calls : int
            -1 for a run that did not get to its end.
        """
        states = np.empty((_STATE_LENGTH, len(times)))
        columns = np.empty((len(BENCHMARK_COLUMNS), len(times)))
        calls = self._solve(
            METHODS.index(method), start.ctypes.data, len(times), times.ctypes.data, tolerance,
            states.ctypes.data, columns.ctypes.data,
        )  # fmt: skip
        return states, columns, calls

    def evaluate(self, state: Array) -> tuple[Array, Array]:
        """Time derivatives, shape (6,), and columns, shape (8,), of a state."""
        rates, columns = np.empty(_STATE_LENGTH), np.empty(len(BENCHMARK_COLUMNS))
        self._evaluate(state.ctypes.data, rates.ctypes.data, columns.ctypes.data)
        return rates, columns


class QuadruplePeer:
    """Extrapolation in binary128, by libquadmath, compiled for a bicycle.

    Raises
    ------
    NoCompilerError
        It cannot be compiled here.
    """

    def __init__(self, bicycle: Bicycle) -> None:
        library = _built("extrapolation.c", quadruple_source(bicycle), "-lquadmath", "-lm")
        self._extrapolate = library.extrapolate
        self._extrapolate.restype = ctypes.c_long

    def end(
        self, columns: int, start: Sequence[str], duration: str, tolerance: float
    ) -> tuple[list[str], int]:
        """State at the end, as decimals, and the calls of the right-hand side.

        Parameters
        ----------
        columns
            Of the scheme; its order is twice as many.
        start, duration
            Decimals of the state at time 0, and of the time [s].
        tolerance
            Of a step.
        """
        found = ((ctypes.c_char * 64) * _STATE_LENGTH)()
        given = (ctypes.c_char_p * _STATE_LENGTH)(*(x.encode() for x in start))
        calls = self._extrapolate(
            columns, given, duration.encode(), ctypes.c_double(tolerance), found
        )
        return [bytes(x).split(b"\0")[0].decode() for x in found], calls


def _built(source: str, equations: str, *libraries: str) -> ctypes.CDLL:
    """A C file of this folder, compiled with equations written from the model."""
    compiler = os.environ.get("CC") or shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        raise NoCompilerError("no C compiler")
    # On Windows a library that is loaded cannot be removed.
    with TemporaryDirectory(prefix="heyoka_bike-", ignore_cleanup_errors=True) as folder:
        Path(folder, "equations.h").write_text(equations, encoding="utf-8")
        library = Path(folder) / "peers.so"
        command = [
            compiler, *FLAGS, "-std=gnu11", "-fPIC", "-shared", f"-I{folder}",
            str(Path(__file__).parent / source), "-o", str(library), *libraries,
        ]  # fmt: skip
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=_MOST_SECONDS)
            # Once loaded, the file is no longer needed.
            return ctypes.CDLL(str(library))
        except (OSError, subprocess.SubprocessError):
            raise NoCompilerError("does not compile") from None
