"""Ordinary readers of CSV and JUnit XML find the values of the report in these formats."""

import csv
import io
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from generators import sample_reports
from heyoka_bike.scoring.requirements import check
from heyoka_bike.showing.formats import csv as csv_renderer
from heyoka_bike.showing.formats import junit

MEASURES = (
    "max_abs_error", "time_of_max", "rms_error", "max_rel_error", "scd", "mescd",
    "time_to_tolerance",
)  # fmt: skip


def rows(scored):
    return list(csv.DictReader(io.StringIO(csv_renderer.render(scored), newline=""), strict=True))


def number(text):
    return float(text) if text else None


def suites(scored):
    root = ElementTree.fromstring(junit.render(scored).encode())
    assert root.tag == "testsuites"
    return root, list(root)


def test_csv_has_a_line_for_each_maneuver_and_column():
    report = sample_reports.sample()
    found = rows(report)
    columns = [(m, c) for m in report.maneuvers for c in m.columns]
    assert len(found) == len(columns) == 24
    for row, (m, c) in zip(found, columns, strict=True):
        assert (row["maneuver"], row["column"]) == (str(m.maneuver), c.key)
        for name in MEASURES:
            assert number(row[name]) == getattr(c.as_understood.measures, name)
        assert number(row["as_written_max_abs_error"]) == c.as_written.measures.max_abs_error
        assert number(row["performance"]) == m.performance
        assert (row["definition"], int(row["sign"])) == (
            c.as_understood.definition, c.as_understood.sign,
        )  # fmt: skip
        assert (row["written_unit"], number(row["offset"])) == (
            c.as_understood.unit, c.as_understood.offset,
        )  # fmt: skip


def test_csv_is_rfc_4180():
    text = csv_renderer.render(sample_reports.hostile())
    lines = re.sub(r'"(?:[^"]|"")*"', "", text).split("\r\n")
    # The file has one line for the heading and one line for each column. Outside of quotes, lines
    # end with CR LF only.
    assert len(lines) == 1 + 24 + 1
    assert not re.search(r"[\r\n]", "".join(lines))
    assert {line.count(",") for line in lines[:-1]} == {len(csv_renderer.FIELDS) - 1}
    expected = sample_reports.HOSTILE.replace("\udcff", "\\udcff")
    assert {row["file"] for row in rows(sample_reports.hostile())} == {expected}
    text.encode()


def test_csv_of_a_series_names_the_run():
    found = rows(sample_reports.series())
    assert len(found) == 4 * 24
    assert [row["run"] for row in found[::24]] == ["1", "2", "3", "4"]
    assert [number(row["run_step"]) for row in found[::24]] == [0.01, 0.005, 0.0025, 0.00125]
    assert number(found[0]["run_cpu"]) == 2.0


def test_unknown_is_empty_in_csv():
    (row, *_), columns = rows(sample_reports.nothing()), rows(sample_reports.nothing())
    assert len(columns) == 8
    assert all(row[name] == "" for name in (*MEASURES, "floor", "performance"))
    assert row["missing"] == "1001"


def test_junit_has_a_case_for_each_column_that_a_requirement_speaks_of():
    report = sample_reports.sample()
    asked = ("scd >= 6", "2.roll_angle.mescd >= 1e2", "performance < 1e-3", "3.yaw.scd > 1")
    report = replace(report, requirements=check(asked, report))
    _, (suite,) = suites(report)
    found = {case.get("name"): case.find("failure") for case in suite.findall("testcase")}
    columns = [f"{m.maneuver}.{c.key}.scd >= 6" for m in report.maneuvers for c in m.columns]
    maneuvers = [f"{m.maneuver}.performance < 0.001" for m in report.maneuvers]
    assert list(found) == [
        *columns, "2.roll_angle.mescd >= 100", *maneuvers, "3.yaw.scd > 1"
    ]  # fmt: skip
    for m in report.maneuvers:
        for c in m.columns:
            value = c.shown("scd")
            is_met = value is not None and value >= 6
            assert (found[f"{m.maneuver}.{c.key}.scd >= 6"] is None) == is_met
    assert found["2.roll_angle.mescd >= 100"] is not None
    # If the file lacks a column, the test case contains only the requirement.
    assert "in the file" in found["3.yaw.scd > 1"].get("message")


