"""What is proved about a set: certificate.json, and proving it again from the published files.

Proving again needs the folder and python-flint only: candidate.h5 holds the trajectories, and
everything else follows from them and from the inputs written beside them.
"""

from __future__ import annotations

import hashlib
import io
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import flint
import h5py
import numpy as np

from heyoka_bike import manifest as manifest_file
from heyoka_bike.candidate import read_candidate
from heyoka_bike.certificate import Certificate, certify
from heyoka_bike.columns import COLUMNS
from heyoka_bike.dense import Dense
from heyoka_bike.dense_bound import bound_dense
from heyoka_bike.errors import DatasetError, NotCertifiedError
from heyoka_bike.motion.columns import DENSE_COLUMNS
from heyoka_bike.motion.file import MOTION
from heyoka_bike.motion.integrals import with_integrals
from heyoka_bike.motion.table import MotionTable, bound_motion, motion_expansions, round_motion
from heyoka_bike.parameters import describe_inputs
from heyoka_bike.rounding import hi_lo
from heyoka_bike.rows import Rows, constant_columns, round_rows
from heyoka_bike.trajectory import Trajectory, row_times

CERTIFICATE = "certificate.json"
HDF5 = "uncontrolled-bicycle.h5"

Progress = Callable[[str, float], None]

_NAMES = tuple(c.name for c in COLUMNS)

STATEMENT = (
    "For every maneuver, at every time of the interval, each state variable of the exact motion "
    "differs from the polynomial in candidate.h5 by at most the bound given. Every value of the "
    "rows is the binary64 nearest to the exact one, its _lo the binary64 nearest to the rest, and "
    "the 50-digit text is correctly rounded. The dense output differs from the exact columns by at "
    "most the bounds given, relative to the largest absolute value of the column's rows."
)

TRUSTED = (
    "that the equations of motion in heyoka_bike (modules constants, kinematics, model, outputs) "
    "are those of the Carvallo-Whipple bicycle; the independent Newton-Euler model in the tests "
    "speaks for it",
    "that they conserve the mechanical energy, which is published as its initial value, and that "
    "straight running is a solution",
    "that with an initial steer angle the pitch is the root followed from zero steer (the root "
    "itself is enclosed)",
    "the ball arithmetic of FLINT/Arb, through python-flint",
    "the modules of heyoka_bike that 'certify' imports, and the Python interpreter that runs them",
)
"""What is not proved but assumed. heyoka, its tolerance and its rounding are not among it."""


@dataclass(frozen=True)
class Proof:
    """What was proved about one maneuver.

    Attributes
    ----------
    name : str
    steps, entries, ambiguous : int
        Pieces of the candidate; rounded entries of the rows; those that were not decided.
    states : mapping of str to (Fraction, Fraction)
        Bound over the interval and at its end, by state variable [rad, rad/s].
    dense : mapping of str to Fraction
        Bound of the dense output over the column's scale.
    cpu : float
        Processor time [s].
    """

    name: str
    steps: int
    entries: int
    ambiguous: int
    states: Mapping[str, tuple[Fraction, Fraction]]
    dense: Mapping[str, Fraction]
    cpu: float = 0.0

    @property
    def bound(self) -> Fraction:
        """Largest bound over the interval."""
        return max(x for x, _ in self.states.values())

    @property
    def bound_end(self) -> Fraction:
        """Largest bound at the end."""
        return max(x for _, x in self.states.values())


def summarise(
    run: Trajectory, certificate: Certificate, rows: Rows, dense: Dense, cpu: float = 0.0
) -> Proof:
    """Gather what was proved."""
    worst = [max(column) for column in zip(*certificate.pieces, strict=True)]
    pairs = zip(certificate.states, zip(worst, certificate.end, strict=True), strict=True)
    return Proof(
        name=run.maneuver.name,
        steps=run.steps,
        entries=sum(x.size for x in rows.hi.values()),
        ambiguous=0,
        states=dict(pairs),
        dense={
            name: Fraction(float(x.max())) / Fraction(rows.scales[name] or 1.0)
            for name, x in dense.bound.items()
        },
        cpu=cpu,
    )


