"""Find the definition, sign, unit and zero of each column of a file that fit its values best.

The benchmark text prescribes none of them, so a different definition is no error. Each candidate is
compared with the reference, and the likeliest one over all maneuvers of the file together is
chosen. The *typical* error of a candidate in a maneuver is the root mean square of e without the
largest hundredth of the rows, so that a few bad rows do not decide.

An error is a curve of unknown size, however many rows show it: the error of an integrator is
smooth, and neighbouring rows give the same information. If the curve counts as nu independent
values and its size may be anything (a prior of 1 / size), the likelihood of a candidate is
typical^-nu in each maneuver. The *odds* of two candidates are the product of (typical / typical)^nu
over the maneuvers. So a maneuver counts only as far as it distinguishes the candidates: where the
error is larger than the difference of two definitions, or both are below the digits written, its
factor is near 1. The first row, at the known initial conditions, is evidence of its own, because no
integrator has made an error there yet.

The first row also shows the unit and the sign if the motion is wrong. If the row equals the initial
conditions in only one unit and sign, the column has these. An angle has the sign of its rate. If
one column of a file is in degrees, others may be in degrees, however wrong they are.

A rate is the slope of its angle, whatever the motion is. So the rows of a wrong motion, too, show
whether the two have the same sign, and units that belong together. If the signs are opposite, the
one that fits better with the other sign is flipped. A unit other than the assumed one is dropped
if the rate is the slope of its angle in the assumed unit only.

Before the values are compared, the default is five times as likely as any other definition. The
same holds for a definition that belongs to one already found: the derivative of the file's own
angle, or the pitch and yaw of the same attitude. A definition remains open while the odds against
it are below 20 to 1: nothing is claimed without evidence.

A wrong motion may be nearest to any definition by chance. So errors that are smaller than the error
of the motion count as if they were as large as it. The error of the motion is a fraction of the
column's variation: the median of this fraction over the other columns. A column that is off by over
a tenth of its variation in its nearest definition also shows the error: at least twice its own.

*None of the known definitions* is a hypothesis, too, with a prior of one in a hundred files. An
unknown definition would be as far from the known ones as they are from each other. The odds against
it fall if the column's errors are larger than the errors of columns with only one definition. They
rise if both errors are smaller than the distance to the next definition. A wrong motion moves all
columns, so errors are compared relative to the variation of each column. A constant error of the
speed does not change its variation. In a file without a kinetic energy, which would show this
error, errors are compared relative to the scales.

The heading, the places on the floor and the angles of the wheels have no natural zero: a program
may start them from any value.

The zero of the energies is free, and the same for both. A constant difference counts as another
zero if it is ten times as large as the error of any other column: an error of the motion is never
so large and so even.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import (
    ANGLE_OF,
    BENCHMARK_COLUMNS,
    COMPARED,
    DERIVATIVES,
    FREE_ZERO,
    LATERAL,
    RATE_OF,
)
from heyoka_bike.numbers.double import Array, Double, median, two_sum
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR, Part
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE
from heyoka_bike.scoring.measures import TOLERANCE, rms
from heyoka_bike.scoring.noise import FEWEST_ROWS, roughness
from heyoka_bike.scoring.ratios import AS_GOOD, CLEARLY, MOST_ROWS, ODDS_CLAIMED
from heyoka_bike.scoring.recognition import ZEROED
from heyoka_bike.scoring.slopes import Columns, opposite_pairs, slope_sign
from heyoka_bike.scoring.units import UNITS, factor, to_si, tried

# In likelihoods, an error curve counts as this many independent values. Error curves of programs
# have about five (the participation ratio of their spectra). With three, wrong claims are rarer
# than the odds allow, for runs from a quarter of a second to ten seconds (measured in
# docs/measures.md).
_INDEPENDENT_VALUES = 3
_LOG_ODDS_CLAIMED = float(np.log(ODDS_CLAIMED))
# Natural logarithm of the prior odds that all rows of a column are written in the same way. In one
# file in a thousand, the first row or a whole maneuver is written differently from the other rows.
_LOG_ODDS_AGAINST_ODD_ROW = float(np.log(1000.0))
# The typical error leaves out one row in this many: the rows with the largest errors.
_ROWS_FOR_ONE_LEFT_OUT = 100
_LN_10 = float(np.log(10.0))
NEAR_STEADY = 0.02
"""Largest relative error of a column that hardly varies, such as a speed, for its unit to be
recognised. A unit that is not tried, such as ft/s, may differ from a tried unit by only a tenth."""
# Natural logarithm of the prior odds of an expected definition against any other definition.
_LOG_ODDS_OF_EXPECTED = float(np.log(5.0))
# Natural logarithm of the prior odds that a column has one of the known definitions.
_LOG_ODDS_OF_KNOWN = float(np.log(100.0))
_ENERGY_KEYS = ("kinetic_energy", "mechanical_energy", "potential_energy")

_UnitAndSign = tuple[str, int]
"""Unit and sign of a column."""

_ATTITUDE = ("roll_angle", "pitch", "yaw")
_WITH_SLOPES = {*ANGLE_OF, *RATE_OF}
_UNSIGNED = (*_ENERGY_KEYS, "rear_friction", "front_friction")


@dataclass(frozen=True, slots=True)
class Understanding:
    """The interpretation of a written column: its definition, unit, sign and zero.

    Attributes
    ----------
    column : Column
        The definition.
    unit, sign, offset, offset_lo
        SI value = sign * (value in unit) - offset - offset_lo, where offset_lo is far smaller.
    indistinguishable : tuple of str
        Definitions that the file cannot distinguish from this one.
    odds : mapping of str to float
        Odds of this definition against each other one, as decimal logarithms. They are below zero
        if this definition was chosen to agree with other runs.
    none : float or None
        Odds of this definition against any unknown one, as a decimal logarithm; None if only one
        definition is known.
    """

    column: Column
    unit: str
    sign: int = 1
    offset: float = 0.0
    offset_lo: float = 0.0
    indistinguishable: tuple[str, ...] = ()
    odds: Mapping[str, float] = field(default_factory=dict)
    none: float | None = None

    def taken_as(self, column: Column) -> Understanding:
        """Return the interpretation with another definition, and its odds against the others."""
        mine = self.odds[column.definition]
        odds = {d: x - mine for d, x in self.odds.items()}
        odds[self.column.definition] = -mine
        del odds[column.definition]
        alike = tuple(d for d, x in odds.items() if x * _LN_10 < _LOG_ODDS_CLAIMED)
        none = None if self.none is None else self.none - mine
        return replace(self, column=column, indistinguishable=alike, odds=odds, none=none)

    def assumed(self) -> Column:
        """Return the definition to assume: the default, unless the file excludes it."""
        default = COMPARED[self.column.key][0]
        return default if default.definition in self.indistinguishable else self.column

    @property
    def factor(self) -> float:
        """The factor from written values to SI units, negative if the sign is flipped."""
        return self.sign * factor(self.unit)[0]

    def in_si(self, values: Array) -> Array:
        """Return written values in SI units, with the sign and the zero of the definition."""
        return self.factor * values - self.offset

    def exactly_in_si(self, values: Double) -> Double:
        """Return written values in SI units to 32 digits, as hi + lo; lo is often zero."""
        hi, lo = to_si(values, self.unit)
        if self.sign < 0:
            hi, lo = -hi, -lo
        if not self.offset:
            return hi, lo
        hi, rest = two_sum(hi, np.full_like(hi, -self.offset))
        return two_sum(hi, rest + (lo - self.offset_lo))

    def is_plain(self) -> bool:
        """True if the column is read as written: default definition, SI unit, sign and zero."""
        is_moved = self.sign < 0 or self.unit != self.column.unit or self.offset
        return self.column.default and not is_moved


Understandings = Mapping[str, Understanding]
"""The interpretation of each column of a file, by key."""


def plain(key: str) -> Understanding:
    """Return the interpretation of a column as written, with the default definition in SI units."""
    column = COMPARED[key][0]
    return Understanding(column, column.unit)


def understand(parts: Sequence[Part]) -> Understandings:
    """Return the interpretation of each column of a file, the same for all its maneuvers."""
    samples = [Sample(part) for part in parts]
    found = understand_samples(samples)
    return {key: _with_odds_against_unknown(key, found, samples) for key in found}


def understand_samples(samples: Sequence[Sample]) -> Understandings:
    """Return the interpretation of each column that fits the samples' expected motion best."""
    found: dict[str, Understanding] = {}
    starts = _units_and_signs_at_start(samples)
    off_by = [{key: x for key in s.values if (x := s.off_by(key)) is not None} for s in samples]

    def choose(key: str, signs: Sequence[int] = (1, -1), unit: str | None = None) -> Understanding:
        having = [i for i, s in enumerate(samples) if key in s.values]
        errors = [_error_of_motion(key, samples[i], off_by[i]) for i in having]
        return _choose(key, [samples[i] for i in having], errors, found, starts, signs, unit)

    for key in COMPARED:
        if any(key in s.values for s in samples):
            found[key] = choose(key)
    for key, unit in _units_by_slopes(found, samples, starts):
        found[key] = choose(key, unit=unit)
    for pair in _opposite_in_wrong_motion(found, samples, starts):
        flipped = min(pair, key=lambda key: _cost_of_flip(key, found[key], samples))
        found[flipped] = choose(flipped, (-found[flipped].sign,))
    # The kinetic energy has a fixed zero, so it shows the unit best if no heading names one.
    energies = [key for key in _ENERGY_KEYS if key in found]
    if energies:
        found.update(_in_unit(found[energies[0]].unit, energies, found, samples))
    _find_offset(found, samples)
    return found


