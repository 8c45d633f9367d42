"""candidate.h5: the computed trajectories themselves, as exact integers.

This is what a certificate is about. With it the published digits can be checked, or evaluated anew,
without heyoka and without running anything again.
"""

import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.reference import form, hdf5, structure
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description import about
from heyoka_bike.reference.layout import CANDIDATE


def render(trajectories: Sequence[Trajectory], inputs: Mapping[str, Any], version: str) -> bytes:
    """Bytes of candidate.h5; `inputs` as in the manifest, `version` of the dataset."""
    data = []
    for run in trajectories:
        name = "regular" if run.is_regular else "few_products"
        stated = (json.dumps(run.states), name, run.grid, run.order, run.precision, run.bits)
        breaks = np.array([float(t) for t in run.breaks])
        stored = {"breaks": breaks, "coefficients": _to_bytes(run.pieces)}
        data.append(stored | dict(zip(structure.STATED, stated, strict=True)))
    layout = structure.of_file(CANDIDATE, about(CANDIDATE, inputs, version), inputs, data)
    return hdf5.render(layout, hdf5.by_maneuver(data))


def read_candidate(folder: str | Path) -> tuple[Trajectory, ...]:
    """Trajectories of a reference folder, in the order of its maneuvers.

    Raises
    ------
    DatasetError
        The file is missing, does not match the manifest, or is not a candidate file.
    """
    raw = manifest_file.read_file(folder, CANDIDATE, manifest_file.read_manifest(folder))
    return parse_candidate(raw, Path(folder) / CANDIDATE)


def parse_candidate(raw: bytes, path: Path) -> tuple[Trajectory, ...]:
    """Trajectories of the bytes of a candidate file; `path` is for errors.

    Raises
    ------
    DatasetError
        It is not one.
    """
    with (
        manifest_file.reading(path, "a candidate file"),
        hdf5.opened(raw) as f,
    ):
        bicycle = Bicycle.parse(str(f.attrs["bicycle"]), json.loads(f.attrs["parameters"]))
        return tuple(_read(bicycle, group) for group in hdf5.of_maneuvers(f, len(f)))


def _read(bicycle: Bicycle, group: Any) -> Trajectory:
    texts = {key: str(text) for key, text in group.attrs.items()}
    maneuver = Maneuver.parse(texts["name"], texts)
    for problem in form.problems_of(form.problems_of_candidate, group, maneuver):
        raise ValueError(problem)
    return Trajectory(
        bicycle=bicycle,
        maneuver=maneuver,
        precision=str(group.attrs["precision"]),
        bits=int(group.attrs["precision_bits"]),
        is_regular=group.attrs["form"] == "regular",
        order=int(group.attrs["taylor_order"]),
        grid=int(group.attrs["grid"]),
        breaks=tuple(Fraction(float(t)) for t in group["breaks"][:]),
        pieces=_from_bytes(group["coefficients"][:]),
    )


def _to_bytes(pieces: Sequence[Sequence[Sequence[int]]]) -> Any:
    numbers = [n for piece in pieces for row in piece for n in row]
    width = max(map(int.bit_length, numbers)) // 8 + 1
    raw = b"".join(n.to_bytes(width, "little", signed=True) for n in numbers)
    shape = (len(pieces), len(pieces[0]), len(pieces[0][0]), width)
    return np.frombuffer(raw, dtype=np.uint8).reshape(shape)


def _from_bytes(table: Any) -> tuple[tuple[tuple[int, ...], ...], ...]:
    return tuple(
        tuple(
            tuple(int.from_bytes(n.tobytes(), "little", signed=True) for n in row) for row in piece
        )
        for piece in table
    )