def render_certificate(proofs: Sequence[Proof], inputs: Mapping[str, Any]) -> bytes:
    """Bytes of certificate.json."""
    document = {
        "schema_version": 1,
        "statement": STATEMENT,
        "inputs": inputs,
        "maneuvers": [_entry(proof) for proof in proofs],
        "trusted": TRUSTED,
        "software": {"flint": flint.__FLINT_VERSION__, "python-flint": flint.__version__},
    }
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def _entry(proof: Proof) -> dict[str, Any]:
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
        "dense_relative_bounds": {name: decimal_above(x) for name, x in proof.dense.items()},
    }


def decimal_above(x: Fraction) -> str:
    """A short decimal that is not below a nonnegative number."""
    context = Context(prec=3, rounding=ROUND_CEILING, Emin=-99999, Emax=99999)
    return f"{context.divide(Decimal(x.numerator), Decimal(x.denominator)):e}"


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
    inputs = describe_inputs(runs[0].bicycle, [run.maneuver for run in runs])
    try:
        with h5py.File(io.BytesIO(raw[HDF5]), "r") as f:
            content = content_of_file(f)
            groups = [f[f"maneuver_{i}"].attrs for i in range(1, len(f) + 1)]
            stated = {
                "bicycle": {
                    "name": f.attrs["bicycle"], "parameters": json.loads(f.attrs["parameters"]),
                },
                "maneuvers": [{key: g[key] for key in inputs["maneuvers"][0]} for g in groups],
            }  # fmt: skip
        certified = json.loads(raw[CERTIFICATE])["inputs"]
    except (OSError, KeyError, ValueError, TypeError) as e:
        raise DatasetError(f"{folder}: {HDF5} or {CERTIFICATE} cannot be read ({e})") from None
    for name, other in (
        (manifest_file.MANIFEST, manifest.inputs), (HDF5, stated), (CERTIFICATE, certified),
    ):  # fmt: skip
        if other != inputs:
            raise NotCertifiedError(f"{folder}: the inputs in {name} are not those of candidate.h5")
    if content != manifest.content_sha256:
        raise NotCertifiedError(f"{folder}: content_sha256 is not that of the numbers in {HDF5}")
    return runs


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


def prove_again(
    folder: str | Path, run: Trajectory, number: int, progress: Progress | None = None
) -> tuple[Proof, Rows]:
    """Prove one maneuver of a folder from its candidate, and compare with what is published.

    Raises
    ------
    NotCertifiedError
        The candidate is not certified, or a published number or bound is not what was proved.
    """
    report = progress or (lambda stage, t: None)
    start = time.process_time()
    certificate = certify(run, lambda t: report("certify", t))
    rows = round_rows(run, certificate, lambda t: report("rows", t))
    published, bounds = _read_published(folder, number)
    _compare_rows(run, rows, folder, number)
    dense = bound_dense(run, certificate, published, constant_columns(run))
    report("dense", float(run.maneuver.duration))
    _compare_dense(run, dense, bounds)
    if MOTION in manifest_file.read_manifest(folder).files:
        _prove_motion(run, certificate, folder, number)
    report("motion", float(run.maneuver.duration))
    proof = summarise(run, certificate, rows, dense, time.process_time() - start)
    _compare_certificate(folder, number, proof)
    return proof, rows


def _prove_motion(
    run: Trajectory, certificate: Certificate, folder: str | Path, number: int
) -> None:
    """Prove every number of the whole motion, and compare with what is published."""
    stretches = list(with_integrals(run, certificate))
    _compare_rows(run, round_motion(run, stretches), folder, number, MOTION)
    published, bounds = _read_published(folder, number, MOTION, DENSE_COLUMNS)
    parts = list(motion_expansions(stretches))
    _compare_dense(run, bound_motion(run, parts, published), bounds)


