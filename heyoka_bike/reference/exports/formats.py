"""Writers of the export formats: CSV, JSON, netCDF, and evaluators in C, Fortran and MATLAB.

A format is a function of a selection and the stem of a file name. It returns the bytes of each file
by the part of the name after the stem (``.h``, ``-1.csv``).
"""

import csv
import io
import json
import keyword
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from itertools import accumulate
from pathlib import Path
from string import Template
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact, shortest_decimal
from heyoka_bike.reference.description import CONVENTIONS, COPYRIGHT, shared_attributes, title_of
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.reference.manifest import CUSTOM
from heyoka_bike.reference.values import Values
from heyoka_bike.version import __version__

ALL = "all"

AXES = (
    "SI units. Axes: x forward, y to the right, z down; roll, steer and yaw positive to the right."
)

_WIDTH_OF_COMMENTS = 96
_DIGITS_OF_COMMENTS = 17  # digits shown of a value that no decimal equals
_NAME_OF_MATLAB = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")  # at most namelengthmax = 63 characters


@dataclass(frozen=True, slots=True)
class Selection:
    """Maneuvers and columns of a reference that are exported.

    Attributes
    ----------
    reference : Reference
    numbers : tuple of int
        Numbers of the maneuvers in the reference.
    columns : tuple of Column
    """

    reference: Reference
    numbers: tuple[int, ...]
    columns: tuple[Column, ...]

    @property
    def maneuvers(self) -> Iterator[tuple[int, ReferenceManeuver]]:
        """The exported maneuvers, each with its number."""
        return ((n, self.reference[n]) for n in self.numbers)

    @property
    def terms(self) -> int:
        """Number of Chebyshev coefficients of a piece of a column."""
        first = self.reference[self.numbers[0]]
        return int(first.dense.hi[self.columns[0].name].shape[-1])


def choose(reference: Reference, maneuver: int | None, columns: str | None) -> Selection:
    """Return the selection of maneuvers and columns that the command line names.

    Raises
    ------
    InputError
        There is no such maneuver or column.
    """
    if maneuver is not None and maneuver not in reference:
        raise InputError(f"--maneuver: found {maneuver}, expected 1 to {len(reference)}")
    numbers = tuple(reference) if maneuver is None else (maneuver,)
    first = reference[numbers[0]]
    known = {c.name: c for columns in first.definitions.values() for c in columns}
    there = {name: known[name] for name in first.columns if name in known}
    if columns is None:
        names = BENCHMARK_COLUMNS
    elif columns == ALL:
        names = tuple(there)
    else:
        names = tuple(dict.fromkeys(name.strip() for name in columns.split(",")))
    for name in names:
        if name not in there:
            raise InputError(
                f"--columns: found {quoted(name)}, expected {ALL} or some of {', '.join(there)}"
            )
    return Selection(reference, numbers, tuple(there[name] for name in names))


def _licence(reference: Reference) -> str:
    """Return a sentence that states the licence; empty for a custom dataset (licence unknown)."""
    return "" if reference.dataset_version == CUSTOM else f" Licence: {COPYRIGHT}."


def about(selection: Selection, content: str, use: str) -> list[str]:
    """Return the lines that describe an exported file and its use, in printable ASCII.

    Parameters
    ----------
    selection
    content
        Description of the content of the file.
    use
        The way to compile or read it.
    """
    reference = selection.reference
    paragraphs = [
        f"{title_of(reference.dataset_version)}: {content}.",
        f"Dataset version {reference.dataset_version}, bicycle {quoted(reference.bicycle)}.",
        f"content_sha256 {reference.content_sha256}",
        f"Written by heyoka-bike export {__version__}.{_licence(reference)}",
        AXES,
        use,
        "Maneuvers:",
        *(
            f"  {n}: {quoted(m.name)}, forward speed {m.inputs['speed']} m/s, "
            f"roll rate {m.inputs['roll_rate']} rad/s, 0 to {m.inputs['duration']} s"
            for n, m in selection.maneuvers
        ),
        "Columns:",
        *(f"  {described(column)}" for column in selection.columns),
    ]
    return wrapped(paragraphs)


