"""Prove a reference dataset again.

Only the folder and python-flint are needed: candidate.h5 contains the trajectories, and everything
else follows from them and from the inputs stored with them.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.reference import layout
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.proof.certificate import Proof, compare_certificate, summarise
from heyoka_bike.reference.proof.compute_table import STAGES, assemble_table, table_jobs
from heyoka_bike.reference.proof.instants import states_differ
from heyoka_bike.reference.proof.rows import render_texts
from heyoka_bike.reference.proof.whole_files import read_whole
from heyoka_bike.system.jobs import Job
from heyoka_bike.system.parallel import Progress, all_of
from heyoka_bike.system.resources import reference_folder


def certify(
    folder: str | Path | None = None, *, progress: Progress | None = None
) -> tuple[Proof, ...]:
    """Prove again all that the certificate of a reference dataset claims, from its candidate.

    This is what ``heyoka-bike certify`` does, in ball arithmetic; heyoka is not needed. Parts of
    the proof run in processes of their own, or as set by `using`, so a script that calls this
    function needs the guard ``if __name__ == "__main__"``.

    Parameters
    ----------
    folder
        The dataset; by default the published one that comes with the package.
    progress
        Called with the name of a maneuver, the stage of the proof (``waiting``, ``certify``,
        ``rows``, ``dense``, ``motion``) and the completed fraction of that stage, 0 to 1.

    Returns
    -------
    tuple of Proof
        Proved facts by maneuver.

    Raises
    ------
    NotCertifiedError
        A candidate is not certified, a published value differs from the proved one, or the dataset
        contains something that is not proved.
    DatasetError
        A file is missing, damaged, or not part of a reference dataset.
    """
    where = reference_folder() if folder is None else folder
    read = manifest_file.check_published if folder is None else manifest_file.read_manifest
    manifest = read(where)
    runs = read_whole(where)
    jobs = list(_jobs(where, runs))
    found = all_of([of_run[stage] for stage in STAGES for of_run in jobs], progress)
    tables = [
        assemble_table(run, {stage: found[job] for stage, job in of_run.items()})
        for run, of_run in zip(runs, jobs, strict=True)
    ]
    proofs = tuple(map(summarise, tables))
    compare_certificate(manifest_file.read_file(where, layout.CERTIFICATE, manifest), proofs)
    for name in (layout.STATES, layout.STATES_HDF5):
        if name in manifest.files:
            raw = manifest_file.read_file(where, name, manifest)
            for problem in states_differ(name, raw, runs[0].bicycle):
                raise NotCertifiedError(f"{where}/{name}: {problem}")
    for name, data in render_texts([t.maneuver for t in tables], [t.rows for t in tables]).items():
        if manifest_file.read_file(where, name, manifest) != data:
            raise NotCertifiedError(f"{where}/{name}: differs from the proved values")
    return proofs


def _jobs(folder: str | Path, runs: Sequence[Trajectory]) -> Iterator[dict[str, Job]]:
    """Yield the jobs of each maneuver: the proof of its bound, and all that follows from it."""
    x = load_reference(folder)
    parts: dict[str, Mapping[int, Any]] = {
        "vary": x.sensitivities, "motion": x.motion, "rows": x
    }  # fmt: skip
    for number, run in enumerate(runs, start=1):
        m = run.maneuver
        job = partial(Job, name=m.name, duration=float(m.duration))
        yield table_jobs(run, job, {stage: part[number] for stage, part in parts.items()})
