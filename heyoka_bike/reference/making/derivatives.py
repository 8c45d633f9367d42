"""Derivatives of the columns of a maneuver with respect to the parameters and the start.

heyoka integrates the motion together with the derivatives of its state with respect to the initial
state and to the constants of the equations, in binary128, in the form that is regular at zero
trail. The chain rule leads from the unknowns (parameters and start) to these, and from these to the
columns. The result is stored as piecewise Chebyshev polynomials in binary64.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import flint
import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, Maneuver
from heyoka_bike.errors import InputError
from heyoka_bike.motion.expressions import Expressions, require_heyoka
from heyoka_bike.numbers.arithmetic import Balls, Multiprecision, Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.sensitivities import START, Sensitivity

Progress = Callable[[float], None]
"""Called with the time reached [s]."""

_NODES = 24
# The last coefficients are below this part of the largest value over the run, and what is left out
# is smaller still.
_TAIL = 1e-15
# Coefficients are multiples of this part of it (a power of two): the 24 of a piece are then good to
# 1e-14, and what decays to zero takes no space.
_GRID = 2.0**-50
_FIRST_WIDTH = Fraction(1)
_MIN_WIDTH = Fraction(1, 2**16)
# A derivative that moves a column by less than this part of it, when the unknown changes by itself,
# is zero and what is seen is roundoff of binary128 (33 digits).
_NOTHING = 1e-25
_SAMPLES = 201
# Differences over this step, with this many bits, are derivatives to 70 digits.
_STEP = Fraction(1, 2**240)
_BITS = 500
_DIGITS = 40
_ENERGY = [c.name for c in COLUMNS].index("mechanical_energy")


def differentiate(
    bicycle: Bicycle, maneuver: Maneuver, progress: Progress = lambda _: None
) -> Sensitivity:
    """Derivatives of all columns over the run of a maneuver, which must not meet a singularity.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    InputError
        The initial state is unreachable, or this build of heyoka has no binary128.
    """
    motion = _Motion(bicycle, maneuver, progress)
    scales = motion.scales()
    sizes = np.where(scales > 0, 2.0 ** np.ceil(np.log2(np.where(scales > 0, scales, 1.0))), 1.0)
    breaks, pieces, widths = [Fraction(0)], [], [_FIRST_WIDTH]
    while breaks[-1] < motion.end:
        a, width = breaks[-1], widths[-1]
        b = min(a + width, motion.end)
        relative = motion.coefficients(float(a), float(b)) / sizes
        relative[:, scales == 0] = 0.0
        tail = np.abs(relative[-3:]).sum(axis=0)
        if width > _MIN_WIDTH and np.fmax.reduce(tail, axis=None) > _TAIL:
            widths[-1:] = [width / 2, width / 2]
            continue
        widths.pop()
        if not widths:
            widths = [_FIRST_WIDTH]
        breaks.append(b)
        pieces.append(np.rint(relative / _GRID) * _GRID * sizes + 0.0)
    table = np.array(pieces)
    return Sensitivity(
        breaks=np.array([float(t) for t in breaks]),
        coefficients={c.name: np.ascontiguousarray(table[:, :, i]) for i, c in enumerate(COLUMNS)},
    )


class _Motion:
    """The motion of a maneuver and its first variations, at any time up to `end`."""

    def __init__(self, bicycle: Bicycle, maneuver: Maneuver, progress: Progress) -> None:
        hy = require_heyoka()
        if not hasattr(hy, "real128"):
            raise InputError("this build of heyoka has no binary128, expected one that has")
        self._real = hy.real128
        self.end = Fraction(math.ceil(maneuver.duration * 2**20), 2**20)
        self._sizes = _sizes(bicycle, maneuver)
        inputs, slopes = _inputs(bicycle, maneuver)
        parameters: list[Number] = []

        def parameter(_: Number) -> Number:
            parameters.append(hy.par[len(parameters)])
            return parameters[-1]

        exact = Equations.of(bicycle, Multiprecision(_DIGITS))
        equations = replace(exact, k=exact.k.convert(parameter), a=Expressions())
        state = list(hy.make_vars(*equations.states))
        rates, values = equations.rates_with_yaw(state), equations.columns(state)
        there = {str(p) for p in hy.get_params(rates)}
        used = [i for i, p in enumerate(parameters) if str(p) in there]

        count = len(state)
        self._constants = self._numbers(inputs[count:])
        integrator = hy.taylor_adaptive(
            hy.var_ode_sys(
                list(zip(state, rates, strict=True)),
                [*state, *(parameters[i] for i in used)],
                order=1,
            ),
            self._numbers(inputs[:count]),
            pars=self._constants[: max(used) + 1],
            fp_type=self._real,
            compact_mode=True,
        )
        watch = _watch(progress, float(maneuver.duration))
        end = self._numbers([flint.arb(flint.fmpq(self.end.numerator, self.end.denominator))])[0]
        # The dense solution, of the state and then of its variations.
        self._motion = integrator.propagate_until(end, c_output=True, callback=watch)[4]
        self._effect = _effect(hy, state, parameters, used, [values[c.name] for c in COLUMNS])
        # Of each unknown: its effect on the start and the constants in the equations, and on all
        # constants, as `_effect` takes them.
        chosen = [*range(count), *(count + i for i in used), *range(count, len(inputs))]
        self._by_unknown = np.array([self._numbers([s[i] for i in chosen]) for s in slopes])
        # Chebyshev nodes of the first kind, and from values there to coefficients.
        with flint.ctx.workprec(_BITS):
            angles = [flint.fmpq(2 * j + 1, 2 * _NODES) for j in range(_NODES)]
            nodes = [flint.arb.cos_pi_fmpq(x) for x in angles]
            orders = [
                [flint.arb.cos_pi_fmpq(i * x) * min(i + 1, 2) / _NODES for x in angles]
                for i in range(_NODES)
            ]
        self._nodes = self._numbers(nodes)
        self._transform = np.array([self._numbers(row) for row in orders])
        self._energy = self._evaluated(self._motion(self._numbers([flint.arb(0)])))[0, _ENERGY]

    def scales(self) -> Array:
        """Largest derivatives over the run, shape (columns, unknowns)."""
        spread = np.linspace(-1, 1, _SAMPLES).astype(self._real)
        found = np.max(np.abs(self._at(0.0, float(self.end), spread).astype(np.float64)), axis=0)
        effects = found * self._sizes
        largest = np.fmax.reduce(effects, axis=1, keepdims=True)
        return np.where(effects < _NOTHING * largest, 0.0, found)

    def coefficients(self, a: float, b: float) -> Array:
        """Chebyshev coefficients on the piece [a, b], shape (orders, columns, unknowns)."""
        values = self._at(a, b, self._nodes)
        found = values[:1] * self._transform[:, 0, None, None]
        for j in range(1, _NODES):
            found += values[j] * self._transform[:, j, None, None]
        array: Array = found.astype(np.float64)
        return array

    def _at(self, a: float, b: float, x: NDArray[Any]) -> NDArray[Any]:
        """Derivatives at (a + b) / 2 + x (b - a) / 2, shape (times, columns, unknowns)."""
        middle, half = (self._real(v) for v in ((a + b) / 2, (b - a) / 2))
        found = self._evaluated(self._motion(middle + half * x))
        # The energy stays that of the start. Variations that grow would add up to it only as far
        # as their own roundoff.
        found[:, _ENERGY] = self._energy
        return found

    def _evaluated(self, states: NDArray[Any]) -> NDArray[Any]:
        """Derivatives at some states and their variations, shape (times, columns, unknowns)."""
        times, unknowns = len(states), len(self._by_unknown)
        rows = np.concatenate(
            [np.repeat(states, unknowns, axis=0), np.tile(self._by_unknown, (times, 1))], axis=1
        )
        constants = np.broadcast_to(self._constants[:, None], (len(self._constants), len(rows)))
        found = self._effect(np.ascontiguousarray(rows.T), pars=np.ascontiguousarray(constants))
        array: NDArray[Any] = found.reshape(len(COLUMNS), times, unknowns)
        return array.transpose(1, 0, 2)

    def _numbers(self, values: Sequence[flint.arb]) -> NDArray[Any]:
        """Balls as binary128."""
        with flint.ctx.workprec(_BITS):
            return np.array([self._real(x.mid().str(_DIGITS, radius=False)) for x in values])


def _effect(
    hy: Any, state: Sequence[Number], parameters: Sequence[Number], used: Sequence[int],
    values: Sequence[Number],
) -> Any:  # fmt: skip
    """Compiled derivatives of the columns along a direction.

    Its arguments: the state; its variations, row by row; how the start and the constants in the
    equations change along the direction; how all constants do.
    """
    arguments = [*(str(x) for x in state), *(f"c{i}" for i in used)]
    variations = [[hy.make_vars(f"d_{x}_{y}") for y in arguments] for x in state]
    start = [hy.make_vars(f"by_{y}") for y in arguments]
    change = [hy.make_vars(f"by_constant_{i}") for i in range(len(parameters))]
    moved = [hy.sum([s * d for s, d in zip(row, start, strict=True)]) for row in variations]
    tensor = hy.diff_tensors(list(values), diff_args=[*state, *parameters], diff_order=1)
    effects = []
    for i in range(len(values)):
        slopes = [e for _, e in tensor.get_derivatives(1, i)]
        effects.append(hy.sum([s * d for s, d in zip(slopes, [*moved, *change], strict=True)]))
    flat = [x for row in variations for x in row]
    return hy.cfunc(
        effects,
        vars=[*state, *flat, *start, *change],
        fp_type=hy.real128,
        compact_mode=True,
    )


def _inputs(bicycle: Bicycle, maneuver: Maneuver) -> tuple[list[flint.arb], list[list[flint.arb]]]:
    """The state at t = 0 and the constants of the equations, and their derivatives by unknown."""
    balls = Balls(_BITS)
    with balls.precision():

        def numbers(b: Bicycle, m: Maneuver) -> list[flint.arb]:
            equations = Equations.of(b, balls)
            found = initial_state(equations, m)
            equations.k.convert(found.append)
            return found

        here = numbers(bicycle, maneuver)
        there = []
        for symbol in PARAMETERS:
            values = {**bicycle.values, symbol: _moved(bicycle[symbol])}
            there.append(numbers(Bicycle(bicycle.name, values), maneuver))
        for key in START:
            moved: dict[str, Any] = {key: _moved(getattr(maneuver, key))}
            there.append(numbers(bicycle, replace(maneuver, **moved)))
        step = flint.arb(flint.fmpq(_STEP.numerator, _STEP.denominator))
        return here, [[(y - x) / step for x, y in zip(here, t, strict=True)] for t in there]


def _moved(x: Exact) -> Exact:
    return Exact(x.rational + _STEP, x.pi_multiple)


def _sizes(bicycle: Bicycle, maneuver: Maneuver) -> Array:
    """Size of each unknown, one where it is zero."""
    values = [bicycle[s] for s in PARAMETERS] + [getattr(maneuver, s) for s in START]
    return np.array([abs(float(x)) or 1.0 for x in values])


def _watch(progress: Progress, duration: float) -> Callable[[Any], bool]:
    def report(integrator: Any) -> bool:
        progress(min(float(integrator.time), duration))
        return True

    return report