class Sample:
    """Some rows of a part, with the expected values in every definition and the resolution.

    Parameters
    ----------
    part : Part
    pick : ndarray of int, shape (n,)
        The rows; by default those of `Part.sample`.
    expected : mapping of str to ndarray, shape (n,)
        Expected values at these rows, by column and definition; by default the reference's. Rows
        where they are not finite are left out.
    """

    def __init__(
        self,
        part: Part,
        pick: NDArray[np.intp] | None = None,
        expected: Mapping[str, Array] | None = None,
    ) -> None:
        some = part.at(part.sample() if pick is None else pick)
        self.definitions = definitions = part.reference.definitions
        if expected is None:
            names = [c.name for key in some.values for c in definitions[key]]
            expected = part.reference.approximate(some.time, names)
        self.time, self.values, self.expected, self.scale, self.floor = {}, {}, {}, {}, {}
        self.at_start: set[str] = set()
        self.units = part.units
        height = part.reference["potential_energy"]
        self.varies = rms(height - median(height))
        for key, values in some.values.items():
            good = np.isfinite(values) & np.isfinite(expected[key])
            if not good.any():
                continue
            self.time[key], self.values[key] = some.time[good], values[good]
            if good[0] and some.time[0] == 0.0:
                self.at_start.add(key)
            self.expected.update({c.name: expected[c.name][good] for c in definitions[key]})
            scale = part.reference.scale(key)
            written = float(median(part.spacing(key, values[good]))) / 2
            self.scale[key] = scale
            # The second value is the resolution of binary64 (see `ReferenceManeuver.approximate`).
            self.floor[key] = (written, 1e-15 * scale or np.finfo(np.float64).tiny)

    def start(self, key: str) -> float:
        """Return the initial value in the default definition; 0 if small or without a first row."""
        first = float(self.expected[self.definitions[key][0].name][0])
        return first if key in self.at_start and abs(first) > TOLERANCE * self.scale[key] else 0.0

    def error(self, key: str, u: Understanding) -> Array:
        return u.in_si(self.values[key]) - self.expected[u.column.name]

    def log_likelihoods(
        self, key: str, candidates: Sequence[Understanding], error_of_motion: float = 0.0
    ) -> Array:
        """Return the log likelihoods of candidate interpretations, up to a common constant.

        All candidates are compared at once, because there are some hundred of them, each with some
        hundred rows.

        Parameters
        ----------
        key, candidates
        error_of_motion
            Error that the motion itself may have in this column [SI]. Smaller errors are due to
            chance, so they count as errors of this size.
        """
        factors = np.array([u.factor for u in candidates])
        expected = np.array([self.expected[u.column.name] for u in candidates])
        errors = np.multiply.outer(factors, self.values[key]) - expected
        if key in FREE_ZERO:
            errors -= errors[:, :1]
        errors = np.abs(errors)
        smallest = np.array([self.smallest(key, u) for u in candidates])
        against = np.zeros(len(candidates))
        if key in self.at_start:
            # Evidence of the first row against each candidate definition, as natural log odds.
            against = np.clip(
                np.log(np.maximum(errors[:, 0] / smallest, 1.0)), 0.0, _LOG_ODDS_AGAINST_ODD_ROW
            )
        typical = np.maximum(_typical_sizes(errors), np.maximum(smallest, error_of_motion))
        return np.asarray(-_INDEPENDENT_VALUES * np.log(typical) - against)

    def of_a_constant(self, key: str, u: Understanding) -> float:
        """Return the log likelihood that a column is constant, comparable to `log_likelihoods`."""
        varies = factor(u.unit)[0] * rms(self.values[key] - np.mean(self.values[key]))
        return -_INDEPENDENT_VALUES * float(np.log(max(varies, self.smallest(key, u))))

    def moves(self, key: str) -> float:
        """Return the size [SI] by which errors are divided to compare errors of several columns."""
        if "kinetic_energy" not in self.values:
            return self.scale[key]
        if key in _ENERGY_KEYS:
            return self.varies
        return self.varies_by(key)

    def varies_by(self, key: str) -> float:
        """Return the root mean square of a column's expected values about their median [SI]."""
        expected = self.expected[self.definitions[key][0].name]
        return rms(expected - median(expected))

    def off_by(self, key: str) -> float | None:
        """Return the error of a column in its nearest reading, as a fraction of its variation.

        None for columns that do not show the motion: the mechanical energy is always constant.
        """
        if key not in BENCHMARK_COLUMNS or key == "mechanical_energy":
            return None
        varies = self.varies_by(key)
        if not varies:
            return None
        factors = [sign * factor(unit)[0] for unit, sign in _units_and_signs(key, (self,))]
        expected = np.array([self.expected[c.name] for c in self.definitions[key]])
        errors = np.multiply.outer(factors, self.values[key])[:, None] - expected
        errors = errors.reshape(-1, errors.shape[-1])
        if key in ZEROED:
            errors = errors - median(errors)[:, None]
        return float(np.min(_typical_sizes(np.abs(errors)))) / varies

    def typical(self, key: str, u: Understanding) -> float:
        """Return the rms error [SI] without its largest hundredth; at least the resolution."""
        found = _typical_sizes(np.abs(self.error(key, u))[None])
        return max(float(found[0]), self.smallest(key, u))

    def smallest(self, key: str, u: Understanding) -> float:
        """Return the smallest error [SI] that the digits written and binary64 can show."""
        written, known = self.floor[key]
        return max(written * factor(u.unit)[0], known)


