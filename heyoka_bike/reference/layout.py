"""The files of a reference dataset: their names, the storage of numbers, and their hash."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from heyoka_bike.bicycle.parameters import Maneuver

HDF5 = "uncontrolled-bicycle.h5"
TEXT = "uncontrolled-bicycle.txt"
TEXT_50 = "uncontrolled-bicycle-50digits.txt"
CANDIDATE = "candidate.h5"
CERTIFICATE = "certificate.json"
SENSITIVITIES = "sensitivities.h5"
MOTION = "motion.h5"
STATES = "states.csv"
STATES_HDF5 = "states.h5"
AFTER = "after-ten-seconds.json"
CARD = "README.md"
CRATE = "ro-crate-metadata.json"

AFTER_FOLDER = "after-ten-seconds"
AFTER_FILES = (f"{AFTER_FOLDER}/{AFTER}", f"{AFTER_FOLDER}/{CANDIDATE}")
"""Files with proved statements on the benchmark's motions after their first ten seconds."""

FILTERS = {"compression": "gzip", "compression_opts": 9, "shuffle": True, "fletcher32": True}


NODES = 32
"""Number of Chebyshev coefficients of a dense piece."""


def as_json(document: Any) -> bytes:
    """Return the bytes of a JSON document of a dataset, in its canonical form."""
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def content_sha256(content: Mapping[str, Mapping[str, Any]]) -> str:
    """Hash the published numbers of the maneuvers; an open HDF5 file can be passed as well.

    The hash covers each group's names in order, shapes, and values as little-endian binary64:
    times, hi and lo, and the dense coefficients. It does not cover the bounds and the numbers of
    undecided rows.
    """
    h = hashlib.sha256()
    for i in range(1, len(content) + 1):
        group = f"maneuver_{i}"
        for name, array in sorted(_published(content[group])):
            x = np.ascontiguousarray(array[:], dtype="<f8")
            h.update(f"{group}/{name} {x.shape}\n".encode())
            h.update(x.data)
    return h.hexdigest()


def _published(group: Mapping[str, Any], where: str = "") -> Iterator[tuple[str, Any]]:
    for name, item in group.items():
        if isinstance(item, Mapping):
            yield from _published(item, f"{where}{name}/")
        elif not name.endswith(("_bound", "_undecided")) and name not in ("piece", "order"):
            yield where + name, item


@dataclass(frozen=True, slots=True)
class TextFile:
    """A text file of a dataset.

    Attributes
    ----------
    name : str
    numbers : tuple of int
        Numbers of the maneuvers in the file, from 1.
    is_long : bool
        True if the numbers have 50 digits.
    """

    name: str
    numbers: tuple[int, ...]
    is_long: bool


def text_files(maneuvers: Sequence["Maneuver"]) -> tuple[TextFile, ...]:
    """Return the text files of a dataset: one, or one for each maneuver if their times differ."""
    numbers = tuple(range(1, len(maneuvers) + 1))
    both = ((TEXT, False), (TEXT_50, True))
    if len({(m.rows, m.spacing) for m in maneuvers}) == 1:
        return tuple(TextFile(name, numbers, is_long) for name, is_long in both)
    return tuple(
        TextFile(f"-{i}.".join(name.rsplit(".", 1)), (i,), is_long)
        for name, is_long in both
        for i in numbers
    )
