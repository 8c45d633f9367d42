"""Read the reference: rows, dense output, and evaluation at any time (NumPy and h5py only)."""

from __future__ import annotations

import json
import logging
from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, definitions_among
from heyoka_bike.display import Displayed
from heyoka_bike.errors import InputError, unknown_word
from heyoka_bike.numbers.double import Array, Double, two_sum, with_usual_errors
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.following import FOLLOWS, with_following
from heyoka_bike.reference.hdf5 import (
    BOUND,
    LOW,
    UNDECIDED,
    columns_of,
    of_maneuvers,
    on_demand,
    opened,
    read_array,
)
from heyoka_bike.reference.layout import HDF5, MOTION, NODES, SENSITIVITIES
from heyoka_bike.reference.values import Dense, Numbered, Sensitivities, Sensitivity, Values

Time = float | Fraction | str | tuple[ArrayLike, ArrayLike] | ArrayLike
"""A time [s]: a float (meaning exactly that binary64), an exact `Fraction` or decimal string, an
array or sequence of these, or a pair (hi, lo) of floats or arrays."""


def as_double(t: Time | object) -> Double:
    """Return a time in any accepted form as hi + lo.

    Raises
    ------
    InputError
        The time is not a number, or converting it would round it.
    """
    if isinstance(t, tuple) and len(t) == 2:
        hi, lo = _plain(t[0]), _plain(t[1])
        if hi.shape != lo.shape or not (np.abs(lo) <= np.spacing(np.abs(hi))).all():
            raise InputError(
                f"time: found the pair {t!r:.60}, expected (hi, lo) of one shape with lo below the "
                "last digit of hi; put two separate times into a list"
            )
        return two_sum(hi, lo)
    try:
        exact = np.asarray(t)
        if exact.dtype.kind in "fiu" and exact.dtype.itemsize <= 8:
            return _plain(exact), np.zeros(exact.shape)
        # Put the members of a mixed list into an array of objects, in which NumPy does not convert
        # them.
        exact = exact if isinstance(t, np.ndarray) else np.asarray(t, dtype=object)
    except ValueError:
        raise InputError("time: found a ragged sequence, expected numbers of one shape") from None
    pairs = np.array([_split(x) for x in exact.ravel()], dtype=np.float64).reshape(-1, 2)
    return pairs[:, 0].reshape(exact.shape), pairs[:, 1].reshape(exact.shape)


def _split(t: object) -> tuple[float, float]:
    """Return one time (a string, an exact number or a float) as hi + lo."""
    if isinstance(t, bytes):
        t = t.decode("utf-8", "replace")
    if isinstance(t, str):
        try:
            exact = Exact.parse(t).fraction()
        except ValueError as e:
            raise InputError(f"time: {e}") from None
    elif isinstance(t, bool | np.bool_ | None.__class__):
        raise InputError(f"time: found {t!r}, expected numbers or decimal strings")
    else:
        try:
            exact = Fraction(*t.as_integer_ratio())  # type: ignore[attr-defined]
        except (ValueError, OverflowError):
            return float("nan"), 0.0
        except (AttributeError, TypeError):
            raise InputError(
                f"time: found {t!r:.60}, expected numbers or decimal strings"
            ) from None
    try:
        hi = float(exact)
    except OverflowError:
        return float("inf"), 0.0
    return hi, float(exact - Fraction(hi))


def _plain(x: object) -> Array:
    """Return numbers as binary64; reject numbers of other types, such as longdouble."""
    values = np.asarray(x)
    if values.dtype.kind not in "fiu" or values.dtype.itemsize > 8:
        raise InputError(f"time: found {x!r:.60}, expected floats")
    return values.astype(np.float64)


_log = logging.getLogger(__name__)

# The polynomials of the last piece may be continued beyond its end by its length divided by this
# number.
_PARTS_OF_PIECE = 100
NEEDED = (*BENCHMARK_COLUMNS, "pitch", "yaw", "yaw_rate")
"""Columns that every dataset must have."""


