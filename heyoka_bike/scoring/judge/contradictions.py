"""What a file lacks, and what in it contradicts the rest or the exact motion.

Columns that hold one number in every row where the quantity varies were never filled in. Programs
that write the benchmark's file without some of its columns, the energies mostly, leave zeros in
their place, NaN or the first value. That is no result: it is named, and left out. A requirement
that speaks of such a column fails, see `requirements`.

Rows may hold the right motion at times that are off by a constant, such as one second. Small shifts
look like other errors and are left to the diagnosis. Here the whole motion has to fit: shifted by
one and the same time in all maneuvers, what was wrong all over is right.

Numbers may be of single precision: written as such, or computed with on the way. Energies and rates
may disagree with each other, whatever their distance from the reference. Rows may not be there,
energy may hide an error, and digits may not be written.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL, RATE_OF
from heyoka_bike.numbers.double import Array, median, two_sum
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.scoring.alignment import Alignment, Part, spread
from heyoka_bike.scoring.findings import Finding, grouped, info, maneuvers, named, warning
from heyoka_bike.scoring.measures import FEW, TOLERANCE, rms
from heyoka_bike.scoring.reading.quanta import are_single
from heyoka_bike.scoring.report import ColumnScore, Consistency, Report
from heyoka_bike.scoring.units import factor
from heyoka_bike.scoring.verdict import SUM_ROUNDING

# Fewer rows may be alike.
_FEW_ROWS = 10
# Another number than zero is what was never filled in of these alone: a constant speed is what the
# linear equations have, a constant angle what a motion has that stands still.
_HELD = ("potential_energy", "kinetic_energy", "mechanical_energy")
# What is said of numbers that are none.
_NOTHING = {"nan": "nothing but NaN", "0.0": "nothing but zeros", "-0.0": "nothing but zeros"}
# Zeros are the rate of such an angle.
_RATES = {"roll_rate": "roll_angle", "steer_rate": "steer_angle"}
# Of a bicycle that runs upright and straight nothing varies but by an integrator's roundoff.
_ROUNDOFF = 1e-9
# The quantity varies by more of what can be written than this: rounding does not explain one value.
_STEPS = 4.0


def without_unfilled(alignment: Alignment) -> Alignment:
    """The rows without the columns that were never filled in, and a finding that names them.

    A file that has nothing else stays as it is.
    """
    found = [(part, _unfilled(part)) for part in alignment.parts]
    kept = tuple(
        part.only(part.values.keys() - keys) if keys else part
        for part, keys in found
        if part.values.keys() - keys
    )
    if not kept or not any(keys for _, keys in found):
        return alignment
    return replace(alignment, parts=kept, findings=(*alignment.findings, _finding(found)))


def _unfilled(part: Part) -> dict[str, float]:
    """The columns that were never filled in, with the number that they hold."""
    empty = {key: np.nan for key, x in part.values.items() if len(x) and np.isnan(x).all()}
    if len(part.time) < _FEW_ROWS or _runs_straight(part):
        return empty
    columns = part.only(BENCHMARK_COLUMNS).values
    constant = {key: float(x[0]) for key, x in columns.items() if np.all(x == x[0])}
    found = {
        key: number
        for key, number in constant.items()
        if (key in _HELD if number else not constant.get(_RATES.get(key, "")))
        and _should_vary(part, key, number)
    }
    # Their sum is constant, as the mechanical energy should be, and as empty.
    parts = [found.get(key) for key in ("potential_energy", "kinetic_energy")]
    total = constant.get("mechanical_energy")
    if None not in parts and total is not None and total == sum(x or 0.0 for x in parts):
        found["mechanical_energy"] = total
    return empty | found


def _runs_straight(part: Part) -> bool:
    """True if all columns together are those of a bicycle that stays upright and straight."""
    lateral = part.only(LATERAL).values.values()
    others = part.only({*BENCHMARK_COLUMNS} - {*LATERAL}).values.values()
    return (
        bool(lateral and others)
        and not any(x.any() for x in lateral)
        and all(x.any() and np.ptp(x) <= _ROUNDOFF * np.max(np.abs(x)) for x in others)
    )


def _should_vary(part: Part, key: str, number: float) -> bool:
    """True if no definition of the quantity is one number, as far as the digits written show."""
    names = [c.name for c in part.reference.definitions[key]]
    rows = part.time[part.sample()]
    quantum = part.quantum.get(key)
    for name, expected in part.reference.approximate(rows, names).items():
        step = 1e-15 * part.reference.scale(name)
        if quantum is not None:
            step = max(step, float(np.max(quantum.at(expected))))
        # Nothing but zeros is no mechanical energy either, which is constant.
        far = np.max(np.abs(expected)) if number == 0.0 else np.ptp(expected)
        if far <= _STEPS * step:
            return False
    return True


def _finding(found: Sequence[tuple[Part, dict[str, float]]]) -> Finding:
    held = grouped((of, part.number) for part, keys in found for of in keys.items())
    alike = grouped(((number, tuple(where)), key) for (key, number), where in held.items())
    said = []
    for (number, where), keys in alike.items():
        of = f" of maneuver {', '.join(map(str, where))}" if len(where) < len(found) else ""
        what = _NOTHING.get(str(number), f"{number:.9g}")
        said.append(f"{', '.join(keys)}{of} hold{'s' if len(keys) == 1 else ''} {what}")
    return warning(
        "never_filled",
        f"{', '.join(said)}: one number in every row of what varies, so never filled in; left out "
        "of the result",
        columns=[f"{part.number}.{key}" for part, keys in found for key in keys],
    )


# Rows that are compared, and times that are tried first [s]: the fastest mode decays in 0.05 s.
_ROWS = 200
_GRID = 0.02
# Below this part of their size the columns are not wrong enough to ask.
_WRONG = 0.02
# ... and shifted they have to be so many times better in each maneuver, and this good. Definitions
# of the roll angle differ by 0.03 of it.
_BETTER = 10.0
_RIGHT = 0.05
# Half the rows at least must have a place in the run.
_KEPT = 0.5
# Halvings of the golden section: from a hundredth of a second to a nanosecond.
_ROUNDS = 40
_GOLDEN = (5**0.5 - 1) / 2
# A time of few decimals is meant if the file cannot tell it from the best one [s].
_DECIMALS = range(7)
_AS_GOOD = 1.1


def time_shifted(report: Report) -> Iterator[Finding]:
    """Times that are off by a constant."""
    shift = time_shift([m.part for m in report.maneuvers])
    if shift is None:
        return
    first = all(abs(m.part.time[0] - shift) < (m.step or 0.0) / 10 for m in report.maneuvers)
    starts = f"; the first row, at {shift:.6g} s, holds the initial state" if first else ""
    yield warning(
        "time_shifted",
        f"All times are {abs(shift):.9g} s too {'late' if shift > 0 else 'early'}: with that taken "
        f"{'off' if shift > 0 else 'into account'} the motion fits{starts}. The errors here are "
        "those at the times as written",
        shift=shift,
    )


def time_shift(parts: Sequence[Part]) -> float | None:
    """Return the delay of the times of a file [s]; None if they are not shifted.

    Signs and units of the columns are those that fit best, definitions those by default.
    """
    motions = [few for part in parts if (few := _some_rows(part)) is not None]
    if not motions or any(_error(m, 0.0) < _WRONG for m in motions):
        return None
    longest = max(float(m.time[-1]) for m in motions)
    if longest <= 0.0:
        # All rows are of the start, which fits any motion.
        return None
    grid = np.arange(-longest, longest, _GRID)
    first = min(grid, key=lambda shift: _joint(motions, shift, exact=False))
    best = _refined(motions, float(first))
    numbers = [m.number for m in motions]
    apart = [float(median(np.diff(p.time))) for p in parts if p.number in numbers]
    if abs(best) <= 1.5 * max(apart):
        return None
    before, after = ([_error(m, shift) for m in motions] for shift in (0.0, best))
    if any(a > _RIGHT or _BETTER * a > b for a, b in zip(after, before, strict=True)):
        return None
    limit = _AS_GOOD * _joint(motions, best)
    return next(
        (x for x in (round(best, n) for n in _DECIMALS) if _joint(motions, x) <= limit), best
    )


def _some_rows(part: Part) -> Part | None:
    """Some rows of the columns that show a shift; None without any."""
    if len(part.time) < 2:
        return None
    # Speed and energies hardly vary: they show no shift.
    some = part.at(spread(len(part.time), _ROWS)).only(LATERAL)
    good = np.all([np.isfinite(x) for x in some.values.values()], axis=0)
    return some.at(good) if some.values and good.any() else None


def _error(part: Part, shift: float, *, exact: bool = True) -> float:
    """Error over size of the worst column, with times so much earlier.

    If not exact, by straight lines between the rows of the reference.
    """
    time, reference = part.time - shift, part.reference
    inside = (time >= 0.0) & (time <= float(reference.duration))
    if np.mean(inside) < _KEPT:
        return np.inf
    time = time[inside]
    if exact:
        expected = reference.approximate(time, list(part.values))
    else:
        expected = {k: np.interp(time, reference.time, reference.rows[k]) for k in part.values}
    return max(_apart(x[inside], expected[k]) for k, x in part.values.items())


def _apart(values: Array, expected: Array) -> float:
    """Error over size of a column, with the sign and the unit that fit."""
    size, own = rms(expected), rms(values)
    if not size or not own:
        return np.inf
    in_degrees = factor("degree")[0]
    # Rates are in degrees per second where angles are in degrees.
    unit = in_degrees if own > size / in_degrees**0.5 else 1.0
    sign = np.sign(np.dot(values / own, expected / size))
    return rms(sign * unit * values - expected) / size


def _joint(motions: Sequence[Part], shift: float, *, exact: bool = True) -> float:
    """Geometric mean of the errors over the maneuvers."""
    errors = [_error(m, shift, exact=exact) for m in motions]
    return float(np.exp(np.mean(np.log(np.maximum(errors, np.finfo(np.float64).tiny)))))


def _refined(motions: Sequence[Part], near: float) -> float:
    """The best shift within a step of the grid, by golden section."""
    low, high = near - _GRID, near + _GRID
    for _ in range(_ROUNDS):
        a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        if _joint(motions, a) < _joint(motions, b):
            high = b
        else:
            low = a
    return (low + high) / 2


_BITS = 24
_ENOUGH_ROWS = 50
# Rows that are looked at.
_MOST_ROWS = 4000
# Rounding to 24 bits leaves 1.7e-8 to 3.4e-8 of a value, root mean square; a value that is computed
# from some rounded ones, a few times that.
_NOISE = (1.2e-8, 3e-7)
# Root mean square of third over second differences: 1.83 for white noise, far less for a smooth
# error. With a thousand rows it scatters by 0.03.
_WHITE = (1.6, 2.0)
# Times the floor: what few digits leave of a right value.
_OF_DIGITS = 4.0
# The noise is said of a file if that many of its columns have it.
_MOSTLY = 2 / 3


def single_precision(report: Report) -> Iterator[Finding]:
    """Say that a file was written or computed in single precision, though with more digits."""
    every = [(m.part, c) for m in report.maneuvers for c in m.columns]
    # A constant is a number of any precision.
    telling = [(p, c) for p, c in every if c.values >= _ENOUGH_ROWS and np.ptp(c.trace.value)]
    single = {c.key for part, c in telling if _is_single(part, c)}
    others = {c.key for _, c in telling} - single
    noisy = [c.key for _, c in telling if _has_its_noise(c)]
    if telling and len(single) >= len(others):
        yield warning(
            "single_precision",
            f"{'Most' if others else 'All'} values are single-precision numbers, good to seven "
            "digits, however many are written: an error of 1e-7 of a value, or one that grows from "
            "that, is the arithmetic and not the model; compute and store in double precision",
            columns=sorted(single if others else {c.key for _, c in every}),
        )
    elif telling and len(noisy) >= _MOSTLY * len(telling):
        yield warning(
            "single_precision",
            "The values jump from row to row by some 1e-7 of their size, as numbers of single "
            "precision on the way leave them: this is the arithmetic and not the model; compute "
            "in double precision throughout",
            columns=sorted(set(noisy)),
        )


def _is_single(part: Part, c: ColumnScore) -> bool:
    """True if a column holds numbers of single precision, and more digits than these have."""
    quantum = part.quantum.get(c.key)
    if quantum is None or quantum.base != 2:
        return False
    return quantum.digits == _BITS or are_single(part.values[c.key])


def _has_its_noise(c: ColumnScore) -> bool:
    """True if the error is noise of the size that rounding to 24 bits leaves.

    Where so few digits are written that their rounding is as large, it says nothing.
    """
    if c.as_understood.measures.max_abs_error in (None, 0.0) or c.is_at_floor(_OF_DIGITS):
        return False
    error: Array = c.trace.error[:_MOST_ROWS]
    size = rms(c.trace.value[:_MOST_ROWS])
    second, third = (rms(np.diff(error, n)) for n in (2, 3))
    if not second or not size:
        return False
    noise = second / 6**0.5 / size
    return _NOISE[0] < noise < _NOISE[1] and _WHITE[0] < third / second < _WHITE[1]


# The angle's own error must explain less than this part of what its rate is wrong by: an error of
# the integrator moves both alike, differences of a good angle do not.
_MUCH_BETTER = 1 / 3
# Rounding of neighbouring values explains this many times the floors.
_ROUNDED = 3.0
# Rows farther apart than this [s] do not show the derivative: the fastest mode decays in 0.05 s.
_WIDEST = 0.05


def consistency(part: Part, columns: Sequence[ColumnScore]) -> Consistency:
    """Sum of the energies, and rates against the derivatives of their own angles."""
    by_key = {c.key: c for c in columns if c.values and not c.missing}
    total, floor = _energy_sum(by_key, has_rest=any("energy" in key for key in part.lo))
    found = {key: _rate(part.reference, by_key, key) for key in ("roll_rate", "steer_rate")}
    return Consistency(
        energy_sum=total,
        energy_sum_floor=floor,
        roll_rate=found["roll_rate"][0],
        steer_rate=found["steer_rate"][0],
        contradicted=tuple(key for key, (_, is_contradicted) in found.items() if is_contradicted),
    )


def against_itself(report: Report) -> Iterator[Finding]:
    """Energies that do not add up, and rates that are visibly not those of their own angles."""
    apart = {
        m.maneuver: (c.energy_sum, c.energy_sum_floor)
        for m in report.maneuvers
        if (c := m.consistency).energy_sum is not None
        and c.energy_sum_floor is not None
        and c.energy_sum > SUM_ROUNDING * c.energy_sum_floor
    }
    if apart:
        total, floor = max(apart.values())
        said = (
            f"{maneuvers(apart)}: potential plus kinetic energy differs from the mechanical energy "
            f"by up to {total:.2g} J; rounding explains {floor:.2g} J"
        )
        yield warning("energy_sum", said, maneuvers=[*apart], energy_sum=total, floor=floor)
    for key in ("roll_rate", "steer_rate"):
        off = {
            m.maneuver: x
            for m in report.maneuvers
            if key in m.consistency.contradicted
            and (x := getattr(m.consistency, key))
            > TOLERANCE * float(abs(m[key].trace.reference).max())
        }
        if off:
            most = max(off.values())
            said = (
                f"{maneuvers(off)}: {key} is not the derivative of its own angle, which is much "
                f"better than it: up to {most:.2g} rad/s apart (root mean square)"
            )
            evidence = {"maneuvers": [*off], "column": key, "rms_difference": most}
            yield warning("rate_is_not_the_derivative", said, **evidence)


def _energy_sum(
    columns: Mapping[str, ColumnScore], *, has_rest: bool
) -> tuple[float | None, float | None]:
    """Largest difference of the sum, and what rounding explains of it [J]."""
    keys = ("potential_energy", "kinetic_energy", "mechanical_energy")
    if not all(key in columns for key in keys):
        return None, None
    traces = [columns[key].trace for key in keys]
    if has_rest:
        # Values of more digits than binary64: the reference adds up, so their errors have to.
        difference = traces[0].error + traces[1].error - traces[2].error
    else:
        total, rest = two_sum(traces[0].value, traces[1].value)
        difference = (total - traces[2].value) + rest
    floors = [columns[key].floor for key in keys]
    floor = None if None in floors else float(sum(f for f in floors if f is not None))
    if has_rest and floor is not None:
        # The reference itself is known to 1e-31 of its scale, see the dense bounds.
        floor += 1e-30 * float(np.max(np.abs(traces[2].value)))
        # Errors are known to binary64, those of very many rows to 1e-15 of the scale.
        floor += sum(1e-15 * float(np.max(np.abs(t.error))) for t in traces)
        if len(traces[0].time) * len(columns) > FEW:
            floor += sum(2e-15 * float(np.max(np.abs(t.value))) for t in traces)
    return float(np.max(np.abs(difference))), floor


def _rate(
    reference: ReferenceManeuver, columns: Mapping[str, ColumnScore], key: str
) -> tuple[float | None, bool]:
    """Difference of a rate from the derivative of its angle over a step, rms [rad/s].

    Returned with whether the rate is to blame: the difference is more than rounding and much more
    than what the angle's own error amounts to.

    The reference's own rate and angle agree, so it is enough to look at the errors, which are
    small and smooth: over a step, the increase of the angle's error should be the integral of the
    rate's error, taken by the trapezoidal rule.
    """
    if key not in columns:
        return None, False
    rate = columns[key]
    pair = RATE_OF.get((key, rate.as_understood.definition))
    angle = columns.get(pair[0]) if pair else None
    if pair is None or angle is None or angle.as_understood.definition != pair[1]:
        return None, False
    t = rate.trace.time
    step = np.diff(t)
    usual = float(median(step)) if len(step) else 0.0
    if not 0.0 < usual <= _WIDEST:
        return None, False
    # Repeated times and event steps have no step to speak of.
    near = (step > usual / 10) & (step <= _WIDEST)
    with np.errstate(over="ignore"):
        slope = np.diff(angle.trace.error)[near] / step[near]
    if not np.isfinite(slope).all():
        return None, False
    mean = (rate.trace.error[1:] + rate.trace.error[:-1])[near] / 2
    found = rms(slope - mean)
    if _distance_left_open(reference, rate, angle) > found / 2:
        return None, False
    rounding = 2**0.5 * (angle.floor or 0.0) / usual + (rate.floor or 0.0)
    return found, found > _ROUNDED * rounding and rms(slope) < _MUCH_BETTER * found


def _distance_left_open(
    reference: ReferenceManeuver, rate: ColumnScore, angle: ColumnScore
) -> float:
    """Return the distance of the rates that the two columns may honestly mean, rms [rad/s]."""
    names = {c.definition: c.name for c in reference.definitions[rate.key]}
    angles = {(angle.key, other) for other in angle.indistinguishable}
    meant = list(rate.indistinguishable)
    # A set may have an angle and not its rate.
    meant += [d for (_, d), of in RATE_OF.items() if of in angles and d in names]
    own = names[rate.as_understood.definition]
    rows = reference.approximate(reference.time, [own, *(names[d] for d in meant)])
    return max((rms(rows[names[other]] - rows[own]) for other in meant), default=0.0)


# Fewer digits than binary64 holds are worth mentioning where they are what limits the score.
_DIGITS_OF_BINARY64 = 15
# An error of this part of the scale is seen in a plot; the benchmark's measure may miss it.
_VISIBLE = 1e-2
# An error of up to this many floors is that of the digits written.
_LIMITED = 2.0


def coverage(report: Report) -> Iterator[Finding]:
    """Parts of the run that no rows show; maneuvers with the same rows are named together."""
    said = set()
    for m in report.maneuvers:
        duration = float(m.part.reference.duration)
        slack = 1.5 * (m.step or 0.0) / duration
        ends = (m.t_start, m.t_end, m.gap)
        if ends in said or (m.coverage and m.coverage + 2 * slack >= 1.0):
            continue
        said.add(ends)
        which = [n.maneuver for n in report.maneuvers if (n.t_start, n.t_end, n.gap) == ends]
        rows = f"complete rows of maneuver {', '.join(map(str, which))}"
        what = f"{rows} cover {m.t_start:.6g} to {m.t_end:.6g} s only; the rest of the run is"
        if m.coverage < (m.t_end - m.t_start) / duration - slack or not m.coverage:
            what = f"{rows} are up to {m.gap:.3g} s apart; what the motion does meanwhile is"
        evidence = {"maneuvers": which, "t_start": m.t_start, "t_end": m.t_end, "gap": m.gap}
        yield warning("coverage", f"{what} not judged", **evidence)


def energy_hides_error(report: Report) -> Iterator[Finding]:
    """Maneuvers that meet eq. (1), although something else of them is visibly wrong."""
    limit = next((m.performance_limit for m in report.maneuvers if m.performance_limit), None)
    hidden = {}
    for m in report.maneuvers:
        if m.performance is None or limit is None or m.claim(limit)[0] >= limit:
            continue
        wrong = {
            c.key: c.max_rel_error or 0.0
            for c in m.columns
            if c.is_known and not c.is_at_floor(_LIMITED)
        }
        key = max(wrong, key=wrong.__getitem__, default="")
        worst = wrong.get(key, 0.0)
        # Where the energy itself is wrong, it shows the error, but eq. (1) does not ask for it.
        if worst > _VISIBLE and wrong.get("mechanical_energy", 0.0) < _VISIBLE:
            hidden[m.maneuver] = worst, key, m.performance
    if hidden:
        number = max(hidden, key=hidden.__getitem__)
        worst, key, performance = hidden[number]
        part = f"{100 * worst:.0f}" if worst >= 0.1 else f"{100 * worst:.2g}"
        said = (
            f"{maneuvers(hidden)}: eq. (1) is met, and yet {key} is wrong by up to {part} % of its "
            "scale; energy alone does not show this error"
        )
        evidence = {"maneuvers": [*hidden], "maneuver": number, "performance": performance}
        yield warning("energy_hides_error", said, **evidence, column=key, max_rel_error=worst)


def digits_written(report: Report) -> Iterator[Finding]:
    """Where not the program but the digits it wrote limit the score, if not for their precision."""
    digits = report.file.significant_digits
    if digits is None or digits >= _DIGITS_OF_BINARY64:
        return
    single = [key for f in single_precision(report) for key in f.evidence["columns"]]
    limited = [
        key
        for key, places in report.by_column().items()
        if key not in single and all(c.is_at_floor(_LIMITED) for _, c in places)
    ]
    if limited:
        said = (
            f"{named(limited)}: the error is that of the digits written ({digits} in the "
            "column with the fewest); write 17 to show what the program can do"
        )
        yield info("digits_written", said, columns=limited, significant_digits=digits)
