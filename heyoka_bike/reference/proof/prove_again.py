"""Certification of a set: prove again, from the published files, all that certificate.json names.

Proving again needs the folder and python-flint only: candidate.h5 holds the trajectories, and
everything else follows from them and from the inputs written beside them.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.parameters import STATE_INPUTS, describe_inputs
from heyoka_bike.errors import DatasetError, NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Drift, Trajectory, evaluator
from heyoka_bike.reference import hdf5, layout, structure
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description.describe import describe
from heyoka_bike.reference.hdf5 import BOUND, LOW, SCALE_ATTRIBUTES, Group, of_maneuvers, whole_file
from heyoka_bike.reference.load import ReferenceManeuver, load_motion, load_reference
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.proof.certificate_file import (
    COMPUTED,
    STATEMENT,
    STATEMENT_1_5_0,
    TRUSTED,
    Proof,
    entry,
    proved,
    summarise,
)
from heyoka_bike.reference.proof.dense import bound_dense
from heyoka_bike.reference.proof.enclose import enclosed
from heyoka_bike.reference.proof.instants import states_differ
from heyoka_bike.reference.proof.motion_rows import (
    bound_motion,
    motion_expansions,
    round_motion,
    with_integrals,
)
from heyoka_bike.reference.proof.rows import (
    EVALUATION_BITS,
    constant_columns,
    render_texts,
    round_rows,
    rounded_times,
)
from heyoka_bike.reference.proof.sensitivity_rows import differentiate
from heyoka_bike.reference.sensitivities import Sensitivity, load_sensitivities
from heyoka_bike.reference.structure import COLUMNS_OF, numbers_of_derivatives, with_tags
from heyoka_bike.reference.values import Dense, RoundedRows, Values
from heyoka_bike.system.jobs import Job, Report
from heyoka_bike.system.parallel import Progress, all_of
from heyoka_bike.system.resources import reference_folder

_DENSE = "dense"


def certify(
    folder: str | Path | None = None, *, progress: Progress | None = None
) -> tuple[Proof, ...]:
    """Prove a reference set again, from its candidate trajectories: all that its certificate names.

    As ``heyoka-bike certify`` does, in ball arithmetic; heyoka is not needed. A script that calls
    it has to guard itself by ``if __name__ == "__main__"``: parts of the proof get processes of
    their own, or what `using` says.

    Parameters
    ----------
    folder
        The set; by default the published one that comes with the package.
    progress
        Called with the name of a maneuver, the stage of the proof (``waiting``, ``certify``,
        ``rows``, ``dense``, ``motion``) and the share of that stage that is done, 0 to 1.

    Returns
    -------
    tuple of Proof
        Proved facts by maneuver.

    Raises
    ------
    NotCertifiedError
        A candidate is not certified, something published is not what was proved, or there is
        something that nothing proves.
    UndecidedError
        The candidate does not decide how a value is rounded.
    DatasetError
        A file is missing, damaged, or not that of a reference set.
    """
    where = reference_folder() if folder is None else folder
    if folder is None:
        manifest_file.check_published(where)
    runs = read_whole(where)
    jobs = _jobs(where, runs)
    found = all_of([job for stage in zip(*jobs, strict=True) for job in stage], progress)
    proofs, proved_rows = [], []
    for number, (run, parts) in enumerate(zip(runs, jobs, strict=True), start=1):
        certificate, sensitivity, motion, columns = (found[job].value for job in parts)
        (rows, dense, drift), (motion_rows, motion_dense) = columns, motion
        cpu = sum(found[job].seconds for job in parts)
        proof = summarise(
            run, certificate, rows, dense, motion_rows, motion_dense, sensitivity, drift, cpu
        )
        _compare_certificate(where, number, proof)
        proofs.append(proof)
        proved_rows.append(rows)
    manifest = manifest_file.read_manifest(where)
    for name in (layout.STATES, layout.STATES_HDF5):
        if name in manifest.files:
            raw = manifest_file.read_file(where, name, manifest)
            for problem in states_differ(name, raw, runs[0].bicycle):
                raise NotCertifiedError(f"{where}/{name}: {problem}")
    for name, data in render_texts([run.maneuver for run in runs], proved_rows).items():
        if manifest_file.read_file(where, name, manifest) != data:
            raise NotCertifiedError(f"{where}/{name}: differs from the proved values")
    return tuple(proofs)


def _jobs(folder: str | Path, runs: Sequence[Trajectory]) -> list[tuple[Job, ...]]:
    """Of each maneuver the proof of its bound, and of all that follows from it."""
    published = zip(
        runs, load_reference(folder).values(), load_motion(folder).values(),
        load_sensitivities(folder).values(), strict=True,
    )  # fmt: skip
    found: list[tuple[Job, ...]] = []
    for run, reference, motion, sensitivity in published:
        named = run.maneuver.name, float(run.maneuver.duration)
        bound = Job(enclosed, (run,), *named, ("certify",))
        found.append((
            bound,
            Job(_varied, (run, bound, sensitivity), *named, ("vary",)),
            Job(_moved, (run, bound, motion), *named, ("motion",)),
            Job(_rounded, (run, bound, reference), *named, ("rows", "dense")),
        ))  # fmt: skip
    return found


def read_whole(folder: str | Path) -> tuple[Trajectory, ...]:
    """Trajectories of a set whose files are all whole and speak of the same inputs.

    Raises
    ------
    DatasetError
        A file is missing or does not match the manifest.
    NotCertifiedError
        The files do not agree on the bicycle or the maneuvers.
    """
    manifest = manifest_file.read_manifest(folder)
    raw = {name: manifest_file.read_file(folder, name, manifest) for name in manifest.files}
    runs = read_candidate(folder)
    if not runs:
        raise DatasetError(f"{folder}: candidate.h5 holds no maneuver")
    maneuvers = [run.maneuver for run in runs]
    inputs = describe_inputs(runs[0].bicycle, maneuvers)
    about, texts = describe(manifest), [text.name for text in layout.text_files(maneuvers)]
    layouts, stated = _layouts(inputs), {manifest_file.MANIFEST: manifest.inputs}
    others = {layout.STATES, layout.CERTIFICATE, *COMPUTED, *about}
    if manifest.dataset_version != manifest_file.CUSTOM:
        # Proved by `certify_after`.
        others |= {*layout.AFTER_FILES}
    if layout.STATES_HDF5 in raw:
        layouts[layout.STATES_HDF5] = structure.states(inputs, "", 0)
    for name in raw.keys() - {*layouts, *texts, *others}:
        raise NotCertifiedError(f"{name}: found in the manifest, and nothing proves it")
    try:
        # First: of an older set it says so.
        stated[layout.CERTIFICATE] = _whole_certificate(raw, len(runs))["inputs"]
        for name, built in layouts.items():
            if name not in raw:
                raise NotCertifiedError(
                    f"{name}: not in the manifest, expected what {layout.CERTIFICATE} names"
                )
            with hdf5.opened(raw[name]) as f:
                for extra in sorted(_unknown(f, built)):
                    raise NotCertifiedError(f"{name}: found {extra}, and nothing proves it")
                stated[name] = _inputs(f, name, built.groups)
        with hdf5.opened(raw[layout.HDF5]) as f:
            content = layout.content_sha256(f)
    except (OSError, KeyError, ValueError, TypeError) as e:
        raise DatasetError(f"{folder}: a file of the set cannot be read ({e})") from None
    for name, other in stated.items():
        about_all = {"bicycle": inputs["bicycle"]} if name == layout.STATES_HDF5 else inputs
        if other != about_all:
            raise NotCertifiedError(f"{folder}: the inputs in {name} are not those of candidate.h5")
    if content != manifest.content_sha256:
        raise NotCertifiedError(
            f"{folder}: content_sha256 is not that of the numbers in {layout.HDF5}"
        )
    return runs


def _layouts(inputs: Mapping[str, Any]) -> dict[str, Group]:
    """Return the layouts of the HDF5 files of a set by name; lengths and texts do not count."""
    own = inputs["maneuvers"][0]
    groups = {
        name: structure.of_columns(name, own, columns, {}) for name, columns in COLUMNS_OF.items()
    }
    groups[layout.CANDIDATE] = structure.trajectory(own, dict.fromkeys(structure.STATED, 0), {})
    found = {}
    for name, group in groups.items():
        content = None if name == layout.CANDIDATE else ""
        about = structure.about(name, inputs, "", content)
        found[name] = whole_file(about, [group] * len(inputs["maneuvers"]))
    return found


def _unknown(item: Any, declared: Group, where: str = "") -> Iterator[str]:
    """Paths of what a group has and is not declared, attributes included."""
    yield from (f"{where}{name}" for name in item if name not in declared.members)
    yield from (
        f"attribute {where}{name}" for name in item.attrs if name not in declared.attributes
    )
    for dataset in declared.datasets:
        known = dataset.attributes.keys() | SCALE_ATTRIBUTES
        attributes = item[dataset.name].attrs if dataset.name in item else ()
        yield from (f"attribute {where}{dataset.name}/{x}" for x in attributes if x not in known)
    for name, inner in declared.groups.items():
        if name in item:
            yield from _unknown(item[name], inner, f"{where}{name}/")


def _inputs(f: Any, name: str, groups: Mapping[str, Group]) -> dict[str, Any]:
    """Read the inputs that a file states; a file without groups has no maneuvers."""
    parameters = _json(f.attrs["parameters"], name)
    found: dict[str, Any] = {"bicycle": {"name": f.attrs["bicycle"], "parameters": parameters}}
    if groups:
        maneuvers = [group.attrs for group in of_maneuvers(f, len(f))]
        found["maneuvers"] = [{k: x[k] for k in ("name", *STATE_INPUTS)} for x in maneuvers]
    return found


def _json(raw: str | bytes, name: str) -> Any:
    """A document in which no key is there twice: what is read of it depends on the reader."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        document = dict(pairs)
        if len(document) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise NotCertifiedError(f"{name}: found the key {twice!r:.60} twice")
        return document

    return json.loads(raw, object_pairs_hook=unique)


