"""JSON: the rows and the dense output; `export-1.schema.json` describes it."""

import json

from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.exports.selection import Selection, about
from heyoka_bike.reference.values import Values

SUFFIXES = (".json",)

SCHEMA_VERSION = 1


def render(selection: Selection, stem: str) -> dict[str, bytes]:
    """One document; each number reads back as the same binary64."""
    use = (
        "rows: the value is <name> + <name>_lo at the time time + time_lo. pieces: the column is "
        "sum_k c_k T_k(x), c = <name>[p] + <name>_lo[p], x = 2 (t - a) / (b - a) - 1, "
        "from a = breaks[p] to b = breaks[p + 1]."
    )
    document = {
        "about": about(selection, "rows and dense output, piecewise Chebyshev polynomials", use),
        "schema_version": SCHEMA_VERSION,
        "dataset_version": selection.reference.dataset_version,
        "content_sha256": selection.reference.content_sha256,
        "bicycle": selection.reference.bicycle,
        "parameters": dict(selection.reference.parameters),
        "columns": [
            {
                "name": c.name, "key": c.key, "definition": c.definition, "unit": c.unit,
                "meaning": c.meaning, "positive": c.positive,
            }
            for c in selection.columns
        ],
        "maneuvers": {
            f"maneuver_{n}": {"name": m.name, **m.inputs} for n, m in selection.maneuvers
        },
        "rows": {
            f"maneuver_{n}": _lists(selection, m.rows, time=m.time, time_lo=m.time_lo)
            for n, m in selection.maneuvers
        },
        "pieces": {
            f"maneuver_{n}": _lists(selection, m.dense, breaks=m.breaks)
            for n, m in selection.maneuvers
        },
    }  # fmt: skip
    return {".json": (json.dumps(document, indent=1, allow_nan=False) + "\n").encode("ascii")}


def _lists(selection: Selection, values: Values, **times: Array) -> dict[str, list[float]]:
    """Times and columns by name, hi and lo."""
    found = dict(times)
    for column in selection.columns:
        found[column.name] = values.hi[column.name]
        found[f"{column.name}_lo"] = values.lo[column.name]
    return {name: x.tolist() for name, x in found.items()}
