"""Fortran 2008: a module with the dense output and an elemental evaluator."""

from collections.abc import Iterator, Sequence
from itertools import accumulate

from heyoka_bike.reference.exports.selection import Selection, evaluators

SUFFIXES = (".f90",)

# A line may have 132 characters and a statement 255 continuation lines: a statement for each piece
# of a column, and three numbers in a line.
_PER_LINE = 3


def render(selection: Selection, stem: str) -> dict[str, bytes]:
    """The module; 17 digits, which every compiler that rounds correctly reads exactly."""
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
        "data": "\n".join(_data(selection)),
    }
    return evaluators(selection, stem, use, "!", SUFFIXES, fields)


def _data(selection: Selection) -> Iterator[str]:
    """Statements with the breaks and coefficients, the pieces of all maneuvers in a row."""
    piece = 1
    for number, m in selection.maneuvers:
        yield f"   ! maneuver {number}"
        for i in range(len(m.breaks) - 1):
            a, b = m.breaks[i : i + 2].tolist()
            yield _statement(f"starts({piece}), ends({piece})", (a, b))
            for j, column in enumerate(selection.columns, 1):
                values = m.dense.hi[column.name][i].tolist()
                yield _statement(f"c(:, {piece}, {j})", values)
            piece += 1


def _statement(place: str, values: Sequence[float]) -> str:
    texts = [f"{x:.16e}_real64" for x in values]
    lines = [", ".join(texts[i : i + _PER_LINE]) for i in range(0, len(texts), _PER_LINE)]
    return f"   data {place} / &\n      " + ", &\n      ".join(lines) + " /"
