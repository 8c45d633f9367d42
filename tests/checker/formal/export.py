"""Write the equations and a certificate of maneuver 3, its first second, for Coq.

``python tests/checker/formal/export.py FOLDER`` writes ``Equations.v``, the equations of motion as
a program for CoqInterval, and ``Certificate.v``, polynomials with short dyadic coefficients and
the numbers of their proof. Nothing in it has to be believed: Coq checks the certificate, and the
equations are what the theorem speaks of.
"""

import math
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path

import flint
import numpy as np

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Maneuver, benchmark
from heyoka_bike.numbers.analytic import AtPoints
from heyoka_bike.numbers.arithmetic import Arithmetic, Arrays, Balls
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.exact import Exact

BITS = 200
GRID = 52  # Coefficients are integers over 2 to this power,
SQUARES = 160  # squared errors over this one,
RATES = 4  # growth rates over this one.
PIECES, STEP = 32, Fraction(1, 32)  # [s]
DEGREE, EXACT_DEGREE = 16, 26  # of the certificate, and of the motion that it is taken from
ERROR = Fraction(1, 10**8)  # what is claimed [rad, rad/s], as in Enclosure.v
ETA = Fraction(1, 2**10)  # how a jump is shared between the squares, see Enclosure.v
# Thresholds of errors, in 12ths, and numbers that balance rows: those of Enclosure.v. They keep the
# growth rate small.
THRESHOLDS = (12, 1, 4, 36, 72, 144, 192)
BALANCE = (60, 20, 96, 100, 38, 20, 6)
READING = Fraction(1, 10**29)  # squared: of numbers read into binary64 intervals
# Of the defect over weights, in binary64 intervals, by variable: seen, with a margin.
ROUNDING = (1e-14, 2e-12, 1e-14, 1e-13, 5e-13, 1e-14, 1e-14)