def _typical_sizes(errors: Array) -> Array:
    """Return the rms of each row of errors without its largest hundredth, without overflow."""
    kept = errors.shape[1] - errors.shape[1] // _ROWS_FOR_ONE_LEFT_OUT
    if kept < errors.shape[1]:
        errors = np.partition(errors, kept, axis=1)[:, :kept]
    largest = np.max(errors, axis=1)
    whole = errors / np.where(largest, largest, 1.0)[:, None]
    return np.asarray(largest * np.sqrt(np.mean(np.square(whole), axis=1)))


_Typical = tuple[float, ...]


def _typical(key: str, u: Understanding, samples: Iterable[Sample]) -> _Typical:
    return tuple(s.typical(key, u) for s in samples if key in s.values)


def _log_product(sizes: Iterable[float]) -> float:
    """Return the logarithm of the product of sizes, which itself may overflow."""
    return float(np.sum(np.log(list(sizes))))


def _log_prior(key: str, column: Column, found: Understandings) -> float:
    """Return the natural log of the prior odds of a definition against an unexpected one."""
    angle = DERIVATIVES.get((key, column.definition), ("", ""))
    belongs = angle[0] in found and found[angle[0]].column.definition == angle[1]
    attitude = {u.column.definition for k, u in found.items() if k in _ATTITUDE and k != key}
    belongs |= key in _ATTITUDE and column.definition in attitude
    return _LOG_ODDS_OF_EXPECTED if column.default or belongs else 0.0


