"""`heyoka-bike generate --until`: durations, falls, and published parts of short motions."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest

from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError, NotCertifiedError
from heyoka_bike.motion import events
from heyoka_bike.motion.events import REAR_LIFT, ending, first_event
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.manifest import read_manifest
from heyoka_bike.reference.proof import cauchy as circle
from heyoka_bike.reference.proof.enclose import enclose


def exact(text):
    return Exact.parse(text)


@pytest.fixture
def toppling():
    """A slow, leaning and falling start: a wheel leaves the floor within half a second."""
    return Maneuver("toppling", exact("1/2"), exact("2"), Fraction(10), Fraction(1, 50),
                    roll=exact("1/2"))  # fmt: skip


def file_of(folder, maneuver):
    path = folder / "maneuvers.toml"
    path.write_text(
        'name = "some"\n[[maneuver]]\n'
        + f'name = "{maneuver.name}"\n'
        + "".join(
            f'{key} = "{getattr(maneuver, key)}"\n'
            for key in ("speed", "roll_rate", "roll", "duration", "spacing")
        )
    )
    return str(path)


@pytest.mark.proof
def test_without_a_word_a_maneuver_keeps_its_duration(bicycle, maneuvers):
    found = ending(bicycle, maneuvers[0])
    assert found.maneuver == maneuvers[0]
    assert found.said is None
    assert not found.is_early


@pytest.mark.proof
def test_a_time_takes_the_place_of_the_duration(bicycle, maneuvers):
    found = ending(bicycle, maneuvers[0], "3/2")
    assert found.maneuver == replace(maneuvers[0], duration=Fraction(3, 2))
    assert not found.is_early


@pytest.mark.proof
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("never", "--until: found .*'fall'"),
        ("-1", "expected 'fall' or a positive time"),
        ("pi", "expected 'fall' or a positive time"),
        ("0.005", "expected a multiple of the spacing of maneuver 1, 0.01 s"),
        ("20000", "found 2000001 rows, expected 1000001 or fewer"),
    ],
)
def test_other_times_are_refused_in_one_line(bicycle, maneuvers, text, said):
    with pytest.raises(InputError, match=said) as e:
        ending(bicycle, maneuvers[0], text)
    assert "\n" not in str(e.value)


@pytest.mark.proof
def test_a_fall_ends_at_the_last_row_before_it(bicycle, maneuvers):
    found = ending(bicycle, maneuvers[2], "fall")
    assert found.maneuver == replace(maneuvers[2], duration=Fraction("44.43"))
    assert not found.is_early
    assert found.said == "the rear wheel leaves the floor at t = 44.4304263 s"


@pytest.mark.proof
def test_a_motion_past_a_singularity_is_kept_up_to_it_and_says_so(bicycle, maneuvers):
    long = replace(maneuvers[2], duration=Fraction(60))
    found = ending(bicycle, long)
    assert found.is_early
    assert found.maneuver.duration == Fraction("44.45")
    assert found.maneuver.name == "maneuver 3, stopped at 44.45 of 60 s"
    assert "singularity at t = 44.45003" in found.said
    assert "roll and steer rate no longer give the turn rate" in found.said


@pytest.mark.proof
def test_a_motion_that_does_not_fall_keeps_its_duration_and_says_so(
    bicycle, maneuvers, monkeypatch
):
    monkeypatch.setattr(events, "MAX_SEARCH_TIME", Fraction(20))
    found = ending(bicycle, maneuvers[1], "fall")
    assert found.is_early
    assert found.maneuver.duration == 10
    assert found.maneuver.name == "maneuver 2, no fall within 20 s"


@pytest.mark.proof
def test_a_fall_before_the_second_row_is_bad_input(bicycle, toppling):
    coarse = replace(toppling, spacing=Fraction(5))
    with pytest.raises(InputError, match="before its second row at 5 s"):
        ending(bicycle, coarse, "fall")


@pytest.mark.proof
def test_a_bicycle_that_is_not_on_the_floor_at_the_start_is_bad_input(bicycle, maneuvers):
    with pytest.raises(InputError, match="expected both wheels to press on the floor"):
        ending(bicycle, replace(maneuvers[0], roll_rate=exact("10")), "fall")


@pytest.mark.slow
def test_a_set_until_the_fall_is_whole_and_proved(bicycle, toppling, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["generate", "--maneuvers", file_of(tmp_path, toppling), "--out", str(out)]
    assert main([*arguments, "--until", "fall"]) == 0
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    event = first_event(bicycle, toppling)
    (maneuver,) = load_reference(out).values()
    assert 0 < float(event.time) - float(maneuver.duration) <= float(toppling.spacing)
    assert read_manifest(out).inputs["maneuvers"][0]["duration"] == str(maneuver.duration)
    document = json.loads((out / "certificate.json").read_text())
    assert document["inputs"]["maneuvers"][0]["duration"] == str(maneuver.duration)
    assert main(["verify", str(out)]) == 0
    # When the command is repeated, it writes nothing.
    assert main([*arguments, "--until", "fall"]) == 0
    assert "nothing written" in capsys.readouterr().out


@pytest.mark.proof
def test_the_end_of_a_fall_is_an_event(bicycle, toppling):
    assert first_event(bicycle, toppling).what in (REAR_LIFT, "front wheel leaves the floor")


@pytest.mark.proof
def test_a_motion_about_to_fall_is_certified(bicycle, monkeypatch):
    """The motion of maneuver 3 just before its fall needs a small polydisc for analyticity."""
    falling = Maneuver("falling", exact("11.161"), exact("-0.508"), Fraction(1, 250),
                       Fraction(1, 250), roll=exact("1.22736"), steer=exact("0.1731"),
                       steer_rate=exact("2.08"))  # fmt: skip
    run = integrate(bicycle, falling, is_regular=True)
    bounds = enclose(run).end
    better = integrate(bicycle, falling, 30, is_regular=True)
    ends = (r.state(falling.duration) for r in (run, better))
    errors = [abs(float(x - y)) for x, y in zip(*ends, strict=True)]
    assert max(errors) > 1e-16
    assert all(e <= b for e, b in zip(errors, bounds, strict=True))
    # The bound is useful: it is at most a few thousand times as large as the error.
    assert max(bounds) < 1e-11
    monkeypatch.setattr(circle, "SMALLER", (1,))
    monkeypatch.setattr(circle, "SMALLER_STILL", ())
    with pytest.raises(NotCertifiedError, match="a divisor may vanish"):
        enclose(run)
