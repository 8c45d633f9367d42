"""The pages of the field show the runs in docs/field.json, those of data/peers/field.toml."""

import json
import tomllib
from textwrap import fill

import pytest
from field_page import BUDGET, FIGURES, PAGE, RUN, better, figures, pages, parts, shown
from field_race import PASSES, cost, digits
from support.peers import measured

from heyoka_bike.system.resources import data_folder


@pytest.fixture(scope="module")
def run():
    return json.loads(RUN.read_text())


@pytest.fixture(scope="module")
def field():
    return tomllib.loads((data_folder() / "peers" / "field.toml").read_text())


def test_tables_and_counts_are_those_of_the_run(run):
    committed = {page: page.read_text(encoding="utf-8") for page in pages(run)}
    assert len(committed) == 3
    assert pages(run) == committed
    for change in ({"digits": 2.0}, {"performance": [1e-9] * 3}, {"ratio": 7.77}):
        other = json.loads(RUN.read_text())
        next(iter(other["programs"].values()))["runs"][0] |= change
        assert pages(other) != committed, change
        other = json.loads(RUN.read_text())
        next(iter(other["programs"].values()))["harder"]["H4"][0] |= change
        assert pages(other) != committed, change


def test_runs_are_those_that_the_programs_are_said_to_have(run, field):
    assert set(run["programs"]) <= set(field)
    for name, said in run["programs"].items():
        entry = field[name]
        assert said["version"] == entry["version"]
        # What is best may have been one of the sweep when it was run, and the other way round.
        known = [setting for _, setting in measured.settings(entry)]
        assert all(r["setting"] in known for r in said["runs"]), name
        assert len({(r["kind"], str(r["setting"])) for r in said["runs"]}) == len(said["runs"])
        assert [r["setting"] for r in said["runs"] if r["kind"] == "default"] == (
            [entry["default"]] if "default" in entry else []
        )
        for problem, runs in said.get("harder", {}).items():
            kinds = [kind for kind, _ in measured.settings(entry, problem)]
            assert [r["kind"] for r in runs] == kinds
            assert all(r["setting"] in known for r in runs), (name, problem)
        assert all(r["digits"] <= min(r["scd"].values()) for r in said["runs"] if not r["failure"])


def test_programs_stand_in_the_order_of_their_digits(run):
    digits = [p.best["digits"] for p in shown(run) if p.best]
    assert digits == sorted(digits, reverse=True)
    assert len(digits) >= 9


def test_the_race_has_the_cheapest_run_that_passes_of_each_program(run):
    rows = [x for x in parts(run)["race"].splitlines() if x.startswith("| ")][2:]
    named = [row.split(" | ")[1] for row in rows]
    folders = {p.folder for p in shown(run) if p.name in named}
    assert len(folders) == len(named)
    passing = {}
    for p in shown(run):
        if p.said["kind"] != "linear":
            found = [cost(r) for r in p.runs if r["performance"][1] < PASSES]
            passing.setdefault(p.folder, []).extend(found)
    assert {folder for folder, found in passing.items() if found} == folders
    other = json.loads(RUN.read_text())
    said = other["programs"]["mujoco"]
    said["runs"][0] |= {"performance": [1.0, 0.9e-3, 1.0], "ratio": 0.07}
    before, after = (parts(x)["race"] for x in (run, other))
    assert "| MuJoCo | Euler, h = 0.002" in after
    assert "| MuJoCo | Euler, h = 0.002" not in before


def test_a_run_of_the_old_format_says_the_digits_that_it_has_at_least():
    old = {"digits": 2.0, "worst": {"maneuver": 1}, "ratio": 6.0, "performance": [1, 1, 1]}
    assert digits(old) == (2.0, True)
    assert digits(old | {"worst": {"maneuver": 2}}) == (2.0, False)
    assert cost(old) == 6.0
    new = old | {"cpu": 3.0, "maneuvers": [{"maneuver": 2, "digits": 4.5, "cpu": 0.5}]}
    assert digits(new) == (4.5, False)
    # A third of the motion in a sixth of the time.
    assert cost(new) == 3.0


def test_digits_of_a_run_are_those_of_its_worst_maneuver(run):
    known = [r for p in run["programs"].values() for r in p["runs"] if r.get("maneuvers")]
    assert len(known) >= 43
    for r in known:
        worst = min(r["maneuvers"], key=lambda m: m["digits"])
        assert (r["digits"], r["worst"]) == (
            worst["digits"], {"maneuver": worst["maneuver"], "column": worst["worst"]}
        )  # fmt: skip


def test_a_run_that_is_more_right_than_the_best_is_named(run):
    assert "Pinocchio" in better(shown(run))
    other = json.loads(RUN.read_text())
    for r in other["programs"]["pinocchio"]["runs"]:
        r["digits"] = min(r["digits"], 9.1)
    assert better(shown(other)).startswith("No run")


def test_a_run_that_came_to_no_end_is_named(run):
    other = json.loads(RUN.read_text())
    said = next(p for p in other["programs"].values() if "H4" in p.get("harder", {}))
    said["harder"]["H4"][0] = {"kind": "best", "failure": "no end after 9 s", "started": "2026-11"}
    assert f"{said['program']} (H4)" in parts(other)["harder left out"]
    assert len(parts(other)["H4"].splitlines()) == len(parts(run)["H4"].splitlines()) - 1


def test_figures_name_every_program(run):
    drawn = figures(run)
    assert set(drawn) == set(FIGURES)
    for name, data in drawn.items():
        assert (PAGE.parent / name).read_bytes().startswith(b"<?xml")
        assert f"]({name})" in PAGE.read_text()
        assert data.startswith(b"<?xml")
    for p in shown(run):
        # matplotlib writes a line of text as paths, with the text as a comment.
        words = fill(p.name, 24).split("\n")[0]
        assert f"<!-- {words} -->".encode() in drawn["field.svg"]


def test_the_protocol_has_a_row_for_every_program(field):
    page = (data_folder() / "peers" / "PROTOCOL.md").read_text(encoding="utf-8")
    rows = page.partition("right of reply")[2].splitlines()
    named = [row.split("|")[1].strip() for row in rows if row.startswith("| ")][1:]
    assert sorted(named) == sorted(entry["program"] for entry in field.values())
    assert f"at most {BUDGET} s of processor time" in page