def wrapped(paragraphs: Iterable[str]) -> list[str]:
    """Wrap paragraphs into lines of printable ASCII."""
    lines = []
    for text in paragraphs:
        ascii_only = text.encode("ascii", "backslashreplace").decode()
        indent = "    " if text.startswith("  ") else ""
        lines += textwrap.wrap(
            ascii_only, _WIDTH_OF_COMMENTS, subsequent_indent=indent, break_on_hyphens=False
        )
    return lines


def described(column: Column) -> str:
    """Return a column, its unit and its definition on one line."""
    positive = f"; positive {column.positive}" if column.positive else ""
    return f"{column.name} [{column.unit}]: {column.long_name}: {column.meaning}{positive}"


def commented(lines: list[str], mark: str) -> str:
    """Join lines into a comment; each of its lines begins with `mark`."""
    return "".join(f"{mark} {line}".rstrip() + "\n" for line in lines)


def parameter_lines(bicycle: Bicycle) -> Iterator[str]:
    """Yield every parameter with its value and meaning, for `wrapped`."""
    for symbol, p in PARAMETERS.items():
        value = f"{symbol} = {value_text(bicycle[symbol])} {p.unit}".rstrip()
        yield f"  {value}: {p.description}"


def value_text(x: Exact) -> str:
    """Return a value as a decimal, or as an expression with pi."""
    return shortest_decimal(x.rational, _DIGITS_OF_COMMENTS) if x.is_rational else str(x)


_WORDS = (
    "abstract as baremodule begin break case catch classdef const continue do elseif end enum "
    "export extern false fn function global if impl in let local loop macro match mod module mut "
    "mutable otherwise parfor primitive pub quote ref return self spmd static struct super switch "
    "true try type unsafe use using where while"
)
_RESERVED = frozenset(keyword.kwlist) | frozenset(_WORDS.split())
"""Words of Python, MATLAB, Julia and Rust that cannot be names."""


def check_name(stem: str, of: str) -> None:
    """Reject a file name that cannot also be the name of a function or module.

    Raises
    ------
    InputError
    """
    if stem in _RESERVED:
        raise InputError(
            f"--output: {quoted(stem)} is a reserved word, expected another name of a {of}"
        )
    if not _NAME_OF_MATLAB.fullmatch(stem):
        raise InputError(
            f"--output: found {quoted(stem)}, expected the name of a {of}: a letter, then "
            "letters, digits and _"
        )


def sharing_times(selection: Selection) -> dict[str, Selection]:
    """Return the selection of each table to write, by the suffix of the table's file name.

    There is one table if all have the same times, else one for each maneuver, as in the reference
    folder.
    """
    grids = {(m.inputs["duration"], m.inputs["spacing"]) for _, m in selection.maneuvers}
    if len(grids) == 1:
        return {"": selection}
    return {
        f"-{n}": Selection(selection.reference, (n,), selection.columns) for n in selection.numbers
    }


SCHEMA_VERSION = 1
"""Version of the JSON document, which `export-1.schema.json` describes."""

DIGITS = {
    17: "Values read back as the correctly rounded binary64",
    32: "Values are hi + lo of the reference, to 32 digits",
}
"""Meaning of the values in CSV, by their number of digits."""

# Number of digits written for a time that is not a finite decimal, as in the reference's text
# files.
_TIME_DIGITS = 50

_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}

# Values of the attribute `coverage_content_type` of ACDD-1.3.
_COORDINATE_TYPE, _VALUE, _REST = "coordinate", "modelResult", "auxiliaryInformation"


def as_csv(selection: Selection, stem: str, digits: int = 17) -> dict[str, bytes]:
    """Write CSV: comment lines, a heading line, and the rows with exact times.

    One table contains all maneuvers, or each has its own if their times differ.
    """
    parts = sharing_times(selection)
    return {f"{tag}.csv": _table(part, digits).encode("ascii") for tag, part in parts.items()}


def _table(selection: Selection, digits: int) -> str:
    use = (
        "Read: lines that begin with # are comments, as for pandas.read_csv(..., comment='#') and "
        f"heyoka-bike score. {DIGITS[digits]}; times are exact."
    )
    first = selection.reference[selection.numbers[0]]
    spacing = Exact.parse(first.inputs["spacing"]).fraction()
    times = [shortest_decimal(i * spacing, _TIME_DIGITS) for i in range(len(first.time))]
    names, columns = ["time [s]"], [times]
    for number, m in selection.maneuvers:
        for column in selection.columns:
            names.append(f"maneuver_{number}_{column.name} [{column.unit}]")
            columns.append(_values(m, column.name, digits))
    text = io.StringIO()
    text.write(commented(about(selection, "the rows", use), "#"))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue()


