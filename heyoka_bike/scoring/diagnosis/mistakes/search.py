"""How well programs with mistakes explain a file: simulated, and compared as with the reference.

Motions are compared through their difference from the simulated correct one, so that the
simulation's own error cancels.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS, DEFINITIONS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference
from heyoka_bike.reference.sensitivities import Sensitivities
from heyoka_bike.scoring.alignment import Part, spread
from heyoka_bike.scoring.definitions import Sample, Understanding, understand_samples
from heyoka_bike.scoring.diagnosis.mistakes.library import Mistake, Program, apply
from heyoka_bike.scoring.diagnosis.mistakes.linearised import linearised
from heyoka_bike.scoring.diagnosis.mistakes.pairs import Alone, promising
from heyoka_bike.scoring.diagnosis.mistakes.proposals import (
    columns_in_another_order,
    times_on_another_scale,
)
from heyoka_bike.scoring.diagnosis.programs.first_order import FirstOrder
from heyoka_bike.scoring.diagnosis.programs.linear import linear_columns
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.programs.start import Start, initial_state
from heyoka_bike.scoring.diagnosis.remainder import energy_level, too_large
from heyoka_bike.scoring.diagnosis.unknowns.fitting import Fitting, best_explained
from heyoka_bike.scoring.report import Curve
from heyoka_bike.scoring.units import factor

# Rows that are compared, and rows that are simulated, of each maneuver.
_COMPARED = 251
_SIMULATED = 2001
# The simulation's relative roundoff, at most.
_ROUNDOFF = 1e-11
# A program whose motion ends cannot have written many more rows.
_REACHED = 0.5
# A start contradicts a first row from which it is so many times farther than the right one is, and
# than the digits can tell.
_CLEARLY = 10.0

_Place = tuple[int, str]
"""A maneuver's number and a column's key."""
_Expected = Sequence[Mapping[str, Array]]
"""Of each part, columns by name."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """Mistakes, and how much of the difference they explain.

    Attributes
    ----------
    mistakes : tuple of Mistake
        None of them for the correct program.
    gain, relief
        Factor by which the typical error falls, geometric mean over all maneuvers and columns, and
        over those that the mistakes change.
    before, after : mapping of (int, str) to float
        Typical error of each maneuver and column, of the correct program and of this one, in
        scales of the column, over the same rows.
    contradicted : (int, str) or None
        Maneuver and column whose first row says the contrary.
    unexplained : (int, str) or None
        Maneuver and column that keep more than an integrator leaves, see `remainder`.
    """

    mistakes: tuple[Mistake, ...]
    gain: float
    relief: float
    before: Mapping[_Place, float]
    after: Mapping[_Place, float]
    contradicted: _Place | None = None
    unexplained: _Place | None = None

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the mistakes."""
        return tuple(m.code for m in self.mistakes)


