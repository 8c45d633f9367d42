"""Integrating a reference set again, and counting the digits in which it comes out the same.

Every column is compared at every row with the finest published number of it: the text of 50 digits,
or hi + lo where there is no such text, and with the trajectory in candidate.h5, which has some 65.

How many digits must agree follows from the certificate, which bounds what a run of p bits is off
by some B. Truncation and roundoff of a Taylor integration are proportional to 2^-p, and what the
motion makes of them does not depend on p, so a run of q bits is expected within 2^(p - q) B. This
is no proof, only the published run is certified. States of that uncertainty are evaluated as balls;
each must overlap the published number and its bound.
"""

import time
from dataclasses import replace
from fractions import Fraction
from math import inf, log10

import flint

from heyoka_bike.motion.integrate import integrate, require_heyoka
from heyoka_bike.motion.trajectory import Certificate, Trajectory, evaluator, row_times
from heyoka_bike.numbers.arithmetic import exact_ball
from heyoka_bike.numbers.precision import MAX_DIGITS, Precision
from heyoka_bike.reference.layout import HDF5
from heyoka_bike.reference.verification.agreement import half_unit, scale, stored_ball
from heyoka_bike.reference.verification.checks import Check, Tally
from heyoka_bike.reference.verification.outcome import Agreement, StoredManeuver, Verification
from heyoka_bike.system.jobs import Report
from heyoka_bike.system.parallel import Progress, side_by_side

QUICK: tuple[str | int, ...] = ("binary128", 40)
"""Precisions of a quick rerun."""
MORE_DIGITS = 20
"""By which the second of a full rerun is longer than the set's own."""

_GUARD_BITS = 64  # of evaluation, beyond the longer of the two runs


def run_again(
    found: Verification, *, is_quick: bool = False, progress: Progress | None = None
) -> Verification:
    """Integrate the maneuvers of a whole set again, at two precisions each, side by side.

    Parameters
    ----------
    found
        A set that is not whole gets a check that says so instead.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """
    if not found.passed:
        message = "not made: the set has to be whole"
        unmade = Check("rerun", None, "", message, {"values": 0})
        return replace(found, checks=(*found.checks, unmade))
    require_heyoka()
    jobs = [
        (part, precision)
        for part in found.parts
        for precision in precisions(part.run, is_quick=is_quick)
    ]
    motions = [
        (f"{part.maneuver.name}, {precision.name}", float(part.maneuver.duration))
        for part, precision in jobs
    ]
    agreements = tuple(side_by_side(agreement, jobs, motions, progress))
    checks = (*found.checks, *(a.check() for a in agreements))
    return replace(found, checks=checks, agreements=agreements)


def precisions(run: Trajectory, *, is_quick: bool) -> tuple[Precision, ...]:
    """The precisions in which a maneuver is integrated again."""
    if is_quick:
        return tuple(map(Precision.of, QUICK))
    digits = int(run.precision.split()[0])
    more = min(digits + MORE_DIGITS, MAX_DIGITS)
    return Precision.of(digits), Precision.of(more)


def agreement(part: StoredManeuver, precision: Precision, report: Report) -> Agreement:
    """Integrate a maneuver and compare it with what is published."""
    run = part.run
    start = time.perf_counter()
    again = integrate(
        run.bicycle, run.maneuver, precision, progress=lambda t: report("integrate", t)
    )
    seconds = time.perf_counter() - start
    bits = max(run.bits, again.bits) + _GUARD_BITS
    at_run, at_again = evaluator(run, bits), evaluator(again, bits)
    around = evaluator(again, bits, _may_be_off(part.certificate, run, again))
    names = part.reference.columns
    off = {kind: dict.fromkeys(names, 0.0) for kind in ("published", "candidate", "allowed")}
    tally = Tally("rerun", HDF5)
    with at_run.balls.precision():
        for i, t in enumerate(row_times(run.maneuver)):
            found, ball, candidate = at_again.columns(t), around.columns(t), at_run.columns(t)
            for name in names:
                published = _published(part, name, i)
                _widen(off["allowed"], name, ball[name].rad() + published.rad())
                for kind, number in (("published", published), ("candidate", candidate[name])):
                    apart = found[name] - number
                    _widen(off[kind], name, apart.mid())
                    if not tally.counts(ball[name].is_finite() and ball[name].overlaps(number)):
                        tally.fail(
                            f"{part.at(name, i)}: {precision.name}: {float(apart.mid()):.2g} "
                            f"from the {kind} value, expected at most "
                            f"{float(ball[name].rad() + number.rad()):.2g}"
                        )
            report("compare", float(t))
    most = min(run.bits, again.bits) * log10(2)
    scales = {name: scale(part.reference, name) for name in names}
    digits = {
        kind: {name: min(_digits(x, scales[name]), most) for name, x in worst.items()}
        for kind, worst in off.items()
    }
    return Agreement(
        maneuver=part.maneuver.name, precision=precision.name, published=digits["published"],
        candidate=digits["candidate"], promised=digits["allowed"], tally=tally,
        steps=again.steps, seconds=seconds,
    )  # fmt: skip


def _may_be_off(certificate: Certificate, run: Trajectory, again: Trajectory) -> Certificate:
    """Return the expected bound on the distance of a run of other precision from the published one.

    The bound over the whole time, for all states alike: the other run has steps, and maybe states,
    of its own.
    """
    worst = certificate.worst * (1 + Fraction(2) ** (run.bits - again.bits))
    bounds = (worst,) * len(again.states)
    return Certificate(again.states, (bounds,) * again.steps, bounds)


def _published(part: StoredManeuver, name: str, row: int) -> flint.arb:
    """The finest published number of a value, with its bound."""
    text = part.long_text
    if text is None or (part.number, name) not in text.columns:
        return stored_ball(part.reference.rows, name, row)
    token = text.columns[part.number, name][row]
    return flint.arb(exact_ball(Fraction(token)), exact_ball(half_unit(token)).upper())


def _widen(worst: dict[str, float], name: str, x: flint.arb) -> None:
    worst[name] = max(worst[name], abs(float(x)))


def _digits(error: float, scale: float) -> float:
    return -log10(error / scale) if error else inf
