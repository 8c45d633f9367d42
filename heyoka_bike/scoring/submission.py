"""A submission to the leaderboard: a small TOML file that says what made some result files.

    name = "Exudyn, trapezoidal rule, h = 0.001"
    problem = "H1"
    program = "Exudyn"
    version = "1.13.6"
    method = "implicit trapezoidal rule, index 2"
    coordinates = "Euler parameters of each body, constraints of rolling"
    precision = "binary64"
    step = "0.001"
    processor_time = "48.5"
    machine = "AMD EPYC 7763, 1 core, Linux, wheel of PyPI"
    licence = "CC0-1.0"
    contact = "https://github.com/jgerstmayr/EXUDYN"

    [[file]]
    path = "exudyn-h0.001.txt"
    sha256 = "..."

Paths are relative to the file and stay below its folder. The problems are those of
docs/harder-tier.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from re import fullmatch
from typing import Any

from heyoka_bike.bicycle.toml_source import TomlSource, kind
from heyoka_bike.errors import quoted

_REQUIRED = (
    "name", "problem", "program", "version", "method", "coordinates", "precision",
    "processor_time", "machine", "licence", "contact",
)  # fmt: skip
_OPTIONAL = ("step", "tolerance", "model", "wall_time", "steps", "calls")
_FILE = ("path", "sha256", "maneuver")
_LONGEST = 500


@dataclass(frozen=True, slots=True)
class RankedProblem:
    """A problem of the leaderboard.

    Attributes
    ----------
    inputs
        Names of the bicycle and the maneuvers in ``data`` that its set is made of.
    numbers
        Of the maneuvers, in the set of these inputs.
    """

    inputs: tuple[str, str]
    numbers: tuple[int, ...]


_EDGE = ("benchmark", "harder/edge-of-falling")

PROBLEMS: Mapping[str, RankedProblem] = {
    "H1": RankedProblem(("benchmark", "benchmark"), (1, 2, 3)),
    "H2": RankedProblem(("benchmark", "harder/longer"), (1,)),
    **{f"H3{x}": RankedProblem(_EDGE, (n,)) for n, x in enumerate("abcdefg", start=1)},
    "H4": RankedProblem(("browser-jason", "harder/another-bicycle"), (1, 2, 3)),
}
"""Problems of docs/harder-tier.md by name; in H3 each maneuver is a problem of its own."""


@dataclass(frozen=True, slots=True)
class SubmittedFile:
    """A result file of a submission.

    Attributes
    ----------
    path : Path
    sha256
    maneuver
        That it holds, if it is of one; None if the file says so, or its values do.
    """

    path: Path
    sha256: str
    maneuver: int | None


@dataclass(frozen=True, slots=True)
class Submission:
    """The entries of a submission.

    Attributes
    ----------
    source : Path
        Its file.
    problem
        A key of `PROBLEMS`.
    said : mapping of str to str
        Every entry as text.
    processor_time
        Of all maneuvers of the problem [s].
    files : tuple of SubmittedFile
    """

    source: Path
    problem: str
    said: Mapping[str, str]
    processor_time: float
    files: tuple[SubmittedFile, ...]

    @property
    def name(self) -> str:
        """Its entry ``name``."""
        return self.said["name"]


def read_submission(path: str | Path) -> Submission:
    """Read a submission.

    Raises
    ------
    InputError
        With file, line and column: unreadable, an entry that is missing, unknown or not as it
        should be.
    """
    source = TomlSource.load(path)
    tree = source.tree
    source.refuse_unknown(tree, {*_REQUIRED, *_OPTIONAL, "file"}, (), _REQUIRED)
    said = {
        key: source.line_of_text(tree, key, (), limit=_LONGEST) for key in tree if key != "file"
    }
    if said["problem"] not in PROBLEMS:
        raise source.error(
            f"problem: found {quoted(said['problem'])}, expected one of {', '.join(PROBLEMS)}",
            ("problem",),
        )
    if ("step" in said) == ("tolerance" in said):
        found = "both" if "step" in said else "neither"
        raise source.error(f"found {found} of step and tolerance, expected one of them", ())
    times = {
        key: source.positive(said, key, ())
        for key in ("processor_time", "wall_time", "step", "tolerance")
        if key in said
    }
    files = tuple(
        _read_file(source, table, i, Path(path).parent)
        for i, table in enumerate(source.tables("file"))
    )
    return Submission(Path(path), said["problem"], said, times["processor_time"], files)


def _read_file(
    source: TomlSource, table: dict[str, Any], index: int, folder: Path
) -> SubmittedFile:
    where = ("file", index)
    source.refuse_unknown(table, _FILE, where, ("path", "sha256"))
    path = PurePosixPath(source.line_of_text(table, "path", where))
    if path.is_absolute() or ".." in path.parts or "\\" in str(path):
        raise source.error(
            f"path: found {quoted(str(path))}, expected one below the folder of this file",
            (*where, "path"),
        )
    sha256 = source.line_of_text(table, "sha256", where)
    if not fullmatch("[0-9a-f]{64}", sha256):
        raise source.error(
            f"sha256: found {quoted(sha256)}, expected 64 hexadecimal digits, as sha256sum prints "
            "them",
            (*where, "sha256"),
        )
    number = table.get("maneuver")
    if number is not None and (type(number) is not int or number < 1):
        found = str(number) if type(number) is int else kind(number)
        raise source.error(
            f"maneuver: found {found}, expected a number from 1", (*where, "maneuver")
        )
    return SubmittedFile(folder / path, sha256, number)