class Search:
    """The file, its rows that count, and the correct motion."""

    def __init__(
        self, parts: Sequence[Part], reference: Reference, simulator: Simulator | None,
        sensitivities: Sensitivities | None = None,
    ) -> None:  # fmt: skip
        self._parts = parts
        bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
        self._correct = Program(
            bicycle=bicycle,
            starts={n: _start(reference[n].inputs) for n in reference},
        )
        self._simulators = [
            simulator or FirstOrder(p.reference, sensitivities, p.number, bicycle) for p in parts
        ]
        self._rows = [spread(len(p.time), _SIMULATED) for p in parts]
        self._picks = [spread(len(rows), _COMPARED) for rows in self._rows]
        self._times = [p.time[rows] for p, rows in zip(parts, self._rows, strict=True)]
        self._steps = [float(np.median(np.diff(p.time))) if len(p.time) > 1 else 0.0 for p in parts]
        self._exact = [
            p.reference.approximate(t, [c.name for c in COLUMNS])
            for p, t in zip(parts, self._times, strict=True)
        ]
        self._found: dict[object, dict[str, Array]] = {}
        self._simulated = self._motions(self._correct)
        self._compared = [
            {name: v[pick] for name, v in exact.items()}
            for exact, pick in zip(self._exact, self._picks, strict=True)
        ]
        self._seen = {self._key(self._correct)}
        self._expected: dict[tuple[str, ...], _Expected] = {(): self._compared}
        self._understood: dict[tuple[str, ...], Mapping[str, Understanding]] = {}
        self._understood[()], self._correct_typical = self._typical(self._compared)
        self._floors = self._floors_in_scales()
        self.energy_level = energy_level(parts, self._understood[()])

    def is_new(self, mistakes: tuple[Mistake, ...]) -> bool:
        """Whether no hypothesis before was the same program as far as the file shows it."""
        key = self._key(apply(self._correct, mistakes))
        is_new = key not in self._seen
        self._seen.add(key)
        return is_new

    def judge(self, mistakes: tuple[Mistake, ...]) -> Hypothesis:
        """How well the program with these mistakes explains the file."""
        expected = self._expect(apply(self._correct, mistakes))
        understood, after = self._typical(expected)
        before = self._before(expected)
        logs = {k: float(np.log(before[k] / after[k])) for k in after if k in before}
        changed = [x for k, x in logs.items() if self._differ(k, expected, self._compared)]
        is_possible = self._reaches_the_end(expected)
        found = Hypothesis(
            mistakes=mistakes,
            gain=float(np.exp(np.mean(list(logs.values())))) if logs and is_possible else 0.0,
            relief=float(np.exp(np.mean(changed))) if changed and is_possible else 0.0,
            before=before,
            after=after,
            contradicted=self._contradicted(expected),
            unexplained=self.too_large(after, expected),
        )
        self._expected[found.codes] = expected
        self._understood[found.codes] = understood
        return found

    def too_large(
        self, left: Mapping[_Place, float], expected: _Expected | None = None
    ) -> _Place | None:
        """The column that keeps more than an integrator leaves, of errors in scales.

        Motions that become larger than the correct one have larger errors.
        """
        motion = self._compared if expected is None else expected
        sizes = {
            (part.number, key): max(1.0, _largest(e[key]) / (_largest(known[key]) or np.inf))
            for part, e, known in zip(self._parts, motion, self._compared, strict=True)
            for key in part.values
            if key in known
        }
        return too_large({k: x / sizes[k] for k, x in left.items()}, self._floors,
                         self.energy_level)  # fmt: skip

    def _contradicted(self, expected: _Expected) -> _Place | None:
        """The column whose first row has the correct start, and not that of the program.

        Where the second row has what the program makes, the first is only what it was told.
        """
        understood = self._understood[()]
        written = self._as_understood(understood)
        for i, part in enumerate(self._parts):
            if len(self._picks[i]) < 2 or self._times[i][0] != 0.0:
                continue
            for key, values in written[i].items():
                place = part.number, key
                if understood[key].offset or place not in self._floors:
                    continue
                floor = max(_ROUNDOFF, self._floors[place]) * part.reference.scale(key)
                right = _nearest(key, values, self._compared[i])
                wrong = _nearest(key, values, expected[i])
                limit = _CLEARLY * max(right[0], floor)
                if wrong[0] > limit and wrong[1] > wrong[0] / _CLEARLY:
                    return place
        return None

    def advantage(self, better: Hypothesis, other: Hypothesis) -> float:
        """Factor by which one leaves less than another, where the two differ."""
        a, b = self._expected[better.codes], self._expected[other.codes]
        places = [k for k in better.after if k in other.after and self._differ(k, a, b)]
        logs = [np.log(other.after[k] / better.after[k]) for k in places]
        return float(np.exp(np.mean(logs))) if logs else 1.0

    def proposals(self) -> list[Mistake]:
        """Mistakes that are read off the file."""
        understood = self._understood[()]
        written = self._as_understood(understood)
        found = (
            columns_in_another_order(self._as_written(), self._compared),
            times_on_another_scale(self._parts, self._compared_times(), written, understood),
            linearised(written, self._compared, self._expect, self._correct),
        )
        return [mistake for mistake in found if mistake is not None]

    def order_beside(self, other: Hypothesis) -> Mistake | None:
        """Another order of the columns that explains what another mistake leaves."""
        return columns_in_another_order(self._as_written(), self._expected[other.codes])

    def promising_pairs(self, singles: Sequence[Hypothesis]) -> list[tuple[Mistake, ...]]:
        """Pairs that are worth a simulation."""
        possible = [h for h in singles if h.gain > 0.0]
        alone = [
            Alone(
                expected=self._expected[h.codes],
                names={key: u.column.name for key, u in self._understood[h.codes].items()},
                written=self._as_understood(self._understood[h.codes]),
            )
            for h in possible
        ]
        found = promising(self._compared, alone, self._compared_times())
        return [(*possible[i].mistakes, *possible[j].mistakes) for i, j in found]

    def _known_floors(self) -> dict[_Place, float]:
        """What the digits of each column cannot tell [SI]."""
        understood, floors = self._understood[()], {}
        for i, part in enumerate(self._parts):
            sample = Sample(part, self._rows[i][self._picks[i]], self._compared[i])
            for key, (written, known) in sample.floor.items():
                floors[part.number, key] = written * factor(understood[key].unit)[0] + known
        return floors

    def _floors_in_scales(self) -> dict[_Place, float]:
        scales = {(p.number, key): p.reference.scale(key) for p in self._parts for key in p.values}
        return {k: x / (scales[k] or 1.0) for k, x in self._known_floors().items()}

    def fitting(self) -> Fitting:
        """The file as `estimation` takes it, understood as a correct one."""
        understood = self._understood[()]
        floors = self._known_floors()
        return Fitting(
            numbers=[part.number for part in self._parts],
            times=self._compared_times(),
            written=[
                {key: v for key, v in columns.items() if (part.number, key) in floors}
                for part, columns in zip(self._parts, self._as_understood(understood), strict=True)
            ],
            exact=self._compared,
            names={key: u.column.name for key, u in understood.items()},
            floors=floors,
            program=self._correct,
        )

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

    def _as_written(self) -> list[dict[str, Array]]:
        """Columns of each part at the compared rows."""
        return [
            {key: v[rows[pick]] for key, v in part.values.items()}
            for part, rows, pick in zip(self._parts, self._rows, self._picks, strict=True)
        ]

    def _as_understood(self, understood: Mapping[str, Understanding]) -> list[dict[str, Array]]:
        """The same in SI units, with signs and zeros; without columns that hold no number."""
        return [
            {
                key: u.sign * factor(u.unit)[0] * written[key] - u.offset
                for key, u in understood.items()
                if key in written
            }
            for written in self._as_written()
        ]

    def _key(self, program: Program) -> object:
        """Equal for programs that do the same as far as the file shows it."""
        starts = tuple(program.starts[part.number] for part in self._parts)
        bicycle = tuple(program.bicycle.values.values())
        return bicycle, starts, program.clock, program.rows, program.linear

    def _expect(self, program: Program) -> _Expected:
        """Columns of each part at the compared rows."""
        motions = self._motions(program)
        found = []
        for i, motion in enumerate(motions):
            exact, simulated = self._exact[i], self._simulated[i]
            columns = motion | {name: exact[name] + (motion[name] - simulated[name])
                                for name in exact}  # fmt: skip
            for change in program.rows:
                columns = dict(change(columns, self._times[i]))
            found.append({name: columns[name][self._picks[i]] for name in exact})
        return found

    def _before(self, expected: _Expected) -> dict[_Place, float]:
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

    def _differ(self, place: _Place, one: _Expected, other: _Expected) -> bool:
        """Whether two programs differ in a column by more than the simulation's roundoff."""
        number, key = place
        i = next(i for i, part in enumerate(self._parts) if part.number == number)
        distance = np.abs(one[i][key] - other[i][key])
        scale = float(np.max(np.abs(self._compared[i][key])))
        return bool(np.fmax.reduce(distance, initial=0.0) > _ROUNDOFF * scale)

    def _motions(self, program: Program) -> list[dict[str, Array]]:
        """Columns of each part as the program computes them, at the times that it means."""
        p = {s: float(x) for s, x in program.bicycle.values.items()}
        values = tuple(program.bicycle.values.values())
        found = []
        for i, part in enumerate(self._parts):
            start = program.starts[part.number]
            key = values, start, program.clock, program.linear, i
            if key not in self._found:
                meant = program.clock(self._times[i], self._steps[i])
                state = initial_state(p, start)
                self._found[key] = (
                    linear_columns(program.bicycle, state, meant, program.linear)
                    if program.linear
                    else self._simulators[i].run(program.bicycle, state, meant)
                )
            found.append(self._found[key])
        return found

    def _typical(
        self, expected: _Expected
    ) -> tuple[Mapping[str, Understanding], dict[_Place, float]]:
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


def _nearest(key: str, values: Array, expected: Mapping[str, Array]) -> tuple[float, float]:
    """Errors of the first two rows, each in the definition that fits it best; NaN if unknown."""
    errors = np.array([np.abs(values[:2] - expected[c.name][:2]) for c in DEFINITIONS[key]])
    first, second = np.fmin.reduce(errors)
    return float(first), float(second)


def _start(inputs: Mapping[str, str]) -> Start:
    if any(not Exact.parse(inputs[k]).is_zero for k in ("roll", "steer", "steer_rate")):
        raise InputError("diagnosis: found a start that is not upright and straight")
    return Start(
        speed=float(Exact.parse(inputs["speed"])), roll_rate=float(Exact.parse(inputs["roll_rate"]))
    )