def _units_and_signs(key: str, samples: Iterable[Sample]) -> list[_UnitAndSign]:
    """Return all units and signs that a column may have."""
    units = tried(COMPARED[key][0].unit, _named_unit(key, samples))
    return list(product(units, (1,) if key in _UNSIGNED else (1, -1)))


def _named_unit(key: str, samples: Iterable[Sample]) -> str | None:
    """Return the unit that the heading of a column names; None if it names none."""
    return next((s.units[key] for s in samples if key in s.units), None)


def _units_and_signs_at_start(samples: Sequence[Sample]) -> dict[str, _UnitAndSign]:
    """Return the only unit and sign with which the first value equals the initial value, by key."""
    found = {}
    for key in dict.fromkeys(key for s in samples for key in s.values if key not in FREE_ZERO):
        having = [s for s in samples if key in s.values and s.start(key)]
        fitting = [
            pair
            for pair in _units_and_signs(key, samples)
            if all(_begins(s, key, *pair) for s in having)
        ]
        if having and len(fitting) == 1:
            found[key] = fitting[0]
    return found


def _begins(sample: Sample, key: str, unit: str, sign: int) -> bool:
    """True if the first value equals the initial condition within `TOLERANCE`."""
    written, given = sign * factor(unit)[0] * sample.values[key][0], sample.start(key)
    return bool(abs(written - given) <= TOLERANCE * abs(given))


