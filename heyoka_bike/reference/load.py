"""Reading the reference: rows, dense output, and evaluation at any time (NumPy and h5py only)."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.numbers.chebyshev import argument, clenshaw, locate
from heyoka_bike.numbers.chebyshev_products import double_sums, plain_sums
from heyoka_bike.numbers.double import Array, Double, two_sum
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.layout import HDF5

Time = float | Fraction | str | tuple[ArrayLike, ArrayLike] | ArrayLike
"""A time [s]: a float (meaning exactly that binary64), an exact `Fraction` or decimal string, an
array or sequence of these, or a pair (hi, lo) of floats or arrays."""


T = TypeVar("T")


class Numbered(Mapping[int, T]):
    """A mapping of the numbers of maneuvers; two are equal only if they are the same object.

    Attributes
    ----------
    maneuvers : tuple
        Number 1 goes first.
    """

    maneuvers: tuple[T, ...]

    def __getitem__(self, number: int) -> T:
        if number not in self:
            raise KeyError(f"found maneuver {number!r}, expected 1 to {len(self.maneuvers)}")
        return self.maneuvers[number - 1]

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __contains__(self, number: object) -> bool:
        return isinstance(number, int) and 1 <= number <= len(self.maneuvers)

    def __iter__(self) -> Iterator[int]:
        return iter(range(1, len(self.maneuvers) + 1))

    def __len__(self) -> int:
        return len(self.maneuvers)


@dataclass(frozen=True, eq=False, repr=False)
class Values:
    """Columns at some times: ``values["roll_angle"]`` is hi, ``values.lo["roll_angle"]`` the rest.

    Attributes
    ----------
    hi, lo : mapping of str to ndarray
        SI units, of the shape of the times; the value is their exact sum.
    bound : mapping of str to ndarray
        Certified bound on abs(exact - (hi + lo)) of a row, or on the distance of a dense piece from
        the exact column; empty for evaluated values.
    """

    hi: Mapping[str, Array]
    lo: Mapping[str, Array]
    bound: Mapping[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self.hi:
            raise KeyError(f"found column '{name}', expected one of {', '.join(self.hi)}")
        return self.hi[name]

    def __repr__(self) -> str:
        return f"<values of {len(self.hi)} columns>"


@dataclass(frozen=True, eq=False, repr=False)
class ReferenceManeuver:
    """The reference of one maneuver.

    Attributes
    ----------
    name : str
    inputs : mapping of str to str
        Initial state, duration and spacing, exact.
    time, time_lo : ndarray, shape (rows,)
        Times of the rows [s], hi + lo.
    rows : Values
        Columns at the rows.
    breaks : ndarray, shape (P + 1,)
        Ends of the dense pieces [s].
    dense : Values
        Chebyshev coefficients, shape (P, N).
    units : mapping of str to str
    """

    name: str
    inputs: Mapping[str, str]
    time: Array
    time_lo: Array
    rows: Values
    breaks: Array
    dense: Values
    units: Mapping[str, str]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns, alternates included."""
        return tuple(self.rows.hi)

    @property
    def duration(self) -> Fraction:
        """End of the reference [s]."""
        return Fraction(self.inputs["duration"])

    def scale(self, name: str) -> float:
        """Largest absolute value of a column over the run, at its rows."""
        return float(np.max(np.abs(self.rows[name])))

    def evaluate(self, t: Time, columns: Sequence[str] | str | None = None) -> Values:
        """Columns at any time of the run, to about 31 digits of the column's scale.

        Parameters
        ----------
        t
            Time or times [s], see `Time`. A float means exactly that binary64: 0.07 is not 7/100;
            write ``"0.07"`` or ``Fraction(7, 100)`` for that.
        columns
            Names; all by default.

        Raises
        ------
        InputError
            A time outside the run, not a number, or an unknown column.
        """
        chosen = (columns,) if isinstance(columns, str) else columns
        names = self.columns if chosen is None else tuple(chosen)
        for name in names:
            if name not in self.rows.hi:
                raise InputError(
                    f"found column '{name}', expected one of {', '.join(self.columns)}"
                )
        hi, lo = _double(t)
        shape = hi.shape
        times: Double = (hi.ravel(), lo.ravel())
        self._check_range(times)
        found = self.continued(times, names)
        return Values(
            hi={name: v.reshape(shape) for name, v in found.hi.items()},
            lo={name: v.reshape(shape) for name, v in found.lo.items()},
        )

    def continued(self, times: Double, names: Sequence[str]) -> Values:
        """`evaluate` at times that are not checked, of shape (n,).

        The last piece is analytic: it may be continued by a tiny part of its length.
        """
        piece = locate(self.breaks, times)
        x = argument(self.breaks, piece, times)
        if not names:
            return Values({}, {})
        c = np.stack([self.dense.hi[name] for name in names])
        c_lo = np.stack([self.dense.lo[name] for name in names])
        found_hi, found_lo = clenshaw(c, c_lo, piece, x)
        return Values(
            dict(zip(names, found_hi, strict=True)), dict(zip(names, found_lo, strict=True))
        )

    def approximate(self, t: Array, columns: Sequence[str]) -> dict[str, Array]:
        """Columns at many times in plain binary64: fast, good to its roundoff.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Sorted times within the run [s], not checked.
        columns
            Names.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Good to about 1e-15 of each column's scale.
        """
        if not len(columns):
            return {}
        c = np.stack([self.dense.hi[name] for name in columns])
        return dict(zip(columns, plain_sums(self.breaks, c, t), strict=True))

    def evaluate_many(self, t: Double, columns: Sequence[str]) -> Values:
        """`evaluate` for very many times: several times faster, to about 27 digits of the scale.

        Parameters
        ----------
        t : pair of ndarray, shape (n,)
            Sorted times within the run [s], hi + lo, not checked.
        columns
            Names.
        """
        if not len(columns):
            return Values({}, {})
        c = np.stack([self.dense.hi[name] for name in columns])
        c_lo = np.stack([self.dense.lo[name] for name in columns])
        hi, lo = double_sums(self.breaks, (c, c_lo), t)
        return Values(dict(zip(columns, hi, strict=True)), dict(zip(columns, lo, strict=True)))

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self.time)} rows of {len(self.columns)} columns>"

    def _check_range(self, t: Double) -> None:
        end = self.duration
        end_hi = float(end)
        end_lo = float(end - Fraction(end_hi))
        hi, lo = t
        bad = ~np.isfinite(hi + lo) | (hi + lo < 0)
        bad |= (hi > end_hi) | ((hi == end_hi) & (lo > end_lo))
        if bad.any():
            first = int(np.flatnonzero(bad)[0])
            raise InputError(
                f"{self.name}: found time {_show(hi[first], lo[first])} s, "
                f"expected 0 to {float(end):g} s (nothing is extrapolated)"
            )


