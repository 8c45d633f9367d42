"""Make an atlas: compute missing chunks, then the basin boundary from all chunks."""

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.parameters import START, Bicycle, Maneuver
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.jobs import Job, Outcome
from heyoka_bike.system.parallel import carry_out, side_by_side
from heyoka_bike.workbench.atlas.data import FALLS, UNDECIDED, Atlas, Edge
from heyoka_bike.workbench.atlas.design import ACCURACY, EDGE_ACCURACY, Chunk, Design
from heyoka_bike.workbench.atlas.fates import fates
from heyoka_bike.workbench.atlas.runs import PLANS, Runs
from heyoka_bike.workbench.atlas.store import AtlasStore, load_atlas

Quantities = Mapping[str, Array]

# Duration of the motion in which a wheel lift is searched for [s].
_SECONDS_LOOKED_AHEAD = Fraction(10)


def chunk(design: Design, which: Chunk, report: Any = None) -> Quantities:
    """Compute the quantities of `VARIABLES` at the points of a chunk."""
    first, second = (
        axis.values[part] for axis, part in zip(design.axes, design.slices(which), strict=True)
    )
    grid = np.meshgrid(first, second, indexing="ij")
    bicycles, starts, mine = design.points(*(x.ravel() for x in grid))
    found = fates(Runs(bicycles, PLANS[ACCURACY]), starts, mine, design.longest)
    return {name: values.reshape(grid[0].shape) for name, values in found.items()}


def changes(axis: Array, row: Array) -> tuple[Array, Array]:
    """Return pairs of neighbouring values on an axis: one motion stays up, the other falls.

    If one of the two is undecided, nothing is known about a change.
    """
    is_known = (row[:-1] != UNDECIDED) & (row[1:] != UNDECIDED)
    falls = row == FALLS
    places = np.flatnonzero((falls[:-1] != falls[1:]) & is_known)
    ahead = falls[places + 1]
    return axis[np.where(ahead, places, places + 1)], axis[np.where(ahead, places + 1, places)]


def bisect_boundary(
    design: Design, at: Array, stays: Array, falls: Array, report: Any = None
) -> tuple[Array, Array, Array]:
    """Bisect each change of fate, until its two values are neighbouring binary64 numbers.

    A change is left out if the bisection meets an undecided motion.

    Parameters
    ----------
    at : ndarray, shape (changes,)
        Values on the first axis.
    stays, falls : ndarray, shape (changes,)
        Values on the second axis, from `changes`.

    Returns
    -------
    at, stays, falls : ndarray
    """
    at, stays, falls = at.copy(), stays.copy(), falls.copy()
    # The grid was computed less accurately than the boundary, so determine the fates at both ends
    # of each interval again.
    ends = [_fates(design, at, x) for x in (stays, falls)]
    is_kept = (ends[0] != FALLS) & (ends[0] != UNDECIDED) & (ends[1] == FALLS)
    while True:
        middle = stays + (falls - stays) / 2
        active = np.flatnonzero(is_kept & (middle != stays) & (middle != falls))
        if not len(active):
            return at[is_kept], stays[is_kept], falls[is_kept]
        fate = _fates(design, at[active], middle[active])
        is_fall = fate == FALLS
        falls[active[is_fall]] = middle[active[is_fall]]
        stays[active[~is_fall]] = middle[active[~is_fall]]
        is_kept[active[fate == UNDECIDED]] = False


def lift_of(design: Design, point: Mapping[str, Exact]) -> tuple[Bicycle, Maneuver, float | None]:
    """Return the bicycle and maneuver of a point, and when a wheel first lifts (in binary64).

    Without a lift the maneuver has the duration of the search.
    """
    at = {**{name: Exact(Fraction(x)) for name, x in design.start.items()}, **point}
    start: dict[str, Any] = {name: at.pop(name) for name in START}
    bicycle = design.bicycle.replace(**at) if at else design.bicycle
    maneuver = Maneuver(
        "point", **start, duration=_SECONDS_LOOKED_AHEAD, spacing=_SECONDS_LOOKED_AHEAD
    )
    row = np.array([[float(start[name]) for name in START]])
    runs = Runs([bicycle], PLANS[EDGE_ACCURACY])
    time = fates(runs, row, np.zeros(1, int), design.longest, is_brief=True)["lift_time"][0]
    return bicycle, maneuver, float(time) if np.isfinite(time) else None


def _fates(design: Design, first: Array, second: Array) -> Array:
    bicycles, starts, which = design.points(first, second)
    runs = Runs(bicycles, PLANS[EDGE_ACCURACY])
    return fates(runs, starts, which, design.longest, is_brief=True)["fate"]


_EDGE_SHARE = 0.3  # approximate share of the progress bar for the boundary
_CHANGES_OF_JOB = 8  # number of changes of fate that one job bisects


def make_atlas(
    design: Design, folder: str | Path, *, force: bool = False,
    progress: Callable[[float], None] = lambda done: None,
) -> Atlas:  # fmt: skip
    """Compute an atlas in a folder, or only the missing parts of the atlas.

    Parameters
    ----------
    design : Design
    folder
        Folder of the Zarr store; an interrupted atlas is continued.
    force
        Replace another atlas in the folder.
    progress
        Called with the fraction of the work that is done, 0 to 1.

    Returns
    -------
    Atlas

    Raises
    ------
    InputError
        The folder contains something else, or cannot be written.
    MissingPackageError
        heyoka or zarr is not installed.
    """
    store = AtlasStore(Path(folder), design, force=force)
    # A boundary in the store remains valid even if chunks are missing: the same chunks will be
    # computed again.
    has_edge = store.has_edge
    missing = {Job(chunk, (design, which)): which for which in store.missing()}
    total = sum(1 for _ in design.chunks())

    def ended(job: Job, outcome: Outcome) -> tuple[()]:
        store.put(missing.pop(job), outcome.get())
        progress((1 - _EDGE_SHARE) * (1 - len(missing) / total))
        return ()

    carry_out(list(missing), ended)
    if not has_edge:
        jobs = list(_edge_jobs(design, store))
        parts = side_by_side(
            bisect_boundary, jobs, done=lambda n: progress(1 - _EDGE_SHARE * (1 - n / len(jobs)))
        )
        together = [np.concatenate(x) for x in zip(*parts, strict=True)]
        store.put_edge(Edge(*together))
    progress(1.0)
    return load_atlas(folder)


def _edge_jobs(design: Design, store: AtlasStore) -> Iterator[tuple[Design, Array, Array, Array]]:
    """Yield arguments of `bisect_boundary`, each for several changes of fate in the grid."""
    first, second = (axis.values for axis in design.axes)
    for begin in range(0, len(first), design.side):
        rows = range(begin, min(begin + design.side, len(first)))
        ends = [changes(second, store.row(row)) for row in rows]
        at = np.repeat(first[rows], [len(stays) for stays, _ in ends])
        stays, falls = (np.concatenate(x) for x in zip(*ends, strict=True))
        for i in range(0, len(at), _CHANGES_OF_JOB):
            some = slice(i, i + _CHANGES_OF_JOB)
            yield design, at[some], stays[some], falls[some]