def _assumed_unit_and_sign(
    key: str, samples: Sequence[Sample], starts: Mapping[str, _UnitAndSign]
) -> _UnitAndSign:
    """Return the unit and sign that the first row or the heading shows.

    They are assumed unless the values clearly contradict them, even if the motion is wrong.
    """
    if key in starts:
        return starts[key]
    _, sign = starts.get(RATE_OF.get(key, ""), ("", 1))
    return _named_unit(key, samples) or COMPARED[key][0].unit, sign


def _opposite_in_wrong_motion(
    found: Understandings, samples: Sequence[Sample], starts: Mapping[str, _UnitAndSign]
) -> Iterator[tuple[str, str]]:
    """Yield angles and rates, as interpreted, whose signs contradict each other.

    Columns that are near the expected values show their signs themselves.
    """
    rows = _rows_with_slopes(found, samples)
    for pair in opposite_pairs(rows, is_begun=bool(starts.keys() & ANGLE_OF.keys())):
        if not all(_is_near_as_read(key, found, samples) for key in pair):
            yield pair


def _units_by_slopes(
    found: Understandings, samples: Sequence[Sample], starts: Mapping[str, _UnitAndSign]
) -> Iterator[tuple[str, str]]:
    """Yield angles and rates that must have their assumed unit, for the rate to be the slope.

    Another unit was chosen for them, because the first row of another column shows it.
    """

    def sign(pair: tuple[str, str], units: Sequence[str]) -> int:
        read = {key: replace(found[key], unit=u) for key, u in zip(pair, units, strict=True)}
        return slope_sign(*pair, _rows_with_slopes(read, samples))

    for rate, angle in ANGLE_OF.items():
        pair = angle, rate
        if not found.keys() >= {*pair}:
            continue
        chosen = [found[key].unit for key in pair]
        assumed = [_assumed_unit_and_sign(key, samples, starts)[0] for key in pair]
        if chosen != assumed and not sign(pair, chosen):
            either = product(*zip(chosen, assumed, strict=True))
            fitting = next((units for units in either if sign(pair, units) > 0), chosen)
            yield from (
                (k, unit) for k, unit in zip(pair, fitting, strict=True) if unit != found[k].unit
            )


def _rows_with_slopes(found: Understandings, samples: Sequence[Sample]) -> list[Columns]:
    """Return the times and values [SI] of the angles and rates of each maneuver."""
    return [
        {
            k: (s.time[k], found[k].in_si(s.values[k]))
            for k in s.values.keys() & _WITH_SLOPES & found.keys()
        }
        for s in samples
    ]


def _is_near_as_read(key: str, found: Understandings, samples: Sequence[Sample]) -> bool:
    """True if a column, in the unit and sign chosen for it, is near the expected values."""
    having = [s for s in samples if key in s.values]
    return _is_near(key, _typical(key, found[key], having), having)


def _cost_of_flip(key: str, u: Understanding, samples: Sequence[Sample]) -> float:
    """Return the log likelihood of a column as interpreted, minus that with the opposite sign."""
    both = u, replace(u, sign=-u.sign)
    likely = np.sum([s.log_likelihoods(key, both) for s in samples if key in s.values], axis=0)
    return float(likely[0] - likely[1])


