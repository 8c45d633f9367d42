"""Whether the files of a reference folder are built as docs/files.md says, before they are used.

Every function yields problems, each in words. They take bytes, of which nothing is believed but
that they are what the manifest says; shapes are compared before anything is read.
"""

import io
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

import h5py
import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.equations.kinematics import state_names
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference import structure
from heyoka_bike.reference.hdf5 import INDEX, Dataset, Group, by_maneuver
from heyoka_bike.reference.layout import content_sha256
from heyoka_bike.reference.manifest import MANIFEST, Manifest, hdf5_version
from heyoka_bike.reference.proof.certificate_file import COMPUTED, PROVED, STATEMENT, TRUSTED
from heyoka_bike.reference.proof.rows import TEXT_DIGITS
from heyoka_bike.reference.sensitivities import ROWS_APART, read_group
from heyoka_bike.reference.structure import STATED
from heyoka_bike.reference.texts import TextFile

DAMAGE = (
    OSError, ArithmeticError, AttributeError, LookupError, MemoryError, RuntimeError, TypeError,
    ValueError,
)  # fmt: skip
"""What h5py, json and the rest raise for bytes that are not what they should be: nearly all."""

# Sensitivities are multiples of 2^-50 of their scale, rounded up to a power of two: three of them.
_GRID = 3 * 2.0**-50

# Of evaluating 24 coefficients in binary64, relative to the largest.
_ROUNDOFF = 2.0**-47

