"""The end of a motion in binary128 or with any number of digits, fast, without rows.

Collocation at Radau's points, as many as the precision asks for: at its end a step is right to
twice the order of its polynomial, so that half as many coefficients serve as in a Taylor step, and
their number is multiplied, not squared, into what a step costs. The system of a step is solved in
binary64 with the Jacobians of all points; a few more iterations, whose residuals alone are
evaluated in the full precision, each give the digits that binary64 has. `integrate` is what the
reference is made with: it keeps whole polynomials.
"""

import math
from collections.abc import Callable
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import SingularMotionError
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.motion.integrate import Native, right_hand_side
from heyoka_bike.numbers.arithmetic import Balls, midpoint
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.precision import Precision

STATE = 6
_GUARD = 64  # bits of the constants beyond those of the run
_BITS_A_POINT = 7.0  # points of a step, for a precision
_FIRST = 0.05  # [s]
_SHORTEST = 2.0**-30  # [s]
_SAFETY, _LEAST, _MOST = 0.9, 0.25, 2.0  # of a change of the step
_REPEATED = 2.0**10  # a step whose last coefficient is so much over its limit is made again
_RATE, _SLOW = 1e-6, 0.5  # of the first iteration, as it is expected; one that is given up
_BINARY64, _ITERATIONS = 1e-11, 12  # where the iteration in binary64 ends; most of both kinds


