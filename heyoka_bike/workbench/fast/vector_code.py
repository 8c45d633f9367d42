"""Write functions of numbers and vectors in LLVM's language, with loops and branches.

LLVM compiles them to machine code at the first use; no compiler has to be installed.

A vector has eight places (lanes), half a vector four. Operators on registers write instructions; a
number that is combined with a vector is copied to all of its places.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache, reduce
from itertools import count
from typing import Any

import numpy as np

from heyoka_bike.errors import GENERATE, required
from heyoka_bike.numbers.double import Array

STATE_SIZE = 6
"""Number of variables of a state, without the yaw."""
LANES = 8
"""Places of a vector: the largest register of current processors holds this many numbers."""

ONE, INTEGER, BIT, POINTER, VOID = "double", "i64", "i1", "ptr", "void"
VECTOR, HALF_VECTOR = f"<{LANES} x {ONE}>", f"<{LANES // 2} x {ONE}>"
INTEGERS, BITS = f"<{LANES} x {INTEGER}>", f"<{LANES} x {BIT}>"
_INTRINSIC_SUFFIXES = {ONE: "f64", VECTOR: f"v{LANES}f64", HALF_VECTOR: f"v{LANES // 2}f64"}

# Coefficients of sine and cosine on -pi/4 to pi/4, approximated by x + x^3 S(x^2) and 1 - x^2/2 +
# x^4 C(x^2) to half a unit of roundoff. They are the minimax coefficients of Sun's fdlibm (k_sin.c,
# k_cos.c), highest power first.
_SINE = (
    1.58969099521155010221e-10, -2.50507602534068634195e-08, 2.75573137070700676789e-06,
    -1.98412698298579493134e-04, 8.33333333332248946124e-03, -1.66666666666666324348e-01,
)  # fmt: skip
_COSINE = (
    -1.13596475577881948265e-11, 2.08757232129817482790e-09, -2.75573143513906633035e-07,
    2.48015872894767294178e-05, -1.38888888888741095749e-03, 4.16666666666666019037e-02,
)  # fmt: skip
# Three numbers whose sum is pi/2. The first two end in zero bits, so that small multiples of them
# are exact.
_QUARTER = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
_TO_QUARTERS = 0.63661977236758134308
# Adding this number to x and subtracting it again rounds x to the nearest integer. The last bits of
# the sum are this integer.
_INTEGER = 6755399441055744.0

Registers = np.ndarray[Any, np.dtype[np.object_]]
"""An array of registers: NumPy's operators act on each element."""


@cache
def constant(kind: str, value: float | tuple[float, ...]) -> str:
    """Return an exact constant in LLVM's language: one number, or one for each place."""
    element = kind.split()[-1].rstrip(">")
    if isinstance(value, tuple):
        return f"<{', '.join(f'{element} {constant(element, x)}' for x in value)}>"
    text = f"0x{struct.pack('>d', value).hex()}" if element == ONE else str(value)
    return text if kind == element else f"splat ({element} {text})"


