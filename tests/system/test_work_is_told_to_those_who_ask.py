"""Progress is logged on standard error on request only."""

import logging

import pytest

from heyoka_bike.cli import main
from heyoka_bike.system.jobs import Job
from heyoka_bike.system.log import shown
from heyoka_bike.system.parallel import all_of, using
from heyoka_bike.system.resources import data_folder
from support.jobs import add

FILE = str(data_folder() / "peers" / "exudyn-h0.01.txt")


@pytest.mark.parametrize(
    ("options", "variable", "told"),
    [
        ([], "", ()),
        (["-v"], "", ("load", "assembly")),
        (["-vv"], "", ("load", "assembly", "opening")),
        ([], "info", ("load", "assembly")),
        (["--verbose"], "debug", ("load", "assembly")),
        ([], "debug", ("load", "assembly", "opening")),
    ],
)
def test_a_score_tells_how_the_file_was_read(options, variable, told, capsys, monkeypatch):
    monkeypatch.setenv("HEYOKA_BIKE_LOG", variable)
    assert main(["score", FILE, "--summary", *options]) == 0
    err = capsys.readouterr().err
    loggers = {line.split(" s  ")[1].partition(":")[0] for line in err.splitlines()}
    assert {name.rpartition(".")[2] for name in loggers} == set(told)
    if told:
        assert "roll_angle 2, roll_rate 3, forward_speed 4" in err
    assert not logging.getLogger("heyoka_bike").handlers


@pytest.mark.parametrize("workers", [1, 2])
def test_jobs_are_told_as_they_begin_and_end(workers, capfd):
    jobs = [Job(add, (i, 1), f"motion {i}") for i in range(2)]
    with using(workers), shown("info"):
        all_of(jobs)
    err = capfd.readouterr().err
    for i in range(2):
        assert f"add of motion {i}: started" in err
        assert f"add of motion {i}: done, 0." in err


def test_a_level_that_is_unknown_is_refused(capsys, monkeypatch):
    monkeypatch.setenv("HEYOKA_BIKE_LOG", "inof")
    assert main(["score", FILE]) == 1
    err = capsys.readouterr().err
    assert err == (
        "heyoka-bike: HEYOKA_BIKE_LOG: found 'inof', expected info or debug; did you mean info?\n"
    )