class Node:
    """A value of the program: an input or the result of an operation."""

    def __init__(self, tape: "Tape", key: tuple) -> None:
        self.tape, self.key = tape, key

    def __add__(self, other):
        return self.tape.sum_of(self, other)

    __radd__ = __add__

    def __sub__(self, other):
        return self.tape.difference(self, other)

    def __rsub__(self, other):
        return self.tape.difference(other, self)

    def __mul__(self, other):
        return self.tape.product(self, other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self if other == 1 else self.tape.node("Div", self, other)

    def __rtruediv__(self, other):
        return other if other == 0 else self.tape.node("Div", other, self)

    def __neg__(self):
        return self.tape.node("Neg", self)


class Tape(Arithmetic):
    """An `Arithmetic` that records operations; rational numbers stay exact fractions."""

    def __init__(self) -> None:
        self.nodes: dict[tuple, Node] = {}
        self.pi = self.node("pi")

    def node(self, *key) -> Node:
        """The one value with this operation and these operands."""
        key = tuple(self.fraction(x) if isinstance(x, int | Fraction) else x for x in key)
        return self.nodes.setdefault(key, Node(self, key))

    def state(self, i: int) -> Node:
        return self.node("state", str(i))

    def fraction(self, x: Fraction | int) -> Node:
        x = Fraction(x)
        over = (self.node("integer", str(n)) for n in (x.numerator, x.denominator))
        return next(over) if x.denominator == 1 else self.node("Div", *over)

    def number(self, value):
        if not isinstance(value, Exact):
            return value
        if value.is_rational:
            return value.rational
        return self.product(self.pi, value.pi_multiple) + value.rational

    def elementary(self, name: str, x) -> Node:
        return self.node(name.capitalize(), x)

    def sum(self, terms: Iterable):
        return sum(terms)

    def sum_of(self, x, y):
        if y == 0:
            return x
        return self.node("Add", x, y)

    def difference(self, x, y):
        if y == 0:
            return x
        return -y if x == 0 else self.node("Sub", x, y)

    def product(self, x, y):
        if y == 0:
            return Fraction(0)
        return x if y == 1 else self.node("Mul", x, y)


def equations_file(equations: Equations) -> str:
    """The program: operations whose operands are counted back on a growing stack."""
    tape = Tape()
    exact = Equations.of(equations.bicycle, tape)
    count = len(exact.states)
    rates = exact.rates_with_yaw([tape.state(i) for i in range(count)])
    order: dict[Node, None] = {}
    for rate in rates:
        _visit(rate, order)
    leaves = ("state", "integer", "pi")
    integers = [x for x in order if x.key[0] == "integer"]
    inputs = [*(tape.state(i) for i in range(count)), *integers, tape.pi]
    steps = [x for x in order if x.key[0] not in leaves] + rates[::-1]
    names = {x: f"v{i}" for i, x in enumerate(inputs)}
    place, lines = {x: -1 - i for i, x in enumerate(inputs)}, []
    for i, x in enumerate(steps):
        if x in place:
            lines.append(
                (f"Forward {i - 1 - place[x]}", f"rate of {exact.states[len(steps) - 1 - i]}")
            )
            continue
        operation, *operands = x.key
        names[x] = f"v{len(names)}"
        kind = "Binary" if len(operands) == 2 else "Unary"
        words = [kind, operation, *(str(i - 1 - place[y]) for y in operands)]
        said = " ".join([operation, *(names[y] for y in operands)])
        lines.append((" ".join(words), f"{names[x]} = {said}"))
        place[x] = i
    said = "; ".join(f"v{i} {name}" for i, name in enumerate(exact.states))
    program = ";\n".join(f"  {term} (* {about} *)" for term, about in lines)
    return f"""(* The equations of motion of the benchmark bicycle, written by export.py.

   A program of CoqInterval: each operation puts its result on a stack, and its operands are
   counted from the top. At first the stack has the state, the integers and pi; in the end the
   rates of the state are on top. The state is
   {said}. *)
From Coq Require Import List ZArith.
From Interval Require Import Eval.Tree Eval.Prog.
Import ListNotations.

Definition integers : list Z := (* v{count} to v{len(inputs) - 2} *)
  [{"; ".join(f"({x.key[1]})" for x in integers)}]%Z.

Definition equations : list term := [
{program}].
"""


def _visit(x: Node, order: dict[Node, None]) -> None:
    for y in x.key[1:]:
        if isinstance(y, Node) and y not in order:
            _visit(y, order)
    order.setdefault(x)


def taylor(equations: Equations, start: Sequence[flint.arb]) -> list[list[flint.arb]]:
    """Taylor coefficients of the motion from a state, by variable."""
    x, equations = [[value] for value in start], equations.over(AtPoints(BITS))
    for n in range(1, EXACT_DEGREE + 1):
        # flint keeps the length of all series in a global.
        flint.ctx.cap = n
        with equations.precision():
            rates = equations.rates_with_yaw([flint.arb_series(c, n) for c in x])
            for c, rate in zip(x, rates, strict=True):
                c.append(rate[n - 1] / n)
    return x


def rounded(x: flint.arb, grid: int) -> int:
    """The nearest integer over 2 to the power of the grid."""
    return int((x * flint.arb(2) ** grid + flint.arb(0.5)).mid().floor().unique_fmpz())


def left_out(c: Sequence[flint.arb]) -> float:
    """What the derivative of a polynomial misses over a step, about."""
    h = float(STEP)
    return sum(m * abs(float(a.mid())) * h ** (m - 1) for m, a in enumerate(c) if m > DEGREE)


def polynomial_at(c: Sequence[Fraction], s: Fraction) -> Fraction:
    return sum((a * s**m for m, a in enumerate(c)), Fraction(0))


def growth(equations: Equations, states: Iterable[Sequence[float]]) -> float:
    """How fast squared errors grow at most, estimated: Coq checks what is claimed from it."""
    duals = Duals(Arrays())
    over, found = equations.over(duals), []
    w, v = np.array(THRESHOLDS, float), np.array(BALANCE, float)
    for state in states:
        rates = over.rates_with_yaw(duals.variables(list(state)))
        slopes = np.array([rate.slopes for rate in rates], float)
        b = slopes * w[None, :] / w[:, None]
        m = np.abs(b + b.T)
        np.fill_diagonal(m, 2 * np.diag(b))
        found.append((m @ v / v).max())
    return max(found)


def certificate_file(equations: Equations, maneuver: Maneuver) -> str:
    """Polynomials, and for each piece the numbers that Coq is to check."""
    with flint.ctx.workprec(BITS):
        state, pieces, defects = initial_state(equations, maneuver), [], []
        for _ in range(PIECES):
            motion = taylor(equations, state)
            pieces.append([[rounded(a, GRID) for a in c[: DEGREE + 1]] for c in motion])
            defects.append([left_out(c) for c in motion])
            h = flint.arb(STEP.numerator) / STEP.denominator
            state = [sum((a * h**m for m, a in enumerate(c)), flint.arb(0)).mid() for c in motion]
    start = [Fraction(0)] * 3 + [maneuver.roll_rate.rational, maneuver.steer_rate.rational]
    start += [maneuver.speed.rational / equations.bicycle["rR"].rational, Fraction(0)]
    weights = [Fraction(w, 12) for w in THRESHOLDS]
    exact = [[[Fraction(n, 2**GRID) for n in c] for c in piece] for piece in pieces]
    ends = [start] + [[polynomial_at(c, STEP) for c in piece] for piece in exact]
    binary64 = Equations.binary64(equations.bicycle)
    records, exit_ = [], Fraction(0)
    for piece, before, after, missing in zip(exact, ends, ends[1:], defects, strict=False):
        begin = [c[0] for c in piece]
        jump = sum(((a - b) / w) ** 2 for a, b, w in zip(before, begin, weights, strict=True))
        entry = ceiling((1 + ETA) * exit_ + (1 + 1 / ETA) * (jump + READING), SQUARES)
        grown = growth(binary64, [[*map(float, begin)], [*map(float, after)]])
        # 1 for the defect's share, and room for what the intervals are wider.
        rate = ceiling(Fraction(grown) + 1 + Fraction(1, 2), RATES)
        scaled = [2 * a / float(w) + r for a, w, r in zip(missing, weights, ROUNDING, strict=True)]
        defect = ceiling(sum(Fraction(a) ** 2 for a in scaled), SQUARES)
        left = Fraction(entry, 2**SQUARES) + Fraction(defect, 2**SQUARES) * STEP
        exit_ = left * Fraction(math.exp(rate / 2**RATES * STEP)) * Fraction(1001, 1000)
        numbers = (rate, defect, entry, ceiling(exit_, SQUARES))
        exit_ = Fraction(numbers[-1], 2**SQUARES)
        records.append((piece, numbers))
    if max(weights) ** 2 * exit_ >= ERROR**2:
        raise ValueError("these numbers do not give the error that is claimed")
    texts = []
    for piece, numbers in zip(pieces, records, strict=True):
        rows = ";\n    ".join("[" + "; ".join(map(str, c)) + "]" for c in piece)
        texts.append(f"  Piece [{rows}]\n   {' '.join(f'({n})' for n in numbers[1])}")
    body = ";\n".join(texts)
    fractions = "; ".join(f"({x.numerator}, {x.denominator})" for x in start)
    return f"""(* Maneuver 3, its first second, written by export.py. Coq trusts none of it. *)
From Coq Require Import List ZArith.
Require Import Enclosure.
Import ListNotations.
Open Scope Z_scope.

Definition start : list (Z * Z) := [{fractions}].

Definition pieces : list piece := [
{body}].
"""


def ceiling(x: Fraction, grid: int, bits: int = 16) -> int:
    """An integer over 2 to the power of the grid, not less than x, with few leading bits."""
    n = math.ceil(x * 2**grid)
    shift = max(n.bit_length() - bits, 0)
    return -(-n >> shift) << shift


if __name__ == "__main__":
    bicycle, maneuvers = benchmark()
    balls = Equations.of(bicycle, Balls(BITS))
    folder = Path(sys.argv[1])
    (folder / "Equations.v").write_text(equations_file(balls))
    (folder / "Certificate.v").write_text(certificate_file(balls, maneuvers[2]))
