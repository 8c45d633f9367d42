"""certificate.json: what is proved about a dataset, what is assumed; and proving it again.

The same jobs compute the numbers of a maneuver from its candidate and prove them again. If there
are published numbers, their dense output replaces a new one, and every proved number is compared
with the published one. Proving again needs only the folder and python-flint: candidate.h5 contains
the trajectories, and everything else follows from them and from the inputs stored with them.
"""

import json
import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.instant_columns import QUANTITIES
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import STATE_INPUTS, Maneuver, describe_inputs
from heyoka_bike.errors import BicycleError, DatasetError, NotCertifiedError, printable
from heyoka_bike.motion.trajectory import Certificate, Drift, Trajectory, evaluator
from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.numbers.rounding import decimal_above
from heyoka_bike.reference import form, hdf5, layout, structure
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description import about, describe
from heyoka_bike.reference.layout import STATES, STATES_HDF5, TEXT, TEXT_50
from heyoka_bike.reference.load import ReferenceManeuver, load_reference
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.proof.dense import (
    bound_columns,
    interpolate,
    scale_of_dense,
    tabulate_motion,
)
from heyoka_bike.reference.proof.enclose import enclosed
from heyoka_bike.reference.proof.instants import states_differ
from heyoka_bike.reference.proof.rows import (
    constant_columns,
    render_texts,
    round_rows,
    rounded_times,
)
from heyoka_bike.reference.proof.sensitivity_rows import differentiate
from heyoka_bike.reference.values import Dense, RoundedRows, Sensitivity, Values
from heyoka_bike.system.jobs import Job, Outcome, TellStage
from heyoka_bike.system.parallel import Progress, all_of
from heyoka_bike.system.resources import reference_folder


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
        """Arrays of the maneuver's group in each HDF5 file."""
        times = rounded_times(self.maneuver)
        return {
            layout.HDF5: numbers_of_table(times, self.rows, self.dense),
            layout.MOTION: numbers_of_table(times, self.motion_rows, self.motion_dense),
            layout.SENSITIVITIES: numbers_of_derivatives(self.sensitivity),
        }


STAGES = ("certify", "rows", "vary", "motion")
"""The jobs in the best order to start them: first those that others wait for, then the one that
shows whether the maneuver needs a new run with more digits, then the longest ones."""


