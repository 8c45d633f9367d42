"""`generate`, `certify` and `verify` in Python do the same as the commands, and return results."""

from dataclasses import replace
from fractions import Fraction

import pytest

import heyoka_bike
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError, MissingPackageError, NotCertifiedError
from heyoka_bike.reference import making as module
from heyoka_bike.system.parallel import using
from heyoka_bike.system.resources import collection, find_input

TOML = """
[[maneuver]]
name = "{0.name}"
speed = "{0.speed}"
roll_rate = "{0.roll_rate}"
duration = "{0.duration}"
spacing = "{0.spacing}"
"""


class Listener:
    """A progress callback that records the stages of each job, and their progress."""

    def __init__(self):
        self.stages = {}

    def __call__(self, name, stage, share):
        assert 0 <= share <= 1
        self.stages.setdefault(name, {})[stage] = share


@pytest.fixture(scope="module")
def short():
    first = heyoka_bike.load_reference()[1].inputs
    return heyoka_bike.Maneuver.parse("short", first | {"duration": "1/50", "spacing": "1/100"})


@pytest.fixture(scope="module")
def both(short):
    """Two maneuvers, which are made in parallel."""
    return [short, replace(short, name="other")]


@pytest.fixture(scope="module")
def made(tmp_path_factory, both):
    progress = Listener()
    folder = tmp_path_factory.mktemp("made") / "set"
    with using(workers=2):
        return heyoka_bike.generate(folder, maneuvers=both, progress=progress), progress


@pytest.mark.proof
def test_what_was_made_is_returned(made, both):
    found, progress = made
    assert sorted(found.changed) == sorted(p.name for p in found.folder.iterdir())
    assert found.dataset_version == "custom"
    assert [end.maneuver for end in found.endings] == both
    assert [table.maneuver for table in found.tables] == both
    assert all(table.cpu > 0 for table in found.tables)
    assert list(progress.stages) == ["short", "other"]
    for stages in progress.stages.values():
        assert list(stages)[:3] == ["waiting", "integrate", "certify"]
        assert set(stages) - set(list(stages)[:3]) == {"rows", "dense", "motion", "vary"}
        assert {share for stage, share in stages.items() if stage != "waiting"} == {1.0}


@pytest.mark.proof
def test_the_command_finds_nothing_to_change(made, both, tmp_path, capsys):
    found, _ = made
    (tmp_path / "m.toml").write_text("".join(map(TOML.format, both)))
    arguments = ["generate", "--maneuvers", str(tmp_path / "m.toml"), "--out", str(found.folder)]
    assert main([*arguments, "--workers", "1"]) == 0
    assert "nothing written" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"digits": 10}, "found 10, expected 65 to 1000"),
        ({"bicycle": "bisicle"}, "bicycle: found 'bisicle', expected"),
        ({"until": "never"}, "found 'never', expected .* or 'fall'"),
        ({"maneuvers": []}, "maneuvers: found none, expected one or more"),
    ],
)
def test_what_cannot_be_used_is_refused(tmp_path, short, given, said):
    with pytest.raises(InputError, match=said):
        heyoka_bike.generate(tmp_path / "set", **{"maneuvers": [short]} | given)
    assert not (tmp_path / "set").exists()


def test_names_and_files_are_found_as_on_the_command_line(tmp_path, monkeypatch):
    """For a bicycle given by name, its maneuvers in the collection are the default."""
    asked = []

    class EnoughError(Exception):
        pass

    def look(jobs, *_):
        asked.extend(job.arguments for job in jobs)
        raise EnoughError

    monkeypatch.setattr(module, "carry_out", look)
    own_maneuvers = collection("maneuvers")
    for bicycle in ("benchmark", "pista"):
        own = bicycle if bicycle in own_maneuvers else "benchmark"
        asked.clear()
        with pytest.raises(EnoughError):
            heyoka_bike.generate(tmp_path, bicycle=bicycle)
        ((used, maneuvers, until),) = asked
        assert maneuvers == heyoka_bike.read_maneuvers(own_maneuvers[own])
        assert used == heyoka_bike.read_bicycle(find_input("bicycles", bicycle))
        assert until is None


@pytest.mark.slow
def test_early_ends_are_said(tmp_path, short):
    said = []
    falling = replace(
        short, roll=heyoka_bike.Exact.parse("1.4"), roll_rate=heyoka_bike.Exact.parse("5"),
        duration=Fraction(10),
    )  # fmt: skip
    found = heyoka_bike.generate(tmp_path, maneuvers=[falling], say=said.append)
    (line,) = said
    assert line.startswith("stopped early: short: the motion meets a singularity at t = ")
    (end,) = found.endings
    assert end.is_early
    assert end.maneuver.duration < 10


@pytest.mark.proof
def test_a_set_is_proved_again(made):
    found, _ = made
    progress = Listener()
    proofs = heyoka_bike.certify(found.folder, progress=progress)
    assert [proof.name for proof in proofs] == ["short", "other"]
    assert all(0 < proof.bound < 1e-60 for proof in proofs)
    assert list(progress.stages) == ["short", "other"]
    for stages in map(list, progress.stages.values()):
        assert stages[:2] == ["waiting", "certify"]
        assert set(stages[2:]) == {"rows", "dense", "motion", "vary"}


@pytest.mark.proof
def test_texts_are_compared_with_what_is_proved(made, tmp_path, monkeypatch):
    from heyoka_bike.reference.proof import certify

    found, _ = made
    monkeypatch.setattr(certify, "render_texts", lambda *_: {"uncontrolled-bicycle.txt": b"0\n"})
    with pytest.raises(NotCertifiedError, match=r"uncontrolled-bicycle\.txt: differs from the"):
        heyoka_bike.certify(found.folder)


@pytest.mark.proof
def test_checks_and_agreeing_digits_are_returned(made, both):
    found, _ = made
    progress = Listener()
    with using(workers=2):
        verified = heyoka_bike.verify(found.folder, rerun="quick", progress=progress)
    assert verified.passed
    assert [a.precision for a in verified.agreements] == ["binary128", "40 digits"] * 2
    assert [c.check for c in verified.checks].count("rerun") == 4
    # If a job in its own process reports several times in rapid succession, not all reports are
    # forwarded.
    precisions = ("binary128", "40 digits")
    assert list(progress.stages) == [f"{m.name}, {p}" for m in both for p in precisions]
    for stages in progress.stages.values():
        assert stages.keys() <= {"waiting", "integrate", "compare"}
    plain = heyoka_bike.verify(found.folder)
    assert plain.checks == verified.checks[:-4]
    assert plain.agreements == ()


def test_without_heyoka_a_rerun_is_refused_at_once(folder, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "heyoka", None)
    monkeypatch.delattr("heyoka_bike.reference.verification.verify._verified")
    with pytest.raises(MissingPackageError, match="heyoka is not installed"):
        heyoka_bike.verify(folder, rerun="full")
