"""The report as JSON for programs; the schema is `score-1.schema.json`."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from numbers import Integral, Real
from typing import Any

from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Reading
from heyoka_bike.version import __version__

SCHEMA_VERSION = 1

_OF_MANEUVER = (
    "maneuver", "name", "rows", "t_start", "t_end", "coverage", "column_count", "gap", "step",
    "performance", "performance_limit", "meets_limit",
)  # fmt: skip


_OF_REQUIREMENT = ("text", "met", "found", "message")


def render(scored: Report | Series) -> str:
    """Render the report of a file or of a series as JSON; unknown values are null."""
    return json.dumps(document(scored), indent=2, allow_nan=False) + "\n"


def document(scored: Report | Series) -> dict[str, Any]:
    """Return the document that `render` writes, as lists and dictionaries."""
    found = _report(scored) if isinstance(scored, Report) else _series(scored)
    return {name: clean(x) for name, x in found.items()}


def _report(report: Report) -> dict[str, Any]:
    return {
        "schema_version": SCHEMA_VERSION,
        "dataset_version": report.dataset_version,
        "reference_sha256": report.reference_sha256,
        "version": __version__,
        "bicycle": report.bicycle,
        "file": asdict(report.file),
        "maneuvers": [_maneuver(m) for m in report.maneuvers],
        "findings": [_finding(f) for f in report.said],
        "requirements": [_fields(r, _OF_REQUIREMENT) for r in report.requirements],
        "passed": report.passed,
        "is_right": report.is_right,
        "grade": max(report.grades, default=Grade.UNKNOWN).style,
        "is_whole": report.is_whole,
        "stopped_early": report.is_stopped_early,
    }


def _series(series: Series) -> dict[str, Any]:
    return {
        "schema_version": SCHEMA_VERSION,
        "dataset_version": series.runs[0].report.dataset_version,
        "is_one_program": series.is_one_program,
        "runs": [
            _fields(r, ("name", "step", "tolerance", "cpu")) | {"report": _report(r.report)}
            for r in series.runs
        ],
        "convergence": [asdict(c) for c in series.convergence],
        "findings": [_finding(f) for f in series.findings],
        "passed": series.passed,
    }


def _maneuver(m: ManeuverScore) -> dict[str, Any]:
    parts = {"consistency": asdict(m.consistency), "columns": [_column(c) for c in m.columns]}
    return _fields(m, _OF_MANEUVER) | parts


def _column(c: ColumnScore) -> dict[str, Any]:
    return {
        "key": c.key,
        "unit": c.unit,
        "definition": c.as_understood.definition,
        "definition_is_known": c.is_known,
        **asdict(c.as_understood.measures),
        "floor": c.floor,
        "grade": c.grade.style,
        "is_contradicted": c.is_contradicted,
        "values": c.values,
        "missing": c.missing,
        "between": 0,
        "as_written": _reading(c.as_written),
        "as_understood": _reading(c.as_understood),
        "alternatives": [asdict(a) for a in c.alternatives],
        "indistinguishable": c.indistinguishable,
        "growth": [asdict(g) for g in c.growth],
    }


def _reading(r: Reading) -> dict[str, Any]:
    found = asdict(r)
    measures: dict[str, Any] = found.pop("measures")
    return found | measures


def _finding(f: Finding) -> dict[str, Any]:
    return _fields(f, ("code", "severity", "message", "evidence"))


def _fields(x: object, names: Sequence[str]) -> dict[str, Any]:
    return {name: getattr(x, name) for name in names}


def clean(x: Any) -> Any:
    """Convert a value to the types of JSON; NaN and infinities become None."""
    if x is None or isinstance(x, bool):
        return x
    if isinstance(x, str):
        # File names that are not UTF-8 contain lone surrogates, which many JSON readers reject. So
        # write them as backslash escapes.
        return x.encode("utf-8", "backslashreplace").decode("utf-8")
    if isinstance(x, Mapping):
        return {str(clean(k)): clean(v) for k, v in x.items()}
    if isinstance(x, Sequence):
        return [clean(v) for v in x]
    if isinstance(x, Integral):
        return int(x)
    if isinstance(x, Real):
        return float(x) if math.isfinite(x) else None
    if hasattr(x, "tolist"):  # true for NumPy's booleans and arrays
        return clean(x.tolist())
    raise TypeError(f"found {x!r:.60}, expected a value that JSON can represent")
