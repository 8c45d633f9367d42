"""Compute the published numbers of a maneuver: rows, dense output, whole motion, derivatives.

The numbers come from the candidate, which is the trajectory that heyoka integrated. `generate` and
`certify` run the same jobs. If there are published numbers, their dense output replaces a new one,
and every computed number is compared with the published one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Drift, Trajectory, evaluator
from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.reference import hdf5, layout
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.proof.dense import (
    bound_columns,
    interpolate,
    scale_of_dense,
    tabulate_motion,
)
from heyoka_bike.reference.proof.enclose import enclosed
from heyoka_bike.reference.proof.rows import constant_columns, round_rows, rounded_times
from heyoka_bike.reference.proof.sensitivity_rows import differentiate
from heyoka_bike.reference.values import Dense, RoundedRows, Sensitivity, Values
from heyoka_bike.system.jobs import Job, OnStage, Outcome


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
    rows : RoundedRows
    dense : Dense
    motion_rows : Values
    motion_dense : Dense
        The whole motion.
    sensitivity : Sensitivity
    seconds : mapping
        Processor time that each job took [s], by its first stage.
    """

    trajectory: Trajectory
    certificate: Certificate
    drift: Drift
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
        """Processor time of all jobs [s]."""
        return sum(self.seconds.values())

    @property
    def numbers(self) -> dict[str, dict[str, Any]]:
        """Arrays to store in the group of the maneuver, for each HDF5 file."""
        times = rounded_times(self.maneuver)
        return {
            layout.HDF5: numbers_of_table(times, self.rows, self.dense),
            layout.MOTION: numbers_of_table(times, self.motion_rows, self.motion_dense),
            layout.SENSITIVITIES: numbers_of_derivatives(self.sensitivity),
        }


STAGES = ("certify", "rows", "vary", "motion")
"""The jobs in the best order to start them: first those that others wait for, then the one that
shows whether the maneuver needs a new run with more digits, then the longest ones."""


def table_jobs(
    run: Trajectory | Job, job: Callable[..., Job], published: Mapping[str, Any]
) -> dict[str, Job]:
    """Return the jobs that make a table from a candidate, by first stage (see `STAGES`).

    Parameters
    ----------
    job
        Makes a job from a function, its arguments and its stages.
    published
        Numbers by stage that the results must equal; without them new ones are made.
    """
    bound = job(enclosed, (run,), stages=("certify",))
    works = (
        (compute_derivatives, ("vary",)),
        (compute_motion, ("motion",)),
        (compute_rows, ("rows", "dense")),
    )
    return {"certify": bound} | {
        stages[0]: job(work, (run, bound, published.get(stages[0])), stages=stages)
        for work, stages in works
    }


def assemble_table(run: Trajectory, outcomes: Mapping[str, Outcome]) -> Table:
    """Assemble the table from the outcomes of `table_jobs`, with the times of all outcomes."""
    rows, dense, drift = outcomes["rows"].get()
    motion_rows, motion_dense = outcomes["motion"].get()
    return Table(
        trajectory=run,
        certificate=outcomes["certify"].get(),
        drift=drift,
        rows=rows,
        dense=dense,
        motion_rows=motion_rows,
        motion_dense=motion_dense,
        sensitivity=outcomes["vary"].get(),
        seconds={stage: x.seconds for stage, x in outcomes.items()},
    )


def compute_rows(
    run: Trajectory,
    certificate: Certificate,
    published: ReferenceManeuver | None,
    report: OnStage,
) -> tuple[RoundedRows, Dense, Drift]:
    """Compute rows and dense output of all columns, and the drift of the conserved quantities."""
    rows = round_rows(run, certificate, partial(report, "rows"))
    at = evaluator(run)
    constant = constant_columns(run)
    if published is None:
        scales = {name: scale_of_dense(rows, name) for name in rows.hi}
        progress = partial(report, "dense")

        def near(t: flint.arb, about: Fraction) -> Mapping[str, flint.arb]:
            return at.columns(t, run.piece_at(about))

        dense = interpolate(near, run.breaks[-1], at.balls, scales, constant, progress)
    else:
        dense = published.dense
    dense = bound_columns(run, certificate, dense, constant)
    _compare_tables(run, rows, dense, published)
    return rows, dense, at.drift()


def compute_motion(
    run: Trajectory,
    certificate: Certificate,
    published: ReferenceManeuver | None,
    report: OnStage,
) -> tuple[Values, Dense]:
    """Compute rows and dense output of the whole motion."""
    dense = None if published is None else published.dense
    found = tabulate_motion(run, certificate, dense, partial(report, "motion"))
    _compare_tables(run, *found, published)
    return found