def _compare_dense(run: Trajectory, dense: Dense, bounds: Mapping[str, Any]) -> None:
    """No published bound of a dense piece is smaller than what was proved."""
    for name, x in dense.bound.items():
        kept = x <= bounds[name] if x.shape == bounds[name].shape else np.zeros(1, dtype=bool)
        if not kept.all():
            piece = int(np.argmin(kept))
            raise NotCertifiedError(
                f"{run.maneuver.name}: dense {name}, piece {piece + 1}: proved {x[piece]:.3g}, "
                f"published bound {bounds[name].ravel()[piece]:.3g}"
            )


def _read_published(
    folder: str | Path, number: int, file: str = HDF5,
    names: Sequence[str] = _NAMES,
) -> tuple[Dense, Mapping[str, Any]]:  # fmt: skip
    raw = manifest_file.read_file(folder, file, manifest_file.read_manifest(folder))
    try:
        with h5py.File(io.BytesIO(raw), "r") as f:
            group = f[f"maneuver_{number}/dense"]
            dense = Dense(
                breaks=group["breaks"][:],
                hi={n: group[n][:] for n in names},
                lo={n: group[f"{n}_lo"][:] for n in names},
            )
            return dense, {n: group[f"{n}_bound"][:] for n in names}
    except (OSError, KeyError, ValueError) as e:
        raise DatasetError(f"{Path(folder) / file}: is not a reference file ({e})") from None


def _compare_rows(
    run: Trajectory, rows: Rows | MotionTable, folder: str | Path, number: int, file: str = HDF5
) -> None:
    """Every published row: times and values to the bit, bounds not smaller than proved."""
    times = np.array([hi_lo(t, "time") for t in row_times(run.maneuver)])
    exact = {"time": times[:, 0], "time_lo": times[:, 1]}
    exact |= dict(rows.hi) | {f"{name}_lo": x for name, x in rows.lo.items()}
    raw = manifest_file.read_file(folder, file, manifest_file.read_manifest(folder))
    with h5py.File(io.BytesIO(raw), "r") as f:
        group = f[f"maneuver_{number}"]
        for name, x in exact.items():
            stored = _like(group[name][:], x, run, name)
            _all_hold(stored.view("i8") == x.view("i8"), stored, x, run, name)
        for name, x in rows.bound.items():
            stored = _like(group[f"{name}_bound"][:], x, run, f"{name}_bound")
            _all_hold(stored >= x, stored, x, run, f"{name}_bound")


def _like(stored: Any, x: Any, run: Trajectory, name: str) -> Any:
    if stored.dtype != np.float64 or stored.shape != x.shape:
        raise NotCertifiedError(
            f"{run.maneuver.name}: {name}: found {stored.shape} of {stored.dtype}, "
            f"expected {x.shape} of float64"
        )
    return np.ascontiguousarray(stored)


def _all_hold(kept: Any, stored: Any, x: Any, run: Trajectory, name: str) -> None:
    if not kept.all():
        row = int(np.argmin(kept))
        published, proved = float(stored[row]), float(x[row])
        raise NotCertifiedError(
            f"{run.maneuver.name}: {name}, row {row}: published {published!r}, proved {proved!r}"
        )


def _compare_certificate(folder: str | Path, number: int, proof: Proof) -> None:
    """What certificate.json says of a maneuver: no bound smaller than proved, all else equal."""
    raw = manifest_file.read_file(folder, CERTIFICATE, manifest_file.read_manifest(folder))
    try:
        document = json.loads(raw)
        published = document["maneuvers"][number - 1]
    except (ValueError, KeyError, IndexError, TypeError) as e:
        raise DatasetError(f"{Path(folder) / CERTIFICATE}: is not a certificate ({e})") from None
    if document.get("statement") != STATEMENT or document.get("trusted") != list(TRUSTED):
        raise NotCertifiedError(f"{CERTIFICATE}: its statement is not what is proved")
    _covers(published, _entry(proof), f"{CERTIFICATE}, {proof.name}")


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
