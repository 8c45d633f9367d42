"""The exact motion and the scoring of result files in one C header, without Python.

The state is stored in the published pieces, without the coefficients that binary64 cannot resolve.
Code that computes the columns from the state is generated from `Equations`. Columns are interpreted
as in `scoring.definitions`, but in C; `tests/workbench/test_checker_agrees_with_score.py` compares
the two. Words and limits are those of the verdict.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from string import Template

import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DERIVATIVES
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.double import Array, median
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.straight_line import C, Recorded, StraightLine
from heyoka_bike.reference.exports.formats import Selection, about, commented
from heyoka_bike.reference.following import FOLLOWS
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.scoring.grades import CLOSE_DIGITS, RIGHT_DIGITS, TOLERANCE, Grade
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.units import UNITS, factor
from heyoka_bike.showing.wording.grade_text import WORDS
from heyoka_bike.showing.wording.verdict_text import PHRASES

# The state that the header stores: the variables of the reduced equations, but the forward speed
# instead of the spin.
_STATES_STORED = (
    "roll_angle",
    "pitch",
    "steer_angle",
    "roll_rate",
    "steer_rate",
    "forward_speed",
    "yaw",
)
# Trailing Chebyshev coefficients are left out if the sum of their magnitudes is below this fraction
# of the column's scale.
_NEGLIGIBLE = 2.0**-57
_PER_LINE = 4


def checker_header(reference: Reference) -> bytes:
    """Return the C header for the bicycle and the maneuvers of a reference."""
    first = reference[1]
    keys = first.definitions
    columns = [first.definitions[key][0] for key in BENCHMARK_COLUMNS]
    columns += [c for key in BENCHMARK_COLUMNS for c in keys[key][1:]]
    names = [c.name for c in columns]
    kept = {n: _kept(reference[n]) for n in reference}
    content = "the exact motion, and how many digits of your results are right"
    use = (
        "C99, or C++11 and later, and libm. bicycle_evaluate gives the exact motion; "
        "bicycle_begin, bicycle_give and bicycle_judge, or bicycle_check_table alone, judge your "
        "columns; bicycle_line returns the verdict in one line. Nothing is allocated, 150 kB of "
        "stack are used. It does less than heyoka-bike score: it reads no files, knows no units "
        "but those below, looks for no mistake, does not judge eq. (1), and counts no more than 14 "
        "digits."
    )
    lines = about(Selection(reference, tuple(reference), tuple(columns)), content, use)
    fields = {
        "about": commented(lines, "//"),
        "names": "\n".join(f"    BICYCLE_{n.upper()}, /* [{c.unit}] */"
                           for n, c in zip(names, columns, strict=True)),
        "maneuvers": len(reference),
        "grades": ",\n".join(f"    BICYCLE_{g.name} = {g:d}" for g in Grade),
        "states": ", ".join(_STATES_STORED),
        "terms": max(len(c) for pieces in kept.values() for p in pieces for c in p),
        "data": "\n".join(_data(reference, kept, columns, names)),
        "columns": _columns_function(reference, names),
    }  # fmt: skip
    template = Path(__file__).with_name("header.h").read_text("ascii")
    return Template(template).substitute(fields).encode("ascii")


def _kept(m: ReferenceManeuver) -> list[list[Array]]:
    """Return, for each piece and state variable, the coefficients that are not `_NEGLIGIBLE`."""
    found = []
    for piece in range(len(m.breaks) - 1):
        rows = [m.dense.hi[name][piece] for name in _STATES_STORED]
        limits = [_NEGLIGIBLE * m.scale(name) for name in _STATES_STORED]
        found.append([_seen(c, limit) for c, limit in zip(rows, limits, strict=True)])
    return found


def _seen(coefficients: Array, limit: float) -> Array:
    rest = np.cumsum(np.abs(coefficients[::-1]))[::-1]
    return coefficients[: max(1, int(np.count_nonzero(rest > limit)))]


def _data(
    reference: Reference, kept: Mapping[int, list[list[Array]]], columns: Sequence[Column],
    names: Sequence[str],
) -> Iterator[str]:  # fmt: skip
    places = {(c.key, c.definition): i for i, c in enumerate(columns)}
    yield "static const ub_column ub_names[BICYCLE_COLUMNS] = {"
    for c in columns:
        angle = places.get(DERIVATIVES.get((c.key, c.definition), ("", "")), -1)
        of = BENCHMARK_COLUMNS.index(c.key)
        yield f'    {{"{c.key}", "{c.definition}", {of}, {angle}}},'
    units = [UNITS[c.unit] for c in columns[: len(BENCHMARK_COLUMNS)]]
    yield f"}};\nenum {{ UB_UNITS = {max(map(len, units))} }};"
    yield "static const ub_unit ub_units[BICYCLE_KEYS][UB_UNITS] = {"
    for tried in units:
        known = (f'{{"{unit}", {factor(unit)[0]!r}}}' for unit in tried)
        yield f"    {{{', '.join(known)}}},"
    yield "};\nstatic const char *const ub_words[] = {"
    yield "    " + ", ".join(f'"{WORDS.get(g, "")}"' for g in Grade)
    yield "};"
    for name, text in PHRASES.items():
        yield f'#define UB_{name.upper()} "{text}"'
    yield f"#define UB_MOST_APART {reference.most_apart!r} /* [s], of rows that cover the run */"
    yield f"#define BICYCLE_RIGHT_DIGITS {RIGHT_DIGITS!r} /* or more is right */"
    yield f"#define BICYCLE_CLOSE_DIGITS {CLOSE_DIGITS!r} /* or more is close */"
    yield f"#define UB_TOLERANCE {TOLERANCE!r}\n"
    for n, pieces in kept.items():
        yield f"static const ub_piece ub_pieces_{n}[] = {{"
        ends = reference[n].breaks.tolist()
        for a, b, states in zip(ends, ends[1:], pieces, strict=False):
            yield f"{{{a!r}, {b!r}, {{"
            yield from (f"{{{_numbers(c.tolist())}}}," for c in states)
            yield "}},"
        yield "};"
    yield "static const ub_maneuver ub_maneuvers[BICYCLE_MANEUVERS] = {"
    for n in reference:
        m = reference[n]
        height = m["potential_energy"]
        numbers = [float(m.duration), m.reach, rms(height - median(height))]
        scales = _numbers(m.scale(name) for name in names)
        yield f"{{ub_pieces_{n}, {len(kept[n])}, {_numbers(numbers)}, {{\n{scales}}}}},"
    yield "};\n"


def _numbers(values: Iterable[float]) -> str:
    texts = [repr(float(x)) for x in values]
    return ",\n".join(", ".join(texts[i : i + _PER_LINE]) for i in range(0, len(texts), _PER_LINE))


def _columns_function(reference: Reference, names: Sequence[str]) -> str:
    parameters = {name: Exact.parse(text) for name, text in reference.parameters.items()}
    rounded = Equations.binary64(Bicycle(reference.bicycle, parameters))

    def columns(code: StraightLine, y: Sequence[Recorded]) -> list[Recorded]:
        p = {name: code.literal(float(value)) for name, value in exact.items()}
        state = [*y[:5], y[5] / p["rR"], y[6]]
        found = dict(rounded.convert(code.literal, code).columns(state))
        for name in names:
            if name not in found:
                found[name] = FOLLOWS[name].formula(code, found, p)
        return [found[name] for name in names]

    exact = {name: parameters[name].rational for name in ("rR", "xB", "zB")}
    return "BICYCLE_API " + C.function("ub_columns", {"y": len(_STATES_STORED)}, "c", columns)