def _whole_certificate(files: Mapping[str, bytes], count: int) -> Any:
    """Read certificate.json, and refuse what is not proved of so many maneuvers."""
    document = _json(files[layout.CERTIFICATE], layout.CERTIFICATE)
    is_before_2 = document.get("statement") == STATEMENT_1_5_0
    claims: dict[str, Any] = {
        "statement": STATEMENT_1_5_0 if is_before_2 else STATEMENT,
        "proved": proved(files, COLUMNS_OF),
        "computed": dict(COMPUTED),
        "trusted": list(TRUSTED),
    }
    others = {"schema_version", "inputs", "maneuvers", "software"}
    for key in document.keys() - claims.keys() - others:
        raise NotCertifiedError(f"{layout.CERTIFICATE}: found {key!r:.60}, and nothing proves it")
    for key, said in claims.items():
        if document.get(key) != said:
            older = "; an older set is certified by the version that made it"
            raise NotCertifiedError(
                f"{layout.CERTIFICATE}: its {key!r} is not what is proved{older}"
            )
    if len(document["maneuvers"]) != count:
        raise NotCertifiedError(
            f"{layout.CERTIFICATE}: found {len(document['maneuvers'])} maneuvers, expected {count}"
        )
    return document


def _rounded(
    run: Trajectory, certificate: Certificate, published: ReferenceManeuver, report: Report
) -> tuple[RoundedRows, Dense, Drift]:
    """Every number of the columns, and what the run itself keeps."""
    rows = round_rows(run, certificate, lambda t: report("rows", t))
    _compare_rows(run, rows, published)
    dense = bound_dense(run, certificate, published.dense, constant_columns(run))
    _compare(run, with_tags(dense), with_tags(published.dense), _DENSE)
    return rows, dense, evaluator(run, run.bits + EVALUATION_BITS).drift()


