"""The interface to heyoka: the one module that uses its API.

All other modules use the expressions, integrators, compiled functions and number types defined
here; an import contract and a test enforce this. If heyoka changes a name, only this module
changes.

heyoka's formula for the Taylor order belongs to the interface: the order is
``ceil(1 - log(tolerance) / 2)`` (Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904, as
documented by heyoka).
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from heyoka_bike.errors import GENERATE, InputError, required
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision

CACHE_LIMIT = 2**30
"""Limit on the compiled code that heyoka caches on disk [bytes]; its own limit is 20 times this."""


def require_heyoka() -> None:
    """Raise an error if heyoka is not installed, before any long work begins.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """
    _heyoka()


def version() -> str:
    """Return the version of heyoka."""
    return str(_heyoka().__version__)


def has_binary128() -> bool:
    """True if this build of heyoka has numbers of 128 bits."""
    return hasattr(_heyoka(), "real128")


def _heyoka() -> Any:
    """Import heyoka, with its cache of compiled code on disk if that is possible."""
    module = required(
        "heyoka",
        f"heyoka is not installed; integration needs it ({GENERATE} on Linux, or conda install "
        "heyoka.py)",
    )
    _limit_cache(module)
    return module


@cache
def _limit_cache(module: Any) -> None:
    """Limit the cache, and switch it off if its folder is not writable.

    heyoka would print a message in the middle of a report. Without a home folder, as in a container
    or a cron job, heyoka has no place for its cache.
    """
    state = module.llvm_state
    folder = state.get_diskcache_path()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_usable = folder.is_absolute() and os.access(folder, os.W_OK)
    except OSError:
        is_usable = False
    if is_usable:
        state.set_diskcache_limit(min(state.get_diskcache_limit(), CACHE_LIMIT))
    else:
        state.set_diskcache_enabled(False)


@contextmanager
def caches_off() -> Iterator[None]:
    """Compile everything again, as on the first run: without the caches on disk and in memory."""
    state = _heyoka().llvm_state
    was_enabled = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    state.clear_memcache()
    try:
        yield
    finally:
        state.set_diskcache_enabled(was_enabled)


# This part of the module wraps heyoka's numbers and expressions.


class NativeNumbers:
    """heyoka's number type for a precision, and exact conversions from and to integers.

    Attributes
    ----------
    bits
        Bits of the mantissa.
    is_mpfr
        True if the numbers can have any length.
    type : callable
        Converts a Python number, or a text if Python's numbers are too short.

    Raises
    ------
    InputError
        The machine or this build of heyoka does not support these numbers.
    """

    def __init__(self, precision: Precision) -> None:
        hy = _heyoka()
        self.bits = precision.bits
        self.is_mpfr = precision.name.endswith("digits")
        if self.is_mpfr:
            # Without this handler the memory of the digits of heyoka.real in NumPy arrays is never
            # freed.
            hy.install_custom_numpy_mem_handler()
            self.type: Any = hy.real
        elif precision.name == "binary64":
            self.type = float
        elif precision.name == "longdouble":
            if np.finfo(np.longdouble).nmant != 63:
                raise InputError("this machine's long double is not the 80-bit format")
            self.type = np.longdouble
        else:
            if not has_binary128():
                raise InputError("this build of heyoka has no binary128")
            self.type = hy.real128

    def from_integer(self, n: int, grid: int) -> Any:
        """Return the value n 2^-grid, correctly rounded to the precision."""
        # The conversion of an integer is correctly rounded and the scaling is exact, so the result
        # is correctly rounded.
        x, scale = self._number(n), self._number(1 << abs(grid))
        return x / scale if grid > 0 else x * scale

    def to_integer(self, x: Any, shift: int) -> int:
        """Return the value times 2^shift, truncated to an integer."""
        if self.type is float:
            n, d = float(x).as_integer_ratio()
            return (n << shift) // d
        return int(x * self._number(1 << shift))

    def _number(self, n: int) -> Any:
        # Convert through text, because NumPy would round a Python integer to binary64.
        return self.type(n, self.bits) if self.is_mpfr else self.type(str(n))


class Expressions(Arithmetic):
    """Expressions whose constants are exact in one precision.

    Constants come from `Constants.convert`. The equations themselves contain only the integers 0, 1
    and 2, which are exact in every format.
    """

    def number(self, value: Exact | Fraction | int) -> Number:
        raise TypeError("constants of an expression are made by Constants.convert")

    def elementary(self, name: str, x: Number) -> Number:
        return getattr(_heyoka(), name)(x)

    def atan2(self, y: Number, x: Number) -> Number:
        return _heyoka().atan2(y, x)

    def sum(self, terms: Iterable[Number]) -> Number:
        return _heyoka().sum([as_expression(x) for x in terms])


def constant(number: Any) -> Any:
    """Convert a number of one of heyoka's types to an expression."""
    return _heyoka().expression(number)