def _binary(name: str, *, is_swapped: bool = False) -> Callable[[Register, Any], Register]:
    def operator(self: Register, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        kind, x, y = self.code.alike(self, other)
        operation = f"f{name} contract" if kind in _INTRINSIC_SUFFIXES else name
        operands = f"{y}, {x}" if is_swapped else f"{x}, {y}"
        return self.code.assign(kind, f"{operation} {kind} {operands}")

    return operator


def _comparison(sign: str) -> Callable[[Register, Operand], Register]:
    def operator(self: Register, other: Operand) -> Register:
        kind, x, y = self.code.alike(self, other)
        operation = f"fcmp o{sign}" if kind in _INTRINSIC_SUFFIXES else f"icmp s{sign}"
        return self.code.assign(BITS if kind[0] == "<" else BIT, f"{operation} {kind} {x}, {y}")

    return operator


def _intrinsic(name: str) -> Callable[..., Register]:
    def operator(self: Register, *others: Operand) -> Register:
        kind, *texts = self.code.alike(self, *others)
        operands = [Register(self.code, kind, x) for x in texts]
        return self.code.call(kind, f"llvm.{name}.{_INTRINSIC_SUFFIXES[kind]}", *operands)

    return operator


def _kind(value: Operand) -> str:
    if isinstance(value, Register):
        return value.kind
    return INTEGER if isinstance(value, int) else ONE


class Register:
    """A value that a function computes: a number, an integer, a bit, or a vector of them.

    LLVM may fuse a product and a sum, which are then rounded once.

    Parameters
    ----------
    code
        The function.
    kind, text
        LLVM's names of the kind and of the register.
    """

    __slots__ = ("code", "kind", "text")

    def __init__(self, code: Code, kind: str, text: str) -> None:
        self.code, self.kind, self.text = code, kind, text

    __add__, __sub__, __mul__, __truediv__ = map(_binary, ("add", "sub", "mul", "div"))
    __radd__, __rmul__ = __add__, __mul__
    __rsub__, __rtruediv__ = _binary("sub", is_swapped=True), _binary("div", is_swapped=True)
    __and__, __or__, __xor__, __lshift__ = map(_binary, ("and", "or", "xor", "shl"))
    __lt__, __le__, __gt__, __ge__ = map(_comparison, ("lt", "le", "gt", "ge"))
    __abs__, sqrt = map(_intrinsic, ("fabs", "sqrt"))
    # If one operand is NaN, the result is the other operand.
    at_most, at_least = map(_intrinsic, ("minnum", "maxnum"))

    def __neg__(self) -> Register:
        return self.code.assign(self.kind, f"fneg {self.kind} {self.text}")

    def __invert__(self) -> Register:
        return self ^ -1

    def is_null(self) -> Register:
        """True if an address is null."""
        return self.code.assign(BIT, f"icmp eq {POINTER} {self.text}, null")

    def choose(self, x: Operand, y: Operand) -> Register:
        """Return the value of x where the bit is set, and of y elsewhere."""
        kind, yes, no = self.code.alike(x, y)
        operands = f"{self.kind} {self.text}, {kind} {yes}, {kind} {no}"
        return self.code.assign(kind, f"select {operands}")

    def cast(self, name: str, kind: str) -> Register:
        """Convert to another kind by ``bitcast`` or ``trunc``."""
        return self.code.assign(kind, f"{name} {self.kind} {self.text} to {kind}")

    def spread(self, kind: str = VECTOR) -> Register:
        """Copy a number to every place of a vector."""
        first = self.code.assign(
            kind, f"insertelement {kind} poison, {self.kind} {self.text}, i32 0"
        )
        return first.places([0] * int(kind[1:].split()[0]))

    def places(self, chosen: Iterable[int], other: Register | None = None) -> Register:
        """Return a vector of chosen places of this vector, or of this vector and another one."""
        places = [f"i32 {i}" for i in chosen]
        second = "poison" if other is None else other.text
        operands = f"{self.kind} {self.text}, {self.kind} {second}"
        mask = f"<{len(places)} x i32> <{', '.join(places)}>"
        kind = f"<{len(places)} x {self.kind.split()[-1]}"
        return self.code.assign(kind, f"shufflevector {operands}, {mask}")

    def over_places(self, name: str) -> Register:
        """Return the minimum (``fmin``) or maximum (``fmax``) over all places of a vector."""
        return self.code.call(
            ONE, f"llvm.vector.reduce.{name}.{_INTRINSIC_SUFFIXES[self.kind]}", self
        )

    def total(self) -> Register:
        """Return the sum over all places of a vector, added in any order."""
        name = f"llvm.vector.reduce.fadd.{_INTRINSIC_SUFFIXES[self.kind]}"
        return self.code.call(ONE, name, Register(self.code, ONE, "-0.0"), self, flags="reassoc")


Operand = Register | float
"""A register, or a constant of the kind of the other operand."""


class Memory:
    """Values of one kind, stored one after the other.

    Parameters
    ----------
    address
        Address of the first value.
    kind
        Kind of the value at an index.
    """

    def __init__(self, address: Register, kind: str) -> None:
        self.code, self.address, self.kind = address.code, address, kind

    def numbers(self, index: Register | int = 0) -> Memory:
        """Return the memory from an index on, as numbers."""
        return Memory(self.part(index).address, ONE)

    def vectors(self, index: Register | int = 0) -> Memory:
        """Return the memory from an index on, as vectors."""
        return Memory(self.part(index).address, VECTOR)

    def part(self, index: Register | int) -> Memory:
        """Return the memory from an index on."""
        if isinstance(index, int) and index == 0:
            return self
        place = self.code.text(index, INTEGER)
        address = f"getelementptr {self.kind}, ptr {self.address.text}, {INTEGER} {place}"
        return Memory(self.code.assign(POINTER, address), self.kind)

    def __getitem__(self, index: Register | int) -> Register:
        address = self.part(index).address.text
        return self.code.assign(self.kind, f"load {self.kind}, ptr {address}, align 8")

    def __setitem__(self, index: Register | int, value: Operand) -> None:
        address, text = self.part(index).address.text, self.code.text(value, self.kind)
        self.code.do(f"store {self.kind} {text}, ptr {address}, align 8")

    def load(self, count: int = STATE_SIZE) -> Registers:
        return np.array([self[i] for i in range(count)])

    def store(self, values: Iterable[Operand]) -> None:
        for i, value in enumerate(values):
            self[i] = value


class Loop:
    """A loop: the code written in its context is repeated until `leave` ends it."""

    def __init__(self, code: Code) -> None:
        self._code, self._body, self._rest = code, code.block(), code.block()

    def __enter__(self) -> Loop:
        self._code.begin(self._body)
        return self

    def __exit__(self, *_: object) -> None:
        self._code.do(f"br label %{self._body}\n{self._rest}:")

    def again(self, condition: Register) -> None:
        """Go to the beginning of the body if a condition holds."""
        self._code.jump(self._body, condition)

    def leave(self, condition: Register) -> None:
        """Go to the code after the loop if a condition holds."""
        self._code.jump(self._rest, condition)


class Code:
    """The LLVM code of a function, to which instructions are added.

    Parameters
    ----------
    head
        LLVM declaration: linkage, kind of the result, name, and kinds of the arguments.

    Attributes
    ----------
    arguments
        Registers, or memory for pointers; no two pointers overlap.
    declarations
        Declarations of the functions that are called.
    """

    def __init__(self, head: str) -> None:
        self._lines, self._rooms, self._names = list[str](), list[str](), count()
        self.declarations: set[str] = set()
        name, _, kinds = head.rstrip(")").partition("(")
        given = [Register(self, kind, self._name()) for kind in kinds.split(", ")]
        texts = [f"{x.kind} {x.text}".replace(POINTER, f"{POINTER} noalias") for x in given]
        self._head = f"define {name}({', '.join(texts)}) {{"
        self.arguments: list[Any] = [Memory(x, ONE) if x.kind == POINTER else x for x in given]

    def __str__(self) -> str:
        return "\n".join([self._head, *self._rooms, *self._lines, "}"])

    def do(self, text: str) -> None:
        """Add an instruction without a result."""
        self._lines.append(text)

    def assign(self, kind: str, text: str) -> Register:
        """Add an instruction and return the register of its result."""
        found = Register(self, kind, self._name())
        self.do(text if kind == VOID else f"{found.text} = {text}")
        return found

    def text(self, value: Operand, kind: str) -> str:
        """Return LLVM's text of a value; a number is copied to all places if `kind` is a vector."""
        if not isinstance(value, Register):
            return constant(kind, value)
        return value.text if value.kind == kind else value.spread(kind).text

    def alike(self, *operands: Operand) -> list[str]:
        """Return the common kind of operands (a vector if any is one), and their texts."""
        kinds = [x.kind for x in operands if isinstance(x, Register)]
        kind = next((x for x in kinds if x[0] == "<"), kinds[0])
        return [kind, *(self.text(x, kind) for x in operands)]

    def vector(self, values: Iterable[float]) -> Register:
        """Return a constant vector."""
        places = tuple(values)
        kind = f"<{len(places)} x {_kind(places[0])}>"
        return Register(self, kind, constant(kind, places))

    def call(self, kind: str, name: str, *arguments: Register, flags: str = "") -> Register:
        """Call a function and return its result."""
        given = ", ".join(f"{x.kind} {x.text}" for x in arguments)
        if name.startswith("llvm."):
            kinds = ", ".join(x.kind for x in arguments)
            self.declarations.add(f"declare {kind} @{name}({kinds})")
        return self.assign(kind, f"call {flags} {kind} @{name}({given})")

    def memory(self, count: int = STATE_SIZE, kind: str = VECTOR) -> Memory:
        """Allocate memory for values until the function returns."""
        address = Register(self, POINTER, self._name())
        self._rooms.append(f"{address.text} = alloca {kind}, i32 {count}, align 64")
        return Memory(address, kind)

    def variable(self, value: Operand) -> Memory:
        """Allocate memory for one value."""
        found = self.memory(1, _kind(value))
        found[0] = value
        return found

    @contextmanager
    def unless(self, condition: Register) -> Iterator[None]:
        """Skip the code written in this context if a condition holds."""
        rest = self.block()
        self.jump(rest, condition)
        yield
        self.begin(rest)

    def block(self) -> str:
        """Return a new name for a block, which begins at a later call of `begin`."""
        return self._name()[1:]

    def begin(self, block: str) -> None:
        """Begin a block; the previous block continues into it."""
        self.do(f"br label %{block}\n{block}:")

    def jump(self, block: str, condition: Register) -> None:
        """Add a jump to a block if a condition holds."""
        rest = self.block()
        self.do(f"br i1 {condition.text}, label %{block}, label %{rest}\n{rest}:")

    def _name(self) -> str:
        return f"%t{next(self._names)}"


def module(*functions: Code) -> str:
    """Return an LLVM module of functions, with declarations of intrinsics that they call."""
    return "\n".join([*map(str, functions), *set().union(*(x.declarations for x in functions)), ""])


fused: Callable[..., Any] = np.frompyfunc(_intrinsic("fmuladd"), 3, 1)
"""Product of the first two plus the third; for registers or arrays of them."""
choose: Callable[..., Any] = np.frompyfunc(Register.choose, 3, 1)
"""The second if the bit of the first is set, else the third; for registers or arrays of them."""


def eighth_root(x: Register) -> Register:
    """Return the eighth root of a number, or of each number of a vector."""
    return x.sqrt().sqrt().sqrt()


def products(matrix: Array, columns: Memory) -> Registers:
    """Multiply a constant matrix and the vector of each variable."""
    factors = [columns.code.vector(x) for x in matrix.T]
    numbers = [columns.numbers(i).load(LANES) for i in range(STATE_SIZE)]
    return np.array([weighted([x.spread() for x in row], factors) for row in numbers])


def weighted(values: Sequence[Any], factors: Sequence[Operand]) -> Any:
    """Return the sum of products of values and factors, for registers or arrays of registers."""
    # Compute two partial sums, so that the processor can compute both at the same time.
    sums: list[Any] = []
    for x, factor in zip(values, factors, strict=True):
        sums.append(x * factor if len(sums) < 2 else fused(x, factor, sums[-2]))
    return sums[-2] + sums[-1] if len(sums) > 1 else sums[0]


def turns(x: Register) -> tuple[Register, Register]:
    """Return sine and cosine of angles up to a million."""
    shifted = fused(x, _TO_QUARTERS, _INTEGER)
    quarters = shifted - _INTEGER
    r = x
    for part in _QUARTER:
        r = fused(quarters, -part, r)
    square = r * r
    sine = fused(square * r, _polynomial(_SINE, square), r)
    cosine = fused(square * square, _polynomial(_COSINE, square), fused(square, -0.5, 1.0))
    count = shifted.cast("bitcast", INTEGERS)
    odd = count.cast("trunc", BITS)
    by_sine, by_cosine = odd.choose(cosine, sine), odd.choose(sine, cosine)
    return _signed(by_sine, count), _signed(by_cosine, count + 1)


def _polynomial(coefficients: Sequence[float], x: Register) -> Any:
    return reduce(lambda value, c: fused(x, value, c), coefficients)


def _signed(x: Register, quarters: Register) -> Register:
    """Change the sign of x where the number of quarter turns is 2 or 3 modulo 4."""
    sign = (quarters << 62) & -(2**63)
    return (x.cast("bitcast", INTEGERS) ^ sign).cast("bitcast", VECTOR)


_LEVEL = 3  # LLVM's optimisation level
ADDRESS, COUNT, NUMBER = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
"""ctypes of the arguments of a `function`."""
MOST_STEPS = 200_000
"""Limit on the steps of one run."""


def function(source: str, name: str, *signature: Any) -> Any:
    """Compile a function of an LLVM module for ctypes.

    Raises
    ------
    MissingPackageError
        llvmlite is not installed.
    """
    said = f"llvmlite is not installed; simulate needs it ({GENERATE})"
    llvm: Any = required("llvmlite.binding", said)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=_LEVEL
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(source), machine)
    engine.finalize_object()
    found: Any = ctypes.CFUNCTYPE(*signature)(engine.get_function_address(name))
    # The engine owns the code, so it must live as long as the callable.
    found.engine = engine
    return found
