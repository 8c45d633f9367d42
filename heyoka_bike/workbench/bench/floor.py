"""The time that a processor needs for nothing but the products of Taylor steps.

A Taylor step of order n has (n + 1) (n + 2) / 2 products of numbers for each product of two
variables of the decomposition, each quotient, sine and cosine, and n + 1 for each product with a
constant. The peak is measured: fused products and sums of whole vectors that wait for nothing.
"""

import ctypes
import time
from dataclasses import dataclass

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.workbench.bench.c_source import operations
from heyoka_bike.workbench.fast.collocation import POINTS
from heyoka_bike.workbench.fast.native import compiled
from heyoka_bike.workbench.fast.vector_code import DECLARATIONS, WHOLE, Code, constant, function

_CHAINS, _LOOPS, _RUNS = 12, 200_000, 20  # chains: more than a product takes cycles
_PRODUCTS = ("*", "/", "sin", "cos")


@dataclass(frozen=True, slots=True)
class Floor:
    """What a run of Taylor steps takes at least on one processor of this machine.

    Attributes
    ----------
    products_per_second
        The peak, of products with a sum, in binary64.
    products
        Of variables of the decomposition: quotients, sines and cosines counted as such.
    scales
        Products of a variable with a constant.
    """

    products_per_second: float
    products: int
    scales: int

    def seconds(self, order: int, steps: int) -> float:
        """Of so many steps of an order [s]."""
        count = (order + 1) * (self.products * (order + 2) / 2 + self.scales)
        return steps * count / self.products_per_second


def floor(bicycle: Bicycle) -> Floor:
    """The floor for a bicycle's equations, measured now."""
    count = operations(bicycle)
    return Floor(_peak(), sum(count.get(x, 0) for x in _PRODUCTS), count["scale"])


def _peak() -> float:
    c = Code()
    starts = [c.load("%x", 0) for _ in range(_CHAINS)]
    c.do("br label %loop")
    c.label("loop")
    c.lines.append("  %i = phi i64 [ 0, %0 ], [ %next, %loop ]")
    c.lines += [
        f"  %v{i} = phi {WHOLE} [ {x}, %0 ], [ %w{i}, %loop ]" for i, x in enumerate(starts)
    ]
    factor = constant(WHOLE, 0.5)
    for i in range(_CHAINS):
        of = f"{WHOLE} %v{i}, {WHOLE} {factor}, {WHOLE} %v{i}"
        c.lines.append(f"  %w{i} = call {WHOLE} @llvm.fmuladd.v{POINTS}f64({of})")
    c.lines.append("  %next = add i64 %i, 1")
    c.do(f"br i1 {c.assign(f'icmp slt i64 %next, {_LOOPS}')}, label %loop, label %out")
    c.label("out")
    for i in range(_CHAINS):
        c.store(f"%w{i}", "%x", i)
    c.do("ret void")
    engine = compiled(function("void @peak(ptr %x)", c.lines) + DECLARATIONS)
    run = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(engine.get_function_address("peak"))
    room = (ctypes.c_double * (POINTS * _CHAINS))()
    times = []
    for _ in range(_RUNS):
        begin = time.perf_counter()
        run(room)
        times.append(time.perf_counter() - begin)
    return _LOOPS * _CHAINS * POINTS / min(times)
