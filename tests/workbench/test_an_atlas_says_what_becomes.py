"""The atlas's statements on a start are true, and independent of other starts in the batch."""

import json
import shutil
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike.bicycle.equations.kinematics import turn_divisor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.motion.events import REAR_LIFT, follow
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.parallel import using
from heyoka_bike.system.resources import after_folder, data_folder
from heyoka_bike.workbench.after_ten_seconds.facts import prove_lift
from heyoka_bike.workbench.atlas.data import (
    CYCLE,
    FALLS,
    FATES,
    LIFTS,
    REAR,
    UPRIGHT,
    VARIABLES,
    WEAVES,
)
from heyoka_bike.workbench.atlas.design import ACCURACY, axis, design
from heyoka_bike.workbench.atlas.fates import fates, repeats
from heyoka_bike.workbench.atlas.make import bisect_boundary, changes, chunk, lift_of, make_atlas
from heyoka_bike.workbench.atlas.runs import LEAST_TURN, PLANS, SPACING, Runs
from heyoka_bike.workbench.atlas.store import AtlasStore, load_atlas

PLAN = PLANS[ACCURACY]


@pytest.fixture(scope="module")
def runs(bicycle):
    return Runs([bicycle], PLAN)


def starts(*pairs):
    """Return starts from pairs of speed [m/s] and roll rate [rad/s]."""
    found = np.zeros((len(pairs), len(START)))
    for row, (speed, roll_rate) in zip(found, pairs, strict=True):
        row[START.index("speed")], row[START.index("roll_rate")] = speed, roll_rate
    return found


def of(runs, *pairs):
    return fates(runs, starts(*pairs), np.zeros(len(pairs), int))


@pytest.mark.proof
def test_the_three_maneuvers_become_what_is_proved(runs):
    found = of(runs, (4.0, 0.05), (4.6, 0.5), (8.0, 0.05))
    assert found["fate"].tolist() == [CYCLE, UPRIGHT, FALLS]
    proved = json.loads((after_folder() / "after-ten-seconds.json").read_text())
    numbers = json.dumps(proved)
    for digits in ("4.03978871801", "4.62244209582643", "44.43042627212", "1.2486551661"):
        assert digits in numbers
    # The mean speed of a cycle is computed from samples, so it is less accurate than a final speed.
    assert found["final_speed"][0] == pytest.approx(4.03978871801, abs=1e-4)
    assert found["final_speed"][1] == pytest.approx(4.62244209582643, abs=1e-13)
    assert np.isnan(found["final_speed"][2])
    # The error of the steps grows over 44 s, and the time of lift-off is interpolated over a
    # thousandth of a second.
    assert found["lift_time"][2] == pytest.approx(44.43042627212, abs=1e-4)
    assert found["lift_wheel"].tolist() == [0, 0, REAR]
    assert found["fate_time"][2] > found["lift_time"][2]
    # The largest lean is the maximum of a parabola through samples, which is an approximation.
    assert found["largest_lean"][2] == pytest.approx(1.2486551661, abs=2e-5)
    assert found["largest_lean"][0] == pytest.approx(0.187013377283, abs=2e-5)


