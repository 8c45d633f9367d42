"""Selection of the columns to be exported, and the comment at the head of every file."""

import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from string import Template

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, Column
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.reference.description.facts import COPYRIGHT, TITLE
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.version import __version__

ALL = "all"

AXES = (
    "SI units. Axes: x forward, y to the right, z down; roll, steer and yaw positive to the right."
)

_WIDTH = 96
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")  # MATLAB's namelengthmax


@dataclass(frozen=True, slots=True)
class Selection:
    """Maneuvers and columns of a reference that are exported.

    Attributes
    ----------
    reference : Reference
    numbers : tuple of int
        Maneuvers, by their numbers in the reference.
    columns : tuple of Column
    """

    reference: Reference
    numbers: tuple[int, ...]
    columns: tuple[Column, ...]

    @property
    def maneuvers(self) -> Iterator[tuple[int, ReferenceManeuver]]:
        """The maneuvers with their numbers."""
        return ((n, self.reference[n]) for n in self.numbers)

    @property
    def terms(self) -> int:
        """Coefficients of a piece."""
        first = self.reference[self.numbers[0]]
        return int(first.dense.hi[self.columns[0].name].shape[-1])


def choose(reference: Reference, maneuver: int | None, columns: str | None) -> Selection:
    """The maneuver, or all, and the columns as the command line names them.

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


def about(selection: Selection, content: str, use: str) -> list[str]:
    """Lines that say what a file is, in printable ASCII.

    Parameters
    ----------
    selection
    content
        Contents of the file.
    use
        The way to compile or read it.
    """
    reference = selection.reference
    paragraphs = [
        f"{TITLE}: {content}.",
        f"Dataset version {reference.dataset_version}, bicycle {quoted(reference.bicycle)}.",
        f"content_sha256 {reference.content_sha256}",
        f"Written by heyoka-bike export {__version__}. Licence: {COPYRIGHT}.",
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
    """Paragraphs as lines in printable ASCII."""
    lines = []
    for text in paragraphs:
        ascii_only = text.encode("ascii", "backslashreplace").decode()
        indent = "    " if text.startswith("  ") else ""
        lines += textwrap.wrap(ascii_only, _WIDTH, subsequent_indent=indent, break_on_hyphens=False)
    return lines


def described(column: Column) -> str:
    """A column, its unit and its definition on one line."""
    positive = f"; positive {column.positive}" if column.positive else ""
    return f"{column.name} [{column.unit}]: {column.long_name}: {column.meaning}{positive}"


def commented(lines: list[str], mark: str) -> str:
    """The lines as a comment."""
    return "".join(f"{mark} {line}".rstrip() + "\n" for line in lines)


def check_name(stem: str, of: str) -> None:
    """Refuse a name that cannot be that of a function or module.

    Raises
    ------
    InputError
    """
    if not _NAME.fullmatch(stem):
        raise InputError(
            f"--output: found {quoted(stem)}, expected the name of a {of}: a letter, then "
            "letters, digits and _"
        )


def evaluators(
    selection: Selection, stem: str, use: str, mark: str, suffixes: Iterable[str],
    fields: Mapping[str, object],
) -> dict[str, bytes]:  # fmt: skip
    """The dense output and its evaluator in a language, by the suffixes of its files.

    Parameters
    ----------
    mark
        Begins a comment.
    fields
        Of the language's templates, beside those that all have.
    """
    lines = about(selection, "dense output, piecewise Chebyshev polynomials", use)
    words = {"about": commented(lines, mark), "stem": stem, "terms": selection.terms, **fields}
    files = {}
    for suffix in suffixes:
        template = Path(__file__).with_name(f"evaluator{suffix}").read_text("ascii")
        files[suffix] = Template(template).substitute(words).encode("ascii")
    return files


def sharing_times(selection: Selection) -> dict[str, Selection]:
    """The maneuvers that fit into one table, by what is added to the name of its file.

    One table if all have the same times, else one for each maneuver, as in the reference folder.
    """
    grids = {(m.inputs["duration"], m.inputs["spacing"]) for _, m in selection.maneuvers}
    if len(grids) == 1:
        return {"": selection}
    return {
        f"-{n}": Selection(selection.reference, (n,), selection.columns) for n in selection.numbers
    }


def row_times(maneuver: ReferenceManeuver) -> list[Fraction]:
    """Exact times of the rows [s]."""
    spacing = Fraction(maneuver.inputs["spacing"])
    return [i * spacing for i in range(len(maneuver.time))]