def as_expression(x: Any) -> Any:
    """Return an expression unchanged, and an integer or a float as a constant."""
    return x if isinstance(x, _heyoka().expression) else constant(float(x))


def variables(names: Iterable[str]) -> list[Any]:
    """Return variables of these names; equal names give the same variable."""
    found = _heyoka().make_vars(*names)
    return list(found) if isinstance(found, list | tuple) else [found]


def parameter(index: int) -> Any:
    """Return the runtime parameter of this index."""
    return _heyoka().par[index]


class Compiled:
    """A compiled function that evaluates expressions of variables.

    Parameters
    ----------
    expressions, of
        The expressions, and their variables in the order of the rows of the input.
    number
        The number type; None for binary64.
    is_fast
        True if multiplications and additions may be fused.

    Attributes
    ----------
    parameters
        Number of constants that are passed at run time.
    """

    def __init__(
        self, expressions: Sequence[Any], of: Sequence[Any], number: Any = None,
        *, is_fast: bool = False,
    ) -> None:  # fmt: skip
        hy = _heyoka()
        more = {} if number is None else {"fp_type": number}
        self._function = hy.cfunc(list(expressions), list(of), fast_math=is_fast, **more)
        self.parameters: int = self._function.nparams

    def __call__(self, values: Array, parameters: Array | None = None) -> Any:
        """Return the values of the expressions, shape (expressions,) or (expressions, n).

        Parameters
        ----------
        values : ndarray, shape (variables,) or (variables, n)
        parameters : ndarray, shape (parameters,) or (parameters, n)
        """
        more = {} if parameters is None else {"pars": np.ascontiguousarray(parameters)}
        return self._function(np.ascontiguousarray(values), **more)


# This part of the module wraps heyoka's integrators.


def order_of(bits: float) -> int:
    """Return the order of heyoka's Taylor steps for a tolerance of 2^-bits."""
    return math.ceil(1 + bits * math.log(2) / 2)


def tolerance_of(order: int) -> float:
    """Return a tolerance for which heyoka chooses this order."""
    return math.exp(-2 * (order - 1.5))


class Outcome(Enum):
    """The reason why a step ended."""

    TAKEN = "as long as the tolerance allows"
    LIMITED = "as long as it may be"
    NOT_FINITE = "at a state that is not finite"


@dataclass(frozen=True, slots=True)
class TaylorStep:
    """The result of a Taylor step.

    Attributes
    ----------
    outcome : Outcome
    length
        Length of the step [s], as heyoka chooses it.
    coefficients : ndarray, shape (variables, order + 1)
        Coefficients of the state in the time since the beginning of the step, in native numbers.
    """

    outcome: Outcome
    length: float
    coefficients: Any