def _error_of_motion(key: str, sample: Sample, off_by: Mapping[str, float]) -> float:
    """Estimate the error that the motion of a sample may have in a column [SI].

    The median over the other columns shows it, even if one of them is bad. A column that is far
    from its nearest definition shows it, too.
    """
    others = [x for k, x in off_by.items() if k != key] or [0.0]
    own = off_by.get(key, 0.0)
    part = max(float(median(others)), AS_GOOD * own if CLEARLY * own > 1.0 else 0.0)
    return part * sample.varies_by(key)


def _choose(
    key: str,
    samples: Sequence[Sample],
    errors_of_motion: Sequence[float],
    found: Understandings,
    starts: Mapping[str, _UnitAndSign],
    signs: Sequence[int],
    unit: str | None,
) -> Understanding:
    """Choose the unit and the sign of a column, then its definition.

    Parameters
    ----------
    key, samples
    errors_of_motion
        Error of the motion in each sample, see `_error_of_motion`.
    found
        Interpretations of the columns that were chosen before.
    starts
        Units and signs that the first row shows.
    signs
        Signs that the column may have.
    unit
        Unit of the column; None to choose it.
    """
    columns = samples[0].definitions[key]
    pairs = [
        pair for pair in _units_and_signs(key, samples)
        if pair[1] in signs and unit in (None, pair[0])
    ]  # fmt: skip
    usual, sign = _assumed_unit_and_sign(key, samples, starts)
    assumed = unit or usual, sign if sign in signs else signs[0]
    candidates = [Understanding(c, *pair) for pair in pairs for c in columns]
    before = np.array([_log_prior(key, c, found) for c in columns])
    likely = np.tile(before, len(pairs)) + np.sum(
        [s.log_likelihoods(key, candidates) for s in samples], axis=0
    )
    # Each row of the table is a unit with a sign, and each column is a definition. argmax takes the
    # first maximum, so the default wins ties.
    table = likely.reshape(len(pairs), -1)
    row, row_assumed = int(np.argmax(table.max(axis=1))), pairs.index(assumed)
    best = _with_free_zero(key, candidates[int(np.argmax(likely))], samples)
    typical = _typical(key, best, samples)
    if not _has_enough_rows(key, typical, samples):
        return replace(plain(key), unit=assumed[0], sign=assumed[1])
    if not _is_near(key, typical, samples):
        # The motion is wrong. Accept a unit other than the assumed one only if the first row of
        # another column shows it.
        units = {u for unit, _ in starts.values() for u in (unit, unit.removesuffix(" s-1"))}
        possible = [
            i for i, (unit, sign) in enumerate(pairs) if unit in units and sign == assumed[1]
        ]
        row = max((row_assumed, *possible), key=lambda i: table[i].max())
    if float(table[row].max() - table[row_assumed].max()) < _LOG_ODDS_CLAIMED:
        row = row_assumed
    # A wrong motion is nearest to some definition by chance. So differences below the error of the
    # motion do not count.
    alike = [Understanding(c, *pairs[row]) for c in columns]
    by_definition = before + np.sum(
        [s.log_likelihoods(key, alike, e) for s, e in zip(samples, errors_of_motion, strict=True)],
        axis=0,
    )
    chosen = int(np.argmax(by_definition))
    taken = _with_free_zero(key, Understanding(columns[chosen], *pairs[row]), samples)
    constant = sum(s.of_a_constant(key, taken) for s in samples)
    if constant - float(likely.max()) > _LOG_ODDS_CLAIMED:
        # A constant column, such as the speed in the linear equations, is nearest to the definition
        # that varies the least. This does not show that the column has this definition, so assume
        # the default.
        return replace(taken, column=columns[0])
    less = by_definition[chosen] - by_definition
    # The values alone must justify a claim, so prior odds in favour of the chosen definition do not
    # count.
    shown = less - np.maximum(before[chosen] - before, 0.0)
    others = [i for i in range(len(columns)) if i != chosen]
    return replace(
        taken,
        indistinguishable=tuple(
            columns[i].definition for i in others if shown[i] < _LOG_ODDS_CLAIMED
        ),
        odds={columns[i].definition: float(less[i]) / _LN_10 for i in others},
    )