@dataclass(frozen=True, eq=False, repr=False)
class Reference(Numbered[ReferenceManeuver]):
    """A reference set: ``reference[2]`` is its second maneuver.

    Attributes
    ----------
    dataset_version, content_sha256 : str
    bicycle : str
        Name of the bicycle.
    parameters : mapping of str to str
        Its parameters, exact.
    maneuvers : tuple of ReferenceManeuver
    folder : Path
        Where it was loaded from.
    """

    dataset_version: str
    content_sha256: str
    bicycle: str
    parameters: Mapping[str, str]
    maneuvers: tuple[ReferenceManeuver, ...]
    folder: Path

    @property
    def times(self) -> Array:
        """Times of the rows [s], shape (rows,), if all maneuvers have the same.

        Raises
        ------
        InputError
            They differ; each maneuver has its own ``time``.
        """
        shared = self.maneuvers[0].time
        for number in self:
            time = self[number].time
            if not np.array_equal(time, shared):
                raise InputError(
                    f"times: found {len(shared)} rows to {shared[-1]:g} s in maneuver 1 and "
                    f"{len(time)} to {time[-1]:g} s in maneuver {number}, expected the same times "
                    "in all; each maneuver has its own, reference[1].time"
                )
        return shared

    def __repr__(self) -> str:
        return f"<reference {self.dataset_version} of {self.bicycle}: {len(self)} maneuvers>"


def load_reference(folder: str | Path | None = None) -> Reference:
    """Load a reference set, by default the published one that comes with the package.

    Parameters
    ----------
    folder : path, optional
        Folder of the set.

    Returns
    -------
    Reference

    Raises
    ------
    DatasetError
        The set is missing, incomplete or damaged; the published one must also carry the hash that
        this version of the package knows.
    """
    where, manifest, raw = manifest_file.load_file(folder, HDF5)
    try:
        # In memory, checked against the manifest; it stays open for the columns not yet read.
        f = h5py.File(io.BytesIO(raw), "r")
        numbers = range(1, len(manifest.inputs["maneuvers"]) + 1)
        return Reference(
            dataset_version=manifest.dataset_version,
            content_sha256=str(f.attrs["content_sha256"]),
            bicycle=str(f.attrs["bicycle"]),
            parameters=json.loads(f.attrs["parameters"]),
            maneuvers=tuple(_read_reference(f[f"maneuver_{i}"]) for i in numbers),
            folder=where,
        )
    except (OSError, KeyError, ValueError) as e:
        raise DatasetError(f"{where / HDF5}: is not a reference file ({e})") from None


