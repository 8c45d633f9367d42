"""after-ten-seconds.json contains what its candidates prove, and `certify` rejects changes."""

import json
import shutil
from dataclasses import replace
from fractions import Fraction

import flint
import pytest

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.cli import main
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.events import FRONT_LIFT, REAR_LIFT, UPRIGHT, Event
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, evaluator
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.rounding import Enclosure
from heyoka_bike.reference.layout import AFTER, CANDIDATE
from heyoka_bike.reference.proof.candidate import parse_candidate
from heyoka_bike.system.resources import after_folder
from heyoka_bike.workbench.after_ten_seconds import facts, limit_cycle
from heyoka_bike.workbench.after_ten_seconds.facts import Fact, settling_fact


@pytest.fixture(scope="module")
def published():
    return json.loads((after_folder() / AFTER).read_bytes())


@pytest.fixture(scope="module")
def motions():
    """The candidates for the cycle and for the fall."""
    path = after_folder() / CANDIDATE
    return parse_candidate(path.read_bytes(), path)


@pytest.fixture
def copy(tmp_path):
    return shutil.copytree(after_folder(), tmp_path / "copy")


@pytest.fixture
def proved(monkeypatch, published):
    """Replaces the slow proof with the published facts, to more digits."""

    def enclosed(text):
        low, high = (Fraction(text) + side * Fraction(1, 10**45) for side in (-1, 1))
        return Enclosure(low, high)

    found = [
        Fact(x["about"], x["statement"], {name: enclosed(t) for name, t in x["numbers"].items()})
        for x in published["proved"]
    ]
    monkeypatch.setattr(facts, "prove_facts", lambda *_: tuple(found))