def _moved(
    run: Trajectory, certificate: Certificate, published: ReferenceManeuver, report: Report
) -> tuple[Values, Dense]:
    """Every number of the whole motion."""
    stretches = list(with_integrals(run, certificate))
    rows = round_motion(run, stretches)
    _compare_rows(run, rows, published)
    dense = bound_motion(run, list(motion_expansions(stretches)), published.dense)
    _compare(run, with_tags(dense), with_tags(published.dense), _DENSE)
    return rows, dense


def _varied(
    run: Trajectory, certificate: Certificate, published: Sensitivity, report: Report
) -> Sensitivity:
    """Every number of the derivatives."""
    sensitivity = differentiate(run, certificate, lambda t: report("vary", t))
    proved, stored = map(numbers_of_derivatives, (sensitivity, published))
    _compare(run, proved, stored, "derivatives")
    return sensitivity


def _compare_rows(run: Trajectory, rows: Values, published: ReferenceManeuver) -> None:
    time, time_lo = rounded_times(run.maneuver)
    stored = {"time": published.time, "time_lo": published.time_lo, **with_tags(published.rows)}
    _compare(run, {"time": time, "time_lo": time_lo, **with_tags(rows)}, stored)


def _compare(
    run: Trajectory, proved: Mapping[str, Any], published: Mapping[str, Any], inside: str = ""
) -> None:
    """Every published number to the bit, but NaN; no bound smaller than proved or infinite.

    Both are arrays by the names of their datasets, in groups by name; `inside` says of what.
    """
    for name, right in proved.items():
        if isinstance(right, dict):
            _compare(run, right, published[name], f"{name} of {inside}")
            continue
        where, found = f"{run.maneuver.name}: {_in_words(name, inside)}", published.get(name)
        if found is None:
            raise NotCertifiedError(f"{where}: not in the file")
        if found.dtype != np.float64 or found.shape != right.shape:
            raise NotCertifiedError(
                f"{where}: found {found.shape} of {found.dtype}, expected {right.shape} of float64"
            )
        found, right = np.ascontiguousarray(found), np.ascontiguousarray(right)
        kept = found.view("i8") == right.view("i8")
        if name.endswith(BOUND):
            kept = (found >= right) & np.isfinite(found)
        kept |= np.isnan(found) & np.isnan(right)
        if not kept.all():
            place = np.unravel_index(int(np.argmin(kept)), kept.shape)
            # Pieces are counted from 1.
            at = ", ".join(str(i + (inside == _DENSE)) for i in place)
            raise NotCertifiedError(
                f"{where} {at}: published {float(found[place])!r}, proved {float(right[place])!r}"
            )


