"""Text of LLVM's assembly for vectors: the few operations that `step_code` is written with."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence

from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast.collocation import POINTS

WHOLE, HALF, ONE = f"<{POINTS} x double>", f"<{POINTS // 2} x double>", "double"
_SIGNS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}

# Sine and cosine on -pi/4 to pi/4 as x + x^3 S(x^2) and 1 - x^2/2 + x^4 C(x^2), to half a unit of
# roundoff: least maxima as in Sun's fdlibm (k_sin.c, k_cos.c), highest power first.
_SINE = (
    1.58969099521155010221e-10, -2.50507602534068634195e-08, 2.75573137070700676789e-06,
    -1.98412698298579493134e-04, 8.33333333332248946124e-03, -1.66666666666666324348e-01,
)  # fmt: skip
_COSINE = (
    -1.13596475577881948265e-11, 2.08757232129817482790e-09, -2.75573143513906633035e-07,
    2.48015872894767294178e-05, -1.38888888888741095749e-03, 4.16666666666666019037e-02,
)  # fmt: skip
# pi/2 in three parts; the first two have zeros at their end, so that few multiples are exact.
_QUARTER = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
_TO_QUARTERS = 0.63661977236758134308
# Added and taken away again it leaves the nearest integer, whose bits are the last of the sum.
_INTEGER = 6755399441055744.0


def literal(x: float) -> str:
    """A number as LLVM reads it, exactly."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def constant(kind: str, values: float | Iterable[float]) -> str:
    """A constant of a vector or of `ONE`."""
    if kind == ONE:
        assert isinstance(values, float)
        return literal(values)
    count = POINTS if kind == WHOLE else POINTS // 2
    each = [values] * count if isinstance(values, float) else list(values)
    assert len(each) == count
    return "<" + ", ".join(f"double {literal(float(x))}" for x in each) + ">"


