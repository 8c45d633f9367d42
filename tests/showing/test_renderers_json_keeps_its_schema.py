"""The JSON of a score follows its published schema, which rejects other documents."""

import copy
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import heyoka_bike
from generators import sample_reports
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.series import read_runs, score_files
from heyoka_bike.showing.formats import json as renderer

SCHEMA = json.loads(
    (Path(heyoka_bike.__file__).parent / "showing" / "formats" / "score-1.schema.json").read_text()
)
PEERS = Path(__file__).parents[2] / "data" / "peers"
SAMPLES = (
    "sample", "perfect", "rough", "one_row", "half", "without_columns", "nothing", "no_maneuvers",
    "hostile", "series", "programs",
)  # fmt: skip


def problems(document):
    validator = jsonschema.Draft202012Validator(SCHEMA)
    return [error.message for error in validator.iter_errors(document)]


def refuse(text):
    raise AssertionError(f"{text} is not JSON")


def read(scored):
    return json.loads(renderer.render(scored), parse_constant=refuse)


def required_places(schema, document, path=()):
    """Yield the places in a document where the schema requires a key."""
    if "$ref" in schema:
        schema = schema | SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]]
    for part in schema.get("allOf", ()):
        yield from required_places(part, document, path)
    if isinstance(document, dict):
        yield from ((*path, key) for key in schema.get("required", ()))
        for key, part in schema.get("properties", {}).items():
            if key in document:
                yield from required_places(part, document[key], (*path, key))
    if isinstance(document, list) and document and "items" in schema:
        yield from required_places(schema["items"], document[0], (*path, 0))


def changed(document, path, change):
    document = copy.deepcopy(document)
    *way, last = path
    inner = document
    for step in way:
        inner = inner[step]
    change(inner, last)
    return document


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("name", SAMPLES)
def test_every_report_follows_the_schema(name):
    assert problems(read(getattr(sample_reports, name)())) == []


def test_scores_of_shipped_results_follow_the_schema():
    for name in ("exudyn", "scipy"):
        files, told = read_runs(PEERS / f"{name}.toml")
        series = score_files(
            [read_results(file) for file in files],
            steps=None if None in told["step"] else told["step"],
            cpu=told["cpu"],
        )
        document = read(series)
        assert problems(document) == []
        assert problems(document["runs"][0]["report"]) == []


@pytest.mark.parametrize(("name", "definition"), [("sample", "report"), ("series", "series")])
def test_a_dropped_key_or_a_wrong_type_is_refused(name, definition):
    document = read(getattr(sample_reports, name)())
    # A shortened report is enough for this test, and much faster than the whole one.
    report = document if definition == "report" else document["runs"][0]["report"]
    report["maneuvers"] = report["maneuvers"][:1]
    report["maneuvers"][0]["columns"] = report["maneuvers"][0]["columns"][:1]
    if definition == "series":
        document["runs"] = document["runs"][:1]
        document["convergence"] = document["convergence"][:1]
    assert problems(document) == []
    places = sorted(set(required_places(SCHEMA["$defs"][definition], document)), key=str)
    # The list of places includes all measures of docs/measures.md, in both interpretations.
    assert len(places) > 75
    for path in places:
        assert problems(changed(document, path, lambda x, key: x.pop(key))), path
        assert problems(changed(document, path, lambda x, key: x.update({key: {"a": [1]}}))) or (
            path[-1] == "evidence"
        ), path


def test_new_keys_are_welcome():
    document = read(sample_reports.sample())
    for path in ((), ("file",), ("maneuvers", 0), ("maneuvers", 0, "columns", 0), ("findings", 0)):
        assert problems(changed(document, (*path, "news"), lambda x, key: x.update({key: 1}))) == []


def test_numbers_are_those_of_the_report():
    report = sample_reports.sample()
    document = read(report)
    for m, maneuver in zip(report.maneuvers, document["maneuvers"], strict=True):
        assert maneuver["performance"] == m.performance
        for c, column in zip(m.columns, maneuver["columns"], strict=True):
            for reading in ("as_written", "as_understood"):
                for name in c.as_written.measures.__slots__:
                    expected = getattr(getattr(c, reading).measures, name)
                    assert column[reading][name] == expected, (c.key, name)
            assert column["max_abs_error"] == c.as_understood.measures.max_abs_error
            assert column["definition"] == c.as_understood.definition
            assert len(column["growth"]) == 10
    assert document["passed"] is True
    assert read(sample_reports.rough())["passed"] is False


def test_traces_stay_out():
    assert "trace" not in renderer.render(sample_reports.sample())


def test_what_is_not_finite_is_null():
    report = sample_reports.sample()
    first, *rest = report.maneuvers
    odd = replace(first, performance=float("inf"), step=float("nan"), rows=np.int64(7))
    numbers = {"a": np.float64("nan"), "b": np.bool_(True), "c": np.ones(2)}
    finding = Finding("odd", "it has numbers", evidence=numbers)
    document = read(replace(report, maneuvers=(odd, *rest), diagnosis=(finding,)))
    assert document["maneuvers"][0]["performance"] is None
    assert document["maneuvers"][0]["step"] is None
    assert document["maneuvers"][0]["rows"] == 7
    assert document["findings"][0]["evidence"] == {"a": None, "b": True, "c": [1.0, 1.0]}
    assert problems(document) == []


def test_any_file_name_gives_text_that_every_reader_takes():
    text = renderer.render(sample_reports.hostile())
    assert text.isascii()
    path = json.loads(text)["file"]["path"]
    # A byte that is not UTF-8 is written as its escape sequence. All other bytes are preserved.
    assert path == sample_reports.HOSTILE.replace("\udcff", "\\udcff")


def test_a_series_has_its_runs_in_order():
    document = read(sample_reports.series())
    assert [run["step"] for run in document["runs"]] == [0.01, 0.005, 0.0025, 0.00125]
    assert all(run["report"]["schema_version"] == 1 for run in document["runs"])
    assert {len(c["errors"]) - len(c["orders"]) for c in document["convergence"]} == {1}
