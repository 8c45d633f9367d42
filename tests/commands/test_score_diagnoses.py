"""`score --diagnose` gives the same findings in every format, and a figure of the explanation."""

import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.mistaken_programs import columns_of
from heyoka_bike import read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """A file whose rows are one step late, and its reports."""
    table = np.loadtxt(PEERS / "scipy-rtol1e-10.txt")
    table[1:, 1:] = table[:-1, 1:]
    folder = tmp_path_factory.mktemp("late")
    np.savetxt(folder / "late.txt", table, "%.17g")
    written = [f"-o{folder / name}" for name in ("r.json", "r.xml", "r.html", "r.txt")]
    assert main(["score", str(folder / "late.txt"), "--diagnose", *written]) == 0
    return folder


@pytest.mark.proof
def test_every_format_says_it(late):
    findings = json.loads((late / "r.json").read_text())["findings"]
    assert findings[0]["code"] == "mistake"
    assert findings[0]["evidence"]["mistakes"] == ["one_step_late"]
    for name in ("r.xml", "r.html", "r.txt"):
        text = " ".join(re.sub(r"<[^>]*>", " ", (late / name).read_text()).split())
        assert "Each row is written one step late" in text, name
    ET.parse(late / "r.xml")


@pytest.mark.proof
def test_in_python_it_is_the_score_with_a_diagnosis(late):
    results, seen = read_results(late / "late.txt"), []
    found, plain = diagnose(results, progress=seen.append), score(results)
    assert seen == sorted(seen)
    assert 0 < seen[0] < seen[-1] <= 1
    assert found.diagnosis[0].code == "mistake"
    assert found.explanation is not None
    assert (plain.diagnosis, plain.explanation) == ((), None)
    assert found.findings == plain.findings
    codes = [f["code"] for f in json.loads((late / "r.json").read_text())["findings"]]
    assert [f.code for f in found.said] == codes


@pytest.mark.proof
def test_the_page_shows_what_is_left(late):
    page = (late / "r.html").read_text()
    (section,) = re.findall(r'<section id="explanation">.*?</section>', page, re.S)
    # The section has one chart for each maneuver, with two lines in it.
    assert section.count("<figcaption><b>Maneuver") == 3
    assert len(re.findall(r'<path class="before"', section)) >= 3
    assert len(re.findall(r'<path class="after"', section)) >= 3
    assert 'href="#explanation"' in page


@pytest.mark.proof
def test_a_plain_score_has_no_such_figure(tmp_path):
    out = tmp_path / "r.html"
    assert main(["score", str(PEERS / "scipy-rtol1e-10.txt"), "-o", str(out)]) == 0
    assert 'id="explanation"' not in out.read_text()


@pytest.mark.proof
def test_several_runs_are_refused(capsys):
    files = [str(PEERS / f"exudyn-h{h}.txt") for h in ("0.01", "0.001")]
    assert main(["score", *files, "--diagnose"]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "--diagnose: found 2 runs, expected the files of one run" in error


def noise(t):
    return np.random.default_rng(1).standard_normal((len(t), 24))


def zeros(t):
    return np.zeros((len(t), 24))


@pytest.mark.parametrize(
    ("rows", "values", "said"),
    [
        # No cause explains noise, so the search tries everything.
        pytest.param(
            1001, noise, "off by at least half of their largest value", marks=pytest.mark.slow
        ),
        pytest.param(101, zeros, "contain only zeros", marks=pytest.mark.proof),
    ],
)
def test_what_nobody_can_explain_is_not_explained(tmp_path, capsys, rows, values, said):
    t = np.arange(rows) / 100
    np.savetxt(tmp_path / "x.txt", np.column_stack([t, values(t)]))
    assert main(["diagnose", str(tmp_path / "x.txt")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert said in out
    assert "A simulation with this agrees" not in out
    assert not re.search("explains? the error:", out)


@pytest.mark.parametrize(
    "rows",
    [
        pytest.param(slice(300, 301), marks=pytest.mark.proof),
        pytest.param(slice(300, 360, 4), marks=pytest.mark.proof),
        pytest.param(slice(0, 3), marks=pytest.mark.proof),
        pytest.param(slice(0, 1), marks=pytest.mark.slow),
    ],
)
def test_few_rows_are_no_trouble(tmp_path, capsys, rows):
    table = np.loadtxt(PEERS / "exudyn-h0.01.txt")[rows]
    np.savetxt(tmp_path / "x.txt", table, "%.12g")
    assert main(["diagnose", str(tmp_path / "x.txt")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert not re.search("(?<!No known mistake )explains? the error:", out)


@pytest.mark.proof
def test_a_start_that_breaks_rolling_says_what_is_assumed(tmp_path, capsys, reference):
    mistake = next(m for m in MISTAKES if m.code == "roll_without_wheels")
    columns = columns_of(reference, [mistake])
    t = reference[1].time
    table = [t, *(columns[n][key] for n in columns for key in BENCHMARK_COLUMNS)]
    np.savetxt(tmp_path / "x.txt", np.array(table).T, "%.12g")
    assert main(["diagnose", str(tmp_path / "x.txt")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert mistake.says in out.lower()
    assert "nearest velocities that satisfy the constraints" in out