def _values(m: ReferenceManeuver, name: str, digits: int) -> list[str]:
    hi = m.rows[name].tolist()
    if digits == 17:
        return [f"{x:.17g}" for x in hi]
    pairs = zip(hi, m.rows.lo[name].tolist(), strict=True)
    return [_decimal(Fraction(x) + Fraction(rest), digits) for x, rest in pairs]


def _decimal(x: Fraction, digits: int) -> str:
    quotient = Context(prec=digits).divide(Decimal(x.numerator), Decimal(x.denominator))
    return f"{quotient:.{digits - 1}e}" if x else "0"


def as_json(selection: Selection, stem: str) -> dict[str, bytes]:
    """Write JSON: rows and dense output; each number reads back as the same binary64."""
    use = (
        "rows: the value is <name> + <name>_lo at the time time + time_lo. pieces: the column is "
        "sum_k c_k T_k(x), c = <name>[p] + <name>_lo[p], x = 2 (t - a) / (b - a) - 1, "
        "from a = breaks[p] to b = breaks[p + 1]."
    )
    reference = selection.reference
    maneuvers = {f"maneuver_{n}": m for n, m in selection.maneuvers}
    said = ("name", "key", "definition", "unit", "meaning", "positive")
    document = {
        "about": about(selection, "rows and dense output, piecewise Chebyshev polynomials", use),
        "schema_version": SCHEMA_VERSION,
        "dataset_version": reference.dataset_version,
        "content_sha256": reference.content_sha256,
        "bicycle": reference.bicycle,
        "parameters": dict(reference.parameters),
        "columns": [{name: getattr(c, name) for name in said} for c in selection.columns],
        "maneuvers": {n: {"name": m.name, **m.inputs} for n, m in maneuvers.items()},
        "rows": {
            n: _lists(selection, m.rows, time=m.time, time_lo=m.time_lo)
            for n, m in maneuvers.items()
        },
        "pieces": {n: _lists(selection, m.dense, breaks=m.breaks) for n, m in maneuvers.items()},
    }
    return {".json": (json.dumps(document, indent=1, allow_nan=False) + "\n").encode("ascii")}


def _lists(selection: Selection, values: Values, **times: Array) -> dict[str, list[float]]:
    """Return the times and the columns (hi and lo) as lists by name."""
    found = dict(times)
    for column in selection.columns:
        found[column.name] = values.hi[column.name]
        found[f"{column.name}_lo"] = values.lo[column.name]
    return {name: x.tolist() for name, x in found.items()}


def as_netcdf(selection: Selection, stem: str) -> dict[str, bytes]:
    """Write netCDF-4 with CF and ACDD attributes: the rows, each column by maneuver and row.

    One file contains all maneuvers, or each has its own if their times differ. The time is an
    auxiliary coordinate of the rows, not a dimension: in CF a time coordinate counts from a date,
    but this one counts from the start of each maneuver.
    """
    return {f"{tag}.nc": _netcdf(part) for tag, part in sharing_times(selection).items()}


def _netcdf(selection: Selection) -> bytes:
    # Track the order in which variables and attributes are created, as the netCDF library does.
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        f.attrs.update(_about_file(selection))
        first = selection.reference[selection.numbers[0]]
        numbers = np.array(selection.numbers, dtype="<i4")
        maneuver = _dataset(f, "maneuver", numbers, "1", "number of the maneuver", _COORDINATE_TYPE)
        maneuver.make_scale("maneuver")
        row = f.create_dataset("row", shape=first.time.shape, dtype=">f4", track_order=True)
        row.make_scale(f"This is a netCDF dimension but not a netCDF variable.{len(row):10d}")
        said = "time since the start of the maneuver"
        for name, data, more, kind in (
            ("time", first.time, "", _COORDINATE_TYPE),
            ("time_lo", first.time_lo, ", exact value minus time", _REST),
        ):
            _dataset(f, name, data, "s", said + more, kind).dims[0].attach_scale(row)
        for column in selection.columns:
            _write_column(f, selection, column, (maneuver, row))
    return buffer.getvalue()