# Set by HDF5's dimension scales.
_SCALE_ATTRIBUTES = {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"}
_NUMBER_50 = re.compile(rf"-?[1-9]\.[0-9]{{{TEXT_DIGITS - 1}}}e[+-](0|[1-9][0-9]*)|0")
_ENTRY = (
    "maneuver", "steps", "entries", "ambiguous", "bound", "bound_end", "state_bounds",
    "dense_relative_bounds", "motion", "sensitivities",
)  # fmt: skip
_STATES = {
    form: [*state_names(is_regular), "yaw"]
    for form, is_regular in (("few_products", False), ("regular", True))
}
"""Variables of the candidate by the form of the equations."""
_BOUND = re.compile(r"[0-9](\.[0-9]+)?e[+-]?[0-9]{1,5}|0(e[+-]?[0-9]{1,5})?")
_TIME = re.compile(r"(0|[1-9][0-9]*)(\.[0-9]*[1-9])?")


@dataclass(frozen=True, slots=True)
class Text:
    """A text file: its numbers as they are written, by maneuver and column."""

    file: TextFile
    columns: Mapping[tuple[int, str], tuple[str, ...]]


class _UnusableError(Exception):
    """A problem after which there is no use in looking further; its text says which."""


def problems_of(look: Callable[..., Iterator[str]], *arguments: Any) -> list[str]:
    """The problems that are found, or that the file cannot be read."""
    found: list[str] = []
    try:
        found.extend(look(*arguments))
    except _UnusableError as e:
        found.append(str(e))
    except DAMAGE as e:
        found.append(f"cannot be read ({type(e).__name__}: {' '.join(str(e).split()):.200})")
    return found


def of_hdf5(raw: bytes, manifest: Manifest, maneuvers: Sequence[Maneuver]) -> Iterator[str]:
    """Problems of the file of rows and dense output."""
    version = hdf5_version(manifest.dataset_version)
    about = structure.about_reference(manifest.inputs, version, manifest.content_sha256)
    with h5py.File(io.BytesIO(raw), "r") as f:
        yield from _groups(f, about, partial(_table, columns=COLUMNS), manifest, maneuvers)


def of_motion(raw: bytes, manifest: Manifest, maneuvers: Sequence[Maneuver]) -> Iterator[str]:
    """Problems of the file of the whole motion; its hash must be that of its numbers."""
    with h5py.File(io.BytesIO(raw), "r") as f:
        version = hdf5_version(manifest.dataset_version)
        about = structure.about_motion(manifest.inputs, version, content_sha256(f))
        yield from _groups(f, about, partial(_table, columns=MOTION_COLUMNS), manifest, maneuvers)


def of_candidate(raw: bytes, manifest: Manifest, maneuvers: Sequence[Maneuver]) -> Iterator[str]:
    """Problems of the file of trajectories."""
    about = structure.about_candidate(manifest.inputs, hdf5_version(manifest.dataset_version))
    with h5py.File(io.BytesIO(raw), "r") as f:
        yield from _groups(f, about, _trajectory, manifest, maneuvers)


def of_sensitivities(
    raw: bytes, manifest: Manifest, maneuvers: Sequence[Maneuver]
) -> Iterator[str]:
    """Problems of the file of sensitivities: the structure, the hash, and sums of the energies."""
    with h5py.File(io.BytesIO(raw), "r") as f:
        said = f.attrs["content_sha256"]
        version = hdf5_version(manifest.dataset_version)
        about = structure.about_sensitivities(manifest.inputs, version, said)
        yield from _groups(f, about, _sensitivity, manifest, maneuvers)
        if said != content_sha256(f):
            yield "attribute content_sha256: is not that of the numbers"


def _groups(
    f: h5py.File, about: Mapping[str, str], look: Callable[..., Iterator[str]],
    manifest: Manifest, maneuvers: Sequence[Maneuver],
) -> Iterator[str]:  # fmt: skip
    """Problems of a file that has a group for each maneuver, each of which `look` looks at."""
    yield from _attributes(f, about)
    groups = by_maneuver(zip(maneuvers, manifest.inputs["maneuvers"], strict=True))
    yield from _names(f, list(groups))
    if set(f) == set(groups):
        for name, (maneuver, inputs) in groups.items():
            yield from look(f[name], maneuver, inputs)


def content_differs(raw: bytes, manifest: Manifest, _: Sequence[Maneuver]) -> Iterator[str]:
    """A content_sha256 that is not that of the numbers."""
    with h5py.File(io.BytesIO(raw), "r") as f:
        found = content_sha256(f)
    if found != manifest.content_sha256:
        yield (
            f"the numbers have content_sha256 {found[:12]}..., the manifest says "
            f"{manifest.content_sha256:.12}..."
        )


def _table(
    group: Any, maneuver: Maneuver, inputs: Mapping[str, Any], *, columns: Sequence[Column]
) -> Iterator[str]:
    pieces = _pieces(group, "dense/breaks")
    yield from _group(group, structure.table(inputs, columns, maneuver.rows, pieces))
    yield from _increase(group["dense/breaks"])


def _sensitivity(group: Any, maneuver: Maneuver, inputs: Mapping[str, Any]) -> Iterator[str]:
    first = COLUMNS[0].name
    orders = group[first].shape[1] if first in group else 0
    rows = len(range(0, maneuver.rows, ROWS_APART))
    pieces = _pieces(group, "breaks")
    yield from _group(group, structure.sensitivity(inputs, COLUMNS, pieces, orders, rows))
    yield from _increase(group["breaks"])
    yield from _rows_differ(group, maneuver)
    energies = [group[f"{name}_energy"][:] for name in ("potential", "kinetic", "mechanical")]
    size = max(float(np.nanmax(np.abs(e), initial=0.0)) for e in energies)
    difference = np.abs(energies[0] + energies[1] - energies[2])
    if float(np.nanmax(difference, initial=0.0)) > _GRID * size:
        yield f"{group.name}: derivatives of the energies do not add up"


def _rows_differ(group: Any, maneuver: Maneuver) -> Iterator[str]:
    """Rows of derivatives that are not those of the pieces, as far as both have bounds."""
    x = read_group(group)
    times = [float(maneuver.time(i * ROWS_APART)) for i in range(len(x.time))]
    if not np.array_equal(x.time, times):
        yield f"{group.name}/rows/time: found other times than those of every tenth row"
    elif not x.breaks[0] <= times[0] <= times[-1] <= x.breaks[-1]:
        yield f"{group.name}/breaks: the pieces do not cover the rows"
    else:
        with np.errstate(all="ignore"):
            for name, values in x.evaluate(times, list(x.values)).items():
                size = np.abs(x.coefficients[name]).max(axis=(0, 1))
                limit = x.bound[name].max(axis=0) + x.values_bound[name] + _ROUNDOFF * size
                if (np.abs(values - x.values[name]) > limit).any():
                    yield f"{group.name}/rows/{name}: differs from the pieces beyond the bounds"


def _pieces(group: Any, breaks: str) -> int:
    return max(group[breaks].size - 1, 1) if breaks in group else 1


def _increase(breaks: Any) -> Iterator[str]:
    times = breaks[:]
    if times[0] != 0 or not (np.diff(times) > 0).all():
        yield f"{breaks.name}: the breaks do not increase from 0"


def _group(group: Any, layout: Group) -> Iterator[str]:
    """Problems of a group, and of the groups in it."""
    yield from _attributes(group, layout.attributes)
    yield from _names(group, layout.members)
    for item in layout.datasets:
        yield from _dataset(group, item)
    for name, inner in layout.groups.items():
        yield from _group(group[name], inner)


def _names(group: Any, expected: Sequence[str]) -> Iterator[str]:
    """Members that are missing, or of which nothing is said."""
    found = set(group)
    for name in expected:
        if name not in found:
            yield f"{group.name}: has no {name}"
    for name in sorted(found - set(expected)):
        yield f"{group.name}: has {name!r:.60}, which is not part of a set"


def _dataset(group: Any, item: Dataset) -> Iterator[str]:
    """Problems of a dataset: type, shape, attributes, dimension scales, its numbers."""
    dataset, kind = group[item.name], np.dtype(item.kind)
    if dataset.dtype != kind or dataset.shape != item.shape:
        raise _UnusableError(
            f"{dataset.name}: found {dataset.shape} of {dataset.dtype}, expected {item.shape} of "
            f"{kind}"
        )
    yield from _attributes(dataset, item.attributes)
    for axis, scale in enumerate(item.scales):
        attached = dataset.dims[axis].values()
        if len(attached) != 1 or attached[0] != group[scale]:
            yield f"{dataset.name}: axis {axis} does not have the scale {group[scale].name}"
    values = dataset[:]
    if np.isinf(values).any() or (np.isnan(values).any() and not item.has_nan):
        yield f"{dataset.name}: found a number that is not finite"
    if item.kind == INDEX and not np.array_equal(values, np.arange(values.size)):
        yield f"{dataset.name}: found other numbers than 0, 1, 2, ..."
    if item.name.endswith("_bound") and (values < 0).any():
        yield f"{dataset.name}: found a negative bound"


def _attributes(item: Any, expected: Mapping[str, Any]) -> Iterator[str]:
    """Attributes that are missing, not known, or say something else."""
    found = set(item.attrs) - _SCALE_ATTRIBUTES
    for name in sorted(found ^ expected.keys()):
        if name in expected:
            yield f"{item.name}: has no attribute {name}"
        else:
            yield f"{item.name}: has the attribute {name!r:.60}, which is not part of a set"
    yield from _texts(item, {name: text for name, text in expected.items() if name in found})


def _texts(item: Any, expected: Mapping[str, Any]) -> Iterator[str]:
    """Attributes that say something else."""
    for name, text in expected.items():
        found = item.attrs[name]
        if not (isinstance(found, str) and found == text):
            yield f"{item.name}: attribute {name}: found {found!r:.80}, expected {text!r:.80}"


def _trajectory(group: Any, maneuver: Maneuver, inputs: Mapping[str, Any]) -> Iterator[str]:
    said = {name: group.attrs[name] for name in STATED if name in group.attrs}
    yield from _names_of_attributes(group, [*inputs, *STATED])
    yield from _texts(group, inputs)
    form = said["form"]
    if form not in _STATES:
        yield (
            f"{group.name}: attribute form: found {form!r:.80}, "
            f"expected one of {', '.join(_STATES)}"
        )
    elif json.loads(said["states"]) != _STATES[form]:
        yield f"{group.name}: attribute states: found other variables than those of {form}"
    grid, bits = int(said["grid"]), int(said["precision_bits"])
    if Precision.of(str(said["precision"]).split()[0]).bits != bits:
        yield f"{group.name}: {said['precision']!r:.80} do not have {bits} bits"
    if not bits <= grid <= 2 * bits:
        yield f"{group.name}: attribute grid: found {grid}, expected {bits} or somewhat more"
    breaks, coefficients = group["breaks"], group["coefficients"]
    width = coefficients.shape[-1]
    # A state of more than 2^64 would be no motion of a bicycle.
    if width > (grid + 64) // 8 + 1:
        raise _UnusableError(f"{coefficients.name} has integers of {width} bytes")
    layout = structure.trajectory(inputs, said, _pieces(group, "breaks"), width)
    yield from _names(group, layout.members)
    for item in layout.datasets:
        yield from _dataset(group, item)
    times = breaks[:]
    if times[0] != 0 or not (np.diff(times) > 0).all() or times[-1] < maneuver.duration:
        yield f"{breaks.name}: do not increase from 0 to {float(maneuver.duration):g} s"


def _names_of_attributes(item: Any, expected: Sequence[str]) -> Iterator[str]:
    for name in sorted(set(item.attrs) ^ set(expected)):
        has = "has no attribute" if name in expected else "has the unknown attribute"
        yield f"{item.name}: {has} {name!r:.60}"


def of_certificate(raw: bytes, manifest: Manifest, maneuvers: Sequence[Maneuver]) -> Iterator[str]:
    """Problems of the certificate, apart from what its numbers say."""
    document = json.loads(raw)
    parts = [
        "schema_version", "statement", "inputs", "proved", "computed", "maneuvers", "trusted",
        "software",
    ]  # fmt: skip
    if list(document) != parts:
        yield f"found the entries {', '.join(document)}; expected {', '.join(parts)}"
        return
    if document["schema_version"] != 1:
        yield f"found schema version {document['schema_version']!r:.20}, expected 1"
    if document["statement"] != STATEMENT or document["trusted"] != list(TRUSTED):
        yield "its statement, or what is trusted, is not what is proved"
    if document["proved"] != PROVED or document["computed"] != COMPUTED:
        yield "what it names as proved, or as computed, is not what is"
    if document["inputs"] != manifest.inputs:
        yield "its inputs are not those of the manifest"
    if raw != (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode():
        yield "is not written the way 'heyoka-bike generate' writes it"
    if set(document["software"]) != {"flint", "python-flint"}:
        yield "does not name the versions of flint and python-flint"
    entries = document["maneuvers"]
    if len(entries) != len(maneuvers):
        yield f"found {len(entries)} maneuvers, expected {len(maneuvers)}"
    for entry, maneuver in zip(entries, maneuvers, strict=False):
        if list(entry) != list(_ENTRY):
            raise _UnusableError(f"{maneuver.name}: expected the entries {', '.join(_ENTRY)}")
        if list(entry["state_bounds"]) not in _STATES.values():
            raise _UnusableError(f"{maneuver.name}: has other state variables than a candidate")
        dense, motion = entry["dense_relative_bounds"], entry["motion"]
        if list(motion) != ["entries", "dense_relative_bounds"]:
            raise _UnusableError(f"{maneuver.name}: motion: expected entries and bounds")
        forces, slopes = motion["dense_relative_bounds"], entry["sensitivities"]
        if list(slopes) != ["entries", "ambiguous", "relative_bounds"]:
            raise _UnusableError(f"{maneuver.name}: sensitivities: expected entries and bounds")
        slopes, names = slopes["relative_bounds"], [c.name for c in COLUMNS]
        if not list(dense) == list(slopes) == names or list(forces) != list(DENSE_COLUMNS):
            raise _UnusableError(f"{maneuver.name}: has other columns than a set")
        for key, bounds in (
            *entry["state_bounds"].items(), ("dense", dense), ("motion", forces),
            ("sensitivities", slopes),
            ("bound", {key: entry[key] for key in ("bound", "bound_end")}),
        ):  # fmt: skip
            for x in bounds.values():
                if not _BOUND.fullmatch(x):
                    raise _UnusableError(f"{maneuver.name}: {key}: found {x!r:.40} for a bound")


def of_description(
    raw: bytes, manifest: Manifest, _: Sequence[Maneuver], *, expected: bytes
) -> Iterator[str]:
    """A file about the set that says something else."""
    if raw != expected:
        yield f"does not follow from {MANIFEST}"


def of_text(
    raw: bytes, _: Manifest, maneuvers: Sequence[Maneuver], *, file: TextFile
) -> Iterator[str]:
    """Problems of a text file: lines, fields, the form of the numbers, the times."""
    maneuver = maneuvers[file.numbers[0] - 1]
    lines = raw.decode("ascii").split("\n")
    if lines.pop() != "" or len(lines) != maneuver.rows:
        yield f"found {len(lines)} lines, expected {maneuver.rows}, each of them ended"
        return
    count = 1 + len(BENCHMARK_COLUMNS) * len(file.numbers)
    is_number = _has_50_digits if file.is_long else _has_17_digits
    for i, line in enumerate(lines):
        fields = line.split(" ")
        if len(fields) != count:
            yield f"line {i + 1}: found {len(fields)} fields, expected {count}"
        elif not _is_time(fields[0], maneuver.time(i)):
            expected = float(maneuver.time(i))
            yield f"line {i + 1}: found time {fields[0]:.60} s, expected {expected:.17g} s"
        elif wrong := [x for x in fields[1:] if not is_number(x)]:
            yield f"line {i + 1}: found {wrong[0]!r:.80}, expected a number of the format"


def _is_time(text: str, t: Fraction) -> bool:
    """The shortest decimal that is exactly the time, or its first digits if there is none."""
    if not _TIME.fullmatch(text):
        return False
    return abs(Fraction(text) - t) <= (t / 10**TEXT_DIGITS if _is_endless(t) else 0)


def _is_endless(t: Fraction) -> bool:
    denominator = t.denominator
    for p in (2, 5):
        while denominator % p == 0:
            denominator //= p
    return denominator != 1


def _has_50_digits(text: str) -> bool:
    return _NUMBER_50.fullmatch(text) is not None


def _has_17_digits(text: str) -> bool:
    return f"{float(text):.17g}" == text


def read_text(raw: bytes, file: TextFile) -> Text:
    """The numbers of a text file in which no problem was found."""
    fields = [line.split(" ") for line in raw.decode("ascii").splitlines()]
    names = [(number, name) for number in file.numbers for name in BENCHMARK_COLUMNS]
    _, *columns = (tuple(column) for column in zip(*fields, strict=True))
    return Text(file, dict(zip(names, columns, strict=True)))
