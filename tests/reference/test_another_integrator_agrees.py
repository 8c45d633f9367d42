"""A different integrator finds the published motion, within the proved bounds of both.

`oracles.taylor` has its own series, step sizes and precision. It uses the regular form of the
equations, while the published candidate uses the few-product form. The distance of each from the
exact motion is certified, so their enclosures of every column must overlap. The enclosure of the
other integrator is far narrower than the published hi + lo, so it decides every published digit
independently.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import flint
import pytest

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Certificate, Trajectory, evaluator
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.rounding import Enclosure
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.reference.proof.enclose import enclose
from heyoka_bike.reference.proof.rows import exact_columns
from oracles import taylor

SHORT, WHOLE = 3, 10
"""Seconds of a maneuver that are integrated."""

NAMES = [c.name for c in COLUMNS]

Enclosures = Mapping[str, flint.arb]


@dataclass(frozen=True)
class Certified:
    """A motion with a bound on its distance from the exact motion."""

    run: Trajectory
    certificate: Certificate

    def columns(self, times: Sequence[Fraction]) -> list[Enclosures]:
        """Return enclosures of every column of the exact motion."""
        at = evaluator(self.run, self.run.grid + 64, self.certificate)
        with at.balls.precision():
            return [at.columns(t) for t in times]

    def cut(self, pieces: int) -> Certified:
        """Return the first segments, as the motion of a shorter maneuver."""
        run, breaks = self.run, self.run.breaks[: pieces + 1]
        return Certified(
            replace(
                run,
                maneuver=replace(run.maneuver, duration=breaks[-1]),
                breaks=breaks,
                pieces=run.pieces[:pieces],
            ),
            replace(self.certificate, pieces=self.certificate.pieces[:pieces]),
        )

    def middles(self) -> list[Fraction]:
        """Return a time in the middle of each segment."""
        return [(a + b) / 2 for a, b in pairwise(self.run.breaks)]


@dataclass(frozen=True)
class Case:
    """One maneuver from the other integrator and as published."""

    number: int
    other: Certified
    published: Certified
    values: ReferenceManeuver

    @property
    def rows(self) -> range:
        """One row per second."""
        return range(0, self.other.run.maneuver.rows, 100)

    @property
    def times(self) -> list[Fraction]:
        return [self.other.run.maneuver.time(i) for i in self.rows]


@pytest.fixture(
    scope="module",
    params=[
        pytest.param((2, SHORT), marks=pytest.mark.proof),
        *(pytest.param((n, WHOLE), marks=pytest.mark.slow) for n in (1, 2, 3)),
    ],
    ids=lambda case: f"{case[0]}-{case[1]} s",
)
def case(
    request: pytest.FixtureRequest,
    bicycle: Bicycle,
    maneuvers: tuple[Maneuver, ...],
    candidate: tuple[Trajectory, ...],
    reference: Reference,
    folder: Path,
) -> Case:
    number, seconds = request.param
    run = taylor.integrate(bicycle, replace(maneuvers[number - 1], duration=Fraction(seconds)))
    return Case(
        number,
        Certified(run, enclose(run)),
        Certified(candidate[number - 1], published_bound(folder, candidate[number - 1], number)),
        reference[number],
    )


def published_bound(folder: Path, run: Trajectory, number: int) -> Certificate:
    """Return the bound of certificate.json, the same for all states and times."""
    entry = json.loads((folder / "certificate.json").read_text())["maneuvers"][number - 1]
    bounds = (Fraction(entry["bound"]),) * len(run.states)
    return Certificate(run.states, (bounds,) * run.steps, bounds)


def disagreements(
    ours: Certified, published: Certified, times: Sequence[Fraction]
) -> list[tuple[str, Fraction]]:
    """Return columns and times at which two enclosures of one number do not overlap."""
    found = []
    for t, x, y in zip(times, ours.columns(times), published.columns(times), strict=True):
        assert x.keys() == y.keys() == set(NAMES)
        with flint.ctx.workprec(1000):
            # A comparison of balls is true only if it is certain. It is false if one of the balls
            # is NaN.
            found += [
                (name, t)
                for name in NAMES
                if not abs(x[name].mid() - y[name].mid()) <= x[name].rad() + y[name].rad()
            ]
    return found


def wrongly_rounded(case: Case, ours: Certified) -> list[tuple[str, int]]:
    """Return entries of the published rows to which our enclosures do not round."""
    first = exact_columns(ours.run.bicycle, ours.run.maneuver)
    found = []
    for i, row in zip(case.rows, ours.columns(case.times), strict=True):
        for name in NAMES:
            x = Enclosure.of(row[name])
            hi, lo = (float(part[name][i]) for part in (case.values.rows.hi, case.values.rows.lo))
            right = x.binary64() == hi and x.minus(hi).binary64() == lo
            if i == 0 and name in first and not right:
                # The exact value is a terminating decimal. No enclosure can decide how to round it,
                # so hi and lo are compared with the exact value.
                exact = first[name]
                right = x.low <= exact <= x.high
                right = right and hi == float(exact) and lo == float(exact - Fraction(hi))
            if not right:
                found.append((name, i))
    return found


def moved(run: Trajectory, first: int, state: int, by: Fraction) -> Trajectory:
    """Return the run with a constant added to one state variable from a segment on."""
    offset = round(by * 2**run.grid)

    def piece(rows: tuple[tuple[int, ...], ...]) -> tuple[tuple[int, ...], ...]:
        return tuple(
            (row[0] + offset, *row[1:]) if j == state else row for j, row in enumerate(rows)
        )

    return replace(run, pieces=(*run.pieces[:first], *map(piece, run.pieces[first:])))


def test_it_shares_no_step_with_the_published_run(case: Case) -> None:
    other, published = case.other.run, case.published.run
    assert other.is_regular
    assert not published.is_regular
    assert other.order != published.order
    shared = set(other.breaks[1:-1]) & set(published.breaks[1:-1])
    assert len(shared) < len(published.breaks) / 10


def test_its_own_bound_is_small(case: Case) -> None:
    assert case.other.certificate.worst < Fraction(1, 10**40)


def test_every_column_agrees_within_both_bounds(case: Case) -> None:
    times = case.times
    assert times == [Fraction(i) for i in range(len(case.rows))]
    assert disagreements(case.other, case.published, times) == []
    # The enclosures must be narrow. Very wide enclosures would overlap in any case and prove
    # nothing.
    for row in case.other.columns(times):
        for name, x in row.items():
            scale = float(abs(case.values.rows.hi[name]).max())
            assert x.rad() < 1e-40 * max(1.0, scale), name


def test_it_decides_every_published_value_anew(case: Case) -> None:
    assert wrongly_rounded(case, case.other) == []


def test_agreement_in_the_middle_of_every_piece(case: Case) -> None:
    times = [t for t in case.other.middles() if t <= case.other.run.maneuver.duration]
    assert disagreements(case.other, case.published, times) == []


@pytest.mark.parametrize("state", range(7))
def test_a_state_off_by_1e_20_from_half_way_on_is_noticed(case: Case, state: int) -> None:
    run = case.other.run
    half = run.steps // 2
    wrong = replace(case.other, run=moved(run, half, state, Fraction(1, 10**20)))
    late = {t for t in case.times if t >= run.breaks[half]}
    assert {t for _, t in disagreements(wrong, case.published, case.times)} == late
    assert {case.times[i // 100] for _, i in wrongly_rounded(case, wrong)} == late


def test_a_state_off_by_1e_20_has_a_bound_that_says_so(case: Case) -> None:
    cut = case.other.cut(6)
    wrong = moved(cut.run, 3, 0, Fraction(1, 10**20))
    bound = enclose(wrong)
    assert Fraction(1, 10**20) < bound.worst < Fraction(1, 10**17)
    # The bound of the wrong run allows for the error of this run. So within this bound it does not
    # contradict the published run.
    assert disagreements(Certified(wrong, bound), case.published, cut.middles()) == []


def test_a_series_cut_at_too_low_an_order_is_noticed(case: Case) -> None:
    cut = case.other.cut(3)
    pieces = tuple(tuple(row[:30] for row in piece) for piece in cut.run.pieces)
    wrong = replace(cut.run, pieces=pieces)
    times = cut.middles()
    # In the middle of a segment the omitted terms are smaller than at its end, by a factor of 2^30,
    # but still visible.
    found = disagreements(replace(cut, run=wrong), case.published, times)
    assert {t for _, t in found} == set(times)
    assert enclose(wrong).worst > Fraction(1, 10**40)


def test_another_bicycle_is_noticed(case: Case) -> None:
    maneuver = replace(case.other.run.maneuver, duration=Fraction(1, 4))
    bicycle = case.other.run.bicycle
    heavier = bicycle.replace(g=Exact(bicycle["g"].rational * (1 + Fraction(1, 10**30))))
    run = taylor.integrate(heavier, maneuver)
    wrong = Certified(run, enclose(run))
    assert wrong.certificate.worst < Fraction(1, 10**40)
    found = disagreements(wrong, case.published, [Fraction(1, 8), Fraction(1, 4)])
    assert {"roll_angle", "steer_angle", "potential_energy"} <= {name for name, _ in found}
