"""The tutorial's cells run in order, display reports, and find what the text says."""

import ast
import json
import tempfile

import pytest

from heyoka_bike.system.resources import data_folder

pytest.importorskip("matplotlib")

DOCS = data_folder().parent / "docs"


def cells():
    notebook = json.loads((DOCS / "tutorial.ipynb").read_text(encoding="utf-8"))
    return [c for c in notebook["cells"] if c["cell_type"] == "code"]


def shown(code, number, namespace):
    """The output of a notebook's cell: the value of its last expression."""
    tree = ast.parse(code)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, f"cell {number}", "exec"), namespace)
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), namespace)


def test_outputs_are_not_kept():
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in cells())


@pytest.mark.proof
def test_every_cell_runs(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.chdir(DOCS)
    monkeypatch.setenv("MPLBACKEND", "agg")
    before = {p.name for p in DOCS.iterdir()}
    namespace = {"__name__": "tutorial"}
    results = [
        shown("".join(c["source"]), number, namespace) for number, c in enumerate(cells(), start=1)
    ]
    reports = [x for x in results if hasattr(x, "_repr_html_")]
    assert len(reports) == 5
    file, own, series, diagnosed, mine = reports
    assert all("<table" in x._repr_html_() for x in reports)
    assert file.worst.scd < 3 < own.worst.scd
    assert mine.worst.scd > 10
    (explained,) = (f for f in diagnosed.diagnosis if f.code == "parameters")
    ((changed,), *_) = explained.evidence["changes"]
    assert changed["unknown"] == "xB"
    assert round(changed["value"], 6) == 0.33
    (order,) = (f.message for f in series.findings if "order" in f.message)
    assert "Observed order of convergence: 4.0" in order
    said = capsys.readouterr().out
    assert "benchmark: from 4.292382536 to 6.024262015 m/s" in said
    assert {p.name for p in DOCS.iterdir()} == before