def _write_column(
    f: h5py.File, selection: Selection, c: Column, scales: tuple[h5py.Dataset, h5py.Dataset]
) -> None:
    hi, lo = (
        np.stack([getattr(m.rows, part)[c.name] for _, m in selection.maneuvers])
        for part in ("hi", "lo")
    )
    said = f"{c.long_name}, exact value minus {c.name}"
    whole = _dataset(f, c.name, hi, c.unit, c.long_name, _VALUE)
    whole.attrs.update({"definition": c.meaning, "definition_name": c.definition})
    if c.positive:
        whole.attrs["positive"] = c.positive
    for x in (whole, _dataset(f, f"{c.name}_lo", lo, c.unit, said, _REST)):
        x.attrs["coordinates"] = "time"
        for axis, scale in zip(x.dims, scales, strict=True):
            axis.attach_scale(scale)


def _about_file(selection: Selection) -> dict[str, str]:
    reference = selection.reference
    use = (
        "The value is <name> + <name>_lo at the time time + time_lo; <name> alone is the double "
        "nearest to the exact value."
    )
    shared = shared_attributes(reference.dataset_version)
    history = f"{shared['history']}; by heyoka-bike export {__version__}"
    return {
        "_NCProperties": f"version=2,h5py={h5py.__version__}",
        "title": title_of(reference.dataset_version),
        "summary": "Rows of " + ", ".join(c.long_name for c in selection.columns),
        **shared,
        "Conventions": CONVENTIONS,
        "history": history,
        "dataset_version": reference.dataset_version,
        "content_sha256": reference.content_sha256,
        "comment": "\n".join(about(selection, "the rows", use)),
    }


def _dataset(
    f: h5py.File, name: str, data: ArrayLike, unit: str, long_name: str, kind: str
) -> h5py.Dataset:
    dataset = f.create_dataset(name, data=data, track_order=True, **_FILTERS)
    about = {"units": unit, "long_name": long_name, "coverage_content_type": kind}
    dataset.attrs.update(about)
    return dataset


# Characters that a file name in #include "..." may contain.
_STEM_OF_FILES = re.compile(r"[A-Za-z0-9_+. -]+")


def c(selection: Selection, stem: str) -> dict[str, bytes]:
    """Write C99: a header and a source file; numbers are hexadecimal and exact.

    Raises
    ------
    InputError
        The name cannot be written in an ``#include``.
    """
    if not _STEM_OF_FILES.fullmatch(stem):
        raise InputError(
            f"--output: found {quoted(stem)}, expected a name of letters, digits and _ + - ."
        )
    use = (
        f"Compile: cc -std=c99 -O2 your-code.c {stem}.c -lm (never with -ffast-math; on processors "
        "that fuse products and sums GCC needs -ffp-contract=off to give the last bits of "
        "heyoka_bike's own evaluation)."
    )
    fields = {
        "names": "\n".join(
            f"    BICYCLE_{c.name.upper()}, /* [{c.unit}] */" for c in selection.columns
        ),
        "data": "".join(f"{line}\n" for line in _c_tables(selection)),
    }
    return _files(selection, stem, use, "//", (".c", ".h"), fields)


def _c_tables(selection: Selection) -> Iterator[str]:
    """Yield C arrays of breaks and coefficients, and the array of maneuvers that refers to them."""

    def block(head: str, values: Sequence[float], tail: str = "};") -> Iterator[str]:
        yield head
        yield from (f"{line}," for line in _lines([x.hex() for x in values], 4))
        yield tail

    for number, m in selection.maneuvers:
        yield from block(f"static const double breaks_{number}[] = {{", m.breaks.tolist())
        for tag, values in (("hi", m.dense.hi), ("lo", m.dense.lo)):
            yield f"static const double {tag}_{number}[][TERMS] = {{"
            for column in selection.columns:
                yield f"/* {column.name} */"
                for piece in values[column.name].tolist():
                    yield from block("{", piece, "},")
            yield "};"
        yield ""
    yield "static const struct maneuver maneuvers[] = {"
    for number, m in selection.maneuvers:
        end = float(m.duration)
        ends = f"{end.hex()}, {float(m.duration - Fraction(end)).hex()}"
        arrays = f"breaks_{number}, hi_{number}, lo_{number}"
        yield f"    {{{number}, {len(m.breaks) - 1}, {ends}, {arrays}}},"
    yield "};"