def tabulating(
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
    works = ((varied, ("vary",)), (moved, ("motion",)), (rounded, ("rows", "dense")))
    return {"certify": bound} | {
        stages[0]: job(work, (run, bound, published.get(stages[0])), stages=stages)
        for work, stages in works
    }


def tabulated(run: Trajectory, outcomes: Mapping[str, Outcome]) -> Table:
    """Assemble the table from the outcomes of `tabulating` and of other jobs whose time counts."""
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


def rounded(
    run: Trajectory,
    certificate: Certificate,
    published: ReferenceManeuver | None,
    report: TellStage,
) -> tuple[RoundedRows, Dense, Drift]:
    """Compute every number of the columns, and the drift of the run's conserved quantities."""
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


def moved(
    run: Trajectory,
    certificate: Certificate,
    published: ReferenceManeuver | None,
    report: TellStage,
) -> tuple[Values, Dense]:
    """Compute every number of the whole motion."""
    dense = None if published is None else published.dense
    found = tabulate_motion(run, certificate, dense, partial(report, "motion"))
    _compare_tables(run, *found, published)
    return found


def varied(
    run: Trajectory, certificate: Certificate, published: Sensitivity | None, report: TellStage
) -> Sensitivity:
    """Compute every number of the derivatives."""
    found = differentiate(run, certificate, partial(report, "vary"))
    if published is not None:
        stored = numbers_of_derivatives(published)
        _compare(run, numbers_of_derivatives(found), stored, "derivatives")
    return found


def numbers_of_table(times: Double, rows: Values, dense: Dense) -> dict[str, Any]:
    """Return the arrays of a group of rows and dense output."""
    return {
        **dict(zip(("time", "time_lo"), times, strict=True)),
        **_tagged(rows.hi, rows.lo, rows.bound),
        **{name + hdf5.UNDECIDED: x for name, x in rows.undecided.items()},
        "dense": {"breaks": dense.breaks, **_tagged(dense.hi, dense.lo, dense.bound)},
    }


def numbers_of_derivatives(x: Sensitivity) -> dict[str, Any]:
    """Return the arrays of a group of derivatives."""
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
    """Compare rows and dense output with the published ones, if there are any."""
    if x is not None:
        stored = numbers_of_table((x.time, x.time_lo), x.rows, x.dense)
        _compare(run, numbers_of_table(rounded_times(run.maneuver), rows, dense), stored)


def _compare(
    run: Trajectory, proved: Mapping[str, Any], published: Mapping[str, Any], inside: str = ""
) -> None:
    """Compare every published number to the bit, except NaN; bounds must cover the proved ones.

    Both arguments map names of groups to arrays by names of datasets; `inside` says what the
    indices count.
    """
    for name in published.keys() - proved.keys():
        raise NotCertifiedError(
            f"{run.maneuver.name}: {_in_words(name, inside)}: published, and not what is proved"
        )
    for name, right in proved.items():
        if isinstance(right, dict):
            _compare(run, right, published[name], f"{name} of {inside}" if inside else name)
            continue
        where, found = f"{run.maneuver.name}: {_in_words(name, inside)}", published.get(name)
        if found is None:
            raise NotCertifiedError(f"{where}: not in the file")
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
            # Count pieces from 1.
            at = ", ".join(str(i + (inside == "dense")) for i in place)
            raise NotCertifiedError(
                f"{where} {at}: published {float(found[place])!r}, proved {float(right[place])!r}"
            )


def _in_words(name: str, inside: str) -> str:
    """Return the name of a dataset in words, up to the index in it."""
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


STATEMENT_1_5_0 = (
    "For every maneuver, at every time of the interval, each state variable of the exact motion "
    "differs from the polynomial in candidate.h5 by at most the bound given. Every value of the "
    "rows is the binary64 nearest to the exact one, its _lo the binary64 nearest to the rest, and "
    "the 50-digit text is correctly rounded. The dense output differs from the exact columns by at "
    "most the bounds given, relative to the largest absolute value of the column's rows. The same "
    "holds of motion.h5, where a value is zero if an enclosure as narrow as its bound holds zero, "
    "and where the friction demands have rows only. In sensitivities.h5 each piece differs from "
    "the exact derivatives by at most its bound, by column and unknown; the rows there are the "
    "exact derivatives, each rounded to the nearest binary64 but for the number of ambiguous "
    "roundings, and zero where an enclosure as narrow as its bound holds zero; of NaN nothing is "
    "said. Nothing is proved of what is only computed."
)
"""The statement of the datasets 1.4.0 and 1.5.0."""

_OF_UNDECIDED = (
    " Of the rows that a dataset with _undecided lists it is not decided what is nearest: there "
    "value and _lo are some that are within the bound. A number of the 50-digit text that has "
    "fewer digits, or the exponent of a zero, differs from the exact one by at most one unit of "
    "the last digit. 'ambiguous' counts both."
)

STATEMENT = (
    f"{STATEMENT_1_5_0} Of the integration it is proved, from the state of candidate.h5 at the "
    "rows alone, how large the benchmark's eq. (1) is at most [%], how far the mechanical energy "
    "is at most from its first value, over that, and the front wheel from the floor [m]. Where "
    "there are states.csv and states.h5, every value there is the binary64 nearest to the exact "
    "one, in the state whose coordinates are the decimals written there; it is zero where a ball "
    "narrower than 2^-160 holds zero."
)


def statement_of(*, is_decided: bool) -> str:
    """Return the statement of a dataset; it mentions undecided roundings if there may be any."""
    return STATEMENT if is_decided else STATEMENT + _OF_UNDECIDED


def proved(files: Container[str], columns: Mapping[str, Sequence[Column]]) -> dict[str, list[str]]:
    """Return the proved columns by file; one text may stand for several files, one per maneuver.

    Parameters
    ----------
    files
        Files of the dataset.
    columns
        Columns of each HDF5 file of the maneuvers.
    """
    found = {name: [c.name for c in of_file] for name, of_file in columns.items()}
    found |= {TEXT: list(BENCHMARK_COLUMNS), TEXT_50: list(BENCHMARK_COLUMNS)}
    return found | {name: list(QUANTITIES) for name in (STATES, STATES_HDF5) if name in files}


TRUSTED = (
    "that the equations of motion in heyoka_bike (modules constants, kinematics, model, outputs) "
    "are those of the Carvallo-Whipple bicycle; that they are identically those of an independent "
    "Newton-Euler model is shown in the tests, at random points of a random prime field, where a "
    "false equation passes with a probability below 1e-140",
    "that they conserve the mechanical energy, which is published as its initial value, and that "
    "straight running is a solution: identities, shown in the tests in the same way, not by "
    "'certify'",
    "that with an initial steer angle the pitch is the root followed from zero steer (the root "
    "itself is enclosed)",
    "the ball arithmetic of FLINT/Arb, through python-flint",
    "the modules of heyoka_bike that 'certify' imports, and the Python interpreter that runs them; "
    "NumPy, h5py and HDF5, which read the files",
)
"""Assumptions of the proof. heyoka, its tolerance and its rounding are not among them."""


@dataclass(frozen=True)
class Proof:
    """Proved facts about a maneuver.

    Attributes
    ----------
    name : str
    steps, entries, motion_entries, ambiguous, motion_ambiguous : int
        Pieces of the candidate; rounded entries of the rows in either HDF5 file; entries of either
        file whose rounding is undecided, the first number including the text of 50 digits.
    states : mapping of str to (Fraction, Fraction)
        Bound over the interval and at its end, by state variable [rad, rad/s].
    dense, motion_dense : mapping of str to Fraction
        Bound of the dense output relative to the column's scale, in either HDF5 file.
    derivatives : mapping of str to Fraction
        Bound of the derivatives of each column relative to the largest, for the worst unknown.
    drift : Drift
        Drift of the candidate in energy and contact, which the exact motion conserves.
    bits : int
        Bits of the significand in the run.
    derivative_entries, derivatives_ambiguous : int
        Rounded entries of the rows of derivatives; undecided roundings among them and among the
        coefficients.
    cpu : float
        Processor time [s].
    """

    name: str
    steps: int
    entries: int
    motion_entries: int
    ambiguous: int
    motion_ambiguous: int
    states: Mapping[str, tuple[Fraction, Fraction]]
    dense: Mapping[str, Fraction]
    motion_dense: Mapping[str, Fraction]
    derivatives: Mapping[str, Fraction]
    drift: Drift
    bits: int
    derivative_entries: int
    derivatives_ambiguous: int
    cpu: float = 0.0

    @property
    def is_decided(self) -> bool:
        """True if every entry of the rows could be rounded."""
        return not (self.ambiguous or self.motion_ambiguous)

    @property
    def bound(self) -> Fraction:
        """Largest bound over the interval."""
        return max(x for x, _ in self.states.values())

    @property
    def bound_end(self) -> Fraction:
        """Largest bound at the end."""
        return max(x for _, x in self.states.values())


def summarise(x: Table) -> Proof:
    """Gather the proved facts of a table."""
    worst = [max(column) for column in zip(*x.certificate.pieces, strict=True)]
    pairs = zip(worst, x.certificate.end, strict=True)
    return Proof(
        name=x.maneuver.name,
        steps=x.trajectory.steps,
        entries=_count(x.rows),
        motion_entries=_count(x.motion_rows),
        ambiguous=x.rows.ambiguous,
        motion_ambiguous=x.motion_rows.ambiguous,
        states=dict(zip(x.certificate.states, pairs, strict=True)),
        dense=_relative(x.dense, x.rows),
        motion_dense=_relative(x.motion_dense, x.motion_rows),
        derivatives={name: _of_largest(x.sensitivity, name) for name in x.sensitivity.bound},
        drift=x.drift,
        bits=x.trajectory.bits,
        derivative_entries=sum(values.size for values in x.sensitivity.values.values()),
        derivatives_ambiguous=x.sensitivity.ambiguous,
        cpu=x.cpu,
    )


def _count(rows: Values) -> int:
    return sum(x.size for x in rows.hi.values())


def _relative(dense: Dense, rows: Values) -> Mapping[str, Fraction]:
    return {
        name: Fraction(float(x.max())) / Fraction(rows.scale(name) or 1.0)
        for name, x in dense.bound.items()
    }


def relative_bounds(m: ReferenceManeuver) -> dict[str, str]:
    """Return the entry on the bounds of the dense output of a maneuver."""
    return _above(_relative(m.dense, m.rows))


def _of_largest(sensitivity: Sensitivity, name: str) -> Fraction:
    """Return the bound of a column relative to its largest coefficient, for the worst unknown."""
    sizes = np.fmax.reduce(np.abs(sensitivity.coefficients[name]), axis=(0, 1))
    bounds = np.fmax.reduce(sensitivity.bound[name], axis=0)
    pairs = zip(bounds, sizes, strict=True)
    return max(
        (Fraction(float(b)) / Fraction(float(x)) for b, x in pairs if x > 0), default=Fraction(0)
    )


def document(
    inputs: Mapping[str, Any], files: Container[str], maneuvers: Sequence[Any],
    columns: Mapping[str, Sequence[Column]] = structure.COLUMNS_OF, statement: str = STATEMENT,
) -> dict[str, Any]:  # fmt: skip
    """Return certificate.json of a dataset with these files; for the parameters see `proved`."""
    return {
        "schema_version": 1,
        "statement": statement,
        "inputs": inputs,
        "proved": proved(files, columns),
        # A file is never published without a proof, so none is listed as only computed.
        "computed": {},
        "maneuvers": maneuvers,
        "trusted": list(TRUSTED),
        "software": {"flint": flint.__FLINT_VERSION__, "python-flint": flint.__version__},
    }


def entry(proof: Proof) -> dict[str, Any]:
    """Return the entry of a maneuver; decimals are bounds."""
    return {
        "maneuver": proof.name,
        "steps": proof.steps,
        "entries": proof.entries,
        "ambiguous": proof.ambiguous,
        "bound": decimal_above(proof.bound),
        "bound_end": decimal_above(proof.bound_end),
        "state_bounds": {
            state: {"interval": decimal_above(x), "end": decimal_above(y)}
            for state, (x, y) in proof.states.items()
        },
        "dense_relative_bounds": _above(proof.dense),
        "motion": {
            "entries": proof.motion_entries,
            **({"ambiguous": proof.motion_ambiguous} if proof.motion_ambiguous else {}),
            "dense_relative_bounds": _above(proof.motion_dense),
        },
        "sensitivities": {
            "entries": proof.derivative_entries,
            "ambiguous": proof.derivatives_ambiguous,
            "relative_bounds": _above(proof.derivatives),
        },
        "integration": kept(proof.drift, proof.bits),
    }


def kept(drift: Drift, bits: int) -> dict[str, str]:
    """Return the entry on energy and contact of a run with this many bits."""
    return {
        "performance_percent": decimal_above(Fraction(drift.performance)),
        "energy": decimal_above(Fraction(drift.energy) / 2**bits),
        "contact": decimal_above(Fraction(drift.contact)),
    }


def _above(bounds: Mapping[str, Fraction]) -> dict[str, str]:
    return {name: decimal_above(x) for name, x in bounds.items()}


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
    if folder is None:
        manifest_file.check_published(where)
    runs = read_whole(where)
    jobs = list(_jobs(where, runs))
    found = all_of([of_run[stage] for stage in STAGES for of_run in jobs], progress)
    tables = [
        tabulated(run, {stage: found[job] for stage, job in of_run.items()})
        for run, of_run in zip(runs, jobs, strict=True)
    ]
    proofs = tuple(map(summarise, tables))
    manifest = manifest_file.read_manifest(where)
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
        yield tabulating(run, job, {stage: part[number] for stage, part in parts.items()})


def read_whole(folder: str | Path) -> tuple[Trajectory, ...]:
    """Read the trajectories of a dataset, after checking that all files are whole and agree.

    Raises
    ------
    DatasetError
        A file is missing or does not match the manifest.
    NotCertifiedError
        The files do not agree on the bicycle or the maneuvers.
    """
    of_manifest = manifest_file.read_raw(folder)
    manifest = manifest_file.parse(of_manifest, Path(folder) / manifest_file.MANIFEST)
    raw = {name: manifest_file.read_file(folder, name, manifest) for name in manifest.files}
    runs = read_candidate(folder)
    if not runs:
        raise DatasetError(f"{folder}: candidate.h5 holds no maneuver")
    maneuvers = [run.maneuver for run in runs]
    inputs = describe_inputs(runs[0].bicycle, maneuvers)
    texts = [text.name for text in layout.text_files(maneuvers)]
    others = {STATES, layout.CERTIFICATE, *describe(manifest), *texts}
    if manifest.dataset_version != manifest_file.CUSTOM:
        # `certify_after` proves these files.
        others |= {*layout.AFTER_FILES}
    # Lengths and texts do not matter here. Undecided entries are compared with the proof later.
    empty = np.empty(0)
    undecided = {c.name + hdf5.UNDECIDED: empty for c in (*COLUMNS, *MOTION_COLUMNS)}

    def declared(name: str) -> hdf5.Group:
        said = about(name, inputs, "", None if name == layout.CANDIDATE else "")
        stored = dict.fromkeys(structure.STATED, 0) | undecided
        return structure.of_file(name, said, inputs, [stored] * len(runs))

    layouts = {name: declared(name) for name in (*structure.COLUMNS_OF, layout.CANDIDATE)}
    if STATES_HDF5 in raw:
        layouts[STATES_HDF5] = structure.states(about(STATES_HDF5, inputs, ""), 0)
    for name in raw.keys() - layouts.keys() - others:
        raise NotCertifiedError(f"{name}: found in the manifest, and nothing proves it")
    stated = {manifest_file.MANIFEST: manifest.inputs}
    try:
        # First, because the certificate of an older dataset shows its age.
        stated[layout.CERTIFICATE] = _whole_certificate(raw, len(runs))["inputs"]
        for name, built in layouts.items():
            if name not in raw:
                raise NotCertifiedError(
                    f"{name}: not in the manifest, expected what {layout.CERTIFICATE} names"
                )
            where = Path(folder) / name
            with manifest_file.reading(where, "a file of a set"), hdf5.opened(raw[name]) as f:
                for extra in sorted(_unknown(f, built)):
                    raise NotCertifiedError(f"{name}: found {extra}, and nothing proves it")
                stated[name] = _inputs(f, name, built.groups)
        with hdf5.opened(raw[layout.HDF5]) as f:
            content = layout.content_sha256(f)
    except BicycleError:
        raise
    except hdf5.DAMAGE as e:
        reason = f"{type(e).__name__}: {printable(str(e))[:200]}"
        raise DatasetError(f"{folder}: a file of the set cannot be read ({reason})") from None
    for name, other in stated.items():
        # The file of states has no maneuvers among its inputs.
        if other != {key: x for key, x in inputs.items() if key in other or name != STATES_HDF5}:
            raise NotCertifiedError(f"{folder}: the inputs in {name} are not those of candidate.h5")
    if content != manifest.content_sha256:
        raise NotCertifiedError(
            f"{folder}: content_sha256 is not that of the numbers in {layout.HDF5}"
        )
    expected = replace(form.expected(manifest, maneuvers, raw), has_proof=True)
    for name in layouts:
        is_states = name == STATES_HDF5
        look = form.of_instants if is_states else partial(form.of_groups, name=name)
        for problem in form.problems_of(look, raw[name], expected):
            if not isinstance(problem, form.Unchecked):
                raise NotCertifiedError(f"{folder}/{name}: {problem}")
    if problem := manifest_file.problem_of_form(of_manifest):
        raise NotCertifiedError(f"{folder}/{manifest_file.MANIFEST}: {problem}")
    return runs


def _unknown(item: Any, declared: hdf5.Group, where: str = "") -> Iterator[str]:
    """Yield the paths of undeclared members of a group, including attributes."""
    yield from (f"{where}{name}" for name in item if name not in declared.members)
    yield from (
        f"attribute {where}{name}" for name in item.attrs if name not in declared.attributes
    )
    for dataset in declared.datasets:
        known = dataset.attributes.keys() | hdf5.SCALE_ATTRIBUTES
        attributes = item[dataset.name].attrs if dataset.name in item else ()
        yield from (f"attribute {where}{dataset.name}/{x}" for x in attributes if x not in known)
    for name, inner in declared.groups.items():
        if name in item:
            yield from _unknown(item[name], inner, f"{where}{name}/")


def _inputs(f: Any, name: str, groups: Mapping[str, hdf5.Group]) -> dict[str, Any]:
    """Read the inputs that a file states; a file without groups has no maneuvers."""
    parameters = _json(f.attrs["parameters"], name)
    found: dict[str, Any] = {"bicycle": {"name": f.attrs["bicycle"], "parameters": parameters}}
    if groups:
        maneuvers = [group.attrs for group in hdf5.of_maneuvers(f, len(f))]
        found["maneuvers"] = [{k: x[k] for k in ("name", *STATE_INPUTS)} for x in maneuvers]
    return found


def _json(raw: str | bytes, name: str) -> Any:
    """Parse JSON without duplicate keys: which of two values is read depends on the reader."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        document = dict(pairs)
        if len(document) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise NotCertifiedError(f"{name}: found the key {twice!r:.60} twice")
        return document

    return json.loads(raw, object_pairs_hook=unique)


def _whole_certificate(files: Mapping[str, bytes], count: int) -> Any:
    """Read certificate.json, and reject statements not proved for this many maneuvers."""
    name = layout.CERTIFICATE
    found = _json(files[name], name)
    # The proofs decide later which of the two statements is right.
    known = (STATEMENT_1_5_0, statement_of(is_decided=False))
    statement = found["statement"] if found.get("statement") in known else STATEMENT
    expected = document({}, files, [], statement=statement)
    for key in found.keys() - expected.keys():
        raise NotCertifiedError(f"{name}: found {key!r:.60}, and nothing proves it")
    for key in ("statement", "proved", "computed", "trusted"):
        if found.get(key) != expected[key]:
            older = "; an older set is certified by the version that made it"
            raise NotCertifiedError(f"{name}: its {key!r} is not what is proved{older}")
    if len(found["maneuvers"]) != count:
        raise NotCertifiedError(
            f"{name}: found {len(found['maneuvers'])} maneuvers, expected {count}"
        )
    return found


def compare_certificate(raw: bytes, proofs: Sequence[Proof]) -> None:
    """Compare certificate.json with the proofs: bounds must cover them, all else must be equal.

    Raises
    ------
    NotCertifiedError
        The certificate claims something else.
    """
    said = json.loads(raw)
    statement = statement_of(is_decided=all(proof.is_decided for proof in proofs))
    if said["statement"] not in (statement, STATEMENT_1_5_0):
        raise NotCertifiedError(f"{layout.CERTIFICATE}: its 'statement' is not what is proved")
    for published, proof in zip(said["maneuvers"], proofs, strict=True):
        found = entry(proof)
        if said["statement"] == STATEMENT_1_5_0:
            del found["integration"]
        _covers(published, found, f"{layout.CERTIFICATE}, {proof.name}")


def _covers(published: Any, proved: Any, where: str) -> None:
    """Check that decimal strings are valid bounds and everything else is equal."""
    if isinstance(proved, dict):
        if not isinstance(published, dict) or set(published) != set(proved):
            raise NotCertifiedError(f"{where}: found other entries than {', '.join(proved)}")
        for key, x in proved.items():
            _covers(published[key], x, f"{where}, {key}")
        return
    bound = _as_bound(proved)
    if bound is not None and (said := _as_bound(published)) is not None and said >= bound:
        return
    if published != proved:
        raise NotCertifiedError(f"{where}: published {published!r:.80}, proved {proved!r}")


BOUND = re.compile(r"[0-9](\.[0-9]+)?e[+-]?[0-9]{1,5}|0(e[+-]?[0-9]{1,5})?")
"""A bound in the notation of a certificate. Longer exponents are rejected, because computing the
fraction could take forever."""


def _as_bound(x: Any) -> Fraction | None:
    return Fraction(x) if isinstance(x, str) and BOUND.fullmatch(x) else None
