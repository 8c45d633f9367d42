"""The pages on compared software show the runs in docs/field.json, as data/peers/field.toml
defines them."""

import json
import tomllib
from functools import partial
from textwrap import fill

import pytest

from field_page import BUDGET, FIGURES, PAGE, RUN, figures, pages, parts, shown
from heyoka_bike.system.resources import data_folder
from support.peers import field as runner
from support.peers import measured, race


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
    other = json.loads(RUN.read_text())
    for part in (
        other["programs"]["ode"]["runs"],
        other["harder"]["programs"]["ode"]["problems"]["H4"],
    ):
        line = next(r for r in part if r["kind"] in ("default", "best"))
        for change in ({"digits": 2.0}, {"cpu": 7.77}):
            before = dict(line)
            line |= change
            assert pages(other) != committed, change
            line |= before
    next(iter(other["race"]["rows"].values()))["ratio"] = 7.77
    assert pages(other) != committed


def test_runs_are_those_that_the_protocol_asks_for(run, field):
    """The stored runs are the default and, for each family, the values that its sweep asks for."""
    assert set(run["programs"]) == set(field)
    for name, said in run["programs"].items():
        entry = field[name]
        assert said["version"] == entry["version"]
        lines, asked = {str(r["setting"]): r for r in said["runs"]}, []

        def tried(family, value, entry=entry, lines=lines, asked=asked, kind="sweep"):
            about = measured.told(entry, kind, family, value)
            line = lines[str(about["setting"])]
            assert line["words"] == about["words"] or line["kind"] == "default"
            asked.append(str(about["setting"]))
            return line

        tried(entry["default"], entry["default"]["at"], kind="default")
        for family in entry["sweep"]:
            runner.sweep(entry["measure"], family, partial(tried, family))
        assert len(lines) == len(said["runs"])
        assert set(asked) == set(lines), name
        assert said["best"] == measured.best(said["runs"])
        assert all(r["digits"] <= min(r["scd"].values()) for r in said["runs"] if not r["failure"])


def test_no_run_within_the_budget_is_more_right_than_the_best(run):
    assert BUDGET == measured.BUDGET, "the page states the time limit of the runs"
    for p in shown(run):
        within = [r["digits"] for r in p.runs if r["cpu"] <= measured.BUDGET]
        assert p.best["digits"] == max(within)


def test_programs_stand_in_the_order_of_their_digits(run):
    digits = [p.best["digits"] for p in shown(run) if p.best]
    assert digits == sorted(digits, reverse=True)
    assert len(digits) >= 9


def test_the_race_has_the_cheapest_run_that_passes_of_each_program(run):
    asked = race.cheapest(run["programs"])
    assert {name: x["setting"] for name, x in asked.values()} == {
        name: x["setting"] for name, x in run["race"]["rows"].items()
    }
    rows = [x for x in parts(run)["race"].splitlines() if x.startswith("| ")][2:]
    named = [row.split(" | ")[1] for row in rows]
    assert sorted(named) == sorted(run["programs"][name]["program"] for name in run["race"]["rows"])
    for timed in run["race"]["rows"].values():
        assert len(timed["peer"]) == len(timed["times"]) + 1 >= 4
        ratio = min(timed["times"]) / min(timed["peer"])
        assert timed["ratio"] == pytest.approx(ratio, rel=0.01)


def test_digits_of_a_run_are_those_of_its_worst_maneuver(run):
    for r in (r for p in run["programs"].values() for r in p["runs"] if not r["failure"]):
        assert [m["maneuver"] for m in r["maneuvers"]] == [1, 2, 3]
        worst = min(r["maneuvers"], key=lambda m: m["digits"])
        assert (r["digits"], r["worst"]) == (
            worst["digits"], {"maneuver": worst["maneuver"], "column": worst["worst"]}
        )  # fmt: skip


def test_a_run_that_came_to_no_end_is_named(run):
    other = json.loads(RUN.read_text())
    said = next(p for p in other["harder"]["programs"].values() if "H4" in p["problems"])
    said["problems"]["H4"][0] = {
        "kind": "best",
        "failure": "no end after 9 s",
        "started": "2026-11",
    }
    assert f"{said['program']} (H4)" in parts(other)["harder left out"]
    assert len(parts(other)["H4"].splitlines()) == len(parts(run)["H4"].splitlines()) - 1


@pytest.mark.proof
def test_figures_name_every_program(run):
    drawn = figures(run)
    assert set(drawn) == set(FIGURES)
    for name, data in drawn.items():
        assert (PAGE.parent / name).read_bytes().startswith(b"<?xml")
        assert f"]({name})" in PAGE.read_text()
        assert data.startswith(b"<?xml")
    for p in shown(run):
        # matplotlib draws text as paths and puts each line of text in a comment.
        words = fill(p.name, 24).split("\n")[0]
        assert f"<!-- {words} -->".encode() in drawn["field.svg"]


def test_the_protocol_has_a_row_for_every_program(field):
    page = (data_folder() / "peers" / "PROTOCOL.md").read_text(encoding="utf-8")
    rows = page.partition("right of reply")[2].splitlines()
    named = [row.split("|")[1].strip() for row in rows if row.startswith("| ")][1:]
    assert sorted(named) == sorted(entry["program"] for entry in field.values())
    assert f"at most {measured.BUDGET} s of processor time" in page
