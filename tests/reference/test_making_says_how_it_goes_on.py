"""Making a dataset reports the remaining time, and uses more digits as long as they help."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from heyoka_bike.errors import DatasetError
from heyoka_bike.motion.events import Ending
from heyoka_bike.reference import making
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.proof import compute_table
from heyoka_bike.system.jobs import Job, Outcome
from heyoka_bike.system.parallel import carry_out, using
from heyoka_bike.system.resources import reference_folder


def made(bicycle, maneuvers, count):
    ends = [Ending(m) for m in maneuvers[:count]]
    return making._SetInMaking(Path("set"), bicycle, ends, "", 70)


def ended(one, job, value, seconds=1.0):
    return one.ended(job, Outcome(value, seconds))


@pytest.mark.parametrize(
    ("pieces", "seconds", "said"),
    [
        (18, 1.84, "18 pieces of motion, about 23 s"),
        (105, 18.0, "105 pieces of motion, about 4 min"),
        (1, 0.48, None),
    ],
)
def test_the_time_is_told_once_all_is_integrated(bicycle, maneuvers, pieces, seconds, said):
    one = made(bicycle, maneuvers, 1)
    integrate = one.begin()[0]
    assert one.outlook() is None
    ended(one, integrate, SimpleNamespace(steps=pieces), seconds)
    line = one.outlook()
    assert (line is None) == (said is None)
    if said is not None:
        assert f"{said} of processor time" in line
    assert one.outlook() is None


def test_more_digits_are_taken_as_long_as_they_tell_more(bicycle, maneuvers):
    one = made(bicycle, maneuvers, 1)
    jobs = {job.stages[0]: job for job in one.begin()}
    assert [job.stages[0] for job in one.begin()] == ["integrate", *compute_table.STAGES]
    told = []
    for candidates in ({"0"}, {"1"}, {"1"}):
        value = (SimpleNamespace(candidates=frozenset(candidates)),)
        again = ended(one, jobs["rows"], value)
        told.append(len(again))
        if again:
            # The remaining jobs of the previous attempt have been cancelled.
            assert not any(job in one.places for job in jobs.values())
            jobs = {job.stages[0]: job for job in again}
            assert again[0].arguments[-1] == 70 + 20 * len(told)
    assert told == [5, 5, 0]
    assert "rows" in one.parts[0]


def test_a_set_is_written_once(bicycle, maneuvers, monkeypatch):
    """This is also true if a job of an abandoned attempt ends after all others."""
    one, written = made(bicycle, maneuvers, 1), []
    monkeypatch.setattr(compute_table, "assemble_table", lambda run, parts: sorted(parts))
    monkeypatch.setattr(making, "write_dataset", lambda *of: written.append(of[2]) or ())
    late = {job.stages[0]: job for job in one.begin()}
    rows = (SimpleNamespace(candidates=frozenset({"0"})),)
    for job in ended(one, late.pop("rows"), rows):
        assert not one.is_done
        ended(one, job, (SimpleNamespace(candidates=frozenset()),))
    assert one.is_done
    one.write()
    for job in late.values():
        assert ended(one, job, None) == []
        assert not one.is_done
    assert written == [[sorted(making._STAGES)]]


@pytest.mark.parametrize("how", ["old manifest", "no manifest"])
def test_a_set_whose_making_was_interrupted_is_refused_and_says_what_to_do(tmp_path, how):
    """The manifest is missing or old, because it is written last."""
    for file in reference_folder().glob("*.*"):
        shutil.copy(file, tmp_path)
    if how == "old manifest":
        with (tmp_path / "uncontrolled-bicycle.h5").open("ab") as f:
            f.write(b"newer")
    else:
        (tmp_path / "manifest.json").unlink()
    with pytest.raises(DatasetError, match=r"interrupted.*run it again"):
        load_reference(tmp_path)


def test_a_job_that_is_not_wanted_is_not_begun():
    jobs = [Job(_named, (x,)) for x in "abc"]
    done = []

    def over(job, outcome):
        done.append(outcome.get())
        return ()

    with using(workers=1):
        carry_out(jobs, over, is_wanted=lambda job: "a" not in done or job.arguments != ("b",))
    assert done == ["a", "c"]


def _named(name, report):
    return name