def compute_derivatives(
    run: Trajectory, certificate: Certificate, published: Sensitivity | None, report: OnStage
) -> Sensitivity:
    """Compute the derivatives of all columns with respect to the unknowns."""
    found = differentiate(run, certificate, partial(report, "vary"))
    if published is not None:
        stored = numbers_of_derivatives(published)
        _compare(run, numbers_of_derivatives(found), stored, "derivatives")
    return found


def numbers_of_table(times: Double, rows: Values, dense: Dense) -> dict[str, Any]:
    """Return rows and dense output as arrays, by the names of their HDF5 datasets."""
    return {
        **dict(zip(("time", "time_lo"), times, strict=True)),
        **_tagged(rows.hi, rows.lo, rows.bound),
        **{name + hdf5.UNDECIDED: x for name, x in rows.undecided.items()},
        "dense": {"breaks": dense.breaks, **_tagged(dense.hi, dense.lo, dense.bound)},
    }


def numbers_of_derivatives(x: Sensitivity) -> dict[str, Any]:
    """Return derivatives as arrays, by the names of their HDF5 datasets."""
    return {
        "breaks": x.breaks,
        **_tagged(x.coefficients, {}, x.bound),
        "rows": {"time": x.time, **_tagged(x.values, {}, x.values_bound)},
    }


def _tagged(*parts: Mapping[str, Array]) -> dict[str, Any]:
    """Return values, low parts and bounds by the names of their datasets."""
    pairs = zip(("", hdf5.LOW, hdf5.BOUND), parts, strict=True)
    return {name + tag: x for tag, part in pairs for name, x in part.items()}


def _compare_tables(
    run: Trajectory, rows: Values, dense: Dense, x: ReferenceManeuver | None
) -> None:
    """Compare rows and dense output with the published ones, if published ones are given."""
    if x is not None:
        stored = numbers_of_table((x.time, x.time_lo), x.rows, x.dense)
        _compare(run, numbers_of_table(rounded_times(run.maneuver), rows, dense), stored)


def _compare(
    run: Trajectory, proved: Mapping[str, Any], published: Mapping[str, Any], inside: str = ""
) -> None:
    """Check that published numbers other than NaN equal the proved ones; bounds must cover them.

    Both arguments map names of groups to arrays by names of datasets; `inside` says what the
    indices count.
    """
    for name in published.keys() - proved.keys():
        raise NotCertifiedError(
            f"{run.maneuver.name}: {_in_words(name, inside)}: found in the file, but the proof has "
            "no such values"
        )
    for name, right in proved.items():
        if isinstance(right, dict):
            _compare(run, right, published[name], f"{name} of {inside}" if inside else name)
            continue
        where, found = f"{run.maneuver.name}: {_in_words(name, inside)}", published.get(name)
        if found is None:
            raise NotCertifiedError(f"{where}: missing in the file")
        if found.dtype != right.dtype or found.shape != right.shape:
            raise NotCertifiedError(
                f"{where}: found {found.shape} of {found.dtype}, expected {right.shape} of "
                f"{right.dtype}"
            )
        found, right = np.ascontiguousarray(found), np.ascontiguousarray(right)
        kept = found.view("i8") == right.view("i8")
        if name.endswith(hdf5.BOUND):
            kept = (found >= right) & np.isfinite(found)
        kept |= np.isnan(found) & np.isnan(right)
        if not kept.all():
            place = np.unravel_index(int(np.argmin(kept)), kept.shape)
            # Messages count pieces from 1, and rows from 0.
            at = ", ".join(str(i + (inside == "dense")) for i in place)
            raise NotCertifiedError(
                f"{where} {at}: published {float(found[place])!r}, proved {float(right[place])!r}"
            )


def _in_words(name: str, inside: str) -> str:
    """Return the name of a dataset in words, to be followed by an index."""
    stem = name.removesuffix(hdf5.LOW).removesuffix(hdf5.BOUND)
    if name.endswith(hdf5.UNDECIDED):
        return f"{name}, entry"
    if inside == "dense":
        return f"{inside} {stem}, piece"
    if not inside:
        return f"{name}, row"
    if name in ("breaks", "time"):
        return f"{name} of the derivatives, row"
    bound = "bound of the " if name.endswith(hdf5.BOUND) else ""
    return f"{bound}{inside} of {stem}, row"
