"""C99: a header and a source file of the dense output and its evaluators, needing nothing else."""

import re
from collections.abc import Iterator
from fractions import Fraction

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.exports.selection import Selection, evaluators
from heyoka_bike.reference.load import ReferenceManeuver

SUFFIXES = (".c", ".h")

# What a name may have to be quoted in #include.
_STEM = re.compile(r"[A-Za-z0-9_+. -]+")
_PER_LINE = 4


def render(selection: Selection, stem: str) -> dict[str, bytes]:
    """The header and the source file; numbers are hexadecimal and exact.

    Raises
    ------
    InputError
        The name cannot be written in an ``#include``.
    """
    if not _STEM.fullmatch(stem):
        raise InputError(
            f"--output: found {quoted(stem)}, expected a name of letters, digits and _ + - ."
        )
    use = (
        f"Compile: cc -std=c99 -O2 your-code.c {stem}.c -lm (never with -ffast-math; on processors "
        "that fuse products and sums GCC needs -ffp-contract=off to give the last bits of "
        "heyoka_bike's own evaluation)."
    )
    names = "\n".join(f"    BICYCLE_{c.name.upper()}, /* [{c.unit}] */" for c in selection.columns)
    tables = "\n".join(
        _tables(n, m, [c.name for c in selection.columns]) for n, m in selection.maneuvers
    )
    entries = "\n".join(_entry(n, m) for n, m in selection.maneuvers)
    data = f"{tables}\nstatic const struct maneuver maneuvers[] = {{\n{entries}\n}};\n"
    return evaluators(selection, stem, use, "//", SUFFIXES, {"names": names, "data": data})


def _tables(number: int, m: ReferenceManeuver, names: list[str]) -> str:
    breaks = "\n".join(_numbers(m.breaks))
    text = f"static const double breaks_{number}[] = {{\n{breaks}\n}};\n"
    for tag, values in (("hi", m.dense.hi), ("lo", m.dense.lo)):
        pieces = []
        for name in names:
            pieces.append(f"/* {name} */")
            pieces += ["{\n" + "\n".join(_numbers(c)) + "\n}," for c in values[name]]
        body = "\n".join(pieces)
        text += f"static const double {tag}_{number}[][TERMS] = {{\n{body}\n}};\n"
    return text


def _numbers(values: Array) -> Iterator[str]:
    texts = [x.hex() for x in values.tolist()]
    for i in range(0, len(texts), _PER_LINE):
        yield ", ".join(texts[i : i + _PER_LINE]) + ","


def _entry(number: int, m: ReferenceManeuver) -> str:
    end = float(m.duration)
    end_lo = float(m.duration - Fraction(end))
    ends = f"{end.hex()}, {end_lo.hex()}"
    arrays = f"breaks_{number}, hi_{number}, lo_{number}"
    return f"    {{{number}, {len(m.breaks) - 1}, {ends}, {arrays}}},"
