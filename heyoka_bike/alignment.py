"""Which maneuver a file holds, and which of its rows lie within the run of the reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.chebyshev import Array
from heyoka_bike.columns import DEFINITIONS
from heyoka_bike.errors import InputError, NothingScoredError
from heyoka_bike.findings import Finding, Severity
from heyoka_bike.reference import Reference, ReferenceManeuver
from heyoka_bike.results import Quantum, Results, Rows
from heyoka_bike.units import UNITS, factor

MOST_SAMPLED = 4001
"""Rows enough to tell columns, units and maneuvers apart."""

# A column farther from the reference than half its scale says nothing about what it is.
HALF = 0.5
# Beyond this a product of two values overflows on the way; no program means it.
_LARGEST = 1e150


@dataclass(frozen=True, eq=False, slots=True)
class Part:
    """Rows of one maneuver within the run of its reference.

    Attributes
    ----------
    number
        Of the maneuver, from 1.
    reference : ReferenceManeuver
    time, time_lo : ndarray, shape (n,)
        [s], ascending.
    values, lo : mapping of str to ndarray, shape (n,)
        As written; NaN where there is no usable number.
    quantum : mapping of str to Quantum
    """

    number: int
    reference: ReferenceManeuver
    time: Array
    time_lo: Array
    values: Mapping[str, Array]
    lo: Mapping[str, Array]
    quantum: Mapping[str, Quantum]

    def sample(self) -> NDArray[np.intp]:
        """Indices of at most `MOST_SAMPLED` rows, evenly spread."""
        n = len(self.time)
        if n <= MOST_SAMPLED:
            return np.arange(n)
        return np.linspace(0, n - 1, MOST_SAMPLED).astype(np.intp)


@dataclass(frozen=True, eq=False, slots=True)
class Alignment:
    """A result file laid beside the reference; see `report.FileInfo` for the first fields."""

    path: str
    format: str
    rows: int
    t_start: float
    t_end: float
    significant_digits: int | None
    parts: tuple[Part, ...]
    findings: tuple[Finding, ...]


def align(results: Results, reference: Reference) -> Alignment:
    """Lay a result file beside the reference.

    Raises
    ------
    InputError
        It holds a maneuver that the reference does not have, or one twice.
    NothingScoredError
        None of its rows can be compared, or its maneuver cannot be recognised.
    """
    findings = list(results.findings)
    parts: list[Part] = []
    for rows in results.maneuvers:
        number = rows.maneuver
        if number is None:
            number = _recognise(results.path, rows, reference)
            findings.append(
                Finding(
                    "maneuver_recognised",
                    f"the columns are those of maneuver {number}, recognised by their values",
                    evidence={"maneuver": number},
                )
            )
        if number not in reference:
            raise InputError(
                f"found maneuver {number}, expected 1 to {len(reference)}", file=results.path
            )
        if any(part.number == number for part in parts):
            raise InputError(f"found maneuver {number} twice", file=results.path)
        part, outside = _within(rows, number, reference[number])
        findings += [f for f in outside if f not in findings]
        if len(part.time):
            parts.append(part)
    if not any(np.isfinite(v).any() for part in parts for v in part.values.values()):
        raise NothingScoredError(_why_nothing(results, reference, bool(parts)))
    first = [rows.time[0] for rows in results.maneuvers if len(rows.time)]
    last = [rows.time[-1] for rows in results.maneuvers if len(rows.time)]
    return Alignment(
        path=results.path,
        format=results.format,
        rows=max(len(rows.time) for rows in results.maneuvers),
        t_start=float(min(first)),
        t_end=float(max(last)),
        significant_digits=results.significant_digits,
        parts=tuple(sorted(parts, key=lambda p: p.number)),
        findings=tuple(findings),
    )


def merge(alignments: Sequence[Alignment]) -> Alignment:
    """Files of different maneuvers of one run as one."""
    digits = [a.significant_digits for a in alignments if a.significant_digits is not None]
    several = len(alignments) > 1
    return Alignment(
        path=", ".join(a.path for a in alignments),
        format=", ".join(dict.fromkeys(a.format for a in alignments)),
        rows=sum(a.rows for a in alignments),
        t_start=min(a.t_start for a in alignments),
        t_end=max(a.t_end for a in alignments),
        significant_digits=min(digits) if digits else None,
        parts=tuple(sorted((p for a in alignments for p in a.parts), key=lambda p: p.number)),
        findings=tuple(
            Finding(f.code, f"{a.path}: {f.message}", f.severity, f.evidence) if several else f
            for a in alignments
            for f in a.findings
        ),
    )


def _recognise(path: str, rows: Rows, reference: Reference) -> int:
    """Number of the maneuver that the values are nearest to."""
    distance = {}
    for number in reference:
        part, _ = _within(rows, number, reference[number])
        distance[number] = _distance(part) if len(part.time) else 1.0
    nearest, *others = sorted(distance, key=distance.__getitem__)
    # The same factor that tells definitions apart.
    if distance[nearest] >= HALF or (others and distance[others[0]] < 2 * distance[nearest]):
        raise NothingScoredError(
            f"{path}: found columns that fit no maneuver clearly (relative distances "
            + ", ".join(f"{n}: {d:.2g}" for n, d in sorted(distance.items()))
            + "), expected those of one; say which with --maneuver N"
        )
    return nearest


def _distance(part: Part) -> float:
    """Geometric mean over the columns of their distance from the maneuver, in scales."""
    pick = part.sample()
    names = [key for key in DEFINITIONS if key in part.values]
    expected = part.reference.approximate(part.time[pick], names)
    logs = []
    for key in names:
        values = part.values[key][pick]
        good = np.isfinite(values)
        scale = float(np.max(np.abs(part.reference.rows[key])))
        if not good.any() or not scale:
            continue
        nearest = min(
            float(np.median(np.abs(sign * factor(unit)[0] * values[good] - expected[key][good])))
            for unit in UNITS[DEFINITIONS[key][0].unit]
            for sign in (1, -1)
        )
        # Nothing is nearer than binary64 can tell, or farther than not at all.
        logs.append(np.log(np.clip(nearest / scale, np.finfo(np.float64).eps, 1.0)))
    return float(np.exp(np.mean(logs))) if logs else 1.0


def _within(
    rows: Rows, number: int, reference: ReferenceManeuver
) -> tuple[Part, tuple[Finding, ...]]:
    """The rows within the run; nothing is extrapolated."""
    end = reference.duration
    end_hi = float(end)
    end_lo = float(end - Fraction(end_hi))
    hi, lo = rows.time, rows.time_lo
    early = (hi < 0) | ((hi == 0) & (lo < 0))
    late = (hi > end_hi) | ((hi == end_hi) & (lo > end_lo))
    keep = ~(early | late)
    findings: tuple[Finding, ...] = ()
    if not keep.all():
        left_out = hi[~keep]
        count = len(left_out)
        findings = (
            Finding(
                "time_outside",
                f"{count} row{'s' if count > 1 else ''} with times from {left_out.min():.6g} to "
                f"{left_out.max():.6g} s left out: the reference covers 0 to {end_hi:g} s and "
                "nothing is extrapolated",
                Severity.WARNING,
                {
                    "rows": count,
                    "t_first": float(left_out.min()),
                    "t_last": float(left_out.max()),
                },
            ),
        )

    def kept_of(array: Array) -> Array:
        # A long file is not copied for nothing.
        return array if keep.all() else array[keep]

    values = {}
    for key, written in rows.values.items():
        kept = kept_of(written)
        usable = np.abs(kept) <= _LARGEST
        values[key] = kept if usable.all() else np.where(usable, kept, np.nan)
    part = Part(
        number=number,
        reference=reference,
        time=kept_of(hi),
        time_lo=kept_of(lo),
        values=values,
        lo={key: kept_of(rest) for key, rest in rows.lo.items()},
        quantum=rows.quantum,
    )
    return part, findings


def _why_nothing(results: Results, reference: Reference, has_rows: bool) -> str:
    if has_rows:
        return f"{results.path}: found no finite value within the run, expected at least one"
    end = max(float(reference[n].duration) for n in reference)
    times = np.concatenate([rows.time for rows in results.maneuvers])
    if not len(times):
        return f"{results.path}: found no rows, expected at least one"
    low, high = float(times.min()), float(times.max())
    hint = "; are they in milliseconds?" if low >= 0 and 100 * end <= high <= 1000 * end else ""
    return (
        f"{results.path}: found times from {low:.6g} to {high:.6g} s, expected some within 0 to "
        f"{end:g} s{hint}"
    )