class _OnDemand(Mapping[str, Array]):
    """Datasets of a group by column, each read when first asked for."""

    def __init__(self, group: Any, names: Sequence[str], tag: str) -> None:
        stored = set(group)
        missing = [n + tag for n in names if n + tag not in stored]
        if missing:
            raise KeyError(f"no dataset {group.name}/{missing[0]}")
        self._group = group
        self._dataset = {n: n + tag for n in names}
        self._read: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._read:
            self._read[name] = _read(self._group[self._dataset[name]])
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._dataset)

    def __len__(self) -> int:
        return len(self._dataset)

    def __contains__(self, name: object) -> bool:
        return name in self._dataset

    def __reduce__(self) -> tuple[type, tuple[dict[str, Array]]]:
        # An open file cannot be sent to another process; what is in it can.
        return dict, (dict(self),)


def _read(dataset: Any) -> Array:
    array: Array = dataset[:]
    array.setflags(write=False)
    return array


def read_maneuver(
    group: Any, columns: Sequence[str], dense_columns: Sequence[str], units: Mapping[str, str]
) -> dict[str, Any]:
    """The attributes of a `ReferenceManeuver` from a group, its datasets read on demand."""
    dense = group["dense"]

    def values(where: Any, names: Sequence[str]) -> Values:
        return Values(*(_OnDemand(where, names, tag) for tag in ("", "_lo", "_bound")))

    return {
        "name": str(group.attrs["name"]),
        "inputs": {k: str(v) for k, v in group.attrs.items() if k != "name"},
        "time": _read(group["time"]),
        "time_lo": _read(group["time_lo"]),
        "rows": values(group, columns),
        "breaks": _read(dense["breaks"]),
        "dense": values(dense, dense_columns),
        "units": units,
    }


def _read_reference(group: Any) -> ReferenceManeuver:
    stored = set(group)
    names = [n for n in stored if f"{n}_lo" in stored and n != "time"]
    order = {column.name: i for i, column in enumerate(COLUMNS)}
    names.sort(key=lambda n: (order.get(n, len(order)), n))
    units = {c.name: c.unit for c in COLUMNS}
    return ReferenceManeuver(**read_maneuver(group, names, names, units))


def _show(hi: float, lo: float) -> str:
    return f"{float(hi)!r}" + (f" + {float(lo)!r}" if lo else "")


def _double(t: object) -> Double:
    """A time in any accepted form as hi + lo."""
    if isinstance(t, tuple) and len(t) == 2:
        hi, lo = _plain(t[0]), _plain(t[1])
        if hi.shape != lo.shape or not (np.abs(lo) <= np.spacing(np.abs(hi))).all():
            raise InputError(
                f"time: found the pair {t!r:.60}, expected (hi, lo) of one shape with lo below the "
                "last digit of hi; times of their own go in a list or an array"
            )
        return two_sum(hi, lo)
    try:
        exact = np.asarray(t)
        if exact.dtype.kind in "fiu" and exact.dtype.itemsize <= 8:
            return _plain(exact), np.zeros(exact.shape)
        # Mixed lists keep their members as they are.
        exact = exact if isinstance(t, np.ndarray) else np.asarray(t, dtype=object)
    except ValueError:
        raise InputError("time: found a ragged sequence, expected numbers of one shape") from None
    pairs = np.array([_split(x) for x in exact.ravel()], dtype=np.float64).reshape(-1, 2)
    return pairs[:, 0].reshape(exact.shape), pairs[:, 1].reshape(exact.shape)


def _split(t: object) -> tuple[float, float]:
    """One time as hi + lo: a string, an exact number, or a float."""
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


def _plain(x: object) -> NDArray[np.float64]:
    """Floats, as floats; nothing that would be rounded on the way."""
    values = np.asarray(x)
    if values.dtype.kind not in "fiu" or values.dtype.itemsize > 8:
        raise InputError(f"time: found {x!r:.60}, expected floats")
    return values.astype(np.float64)
