"""Write the equations and certificates of ten seconds of the maneuvers, for Coq.

``python tests/checker/formal/export.py FOLDER 1 2 3`` writes ``Equations.v``, the equations of
motion as a program for CoqInterval. For each maneuver it writes ``Certificate1.v``, polynomials
with dyadic coefficients from the published trajectory, and the numbers of their proof; and
``Checked1_0.v`` to ``Checked1_4.v``, which carry out the checks. ``Lines.v`` contains the published
text. Nothing in the certificates has to be believed: Coq checks them, and the equations and the
text are what the theorems are about.
"""

import json
import math
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path

import flint
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Maneuver, benchmark
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.analytic import AtPoints
from heyoka_bike.numbers.arithmetic import Arithmetic, Arrays, Balls
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.layout import TEXT
from heyoka_bike.reference.proof.candidate import read_candidate

BITS = 200
GRID = 80  # coefficients are integers divided by 2**GRID
RATES = 10  # growth rates are integers divided by 2**RATES
TUBE = 140  # the bound of the tube is an integer divided by 2**TUBE
ENTRIES = 200  # sums of squares at the beginning of a block are integers divided by 2**ENTRIES
FRAME = 12  # entries below the diagonal of a frame are integers divided by 2**FRAME
PIECES, LENGTH = 160, Fraction(1, 16)  # [s]
BLOCK = 32  # pieces that Coq checks in one file
DEGREE = 18
SAMPLES = 16  # number of intervals into which samples of the growth rate divide a piece
# Margin added to the growth rate of squares [1/s], because Coq computes this rate with wider
# intervals. Maneuver 1 needs a margin of 0.17.
MARGIN = 0.18
FRAMES = Path(__file__).with_name("frames.json")
DATASET = Path(__file__).parents[3] / "reference"


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


def regular(run: Trajectory, own: Equations, t: Fraction) -> list[flint.arb]:
    """Return the state of a published trajectory in the variables of the regular equations.

    `own` are the equations in the variables of the trajectory.
    """
    state = run.state(t)
    if run.is_regular:
        return state
    _, speeds = own.unfold(state)
    return [*state[:3], speeds.p, speeds.steer_rate, *state[5:]]


def taylor(equations: Equations, start: Sequence[flint.arb]) -> list[list[flint.arb]]:
    """Taylor coefficients of the motion through a state, by variable, at points."""
    x = [[value.mid()] for value in start]
    for n in range(1, DEGREE + 1):
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


def polynomials(equations: Equations, run: Trajectory, k: int) -> list[list[int]]:
    """Coefficients of one piece by variable and power of the time from its middle, on the grid."""
    own, points = run.equations(Balls(BITS)), equations.over(AtPoints(BITS))
    with flint.ctx.workprec(BITS):
        motion = taylor(points, regular(run, own, LENGTH * k + LENGTH / 2))
        return [[rounded(a, GRID) for a in c] for c in motion]


class Frame:
    """Coordinates of the error: a unit lower triangle times scales, and the exact inverse."""

    def __init__(
        self,
        lower: Sequence[Sequence[int]],
        scales: Sequence[float],
        claim: str,
        room: Sequence[float],
    ) -> None:
        """Build the matrices.

        `claim` bounds every error [rad, rad/s]. In each block squares grow more by the factor of
        `room`, because of the defect. It adds most in the first block, where errors are smallest.
        """
        n, self.matrix, self.inverse = len(scales), [], []
        self.claim, self.room = Fraction(claim), room
        unit = [[Fraction(x, 2**FRAME) for x in row] + [Fraction(1)] for row in lower]
        over = [Fraction(x) for x in scales]
        for i in range(n):
            zeros = [Fraction(0)] * (n - i - 1)
            self.matrix.append([x * s for x, s in zip(unit[i], over, strict=False)] + zeros)
        for i in range(n):
            known = [
                sum(x * row[j] for x, row in zip(self.matrix[i], self.inverse, strict=False))
                for j in range(n)
            ]
            row = [(int(i == j) - known[j]) / self.matrix[i][i] for j in range(n)]
            self.inverse.append(row)

    @classmethod
    def of(cls, number: int) -> "Frame":
        """Return the frame of a maneuver."""
        return cls(**json.loads(FRAMES.read_text())[f"maneuver {number}"])

    @property
    def tube(self) -> Fraction:
        """The largest sum of squares with which every error is within the claim."""
        worst = max(sum(x * x for x in row) for row in self.matrix)
        return Fraction(math.floor(self.claim**2 / worst * 2**TUBE), 2**TUBE)


