"""The certified bound of each maneuver over time, and beside it the true error of the candidate.

The bound is proved again from candidate.h5, as ``heyoka-bike certify`` does: certificate.json says
only how large it ever is. The true error is the candidate minus a run of more digits, which is as
good as exact beside it; that run needs heyoka, and without it only the bound is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

import flint
import numpy as np

from heyoka_bike.errors import MissingPackageError
from heyoka_bike.motion.heyoka_adapter import require_heyoka
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory, row_times
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.precision import MAX_DIGITS, Precision
from heyoka_bike.reference.load import Reference
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.proof.enclose import enclosed
from heyoka_bike.system.console import progress_bars
from heyoka_bike.system.jobs import OnStage
from heyoka_bike.system.parallel import side_by_side
from heyoka_bike.workbench.style import BLACK, BLUE, VERMILLION, WIDTH, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MORE_DIGITS = 20
"""By which the run that counts as exact is longer than the candidate's."""

_ACROSS, _HEIGHT = 3, 3.1  # panels of a row, and its height [inch]
# As far below the smallest bound errors are shown.
_BELOW = 1e-3
_SHARES = {"certify": 0.7, "integrate": 0.3}
_GUARD_BITS = 64  # of evaluation, beyond the longer of the two runs
_LABEL = "largest of the seven states\n[rad, rad/s]"


@dataclass(frozen=True, eq=False, slots=True)
class Bounded:
    """What is proved of a candidate, and what is true of it.

    Attributes
    ----------
    name, precision : str
        Of the maneuver, and of the candidate's run.
    breaks : ndarray, shape (P + 1,)
        Ends of the pieces [s].
    bound : ndarray, shape (P,)
        Certified bound over each piece, of all states [rad, rad/s].
    time, error : ndarray, shape (rows,)
        Times of the rows [s] and the largest true error of all states there; no error without
        heyoka.
    """

    name: str
    precision: str
    breaks: Array
    bound: Array
    time: Array
    error: Array | None


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """A panel for each maneuver, the largest of all states, in rad and rad/s.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    DatasetError
        The candidate of the set is missing or damaged.
    NotCertifiedError
        A candidate is not certified.
    """
    with style():
        from matplotlib.figure import Figure

        runs = read_candidate(reference.folder)
        found = bounds([runs[n - 1] for n in numbers])
        lines = ceil(len(found) / _ACROSS)
        figure = Figure(figsize=(WIDTH, lines * _HEIGHT), layout="constrained")
        grid = figure.subplots(lines, min(len(found), _ACROSS), sharey=True, squeeze=False)
        axes = grid.ravel()
        for ax in axes[len(found) :]:
            ax.set_visible(False)
        for ax, run in zip(axes, found, strict=False):
            ax.stairs(
                run.bound, run.breaks, baseline=None, color=VERMILLION, linewidth=1.6,
                zorder=2.5, label="certified bound",
            )  # fmt: skip
            if run.error is not None:
                label = f"true error (from {MORE_DIGITS} more digits)"
                ax.plot(run.time, run.error, color=BLUE, linewidth=0.8, label=label)
            ax.set_yscale("log", nonpositive="mask")
            ax.set(xlim=(0.0, float(run.time[-1])), xlabel="time [s]")
            ax.set_title(f"{run.name}, {run.precision}", fontsize=9, parse_math=False)
        for row in grid:
            row[0].set_ylabel(_LABEL)
        # Before the first step the error is that of rounding the start, and of no interest.
        axes[0].set_ylim(bottom=min(run.bound.min() for run in found) * _BELOW)
        if any(run.error is None for run in found):
            axes[0].plot([], [], color=BLACK, linestyle="none", label="true error: needs heyoka")
        figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2,
            frameon=False,
        )  # fmt: skip
    return figure


def bounds(runs: Sequence[Trajectory]) -> list[Bounded]:
    """Bounds and true errors of candidates, several at a time."""
    motions = [(run.maneuver.name, float(run.maneuver.duration)) for run in runs]
    with progress_bars(_SHARES) as progress:
        return side_by_side(bounded, [(run,) for run in runs], motions, progress)


def bounded(run: Trajectory, report: OnStage) -> Bounded:
    """The bound of a candidate, proved, and its true error."""
    certificate = enclosed(run, report)
    return Bounded(
        name=run.maneuver.name,
        precision=run.precision,
        breaks=np.array([float(t) for t in run.breaks]),
        bound=np.array([float(max(piece)) for piece in certificate.pieces]),
        time=np.array([float(t) for t in row_times(run.maneuver)]),
        error=_true_error(run, lambda t: report("integrate", t)),
    )


def _true_error(run: Trajectory, progress: Callable[[float], None]) -> Array | None:
    try:
        require_heyoka()
    except MissingPackageError:
        return None
    digits = min(int(run.precision.split()[0]) + MORE_DIGITS, MAX_DIGITS)
    exact = integrate(
        run.bicycle, run.maneuver, Precision.of(digits), is_regular=run.is_regular,
        progress=progress,
    )  # fmt: skip
    with flint.ctx.workprec(max(run.bits, exact.bits) + _GUARD_BITS):
        apart = [
            max(
                abs(float((x - y).mid())) for x, y in zip(run.state(t), exact.state(t), strict=True)
            )
            for t in row_times(run.maneuver)
        ]
    return np.array(apart)
