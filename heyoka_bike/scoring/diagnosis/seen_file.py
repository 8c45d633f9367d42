"""A file, and programs with mistakes that are simulated and compared with it."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS, DEFINITIONS, FOLLOWING
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR, ROWS_COMPARED, Part, are_even, spread
from heyoka_bike.scoring.definitions import Sample, Understandings, understand_samples
from heyoka_bike.scoring.diagnosis import step_log
from heyoka_bike.scoring.diagnosis.budget import Deadline
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis, log_odds_before
from heyoka_bike.scoring.diagnosis.integrated import (
    CARRIED,
    ROWS_FOLLOWED,
    Integrated,
    Run,
    integrated,
)
from heyoka_bike.scoring.diagnosis.mistakes.library import Mistake, Program, apply, mistakes_of
from heyoka_bike.scoring.diagnosis.mistakes.linearised import has_constant_speed
from heyoka_bike.scoring.diagnosis.mistakes.proposals import columns_in_another_order
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, Place, log_ratio
from heyoka_bike.scoring.diagnosis.programs.forces import WITHOUT_POTENTIAL
from heyoka_bike.scoring.diagnosis.programs.linear_motion import linear_columns
from heyoka_bike.scoring.diagnosis.programs.program import Cause, Motion, Start
from heyoka_bike.scoring.diagnosis.programs.simulator import (
    COARSE,
    MotionRequest,
    Simulator,
    requested,
)
from heyoka_bike.scoring.diagnosis.residual.edited import edit_beside_a_value
from heyoka_bike.scoring.diagnosis.residual.fits import SPLIT, Fits
from heyoka_bike.scoring.diagnosis.residual.observed import CONVERGED, STATE_KEYS, in_si, observe
from heyoka_bike.scoring.diagnosis.residual.readings import other_definitions, readings
from heyoka_bike.scoring.diagnosis.residual.residual import Residual, shows_equations
from heyoka_bike.scoring.explanation import Curve
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR
from heyoka_bike.scoring.rows.edits import Columns
from heyoka_bike.scoring.rows.scaled_columns import ColumnRatio
from heyoka_bike.scoring.units import factor

_NAMES_OF_COLUMNS = [c.name for c in (*COLUMNS, *FOLLOWING)]
_OF_POTENTIAL = [
    c.name for key in ("potential_energy", "mechanical_energy") for c in DEFINITIONS[key]
]
# Minimum duration of the beginning of a run [s]. It is a few time constants of the more slowly
# decaying mode of the upright bicycle at the initial speed.
_BEGINNING = 1.0
# Maximum number of programs that are simulated together. The processor's cache and the memory limit
# this number.
_PROGRAMS_AT_ONCE = 32

# Number of rows by which definitions are ranked, see `_by_other_definitions`. They are 0.04 s apart
# in a whole run, which resolves the fastest mode of the bicycle (20 1/s).
_ROWS_FOR_PROMISE = 250

_EDITED = step_log.Step("edited", "is a column also offset or scaled, besides a wrong value?")

Expected = Sequence[Columns]
"""For each part of the file, the columns of a program by name, at the rows that are compared."""


class _SeenPart:
    """A maneuver of the file.

    Attributes
    ----------
    part : Part
    time : ndarray, shape (n,)
        Times of the rows that are simulated [s].
    step
        Median distance of all rows [s].
    pick, compared : ndarray of int, shape (m,)
        Indices of the rows that are compared: in the simulated rows, and in all rows.
    names : list of str
        Names of the columns that are compared.
    of_motion : list of str
        Keys of the columns to which values are fitted: the columns of the state, or all columns if
        the file has none of these.
    """

    def __init__(self, part: Part) -> None:
        rows = spread(len(part.time), ROWS_FOLLOWED)
        self.part, self.time = part, part.time[rows]
        self.step = float(np.median(np.diff(part.time))) if len(part.time) > 1 else 0.0
        self.pick = spread(len(rows), ROWS_COMPARED)
        self.compared = rows[self.pick]
        self.names = [name for name in _NAMES_OF_COLUMNS if name in part.reference.at_any_time]
        there = [key for key, values in part.values.items() if np.isfinite(values).any()]
        self.of_motion = [key for key in there if key in STATE_KEYS] or there

    def right(self) -> Columns:
        """Return the columns of the exact motion."""
        return self.part.reference.approximate(self.time[self.pick], self.names)

    def written_by(self, program: Program, columns: Columns) -> Columns:
        """Return the columns that a program writes for a simulated motion."""
        if any(name not in WITHOUT_POTENTIAL for name, _ in program.motion.amounts):
            # The columns with potential energy are not compared: programs define the energy that
            # such a force stores in different ways.
            unknown = np.full_like(self.time, np.nan)
            columns = {**columns, **dict.fromkeys(_OF_POTENTIAL, unknown)}
        columns = program.written(columns, self.time)
        return {name: columns[name][self.pick] for name in self.names}

    def motion(self, program: Program, rows: Array) -> MotionRequest:
        """Return the request for the motion of a program at the times of some rows [s]."""
        return requested(program, self.part.number, program.clock(rows, self.step))


class FileUnderTest:
    """The file under diagnosis, and programs that are simulated and compared with it.

    Attributes
    ----------
    program : Program
        The correct program.
    right : Hypothesis
        The hypothesis that the program is correct, with the errors of the file.
    residual : Residual or None
        Residual of the equations along the file's motion; None if the file does not show its
        motion.
    maneuvers : list of int
        Numbers of the maneuvers in the file.
    has_one_speed
        True if the forward speed never changes, or is not in the file.
    tried
        Number of programs compared so far.
    edit : ColumnRatio or None
        An offset or a ratio of a column that was found together with a wrong value, if
        `asks_for_edit` was given. The caller must undo it and diagnose the rows again.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        reference: Reference,
        simulator: Simulator,
        library: Sequence[Mistake],
        deadline: Deadline,
        asks_for_edit: bool = False,
    ) -> None:
        self._reference, self._deadline = reference, deadline
        self.program = correct_program(reference)
        times = max((part.time for part in parts), key=len)
        duration = float(reference[1].duration)
        self._library = mistakes_of(tuple(reference), times, duration)
        self.simulator = simulator
        self.tried = 0
        self._parts = [_SeenPart(part) for part in parts]
        self.maneuvers = [part.number for part in parts]
        self._seen = {self._key(self.program)}
        self._usual: Understandings = {}
        right = [p.right() for p in self._parts]
        understood, typical = self._typical(right)
        self.right = Hypothesis(
            (), typical, typical, (), self._limits(understood, right), True, right, understood
        )
        self.edit: ColumnRatio | None = None
        self._asks_for_edit = asks_for_edit
        # Motions without a meaning have infinite or NaN residuals. Suppress the warnings about
        # them.
        with np.errstate(all="ignore"):
            self.residual = self._residual(library) if library else None
        self.has_one_speed = has_constant_speed(parts)

    def of_kind(self, kind: str) -> list[Mistake]:
        """Return the mistakes of the library of a kind, ``start`` or ``output``."""
        return [m for m in self._library if m.kind == kind]

    def judged(self, hypotheses: Iterable[tuple[Cause, ...]]) -> Iterator[Hypothesis]:
        """Simulate programs with these mistakes and compare them with the file.

        Programs that the file cannot distinguish from one tried before are skipped. Each hypothesis
        is yielded as soon as it is judged.

        Raises
        ------
        BudgetSpentError
            The time limit of the diagnosis is reached.
        """
        new: dict[object, tuple[tuple[Cause, ...], Program]] = {}
        for mistakes in hypotheses:
            program = apply(self.program, mistakes)
            new.setdefault(self._key(program), (mistakes, program))
        chosen = [x for key, x in new.items() if key not in self._seen]
        self._seen |= new.keys()
        for i in range(0, len(chosen), _PROGRAMS_AT_ONCE):
            together = chosen[i : i + _PROGRAMS_AT_ONCE]
            made = self._written([program for _, program in together])
            for x, expected in zip(together, made, strict=True):
                self._deadline.check()
                yield self._judge(*x, expected)
                self.tried += 1

    def promising(
        self, hypotheses: Sequence[tuple[Cause, ...]], few: int
    ) -> list[tuple[Cause, ...]]:
        """Return the hypotheses that are worth an accurate simulation of whole runs.

        A cause of all runs also explains the beginning of one, which takes less time to simulate.
        The causes that explain the beginning of the worst maneuver best are then compared with
        whole runs. Both times the simulation is only as accurate as this choice needs. The best
        `few` are returned even if they explain little: one of them may explain the file together
        with another mistake.
        """
        every = [p.part for p in self._parts]
        (number, _), _ = max(self.right.after.items(), key=lambda x: x[1])
        worst = next(part for part in every if part.number == number)
        begun = worst.at(worst.time <= self._first_errors)
        if len(begun.time) < MIN_ROWS_FOR_SHAPE:
            # The file has too few rows at the beginning, so use all of them.
            begun = worst
        likely = self._best(hypotheses, [begun], 1.0 / AS_GOOD)[: THRESHOLDS.max_simulated]
        kept = [h.mistakes for h in likely]
        if len(kept) > few:
            whole = self._best(kept, every, 0.0)
            kept = [h.mistakes for i, h in enumerate(whole) if i < few or h.gain > AS_GOOD]
        self.tried += len(hypotheses) - len(kept)
        return kept

    def _best(
        self, hypotheses: Sequence[tuple[Cause, ...]], parts: Sequence[Part], least: float
    ) -> list[Hypothesis]:
        """Judge hypotheses by some rows; return those with more than the least gain, best first."""
        judge = FileUnderTest(parts, self._reference, self.simulator, (), self._deadline)
        if max(judge.right.after.values(), default=0.0) >= BY_FAR * COARSE.error:
            judge.simulator = Simulator(COARSE)
        known = [h for h in judge.judged(hypotheses) if h.gain > least]
        return sorted(known, key=lambda h: -h.gain)

    @cached_property
    def _first_errors(self) -> float:
        """Return the time at which all maneuvers with a visible error have begun to show it [s].

        Visible: far above the digits. If no maneuver shows its error, the end of the file.
        """
        until = []
        for p, right in zip(self._parts, self.right.expected, strict=True):
            shown = np.zeros(len(p.compared), bool)
            for key, v in self.right.understood.items():
                if (floor := self.right.floors.get((p.part.number, key))) is not None:
                    scale = p.part.reference.scale(key) or 1.0
                    values = in_si(p.part, self.right.understood, key)[p.compared]
                    shown |= np.abs(values - right[v.column.name]) > BY_FAR * floor * scale
            if shown.any():
                until.append(float(p.time[p.pick][np.argmax(shown)]))
        return max(_BEGINNING, max(until)) if until else max(float(p.time[-1]) for p in self._parts)

    def whole_runs(self, mistakes: tuple[Cause, ...] = (), maneuver: int | None = None) -> Fits:
        """Return the fits of whole runs of one maneuver, or of all maneuvers.

        They use the definitions of columns that fit the program with `mistakes` best.
        """
        if mistakes or maneuver is not None:
            return self._whole_runs(mistakes, maneuver)
        return self._fits_of_all

    @cached_property
    def _fits_of_all(self) -> Fits:
        return self._whole_runs((), None)

    def _whole_runs(self, mistakes: tuple[Cause, ...], maneuver: int | None) -> Fits:
        understood, _ = self._typical(*self._written([apply(self.program, mistakes)]))
        parts = [p for p in self._parts if maneuver in (None, p.part.number)]
        written = [
            {key: in_si(p.part, understood, key)[p.compared] for key in p.of_motion} for p in parts
        ]

        def leaves(programs: Sequence[Program]) -> list[list[Array]]:
            asked = [[p.motion(one, p.time[p.pick]) for one in programs] for p in parts]
            found: list[list[Array]] = [[] for _ in programs]
            for made, rows in zip(
                self.simulator.run_near(asked, self._deadline), written, strict=True
            ):
                for blocks, columns in zip(found, made, strict=True):
                    for key, values in rows.items():
                        off = _part_off(columns[understood[key].column.name], values)
                        blocks += np.array_split(off, split)
            return found

        split = min(SPLIT, *(len(p.compared) for p in parts))
        floors = np.full(split * sum(len(rows) for rows in written), ROUNDING)
        # `claims.explains` requires these factors, so values that cannot reach them are not fitted.
        needed = THRESHOLDS.explained_factor if shows_equations(self.residual) else BY_FAR
        return Fits(
            self.program, leaves, floors, len(parts), THRESHOLDS.run_exponent, split, needed
        )

    def _leaves_much(self, residual: Residual) -> bool:
        """True if a wrong file shows the equations, and nothing explains their residual."""
        is_seen = self._is_wrong and shows_equations(residual) and residual.is_resolved
        return is_seen and not residual.is_explained

    @property
    def _is_wrong(self) -> bool:
        """True if an error of a column is visible in a plot."""
        return max(self.right.after.values(), default=0.0) > TOLERANCE

    def edited(self) -> ColumnRatio | None:
        """Find an offset or a ratio of a column that, with one parameter, explains the residual.

        Raises
        ------
        BudgetSpentError
            The time limit of the diagnosis is reached.
        """
        parts = [p.part for p in self._parts]
        with np.errstate(all="ignore"):
            return edit_beside_a_value(parts, self.right.understood, self.program, self._deadline)

    def by_integrators(
        self, found_by: Callable[[Sequence[Run], Deadline], Iterable[Integrated]] = integrated
    ) -> Iterator[Hypothesis]:
        """Yield integration methods whose error resembles the file's error.

        `found_by` is `integrated` or `with_steps_of_rows`. It yields nothing if the rows are not
        evenly spaced.

        Raises
        ------
        BudgetSpentError
            The time limit of the diagnosis is reached.
        """
        if not all(are_even(p.part.time, p.step) for p in self._parts):
            return
        runs = [
            self._integrated(p, right)
            for p, right in zip(self._parts, self.right.expected, strict=True)
        ]
        for found in found_by(runs, self._deadline):
            expected = [
                {name: v + off[name] for name, v in columns.items()}
                for columns, off in zip(self.right.expected, found.off, strict=True)
            ]
            yield self._compared((found.cause,), self.right.floors, expected)
            self.tried += 1

    def _integrated(self, p: _SeenPart, right: Columns) -> Run:
        """Return a maneuver with the errors of its columns, for the comparison with integrators."""
        understood = self.right.understood
        names = {key: understood[key].column.name for key in p.of_motion}
        return Run(
            self.simulator,
            p.motion(self.program, p.time[p.pick]),
            p.step,
            {x: in_si(p.part, understood, k)[p.compared] - right[x] for k, x in names.items()},
            {x: p.part.reference.scale(k) or 1.0 for k, x in names.items()},
            {x: max(CARRIED, self.right.floors[p.part.number, k]) for k, x in names.items()},
        )

    def _judge(self, causes: tuple[Cause, ...], program: Program, expected: Expected) -> Hypothesis:
        return self._compared(causes, self._resolved(program, expected), expected)

    def _compared(
        self, causes: tuple[Cause, ...], floors: Mapping[Place, float], expected: Expected
    ) -> Hypothesis:
        understood, after = self._typical(expected)
        before = {k: x for k, x in self._before(expected).items() if k in after}
        changed = tuple(k for k in before if self._differ(k, expected, self.right.expected))
        ends = self._reaches_the_end(expected)
        return Hypothesis(causes, before, after, changed, floors, ends, expected, understood)

    def _resolved(self, program: Program, expected: Expected) -> Mapping[Place, float]:
        """Return the resolution limit of each column, relative to its scale.

        It is the coarser of the rounding to its digits and the inaccuracy of the simulation.

        A motion near a singularity is simulated less accurately. The drift of its energy, which
        should be constant, measures the inaccuracy.
        """
        if program.motion.amounts or program.edits or program.motion.linear:
            return self.right.floors
        drift = {}
        for p, columns in zip(self._parts, expected, strict=True):
            energy = columns["mechanical_energy"][np.isfinite(columns["mechanical_energy"])]
            scale = p.part.reference.scale("mechanical_energy") or 1.0
            drift[p.part.number] = float(np.ptp(energy)) / scale if len(energy) else 0.0
        return {k: max(x, drift[k[0]]) for k, x in self.right.floors.items()}

    def _limits(self, understood: Understandings, right: Expected) -> dict[Place, float]:
        """Return the resolution limit of each column by its digits, in scales."""
        return {
            (p.part.number, key): (written * factor(understood[key].unit)[0] + known)
            / (p.part.reference.scale(key) or 1.0)
            for p, columns in zip(self._parts, right, strict=True)
            for key, (written, known) in Sample(p.part, p.compared, columns).floor.items()
        }

    def log_odds(self, one: Hypothesis, other: Hypothesis) -> float:
        """Return the log odds of one hypothesis against another, from the columns that differ."""
        places = [
            k
            for k in one.after
            if k in other.after and self._differ(k, one.expected, other.expected)
        ]
        before = log_odds_before(one.mistakes) - log_odds_before(other.mistakes)
        return log_ratio(other.after, one.after, places) + before

    def order_beside(self, h: Hypothesis) -> list[Mistake]:
        """Find an order of the columns that explains the errors left by a hypothesis, or none."""
        written = [{key: v[p.compared] for key, v in p.part.values.items()} for p in self._parts]
        order = columns_in_another_order(written, h.expected)
        return [order] if order else []

    def curves(self, h: Hypothesis) -> tuple[Curve, ...]:
        """Return the errors left by a hypothesis, in the best explained column of each maneuver."""
        relief = {k: h.before[k] / h.after[k] for k in h.after if k in h.before}
        # The places are pairs of maneuver and key. Later pairs replace earlier ones in the
        # dictionary, so sorting by relief keeps the best key of each maneuver.
        best = dict(sorted(relief, key=relief.__getitem__))
        found = []
        for p, *expected in zip(self._parts, self.right.expected, h.expected, strict=True):
            if p.part.number not in best:
                continue
            key = best[p.part.number]
            column = h.understood[key].column
            values = in_si(p.part, h.understood, key)[p.compared]
            before, after = (np.abs(values - e[column.name]) for e in expected)
            good = np.isfinite(after)
            time = p.time[p.pick][good]
            found.append(Curve(p.part.number, key, column.unit, time, before[good], after[good]))
        return tuple(sorted(found, key=lambda c: c.maneuver))

    def _residual(self, library: Sequence[Mistake]) -> Residual | None:
        """Evaluate the equations along the motion, under the best interpretation of the columns."""
        best: Residual | None = None
        tried: list[Understandings] = []
        taken: Understandings = {}
        for i, understood in enumerate(readings(self.right.understood)):
            # The default definitions are tried if nothing explains the residual. Interpretations
            # with other signs are tried only if an unexplained force remains in the equations, or
            # if the file does not show the motion.
            if i > 1 and best is not None and best.visibility and not best.is_open:
                break
            if understood in tried:
                continue
            tried.append(understood)
            made = self._put_in(understood, library)
            # Prefer an interpretation in which the rates agree with the angles.
            if made is not None and (best is None or _clearer(made) > _clearer(best)):
                best, taken = made, understood
                is_enough = not self._is_wrong or best.is_explained
                if best.visibility and not best.is_open and is_enough:
                    break
        if best is not None and self._asks_for_edit and self._leaves_much(best):
            with step_log.logged(_EDITED) as log:
                self.edit = self.edited()
                log.found = partial(str, self.edit)
            if self.edit is not None:
                return best
        if best is not None and best.is_open:
            agree = best.above > BY_FAR
            best = self._by_other_definitions(taken, library, rates_are_slopes=agree) or best
        if best is not None:
            # Compute the fitted values now, within the time limit: all later steps use them.
            _ = best.fitted
        return best

    def _put_in(
        self,
        understood: Understandings,
        library: Sequence[Mistake] = (),
        causes: tuple[Cause, ...] = (),
        converged: float = CONVERGED,
        parts: Sequence[Part] | None = None,
    ) -> Residual | None:
        """Return the residual under one interpretation of the file; None if it shows no motion.

        `parts` are the rows that are used, by default all. Columns with other definitions are
        converted to the default ones with the lengths of the program with these causes, iterating
        until changes are below `converged` [SI].
        """
        bicycle = apply(self.program, causes).motion.bicycle
        equations = Equations.binary64(bicycle)
        parameters = {name: float(x) for name, x in bicycle.values.items()}
        used = [p.part for p in self._parts] if parts is None else parts
        seen = (observe(part, understood, equations, parameters, converged) for part in used)
        motions = [m for m in seen if m is not None]
        return Residual(motions, self.program, library, self._deadline) if motions else None

    def _by_other_definitions(
        self, understood: Understandings, library: Sequence[Mistake], *, rates_are_slopes: bool
    ) -> Residual | None:
        """Return the residual with other definitions of roll and speed, or None.

        An error of the motion hides which definitions the file uses. So choose those under which a
        single unknown, to first order, explains most of the residual. They are ranked by a few rows
        of the maneuver that leans most, in which they differ most. None if no cause explains all of
        the residual.
        """
        parts = [p.part for p in self._parts]
        leaning = max(parts, key=lambda part: _largest_lean(part, understood))
        few = leaning.at(spread(len(leaning.time), _ROWS_FOR_PROMISE))
        taken, most = understood, self._promise(understood, few)
        for keys in (("roll_angle", "roll_rate"), ("forward_speed",)):
            before, begun = most, taken
            for read in other_definitions(taken, keys, rates_are_slopes=rates_are_slopes):
                promise = self._promise(read, few)
                if promise > most:
                    taken, most = read, promise
                if most > BY_FAR * before:
                    break
            made = self._put_in(taken, library) if taken is not begun else None
            if made is None:
                continue
            # Another definition that reduces the residual only a little does so by chance, unless a
            # known mistake explains most of the rest.
            if most < AS_GOOD * before and made.known[0].relief < AS_GOOD:
                continue
            if made.is_open and made.largest is not None:
                made = self._put_in(taken, library, made.largest.mistakes)
            if made is not None and not made.is_open and made.best is not None:
                return made
        return None

    def _promise(self, understood: Understandings, part: Part) -> float:
        """Return the rank of an interpretation, see `Residual.promise`; 0 if it has no motion."""
        found = self._put_in(understood, converged=RIGHT, parts=[part])
        return found.promise if found is not None and found.visibility else 0.0

    def _key(self, program: Program) -> object:
        """Return a key that is equal for programs that the file cannot distinguish."""
        motion = program.motion
        starts = tuple(motion.starts[p.part.number] for p in self._parts)
        bicycle = tuple(map(float, motion.bicycle.values.values()))
        return bicycle, starts, program.edits, motion.amounts, motion.linear

    def _written(self, programs: Sequence[Program]) -> Iterator[Expected]:
        """Simulate programs; return the columns that each program writes."""
        asked = [(p, part, part.motion(p, part.time)) for p in programs for part in self._parts]
        made = iter(
            self.simulator.run_all([m for p, _, m in asked if not p.motion.linear], self._deadline)
        )
        each = (
            part.written_by(
                p,
                linear_columns(m.bicycle, m.start, m.time, p.motion.linear)
                if p.motion.linear
                else next(made),
            )
            for p, part, m in asked
        )
        return ([next(each) for _ in self._parts] for _ in programs)

    def _before(self, expected: Expected) -> Mapping[Place, float]:
        """Return the correct program's typical errors in the rows that another program reaches."""
        finite = [np.isfinite(e["roll_angle"]) for e in expected]
        if all(good.all() for good in finite):
            return self.right.after
        return self._typical(
            [
                {name: np.where(good, v, np.nan) for name, v in columns.items()}
                for columns, good in zip(self.right.expected, finite, strict=True)
            ]
        )[1]

    def _reaches_the_end(self, expected: Expected) -> bool:
        """True if the motion covers at least half of the rows of each maneuver."""
        for p, columns in zip(self._parts, expected, strict=True):
            there = np.any([np.isfinite(v[p.compared]) for v in p.part.values.values()], axis=0)
            reached = np.isfinite(columns["roll_angle"][there])
            if there.any() and np.mean(reached) < MEANINGLESS_ERROR:
                return False
        return True

    def _differ(self, place: Place, one: Expected, other: Expected) -> bool:
        """True if two programs differ in a column by more than the simulation's roundoff."""
        number, key = place
        i = next(i for i, p in enumerate(self._parts) if p.part.number == number)
        distance = np.abs(one[i][key] - other[i][key])
        scale = float(np.max(np.abs(self.right.expected[i][key])))
        return bool(np.fmax.reduce(distance, initial=0.0) > ROUNDING * scale)

    def _typical(self, expected: Expected) -> tuple[Understandings, dict[Place, float]]:
        """Return the definitions that fit best, and the typical errors in scales of the columns.

        All errors are in the unit of the correct program, so a larger unit makes no error smaller.
        """
        samples = [
            Sample(p.part, p.compared, e) for p, e in zip(self._parts, expected, strict=True)
        ]
        chosen = understand_samples(samples)
        self._usual = self._usual or chosen
        units = {k: factor(self._usual[k].unit)[0] / factor(u.unit)[0] for k, u in chosen.items()}
        return chosen, {
            (p.part.number, key): units[key]
            * sample.typical(key, chosen[key])
            / (sample.scale[key] or 1.0)
            for p, sample in zip(self._parts, samples, strict=True)
            for key in sample.values
        }


