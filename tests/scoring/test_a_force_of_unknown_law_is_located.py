"""A force whose law is not known is located by the ratio of the accelerations that it changes."""

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.pushed_motions import exact_motions, with_force, with_torque
from heyoka_bike.scoring.diagnosis.answers import acts_elsewhere
from heyoka_bike.scoring.diagnosis.conclusions import ForceUnexplained, LeftOfEquations
from heyoka_bike.scoring.diagnosis.residual.loads import CONSTANT, LOADS, TIME


@pytest.fixture(scope="module")
def motions(reference):
    return exact_motions(reference)


def gust(time):
    """Strength of a push of half a second at 3 s."""
    return np.exp(-(((time - 3.0) / 0.5) ** 2))


def words(residual):
    left = LeftOfEquations(residual.shares, residual.acts_in, residual.above)
    return ForceUnexplained(left, False, True, (), residual.loads).message()


# The size of each load at a time [s] and a state: of the time, constant, of one variable, and of a
# product of two variables, which is none of these.
SIZES = {
    TIME: lambda _, time: gust(time),
    CONSTANT: lambda _, time: 0.3 + 0.0 * time,
    "roll angle": lambda state, _: 2.0 * state["roll_angle"],
    "": lambda state, time: 30.0 * state["roll_angle"] * np.abs(state["steer_angle"]) + 0.0 * time,
}


@pytest.mark.parametrize("varies_with", SIZES)
@pytest.mark.parametrize(
    "name", ["steer_axis", "rear_roll", "rear_side", "front_yaw", "ground_side", "weight"]
)
def test_the_load_and_what_it_varies_with_are_found(reference, motions, name, varies_with):
    def force(moving, state, time):
        size = SIZES[varies_with](state, time)
        return [size * x for x in moving.powers(LOADS[name].law(moving))]

    found = with_force(reference, motions, force).loads
    assert name in [x.load for x in found]
    best = found[0]
    # Loads that the file does not distinguish may be named first, but they vary in the same way.
    assert best.varies_with == varies_with
    if best.load != name:
        return
    if varies_with == TIME:
        assert best.time == pytest.approx(3.0, abs=0.2)
        # The size is an average over a window of the run, so it is smaller than the peak.
        assert best.size == pytest.approx(1.0, abs=0.2)
    elif varies_with == CONSTANT:
        assert best.coefficient == pytest.approx(0.3, rel=1e-3)
    elif varies_with:
        assert best.coefficient == pytest.approx(2.0, rel=0.05)


def test_gravity_that_begins_late_is_reported_where_it_is_missing(reference, motions):
    """Upright at the start, a weight changes little, but later it does not lack at all."""

    def force(moving, state, time):
        lacking = -9.81 * np.clip(1.0 - time / 0.6, 0.0, None)
        return [lacking * x for x in moving.powers(LOADS["weight"].law(moving))]

    best = with_force(reference, motions, force).loads[0]
    assert best.load == "weight"
    assert 0.0 < best.time < 0.5
    assert -9.81 < best.size < -4.0


def test_forces_at_two_places_are_no_load(reference, motions):
    """A size for each part of the run explains one place, not two with different laws."""

    def force(moving, state, time):
        steer = moving.powers(LOADS["steer_axis"].law(moving))
        side = moving.powers(LOADS["rear_side"].law(moving))
        return [
            np.sin(7 * time) * x + 20.0 * np.cos(4 * time) * y
            for x, y in zip(steer, side, strict=True)
        ]

    assert with_force(reference, motions, force).loads == ()


def test_the_sentence_says_where_and_how_large(reference, motions):
    said = words(with_torque(reference, motions, 1, lambda _, time: gust(time)))
    assert said.startswith("The program applies a torque on the steer axis, or lacks a term")
    assert "The size is largest at 3.0" in said
    assert "the same function of time in every maneuver" in said
    said = words(with_torque(reference, motions, 1, lambda s, _: 2.0 * s["roll_angle"]))
    assert "nearly 2 N m/rad times the roll angle" in said
    said = words(with_torque(reference, motions, 1, lambda s, _: 0.3 * s["roll_rate"]))
    assert "nearly 0.3 N m s/rad times the roll rate" in said


def test_a_cause_that_only_resembles_the_force_is_not_named(reference, motions):
    """Linear drag resembles drag in proportion to the square of the speed."""

    def force(moving, state, time):
        return [-0.5 * x for x in moving.powers(LOADS["drag"].law(moving))]

    residual = with_force(reference, motions, force)
    assert residual.best.codes == ("other_air_drag",)
    assert [(x.load, x.coefficient) for x in residual.loads] == [("drag", pytest.approx(-0.5))]
    assert acts_elsewhere(residual)
    left = LeftOfEquations(residual.shares, residual.acts_in, residual.above)
    said = ForceUnexplained(left, False, True, (residual.best,), residual.loads).message()
    assert said.startswith("The program applies a force along the velocity of the rear frame's")
    assert "The nearest known cause is this: the drag coefficient" in said


def test_a_cause_that_explains_all_is_named_though_a_load_resembles_it(reference, motions):
    """A steer torque in proportion to the steer rate is a damper, which is in the library."""
    damped = with_torque(reference, motions, 1, lambda s, _: -0.1 * s["steer_rate"])
    assert damped.best.codes == ("other_steer_damping",)
    assert not acts_elsewhere(damped)
