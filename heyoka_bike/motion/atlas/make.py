"""Making an atlas: what is missing is computed, chunk by chunk, then the edge."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from heyoka_bike.motion.atlas.compute import Quantities, changes, chunk, edge
from heyoka_bike.motion.atlas.data import Atlas, Edge
from heyoka_bike.motion.atlas.design import Design
from heyoka_bike.motion.atlas.store import Store, load_atlas
from heyoka_bike.system.parallel import side_by_side

_EDGE_SHARE = 0.3  # of the work, about
_TOGETHER = 64  # changes that are bisected by a job


def make_atlas(
    design: Design, folder: str | Path, *, force: bool = False,
    progress: Callable[[float], None] = lambda done: None,
) -> Atlas:  # fmt: skip
    """Compute an atlas into a folder, or what is missing of it.

    Parameters
    ----------
    design : Design
    folder
        Of the Zarr store; one that was interrupted goes on where it was.
    force
        Replace another atlas that is there.
    progress
        Called with the part of the work that is done, 0 to 1.

    Returns
    -------
    Atlas

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written.
    MissingPackageError
        heyoka or zarr is not installed.
    """
    store = Store(Path(folder), design, force=force)
    missing = store.missing()
    total = sum(1 for _ in design.chunks())
    there = total - len(missing)

    def keep(i: int, values: Quantities) -> None:
        nonlocal there
        store.put(missing[i], values)
        there += 1
        progress((1 - _EDGE_SHARE) * there / total)

    if missing:
        side_by_side(chunk, [(design, which) for which in missing], done=keep)
    if not store.has_edge:
        store.put_edge(_edge(design, store, progress))
    progress(1.0)
    return load_atlas(folder)


def _edge(design: Design, store: Store, progress: Callable[[float], None]) -> Edge:
    """All changes between staying and falling along the second axis."""
    first, second = (axis.values for axis in design.axes)
    at, stays, falls = [np.empty(0)], [np.empty(0)], [np.empty(0)]
    for i, x in enumerate(first):
        pair = changes(second, store.row(i))
        at.append(np.full(len(pair[0]), x))
        stays.append(pair[0])
        falls.append(pair[1])
    rows = [np.concatenate(x) for x in (at, stays, falls)]
    jobs = [
        (design, *(x[begin : begin + _TOGETHER] for x in rows))
        for begin in range(0, len(rows[0]), _TOGETHER)
    ]
    if not jobs:
        return Edge()
    there = 0

    def keep(i: int, found: object) -> None:
        nonlocal there
        there += 1
        progress(1 - _EDGE_SHARE * (1 - there / len(jobs)))

    found = side_by_side(edge, jobs, done=keep)
    return Edge(*(np.concatenate(x) for x in zip(*found, strict=True)))