def _with_free_zero(key: str, u: Understanding, samples: Sequence[Sample]) -> Understanding:
    """Return the interpretation with the first row's error as offset, if that explains the errors.

    The first row is that of the first maneuver that contains the column. The offset explains the
    errors if it clearly reduces the typical error in every maneuver.
    """
    if key not in FREE_ZERO:
        return u
    moved = replace(u, offset=float(samples[0].error(key, u)[0]))
    both = zip(_typical(key, u, samples), _typical(key, moved, samples), strict=True)
    return moved if all(before >= CLEARLY * after for before, after in both) else u


def _has_enough_rows(key: str, typical: _Typical, samples: Sequence[Sample]) -> bool:
    """True if there are enough rows to judge by, or if the few rows fit to the last digit."""
    if max(len(s.values[key]) for s in samples) >= MIN_ROWS_FOR_SHAPE:
        return True
    floors = [sum(s.floor[key]) for s in samples]
    return all(t <= CLEARLY * f for t, f in zip(typical, floors, strict=True))


def _is_near(key: str, typical: _Typical, samples: Sequence[Sample]) -> bool:
    """True if the typical error is below half the rms of the column (2 % if it hardly varies).

    A column of zeros, or of noise in a unit that makes it tiny, has an error as large as the
    column.
    """
    varies = any(
        float(np.ptp(s.expected[key])) >= MEANINGLESS_ERROR * s.scale[key] for s in samples
    )
    limit = MEANINGLESS_ERROR if varies else NEAR_STEADY
    sizes = [rms(s.expected[key]) for s in samples]
    return all(sizes) and _log_product(typical) < _log_product(limit * x for x in sizes)


def _motion_error(
    sample: Sample,
    found: Understandings,
    without: Collection[str] = (),
    size: Callable[[str], float] | None = None,
) -> float:
    """Return the motion's error: the largest relative error of columns with only one definition.

    Errors are relative to the size of each column, by default its scale. The result is 1 if too few
    columns show the motion: at least two, with roll or steer among them. Speed and energies follow
    the squares of roll and steer, so they may be right in a wrong motion.
    """
    of = sample.scale.__getitem__ if size is None else size
    errors = {
        key: sample.typical(key, found[key]) / of(key)
        for key in sample.values
        if key in BENCHMARK_COLUMNS and key not in without
        if len(sample.definitions[key]) == 1 and of(key)
    }
    is_told = len(errors) > 1 and any(key in LATERAL for key in errors)
    return max(errors.values()) if is_told else 1.0


def _speed_error(sample: Sample, found: Understandings) -> float:
    """Return the error of the speed and the kinetic energy, relative to their variation.

    They vary with the squares of roll and steer, so the motion's relative error is half as large.
    The result is 1 without these columns.
    """
    keys = [k for k in ("forward_speed", "kinetic_energy") if k in sample.values]
    off = [sample.typical(k, found[k]) / x for k in keys if (x := sample.varies_by(k))]
    return max(off, default=1.0)


def _lateral_error(sample: Sample, found: Understandings) -> float:
    """Return the error of roll and steer as interpreted, in scales; 1 without these columns."""
    errors = [sample.typical(k, found[k]) / sample.scale[k]
              for k in sample.values if k in LATERAL and sample.scale[k]]  # fmt: skip
    return max(errors, default=1.0)


def _with_odds_against_unknown(
    key: str, found: Understandings, samples: Sequence[Sample]
) -> Understanding:
    """Add the odds of the chosen definition against an unknown definition."""
    u, having = found[key], [s for s in samples if key in s.values]
    others = [c.name for c in having[0].definitions[key] if c is not u.column]
    if not others:
        return u
    odds = _LOG_ODDS_OF_KNOWN
    of_motion = [_motion_error(s, found) for s in having]
    # A mistake that makes the motion of one maneuver wrong may also change this column in other
    # maneuvers. An error of 1 means that too few columns show the motion, not that the motion is
    # wrong.
    is_wrong = any(x >= TOLERANCE and x != 1.0 for x in of_motion)
    for s, off_motion in zip(having, of_motion, strict=True):
        if is_wrong or off_motion >= TOLERANCE:
            # A wrong or unknown motion does not show the definition of this column.
            continue
        rows = s.error(key, u)
        off_by = _motion_error(s, found, size=s.moves)
        allowed = max(CLEARLY * off_by * s.moves(key), MAX_ROUNDING_FLOORS * s.smallest(key, u))
        # Ignore a few bad rows, because they do not indicate another definition.
        errors = np.sort(np.abs(rows))
        error = max(float(errors[int(MOST_ROWS * (len(errors) - 1))]), allowed)
        apart = min(rms(s.expected[n] - s.expected[u.column.name]) for n in others)
        if error > allowed:
            # An error that is noise does not indicate another definition.
            if len(rows) < FEWEST_ROWS or not roughness(rows).is_white:
                odds -= min(
                    _INDEPENDENT_VALUES * float(np.log(error / allowed)), _LOG_ODDS_AGAINST_ODD_ROW
                )
        elif apart > error:
            odds += _INDEPENDENT_VALUES * float(np.log(apart / error))
    return replace(u, none=odds / _LN_10)