def growth(equations: Equations, frame: Frame, motion: np.ndarray) -> list[int]:
    """Claim growth rates of squares by piece; Coq checks them.

    `motion` has Taylor coefficients by piece, variable and power.
    """
    times = np.linspace(-1, 1, SAMPLES + 1) * float(LENGTH) / 2
    states = motion @ np.vander(times, DEGREE + 1, increasing=True).T
    duals = Duals(Arrays())
    flat = list(states.transpose(1, 0, 2).reshape(states.shape[1], -1))
    rates = equations.over(duals).rates_with_yaw(duals.variables(flat))
    slopes = [[np.broadcast_to(s, flat[0].shape) for s in rate.slopes] for rate in rates]
    into, out = (np.array(m, float) for m in (frame.inverse, frame.matrix))
    turned = into @ np.moveaxis(np.array(slopes, float), 2, 0) @ out
    most = np.linalg.eigvalsh(turned + turned.transpose(0, 2, 1))[:, -1]
    worst = most.reshape(len(motion), -1).max(axis=1) + MARGIN
    return [max(0, math.ceil(k * 2**RATES)) for k in worst]


def initial_numbers(equations: Equations, maneuver: Maneuver) -> list[Fraction]:
    """The state at time zero, exactly; its pitch is zero, as its steer angle is."""
    if not (maneuver.roll.is_zero and maneuver.steer.is_zero):
        raise ValueError("expected a maneuver that begins upright and straight")
    rates = [maneuver.roll_rate.rational, maneuver.steer_rate.rational]
    spin = maneuver.speed.rational / equations.bicycle["rR"].rational
    return [Fraction(0), Fraction(0), Fraction(0), *rates, spin, Fraction(0)]


def certificate_file(equations: Equations, run: Trajectory, number: int) -> str:
    """Polynomials with their growth rates, and the frame of a maneuver."""
    frame = Frame.of(number)
    pieces = [polynomials(equations, run, k) for k in range(PIECES)]
    values = np.array([[[float(a) / 2**GRID for a in c] for c in piece] for piece in pieces])
    rates = growth(Equations.binary64(equations.bicycle), frame, values)
    start = initial_numbers(equations, run.maneuver)
    entries = entries_of(frame, rates)
    texts = []
    for n, entry in enumerate(entries):
        members = range(n * BLOCK, (n + 1) * BLOCK)
        body = ";\n".join(_piece(pieces[k], rates[k]) for k in members)
        texts.append(f"Definition block_{n} : block := Block {_fraction(entry)} [\n{body}].\n")
    blocks = "\n".join(texts)
    fractions = "; ".join(f"({x.numerator}, {x.denominator})" for x in start)
    return f"""(* Maneuver {number}, ten seconds, written by export.py. Coq trusts none of it. *)
From Coq Require Import List ZArith QArith.
Require Import Checks.
Import ListNotations.
Open Scope Z_scope.

Definition start : list (Z * Z) := [{fractions}].

Definition certified : certificate := Certificate
  {_matrix(frame.matrix)}
  {_matrix(frame.inverse)}
  {_fraction(frame.tube)} {_fraction(frame.claim)}.

{blocks}"""


def checked_file(number: int, n: int) -> str:
    """The computation that checks block `n`."""
    following = f"(Some block_{n + 1})" if (n + 1) * BLOCK < PIECES else "None"
    return f"""From Coq Require Import List ZArith.
Require Import Checks Equations Certificate{number}.
Lemma checked : check_block equations integers certified block_{n} {following} = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
"""


def text_file(text: str) -> str:
    """The lines of the published text as Coq's strings."""
    strings = ";\n".join(f'"{line}"' for line in text.splitlines())
    return f"""(* The lines of reference/{TEXT}, written by export.py. *)
From Coq Require Import List String.
Import ListNotations.
Open Scope string_scope.

Definition lines : list string := [
{strings}].
"""


def entries_of(frame: Frame, rates: Sequence[int]) -> list[Fraction]:
    """Claim sums of squares at the beginning of each block, from the growth up to the tube."""
    entries, left = [], float(frame.tube)
    for n, factor in reversed(list(enumerate(frame.room))):
        grown = sum(rates[n * BLOCK : (n + 1) * BLOCK]) / 2**RATES * float(LENGTH)
        left /= factor * math.exp(grown)
        entries.append(Fraction(math.floor(left * 2**ENTRIES), 2**ENTRIES))
    return entries[::-1]


def _piece(rows: Sequence[Sequence[int]], rate: int) -> str:
    texts = ";\n    ".join("[" + "; ".join(map(str, c)) + "]" for c in rows)
    return f"  Piece [{texts}] {rate}"


def _fraction(x: Fraction) -> str:
    return f"({x.numerator} # {x.denominator})"


def _matrix(rows: Sequence[Sequence[Fraction]]) -> str:
    return "[\n" + ";\n".join(f"  [{'; '.join(map(_fraction, row))}]" for row in rows) + "]"


if __name__ == "__main__":
    bicycle, _ = benchmark()
    balls = Equations.of(bicycle, Balls(BITS))
    folder = Path(sys.argv[1])
    (folder / "Equations.v").write_text(equations_file(balls))
    runs, numbers = read_candidate(DATASET), [int(word) for word in sys.argv[2:]]
    if numbers:
        (folder / "Lines.v").write_text(text_file((DATASET / TEXT).read_text()))
    for number in numbers:
        text = certificate_file(balls, runs[number - 1], number)
        (folder / f"Certificate{number}.v").write_text(text)
        for n in range(PIECES // BLOCK):
            (folder / f"Checked{number}_{n}.v").write_text(checked_file(number, n))