class Code:
    """Lines of one function, whose values are names or constants.

    Attributes
    ----------
    lines
        What was written.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._count = 0

    def assign(self, text: str) -> str:
        """A new name for what an instruction gives."""
        self._count += 1
        self.lines.append(f"  %t{self._count} = {text}")
        return f"%t{self._count}"

    def do(self, text: str) -> None:
        """An instruction that gives nothing."""
        self.lines.append(f"  {text}")

    def label(self, name: str) -> None:
        """Begin a block."""
        self.lines.append(f"{name}:")

    def operation(self, sign: str, x: str, y: str, kind: str = WHOLE) -> str:
        """One of ``+ - * /``; a product and a sum may be joined, and then are rounded once."""
        return self.assign(f"{_SIGNS[sign]} contract {kind} {x}, {y}")

    def negative(self, x: str, kind: str = WHOLE) -> str:
        return self.assign(f"fneg {kind} {x}")

    def fused(self, x: str, y: str, z: str, kind: str = WHOLE) -> str:
        """Product of the first two plus the third."""
        return self.call("fmuladd", kind, x, y, z)

    def call(self, name: str, kind: str, *given: str) -> str:
        """An intrinsic function of values of one kind."""
        suffix = {WHOLE: f"v{POINTS}f64", HALF: f"v{POINTS // 2}f64", ONE: "f64"}[kind]
        arguments = ", ".join(f"{kind} {x}" for x in given)
        return self.assign(f"call {kind} @llvm.{name}.{suffix}({arguments})")

    def array(self, kind: str, count: int) -> str:
        """Room for values, until the function ends."""
        return self.assign(f"alloca {kind}, i32 {count}, align 64")

    def at(self, array: str, index: int | str, kind: str) -> str:
        """Address of an element."""
        return self.assign(f"getelementptr {kind}, ptr {array}, i64 {index}")

    def load(self, array: str, index: int | str = 0, kind: str = WHOLE) -> str:
        place = array if index == 0 else self.at(array, index, kind)
        return self.assign(f"load {kind}, ptr {place}, align 8")

    def store(self, x: str, array: str, index: int | str = 0, kind: str = WHOLE) -> None:
        place = array if index == 0 else self.at(array, index, kind)
        self.do(f"store {kind} {x}, ptr {place}, align 8")

    def accumulate(self, sums: str, rests: str, index: int, x: str) -> None:
        """Add to one of some sums; what rounding took from it before is added, too."""
        before = self.load(sums, index, ONE)
        x = self.operation("+", x, self.load(rests, index, ONE), ONE)
        after = self.operation("+", before, x, ONE)
        added = self.operation("-", after, before, ONE)
        kept = self.operation("-", after, added, ONE)
        lost = self.operation("-", before, kept, ONE)
        rest = self.operation("+", self.operation("-", x, added, ONE), lost, ONE)
        self.store(rest, rests, index, ONE)
        self.store(after, sums, index, ONE)

    def spread(self, x: str, kind: str = WHOLE) -> str:
        """One number in every place of a vector."""
        count = POINTS if kind == WHOLE else POINTS // 2
        first = self.assign(f"insertelement {kind} poison, double {x}, i32 0")
        places = f"<{count} x i32> zeroinitializer"
        return self.assign(f"shufflevector {kind} {first}, {kind} poison, {places}")

    def halves(self, x: str) -> tuple[str, str]:
        """First and second half of a vector."""
        n = POINTS // 2
        first, second = (
            self.assign(f"shufflevector {WHOLE} {x}, {WHOLE} poison, {_places(range(i, i + n))}")
            for i in (0, n)
        )
        return first, second

    def joined(self, first: str, second: str) -> str:
        """A vector from its halves."""
        places = _places(range(POINTS))
        return self.assign(f"shufflevector {HALF} {first}, {HALF} {second}, {places}")

    def element(self, x: str, place: int, kind: str = WHOLE) -> str:
        return self.assign(f"extractelement {kind} {x}, i32 {place}")

    def product(self, matrix: Array, array: str, index: int) -> str:
        """A constant matrix times a column, which is element `index` of an array of vectors."""
        found = ["", ""]
        for j in range(POINTS):
            x = self.spread(self.load(array, POINTS * index + j, ONE))
            column = constant(WHOLE, [row[j] for row in matrix])
            # Two sums, which do not wait for each other.
            half = found[j % 2]
            found[j % 2] = self.fused(x, column, half) if half else self.operation("*", x, column)
        return self.operation("+", *found)

    def turns(self, x: str) -> tuple[str, str]:
        """Sine and cosine of angles up to a million."""
        k = constant(WHOLE, _INTEGER)
        shifted = self.fused(x, constant(WHOLE, _TO_QUARTERS), k)
        quarters = self.assign(f"fsub {WHOLE} {shifted}, {k}")
        r = x
        for part in _QUARTER:
            r = self.fused(quarters, constant(WHOLE, -part), r)
        square = self.operation("*", r, r)
        sine = self.fused(self.operation("*", square, r), self._polynomial(_SINE, square), r)
        half = self.fused(square, constant(WHOLE, -0.5), constant(WHOLE, 1.0))
        fourth = self.operation("*", square, square)
        cosine = self.fused(fourth, self._polynomial(_COSINE, square), half)
        integers = f"<{POINTS} x i64>"
        bits = self.assign(f"bitcast {WHOLE} {shifted} to {integers}")
        odd = self.assign(f"trunc {integers} {bits} to <{POINTS} x i1>")
        by_sine = self._chosen(odd, cosine, sine)
        by_cosine = self._chosen(odd, sine, cosine)
        return self._signed(by_sine, bits, 0), self._signed(by_cosine, bits, 1)

    def _polynomial(self, coefficients: Sequence[float], x: str) -> str:
        value = constant(WHOLE, coefficients[0])
        for c in coefficients[1:]:
            value = self.fused(value, x, constant(WHOLE, c))
        return value

    def _chosen(self, mask: str, x: str, y: str) -> str:
        return self.assign(f"select <{POINTS} x i1> {mask}, {WHOLE} {x}, {WHOLE} {y}")

    def _signed(self, x: str, quarters: str, ahead: int) -> str:
        """The sign changed where the second bit of the quarters, and so many more, is set."""
        integers = f"<{POINTS} x i64>"
        if ahead:
            ones = "<" + ", ".join(["i64 1"] * POINTS) + ">"
            quarters = self.assign(f"add {integers} {quarters}, {ones}")
        shift = "<" + ", ".join(["i64 62"] * POINTS) + ">"
        top = "<" + ", ".join([f"i64 {-(2**63)}"] * POINTS) + ">"
        moved = self.assign(f"shl {integers} {quarters}, {shift}")
        sign = self.assign(f"and {integers} {moved}, {top}")
        bits = self.assign(f"bitcast {WHOLE} {x} to {integers}")
        changed = self.assign(f"xor {integers} {bits}, {sign}")
        return self.assign(f"bitcast {integers} {changed} to {WHOLE}")

    def statements(
        self, given: Mapping[str, str], statements: Mapping[str, str], results: Iterable[str]
    ) -> list[str]:
        """Values of a recorded formula, see `straight_line`, from those of its variables."""
        found = dict(given)
        pairs: dict[str, tuple[str, str]] = {}

        def value(text: str) -> str:
            if text in found:
                return found[text]
            try:
                return constant(WHOLE, float(text))
            except ValueError:
                return self.negative(found[text[1:]])

        for name, text in statements.items():
            function, _, rest = text.partition("(")
            if not rest:
                x, sign, y = text.split(" ")
                found[name] = self.operation(sign, value(x), value(y))
                continue
            argument = rest[:-1]
            if function == "sqrt":
                found[name] = self.call("sqrt", WHOLE, value(argument))
                continue
            if argument not in pairs:
                pairs[argument] = self.turns(value(argument))
            found[name] = pairs[argument][function == "cos"]
        return [value(x) for x in results]


def _places(places: Iterable[int]) -> str:
    found = [f"i32 {i}" for i in places]
    return f"<{len(found)} x i32> <{', '.join(found)}>"


def function(head: str, lines: Sequence[str]) -> str:
    """Text of a function."""
    return "\n".join([f"define {head} {{", *lines, "}", ""])


def _declare(name: str, kind: str, count: int) -> str:
    suffix = {WHOLE: f"v{POINTS}f64", HALF: f"v{POINTS // 2}f64", ONE: "f64"}[kind]
    return f"declare {kind} @llvm.{name}.{suffix}({', '.join([kind] * count)})"


_KINDS = (WHOLE, HALF, ONE)
DECLARATIONS = "\n".join(
    [
        *(_declare("fmuladd", kind, 3) for kind in _KINDS),
        *(_declare(name, kind, 1) for name in ("fabs", "sqrt") for kind in _KINDS),
        *(_declare(name, kind, 2) for name in ("maxnum", "minnum") for kind in _KINDS),
        *(
            f"declare double @llvm.vector.reduce.{name}.v{POINTS}f64({WHOLE})"
            for name in ("fmin", "fmax")
        ),
        f"declare double @llvm.vector.reduce.fadd.v{POINTS}f64(double, {WHOLE})",
        f"declare {WHOLE} @llvm.masked.load.v{POINTS}f64.p0(ptr, i32, <{POINTS} x i1>, {WHOLE})",
        f"declare void @llvm.masked.store.v{POINTS}f64.p0({WHOLE}, ptr, i32, <{POINTS} x i1>)",
        "",
    ]
)
"""Of the intrinsic functions that are called."""
