"""Everything published about one maneuver: integrated, certified, rounded, made dense."""

import time
from dataclasses import dataclass, replace

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import SingularMotionError, UndecidedError
from heyoka_bike.motion.evaluator import Drift, evaluator
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.proof.dense import interpolate
from heyoka_bike.reference.proof.dense_bound import bound_dense
from heyoka_bike.reference.proof.enclose import enclose
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
from heyoka_bike.system.parallel import Report

_ATTEMPTS = 4
_MORE_DIGITS = 20


@dataclass(frozen=True)
class Table:
    """Everything published about one maneuver.

    Attributes
    ----------
    trajectory : Trajectory
        The candidate.
    certificate : Certificate
        How far the exact motion may be from it.
    drift : Drift
    time, time_lo : ndarray, shape (rows,)
        Time of the rows [s] as hi + lo.
    rows : RoundedRows
    dense : Dense
    motion_rows : Values
    motion_dense : Dense
        The whole motion.
    sensitivity : Sensitivity
    cpu : float
        Processor time that it took [s].
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
    cpu: float = 0.0

    @property
    def maneuver(self) -> Maneuver:
        return self.trajectory.maneuver


def tabulate(bicycle: Bicycle, maneuver: Maneuver, digits: int, report: Report) -> Table:
    """Integrate a maneuver at `digits` decimal digits, and prove and round what is published.

    An entry whose rounding is not decided makes it start again with 20 digits more, three times.

    Raises
    ------
    SingularMotionError
        The motion meets a singularity before its end.
    NotCertifiedError
        The candidate cannot be certified.
    UndecidedError
        A rounding that stays undecided, named.
    """
    start = time.process_time()
    for attempt in range(_ATTEMPTS):
        try:
            table = _tabulate(bicycle, maneuver, digits + attempt * _MORE_DIGITS, report)
            return replace(table, cpu=time.process_time() - start)
        except UndecidedError:
            if attempt == _ATTEMPTS - 1:
                raise
        except SingularMotionError as e:
            raise SingularMotionError(
                f"{maneuver.name}: {e}; its duration is {float(maneuver.duration):g} s, nothing "
                "was written, expected a shorter duration",
                e.time,
            ) from None
    raise AssertionError("unreachable")


def _tabulate(bicycle: Bicycle, maneuver: Maneuver, digits: int, report: Report) -> Table:
    run = integrate(
        bicycle, maneuver, Precision.of(digits), progress=lambda t: report("integrate", t)
    )
    certificate = enclose(run, lambda t: report("certify", t))
    rows = round_rows(run, certificate, lambda t: report("rows", t))
    at = evaluator(run, run.bits + EVALUATION_BITS)
    constant = constant_columns(run)
    scales = {name: rows.scale(name) for name in rows.hi}
    dense = interpolate(at, scales, constant, lambda t: report("dense", t))
    dense = bound_dense(run, certificate, dense, constant)
    motion_rows, motion_dense = tabulate_motion(run, certificate, lambda t: report("motion", t))
    time, time_lo = rounded_times(maneuver)
    return Table(
        trajectory=run,
        certificate=certificate,
        drift=at.drift(),
        time=time,
        time_lo=time_lo,
        rows=rows,
        dense=dense,
        motion_rows=motion_rows,
        motion_dense=motion_dense,
        sensitivity=differentiate(run, certificate, lambda t: report("vary", t)),
    )
