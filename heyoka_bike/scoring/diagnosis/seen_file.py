"""How well programs with mistakes explain a file: simulated, and compared as with the reference."""

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COLUMNS, FOLLOWING
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import START, Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part, spread
from heyoka_bike.scoring.definitions import Sample, Understanding, understand_samples
from heyoka_bike.scoring.diagnosis.evidence import Hypothesis, Place
from heyoka_bike.scoring.diagnosis.mistakes.library import Mistake, Program, apply
from heyoka_bike.scoring.diagnosis.mistakes.proposals import columns_in_another_order
from heyoka_bike.scoring.diagnosis.programs.beginning import beginning
from heyoka_bike.scoring.diagnosis.programs.linear import linear_columns
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.scoring.diagnosis.programs.start import Start
from heyoka_bike.scoring.diagnosis.residual.causes import Cause, Causes, find_causes
from heyoka_bike.scoring.diagnosis.residual.observed import STATE, Observed, observe, readings
from heyoka_bike.scoring.diagnosis.residual.shooting import Shooting
from heyoka_bike.scoring.diagnosis.residual.terms import Accelerations
from heyoka_bike.scoring.report import Curve
from heyoka_bike.scoring.units import factor

# Rows that are compared, and rows that are simulated, of each maneuver.
_COMPARED = 251
_COLUMNS = (*COLUMNS, *FOLLOWING)
_SIMULATED = 2001
# The simulation's relative roundoff, at most.
ROUNDOFF = 1e-11
# Starts that are simulated.
_STARTS = 8
# A value of the start is another one if it is off by so many times what the rows disagree, and by
# such a part of what the one that is off most is, in sizes of columns: smooth errors are off, too.
_SURE, _SMALL = 3.0, 1e-3
# A program whose motion ends cannot have written many more rows.
_REACHED = 0.5

_Expected = Sequence[Mapping[str, Array]]
"""Of each part, columns by name."""
_Indices = Sequence[NDArray[np.intp]]
"""Of each part, some of its rows."""