@dataclass(frozen=True, eq=False, repr=False)
class ReferenceManeuver(Displayed):
    """The reference of one maneuver; ``maneuver["roll_angle"]`` are the values at its rows.

    Attributes
    ----------
    name : str
    inputs : mapping of str to str
        Initial state, duration and spacing, exact.
    time, time_lo : ndarray, shape (rows,)
        Times of the rows [s], hi + lo.
    rows : Values
        Columns at the rows.
    dense : Dense
        Chebyshev pieces of the columns, except friction demands, which follow from other columns.
    units : mapping of str to str
    parameters : mapping of str to str
        Exact parameters of the bicycle.
    more : tuple of Dense
        Pieces of other columns, with other breaks.
    performance_limit : float or None
        Upper limit for eq. (1) of the benchmark [%]; None if the maneuver is not judged by it.
    """

    name: str
    inputs: Mapping[str, str]
    time: Array
    time_lo: Array
    rows: Values
    dense: Dense
    units: Mapping[str, str]
    parameters: Mapping[str, str]
    more: tuple[Dense, ...] = ()
    performance_limit: float | None = None

    _view: ClassVar[str] = "reference_maneuver"

    def __getitem__(self, name: str) -> Array:
        try:
            is_stored = name in self.rows.hi or name not in self.at_any_time
        except TypeError:
            # The name is not hashable, so the look-up in the rows rejects it.
            is_stored = True
        return self.rows[name] if is_stored else self._at_rows([name])[name]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns, including alternate definitions."""
        return tuple(self.rows.hi)

    @cached_property
    def at_any_time(self) -> Set[str]:
        """Names of the columns that can be evaluated at any time; older datasets may lack some.

        They include definitions that the dataset does not store but that follow from its columns.
        """
        pieces = {name for dense in (self.dense, *self.more) for name in dense.hi}
        stored = pieces & self.rows.hi.keys()
        return stored | {name for name, how in FOLLOWS.items() if stored.issuperset(how.needs)}

    @cached_property
    def definitions(self) -> Mapping[str, tuple[Column, ...]]:
        """The definitions of each column that this dataset has, by key; the default comes first.

        Results are compared with these definitions only, although `columns.COMPARED` may have more.
        """
        return definitions_among(self.at_any_time)

    @property
    def breaks(self) -> Array:
        """Ends of the pieces of the dense output [s], shape (P + 1,)."""
        return self.dense.breaks

    @cached_property
    def reach(self) -> float:
        """Latest time [s] at which the last polynomials describe the motion, just past its end.

        The continuation is a hundredth of the last piece. There T_31 is below 250, so errors of the
        coefficients cost about two of some thirty digits. Nothing is proved beyond the end.
        """
        return float(self.duration) + float(self.breaks[-1] - self.breaks[-2]) / _PARTS_OF_PIECE

    @cached_property
    def duration(self) -> Fraction:
        """End of the reference [s]."""
        return Exact.parse(self.inputs["duration"]).fraction()

    def scale(self, name: str) -> float:
        """Return the largest absolute value of a column at the rows."""
        return float(np.max(np.abs(self[name])))

    @with_usual_errors
    def evaluate(self, t: Time, columns: Sequence[str] | str | None = None) -> Values:
        """Evaluate columns at any time of the run, to about 31 digits of the column's scale.

        Parameters
        ----------
        t
            Time or times [s], see `Time`. A float means exactly that binary64: 0.07 is not 7/100;
            write ``"0.07"`` or ``Fraction(7, 100)`` for that.
        columns
            Names of columns; by default all of `at_any_time`.

        Raises
        ------
        InputError
            A time is outside the run or not a number, or a column is unknown or has rows only.
        """
        if columns is None:
            known = dict.fromkeys((*self.columns, *FOLLOWS))
            columns = [name for name in known if name in self.at_any_time]
        names = (columns,) if isinstance(columns, str) else tuple(columns)
        for name in names:
            if name not in self.at_any_time | self.rows.hi.keys():
                raise InputError(unknown_word(name, self.columns, "column "))
            if name not in self.at_any_time:
                raise InputError(
                    f"{name}: this dataset contains the column at the rows only; use "
                    f"maneuver[{name!r}]"
                )
        hi, lo = as_double(t)
        times: Double = (hi.ravel(), lo.ravel())
        self._check_range(times)
        found = self.continued(times, names)
        shaped = (
            {name: x.reshape(hi.shape) for name, x in part.items()} for part in (found.hi, found.lo)
        )
        return Values(*shaped, time=hi)

    def continued(self, times: Double, names: Sequence[str]) -> Values:
        """Evaluate columns at times of shape (n,), without checking that they are within the run.

        The last piece is analytic: it may be continued by a tiny part of its length.
        """
        return self._gathered(Dense.evaluate, times, names)

    def approximate(self, t: Array, columns: Sequence[str]) -> dict[str, Array]:
        """Evaluate columns at many times in plain binary64: fast, accurate to its roundoff.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Sorted times within the run [s], not checked.
        columns
            Names.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Values accurate to about 1e-15 of each column's scale.
        """
        if np.array_equal(t, self.time):
            return dict(self._at_rows(columns).hi)
        return dict(self._gathered(Dense.approximate, (t, np.zeros_like(t)), columns).hi)

    def evaluate_many(self, t: Double, columns: Sequence[str]) -> Values:
        """Evaluate columns at very many times, faster than `continued`, to about 27 digits.

        Parameters
        ----------
        t : pair of ndarray, shape (n,)
            Sorted times within the run [s], hi + lo, not checked.
        columns
            Names.
        """
        return self._gathered(Dense.evaluate_many, t, columns)

    def joined(self, other: ReferenceManeuver) -> ReferenceManeuver:
        """Return this maneuver with the columns of another file added; both have the same rows."""
        # A ChainMap combines the mappings without reading any dataset; each is read when it is
        # used.
        rows = Values(
            *(
                ChainMap(getattr(self.rows, part), getattr(other.rows, part))
                for part in ("hi", "lo", "bound")
            ),
            undecided={**self.rows.undecided, **other.rows.undecided},
        )
        return replace(self, rows=rows, units={**other.units, **self.units}, more=(other.dense,))

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self.time)} rows of {len(self.columns)} columns>"

    def _gathered(
        self, evaluate: Callable[[Dense, Double, Sequence[str]], Values], t: Double,
        names: Sequence[str],
    ) -> Values:  # fmt: skip
        """Return columns at given times: rows if these are their times, else dense output."""
        if np.array_equal(t[0], self.time) and np.array_equal(t[1], self.time_lo):
            return self._at_rows(names)

        def from_pieces(names: Sequence[str]) -> Values:
            hi: dict[str, Array] = {}
            lo: dict[str, Array] = {}
            for dense in (self.dense, *self.more):
                if own := [name for name in names if name in dense.hi]:
                    found = evaluate(dense, t, own)
                    hi.update(found.hi)
                    lo.update(found.lo)
            return Values(hi, lo)

        return with_following(from_pieces, names, self.parameters)

    def _at_rows(self, names: Sequence[str]) -> Values:
        """Return columns at the rows: stored columns, and those computed from stored columns."""
        hi, lo = self._at_rows_known

        def stored(names: Sequence[str]) -> Values:
            return Values({n: hi[n] for n in names}, {n: lo[n] for n in names})

        found = with_following(stored, names, self.parameters, hi)
        new = [n for n in names if n not in hi]
        for n in new:
            found.hi[n].setflags(write=False)
            found.lo[n].setflags(write=False)
        hi.update({n: found.hi[n] for n in new})
        lo.update({n: found.lo[n] for n in new})
        return found

    @cached_property
    def _at_rows_known(self) -> tuple[ChainMap[str, Array], ChainMap[str, Array]]:
        """Columns at the rows, as hi and lo; `_at_rows` adds the computed columns on first use."""
        rows: Any = self.rows
        return ChainMap({}, rows.hi), ChainMap({}, rows.lo)

    def _check_range(self, t: Double) -> None:
        (hi, lo), end = t, float(self.duration)
        rest = float(self.duration - Fraction(end))
        bad = ~np.isfinite(hi + lo) | (hi + lo < 0)
        bad |= (hi > end) | ((hi == end) & (lo > rest))
        if bad.any():
            first = int(np.flatnonzero(bad)[0])
            raise InputError(
                f"{self.name}: found time {_show(hi[first], lo[first])} s, "
                f"expected 0 to {end:g} s (nothing is extrapolated)"
            )


@dataclass(frozen=True, eq=False, repr=False)
class Reference(Displayed, Numbered[ReferenceManeuver]):
    """A reference dataset: ``reference[2]`` is its second maneuver.

    Attributes
    ----------
    dataset_version, content_sha256 : str
    bicycle : str
        Name of the bicycle.
    parameters : mapping of str to str
        Exact parameters of the bicycle.
    maneuvers : tuple of ReferenceManeuver
    folder : Path
        Folder that it was loaded from.
    """

    dataset_version: str
    content_sha256: str
    bicycle: str
    parameters: Mapping[str, str]
    maneuvers: tuple[ReferenceManeuver, ...]
    folder: Path

    _view: ClassVar[str] = "reference"

    @cached_property
    def most_apart(self) -> float:
        """Largest spacing [s] of a result's rows that still show the motion between them.

        It is the length of the longest dense piece of the quickest maneuver: 0.25 s for the
        benchmark. Errors of wrong motions oscillate mainly with the weave, or at twice its
        frequency. Their zeros are then 0.37 s or more apart: 0.37 s is half a period of the weave
        at 8 m/s, and 0.41 s a quarter of a period at 4.6 m/s.
        """
        return min(float(np.diff(m.breaks).max()) for m in self.maneuvers)

    @cached_property
    def motion(self) -> Motion:
        """The whole motion of the dataset, read on first use.

        Raises
        ------
        DatasetError
            The dataset has no motion.h5, or the file is damaged.
        """
        return load_motion(self.folder)

    @cached_property
    def sensitivities(self) -> Sensitivities:
        """The sensitivities of the dataset, read on first use.

        Raises
        ------
        DatasetError
            The dataset has no sensitivities.h5, or the file is damaged.
        """
        return load_sensitivities(self.folder)

    def with_motion(self) -> Reference | None:
        """Return the reference with the columns of its motion.h5; None if it has no such file.

        Raises
        ------
        DatasetError
            The manifest or the file is missing or damaged.
        """
        if MOTION not in manifest_file.read_manifest(self.folder).files:
            return None
        joined = tuple(self[number].joined(self.motion[number]) for number in self)
        return replace(self, maneuvers=joined)

    @property
    def judged(self) -> tuple[int, ...]:
        """Numbers of the maneuvers to which eq. (1) applies: those with a ``performance_limit``."""
        return tuple(n for n in self if self[n].performance_limit is not None)

    @property
    def times(self) -> Array:
        """Times of the rows [s], shape (rows,), which must be the same for all maneuvers.

        Raises
        ------
        InputError
            The times differ; each maneuver has its own ``time``.
        """
        shared = self.maneuvers[0].time
        for number in self:
            time = self[number].time
            if not np.array_equal(time, shared):
                raise InputError(
                    f"times: found {len(shared)} rows to {shared[-1]:g} s in maneuver 1 and "
                    f"{len(time)} to {time[-1]:g} s in maneuver {number}, expected equal times; "
                    "use the times of each maneuver, such as reference[1].time"
                )
        return shared

    def __repr__(self) -> str:
        return f"<reference {self.dataset_version} of {self.bicycle}: {len(self)} maneuvers>"


@with_usual_errors
def load_reference(folder: Reference | str | PathLike[str] | None = None) -> Reference:
    """Load a reference dataset, by default the published one that comes with the package.

    Parameters
    ----------
    folder : path, optional
        Folder of the dataset; a loaded reference is returned unchanged.

    Returns
    -------
    Reference

    Raises
    ------
    InputError
        The argument is not a folder.
    DatasetError
        The dataset is missing, incomplete or damaged, or the published one does not have the hash
        that this version of the package knows.
    """
    if isinstance(folder, Reference):
        return folder
    if folder is not None and not isinstance(folder, str | PathLike):
        raise InputError(
            f"reference: found a {type(folder).__name__}, expected the folder of a dataset or a "
            "loaded Reference"
        )
    where, manifest, raw = manifest_file.load_file(None if folder is None else Path(folder), HDF5)
    key = (where, manifest.sha256)
    reference = _loaded.get(key)
    if reference is None:
        with manifest_file.reading(where / HDF5, "a reference file"):
            reference = _read_reference(where, manifest, _opened(raw, manifest))
        if len(_loaded) == _MOST_LOADED:
            _loaded.clear()
        _loaded[key] = reference
    _log.info("%s: %d maneuvers, data %s", where, len(reference), manifest.dataset_version)
    return reference


# Cache of loaded references by folder and hash of the manifest. A loaded reference keeps its
# computed columns, which take longer to compute than the files take to read.
_loaded: dict[tuple[Path, str], Reference] = {}
_MOST_LOADED = 2


def _opened(raw: bytes, manifest: manifest_file.Manifest) -> Any:
    """Open a file that matches the manifest; skip further checks for a published dataset."""
    return opened(raw, is_known=manifest.sha256 in manifest_file.PUBLISHED_MANIFESTS.values())


def _read_reference(where: Path, manifest: manifest_file.Manifest, f: Any) -> Reference:
    maneuvers = _read_maneuvers(f, manifest, where / HDF5)
    for m in maneuvers:
        for key in (*NEEDED, *m.definitions):
            if key not in m.at_any_time:
                raise ValueError(
                    f"{m.name}: the file has no {key}, which is the default definition of this "
                    "quantity"
                )
    return Reference(
        dataset_version=manifest.dataset_version,
        content_sha256=str(f.attrs["content_sha256"]),
        bicycle=str(f.attrs["bicycle"]),
        parameters=json.loads(f.attrs["parameters"]),
        maneuvers=maneuvers,
        folder=where,
    )


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Displayed, Numbered[ReferenceManeuver]):
    """The whole motion of all maneuvers of a dataset; ``motion[2]`` is the second maneuver.

    The columns are those of `columns.MOTION_COLUMNS` that the dataset has.

    Attributes
    ----------
    maneuvers : tuple of ReferenceManeuver
    content_sha256 : str
        Hash of the numbers.
    folder : Path
        Folder that it was loaded from.
    """

    maneuvers: tuple[ReferenceManeuver, ...]
    content_sha256: str
    folder: Path

    _view: ClassVar[str] = "reference"

    def __repr__(self) -> str:
        return f"<whole motion of {len(self)} maneuvers>"


def load_motion(folder: str | Path | None = None) -> Motion:
    """Load the whole motion of a reference dataset, by default of the published one.

    Parameters
    ----------
    folder : path, optional
        Folder of the dataset.

    Returns
    -------
    Motion

    Raises
    ------
    DatasetError
        The dataset has no motion.h5, or the file is damaged.
    """
    where, manifest, raw = manifest_file.load_file(folder, MOTION)
    with manifest_file.reading(where / MOTION, "a file of a whole motion"):
        f = _opened(raw, manifest)
        maneuvers = _read_maneuvers(f, manifest, where / MOTION)
        return Motion(maneuvers, str(f.attrs["content_sha256"]), where)


def load_sensitivities(folder: str | Path | None = None) -> Sensitivities:
    """Load the sensitivities of a reference dataset, by default of the published one.

    Parameters
    ----------
    folder : path, optional
        Folder of the dataset.

    Returns
    -------
    Sensitivities

    Raises
    ------
    DatasetError
        The dataset has no sensitivities.h5, or the file is damaged.
    """
    from heyoka_bike.reference.structure import UNKNOWNS

    where, manifest, raw = manifest_file.load_file(folder, SENSITIVITIES)
    with (
        manifest_file.reading(where / SENSITIVITIES, "a file of sensitivities"),
        _opened(raw, manifest) as f,
    ):
        if tuple(json.loads(f.attrs["unknowns"])) != tuple(UNKNOWNS):
            raise ValueError("its unknowns are not those of this version")
        groups = of_maneuvers(f, len(manifest.inputs["maneuvers"]))
        return Sensitivities(tuple(map(read_group, groups)))


def read_group(group: Any) -> Sensitivity:
    """Read the derivatives of a maneuver; datasets before 1.4.0 have no bounds and no rows."""
    breaks = read_array(group, "breaks")
    shape = group[columns_of(group)[0]].shape
    if len(shape) != 3 or breaks.shape != (shape[0] + 1,):
        raise ValueError(
            f"{group.name}: found coefficients of shape {shape} and breaks of shape "
            f"{breaks.shape}, expected three dimensions, and one break more than the first of them"
        )
    if "rows" not in group:
        (coefficients,) = on_demand(group, SENSITIVITIES, {"": shape})
        return Sensitivity(breaks, dict(coefficients))
    shapes = {"": shape, BOUND: (shape[0], shape[2])}
    coefficients, bound = map(dict, on_demand(group, SENSITIVITIES, shapes))
    rows = group["rows"]
    time = read_array(rows, "time")
    shapes = dict.fromkeys(("", BOUND), (time.size, shape[2]))
    values, values_bound = map(dict, on_demand(rows, SENSITIVITIES, shapes))
    return Sensitivity(breaks, coefficients, bound, time, values, values_bound)


def _read_maneuvers(
    f: Mapping[str, Any], manifest: manifest_file.Manifest, where: Path
) -> tuple[ReferenceManeuver, ...]:
    groups = of_maneuvers(f, len(manifest.inputs["maneuvers"]))
    parameters, limits = manifest.inputs["bicycle"]["parameters"], manifest.performance_limits
    return tuple(
        _read_maneuver(group, parameters, limits.get(number), where)
        for number, group in enumerate(groups, 1)
    )


def _read_maneuver(
    group: Any, parameters: Mapping[str, str], limit: Fraction | None, where: Path
) -> ReferenceManeuver:
    dense = group["dense"]
    undecided = {
        name: group[name + UNDECIDED][:] for name in columns_of(group) if name + UNDECIDED in group
    }
    time, breaks = read_array(group, "time"), read_array(dense, "breaks")
    for name, x in (("time", time), ("dense/breaks", breaks)):
        if x.ndim != 1 or x.size < 2 or not (np.isfinite(x).all() and (np.diff(x) > 0).all()):
            raise ValueError(
                f"{group.name}/{name}: expected at least two finite times that increase"
            )
    of_rows = dict.fromkeys(("", LOW, BOUND), time.shape)
    pieces = breaks.size - 1
    of_pieces = {"": (pieces, NODES), LOW: (pieces, NODES), BOUND: (pieces,)}
    rows = Values(*on_demand(group, where, of_rows, may_be_nan=undecided), undecided=undecided)
    known = definitions_among(rows.hi).values()
    return ReferenceManeuver(
        name=str(group.attrs["name"]),
        inputs={k: str(v) for k, v in group.attrs.items() if k != "name"},
        time=time,
        time_lo=read_array(group, "time_lo", time.shape),
        rows=rows,
        dense=Dense(*on_demand(dense, where, of_pieces, may_be_nan=()), breaks=breaks),
        units={c.name: c.unit for columns in known for c in columns},
        parameters={str(k): str(v) for k, v in parameters.items()},
        performance_limit=None if limit is None else float(limit),
    )


def _show(hi: float, lo: float) -> str:
    return f"{float(hi)!r}" + (f" + {float(lo)!r}" if lo else "")
