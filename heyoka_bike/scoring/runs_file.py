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

from heyoka_bike.bicycle.toml_source import TomlSource, kind
from heyoka_bike.errors import quoted
from heyoka_bike.numbers.exact import Exact

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
    source.refuse_unknown(table, _ENTRIES, where)
    if "file" not in table:
        raise source.error(f"found no entry 'file' in run {index + 1}, expected one", where)
    file = source.line_of_text(table, "file", where, limit=4000)
    return ListedRun(
        file=folder / file,
        step=_positive(source, table, "step", index),
        cpu=_positive(source, table, "cpu", index),
        tolerance=_positive(source, table, "tolerance", index),
    )


def _positive(source: TomlSource, table: dict[str, Any], key: str, index: int) -> float | None:
    if key not in table:
        return None
    where = ("run", index, key)
    entry = table[key]
    if isinstance(entry, int) and not isinstance(entry, bool):
        entry = str(entry)
    if not isinstance(entry, str):
        raise source.error(f"{key}: found {kind(entry)}, expected a decimal number", where)
    try:
        value = float(Exact.parse(entry))
    except ValueError as e:
        raise source.error(f"{key}: {e}", where) from None
    if value <= 0:
        raise source.error(f"{key}: found {quoted(entry)}, expected more than zero", where)
    return value
