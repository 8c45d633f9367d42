"""A list of the runs of a program: a small TOML file of result files, step sizes and times.

    [[run]]
    file = "h0.01.txt"
    step = "0.01"
    cpu = "0.53"

``file`` is relative to the list; ``step`` [s] and ``cpu`` [s] are decimals, both may be left out.
A ``tolerance`` says that the solver chose its steps: how the error follows it is sought instead.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.toml_source import TomlSource

_ENTRIES = {"file", "step", "tolerance", "cpu"}


@dataclass(frozen=True, slots=True)
class ListedRun:
    """One entry of a list of runs.

    Attributes
    ----------
    file : Path
    step, cpu
        Step size and processor time [s]; None if not given.
    tolerance
        Of a solver that chooses its steps; None if not given.
    """

    file: Path
    step: float | None
    cpu: float | None
    tolerance: float | None


def read_runs(path: str | Path) -> tuple[ListedRun, ...]:
    """Read a list of runs.

    Raises
    ------
    InputError
        With file, line and column: unreadable, an unknown entry, or a value that is not a positive
        decimal.
    """
    source = TomlSource.load(path)
    source.refuse_unknown(source.tree, {"run"}, ())
    return tuple(
        _read_run(source, table, i, Path(path).parent)
        for i, table in enumerate(source.tables("run"))
    )


def _read_run(source: TomlSource, table: dict[str, Any], index: int, folder: Path) -> ListedRun:
    where = ("run", index)
    source.refuse_unknown(table, _ENTRIES, where, ("file",))
    file = source.line_of_text(table, "file", where, limit=4000)
    return ListedRun(
        file=folder / file,
        **{
            key: source.positive(table, key, where) if key in table else None
            for key in ("step", "cpu", "tolerance")
        },
    )
