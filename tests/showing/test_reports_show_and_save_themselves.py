"""A report, a maneuver or a series has a short text, and is saved completely."""

import json
import re
from dataclasses import replace

import pytest

from generators import sample_reports
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.showing.formats import csv, output, summary
from heyoka_bike.showing.formats import json as json_format
from support.pages import Page
from support.without_packages import python

SAMPLES = (
    "sample", "perfect", "rough", "one_row", "half", "without_columns", "nothing", "no_maneuvers",
    "hostile", "series", "programs",
)  # fmt: skip


@pytest.fixture(params=SAMPLES)
def scored(request):
    return getattr(sample_reports, request.param)()


@pytest.fixture(scope="module")
def report():
    return sample_reports.sample()


def test_what_is_shown_is_the_summary(scored):
    assert repr(scored) == summary.render(scored, 100, False, in_python=True).rstrip()
    assert "heyoka-bike" not in repr(scored)
    assert "--" not in repr(scored)
    assert len(repr(scored).splitlines()) <= 10
    assert repr(scored).startswith(scored.verdict.partition(":")[0][:20])


def test_what_is_printed_is_what_the_command_prints(report):
    assert str(report) == output.render(report, "table")
    assert "mescd" in str(report)
    assert "mescd" not in repr(report)


def test_a_diagnosis_is_shown_as_its_command_prints_it():
    found = replace(
        sample_reports.rough(), diagnosis=(Finding("mistake", "gravity is 9.8 <N/kg>"),)
    )
    assert repr(found).endswith("\n\ngravity is 9.8 <N/kg>")
    assert repr(found).startswith("runs/other-h0.001.txt: wrong")
    assert "&lt;N/kg&gt;" in found._repr_html_()


def test_a_notebook_gets_sound_html_without_a_script(scored):
    text = scored._repr_html_()
    page = Page(text)
    assert {tag for tag, _ in page.tags}.isdisjoint({"script", "html", "body", "iframe", "link"})
    assert not any(name.startswith("on") for _, attrs in page.tags for name in attrs)
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert ids == [], "two reports in a notebook would have the same ids"
    assert "alert(1)>" not in text
    assert page.tags[0] == ("div", {"class": "heyoka-bike"})


def test_the_style_touches_nothing_around_it(report):
    style = re.search(r"<style>(.*)</style>", report._repr_html_(), re.DOTALL)[1]
    assert style.startswith(".heyoka-bike {")
    assert style.count("{") == style.count("}")
    depth, least = 0, []
    for ch in style.strip()[:-1]:
        depth += (ch == "{") - (ch == "}")
        least.append(depth)
    assert min(least[style.index("{") :]) >= 1, "a style rule applies outside the card"
    assert ":root" not in style


def test_a_maneuver_and_a_column_are_short(report):
    assert len(repr(report[2]).splitlines()) < 20
    assert len(repr(report[2]["roll_angle"])) < 120
    assert "maneuver 2" in repr(report[2])
    assert "heyoka-bike" in report[2]._repr_html_()


def test_numbers_are_found_by_maneuver_and_column(report):
    column = report.maneuvers[1].columns[0]
    found = report[2]["roll_angle"]
    assert found is column
    measures = column.as_understood.measures
    for name in measures.__slots__:
        assert getattr(found, name) == getattr(measures, name)
    assert found.definition == column.as_understood.definition == "tait_bryan_xyz"
    assert list(report) == [1, 2, 3]
    assert list(report[2]) == [c.key for c in report[2].columns]
    assert 2 in report
    assert 4 not in report
    assert {(n, k): c for n, m in report.items() for k, c in m.items()}[2, "roll_angle"] is column
    with pytest.raises(KeyError, match="found maneuver 4, expected one of 1, 2, 3"):
        report[4]
    assert report[2]["phi"] is report[2]["Roll (deg)"] is report[2]["roll_angle"]
    with pytest.raises(KeyError, match=r"expected one of roll_angle, .*; did you mean roll"):
        report[2]["roll_angel"]