class SeenFile:
    """The file, its rows that count, and the correct motion."""

    def __init__(self, parts: Sequence[Part], reference: Reference, simulator: Simulator) -> None:
        self._parts = parts
        bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
        self._correct = Program(
            bicycle=bicycle,
            starts={n: _start(reference[n].inputs) for n in reference},
        )
        self._simulator = simulator
        self._rows = [spread(len(p.time), _SIMULATED) for p in parts]
        self._picks = [spread(len(rows), _COMPARED) for rows in self._rows]
        self._times = [p.time[rows] for p, rows in zip(parts, self._rows, strict=True)]
        self._steps = [float(np.median(np.diff(p.time))) if len(p.time) > 1 else 0.0 for p in parts]
        self._exact = [
            p.reference.approximate(
                t, [c.name for c in _COLUMNS if c.name in p.reference.at_any_time]
            )
            for p, t in zip(parts, self._times, strict=True)
        ]
        self._found: dict[object, dict[str, Array]] = {}
        # Parameters are slow to compare: each set of them has a number.
        self._bicycles: dict[object, int] = {}
        self._compared = [
            {name: v[pick] for name, v in exact.items()}
            for exact, pick in zip(self._exact, self._picks, strict=True)
        ]
        self._seen = {self._key(self._correct)}
        self._expected: dict[tuple[str, ...], _Expected] = {(): self._compared}
        self._understood: dict[tuple[str, ...], Mapping[str, Understanding]] = {}
        self._understood[()], self._correct_typical = self._typical(self._compared)
        self._floors = self._floors_in_scales()

    def is_new(self, mistakes: tuple[Mistake, ...]) -> bool:
        """Whether no hypothesis before was the same program as far as the file shows it."""
        key = self._key(apply(self._correct, mistakes))
        is_new = key not in self._seen
        self._seen.add(key)
        return is_new

    def prepare(self, hypotheses: Iterable[tuple[Mistake, ...]]) -> None:
        """Simulate the programs with these mistakes together, for `judge` to take."""
        self._simulate([apply(self._correct, mistakes) for mistakes in hypotheses])

    def judge(self, mistakes: tuple[Mistake, ...]) -> Hypothesis:
        """How well the program with these mistakes explains the file."""
        expected = self._expect(apply(self._correct, mistakes))
        understood, after = self._typical(expected)
        before = {k: x for k, x in self._before(expected).items() if k in after}
        found = Hypothesis(
            mistakes=mistakes,
            before=before,
            after=after,
            changed=tuple(k for k in before if self._differ(k, expected, self._compared)),
            floors=self._floors,
            reaches_the_end=self._reaches_the_end(expected),
        )
        self._expected[found.codes] = expected
        self._understood[found.codes] = understood
        return found

    def where_they_differ(self, one: Hypothesis, other: Hypothesis) -> tuple[Place, ...]:
        """Maneuvers and columns in which two hypotheses are not the same."""
        a, b = self._expected[one.codes], self._expected[other.codes]
        return tuple(k for k in one.after if k in other.after and self._differ(k, a, b))

    def order_beside(self, other: Hypothesis | None = None) -> Mistake | None:
        """An order of the columns that explains what another mistake leaves, or the whole error."""
        expected = self._expected[other.codes if other else ()]
        return columns_in_another_order(self._as_written(), expected)

    def _known_floors(self) -> dict[Place, float]:
        """What the digits of each column cannot tell [SI]."""
        understood, floors = self._understood[()], {}
        for i, part in enumerate(self._parts):
            sample = Sample(part, self._rows[i][self._picks[i]], self._compared[i])
            for key, (written, known) in sample.floor.items():
                floors[part.number, key] = written * factor(understood[key].unit)[0] + known
        return floors

    def _floors_in_scales(self) -> dict[Place, float]:
        scales = {(p.number, key): p.reference.scale(key) for p in self._parts for key in p.values}
        return {k: x / (scales[k] or 1.0) for k, x in self._known_floors().items()}

    def units_beside(self, h: Hypothesis) -> dict[str, str]:
        """Units that columns have if a hypothesis is true, where they seemed to have others."""
        usual, understood = self._understood[()], self._understood[h.codes]
        return {key: u.unit for key, u in understood.items() if u.unit != usual[key].unit}

    def causes(self, library: Sequence[Mistake]) -> Causes | None:
        """What explains the file's accelerations; None where it does not show its motion."""
        equations = Equations.binary64(self._correct.bicycle)
        found: list[Causes] = []
        tried: list[Mapping[str, Understanding]] = []
        for understood in readings(self._parts, self._understood[()]):
            if understood in tried:
                continue
            tried.append(understood)
            # Motions and equations that make no sense end as such.
            with np.errstate(all="ignore"):
                seen = [observe(p, understood, equations) for p in self._parts]
                motions = [m for m in seen if m is not None]
                if not motions:
                    continue
                found.append(find_causes(Accelerations(motions, self._correct), library, motions))
            if not (found[-1].is_open or found[-1].is_blown_up):
                break
        # Rates that contradict the angles are not understood.
        return max(found, key=lambda c: (not c.is_blown_up, c.most), default=None)

    def starts_like_its_own(
        self, library: Sequence[Mistake], motions: Sequence[Observed]
    ) -> list[Mistake]:
        """Mistakes of the start that come nearer to the file's own than the right one does.

        All of them where the file does not show its motion from the start on.
        """
        own = {m.number: m.beginning for m in motions if m.beginning is not None}
        if len(own) < len(self._parts):
            return list(library)

        def distance(program: Program) -> float:
            found = 0.0
            for n, state in own.items():
                right = np.abs(self._given(self._correct, n)) + np.abs(state) + 1e-3
                found += float(np.sum(np.abs(self._given(program, n) - state) / right))
            return found

        right = distance(self._correct)
        near = [(distance(apply(self._correct, (m,))), i) for i, m in enumerate(library)]
        # One that is made comes far nearer, but for what follows within the first rows.
        return [library[i] for x, i in sorted(near)[:_STARTS] if x < right]

    def other_starts(self, motions: Sequence[Observed]) -> list[Cause]:
        """The start of each maneuver that its own rows lead back to, in what is another."""
        causes = []
        for m in (m for m in motions if m.beginning is not None):
            off = m.beginning - self._given(self._correct, m.number)
            size = np.std([m.state[key] for key in STATE], axis=1) + np.finfo(np.float64).tiny
            least = _SURE * m.scatter + _SMALL * np.max(np.abs(off) / size) * size
            changes = {
                f"initial_{name}_{m.number}": float(x)
                for name, x, limit in zip(START, off, least, strict=True)
                if abs(x) > limit
            }
            causes += [Cause((), changes, dict.fromkeys(changes, 0.0), 1.0)] if changes else []
        return causes

    @staticmethod
    def _given(program: Program, number: int) -> Array:
        """Columns of `STATE` at the start of a maneuver."""
        return np.delete(np.array(beginning(program, number)), 1)

    def shooting(self, motions: Sequence[Observed]) -> Shooting:
        """Whole runs of changed programs, compared with the motions of the file."""
        return Shooting(motions, self._correct, self._simulator)

    def curves(self, h: Hypothesis) -> tuple[Curve, ...]:
        """What a hypothesis leaves, in the column of each maneuver that it explains best."""
        understood = self._understood[h.codes]
        written = self._as_understood(understood)
        places = {part.number: i for i, part in enumerate(self._parts)}

        def curve(number: int, key: str) -> Curve:
            i, column = places[number], understood[key].column
            before, after = (
                np.abs(written[i][key] - expected[i][column.name])
                for expected in (self._compared, self._expected[h.codes])
            )
            good = np.isfinite(after)
            time = self._compared_times()[i]
            return Curve(number, key, column.unit, time[good], before[good], after[good])

        relief = {k: h.before[k] / h.after[k] for k in h.after if k in h.before}
        return best_explained(relief, curve)

    def _compared_times(self) -> list[Array]:
        return [t[pick] for t, pick in zip(self._times, self._picks, strict=True)]

    def _as_written(self, rows: _Indices | None = None) -> list[dict[str, Array]]:
        """Columns of each part at some rows, by default those that are compared."""
        if rows is None:
            rows = [all_[pick] for all_, pick in zip(self._rows, self._picks, strict=True)]
        return [
            {key: v[at] for key, v in part.values.items()}
            for part, at in zip(self._parts, rows, strict=True)
        ]

    def _as_understood(
        self, understood: Mapping[str, Understanding], rows: _Indices | None = None
    ) -> list[dict[str, Array]]:
        """The same in SI units, with signs and zeros; without columns that hold no number."""
        return [
            {
                key: u.sign * factor(u.unit)[0] * written[key] - u.offset
                for key, u in understood.items()
                if key in written
            }
            for written in self._as_written(rows)
        ]

    def _key(self, program: Program) -> object:
        """Equal for programs that do the same as far as the file shows it."""
        starts = tuple(program.starts[part.number] for part in self._parts)
        bicycle = self._number(program.bicycle)
        return bicycle, starts, program.clock, program.rows, program.amounts, program.linear

    def _number(self, bicycle: Bicycle) -> int:
        """The same for bicycles of the same parameters."""
        return self._bicycles.setdefault(tuple(bicycle.values.values()), len(self._bicycles))

    def _expect(self, program: Program) -> _Expected:
        """Columns of each part at the compared rows."""
        motions = self._motions(program)
        found = []
        for i, motion in enumerate(motions):
            columns = dict(motion)
            for change in program.rows:
                columns = dict(change(columns, self._times[i]))
            found.append({name: columns[name][self._picks[i]] for name in self._exact[i]})
        return found

    def _before(self, expected: _Expected) -> dict[Place, float]:
        """Typical errors of the correct program, over the rows that the mistaken one reaches."""
        finite = [np.isfinite(e["roll_angle"]) for e in expected]
        if all(good.all() for good in finite):
            return self._correct_typical
        return self._typical(
            [
                {name: np.where(good, v, np.nan) for name, v in e.items()}
                for e, good in zip(self._compared, finite, strict=True)
            ]
        )[1]

    def _reaches_the_end(self, expected: _Expected) -> bool:
        """Whether the motion goes about as far as the rows of the file do."""
        for e, written in zip(expected, self._as_written(), strict=True):
            there = np.any([np.isfinite(v) for v in written.values()], axis=0)
            if there.any() and np.mean(np.isfinite(e["roll_angle"][there])) < _REACHED:
                return False
        return True

    def _differ(self, place: Place, one: _Expected, other: _Expected) -> bool:
        """Whether two programs differ in a column by more than the simulation's roundoff."""
        number, key = place
        i = next(i for i, part in enumerate(self._parts) if part.number == number)
        distance = np.abs(one[i][key] - other[i][key])
        scale = float(np.max(np.abs(self._compared[i][key])))
        return bool(np.fmax.reduce(distance, initial=0.0) > ROUNDOFF * scale)

    def _motions(self, program: Program) -> list[dict[str, Array]]:
        """Columns of each part as the program computes them, at the times that it means."""
        return [self._found[key] for key in self._simulate([program])]

    def _simulate(self, programs: Sequence[Program]) -> list[object]:
        """Have the motions of programs found; under which keys, all parts of each in order."""
        keys: list[object] = []
        asked: dict[object, AskedMotion] = {}
        for program in programs:
            values = self._number(program.bicycle)
            for i, part in enumerate(self._parts):
                start = program.starts[part.number]
                key = values, start, program.clock, program.amounts, program.linear, i
                keys.append(key)
                if key in self._found or key in asked:
                    continue
                meant = program.clock(self._times[i], self._steps[i])
                state = beginning(program, part.number)
                amounts = dict(program.amounts)
                if program.linear:
                    self._found[key] = linear_columns(program.bicycle, state, meant, program.linear)
                else:
                    asked[key] = AskedMotion(program.bicycle, state, meant, amounts)
        found = self._simulator.run_all(list(asked.values()))
        self._found.update(zip(asked, found, strict=True))
        return keys

    def _typical(
        self, expected: _Expected
    ) -> tuple[Mapping[str, Understanding], dict[Place, float]]:
        """The definitions that fit, and typical errors in scales."""
        samples = [
            Sample(part, rows[pick], e)
            for part, rows, pick, e in zip(
                self._parts, self._rows, self._picks, expected, strict=True
            )
        ]
        chosen: Mapping[str, Understanding] = understand_samples(samples)
        return chosen, {
            (part.number, key): sample.typical(key, chosen[key]) / (sample.scale[key] or 1.0)
            for part, sample in zip(self._parts, samples, strict=True)
            for key in sample.values
        }


def _largest(values: Array) -> float:
    return float(np.fmax.reduce(np.abs(values), initial=0.0))


def best_explained(
    relief: Mapping[Place, float], curve: Callable[[int, str], Curve]
) -> tuple[Curve, ...]:
    """In each maneuver the column whose error falls by the largest factor."""
    ranked = sorted(relief, key=relief.__getitem__, reverse=True)
    # The first in the ranking is the last to be put into its place.
    best = dict(reversed(ranked))
    return tuple(curve(number, key) for number, key in sorted(best.items()))


def _start(inputs: Mapping[str, str]) -> Start:
    if any(not Exact.parse(inputs[k]).is_zero for k in ("roll", "steer", "steer_rate")):
        raise InputError("diagnosis: found a start that is not upright and straight")
    return Start(
        speed=float(Exact.parse(inputs["speed"])), roll_rate=float(Exact.parse(inputs["roll_rate"]))
    )