def _in_words(name: str, inside: str) -> str:
    """Return the name of a dataset in words, up to the index in it."""
    stem = name.removesuffix(LOW).removesuffix(BOUND)
    if inside == _DENSE:
        return f"{inside} {stem}, piece"
    if not inside:
        return f"{name}, row"
    if name in ("breaks", "time"):
        return f"{name} of the derivatives, row"
    bound = "bound of the " if name.endswith(BOUND) else ""
    return f"{bound}{inside} of {stem}, row"


def _compare_certificate(folder: str | Path, number: int, proof: Proof) -> None:
    """Compare certificate.json with the proof: no bound smaller than proved, all else equal."""
    raw = manifest_file.read_file(folder, layout.CERTIFICATE, manifest_file.read_manifest(folder))
    document, found = json.loads(raw), entry(proof)
    if document["statement"] == STATEMENT_1_5_0:
        del found["integration"]
    _covers(document["maneuvers"][number - 1], found, f"{layout.CERTIFICATE}, {proof.name}")


def _covers(published: Any, proved: Any, where: str) -> None:
    """Decimal strings are bounds; everything else must be the same."""
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


def _as_bound(x: Any) -> Fraction | None:
    try:
        return Fraction(x) if isinstance(x, str) else None
    except (ValueError, ZeroDivisionError):
        return None