def fortran(selection: Selection, stem: str) -> dict[str, bytes]:
    """Write a Fortran 2008 module with an elemental evaluator; its 17 digits read back exactly."""
    use = (
        f"Compile: gfortran -O2 {stem}.f90 your-code.f90 (never with -ffast-math); "
        "the module is uncontrolled_bicycle."
    )
    counts = [len(m.breaks) - 1 for _, m in selection.maneuvers]
    fields = {
        "names": "\n".join(
            f"   integer, parameter, public :: bicycle_{c.name} = {i}  ! [{c.unit}]"
            for i, c in enumerate(selection.columns, 1)
        ),
        "columns": len(selection.columns),
        "pieces": sum(counts),
        "numbers": ", ".join(map(str, selection.numbers)),
        "first": ", ".join(map(str, accumulate(counts, initial=1))),
        "data": "\n".join(_fortran_data(selection)),
    }
    return _files(selection, stem, use, "!", (".f90",), fields)


def _fortran_data(selection: Selection) -> Iterator[str]:
    """Yield statements with the breaks and coefficients of all maneuvers, piece by piece."""

    # Fortran allows 132 characters in a line and 255 continuation lines in a statement. Hence each
    # piece of a column has its own statement, with three numbers in a line.
    def statement(place: str, values: Sequence[float]) -> str:
        lines = _lines([f"{x:.16e}_real64" for x in values], 3)
        return f"   data {place} / &\n      " + ", &\n      ".join(lines) + " /"

    piece = 1
    for number, m in selection.maneuvers:
        yield f"   ! maneuver {number}"
        for i in range(len(m.breaks) - 1):
            yield statement(f"starts({piece}), ends({piece})", m.breaks[i : i + 2].tolist())
            for j, column in enumerate(selection.columns, 1):
                yield statement(f"c(:, {piece}, {j})", m.dense.hi[column.name][i].tolist())
            piece += 1


def matlab(selection: Selection, stem: str) -> dict[str, bytes]:
    """Write a function for MATLAB and GNU Octave, named like its file; its numbers have 17 digits.

    Raises
    ------
    InputError
        The name cannot be that of a function.
    """
    check_name(stem, "function")
    use = f"Use: put {stem}.m into your folder; {stem}({selection.numbers[0]}, "
    use += f"'{selection.columns[0].name}', 0:0.01:1)"
    fields = {"data": "\n".join(_matlab_data(selection))}
    return _files(selection, stem, use, "%", (".m",), fields)


def _matlab_data(selection: Selection) -> Iterator[str]:
    def row(values: Sequence[float]) -> str:
        return " ".join(f"{x:.17g}" for x in values)

    for i, (number, m) in enumerate(selection.maneuvers, 1):
        yield f"tables({i}).number = {number};"
        yield f"tables({i}).breaks = [{row(m.breaks.tolist())}];"
        for column in selection.columns:
            yield f"tables({i}).c.{column.name} = ["
            yield from map(row, m.dense.hi[column.name].tolist())
            yield "];"


def _lines(texts: Sequence[str], count: int) -> list[str]:
    """Group texts into lines of `count` each, separated by commas."""
    return [", ".join(texts[i : i + count]) for i in range(0, len(texts), count)]


def _files(
    selection: Selection, stem: str, use: str, mark: str, suffixes: Sequence[str],
    fields: Mapping[str, object],
) -> dict[str, bytes]:  # fmt: skip
    """Return the source files of a language, filled in from templates, by file-name suffix.

    Parameters
    ----------
    mark
        Characters that begin a comment.
    fields
        Fields of this language's templates, in addition to those that all templates have.
    """
    lines = about(selection, "dense output, piecewise Chebyshev polynomials", use)
    words = {"about": commented(lines, mark), "stem": stem, "terms": selection.terms, **fields}
    templates = {x: Path(__file__).with_name(f"evaluator{x}").read_text("ascii") for x in suffixes}
    return {x: Template(text).substitute(words).encode("ascii") for x, text in templates.items()}


FORMATS: Mapping[str, tuple[tuple[str, ...], Callable[..., dict[str, bytes]]]] = {
    "c": ((".c", ".h"), c),
    "fortran": ((".f90",), fortran),
    "matlab": ((".m",), matlab),
    "json": ((".json",), as_json),
    "csv": ((".csv",), as_csv),
    "netcdf": ((".nc",), as_netcdf),
}
"""Suffixes of the files and the function that writes them, by format name on the command line."""