def _in_unit(
    unit: str, keys: Iterable[str], found: Understandings, samples: Sequence[Sample]
) -> dict[str, Understanding]:
    """Return interpretations of energies in `unit`, unless their headings name a unit."""
    untold = [key for key in keys if _named_unit(key, samples) is None]
    return {key: replace(found[key], unit=unit) for key in untold}


def _find_offset(found: dict[str, Understanding], samples: Sequence[Sample]) -> None:
    """Find the zero of the potential and the mechanical energy, if it is not at the floor.

    The zero is determined from the potential energy, or from the mechanical minus the kinetic
    energy. An offset of the mechanical energy alone, which is constant, could as well be an error
    of the initial conditions, unless the motion is right.
    """
    leader = next((key for key in ZEROED if key in found), None)
    if leader is None:
        return
    # The kinetic energy shows the unit. Without it, a different zero of the energy hides the unit,
    # and only the variation of the potential energy shows it.
    known = found[leader].unit
    is_hidden = leader == ZEROED[0] and "kinetic_energy" not in found
    units = UNITS["J"] if is_hidden else (known,)
    for unit in sorted(units, key=lambda u: u != known):
        taken = {k: found[k] for k in ZEROED if k in found}
        taken |= _in_unit(unit, taken, found, samples)
        if moved := _with_offset(leader, taken, found, samples):
            found.update(moved)
            return


def _have_the_same_rows(sample: Sample, key: str, other: str) -> bool:
    """True if both columns have values, in the same rows."""
    values = (sample.values.get(key), sample.values.get(other))
    return values[0] is not None and values[1] is not None and len(values[0]) == len(values[1])


def _with_offset(
    key: str,
    taken: Understandings,
    before: Understandings,
    samples: Sequence[Sample],
) -> Understandings:
    """Return the energies with the zero that explains their errors; empty if no zero does."""
    u = taken[key]
    having = [s for s in samples if key in s.values]
    errors = [s.error(key, u) for s in having]
    shows_height = key == ZEROED[0]
    if not shows_height and all(_have_the_same_rows(s, key, "kinetic_energy") for s in having):
        shows_height = True
        kinetic = replace(before["kinetic_energy"], unit=u.unit)
        errors = [
            e - s.error("kinetic_energy", kinetic) for e, s in zip(errors, having, strict=True)
        ]
    # Choose the maneuver in which the error is most constant. Use its first row, because the errors
    # of the motion are smallest there.
    offset = float(min(errors, key=lambda e: float(median(np.abs(e - median(e)))))[0])
    moved = {k: replace(v, offset=offset) for k, v in taken.items()}
    left = _typical(key, moved[key], having)
    off_by = max(
        min(_motion_error(s, before, ZEROED), _speed_error(s, before), _lateral_error(s, before))
        for s in having
    )
    # The zeros of height that programs choose (the height at the start, of the hubs, or of the
    # centre of mass) are far from the floor.
    is_far = abs(offset) / max(s.scale[key] for s in having) >= min(CLEARLY * off_by, 1.0 / CLEARLY)
    is_zero = (
        is_far and (shows_height or off_by < TOLERANCE) and _has_enough_rows(key, left, having)
    )
    # The error that remains with the new zero must be smaller than the variation of the motion.
    is_zero &= all(t <= MEANINGLESS_ERROR * s.varies + sum(s.floor[key])
                   for s, t in zip(having, left, strict=True))  # fmt: skip
    # In each maneuver, the typical error must be clearly smaller with the new zero.
    fits = all(
        a / b >= CLEARLY
        for k, v in moved.items()
        for a, b in zip(_typical(k, before[k], samples), _typical(k, v, samples), strict=True)
    )
    return moved if is_zero and fits else {}
