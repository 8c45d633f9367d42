"""All published numbers of a maneuver: integrated, certified, rounded, interpolated."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, describe_inputs
from heyoka_bike.errors import SingularMotionError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, Drift, Trajectory, evaluator
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.proof.dense import bound_dense, interpolate
from heyoka_bike.reference.proof.enclose import enclosed
from heyoka_bike.reference.proof.motion_rows import tabulate_motion
from heyoka_bike.reference.proof.rows import (
    EVALUATION_BITS,
    constant_columns,
    round_rows,
    rounded_times,
)
from heyoka_bike.reference.proof.sensitivity_rows import differentiate
from heyoka_bike.reference.sensitivities import Sensitivity
from heyoka_bike.reference.values import Dense, RoundedRows, Values
from heyoka_bike.system.jobs import Job, Outcome, Report
from heyoka_bike.system.unfinished import Unfinished

STAGES = ("integrate", "certify", "vary", "motion", "rows")
"""Jobs in the order in which they are best begun: what others wait for, then the longest ones."""

KEPT = (
    Trajectory, Bicycle, Maneuver, Exact, Certificate, Sensitivity, RoundedRows, Values, Dense,
    Drift,
)  # fmt: skip
"""Classes in the results of these jobs, see `unfinished`."""


@dataclass(frozen=True)
class Table:
    """All published numbers of a maneuver.

    Attributes
    ----------
    trajectory : Trajectory
        The candidate.
    certificate : Certificate
        Bounds on the distance of the exact motion from it.
    drift : Drift
    time, time_lo : ndarray, shape (rows,)
        Time of the rows [s] as hi + lo.
    rows : RoundedRows
    dense : Dense
    motion_rows : Values
    motion_dense : Dense
        The whole motion.
    sensitivity : Sensitivity
    seconds : mapping
        Processor time that each job took [s], see `STAGES`.
    """

    trajectory: Trajectory
    certificate: Certificate
    drift: Drift
    time: Array
    time_lo: Array
    rows: RoundedRows
    dense: Dense
    motion_rows: Values
    motion_dense: Dense
    sensitivity: Sensitivity
    seconds: Mapping[str, float] = field(default_factory=dict)

    @property
    def maneuver(self) -> Maneuver:
        return self.trajectory.maneuver

    @property
    def cpu(self) -> float:
        """Processor time that all of it took [s]."""
        return sum(self.seconds.values())


def tabulating(
    bicycle: Bicycle, maneuver: Maneuver, digits: int, name: str, kept: Unfinished
) -> dict[str, Job]:
    """The jobs that make a table, by the stage that each begins with, see `STAGES`.

    Parameters
    ----------
    name
        Name of the maneuver in reports of progress.
    """
    inputs = describe_inputs(bicycle, [maneuver])

    def job(stages: tuple[str, ...], work: Callable[..., Any], *arguments: Any) -> Job:
        place = kept.at(stages, inputs, digits)
        return Job(work, arguments, name, float(maneuver.duration), stages, place)

    run = job(("integrate",), _integrated, bicycle, maneuver, digits)
    certificate = job(("certify",), enclosed, run)
    return {
        "integrate": run,
        "certify": certificate,
        "vary": job(("vary",), _varied, run, certificate),
        "motion": job(("motion",), _moved, run, certificate),
        "rows": job(("rows", "dense"), _rounded, run, certificate),
    }


def tabulated(outcomes: Mapping[str, Outcome]) -> Table:
    """The table, from what the jobs of `tabulating` gave."""
    run = outcomes["integrate"].get()
    rows, dense, drift = outcomes["rows"].get()
    motion_rows, motion_dense = outcomes["motion"].get()
    time, time_lo = rounded_times(run.maneuver)
    return Table(
        trajectory=run,
        certificate=outcomes["certify"].get(),
        drift=drift,
        time=time,
        time_lo=time_lo,
        rows=rows,
        dense=dense,
        motion_rows=motion_rows,
        motion_dense=motion_dense,
        sensitivity=outcomes["vary"].get(),
        seconds={stage: x.seconds for stage, x in outcomes.items()},
    )


def _integrated(bicycle: Bicycle, maneuver: Maneuver, digits: int, report: Report) -> Trajectory:
    try:
        return integrate(
            bicycle, maneuver, Precision.of(digits), progress=lambda t: report("integrate", t)
        )
    except SingularMotionError as e:
        raise SingularMotionError(
            f"{maneuver.name}: {e}; its duration is {float(maneuver.duration):g} s, nothing "
            "was written, expected a shorter duration",
            e.time,
        ) from None


def _rounded(
    run: Trajectory, certificate: Certificate, report: Report
) -> tuple[RoundedRows, Dense, Drift]:
    rows = round_rows(run, certificate, lambda t: report("rows", t))
    at = evaluator(run, run.bits + EVALUATION_BITS)
    constant = constant_columns(run)
    scales = {name: rows.scale(name) for name in rows.hi}
    dense = interpolate(at, scales, constant, lambda t: report("dense", t))
    return rows, bound_dense(run, certificate, dense, constant), at.drift()


def _moved(run: Trajectory, certificate: Certificate, report: Report) -> tuple[Values, Dense]:
    return tabulate_motion(run, certificate, lambda t: report("motion", t))


def _varied(run: Trajectory, certificate: Certificate, report: Report) -> Sensitivity:
    return differentiate(run, certificate, lambda t: report("vary", t))
