"""The reference files: from tables to the bytes of each file.

- ``uncontrolled-bicycle.h5``: rows and dense output, hi + lo, as HDF5 that netCDF readers open
- ``uncontrolled-bicycle.txt``: the 25 columns of the benchmark
- ``uncontrolled-bicycle-50digits.txt``: the same with 50 significant digits
- ``candidate.h5``: the trajectories themselves, as exact integers
- ``certificate.json``: what is proved
- ``sensitivities.h5``: derivatives of every column with respect to parameters and start
- ``motion.h5``: the whole configuration and all forces, hi + lo
- ``manifest.json``
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import h5py

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, describe_inputs
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.numbers.exact import shortest_decimal
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.layout import (
    CANDIDATE,
    CERTIFICATE,
    HDF5,
    MOTION,
    SENSITIVITIES,
    TEXT,
    TEXT_50,
    content_sha256,
)
from heyoka_bike.reference.making import motion_file, sensitivities_file
from heyoka_bike.reference.making.hdf5_groups import content_parts, write_dense, write_rows
from heyoka_bike.reference.making.tabulate import Table
from heyoka_bike.reference.proof import candidate
from heyoka_bike.reference.proof.certificate_file import render_certificate, summarise
from heyoka_bike.reference.proof.rows import TEXT_DIGITS, RoundedRows


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
    content = _content(tables)
    inputs = describe_inputs(bicycle, [t.maneuver for t in tables])
    files = {
        HDF5: _hdf5(tables, inputs, manifest_file.values_version(dataset_version), content),
        CANDIDATE: candidate.render([t.trajectory for t in tables], inputs),
        **render_texts([t.maneuver for t in tables], [t.rows for t in tables]),
        CERTIFICATE: render_certificate(
            [summarise(t.trajectory, t.certificate, t.rows, t.dense) for t in tables], inputs
        ),
        SENSITIVITIES: sensitivities_file.render([t.sensitivity for t in tables], inputs),
        MOTION: motion_file.render(tables, inputs),
    }
    document = manifest_file.render(
        dataset_version=dataset_version,
        content_sha256=content,
        inputs=inputs,
        made_by={"digits": digits, "packages": _packages()},
        files=files,
    )
    return manifest_file.write_set(folder, files, document)


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


def _content(tables: Sequence[Table]) -> str:
    return content_sha256(
        {
            f"maneuver_{i}": content_parts((t.time, t.time_lo), t.rows, t.dense)
            for i, t in enumerate(tables, start=1)
        }
    )


def _packages() -> dict[str, str]:
    found = {}
    for name in ("heyoka_bike", "heyoka", "python-flint", "h5py", "numpy", "mpmath"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def _hdf5(
    tables: Sequence[Table], inputs: Mapping[str, Any], dataset_version: str, content: str
) -> bytes:
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        f.attrs["title"] = "Reference solution of the multibody benchmark Uncontrolled bicycle"
        f.attrs["Conventions"] = "CF-1.8"
        f.attrs["dataset_version"] = dataset_version
        f.attrs["content_sha256"] = content
        f.attrs["bicycle"] = inputs["bicycle"]["name"]
        f.attrs["parameters"] = json.dumps(inputs["bicycle"]["parameters"])
        f.attrs["comment"] = (
            "Each value is the correctly rounded exact one; <name>_lo is the exact value minus it, "
            "so <name> + <name>_lo has 32 digits. Axes: x forward, y right, z down."
        )
        for i, table in enumerate(tables, start=1):
            group = f.create_group(f"maneuver_{i}", track_order=True)
            group.attrs["name"] = table.maneuver.name
            for key, text in inputs["maneuvers"][i - 1].items():
                if key != "name":
                    group.attrs[key] = text
            write_rows(group, (table.time, table.time_lo), table.rows, COLUMNS)
            write_dense(group.create_group("dense", track_order=True), table.dense, COLUMNS)
    return buffer.getvalue()


def render_texts(maneuvers: Sequence[Maneuver], rows: Sequence[RoundedRows]) -> dict[str, bytes]:
    """The text files: one of 25 columns, or one of 9 for each maneuver on a grid of its own."""
    pairs = list(zip(maneuvers, rows, strict=True))
    grids = {(m.rows, m.spacing) for m in maneuvers}
    groups = {"": pairs} if len(grids) == 1 else {f"-{i + 1}": [p] for i, p in enumerate(pairs)}
    files = {}
    for tag, group in groups.items():
        first = group[0][0]
        times = [shortest_decimal(first.time(i), TEXT_DIGITS) for i in range(first.rows)]
        short = [[f"{x:.17g}" for x in r.hi[name]] for _, r in group for name in BENCHMARK_COLUMNS]
        long = [r.text[name] for _, r in group for name in BENCHMARK_COLUMNS]
        for file, columns in ((TEXT, short), (TEXT_50, long)):
            stem, _, suffix = file.rpartition(".")
            lines = (" ".join(row) for row in zip(times, *columns, strict=True))
            files[f"{stem}{tag}.{suffix}"] = ("\n".join(lines) + "\n").encode()
    return files