def test_the_worst_column_is_the_one_with_fewest_digits(report):
    every = {(n, k): c.scd for n, m in report.items() for k, c in m.items()}
    assert report.worst.scd == min(every.values())
    assert every[report.worst.maneuver, report.worst.column] == report.worst.scd
    sizes = (1e-7, 1e-3, 1e-5)
    mixed = tuple(sample_reports.sample(s)[n] for n, s in enumerate(sizes, start=1))
    assert replace(report, maneuvers=mixed).worst.maneuver == 2
    assert report[1].worst.scd == min(c.scd for c in report[1].values())
    assert sample_reports.no_maneuvers().worst is None
    assert sample_reports.nothing().worst is None


def test_runs_and_programs_are_found_by_place_and_name():
    runs, programs = sample_reports.series(), sample_reports.programs()
    assert runs[-1] is runs.runs[-1].report
    assert list(programs) == [run.report for run in programs.runs]
    assert programs["Fine"] is programs[0]
    with pytest.raises(KeyError, match="expected one of Fine, "):
        programs["none"]


@pytest.mark.parametrize(
    ("name", "kind"),
    [("r.html", "html"), ("r.HTM", "html"), ("r.json", "json"), ("r.csv", "csv"),
     ("r.xml", "junit"), ("r.txt", "table")],
)  # fmt: skip
def test_the_suffix_tells_the_format(name, kind, report, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    path = report.save(tmp_path / "new" / name)
    assert path == tmp_path / "new" / name
    assert path.read_bytes() == output.render(report, kind).encode()
    other = report.save(tmp_path / "other", kind)
    assert other.read_bytes() == path.read_bytes()
    assert [p.name for p in path.parent.iterdir()] == [name], "a temporary file remains"


def test_what_cannot_be_saved_is_refused(report, tmp_path):
    with pytest.raises(InputError, match=r"save: found 'r\.pdf', expected a name ending in \.txt"):
        report.save(tmp_path / "r.pdf")
    with pytest.raises(InputError, match="save: found format 'pdf', expected one of table, json"):
        report.save(tmp_path / "r.txt", "pdf")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        report.save(tmp_path / "file" / "r.txt")


def test_the_results_themselves_are_never_written_over(tmp_path):
    path = tmp_path / "mine.txt"
    path.write_text("0 1 2\n")
    for files in (str(path), f"other.txt, {path}"):
        with pytest.raises(InputError, match=r"mine\.txt: is a result file to be scored"):
            sample_reports.sample(path=files).save(path)
    assert path.read_text() == "0 1 2\n"


def test_the_dictionary_is_the_json(scored):
    assert scored.to_dict() == json.loads(json_format.render(scored))
    assert json.loads(scored.to_json()) == scored.to_dict()


def test_a_frame_has_what_the_csv_has(report):
    pytest.importorskip("pandas")
    found = report.to_pandas()
    assert found.index.names == ["maneuver", "column"]
    assert found.loc[(2, "roll_angle"), "scd"] == report[2]["roll_angle"].scd
    assert [*found.index.names, *found.columns] == [
        *found.index.names, *(f for f in csv.FIELDS if f not in found.index.names)
    ]  # fmt: skip
    runs = sample_reports.series().to_pandas()
    assert runs.index.names == ["run", "maneuver", "column"]
    assert runs.loc[(4, 2, "roll_angle"), "run_step"] == 0.00125
    assert set(sample_reports.programs().to_pandas().index.unique("run")) >= {"Fine", "Rough"}


def test_without_pandas_one_line_says_so():
    code = "from generators import sample_reports\nsample_reports.sample().to_pandas()"
    run = python(f"import sys; sys.path.insert(0, 'tests')\n{code}", {"pandas"})
    last = run.stderr.splitlines()[-1]
    assert last.endswith("pandas is not installed; to_pandas needs it (pip install pandas)")


def test_looking_at_a_report_needs_little():
    code = """
from heyoka_bike import score
report = score("data/peers/exudyn-h0.001.txt")
repr(report), str(report), report._repr_html_(), report[2]._repr_html_(), report.verdict
"""
    run = python(code, {"heyoka", "flint", "mpmath", "scipy", "matplotlib", "rich", "pandas"})
    assert run.returncode == 0, run.stderr
