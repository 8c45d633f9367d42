"""A file, and programs with mistakes that are simulated and compared with it."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS, FOLLOWING
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import START, Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part, spread
from heyoka_bike.scoring.definitions import Sample, Understanding, understand_samples
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS, Hypothesis, Place
from heyoka_bike.scoring.diagnosis.mistakes.library import Mistake, Program, apply
from heyoka_bike.scoring.diagnosis.mistakes.proposals import columns_in_another_order
from heyoka_bike.scoring.diagnosis.programs.linear import linear_columns
from heyoka_bike.scoring.diagnosis.programs.program import Columns, Start, beginning
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
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
# Programs that are simulated together.
_TOGETHER = 32
# Starts that are simulated.
_STARTS = 8
# A value of the start is another one if it is off by so many times what the rows disagree, and by
# such a part of what the one that is off most is, in sizes of columns: smooth errors are off, too.
_SURE, _SMALL = 3.0, 1e-3
# A program whose motion ends cannot have written many more rows.
_REACHED = 0.5

_Expected = Sequence[Mapping[str, Array]]
"""Of each part, columns by name."""


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
        self._compared = [
            {name: v[pick] for name, v in exact.items()}
            for exact, pick in zip(self._exact, self._picks, strict=True)
        ]
        self._seen = {self._key(self._correct)}
        self.tried = 0
        self._expected: dict[tuple[str, ...], _Expected] = {(): self._compared}
        self._understood: dict[tuple[str, ...], Mapping[str, Understanding]] = {}
        self._understood[()], self._correct_typical = self._typical(self._compared)
        self._floors = self._floors_in_scales()

    def judged(self, hypotheses: Iterable[tuple[Mistake, ...]]) -> list[Hypothesis]:
        """Simulate programs with these mistakes and compare them with the file.

        Without those that are, as far as the file shows it, a program that was tried before.
        """
        new: dict[object, tuple[Mistake, ...]] = {}
        for mistakes in hypotheses:
            new.setdefault(self._key(apply(self._correct, mistakes)), mistakes)
        chosen = [mistakes for key, mistakes in new.items() if key not in self._seen]
        self._seen |= new.keys()
        self.tried += len(chosen)
        found = []
        # So many as a processor's cache and the memory hold.
        for i in range(0, len(chosen), _TOGETHER):
            together = chosen[i : i + _TOGETHER]
            programs = [apply(self._correct, mistakes) for mistakes in together]
            made = self._simulated(programs)
            found += [
                self._judge(m, e, self._resolved(p, e))
                for m, p, e in zip(together, programs, made, strict=True)
            ]
        return found

    def _resolved(self, program: Program, expected: _Expected) -> Mapping[Place, float]:
        """Return the resolution limit of each column, by its digits and the simulation, in scales.

        A motion that nears a singularity is simulated less well: its energy, which should be
        constant, says how well.
        """
        if program.amounts or program.rows or program.linear:
            return self._floors
        drift = {}
        for part, e in zip(self._parts, expected, strict=True):
            energy = e["mechanical_energy"][np.isfinite(e["mechanical_energy"])]
            scale = part.reference.scale("mechanical_energy") or 1.0
            drift[part.number] = float(np.ptp(energy)) / scale if len(energy) else 0.0
        return {k: max(x, drift[k[0]]) for k, x in self._floors.items()}

    def _judge(
        self, mistakes: tuple[Mistake, ...], expected: _Expected, floors: Mapping[Place, float]
    ) -> Hypothesis:
        understood, after = self._typical(expected)
        before = {k: x for k, x in self._before(expected).items() if k in after}
        found = Hypothesis(
            mistakes=mistakes,
            before=before,
            after=after,
            changed=tuple(k for k in before if self._differ(k, expected, self._compared)),
            floors=floors,
            reaches_the_end=self._reaches_the_end(expected),
        )
        self._expected[found.codes] = expected
        self._understood[found.codes] = understood
        return found

    def where_they_differ(self, one: Hypothesis, other: Hypothesis) -> tuple[Place, ...]:
        """Maneuvers and columns in which two hypotheses are not the same."""
        a, b = self._expected[one.codes], self._expected[other.codes]
        return tuple(k for k in one.after if k in other.after and self._differ(k, a, b))

    def order_beside(self, other: Hypothesis | None = None) -> list[Mistake]:
        """An order of the columns that explains what another mistake leaves, or the whole error."""
        expected = self._expected[other.codes if other else ()]
        order = columns_in_another_order(self._as_written(), expected)
        return [order] if order else []

    def _floors_in_scales(self) -> dict[Place, float]:
        """Return the resolution limit of each column by its digits, in scales."""
        understood, floors = self._understood[()], {}
        for i, part in enumerate(self._parts):
            sample = Sample(part, self._rows[i][self._picks[i]], self._compared[i])
            for key, (written, known) in sample.floor.items():
                floor = written * factor(understood[key].unit)[0] + known
                floors[part.number, key] = floor / (part.reference.scale(key) or 1.0)
        return floors

    def units_beside(self, h: Hypothesis) -> dict[str, str]:
        """Units that columns have if a hypothesis is true, where they seemed to have others."""
        usual, understood = self._understood[()], self._understood[h.codes]
        return {key: u.unit for key, u in understood.items() if u.unit != usual[key].unit}

    def causes(self, library: Sequence[Mistake]) -> Causes | None:
        """Return the causes of the file's accelerations; None where it does not show its motion."""
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
        for m in motions:
            if m.beginning is None:
                continue
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
        """Return what a hypothesis leaves, in the column of each maneuver that it explains best."""
        written = self._as_written()
        places = {part.number: i for i, part in enumerate(self._parts)}

        def curve(number: int, key: str) -> Curve:
            i, u = places[number], self._understood[h.codes][key]
            values = u.sign * factor(u.unit)[0] * written[i][key] - u.offset
            before, after = (
                np.abs(values - expected[i][u.column.name])
                for expected in (self._compared, self._expected[h.codes])
            )
            good = np.isfinite(after)
            time = self._times[i][self._picks[i]]
            return Curve(number, key, u.column.unit, time[good], before[good], after[good])

        relief = {k: h.before[k] / h.after[k] for k in h.after if k in h.before}
        # The best column of a maneuver is the last to be put into its place.
        best = dict(sorted(relief, key=relief.__getitem__))
        return tuple(curve(number, key) for number, key in sorted(best.items()))

    def _as_written(self) -> list[dict[str, Array]]:
        """Columns of each part at the rows that are compared."""
        return [
            {key: v[rows[pick]] for key, v in part.values.items()}
            for part, rows, pick in zip(self._parts, self._rows, self._picks, strict=True)
        ]

    def _key(self, program: Program) -> object:
        """Equal for programs that do the same as far as the file shows it."""
        starts = tuple(program.starts[part.number] for part in self._parts)
        bicycle = tuple(map(float, program.bicycle.values.values()))
        return bicycle, starts, program.clock, program.rows, program.amounts, program.linear

    def _simulated(self, programs: Sequence[Program]) -> list[_Expected]:
        """Columns of each part at the compared rows, of each program."""
        asked = [
            AskedMotion(
                program.bicycle,
                beginning(program, part.number),
                program.clock(self._times[i], self._steps[i]),
                dict(program.amounts),
            )
            for program in programs
            for i, part in enumerate(self._parts)
        ]
        is_linear = [p.linear for p in programs for _ in self._parts]
        made = iter(
            self._simulator.run_all([m for m, x in zip(asked, is_linear, strict=True) if not x])
        )
        columns = iter(
            linear_columns(m.bicycle, m.start, m.time, terms) if terms else next(made)
            for m, terms in zip(asked, is_linear, strict=True)
        )
        return [self._written(p, columns) for p in programs]

    def _written(self, program: Program, made: Iterator[Columns]) -> _Expected:
        """Return the columns that a program writes of the motions of all parts."""
        found = []
        for time, pick, exact in zip(self._times, self._picks, self._exact, strict=True):
            columns = next(made)
            for change in program.rows:
                columns = change(columns, time)
            found.append({name: columns[name][pick] for name in exact})
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
        """True if the motion goes about as far as the rows of the file do."""
        for e, written in zip(expected, self._as_written(), strict=True):
            there = np.any([np.isfinite(v) for v in written.values()], axis=0)
            if there.any() and np.mean(np.isfinite(e["roll_angle"][there])) < _REACHED:
                return False
        return True

    def _differ(self, place: Place, one: _Expected, other: _Expected) -> bool:
        """True if two programs differ in a column by more than the simulation's roundoff."""
        number, key = place
        i = next(i for i, part in enumerate(self._parts) if part.number == number)
        distance = np.abs(one[i][key] - other[i][key])
        scale = float(np.max(np.abs(self._compared[i][key])))
        return bool(np.fmax.reduce(distance, initial=0.0) > WEIGHTS.resolved * scale)

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


def _start(inputs: Mapping[str, str]) -> Start:
    if any(not Exact.parse(inputs[k]).is_zero for k in ("roll", "steer", "steer_rate")):
        raise InputError("diagnosis: found a start that is not upright and straight")
    return Start(
        speed=float(Exact.parse(inputs["speed"])), roll_rate=float(Exact.parse(inputs["roll_rate"]))
    )
