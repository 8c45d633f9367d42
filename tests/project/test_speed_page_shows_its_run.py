"""The pages on speed show the run in docs/speed.json, and their statements on accuracy are true."""

import json

import pytest

from speed_page import (
    FIGURES,
    PAGE,
    RUN,
    accuracies,
    energy_alone,
    energy_table,
    figures,
    filled,
    pages,
    shown,
)

pytest.importorskip("heyoka")


@pytest.fixture(scope="module")
def run():
    return json.loads(RUN.read_text())


def test_tables_are_those_of_the_run(run):
    committed = {page: page.read_text(encoding="utf-8") for page in pages(shown(run))}
    assert len(committed) == 2
    assert pages(shown(run)) == committed
    for changed in (run["results"][0]["maneuver"], "all maneuvers"):
        other = json.loads(RUN.read_text())
        next(x for x in other["results"] if x["maneuver"] == changed)["median_ms"] *= 2
        assert pages(shown(other)) != committed
    page = committed[PAGE]
    with pytest.raises(ValueError, match="no place for absent"):
        filled(page, {"absent": ""})


def test_run_is_a_complete_one(run):
    assert run["runs"] >= 30
    assert not run["quick"]
    assert {x["maneuver"] for x in run["results"]} == {"maneuver 2", "all maneuvers"}
    assert all(x["status"] in ("ok", "not reached") for x in run["results"])
    assert max(x["digits"] for x in run["digits"]) > 1000
    assert max(x["duration"] for x in run["durations"]) == 10_000
    assert set(run["machine"]) == {"cpu", "cores", "system"}


@pytest.mark.proof
def test_figures_are_drawn_from_the_run(run):
    drawn = figures(run)
    assert set(drawn) == set(FIGURES)
    assert all(data.startswith(b"<?xml") for data in drawn.values())
    assert all((PAGE.parent / name).read_bytes().startswith(b"<?xml") for name in FIGURES)


def test_energy_alone_is_no_measure():
    found = energy_alone()
    # The page is about a run that meets the energy limit in maneuver 2, although its roll angle in
    # maneuver 1 is wrong by 31 %.
    assert found[1][0] < 1e-3
    assert found[0][1] > 0.3
    assert energy_table(found) in PAGE.read_text()


@pytest.mark.slow
def test_accuracies_are_kept():
    for accuracy, (wrong, drift) in accuracies().items():
        if accuracy == "eq1":
            assert drift < 1e-3
        elif accuracy != "roundoff":
            assert wrong < accuracy