def _clearer(residual: Residual) -> tuple[bool, float]:
    """Return a sort key of a residual: greater if its interpretation of the columns is better."""
    return bool(residual.visibility), residual.promise


def _largest_lean(part: Part, understood: Understandings) -> float:
    """Return the largest roll angle of a part [rad]; 0 without this column."""
    if "roll_angle" not in part.values or "roll_angle" not in understood:
        return 0.0
    return float(np.nanmax(np.abs(in_si(part, understood, "roll_angle")), initial=0.0))


def _part_off(values: Array, written: Array) -> Array:
    """Return the error of a column relative to its size; 1 after the end of the motion."""
    there = np.isfinite(written)
    size = (rms(written[there]) if there.any() else 0.0) or 1.0
    off = np.nan_to_num((written - values) / size, nan=1.0, posinf=1.0, neginf=1.0)
    return np.where(there, off, 0.0)


def correct_program(reference: Reference) -> Program:
    """Return the program that computes the motions of a reference."""
    starts = {n: _start(reference[n].inputs) for n in reference}
    return Program(Motion(Bicycle.parse(reference.bicycle, reference.parameters), starts))


def _start(inputs: Mapping[str, str]) -> Start:
    if any(not Exact.parse(inputs[k]).is_zero for k in ("roll", "steer", "steer_rate")):
        raise InputError(
            "diagnosis: found a reference with another start, expected one that is upright and "
            "straight, with zero steer rate"
        )
    speed, roll_rate = (float(Exact.parse(inputs[k])) for k in ("speed", "roll_rate"))
    return Start(speed=speed, roll_rate=roll_rate)
