"""The time that a processor needs for nothing but the products of Taylor steps.

A Taylor step of order n has (n + 1) (n + 2) / 2 products of numbers for each product of two
variables of the decomposition, each quotient, sine and cosine, and n + 1 for each product with a
constant. The peak is measured: fused products and sums of whole vectors that wait for nothing.
"""

import ctypes
from dataclasses import dataclass

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.workbench.bench.c_source import operations
from heyoka_bike.workbench.bench.problem import seconds
from heyoka_bike.workbench.fast.native import function
from heyoka_bike.workbench.fast.vector_code import POINTS, Code, Loop, fused, module

_CHAINS = 12  # more than a product takes cycles
_LOOPS, _TURNS, _RUNS = 5_000, 40, 20
_PRODUCTS = ("*", "/", "sin", "cos")


@dataclass(frozen=True, slots=True)
class Floor:
    """The least time of a run of Taylor steps on one processor of this machine.

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
    c = Code("void @peak(ptr)")
    (memory,) = c.arguments
    loops = c.variable(0)
    with Loop(c) as loop:
        loop.leave(loops[0] >= _LOOPS)
        values = memory.vectors().load(_CHAINS)
        # Every chain waits for its own products alone; memory is left out of most turns.
        for _ in range(_TURNS):
            values = fused(values, 0.5, values)
        memory.vectors().store(values)
        loops[0] += 1
    c.do("ret void")
    run = function(module(c), "peak", None, ctypes.c_void_p)
    numbers = (ctypes.c_double * (POINTS * _CHAINS))()
    shortest = min(seconds(lambda: run(numbers)) for _ in range(_RUNS))
    return _LOOPS * _TURNS * _CHAINS * POINTS / shortest
