"""The files of a reference set: their names, how numbers are stored, and the hash of them."""

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
"""Files with proved statements on the benchmark's motions after their ten seconds."""

FILTERS = {"compression": "gzip", "compression_opts": 9, "shuffle": True, "fletcher32": True}


NODES = 32
"""Chebyshev coefficients of a dense piece."""


def as_json(document: Any) -> bytes:
    """Bytes of a document of a set, in the one way in which it is written."""
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def content_sha256(content: Mapping[str, Mapping[str, Any]]) -> str:
    """Hash of the published numbers of the maneuvers, which also an open HDF5 file is a mapping of.

    Of each group the names in order, shapes, and values as little-endian binary64: times, hi and
    lo, and the dense coefficients; not the bounds, nor which rows are not decided.
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
    """One of the text files of a set.

    Attributes
    ----------
    name : str
    numbers : tuple of int
        The maneuvers it holds, from 1.
    is_long : bool
        True if its numbers have 50 digits.
    """

    name: str
    numbers: tuple[int, ...]
    is_long: bool


def text_files(maneuvers: Sequence["Maneuver"]) -> tuple[TextFile, ...]:
    """The text files of a set: for all maneuvers, or one for each that has its own time grid."""
    numbers = tuple(range(1, len(maneuvers) + 1))
    both = ((TEXT, False), (TEXT_50, True))
    if len({(m.rows, m.spacing) for m in maneuvers}) == 1:
        return tuple(TextFile(name, numbers, is_long) for name, is_long in both)
    return tuple(
        TextFile(f"-{i}.".join(name.rsplit(".", 1)), (i,), is_long)
        for name, is_long in both
        for i in numbers
    )
