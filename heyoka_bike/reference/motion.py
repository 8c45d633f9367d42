"""motion.h5: the whole configuration and all forces of the reference, and reading them.

How they are computed is in `table`; reading and evaluating needs NumPy and h5py only.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import h5py

from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.layout import MOTION
from heyoka_bike.reference.load import Numbered, ReferenceManeuver, Time, Values, read_maneuver

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, eq=False, repr=False)
class MotionManeuver(ReferenceManeuver):
    """The whole motion of one maneuver; ``maneuver["com_z"]`` are the values at its rows.

    Rows are of all columns (`columns.MOTION_COLUMNS`), dense output of some
    (`columns.DENSE_COLUMNS`). The attributes are those of a `ReferenceManeuver`.
    """

    def __getitem__(self, name: str) -> Array:
        return self.rows[name]

    def evaluate(self, t: Time, columns: Sequence[str] | str | None = None) -> Values:
        """Columns that have dense output (by default all such), at any time of the run.

        Times, and what comes back, are as for `ReferenceManeuver.evaluate`.

        Raises
        ------
        InputError
            A time outside the run, not a number, or a column without dense output.
        """
        names = (columns,) if isinstance(columns, str) else columns
        chosen = tuple(self.dense.hi) if names is None else tuple(names)
        for name in chosen:
            if name in self.rows.hi and name not in self.dense.hi:
                raise InputError(
                    f"{name}: has values at the rows only; dense output have "
                    f"{', '.join(self.dense.hi)}"
                )
        return super().evaluate(t, chosen)


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Numbered[MotionManeuver]):
    """The whole motion of all maneuvers of a set; ``motion[2]`` is its second.

    Attributes
    ----------
    maneuvers : tuple of MotionManeuver
    content_sha256 : str
        Hash of the numbers.
    folder : Path
        Where it was loaded from.
    """

    maneuvers: tuple[MotionManeuver, ...]
    content_sha256: str
    folder: Path

    def __repr__(self) -> str:
        return f"<whole motion of {len(self)} maneuvers>"


def load_motion(folder: str | Path | None = None) -> Motion:
    """Load the whole motion of a reference set, by default of the published one.

    Parameters
    ----------
    folder : path, optional
        Folder of the set.

    Returns
    -------
    Motion

    Raises
    ------
    DatasetError
        The set has none, or the file is damaged.
    """
    where, manifest, raw = manifest_file.load_file(folder, MOTION)
    units = {c.name: c.unit for c in MOTION_COLUMNS}
    try:
        f = h5py.File(io.BytesIO(raw), "r")
        groups = [f[f"maneuver_{i}"] for i in range(1, len(manifest.inputs["maneuvers"]) + 1)]
        maneuvers = tuple(
            MotionManeuver(**read_maneuver(group, tuple(units), DENSE_COLUMNS, units))
            for group in groups
        )
        return Motion(maneuvers, str(f.attrs["content_sha256"]), where)
    except (OSError, KeyError, ValueError) as e:
        raise DatasetError(f"{where / MOTION}: is not a file of a whole motion ({e})") from None
