"""Each engine loads every bicycle of the collection unchanged, and rolls it for a second."""

import numpy as np
import pytest

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import benchmark, read_bicycle
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.reference.exports.models import MODELS, render
from heyoka_bike.reference.exports.solid import nearest_solid
from heyoka_bike.system.resources import collection, find_input
from support import engines
from support.engines import ENGINES, apart, need
from support.model_files import model_of

pytestmark = [pytest.mark.peers, pytest.mark.timeout(600)]

NAMES = tuple(collection("bicycles"))
MANEUVER, SECONDS = 2, 1.0
ROUNDOFF = 1e-12
STEPS = 2000
BITS = 128
FALLEN = 0.8  # roll angle that counts as a fall [rad]
LEAST_MASS, LEAST_RADIUS = 0.1, 0.1  # least mass [kg] and radius [m] of a wheel that is tested
# Limits of the errors after one second, relative to the largest angle during it. In engines with
# contact, the errors are of first order in the step. Pinocchio rolls by constraints, without
# contact.
BOUNDS = {"mujoco": 0.02, "pinocchio": 1e-6}
BOUND = 0.2


def after(bicycle, maneuver):
    """Return roll and steer angle at the end, and their maxima; None if the bicycle falls.

    The method is Runge-Kutta 4 on the package's equations.
    """
    start = initial_state(Equations.of(bicycle, Balls(BITS)), maneuver)
    y = np.array([float(x.mid()) for x in start])[:6]
    equations, h = Equations.binary64(bicycle), SECONDS / STEPS

    def slope(y):
        return np.array(equations.rates(list(y)), dtype=float)

    largest = np.abs(y[[0, 2]])
    for _ in range(STEPS):
        a = slope(y)
        b = slope(y + h / 2 * a)
        c = slope(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + slope(y + h * c))
        largest = np.maximum(largest, np.abs(y[[0, 2]]))
        if largest[0] > FALLEN:
            return None
    return y[0], y[2], largest


@pytest.fixture(scope="module")
def maneuvers():
    return benchmark()[1]


@pytest.mark.parametrize("name", ENGINES)
def test_every_bicycle(name, maneuvers, tmp_path):
    need(name)
    kind = ENGINES[name][2]
    bicycles = [nearest_solid(read_bicycle(find_input("bicycles", x)))[0] for x in NAMES]
    files = []
    for i, bicycle in enumerate(bicycles):
        path = tmp_path / f"{i}{MODELS[kind].suffix}"
        path.write_bytes(render(kind, bicycle, maneuvers))
        files.append((str(path), MANEUVER))
    found = apart(engines.tried, name, files, SECONDS)
    for other, bicycle, (has, roll, steer) in zip(NAMES, bicycles, found, strict=True):
        model = model_of(kind, bicycle)
        zero = np.zeros(3)
        centres = model.centres_of_mass(zero, np.eye(3), zero)
        for x in "BRHF":
            assert has["masses"][x] == pytest.approx(model.masses[x], rel=ROUNDOFF), other
            assert has["centres"][x] == pytest.approx(centres[x], abs=ROUNDOFF), other
        _, _, axis = model.hinges["H"]
        assert has["axis"] == pytest.approx(axis, abs=ROUNDOFF), other
        assert has["gravity"] == pytest.approx(float(bicycle["g"]), rel=1e-15), other
        for angles, matrix in zip(([0, 0, 0], [0, 0.4, 0]), has["matrices"], strict=True):
            expected = model.mass_matrix(zero, np.eye(3), np.array(angles))
            assert np.abs(matrix - expected).max() < ROUNDOFF * np.abs(expected).max(), other
        right = after(bicycle, maneuvers[MANEUVER - 1])
        if right is None:
            print(f"{name} {other}: falls")
            continue
        right_roll, right_steer, largest = right
        error = np.abs([roll - right_roll, steer - right_steer]) / largest
        print(f"{name} {other}: roll and steer angle off by {error} of their largest values")
        # The engines cannot compute contact for wheels with a mass of a milligram or the size of a
        # coin, so such bicycles are not tested.
        if min(float(bicycle[x]) for x in ("mR", "mF")) > LEAST_MASS and (
            min(float(bicycle[x]) for x in ("rR", "rF")) > LEAST_RADIUS
        ):
            assert error.max() < BOUNDS.get(name, BOUND), other