class End:
    """A motion that is ready to be carried out, again and again.

    Parameters
    ----------
    bicycle, maneuver
        What is integrated, in the few-product form.
    precision
        See `Precision.of`.

    Attributes
    ----------
    points
        Of a step.
    steps
        How many the last call took.

    Raises
    ------
    InputError
        The initial state is unreachable.
    MissingPackageError
        heyoka is not installed.
    """

    def __init__(
        self, bicycle: Bicycle, maneuver: Maneuver, precision: Precision | str | int
    ) -> None:
        precision = precision if isinstance(precision, Precision) else Precision.of(precision)
        self._bits, self._native = precision.bits, Native(precision)
        self.points, self.steps = max(8, round(precision.bits / _BITS_A_POINT)), 0
        self._duration = maneuver.duration
        self._rates, self._jacobian = _compiled(bicycle, precision, self._native)
        equations = Equations.of(bicycle, Balls(precision.bits + _GUARD), is_regular=False)
        with equations.precision():
            start = initial_state(equations, maneuver)[:STATE]
            integral, last = _radau(self.points)
            self._start = np.array([self._number(x) for x in start])
            self._integral = np.array([[self._number(x) for x in row] for row in integral])
            self._last = np.array([self._number(x) for x in last])
        self._integral64 = self._integral.astype(float)

    def __call__(self) -> Any:
        """The state at the end, without the yaw: an array of the precision's numbers.

        Raises
        ------
        SingularMotionError
            The motion meets a singularity, or zero trail, before its end.
        """
        duration = float(self._duration)
        # Dyadic steps: their sum is exact, and so is the rest.
        y, t, wish, steps = self._start, 0.0, _FIRST, 0
        limit = 2.0 ** (-self._bits / 2)
        while t < duration:
            h = min(_dyadic(wish), duration - t)
            found = self._step(y, h) if h >= _SHORTEST else None
            if found is None:
                if h < _SHORTEST:
                    raise SingularMotionError(f"the motion meets a singularity at t = {t:.9g} s", t)
                wish = h / 2
                continue
            after, tail = found
            change = (limit / max(tail, 1e-300)) ** (1 / self.points)
            wish = h * min(_MOST, max(_LEAST, _SAFETY * change))
            if tail > _REPEATED * limit:
                continue
            y, t, steps = after, t + h, steps + 1
        self.steps = steps
        return y

    def _number(self, x: flint.arb) -> Any:
        return self._native.from_integer(*midpoint(x))

    def _step(self, y: Any, h: float) -> tuple[Any, float] | None:
        """State after a step, and the last coefficient of its derivative's Legendre series."""
        solved = self._binary64(y.astype(float), h)
        if solved is None:
            return None
        z, inverse = solved
        length = self._native.from_integer(*_integer(h))
        # Numbers of MPFR have the larger one of two precisions.
        z = z.astype(y.dtype) + self._native.from_integer(0, 0)
        size = math.inf
        for _ in range(_ITERATIONS + self._bits // 16):
            slopes = self._rates(np.ascontiguousarray((y + z).T)).T
            # `@` takes ten times as long in binary128 as operations on arrays, in MPFR half.
            product = (
                self._integral @ slopes if self._native.is_mpfr else _sums(self._integral, slopes)
            )
            rest = length * product - z
            change = (inverse @ rest.astype(float).ravel()).reshape(z.shape)
            before, size = size, float(np.abs(change).max())
            z = z + change.astype(y.dtype)
            # What is left after this change, by the rate of the last two.
            rate = size / before if before < math.inf else _RATE
            if size * rate < 2.0 ** (-self._bits - 2):
                tail = np.abs((self._last @ slopes).astype(float)).max()
                return y + z[-1], h * float(tail)
            # What the precision cannot resolve is no failure: the state is some units large.
            if not rate < _SLOW and size > 2.0 ** (8 - self._bits):
                break
        return None

    def _binary64(self, y: Array, h: float) -> tuple[Array, Array] | None:
        """Increments at the points in binary64, and the inverse of the system's Jacobian there."""
        s, z = self.points, np.zeros((self.points, STATE))
        size = math.inf
        for _ in range(_ITERATIONS):
            at = np.ascontiguousarray((y + z).T)
            slopes, jacobian = self._jacobian(at)
            blocks = h * self._integral64[:, None, :, None] * jacobian.transpose(0, 2, 1)[None]
            system = np.eye(STATE * s) - blocks.reshape(STATE * s, -1)
            if size < _BINARY64:
                inverse: Array = np.linalg.inv(system).astype(float)
                return z, inverse
            rest = h * (self._integral64 @ slopes.T) - z
            change = np.linalg.solve(system, rest.ravel()).reshape(z.shape)
            size = float(np.abs(change).max())
            z += change
            if not size < 1e3:
                return None
        return None


def _compiled(
    bicycle: Bicycle, precision: Precision, native: Native
) -> tuple[Callable[[Any], Any], Callable[[Array], tuple[Array, Array]]]:
    """Rates of columns of states in the precision; rates and Jacobians in binary64."""
    hy = require_heyoka()
    options: dict[str, Any] = {"prec": native.bits} if native.is_mpfr else {}
    system = right_hand_side(bicycle, precision, with_yaw=False)
    rates = hy.cfunc([r for _, r in system], [x for x, _ in system], fp_type=native.type, **options)
    system = right_hand_side(bicycle, Precision.of("binary64"), with_yaw=False)
    state = [x for x, _ in system]
    tensors = hy.diff_tensors([r for _, r in system], diff_args=state, diff_order=1)
    # Loops are kept: what is compiled in a second and not in ten takes a tenth of a step.
    both = hy.cfunc([*(r for _, r in system), *tensors.jacobian.ravel()], state, compact_mode=True)

    def jacobian(at: Array) -> tuple[Array, Array]:
        found = both(at)
        return found[:STATE], found[STATE:].reshape(STATE, STATE, -1)

    return rates, jacobian


def _sums(matrix: Any, columns: Any) -> Any:
    """Matrix times columns, by operations on arrays."""
    found = matrix[:, :1] * columns[:1]
    for j in range(1, len(columns)):
        found = found + matrix[:, j : j + 1] * columns[j : j + 1]
    return found


def _radau(s: int) -> tuple[list[list[flint.arb]], list[flint.arb]]:
    """Radau's method of s points, in the working precision of balls.

    Returns
    -------
    integral
        From derivatives at the points to increments since the beginning, over the length.
    last
        From derivatives to their last Legendre coefficient.
    """
    near = np.polynomial.legendre.legroots([0.0] * (s - 1) + [-1.0, 1.0]).real
    points = [_root(s, float(x)) for x in np.sort(near)[:-1]] + [flint.arb(1)]
    values = [_legendre(s, x) for x in points]
    # Radau's weights on -1 to 1; half of them on 0 to 1.
    weights = [(1 + x) / (s * v[s - 1]) ** 2 / 2 for x, v in zip(points, values, strict=True)]
    integrals = flint.arb_mat(
        [
            [(x + 1) / 2, *((v[k + 1] - v[k - 1]) / (2 * (2 * k + 1)) for k in range(1, s))]
            for x, v in zip(points, values, strict=True)
        ]
    )
    series = flint.arb_mat(
        [[(2 * k + 1) * w * v[k] for w, v in zip(weights, values, strict=True)] for k in range(s)]
    )
    product = integrals * series
    table = [[product[i, j] for j in range(s)] for i in range(s)]
    return table, [series[s - 1, j] for j in range(s)]


def _root(s: int, x: float) -> flint.arb:
    """Zero of P_s - P_(s-1) by Newton's method; the radius of the balls plays no part."""
    at = flint.arb(x)
    for _ in range(3 + flint.ctx.prec.bit_length()):
        v = _legendre(s, at)
        square = 1 - at * at
        slope = s * (v[s - 1] - at * v[s]) - (s - 1) * (v[s - 2] - at * v[s - 1])
        at = (at - (v[s] - v[s - 1]) * square / slope).mid()
    return at


def _legendre(s: int, x: flint.arb) -> list[flint.arb]:
    """Legendre's polynomials of degrees 0 to s."""
    found = [flint.arb(1), x]
    for k in range(1, s):
        found.append(((2 * k + 1) * x * found[k] - k * found[k - 1]) / (k + 1))
    return found


def _dyadic(h: float) -> float:
    """The largest number of a few bits that is no larger."""
    mantissa, exponent = math.frexp(h)
    return math.ldexp(math.floor(mantissa * 256), exponent - 8)


def _integer(h: float) -> tuple[int, int]:
    n, d = h.as_integer_ratio()
    return n, d.bit_length() - 1