def test_a_requirement_that_no_column_tells_of_is_a_case():
    report = sample_reports.rough()
    root, (suite,) = suites(report)
    cases = suite.findall("testcase")
    assert [case.get("name") for case in cases] == [r.text for r in report.requirements]
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("3", "1", "0")
    assert (root.get("tests"), root.get("failures")) == ("3", "1")
    (failure,) = suite.iter("failure")
    assert failure.get("message") == "-0.5 (maneuver 1, roll_angle)"
    assert cases[2].find("failure") is failure
    assert "timestamp" not in suite.attrib


def test_junit_without_requirements_has_a_passing_case_for_each_column():
    report = replace(sample_reports.sample(), requirements=())
    _, (suite,) = suites(report)
    names = [case.get("name") for case in suite.findall("testcase")]
    assert names == [f"{m.maneuver}.{c.key}" for m in report.maneuvers for c in m.columns]
    assert (suite.get("tests"), suite.get("failures")) == ("24", "0")


def test_junit_has_the_measures_as_properties_and_the_findings_as_output():
    report = sample_reports.sample()
    _, (suite,) = suites(report)
    properties = {p.get("name"): p.get("value") for p in suite.iter("property")}
    for m in report.maneuvers:
        for c in m.columns:
            for name in MEASURES:
                value = getattr(c.as_understood.measures, name)
                found = properties.get(f"{m.maneuver}.{c.key}.{name}")
                assert (None if found is None else float(found)) == value
    said = suite.find("system-out").text
    assert all(f.message in said for f in report.findings)
    assert said.index("warning:") < said.index("info:")


@pytest.mark.parametrize("name", ["sample", "hostile", "nothing", "no_maneuvers", "series"])
def test_junit_follows_the_order_that_readers_expect(name):
    root, found = suites(getattr(sample_reports, name)())
    for suite in found:
        tags = [child.tag for child in suite]
        count = len(tags) - 2
        assert tags == ["properties", *["testcase"] * count, "system-out"]
        assert int(suite.get("tests")) == count
        assert {"name", "tests", "failures", "errors", "skipped", "time"} == set(suite.attrib)
        assert all(case.get("classname") and case.get("name") for case in suite.iter("testcase"))
        assert len({suite.get("name") for suite in root}) == len(root)


def test_junit_of_a_series_has_a_suite_for_each_run():
    series = sample_reports.series()
    root, found = suites(series)
    assert [s.get("name") for s in found] == [r.report.file.path for r in series.runs]
    assert root.get("tests") == "8"
    # Test cases of different runs must have distinct names.
    assert len({case.get("classname") for case in root.iter("testcase")}) == 4
    assert series.findings[0].message in found[-1].find("system-out").text


def test_junit_has_no_letter_that_xml_forbids():
    text = junit.render(sample_reports.hostile())
    assert not re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]", text)
    _, (suite,) = suites(sample_reports.hostile())
    name = suite.get("name")
    assert name.startswith("a<script>alert(1)</script><b onclick=alert(1)>&\"'")
    assert "\\x1b[31m\\x00\\udcff" in name


@pytest.mark.parametrize("name", ["=cmd|calc.txt", "+1.txt", "-1.txt", "@SUM(A1).txt"])
def test_a_name_is_no_formula_of_a_spreadsheet(name):
    """A spreadsheet executes a cell with such a start; negative numbers remain numbers."""
    report = sample_reports.sample()
    report = replace(report, file=replace(report.file, path=name))
    rows = list(csv.DictReader(io.StringIO(csv_renderer.render(report))))
    assert {row["file"] for row in rows} == {f"'{name}"}
    cells = [cell for row in rows for key, cell in row.items() if key != "file"]
    assert not any(cell.startswith(("=", "+", "@", "'")) for cell in cells)
    assert all(float(cell) < 0 for cell in cells if cell.startswith("-"))
