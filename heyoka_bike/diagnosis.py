"""Why a result differs: the mistakes whose simulation explains the file.

A hypothesis is a program that makes one or two of the usual `mistakes`. Its motion is simulated,
and the file is compared with that motion as it is with the reference, with the definitions, signs
and units that then fit best. The *gain* of a hypothesis is the geometric mean, over maneuvers and
columns, of the factor by which the typical error (see `understanding`) falls from the correct
program to it: the likelihood ratio if the size of what remains, an unknown smooth error of
the integrator and the digits written, is unknown in each column. Motions are compared through their
difference from the simulated correct one, so that the simulation's own error cancels.

The *relief* is the same mean over the columns that the mistakes change at all: a wrong rate alone
changes two of eight. Nothing is claimed below a relief of 2. Hypotheses are ranked by their gain;
those within a factor 2 of the first of a class cannot be told apart by the file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from heyoka_bike.alignment import Alignment, Part, spread
from heyoka_bike.chebyshev import Array
from heyoka_bike.columns import COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.exact import Exact
from heyoka_bike.mistakes import MISTAKES, Mistake, Program, apply
from heyoka_bike.parameters import Bicycle
from heyoka_bike.reference import Reference
from heyoka_bike.simulator import Simulator
from heyoka_bike.start import Start, initial_state
from heyoka_bike.understanding import Sample, Understanding, understand_samples

# Rows that are compared in the search, and rows that are simulated, of each maneuver.
_COMPARED = 251
_SIMULATED = 2001
# The same factor that tells definitions apart.
_TOLD_APART = 2.0
# A second mistake must explain this much more than the first alone: two always fit a little better.
_SECOND = 3.0
# The simulation's relative roundoff, at most.
_ROUNDOFF = 1e-11
# Mistakes that are tried together with all others, the best of them alone.
_LEADERS = 8

Progress = Callable[[float], None]
"""Called with the part of the work that is done, 0 to 1."""


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
    """

    mistakes: tuple[Mistake, ...]
    gain: float
    relief: float
    before: Mapping[tuple[int, str], float]
    after: Mapping[tuple[int, str], float]

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the mistakes."""
        return tuple(m.code for m in self.mistakes)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What explains a file.

    Attributes
    ----------
    classes : tuple of tuple of Hypothesis
        Ranked; hypotheses of a class cannot be told apart. Empty if nothing explains it.
    tried
        How many hypotheses were simulated.
    """

    classes: tuple[tuple[Hypothesis, ...], ...]
    tried: int


def diagnose(
    alignment: Alignment, reference: Reference, *, simulator: Simulator | None = None,
    progress: Progress = lambda _: None,
) -> Diagnosis:  # fmt: skip
    """Search the mistakes, alone and in pairs, that explain a file.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """
    search = _Search(alignment.parts, reference, simulator or Simulator())
    singles = []
    for i, mistake in enumerate(MISTAKES):
        singles.append(search.judge((mistake,)))
        progress(0.2 * (i + 1) / len(MISTAKES))
    singles.sort(key=lambda h: -h.gain)
    pairs = []
    leaders = [h.mistakes[0] for h in singles[:_LEADERS]]
    chosen = [(a, b) for a, b in combinations(MISTAKES, 2) if a in leaders or b in leaders]
    for i, pair in enumerate(chosen):
        pairs.append(search.judge(pair))
        progress(0.2 + 0.8 * (i + 1) / len(chosen))
    return Diagnosis(_classes(singles, pairs), len(singles) + len(pairs))


def _classes(
    singles: Sequence[Hypothesis], pairs: Sequence[Hypothesis]
) -> tuple[tuple[Hypothesis, ...], ...]:
    """What is worth claiming, ranked, in classes that cannot be told apart."""
    alone = {h.mistakes[0].code: h.gain for h in singles}
    clear = [h for h in (*singles, *pairs) if h.relief > _TOLD_APART and h.gain > 1.0]
    worth = [
        h
        for h in clear
        if len(h.mistakes) == 1 or h.gain > _SECOND * max(1.0, *(alone[c] for c in h.codes))
    ]
    worth.sort(key=lambda h: -h.gain)
    classes: list[list[Hypothesis]] = []
    for h in worth:
        if classes and classes[-1][0].gain < _TOLD_APART * h.gain:
            classes[-1].append(h)
        else:
            classes.append([h])
    return tuple(tuple(c) for c in classes)


