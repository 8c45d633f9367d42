"""Check the files of a dataset before its proof: all files are whole and agree on their inputs."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import STATE_INPUTS, describe_inputs
from heyoka_bike.errors import BicycleError, DatasetError, NotCertifiedError, printable
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.reference import form, hdf5, layout, structure
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description import about, describe
from heyoka_bike.reference.layout import STATES, STATES_HDF5
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.proof.certificate import (
    STATEMENT,
    STATEMENT_1_5_0,
    document,
    statement_of,
)


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
        raise DatasetError(f"{folder}: candidate.h5 contains no maneuver")
    maneuvers = [run.maneuver for run in runs]
    inputs = describe_inputs(runs[0].bicycle, maneuvers)
    texts = [text.name for text in layout.text_files(maneuvers)]
    others = {STATES, layout.CERTIFICATE, *describe(manifest), *texts}
    if manifest.dataset_version != manifest_file.CUSTOM:
        # `certify_after` proves these files. Here it is enough that they are known.
        others |= {*layout.AFTER_FILES}
    # Only the structure is compared here, and it does not depend on lengths and texts, so arrays
    # and texts may be empty. The proof compares the undecided entries later.
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
        raise NotCertifiedError(f"{name}: listed in the manifest, but the proof does not cover it")
    stated = {manifest_file.MANIFEST: manifest.inputs}
    try:
        # Check the certificate first, because its error states that the dataset is of an older
        # version.
        stated[layout.CERTIFICATE] = _whole_certificate(raw, len(runs))["inputs"]
        for name, built in layouts.items():
            if name not in raw:
                raise NotCertifiedError(
                    f"{name}: missing in the manifest, although {layout.CERTIFICATE} names it"
                )
            where = Path(folder) / name
            with manifest_file.reading(where, "a file of a set"), hdf5.opened(raw[name]) as f:
                for extra in sorted(_unknown(f, built)):
                    raise NotCertifiedError(
                        f"{name}: found {extra}, which the proof does not cover"
                    )
                stated[name] = _inputs(f, name, built.groups)
        with hdf5.opened(raw[layout.HDF5]) as f:
            content = layout.content_sha256(f)
    except BicycleError:
        raise
    except hdf5.DAMAGE as e:
        reason = f"{type(e).__name__}: {printable(str(e))[:200]}"
        raise DatasetError(f"{folder}: a file of the dataset cannot be read ({reason})") from None
    for name, other in stated.items():
        # states.h5 states no maneuvers, so compare only the inputs that it states.
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
    """Yield the paths of members and attributes of a group that are not declared."""
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
    """Read the inputs that an HDF5 file states; a file without groups has no maneuvers."""
    parameters = _json(f.attrs["parameters"], name)
    found: dict[str, Any] = {"bicycle": {"name": f.attrs["bicycle"], "parameters": parameters}}
    if groups:
        maneuvers = [group.attrs for group in hdf5.of_maneuvers(f, len(f))]
        found["maneuvers"] = [{k: x[k] for k in ("name", *STATE_INPUTS)} for x in maneuvers]
    return found


def _json(raw: str | bytes, name: str) -> Any:
    """Parse JSON, and reject duplicate keys: readers differ in which of two values they use."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        document = dict(pairs)
        if len(document) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise NotCertifiedError(f"{name}: found the key {twice!r:.60} twice")
        return document

    return json.loads(raw, object_pairs_hook=unique)


def _whole_certificate(files: Mapping[str, bytes], count: int) -> Any:
    """Read certificate.json; reject unproved statements, and another number of maneuvers."""
    name = layout.CERTIFICATE
    found = _json(files[name], name)
    # Both statements are accepted here. The proofs later decide which of them is correct.
    known = (STATEMENT_1_5_0, statement_of(is_decided=False))
    statement = found["statement"] if found.get("statement") in known else STATEMENT
    expected = document({}, files, [], statement=statement)
    for key in found.keys() - expected.keys():
        raise NotCertifiedError(f"{name}: found {key!r:.60}, which the proof does not cover")
    for key in ("statement", "proved", "computed", "trusted"):
        if found.get(key) != expected[key]:
            older = "; to certify an older dataset, use the version that made it"
            raise NotCertifiedError(f"{name}: its {key!r} differs from the proved value{older}")
    if len(found["maneuvers"]) != count:
        raise NotCertifiedError(
            f"{name}: found {len(found['maneuvers'])} maneuvers, expected {count}"
        )
    return found
