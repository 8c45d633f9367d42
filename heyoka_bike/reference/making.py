"""Make reference datasets: from bicycles and their maneuvers to the files in folders.

- ``uncontrolled-bicycle.h5``: rows and dense output, hi + lo, as HDF5 that netCDF readers open
- ``uncontrolled-bicycle.txt``: the 25 columns of the benchmark
- ``uncontrolled-bicycle-50digits.txt``: the same with 50 significant digits
- ``candidate.h5``: the trajectories themselves, as exact integers
- ``certificate.json``: what is proved
- ``sensitivities.h5``: derivatives of every column with respect to parameters and initial
  conditions
- ``motion.h5``: the whole configuration and all forces, hi + lo
- ``states.csv``, ``states.h5``: all quantities of the known states of the benchmark's bicycle
- ``after-ten-seconds/``: proved statements on later motion (published dataset only)
- ``README.md``, ``ro-crate-metadata.json``: description of the published dataset, for people and
  machines
- ``manifest.json``
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import (
    Bicycle,
    Given,
    Maneuver,
    benchmark,
    describe_inputs,
    describe_limits,
    read_inputs,
)
from heyoka_bike.errors import BicycleError, DatasetError, InputError, SingularMotionError
from heyoka_bike.motion.events import Ending, ending
from heyoka_bike.motion.heyoka_adapter import require_heyoka
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference import layout
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description import about, describe
from heyoka_bike.reference.hdf5 import by_maneuver, render
from heyoka_bike.reference.manifest import CUSTOM, DATASET_VERSION
from heyoka_bike.reference.proof import candidate, certificate, compute_table
from heyoka_bike.reference.proof.instants import render_states
from heyoka_bike.reference.proof.rows import render_texts
from heyoka_bike.reference.structure import COLUMNS_OF, of_file
from heyoka_bike.system.jobs import Job, OnStage, Outcome
from heyoka_bike.system.machine import PACKAGES, installed
from heyoka_bike.system.parallel import Progress, carry_out
from heyoka_bike.system.resources import reference_folder

MIN_DIGITS, MAX_DIGITS = 65, 1000
_ATTEMPTS = 4
_MORE_DIGITS = 20
_STAGES = ("integrate", *compute_table.STAGES)
_ROUNDING_STAGES = ("rows", "motion")

_TIME_OF_INTEGRATION, _TIME_OF_ALL = (0.4, 0.08), (1.2, 1.2)
"""Time to integrate a maneuver, and to do all of its work, each per maneuver and per piece [s], on
the machine of docs/reference/speed-tables.md. Other machines are assumed to be slower by one factor
throughout."""

_LEAST_TRAIL = 0.1
"""Below this trail, in radii of the front wheel, the regular form is used, because its proof is
faster: a third of the time at a trail of 0.05, a quarter at 0.03. From 0.1 on it is only slower."""

# The expected time is reported if it is at least `_SHORT` [s], in minutes if it is at least `_LONG`
# [s].
_SHORT, _LONG = 10, 90

Fail = Callable[[Path, Exception], None]


@dataclass(frozen=True)
class Generated:
    """Result of making a reference dataset.

    Attributes
    ----------
    folder : Path
    dataset_version : str
        ``custom`` if the inputs are not those of the benchmark.
    changed : tuple of str
        Names of the files that were written; files of equal content are not touched.
    endings : tuple of Ending
        End of each maneuver.
    tables : tuple of Table
        Computed numbers of each maneuver.
    """

    folder: Path
    dataset_version: str
    changed: tuple[str, ...]
    endings: tuple[Ending, ...]
    tables: tuple[compute_table.Table, ...]


def generate(
    folder: str | Path,
    *,
    bicycle: Given = "benchmark",
    maneuvers: Sequence[Maneuver] | str | Path | None = None,
    digits: int = 70,
    until: str | None = None,
    force: bool = False,
    say: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> Generated:
    """Integrate maneuvers, prove their accuracy, and write a reference dataset.

    This is what ``heyoka-bike generate`` does. Parts of the work run in processes of their own, or
    as set by `parallel.using`, so a script that makes more than one maneuver needs the guard
    ``if __name__ == "__main__"``. After an interruption, the same call starts from the beginning.

    Parameters
    ----------
    folder
        Folder for the dataset; created if needed.
    bicycle
        A bicycle, the name of one of the collection, or a TOML file.
    maneuvers
        Maneuvers, the name of some in the collection, or a TOML file; by default those with the
        bicycle's name, else those of the benchmark.
    digits
        Decimal digits of the integration, 65 to 1000.
    until
        A time [s] that replaces the maneuvers' durations, or ``fall``: up to the last row before a
        wheel leaves the floor or the model ends.
    force
        True to replace a dataset of another version or of other inputs.
    say
        Called with a line of text for each warning about the bicycle, for each maneuver that
        `until` or the end of the model shortens, and for the estimated time once it is known.
    progress
        Called with the name of a maneuver, the stage of the work (``waiting``, ``integrate``,
        ``certify``, ``rows``, ``dense``, ``motion``, ``vary``) and the completed fraction of that
        stage, 0 to 1.

    Returns
    -------
    Generated
        The written files, and the numbers that they contain.

    Raises
    ------
    InputError
        An argument cannot be used, or the folder contains another dataset and `force` is False.
    SingularMotionError
        A motion meets a singularity before its end that the first search did not find.
    NotCertifiedError
        A motion cannot be certified.
    DatasetError
        The folder cannot be written.
    MissingPackageError
        heyoka is not installed.
    """
    if not str(folder).strip():
        raise InputError("--out: found nothing, expected a folder")
    found: list[Generated] = []
    generate_sets(
        {Path(folder): bicycle}, maneuvers=maneuvers, digits=digits, until=until, force=force,
        say=say or (lambda text: None), progress=progress, made=found.append,
    )  # fmt: skip
    return found[0]


def generate_sets(
    sets: Mapping[Path, Given], *, maneuvers: Sequence[Maneuver] | str | Path | None, digits: int,
    until: str | None, force: bool, say: Callable[[str], None], progress: Progress | None,
    made: Callable[[Generated], None],
) -> dict[Path, Exception]:  # fmt: skip
    """Make the datasets of several bicycles; one queue contains the jobs of all of them.

    Parameters
    ----------
    sets
        The bicycle of each folder.
    made
        Called with each dataset as soon as it is written.

    Returns
    -------
    dict
        The error of each folder that was not written. An error of one dataset does not stop the
        others; the error of a single dataset is raised.
    """
    require_heyoka()
    if not MIN_DIGITS <= digits <= MAX_DIGITS:
        raise InputError(f"--digits: found {digits}, expected {MIN_DIGITS} to {MAX_DIGITS}")
    failed: dict[Path, Exception] = {}

    def fail(folder: Path, error: Exception) -> None:
        if len(sets) == 1:
            raise error
        failed.setdefault(folder, error)

    making = []
    for folder, (bicycle, asked, ends) in _endings(sets, maneuvers, until, fail).items():
        for line in _said(bicycle, asked, ends):
            say(line)
        name = f"{bicycle.name}, " if len(sets) > 1 else ""
        try:
            one = _SetInMaking(folder, bicycle, ends, name, digits)
            check_overwrite(folder, one.version, one.inputs, force=force)
            making.append(one)
        except BicycleError as e:
            fail(folder, e)
    owners = {job: one for one in making for job in one.begin()}

    def ended(job: Job, outcome: Outcome) -> Iterable[Job]:
        one = owners.pop(job)
        try:
            more = one.ended(job, outcome)
            if (line := one.outlook()) is not None:
                say(line)
            if one.is_done:
                made(one.write())
        except Exception as e:
            fail(one.folder, e)
            return ()
        owners.update(dict.fromkeys(more, one))
        return more

    def is_wanted(job: Job) -> bool:
        return job in owners[job].places

    carry_out(list(owners), ended, progress, is_wanted)
    return failed


def _endings(
    sets: Mapping[Path, Given], maneuvers: Sequence[Maneuver] | str | Path | None,
    until: str | None, fail: Fail,
) -> dict[Path, tuple[Bicycle, Sequence[Maneuver], tuple[Ending, ...]]]:  # fmt: skip
    """Read the inputs of each dataset, and determine the time at which each maneuver ends."""
    jobs, found = {}, {}
    for folder, given in sets.items():
        try:
            bicycle, asked = read_inputs(given, maneuvers)
            jobs[Job(_end_of_each, (bicycle, asked, until))] = folder, bicycle, asked
        except BicycleError as e:
            fail(folder, e)

    def ended(job: Job, outcome: Outcome) -> tuple[()]:
        folder, bicycle, asked = jobs[job]
        if outcome.error is not None:
            fail(folder, outcome.error)
        else:
            found[folder] = bicycle, asked, outcome.value
        return ()

    carry_out(jobs, ended)
    return {folder: found[folder] for folder in sets if folder in found}


def _end_of_each(
    bicycle: Bicycle, maneuvers: Sequence[Maneuver], until: str | None, report: OnStage
) -> tuple[Ending, ...]:
    return tuple(ending(bicycle, m, until) for m in maneuvers)


def _integrated(bicycle: Bicycle, maneuver: Maneuver, digits: int, report: OnStage) -> Trajectory:
    try:
        return integrate(
            bicycle, maneuver, Precision.of(digits), least_trail=_LEAST_TRAIL,
            progress=lambda t: report("integrate", t),
        )  # fmt: skip
    except SingularMotionError as e:
        raise SingularMotionError(
            f"{maneuver.name}: {e}, before the end of its {float(maneuver.duration):g} s; nothing "
            "was written; choose a shorter duration",
            e.time,
        ) from None


def _said(bicycle: Bicycle, asked: Sequence[Maneuver], ends: Sequence[Ending]) -> Iterable[str]:
    for warning in bicycle.warnings:
        yield f"warning: {bicycle.name}: {warning}"
    for m, end in zip(asked, ends, strict=True):
        if end.said is not None:
            early = "stopped early: " if end.is_early else ""
            yield (
                f"{early}{m.name}: {end.said}; the dataset ends at "
                f"{float(end.maneuver.duration):g} s"
            )


class _SetInMaking:
    """A dataset that is being made: its jobs, and their outcomes until it is written."""

    def __init__(
        self, folder: Path, bicycle: Bicycle, ends: Sequence[Ending], name: str, digits: int
    ) -> None:
        self.folder, self.bicycle, self.ends, self.name = folder, bicycle, ends, name
        self.digits = digits
        self.maneuvers = [end.maneuver for end in ends]
        self.inputs = describe_inputs(bicycle, self.maneuvers)
        is_published = self.inputs == describe_inputs(*benchmark())
        self.version = DATASET_VERSION if is_published else CUSTOM
        self.attempts = [1] * len(ends)
        self.is_told = self.is_written = False
        self.candidates: list[dict[str, frozenset[Any]]] = [{} for _ in ends]
        self.parts: list[dict[str, Outcome]] = [{} for _ in ends]
        self.places: dict[Job, tuple[int, str]] = {}

    def outlook(self) -> str | None:
        """Return a line on the expected time, once all maneuvers are integrated; None if short.

        Even processor time is longer if processes share a core, so the estimate is exceeded if a
        single process did the integration.
        """
        if self.is_told or not all("integrate" in parts for parts in self.parts):
            return None
        self.is_told = True
        integrated = [parts["integrate"] for parts in self.parts]
        pieces = sum(x.get().steps for x in integrated)
        there, here = (
            fixed * len(integrated) + each * pieces
            for fixed, each in (_TIME_OF_INTEGRATION, _TIME_OF_ALL)
        )
        seconds = here * sum(x.seconds for x in integrated) / there
        if seconds < _SHORT:
            return None
        long = f"{seconds / 60:.0f} min" if seconds >= _LONG else f"{seconds:.0f} s"
        counted = "1 piece" if pieces == 1 else f"{pieces} pieces"
        return (
            f"{self.folder}: {counted} of motion, about {long} of processor time in all, estimated "
            "from the integration; it takes longer if processes share a processor"
        )

    def begin(self) -> list[Job]:
        """Return the jobs of all maneuvers; jobs that other jobs need come first."""
        found = [self._jobs(i) for i in range(len(self.maneuvers))]
        return [jobs[stage] for stage in _STAGES for jobs in found]

    def _jobs(self, i: int) -> dict[str, Job]:
        m, digits = self.maneuvers[i], self.digits + _MORE_DIGITS * (self.attempts[i] - 1)

        def job(work: Callable[..., Any], of: tuple[Any, ...], stages: tuple[str, ...]) -> Job:
            return Job(work, of, self.name + m.name, float(m.duration), stages)

        run = job(_integrated, (self.bicycle, m, digits), stages=("integrate",))
        jobs = {"integrate": run, **compute_table.table_jobs(run, job, {})}
        self.places |= {job: (i, stage) for stage, job in jobs.items()}
        return jobs

    def ended(self, job: Job, outcome: Outcome) -> list[Job]:
        """Record the outcome of a job and return the additional jobs to do.

        If a rounding is not decided, the maneuver starts again with 20 more digits, at most three
        times, as long as that changes the candidates of any entry. Remaining undecided entries are
        published as such.
        """
        if job not in self.places:
            return []
        i, stage = self.places.pop(job)
        value = outcome.get()
        candidates = value[0].candidates if stage in _ROUNDING_STAGES else frozenset()
        before = self.candidates[i].get(stage, frozenset())
        self.candidates[i][stage] = candidates
        if candidates and candidates != before and self.attempts[i] < _ATTEMPTS:
            self.attempts[i] += 1
            self.places = {x: place for x, place in self.places.items() if place[0] != i}
            self.parts[i] = {}
            again = self._jobs(i)
            return [again[stage] for stage in _STAGES]
        self.parts[i][stage] = outcome
        return []

    @property
    def is_done(self) -> bool:
        """True from the last outcome that is needed until the dataset is written."""
        if self.is_written or self.places:
            return False
        return all(len(parts) == len(_STAGES) for parts in self.parts)

    def write(self) -> Generated:
        """Write the files of the dataset."""
        self.is_written = True
        tables = [
            compute_table.assemble_table(parts["integrate"].get(), parts) for parts in self.parts
        ]
        self.parts = []
        changed = write_dataset(
            self.folder, self.bicycle, tables, self.digits, self.version,
            describe_limits(self.maneuvers),
        )  # fmt: skip
        return Generated(self.folder, self.version, tuple(changed), tuple(self.ends), tuple(tables))


def write_dataset(
    folder: str | Path, bicycle: Bicycle, tables: Sequence[compute_table.Table], digits: int,
    dataset_version: str, performance_limits: Mapping[str, str] | None = None,
) -> list[str]:  # fmt: skip
    """Write the dataset into a folder; return the names of the files that changed.

    The limits of eq. (1) are by number of the maneuver, for maneuvers that have one; see
    `describe_limits`.

    Raises
    ------
    DatasetError
        The folder cannot be written.
    """
    inputs = describe_inputs(bicycle, [t.maneuver for t in tables])
    hdf5_version = manifest_file.hdf5_version(dataset_version)
    of_tables = [t.numbers for t in tables]
    numbers = {name: [x[name] for x in of_tables] for name in COLUMNS_OF}
    hashes = {name: layout.content_sha256(by_maneuver(x)) for name, x in numbers.items()}
    files = {
        name: render(
            of_file(name, about(name, inputs, hdf5_version, hashes[name]), inputs, x),
            by_maneuver(x),
        )
        for name, x in numbers.items()
    }
    files |= {
        layout.CANDIDATE: candidate.render([t.trajectory for t in tables], inputs, hdf5_version),
        **render_texts([t.maneuver for t in tables], [t.rows for t in tables]),
    }
    if bicycle.values == benchmark()[0].values:
        files |= render_states(bicycle, inputs, hdf5_version)
    proofs = [certificate.summarise(t) for t in tables]
    statement = certificate.statement_of(is_decided=all(p.is_decided for p in proofs))
    entries = [certificate.entry(p) for p in proofs]
    document = certificate.document(inputs, files, entries, statement=statement)
    files[layout.CERTIFICATE] = layout.as_json(document)
    if dataset_version != manifest_file.CUSTOM:
        files |= _after(Path(folder))
    packages = versions_of_packages(dataset_version)
    manifest_of = partial(
        manifest_file.render,
        dataset_version=dataset_version,
        content_sha256=hashes[layout.HDF5],
        inputs=inputs,
        made_by={"digits": digits, "packages": packages},
        performance_limits=performance_limits,
    )
    files |= describe(manifest_file.parse(manifest_of(files=files)))
    return manifest_file.write_set(folder, files, manifest_of(files=files))


def versions_of_packages(dataset_version: str) -> dict[str, str]:
    """Return the versions of packages that the manifest of a dataset states, by package.

    For the published dataset the version of heyoka_bike is the one that first made it: a later
    version writes the same files, so it must write the same manifest.
    """
    found = {name: installed(name) or "unknown" for name in ("heyoka_bike", *PACKAGES)}
    if dataset_version == DATASET_VERSION:
        found["heyoka_bike"] = manifest_file.DATASET_PACKAGE_VERSION
    return found


def _after(folder: Path) -> dict[str, bytes]:
    """Read the files on the motions after ten seconds, from the folder or else from the package."""
    found = {}
    for name in layout.AFTER_FILES:
        for path in (folder / name, reference_folder() / name):
            if path.is_file():
                found[name] = path.read_bytes()
                break
    return found


def check_overwrite(
    folder: str | Path, dataset_version: str, inputs: Mapping[str, Any], *, force: bool
) -> None:
    """Refuse to replace a dataset of another version or of other inputs.

    Raises
    ------
    InputError
        The folder contains such a dataset and `force` is False, or the folder cannot be written.
    """
    there = next(p for p in (Path(folder), *Path(folder).absolute().parents) if p.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        raise InputError(f"{folder}: cannot be written, {there} is not a writable folder")
    if force or not (Path(folder) / manifest_file.MANIFEST).exists():
        return
    try:
        present = manifest_file.read_manifest(folder)
    except DatasetError as e:
        raise InputError(f"{e}; use --force to replace it") from None
    if present.dataset_version != dataset_version:
        raise InputError(
            f"{folder}: contains dataset version {present.dataset_version}, but this run makes "
            f"{dataset_version}; use --force to replace it, or another --out"
        )
    if present.inputs != inputs:
        raise InputError(
            f"{folder}: contains a dataset of another bicycle or other maneuvers; "
            "use --force to replace it, or another --out"
        )