def certify(folder, capsys):
    code = main(["certify", "--after-ten-seconds", str(folder)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_the_published_file_is_read_and_compared(proved, copy, capsys):
    code, out, err = certify(copy, capsys)
    assert (code, err) == (0, "")
    assert "There is a cycle" in out
    assert "proved: after-ten-seconds.json, 23 numbers and the sentences above" in out


def changed(document):
    """Yield every change of the file, with the expected message."""
    cycle, settling, fall = (x["numbers"] for x in document["proved"])
    name = "period [s]"
    digits = cycle[name]

    def last_digit():
        cycle[name] = digits[:-1] + str((int(digits[-1]) + 1) % 10)

    yield last_digit, "published '2.02035687759961715862235164711', proved 2.020356877599617158"
    yield (
        lambda: fall.update({"lift-off, time [s]": "44.0"}),
        "lift-off, time [s]: published '44.0'",
    )
    yield lambda: cycle.update({name: digits + "0" * 60}), "digits are not decided"
    yield lambda: cycle.update({name: "nan"}), "published 'nan'"
    yield lambda: cycle.update({name: None}), "published None"
    yield lambda: settling.update({"top speed [m/s]": "9"}), "top speed [m/s]: the proof does not"
    yield (
        lambda: fall.pop("largest roll angle [rad]"),
        "largest roll angle [rad]: the number is missing",
    )
    yield lambda: document["proved"].pop(), "the number is missing"
    yield (
        lambda: document["proved"][0].update(statement="All is well."),
        "differ from the proved ones",
    )
    yield (
        lambda: document["inputs"]["bicycle"].update(name="another"),
        "differ from the proved ones",
    )
    yield lambda: document.update(used=[]), "differ from the proved ones"
    yield lambda: document.update(also="the moon"), "differ from the proved ones"


@pytest.mark.parametrize("case", range(12))
def test_another_claim_is_refused_in_one_line(proved, copy, capsys, case):
    document = json.loads((copy / AFTER).read_text())
    change, said = list(changed(document))[case]
    change()
    (copy / AFTER).write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    code, out, err = certify(copy, capsys)
    assert (code, out) == (3, "")
    assert said in err
    assert err.count("\n") == 1


def test_fewer_digits_are_proved_too(proved, copy, capsys):
    text = (copy / AFTER).read_text()
    (copy / AFTER).write_text(text.replace("2.02035687759961715862235164710", "2.0204"))
    assert certify(copy, capsys)[0] == 0


@pytest.mark.parametrize(
    ("name", "content"),
    [
        (AFTER, None), (AFTER, b"{"), (AFTER, b"[]"), (AFTER, b'{"proved": [1]}'),
        (CANDIDATE, None), (CANDIDATE, b"no HDF5"),
    ],
)  # fmt: skip
def test_files_that_cannot_be_read_are_named_in_one_line(copy, capsys, name, content):
    (copy / name).unlink()
    if content is not None:
        (copy / name).write_bytes(content)
    code, out, err = certify(copy, capsys)
    assert (code, out) == (1, "")
    assert name in err
    assert err.count("\n") == 1


def test_candidates_of_something_else_are_refused(motions, bicycle):
    cycle, fall = motions
    heavier = replace(bicycle, values={**bicycle.values, "mB": Exact(Fraction(86))})
    with pytest.raises(NotCertifiedError, match="not that of the benchmark"):
        facts.prove_facts(replace(cycle, bicycle=heavier), fall)
    with pytest.raises(NotCertifiedError, match="does not start as maneuver 3"):
        facts.prove_facts(cycle, cycle)


def test_the_final_speed_is_proved_again(bicycle, maneuvers, published):
    (x,) = settling_fact(bicycle, maneuvers[1]).numbers.values()
    (text,) = published["proved"][1]["numbers"].values()
    assert Fraction(x.decimal(30)) == Fraction(text)


@pytest.fixture(scope="module")
def cycle(motions, maneuvers):
    """The published cycle, proved; the bounds of its candidate are reused for other energies."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("enclose", "nearby"):
            patch.setattr(limit_cycle, name, once(getattr(limit_cycle, name)))
        yield limit_cycle.prove_cycle(motions[0], maneuvers[0])


def once(prove):
    """Cache the first result of a proof."""
    kept = []

    def again(*arguments):
        if not kept:
            kept.append(prove(*arguments))
        return kept[0]

    return again


@pytest.mark.proof
def test_the_cycle_exists_and_has_the_published_multipliers(cycle, published):
    assert cycle.is_attracting
    numbers = published["proved"][0]["numbers"]
    for i, x in enumerate(cycle.multipliers, start=1):
        text = numbers[f"half-period multiplier {i}"]
        digits = len(text.partition("e")[0].replace(".", "").lstrip("-0"))
        assert Fraction(Enclosure.of(x).decimal(digits)) == Fraction(text)


@pytest.mark.proof
@pytest.mark.parametrize("faster", [Fraction(1, 10**3), Fraction(1, 10**30)])
def test_no_cycle_of_another_energy_is_there(cycle, motions, maneuvers, faster):
    other = replace(maneuvers[0], speed=Exact(maneuvers[0].speed.rational + faster))
    with pytest.raises(NotCertifiedError, match="Krawczyk's operator leaves the box"):
        limit_cycle.prove_cycle(motions[0], other)


@pytest.mark.proof
def test_a_motion_that_only_comes_near_the_cycle_is_refused(cycle, motions, maneuvers):
    """The run is the same, but a start that differs by 1e-25 is an error of its initial state."""
    start = motions[0].maneuver
    moved = replace(start, steer=Exact(start.steer.rational + Fraction(1, 10**25)))
    with pytest.raises(NotCertifiedError, match="Krawczyk's operator leaves the box"):
        limit_cycle.prove_cycle(replace(motions[0], maneuver=moved), maneuvers[0])


@pytest.mark.proof
def test_a_cycle_comes_upright_once(cycle, motions, maneuvers, monkeypatch):
    twice = [*limit_cycle.events(motions[0], (UPRIGHT,), cycle.certificate)] * 2
    monkeypatch.setattr(limit_cycle, "events", lambda *_: iter(twice))
    with pytest.raises(
        NotCertifiedError, match="not proved that the motion is upright exactly once"
    ):
        limit_cycle.prove_cycle(motions[0], maneuvers[0])


def test_energy_and_floor_determine_spin_and_pitch(motions):
    """This fails at rest, where the kinetic energy has its minimum."""
    run = motions[0]
    balls = Balls(128)
    equations = Equations.of(run.bicycle, balls)
    with balls.precision():
        state = initial_state(equations, run.maneuver)
        slopes = limit_cycle._energy_slopes(run, equations, state, flint.arb(0))
        assert slopes[-1] > 0
        at_rest = [*state[:3], *(flint.arb(0, 1e-9) for _ in range(3)), state[6]]
        with pytest.raises(NotCertifiedError, match="do not determine spin and pitch"):
            limit_cycle._energy_slopes(run, equations, at_rest, flint.arb(0))


def test_a_derivative_that_is_not_known_well_enough_is_refused(motions):
    with flint.ctx.workprec(128):
        radius = flint.arb(2) ** -10
        rest = [radius / 4] * 5
        known, unknown = (
            flint.arb_mat(
                [[flint.arb(int(i == j), 0.1 * wide) for j in range(5)] for i in range(5)]
            )
            for wide in (1, 2)
        )
        # G itself takes a quarter of the box. Each of five columns adds a tenth of the box
        # (accepted) or a fifth (refused).
        limit_cycle._check_krawczyk(motions[0], rest, known, radius)
        with pytest.raises(NotCertifiedError, match="leaves the box"):
            limit_cycle._check_krawczyk(motions[0], rest, unknown, radius)


@pytest.mark.parametrize(
    ("matrix", "refusal"),
    [
        ([[0, 1, 0], [-1, 0, 0], [0, 0, 2]], "not proved to be real"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, 2]], "cannot be separated"),
    ],
)
def test_multipliers_that_are_not_real_and_single_are_refused(motions, matrix, refusal):
    flow = flint.arb_mat(7, 4)
    for i, row in zip((2, 3, 4), matrix, strict=True):
        for j, x in enumerate(row):
            flow[i, j] = -x
    rates, energy = [flint.arb(1)] * 7, [flint.arb(0)] * 3 + [flint.arb(1)]
    with pytest.raises(NotCertifiedError, match=refusal):
        limit_cycle._multipliers(motions[0], flow, rates, energy)


def test_the_mean_speed_is_that_of_the_motion(motions, published):
    """Half the period of the cycle is covered: equal steps in time converge exponentially."""
    run = motions[0]
    numbers = published["proved"][0]["numbers"]
    half = Fraction(numbers["period [s]"]) / 2
    at = evaluator(run, run.bits)
    with at.balls.precision():
        speeds = [at.columns(half * i / 64)["forward_speed"] for i in range(64)]
        mean = float((sum(speeds) / 64).mid())
    assert mean == pytest.approx(float(numbers["mean of the forward speed [m/s]"]), rel=1e-14)


@pytest.fixture(scope="module")
def short(bicycle, maneuvers):
    """One second of maneuver 3, with bounds that are valid for a run in binary64."""
    run = integrate(bicycle, replace(maneuvers[2], duration=Fraction(1)))
    bound = (Fraction(1, 10**12),) * 7
    return run, Certificate(run.states, (bound,) * run.steps, bound)


@pytest.mark.parametrize(
    ("rear", "front", "refusal"),
    [
        ([], [], "the time at which the rear wheel lifts is not proved"),
        ([(0.5, False, False)], [], "the time at which the rear wheel lifts is not proved"),
        ([(0.5, True, True)], [], "a wheel may lift earlier"),
        ([(0.5, False, True)], [(0.4, None, False)], "a wheel may lift earlier"),
        ([(0.5, False, True)], [(0.5, False, True)], "a wheel may lift earlier"),
    ],
)
def test_a_fall_that_is_not_shown_is_refused(monkeypatch, short, rear, front, refusal):
    run, certificate = short
    found = {REAR_LIFT: rear, FRONT_LIFT: front}

    def zeros(run, quantity, what, certificate):
        return [Event(what, flint.arb(t, 1e-9), *rest) for t, *rest in found[what]]

    monkeypatch.setattr(facts, "enclose", lambda *_: certificate)
    monkeypatch.setattr(facts, "zeros", zeros)
    with pytest.raises(NotCertifiedError, match=refusal):
        facts.fall_fact(run)


@pytest.mark.slow
def test_all_is_proved_again(capsys):
    assert main(["certify", "--after-ten-seconds"]) == 0
    assert "proved: after-ten-seconds.json, 23 numbers" in capsys.readouterr().out