class TaylorIntegrator:
    """heyoka's adaptive Taylor integrator.

    Parameters
    ----------
    system
        Pairs of a variable and its time derivative.
    start
        The state, in native numbers.
    number
        The number type.
    bits
        Bits of the numbers if they can be chosen; None for the other types.
    tolerance
        Relative tolerance in native numbers; by default heyoka's own.
    is_compact
        True if the compiled code keeps its loops; False if they are unrolled.
    is_optimised
        True if the compiled code is optimised.
    """

    def __init__(
        self, system: Sequence[tuple[Any, Any]], start: Sequence[Any] | Array, number: Any,
        *, bits: int | None = None, tolerance: Any = None, is_compact: bool = True,
        is_optimised: bool = True,
    ) -> None:  # fmt: skip
        hy = _heyoka()
        options: dict[str, Any] = {} if tolerance is None else {"tol": tolerance}
        if bits is not None:
            options["prec"] = bits
        if not is_optimised:
            options["opt_level"] = 0
        self._adaptive = hy.taylor_adaptive(
            list(system), list(start), fp_type=number, compact_mode=is_compact, **options
        )
        outcomes = hy.taylor_outcome
        self._outcomes: Mapping[Any, Outcome] = {
            outcomes.success: Outcome.TAKEN,
            outcomes.time_limit: Outcome.LIMITED,
        }

    @property
    def order(self) -> int:
        """Taylor order."""
        return int(self._adaptive.order)

    @property
    def tolerance(self) -> float:
        """Relative tolerance of the steps."""
        return float(self._adaptive.tol)

    @property
    def state(self) -> Array:
        """The state in native numbers, shape (variables,)."""
        found: Array = self._adaptive.state
        return found

    def begin(self, time: Any, state: Sequence[Any] | Array) -> None:
        """Set the time and the state at which the next step begins."""
        self._adaptive.time = time
        self._adaptive.state[:] = state

    def step(self, longest: Any) -> TaylorStep:
        """Take one step of at most this length."""
        outcome, _ = self._adaptive.step(max_delta_t=longest, write_tc=True)
        found = self._outcomes.get(outcome, Outcome.NOT_FINITE)
        return TaylorStep(found, float(self._adaptive.last_h), self._adaptive.tc)

    def until(self, end: Any) -> None:
        """Integrate up to the time `end`."""
        self._adaptive.propagate_until(end)

    def over(self, times: Array) -> tuple[Array, int]:
        """Return the states at some times, shape (n, variables), and the number of steps.

        There are fewer states than times if the motion ends early.
        """
        *_, steps, _, rows = self._adaptive.propagate_grid(times)
        return rows, int(steps)


@dataclass(frozen=True, slots=True)
class Lanes:
    """Results of motions that were integrated side by side, each in a lane of a vector.

    Attributes
    ----------
    samples : ndarray, shape (times, variables, lanes)
    times : ndarray, shape (lanes,)
        The times that were reached.
    are_interrupted : list of bool
        True if a motion stopped because another motion of its vector had ended.
    steps : list of int
    """

    samples: Array
    times: Array
    are_interrupted: list[bool]
    steps: list[int]


class TaylorBatch:
    """Integrator of motions side by side, each in a lane of a vector with its own steps.

    Parameters
    ----------
    system
        Pairs of a variable and its time derivative.
    order
        Order of the Taylor steps.
    ends
        Expressions; a motion ends where one of them is zero.

    Attributes
    ----------
    lanes
        Number of motions in a vector.
    parameters
        Number of constants that are passed at run time.
    """

    def __init__(self, system: Sequence[tuple[Any, Any]], order: int, ends: Sequence[Any]) -> None:
        hy = _heyoka()
        self.lanes = int(hy.recommended_simd_size())
        self._adaptive = hy.taylor_adaptive_batch(
            list(system),
            [[1.0] * self.lanes for _ in system],
            tol=tolerance_of(order),
            compact_mode=False,
            fast_math=True,
            t_events=[hy.t_event_batch(x) for x in ends],
        )
        self._interrupted = hy.taylor_outcome.success
        self.parameters: int = len(self._adaptive.pars)

    def over(
        self, states: Array, times: Array, parameters: Array | None = None, *, most_steps: int
    ) -> Lanes:
        """Integrate the motions from time 0, and return their states at given times.

        Parameters
        ----------
        states : ndarray, shape (variables, lanes)
        times : ndarray, shape (n, lanes)
        parameters : ndarray, shape (parameters, lanes)
        most_steps
            Limit on the steps of each motion.
        """
        ta = self._adaptive
        ta.set_time(0.0)
        ta.state[:] = states
        if parameters is not None:
            ta.pars[:] = parameters
        samples = ta.propagate_grid(times, max_steps=most_steps)[-1]
        results = ta.propagate_res
        return Lanes(
            samples,
            np.array(ta.time),
            [result[0] == self._interrupted for result in results],
            [int(result[3]) for result in results],
        )
