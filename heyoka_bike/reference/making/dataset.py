"""The reference files: from tables to the bytes of each file.

- ``uncontrolled-bicycle.h5``: rows and dense output, hi + lo, as HDF5 that netCDF readers open
- ``uncontrolled-bicycle.txt``: the 25 columns of the benchmark
- ``uncontrolled-bicycle-50digits.txt``: the same with 50 significant digits
- ``candidate.h5``: the trajectories themselves, as exact integers
- ``certificate.json``: what is proved
- ``sensitivities.h5``: derivatives of every column with respect to parameters and start
- ``motion.h5``: the whole configuration and all forces, hi + lo
- ``states.csv``, ``states.h5``: all quantities of the known states of the benchmark's bicycle
- ``after-ten-seconds/``: of the published set, what is proved of its motions later
- ``README.md``, ``ro-crate-metadata.json``: what the published set is, for people and machines
- ``manifest.json``
"""

import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import Bicycle, benchmark, describe_inputs
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.reference import layout
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description.describe import describe
from heyoka_bike.reference.hdf5 import by_maneuver, render, whole_file
from heyoka_bike.reference.making.tabulate import Table
from heyoka_bike.reference.proof import candidate
from heyoka_bike.reference.proof.certificate_file import render_certificate, summarise
from heyoka_bike.reference.proof.instants import render_states
from heyoka_bike.reference.proof.rows import render_texts
from heyoka_bike.reference.structure import (
    COLUMNS_OF,
    about,
    numbers_of_derivatives,
    numbers_of_table,
    of_columns,
)
from heyoka_bike.system.machine import PACKAGES, installed
from heyoka_bike.system.resources import reference_folder


def write_dataset(
    folder: str | Path, bicycle: Bicycle, tables: Sequence[Table], digits: int,
    dataset_version: str,
) -> list[str]:  # fmt: skip
    """Write the set into a folder; returns the names of the files that changed.

    Raises
    ------
    DatasetError
        The folder cannot be written.
    """
    inputs = describe_inputs(bicycle, [t.maneuver for t in tables])
    hdf5_version = manifest_file.hdf5_version(dataset_version)
    files, hashes = render_hdf5(tables, inputs, hdf5_version)
    files |= {
        layout.CANDIDATE: candidate.render([t.trajectory for t in tables], inputs, hdf5_version),
        **render_texts([t.maneuver for t in tables], [t.rows for t in tables]),
    }
    if bicycle.values == benchmark()[0].values:
        files |= render_states(bicycle, inputs, hdf5_version)
    proofs = [
        summarise(
            t.trajectory, t.certificate, t.rows, t.dense, t.motion_rows, t.motion_dense,
            t.sensitivity, t.drift,
        )
        for t in tables
    ]  # fmt: skip
    files[layout.CERTIFICATE] = render_certificate(proofs, inputs, files)
    if dataset_version != manifest_file.CUSTOM:
        files |= _after(Path(folder))
    manifest_of = partial(
        manifest_file.render,
        dataset_version=dataset_version,
        content_sha256=hashes[layout.HDF5],
        inputs=inputs,
        made_by={"digits": digits, "packages": _packages()},
    )
    files |= describe(manifest_file.parse(manifest_of(files=files)))
    return manifest_file.write_set(folder, files, manifest_of(files=files))


def render_hdf5(
    tables: Sequence[Table], inputs: Mapping[str, Any], version: str
) -> tuple[dict[str, bytes], dict[str, str]]:
    """The HDF5 files of the columns, and the hashes of their numbers, both by name.

    Parameters
    ----------
    tables
    inputs
        As in the manifest.
    version
        The one that last changed these files.
    """
    files, hashes = {}, {}
    for name, numbers in {
        layout.HDF5: [numbers_of_table(t.time, t.time_lo, t.rows, t.dense) for t in tables],
        layout.SENSITIVITIES: [numbers_of_derivatives(t.sensitivity) for t in tables],
        layout.MOTION: [
            numbers_of_table(t.time, t.time_lo, t.motion_rows, t.motion_dense) for t in tables
        ],
    }.items():
        data = by_maneuver(numbers)
        hashes[name] = layout.content_sha256(data)
        groups = [
            of_columns(name, own, COLUMNS_OF[name], stored)
            for own, stored in zip(inputs["maneuvers"], numbers, strict=True)
        ]
        root = about(name, inputs, version, hashes[name])
        files[name] = render(whole_file(root, groups), data)
    return files, hashes


def _after(folder: Path) -> dict[str, bytes]:
    """Read the files after ten seconds, from the folder or else from the package."""
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
    """Refuse to replace a set of another version or of other inputs.

    Raises
    ------
    InputError
        The folder holds such a set and `force` is not given, or it cannot be written.
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
            f"{folder}: holds dataset version {present.dataset_version}, this run makes "
            f"{dataset_version}; use --force to replace it, or another --out"
        )
    if present.inputs != inputs:
        raise InputError(
            f"{folder}: holds a set of another bicycle or other maneuvers; "
            "use --force to replace it, or another --out"
        )


def _packages() -> dict[str, str]:
    return {name: installed(name) or "unknown" for name in ("heyoka_bike", *PACKAGES)}
