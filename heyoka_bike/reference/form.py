"""Checks that the HDF5 files of a reference folder have the format in docs/files.md.

Every function yields problems in words, and an `Unchecked` for each item that cannot be compared
because the dataset is older. The functions assume only that the bytes match the manifest: they
compare shapes before they read any numbers.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.equations.kinematics import state_names
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.errors import DatasetError
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference import hdf5, layout, structure
from heyoka_bike.reference.description import about
from heyoka_bike.reference.hdf5 import DAMAGE
from heyoka_bike.reference.load import NEEDED, read_group
from heyoka_bike.reference.manifest import Manifest, hdf5_version
from heyoka_bike.reference.structure import ROWS_APART, STATED

# Tolerance of the sum of the derivatives of the energies. Three values are rounded to multiples of
# 2^-50 of their scale. The scale is rounded up to a power of two.
_GRID = 3 * 2.0**-50

# Roundoff of evaluating a Chebyshev sum of 24 coefficients in binary64, relative to the largest
# coefficient.
_ROUNDOFF_OF_CHEBYSHEV = 2.0**-47

STATES_OF_FORM = {
    form: [*state_names(is_regular), "yaw"]
    for form, is_regular in (("few_products", False), ("regular", True))
}
"""Variables of the candidate by the form of the equations."""
_REWORDED = {"Conventions", "comment", "dataset_version"}
"""Attributes of whole files whose texts differ in datasets before 1.5.0."""


@dataclass(frozen=True, slots=True)
class SetForm:
    """Expected contents of the files of a dataset.

    Attributes
    ----------
    manifest : Manifest
    maneuvers : sequence of Maneuver
    columns : mapping of str to sequence of Column
        Columns of each file: those it has among those of this version, and those that are required.
    has_bounds : bool
        True if the derivatives have certified bounds, as in datasets since 1.4.0.
    has_proof : bool
        True if a proof recomputes the numbers. Their values are then not checked here, only types,
        shapes and attributes.
    """

    manifest: Manifest
    maneuvers: Sequence[Maneuver]
    columns: Mapping[str, Sequence[Column]]
    has_bounds: bool = True
    has_proof: bool = False

    @property
    def version(self) -> str:
        """Version of the dataset that last changed the HDF5 files."""
        return hdf5_version(self.manifest.dataset_version)


class Unchecked(str):
    """An item that is not checked, because the dataset is older than the version that added it."""


class UnusableError(Exception):
    """A problem that makes further checks pointless; the text describes the problem."""


def problems_of(look: Callable[..., Iterator[str]], *arguments: Any) -> list[str]:
    """Return the problems that a check finds in a file, or the reason why it cannot be read."""
    found: list[str] = []
    try:
        found.extend(look(*arguments))
    except (UnusableError, DatasetError) as e:
        found.append(str(e))
    except DAMAGE as e:
        found.append(f"cannot be read ({type(e).__name__}: {' '.join(str(e).split()):.200})")
    return found


def expected(
    manifest: Manifest, maneuvers: Sequence[Maneuver], data: Mapping[str, bytes]
) -> SetForm:
    """Return the expected contents of a dataset; expect all columns of an unreadable file."""
    columns: dict[str, Sequence[Column]] = {}
    has_bounds = True
    for name, known in structure.COLUMNS_OF.items():
        columns[name] = known
        try:
            with hdf5.opened(data[name]) as f:
                group = next(iter(f.values()))
                has_bounds &= name != layout.SENSITIVITIES or "rows" in group
                stored = {*NEEDED, *hdf5.columns_of(group)}
                columns[name] = [c for c in known if c.name in stored]
        except DAMAGE:
            continue
    return SetForm(manifest, maneuvers, columns, has_bounds)


def of_groups(raw: bytes, e: SetForm, name: str) -> Iterator[str]:
    """Yield the problems of an HDF5 file: wrong attributes, maneuvers, or hash of the numbers."""
    inputs, version = e.manifest.inputs, e.version
    with hdf5.opened(raw) as f:
        said = f.attrs.get("content_sha256")
        content = e.manifest.content_sha256 if name == layout.HDF5 else said
        root = about(name, inputs, version, None if name == layout.CANDIDATE else content)
        if _is_older(f):
            yield Unchecked("attributes of version 1.5.0")
            root = {key: text for key, text in root.items() if key not in _REWORDED}
        if lacks := len(structure.COLUMNS_OF.get(name, ())) - len(e.columns.get(name, ())):
            yield Unchecked(f"columns that it lacks ({lacks})")
        yield from _attributes(f, root)
        groups = hdf5.by_maneuver(zip(e.maneuvers, inputs["maneuvers"], strict=True))
        yield from _names(f, list(groups))
        if set(f) == set(groups):
            for group, (maneuver, own) in groups.items():
                if name == layout.CANDIDATE:
                    yield from _trajectory(f[group], maneuver, own, e)
                else:
                    declared = structure.of_maneuver(name, own, e.columns[name], f[group])
                    yield from _columns(f[group], declared, maneuver, e, name)
        is_hashed = name in (layout.MOTION, layout.SENSITIVITIES) and not e.has_proof
        if is_hashed and said != layout.content_sha256(f):
            yield "attribute content_sha256 is not the hash of the numbers in the file"


def of_instants(raw: bytes, e: SetForm) -> Iterator[str]:
    """Yield the problems of the structure of states.h5, but not of its numbers."""
    with hdf5.opened(raw) as f:
        root = about(layout.STATES_HDF5, e.manifest.inputs, e.version)
        yield from _group(f, structure.states(root, f["state"].size), e)


def _columns(
    group: Any, declared: hdf5.Group, maneuver: Maneuver, e: SetForm, name: str
) -> Iterator[str]:
    """Yield the problems of a group of columns; that of an older dataset may lack some members."""
    breaks = "breaks" if name == layout.SENSITIVITIES else "dense/breaks"
    if name == layout.MOTION and _is_older(group) and "dense" in group:
        # Datasets before 1.3.0 contain no dense output of some columns, only their rows.
        dense, stored = declared.groups["dense"], set(group["dense"])
        there = tuple(x for x in dense.datasets if not x.is_column or x.name in stored)
        if there != dense.datasets:
            yield Unchecked("dense output that it lacks")
        declared = replace(declared, groups={"dense": replace(dense, datasets=there)})
    if name == layout.SENSITIVITIES and not e.has_bounds:
        yield Unchecked("bounds and rows of derivatives")
        coefficients = (x for x in declared.datasets if not x.name.endswith(hdf5.BOUND))
        declared = hdf5.Group(declared.attributes, tuple(coefficients))
    yield from _group(group, declared, e)
    if e.has_proof:
        return
    if not _do_increase(group[breaks][:]):
        yield f"{group.name}/{breaks}: the breaks do not increase from 0"
    if name == layout.SENSITIVITIES:
        yield from _derivatives_differ(group, maneuver, e)


def _derivatives_differ(group: Any, maneuver: Maneuver, e: SetForm) -> Iterator[str]:
    """Yield the contradictions between the derivatives that a group stores."""
    if e.has_bounds:
        yield from _rows_differ(group, maneuver)
    energies = [group[f"{name}_energy"][:] for name in ("potential", "kinetic", "mechanical")]
    size = max(float(np.nanmax(np.abs(x), initial=0.0)) for x in energies)
    difference = np.abs(energies[0] + energies[1] - energies[2])
    if float(np.nanmax(difference, initial=0.0)) > _GRID * size:
        yield (
            f"{group.name}: the derivatives of the potential and the kinetic energy do not add up "
            "to those of the mechanical energy"
        )


def _rows_differ(group: Any, maneuver: Maneuver) -> Iterator[str]:
    """Yield columns whose derivatives at rows differ from the pieces by more than both bounds."""
    x = read_group(group)
    times = [float(maneuver.time(i * ROWS_APART)) for i in range(len(x.time))]
    if not np.array_equal(x.time, times):
        yield f"{group.name}/rows/time: found other times, expected those of every tenth row"
    elif not x.breaks[0] <= times[0] <= times[-1] <= x.breaks[-1]:
        yield f"{group.name}/breaks: the pieces do not cover the rows"
    else:
        with np.errstate(all="ignore"):
            for name, values in x.evaluate(times, list(x.values)).items():
                size = np.abs(x.coefficients[name]).max(axis=(0, 1))
                limit = (
                    x.bound[name].max(axis=0) + x.values_bound[name] + _ROUNDOFF_OF_CHEBYSHEV * size
                )
                if (np.abs(values - x.values[name]) > limit).any():
                    yield f"{group.name}/rows/{name}: differs from the pieces beyond the bounds"


def _do_increase(breaks: Array) -> bool:
    """True if the breaks begin at 0 and increase."""
    return bool(breaks[0] == 0 and (np.diff(breaks) > 0).all())


def _group(group: Any, declared: hdf5.Group, e: SetForm) -> Iterator[str]:
    """Yield problems of a group and of its subgroups."""
    yield from _attributes(group, declared.attributes)
    yield from _names(group, declared.members)
    for item in declared.datasets:
        yield from _dataset(group, item, e)
    for name, inner in declared.groups.items():
        yield from _group(group[name], inner, e)


def _names(group: Any, expected: Sequence[str]) -> Iterator[str]:
    """Yield the expected members that a group lacks, and its members that are not expected."""
    found = set(group)
    for name in expected:
        if name not in found:
            yield f"{group.name}: has no {name}"
    for name in sorted(found - set(expected)):
        yield f"{group.name}: has {name!r:.60}, which is not part of a dataset"


def _dataset(group: Any, item: hdf5.Dataset, e: SetForm) -> Iterator[str]:
    """Yield the problems of a dataset: wrong type, shape, attributes, scales or numbers."""
    dataset = group[item.name]
    _check_shape(dataset, item)
    yield from _attributes(dataset, item.attributes)
    for axis, scale in enumerate(item.scales):
        attached = dataset.dims[axis].values()
        if len(attached) != 1 or attached[0] != group[scale]:
            yield f"{dataset.name}: axis {axis} lacks the dimension scale {group[scale].name}"
    # The proof recomputes all numbers except the indices, so check only the indices here.
    if e.has_proof and item.kind != hdf5.INDEX:
        return
    values = dataset[:]
    if np.isinf(values).any() or (np.isnan(values).any() and not item.has_nan):
        yield f"{dataset.name}: found a number that is not finite"
    if item.kind == hdf5.INDEX and not np.array_equal(values, np.arange(values.size)):
        yield f"{dataset.name}: found other numbers than 0, 1, 2, ..."
    if item.name.endswith("_bound") and (values < 0).any():
        yield f"{dataset.name}: found a negative bound"


def _check_shape(dataset: Any, item: hdf5.Dataset) -> None:
    kind = np.dtype(item.kind)
    if dataset.dtype != kind or dataset.shape != item.shape:
        raise UnusableError(
            f"{dataset.name}: found {dataset.shape} of {dataset.dtype}, expected {item.shape} of "
            f"{kind}"
        )


def _is_older(item: Any) -> bool:
    """True if an item belongs to a dataset before 1.5.0."""
    return "keywords" not in item.file.attrs


def _attributes(
    item: Any, expected: Mapping[str, Any], *, is_strict: bool = False
) -> Iterator[str]:
    """Yield the attributes that are missing, unknown or wrong; those of older datasets may vary."""
    found = set(item.attrs) - hdf5.SCALE_ATTRIBUTES
    if _is_older(item) and not is_strict:
        found -= {"axis"} | (_REWORDED - expected.keys())
        expected = {name: text for name, text in expected.items() if name in found}
    for name in sorted(found ^ expected.keys()):
        has = "has no attribute" if name in expected else "has the unknown attribute"
        yield f"{item.name}: {has} {name!r:.60}"
    for name in sorted(found & expected.keys()):
        text, said = expected[name], item.attrs[name]
        if not (isinstance(said, type(text)) and said == text):
            yield f"{item.name}: attribute {name}: found {said!r:.80}, expected {text!r:.80}"


def _trajectory(
    group: Any, maneuver: Maneuver, inputs: Mapping[str, Any], e: SetForm
) -> Iterator[str]:
    """Yield the problems of the group that stores the candidate of a maneuver."""
    said = {name: group.attrs.get(name) for name in STATED}
    yield from _attributes(group, {**inputs, **said}, is_strict=True)
    yield from problems_of_candidate(group, maneuver)
    declared = structure.of_maneuver(layout.CANDIDATE, inputs, (), {**group, **said})
    yield from _group(group, replace(declared, attributes=dict(group.attrs)), e)


def problems_of_candidate(group: Any, maneuver: Maneuver) -> Iterator[str]:
    """Yield problems that prevent reading or evaluating the numbers of a candidate."""
    said = {name: group.attrs.get(name) for name in STATED}
    form = said["form"]
    if form not in STATES_OF_FORM:
        yield (
            f"{group.name}: attribute form: found {form!r:.80}, "
            f"expected one of {', '.join(STATES_OF_FORM)}"
        )
    elif json.loads(said["states"]) != STATES_OF_FORM[form]:
        yield f"{group.name}: attribute states: expected the variables of the form {form}"
    grid, bits = int(said["grid"]), int(said["precision_bits"])
    if Precision.of(str(said["precision"]).split()[0]).bits != bits:
        yield f"{group.name}: {said['precision']!r:.80} does not have {bits} bits"
    if not bits <= grid <= 2 * bits:
        yield f"{group.name}: attribute grid: found {grid}, expected {bits} to {2 * bits}"
    width = group["coefficients"].shape[-1]
    # The state of a moving bicycle never exceeds 2^64.
    if not 0 < width <= (grid + 64) // 8 + 1:
        raise UnusableError(
            f"{group.name}/coefficients: found integers of {width} bytes, expected 1 to "
            f"{(grid + 64) // 8 + 1}"
        )
    for item in structure.of_maneuver(layout.CANDIDATE, {}, (), {**group, **said}).datasets:
        _check_shape(group[item.name], item)
    times = group["breaks"][:]
    if not _do_increase(times) or not maneuver.duration <= times[-1] < np.inf:
        yield (
            f"{group.name}/breaks: found times that do not increase from 0 to at least "
            f"{float(maneuver.duration):g} s"
        )