@pytest.mark.proof
def test_a_point_of_a_whole_chunk_is_as_alone(runs, bicycle):
    """One point ends a window in the step that ends another point of its vector."""
    whole = design(bicycle, [axis("2.5:8.5:200", "speed"), axis("0.02:4:200", "roll_rate")])
    place = tuple(
        np.argmin(np.abs(a.values - x)) for a, x in zip(whole.axes, (4.7613, 2.58), strict=True)
    )
    found = chunk(whole, tuple(i // whole.side for i in place))
    inside = tuple(i % whole.side for i in place)
    pair = [a.values[i] for a, i in zip(whole.axes, place, strict=True)]
    assert found["fate"][inside] == LIFTS
    for name, value in of(runs, pair).items():
        assert found[name][inside] == value[0], name


@pytest.mark.proof
def test_lifts_are_the_events_of_single_runs(runs, bicycle, maneuvers):
    pairs = (4.6, 2.6), (4.6, 2.46), (3.0, 0.1)
    found = of(runs, *pairs)["lift_time"]
    for (speed, roll_rate), time in zip(pairs, found, strict=True):
        start = replace(
            maneuvers[0], speed=Exact(Fraction(speed)), roll_rate=Exact(Fraction(roll_rate))
        )
        event = follow(bicycle, start, longest=Fraction(8)).event
        # The atlas interpolates this time between samples that are a thousandth of a second apart.
        assert time == pytest.approx(float(event.time), abs=2e-5)


@pytest.mark.proof
def test_conditions_are_those_of_the_sensitivities(runs):
    known = json.loads((data_folder().parent / "docs" / "harder-tier.json").read_text())
    expected = [
        *(known["H1"]["maneuvers"][f"maneuver {i}"]["condition"] for i in (1, 2, 3)),
        *(known["H3"]["maneuvers"][f"H3{x}"]["condition"] for x in "abcd"),
    ]
    edge = [(4.6, rate) for rate in (1.0, 2.0, 2.4, 2.4649)]
    found = of(runs, (4.0, 0.05), (4.6, 0.5), (8.0, 0.05), *edge)["condition"]
    # The atlas samples bursts 32 times a second. The expected values are sampled 100 times a
    # second.
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.proof
def test_falls_are_those_of_another_integrator(runs, bicycle):
    """SciPy's DOP853 integrates the equations, with the handlebar's rotation as an event."""
    from scipy.integrate import solve_ivp

    pairs = (3.0, 0.5), (4.6, 2.6), (5.0, 2.0), (6.0, 3.8)
    found = of(runs, *pairs)
    equations = Equations.binary64(bicycle)

    def rates(t, state):
        return np.array(equations.rates(list(state)))

    def across(t, state):
        return abs(state[2]) - np.pi / 2

    def end(t, state):
        return abs(turn_divisor(equations.unfold(list(state))[0])) - LEAST_TURN

    across.terminal = end.terminal = True
    for i, (speed, roll_rate) in enumerate(pairs):
        start = [0, 0, 0, roll_rate, 0, speed / equations.k.length]
        run = solve_ivp(
            rates, (0, 12), start, "DOP853", rtol=1e-11, atol=1e-12, events=(across, end)
        )
        time, has_fallen = found["fate_time"][i], run.status == 1
        assert has_fallen == (found["fate"][i] == FALLS)
        if has_fallen:
            assert run.t[-1] == pytest.approx(time, abs=1e-6)
        else:
            assert np.abs(run.y[[0, 2], -1]).max() < 0.05
        # The integrator's steps and the samples of the atlas are at different times, so their
        # maxima differ slightly.
        assert found["largest_lean"][i] == pytest.approx(np.abs(run.y[0]).max(), rel=0.02)
    assert set(found["fate"]) == {FALLS, UPRIGHT}


@pytest.mark.proof
def test_a_point_does_not_depend_on_its_neighbours(runs):
    pairs = (4.0, 0.05), (4.6, 2.46), (3.0, 0.1), (5.0, 3.4), (6.5, 1.0), (4.6, 0.5)
    together = of(runs, *pairs)
    assert set(together["fate"]) == {CYCLE, LIFTS, FALLS, UPRIGHT}
    for i, pair in enumerate(pairs):
        alone = of(runs, pair)
        for name, values in together.items():
            assert np.array_equal(values[i : i + 1], alone[name], equal_nan=True), (name, pair)


@pytest.mark.proof
def test_left_and_right_are_alike(runs):
    found = of(runs, (4.6, 2.46), (4.6, -2.46), (3.5, 0.3), (3.5, -0.3))
    for values in found.values():
        assert np.array_equal(values[::2], values[1::2], equal_nan=True)


@pytest.mark.parametrize(("heights", "is_periodic"), [
    ([1.0], True), ([1.0, 0.7], True), ([1.0, 0.7, 0.9], True),
    ([1.0 + 0.002 * i for i in range(60)], False),
    ([abs(np.sin(i * i)) + 0.3 for i in range(60)], False),
])  # fmt: skip
def test_a_weave_repeats_itself_or_not(heights, is_periodic):
    time = np.arange(640) * SPACING
    half = np.floor(time).astype(int)
    lean = np.sin(np.pi * time) * np.array([heights[i % len(heights)] for i in half])
    found = repeats(lean)
    assert (found is not None) == is_periodic
    if found is not None:
        # The repeated part consists of whole periods, each with turns to the left and to the right.
        period = len(heights) if len(heights) % 2 == 0 else 2 * len(heights)
        assert (found.stop - found.start) * SPACING % period in (0.0, pytest.approx(0.0, abs=0.1))
    assert repeats(np.abs(lean)) is None


def test_changes_are_between_known_neighbours():
    row = np.array([UPRIGHT, UPRIGHT, FALLS, FALLS, 0, UPRIGHT, 0, FALLS, WEAVES])
    stays, falls = changes(np.arange(9.0), row)
    assert stays.tolist() == [1.0, 8.0]
    assert falls.tolist() == [2.0, 7.0]


@pytest.fixture(scope="module")
def small(bicycle):
    return design(bicycle, [axis("4:5:5", "speed"), axis("0.4:2:5", "roll_rate")])


@pytest.fixture(scope="module")
def whole(small, tmp_path_factory):
    folder = tmp_path_factory.mktemp("atlas") / "whole.zarr"
    with ThreadPoolExecutor(1) as pool, using(executor=pool):
        make_atlas(small, folder)
    return folder


def content(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.proof
def test_xarray_opens_an_atlas(whole, small):
    import xarray

    with xarray.open_zarr(whole) as found:
        assert found.fate.dims == ("speed", "roll_rate")
        assert found.fate.dtype == np.int8
        assert found.fate.attrs["flag_meanings"].split() == list(FATES)
        assert found.speed.attrs["units"] == "m s-1"
        assert np.array_equal(found.roll_rate, small.axes[1].values)
        point = found.sel(speed=4.5, roll_rate=0.4)
        assert point.fate == UPRIGHT
        assert point.final_speed.attrs["units"] == "m s-1"
        assert found.attrs["provenance"]["heyoka"]
        assert (found.checksum != 0).all()


@pytest.mark.proof
def test_an_interrupted_atlas_goes_on_to_the_same_bytes(whole, small, tmp_path):
    folder = tmp_path / "again.zarr"
    store = AtlasStore(folder, small)
    atlas = load_atlas(whole)
    first = next(iter(small.chunks()))
    part = small.slices(first)
    store.put(first, {name: values[part] for name, values in atlas.variables.items()})
    assert first not in AtlasStore(folder, small).missing()
    assert content(folder) != content(whole)
    with ThreadPoolExecutor(1) as pool, using(executor=pool):
        made = make_atlas(small, folder)
    assert content(folder) == content(whole)
    assert np.array_equal(made.variables["fate"], atlas.variables["fate"])


def numbers(atlas):
    found = [*(a.values for a in atlas.axes), *atlas.variables.values()]
    found += [atlas.edge.at, atlas.edge.stays, atlas.edge.falls]
    symbols = {s: str(atlas.bicycle[s]) for s in PARAMETERS}
    return [x.tobytes() for x in found] + [symbols, atlas.start, atlas.provenance]


def damages(folder, random):
    """Yield each damage: a missing file, a cut file, and a flipped bit."""
    for file in sorted(p for p in folder.rglob("*") if p.is_file()):
        data = file.read_bytes()
        yield file, None
        yield file, data[: len(data) // 2]
        changed = bytearray(data)
        changed[random.integers(len(data))] ^= 1 << int(random.integers(8))
        yield file, bytes(changed)


@pytest.mark.proof
def test_a_damaged_atlas_is_refused_and_mended(whole, small, tmp_path):
    """Damaged numbers are never read, and the same run computes a damaged grid again."""
    folder = tmp_path / "damaged.zarr"
    shutil.copytree(whole, folder)
    right, outcomes = numbers(load_atlas(whole)), Counter()
    for file, data in damages(folder, np.random.default_rng(1)):
        before = file.read_bytes()
        file.unlink()
        if data is not None:
            file.write_bytes(data)
        try:
            assert numbers(load_atlas(folder)) == right, (file, data)
            outcomes["same"] += 1
        except DatasetError as e:
            said = str(e)
            outcomes["refused" if "\n" not in said else "not in one line"] += 1
            if file.parent.name in VARIABLES and not file.name.startswith("."):
                assert f": chunk {file.name} is damaged: " in said
            # Repair the atlas only after every twelfth damage, because each repair computes a
            # chunk.
            if "repeat the command" in said and outcomes["refused"] % 12 == 0:
                with ThreadPoolExecutor(1) as pool, using(executor=pool):
                    assert numbers(make_atlas(small, folder)) == right
                outcomes["mended"] += 1
        file.write_bytes(before)
    assert outcomes.keys() == {"same", "refused", "mended"}
    assert min(outcomes.values()) > 4, outcomes


@pytest.mark.proof
def test_an_atlas_whose_grid_is_damaged_is_made_anew_on_demand(whole, small, tmp_path):
    folder = tmp_path / "damaged.zarr"
    shutil.copytree(whole, folder)
    (folder / "speed" / "0").unlink()
    with pytest.raises(InputError, match=r"an atlas that is damaged; .*--force"):
        AtlasStore(folder, small)
    assert AtlasStore(folder, small, force=True).missing() == list(small.chunks())


@pytest.mark.proof
def test_a_folder_of_something_else_is_refused(whole, bicycle, small, tmp_path):
    other = design(bicycle, [axis("4:5:6", "speed"), axis("0.4:2:5", "roll_rate")])
    with pytest.raises(InputError, match="differs in inputs; use another folder"):
        AtlasStore(whole, other)
    (tmp_path / "notes.txt").write_text("mine")
    for force in (False, True):
        with pytest.raises(InputError, match="something other than an atlas"):
            AtlasStore(tmp_path, small, force=force)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    with pytest.raises(DatasetError, match="no atlas can be read"):
        load_atlas(tmp_path)


@pytest.mark.parametrize(("text", "name", "said"), [
    ("3:8", "speed", "--speed: found '3:8', expected FROM:TO:N"),
    ("8:3:20", "speed", "--speed: found '8:3:20', expected FROM below TO"),
    ("3:8:1", "roll_rate", "--roll-rate: found '1' points, expected 2 or more"),
    ("x:8:3", "c", "--axis c: "),
])  # fmt: skip
def test_bad_axes_are_refused(text, name, said):
    with pytest.raises(InputError) as found:
        axis(text, name)
    assert str(found.value).startswith(said)


def test_a_parameter_outside_the_model_is_refused(bicycle):
    with pytest.raises(InputError, match="rR"):
        design(bicycle, [axis("-1:1:3", "rR"), axis("3:5:2", "speed")])


@pytest.mark.proof
def test_the_edge_of_falling_is_where_binary128_has_it(bicycle):
    grid = design(bicycle, [axis("4:5:11", "speed"), axis("2:3:11", "roll_rate")])
    at, stays, falls = bisect_boundary(grid, np.array([4.6]), np.array([2.4]), np.array([2.5]))
    assert at == [4.6]
    assert np.nextafter(stays, 3) == falls
    exact = Fraction("2.46491144053243234304")
    # The binary64 number nearest to 4.6 is not exactly 4.6. The motion magnifies this difference to
    # a few units in the last place.
    assert abs(Fraction(float(stays[0])) - exact) <= 4 * Fraction(float(np.spacing(stays[0])))


@pytest.mark.proof
def test_constants_that_are_read_are_those_compiled_in(runs, bicycle):
    pairs = (4.0, 0.05), (4.6, 0.5), (4.6, 2.46), (3.0, 0.1)
    longer = bicycle.replace(c=Exact(Fraction(1, 10)))
    several = Runs([longer, bicycle], PLAN)
    compiled, read = of(runs, *pairs), fates(several, starts(*pairs), np.ones(4, int))
    assert np.array_equal(compiled["fate"], read["fate"])
    for name in ("final_speed", "largest_steer", "lift_time"):
        assert read[name] == pytest.approx(compiled[name], rel=1e-6, nan_ok=True)
    other = fates(several, starts(*pairs), np.zeros(4, int))
    alone = of(Runs([longer], PLAN), *pairs)
    assert np.array_equal(other["fate"], alone["fate"])
    assert other["largest_steer"][:2] == pytest.approx(alone["largest_steer"][:2], rel=1e-6)
    assert other["largest_steer"][1] != pytest.approx(read["largest_steer"][1], rel=1e-3)


@pytest.mark.proof
def test_a_lift_is_proved_where_it_was_found(small):
    point = {"speed": Exact(Fraction("4.6")), "roll_rate": Exact(Fraction("3.3"))}
    bicycle, maneuver, time = lift_of(small, point)
    proved = prove_lift(bicycle, maneuver, time)
    assert proved.is_decided
    assert proved.lift.what == REAR_LIFT
    assert float(proved.lift.time) == pytest.approx(time, abs=2e-5)
    # A candidate that ends before the lift proves that no wheel lifts until its end.
    sooner = prove_lift(bicycle, maneuver, time - 0.01)
    assert sooner.lift is None
    assert sooner.is_decided
    assert sooner.end < time
