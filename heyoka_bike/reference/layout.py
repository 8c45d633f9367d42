"""The files of a reference set: their names, how numbers are stored, and the hash of them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

HDF5 = "uncontrolled-bicycle.h5"
TEXT = "uncontrolled-bicycle.txt"
TEXT_50 = "uncontrolled-bicycle-50digits.txt"
CANDIDATE = "candidate.h5"
CERTIFICATE = "certificate.json"
SENSITIVITIES = "sensitivities.h5"
MOTION = "motion.h5"

FILTERS = {"compression": "gzip", "compression_opts": 9, "shuffle": True, "fletcher32": True}


def content_of_file(f: h5py.File) -> str:
    """Hash of the published numbers of a file: times, hi and lo, and the dense coefficients."""
    parts = {}
    for i in range(1, len(f) + 1):
        group = f[f"maneuver_{i}"]
        names = [*(n for n in group if n != "dense"), *(f"dense/{n}" for n in group["dense"])]
        parts[f"maneuver_{i}"] = {
            name: group[name][:]
            for name in names
            if not name.endswith("_bound") and name not in ("dense/piece", "dense/order")
        }
    return content_sha256(parts)


def content_sha256(parts: Mapping[str, Mapping[str, Any]]) -> str:
    """Hash of names, shapes, and values as little-endian binary64, group by group, names sorted."""
    h = hashlib.sha256()
    for group, arrays in parts.items():
        for name in sorted(arrays):
            x = np.ascontiguousarray(arrays[name], dtype="<f8")
            h.update(f"{group}/{name} {x.shape}\n".encode())
            h.update(x.tobytes())
    return h.hexdigest()