class _Search:
    """The file, its rows that count, and the correct motion."""

    def __init__(self, parts: Sequence[Part], reference: Reference, simulator: Simulator) -> None:
        self._parts = parts
        self._simulator = simulator
        values = {s: Exact.parse(x) for s, x in reference.parameters.items()}
        self._correct = Program(
            bicycle=Bicycle(reference.bicycle, values),
            starts={n: _start(reference[n].inputs) for n in reference},
        )
        self._rows = [spread(len(p.time), _SIMULATED) for p in parts]
        self._picks = [spread(len(rows), _COMPARED) for rows in self._rows]
        self._times = [p.time[rows] for p, rows in zip(parts, self._rows, strict=True)]
        self._exact = [
            p.reference.approximate(t, [c.name for c in COLUMNS])
            for p, t in zip(parts, self._times, strict=True)
        ]
        self._simulated = self._motions(self._correct)
        self._compared = [
            {name: v[pick] for name, v in exact.items()}
            for exact, pick in zip(self._exact, self._picks, strict=True)
        ]
        self._correct_typical = self._typical(self._compared)

    def judge(self, mistakes: tuple[Mistake, ...]) -> Hypothesis:
        """How well the program with these mistakes explains the file."""
        program = apply(self._correct, mistakes)
        motions = self._motions(program)
        expected = []
        for i in range(len(self._parts)):
            columns = {
                name: self._exact[i][name] + (motions[i][name] - self._simulated[i][name])
                for name in self._exact[i]
            }
            for change in program.rows:
                columns = dict(change(columns, self._times[i]))
            expected.append({name: v[self._picks[i]] for name, v in columns.items()})
        after = self._typical(expected)
        before = self._before(expected)
        logs = {k: float(np.log(before[k] / after[k])) for k in after if k in before}
        changed = [x for k, x in logs.items() if self._is_changed(k, expected)]
        return Hypothesis(
            mistakes=mistakes,
            gain=float(np.exp(np.mean(list(logs.values())))) if logs else 0.0,
            relief=float(np.exp(np.mean(changed))) if changed else 0.0,
            before=before,
            after=after,
        )

    def _before(self, expected: Sequence[Mapping[str, Array]]) -> dict[tuple[int, str], float]:
        """Typical errors of the correct program, over the rows that the mistaken one reaches."""
        finite = [np.isfinite(e["roll_angle"]) for e in expected]
        if all(good.all() for good in finite):
            return self._correct_typical
        return self._typical(
            [
                {name: np.where(good, v, np.nan) for name, v in e.items()}
                for e, good in zip(self._compared, finite, strict=True)
            ]
        )

    def _is_changed(self, place: tuple[int, str], expected: Sequence[Mapping[str, Array]]) -> bool:
        """Whether the mistakes change a column by more than the simulation's roundoff."""
        number, key = place
        i = next(i for i, part in enumerate(self._parts) if part.number == number)
        distance = np.abs(expected[i][key] - self._compared[i][key])
        scale = float(np.max(np.abs(self._compared[i][key])))
        return bool(np.fmax.reduce(distance, initial=0.0) > _ROUNDOFF * scale)

    def _motions(self, program: Program) -> list[dict[str, Array]]:
        """Columns of each part as the program computes them, at the times that it means."""
        p = {s: float(x) for s, x in program.bicycle.values.items()}
        found = []
        for part, time in zip(self._parts, self._times, strict=True):
            start = program.starts[part.number]
            step = float(np.median(np.diff(part.time))) if len(part.time) > 1 else 0.0
            meant = program.clock(time, step)
            found.append(self._simulator.run(program.bicycle, initial_state(p, start), meant))
        return found

    def _typical(self, expected: Sequence[Mapping[str, Array]]) -> dict[tuple[int, str], float]:
        """Typical errors in scales, with the definitions that fit."""
        samples = [
            Sample(part, rows[pick], e)
            for part, rows, pick, e in zip(
                self._parts, self._rows, self._picks, expected, strict=True
            )
        ]
        chosen: Mapping[str, Understanding] = understand_samples(samples)
        return {
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
