"""MATLAB and GNU Octave: a function file with the dense output and its evaluator."""

from collections.abc import Iterable, Iterator

from heyoka_bike.reference.exports.selection import Selection, check_name, evaluators

SUFFIXES = (".m",)


def render(selection: Selection, stem: str) -> dict[str, bytes]:
    """The function, named as its file must be; 17 digits are read back exactly.

    Raises
    ------
    InputError
        The name is not that of a function.
    """
    check_name(stem, "function")
    use = f"Use: put {stem}.m into your folder; {stem}({selection.numbers[0]}, "
    use += f"'{selection.columns[0].name}', 0:0.01:1)"
    return evaluators(selection, stem, use, "%", SUFFIXES, {"data": "\n".join(_data(selection))})


def _data(selection: Selection) -> Iterator[str]:
    for i, (number, m) in enumerate(selection.maneuvers, 1):
        yield f"tables({i}).number = {number};"
        yield f"tables({i}).breaks = [{_row(m.breaks.tolist())}];"
        for column in selection.columns:
            yield f"tables({i}).c.{column.name} = ["
            yield from (_row(piece) for piece in m.dense.hi[column.name].tolist())
            yield "];"


def _row(values: Iterable[float]) -> str:
    return " ".join(f"{x:.17g}" for x in values)
