"""Files are read as vehicle engineers write them: with MATLAB's names, labels and layouts, and
others."""

import json
from io import StringIO

import h5py
import numpy as np
import pytest
import scipy.io

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score

TIME = np.arange(101) / 10
STATES = ("roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate")
# Number of correct digits of the coarsest columns, if the program writes everything in binary64.
RIGHT = 12


@pytest.fixture(scope="module")
def columns(reference):
    """Values by maneuver number and key."""
    whole, found = reference.with_motion(), {}
    for n in (1, 2, 3):
        values = whole[n].evaluate(TIME, [*KEYS, "pitch", "forward_speed_wheel_spin"])
        found[n] = {k: v[0] if isinstance(v, tuple) else v for k, v in values.items()}
    return found


def csv(folder, names, arrays, times=None):
    path = folder / "r.csv"
    said = [repr(float(t)) for t in TIME] if times is None else times
    cells = [said, *([repr(float(x)) for x in array] for array in arrays)]
    path.write_text("\n".join([",".join(names), *map(",".join, zip(*cells, strict=True))]) + "\n")
    return path


def assert_right(report, *keys, numbers=(1,), digits=RIGHT):
    assert [m.maneuver for m in report.maneuvers] == [*numbers]
    for m in report.maneuvers:
        assert sorted(c.key for c in m.columns) == sorted(keys)
        assert all(c.scd > digits for c in m.columns), [(c.key, c.scd) for c in m.columns]


def codes(report):
    return [f.code for f in report.findings]


@pytest.mark.parametrize(
    ("names", "keys"),
    [
        ("t,phi,p,u,delta,deltad", STATES),
        ("t,roll,rolld,vx,steer,steerd", STATES),
        ("t,theta,rollrate,speed,delta,deltadot", STATES),
        ("t,theta,p,v,delta,deltad", STATES),
        ("t,phi,p,u,V,T", (*STATES[:3], "potential_energy", "kinetic_energy")),
        ("t,phi,p,v,u,T", (*STATES[:3], "potential_energy", "kinetic_energy")),
        ("t,phi,theta", ("roll_angle", "pitch")),
    ],
)
def test_names_mean_what_their_values_are(names, keys, columns, reference, tmp_path):
    path = csv(tmp_path, names.split(","), [columns[1][k] for k in keys])
    digits = 5 if "pitch" in keys else RIGHT
    assert_right(score(path, reference), *keys, digits=digits)


def test_a_name_that_is_near_to_nothing_is_left_out(columns, reference, tmp_path):
    """Some programs call a wheel angle theta, and use v for a lateral speed if u is the forward
    one."""
    wheel = np.cumsum(columns[1]["forward_speed"])
    arrays = [columns[1]["roll_angle"], columns[1]["forward_speed"], 0.01 * wheel, wheel]
    report = score(csv(tmp_path, ["t", "phi", "u", "v", "theta"], arrays), reference)
    assert_right(report, "roll_angle", "forward_speed")
    said = [f.message for f in report.findings if f.code == "meant_by_values"]
    assert sum("none of these, so it is left out" in x for x in said) == 2


def test_a_wrong_speed_is_no_energy(columns, reference, tmp_path):
    arrays = [columns[1]["roll_angle"], 1.01 * columns[1]["forward_speed"]]
    report = score(csv(tmp_path, ["t", "phi", "u"], arrays), reference)
    assert report[1]["forward_speed"].scd < 3


@pytest.mark.parametrize("heading", ["forward_speed", "forward_speed [rad/s]", "v (rad/s)"])
@pytest.mark.parametrize("turned", [1, -1])
def test_the_rate_of_a_wheel_is_its_speed(heading, turned, columns, reference, tmp_path):
    rate = turned * columns[1]["forward_speed_wheel_spin"] / 0.3
    arrays = [columns[1]["roll_angle"], columns[1]["roll_rate"], rate]
    report = score(csv(tmp_path, ["t", "roll", "roll_rate", heading], arrays), reference)
    assert_right(report, *STATES[:3])
    speed = report[1]["forward_speed"]
    assert speed.as_understood.definition == "wheel_spin"
    assert speed.as_understood.unit == "0.3 m rad s-1"
    assert "wheel_rate" in codes(report)
    said = next(f.message for f in report.findings if f.code == "conventions")
    assert "forward_speed is in rad/s (wheel radius 0.3 m)" in said


@pytest.mark.parametrize("heading", ["forward_speed [rad/s]", "v [rad/s]"])
def test_a_speed_below_a_unit_of_rates_is_a_speed(heading, columns, reference, tmp_path):
    arrays = [columns[1]["roll_angle"], columns[1]["forward_speed"]]
    report = score(csv(tmp_path, ["t", "roll", heading], arrays), reference)
    assert_right(report, "roll_angle", "forward_speed")
    assert "wheel_rate" not in codes(report)


def test_energies_that_are_nan_are_absent(columns, reference, tmp_path):
    table = [columns[1][k] * (np.nan if "energy" in k else 1) for k in KEYS]
    report = score(csv(tmp_path, ["time", *KEYS], table), reference)
    assert_right(report, *STATES)
    assert report[1].coverage == 1
    (finding,) = [f for f in report.findings if f.code == "never_filled"]
    assert len(finding.evidence["columns"]) == 3
    assert "not_finite" not in codes(report)


@pytest.mark.parametrize("form", ["{:.1f} sec", "{:.1f} s", "00:00:{:04.1f}", '"{:.1f} sec"'])
def test_durations_of_a_timetable_are_times(form, columns, reference, tmp_path):
    times = [form.format(t) for t in TIME]
    path = csv(tmp_path, ["Time", *STATES], [columns[1][k] for k in STATES], times)
    assert_right(score(path, reference), *STATES)
    assert (read_results(path).maneuvers[0].time == TIME).all()


def long_rows(columns, numbers=(1,)):
    return [(n, float(t), key, float(x)) for n in numbers for key in STATES
            for t, x in zip(TIME, columns[n][key], strict=True)]  # fmt: skip


@pytest.mark.parametrize("form", ["csv", "json", "mapping", "parts"])
def test_long_tables_are_pivoted(form, columns, reference, tmp_path):
    rows = long_rows(columns, (1, 2, 3) if form == "parts" else (1,))
    given = tmp_path / f"r.{'json' if form == 'json' else 'csv'}"
    if form == "csv":
        given.write_text("time,variable,value\n" + "".join(f"{t},{k},{x}\n" for _, t, k, x in rows))
    elif form == "parts":
        text = "".join(f"m{n};{t};{k};{x}\n" for n, t, k, x in rows)
        given.write_text("maneuver;time;variable;value\n" + text)
    elif form == "json":
        given.write_text(json.dumps([{"time": t, "name": k, "value": x} for _, t, k, x in rows]))
    else:
        _, times, names, values = zip(*rows, strict=True)
        given = {"time": np.array(times), "variable": np.array(names), "value": np.array(values)}
    assert_right(score(given, reference), *STATES, numbers=(1, 2, 3) if form == "parts" else (1,))


def test_a_value_of_a_long_table_that_is_there_twice_is_named(columns):
    names = np.array(["roll_angle", "roll_angle"])
    with pytest.raises(InputError, match=r"found roll_angle at the time 0\.0 twice"):
        read_results({"time": np.zeros(2), "variable": names, "value": np.ones(2)})


def below(columns, label):
    """Rows of three maneuvers below each other, with a label before each maneuver."""
    text = StringIO()
    for n in (1, 2, 3):
        text.write(label(n) if label else "")
        for i, t in enumerate(TIME):
            text.write(" ".join(repr(float(x)) for x in [t, *(columns[n][k][i] for k in KEYS)]))
            text.write("\n")
    return text.getvalue()


@pytest.mark.parametrize(
    "label", [None, "maneuver {}\n".format, "# case {}\n".format, "Maneuver {}:\n\n".format]
)
def test_maneuvers_below_each_other_are_told_apart(label, columns, reference, tmp_path):
    path = tmp_path / "r.txt"
    path.write_text(below(columns, label))
    assert_right(score(path, reference), *KEYS, numbers=(1, 2, 3))


@pytest.mark.parametrize("labels", [("low", "mid", "high"), (7, 8, 9), ("m1", "m2", "m3")])
def test_maneuvers_told_apart_by_a_column(labels, columns, reference, tmp_path):
    path = tmp_path / "r.csv"
    rows = [(label, t, *(columns[n][k][i] for k in KEYS))
            for n, label in enumerate(labels, 1) for i, t in enumerate(TIME)]  # fmt: skip
    lines = [f"{label},{','.join(repr(float(x)) for x in numbers)}" for label, *numbers in rows]
    path.write_text("\n".join([f"case,time,{','.join(KEYS)}", *lines]))
    assert_right(score(path, reference), *KEYS, numbers=(1, 2, 3))


def test_maneuvers_below_each_other_are_never_one(columns, tmp_path):
    path = tmp_path / "r.txt"
    path.write_text(below(columns, None))
    with pytest.raises(
        InputError, match="found times that begin 3 times at 0, expected one maneuver"
    ):
        read_results(path, maneuver=2)
    assert [rows.maneuver for rows in read_results(path).maneuvers] == [None] * 3


@pytest.mark.parametrize("form", ["h5", "nc"])
def test_packed_numbers_are_as_fine_as_their_step(form, columns, reference, tmp_path):
    path, steps = tmp_path / f"r.{form}", {}
    with h5py.File(path, "w") if form == "h5" else scipy.io.netcdf_file(path, "w") as file:
        if form == "nc":
            file.createDimension("time", len(TIME))
        for key in ("time", *STATES):
            x = TIME if key == "time" else columns[1][key]
            steps[key] = 0.1 if key == "time" else np.ptp(x) / 60000
            offset = 0.0 if key == "time" else (x.min() + x.max()) / 2
            packed = np.rint((x - offset) / steps[key]).astype("i2")
            if form == "h5":
                attributes = file.create_dataset(key, data=packed).attrs
            else:
                variable = file.createVariable(key, "i2", ("time",))
                variable[:] = packed
                attributes = variable._attributes
            if key == "roll_angle":
                packed[3] = -32768
                (file[key] if form == "h5" else variable)[:] = packed
            attributes["scale_factor"] = np.float64(steps[key])
            attributes["add_offset"] = np.float64(offset)
            attributes["_FillValue"] = np.int16(-32768)
    (rows,) = read_results(path).maneuvers
    assert (rows.time == TIME).all()
    assert np.flatnonzero(np.isnan(rows.values["roll_angle"])).tolist() == [3]
    for key in STATES:
        far = np.nanmax(np.abs(rows.values[key] - columns[1][key]))
        assert steps[key] / 4 < far < 0.501 * steps[key]
        assert rows.quantum[key].at(np.ones(1)) == [steps[key]]
    report = score(path, reference)
    assert all(c.is_at_floor(1.01) for c in report[1].columns)


def test_floating_point_with_a_fill_value_alone_stays_as_it_is(columns, tmp_path):
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as file:
        file["time"], file["roll"] = TIME, columns[1]["roll_angle"].astype("f4")
        file["roll"].attrs["_FillValue"] = file["roll"][5]
    (rows,) = read_results(path).maneuvers
    assert rows.quantum["roll_angle"].digits == 24
    assert np.isnan(rows.values["roll_angle"][5])


ORDER = ("steer_angle", "roll_angle", "steer_rate", "roll_rate", "forward_speed",
         "kinetic_energy", "potential_energy", "mechanical_energy")  # fmt: skip


@pytest.mark.parametrize("numbers", [(2,), (1, 2, 3)])
def test_columns_in_another_order_are_named_once(numbers, columns, reference):
    table = np.column_stack([TIME, *(columns[n][k] for n in numbers for k in ORDER)])
    report = score(table, reference)
    assert not report.is_right
    (finding,) = [f for f in report.findings if f.severity == "warning"]
    assert finding.code == "columns_in_another_order"
    told = finding.message.partition("columns=")[2]
    assert_right(score(table, reference, columns=told, maneuver=2 if len(numbers) == 1 else None),
                 *KEYS, numbers=numbers)  # fmt: skip


def test_another_order_in_one_maneuver_is_undone_there_alone(columns, reference):
    orders = {1: KEYS, 2: ORDER, 3: KEYS}
    table = np.column_stack([TIME, *(columns[n][k] for n, keys in orders.items() for k in keys)])
    (finding,) = [f for f in score(table, reference).findings if f.severity == "warning"]
    assert finding.evidence["maneuvers"] == [2]
    assert finding.message.startswith("The columns of maneuver 2 seem to be in another order")
    told = finding.message.partition("columns=")[2]
    assert_right(score(table, reference, columns=told), *KEYS, numbers=(1, 2, 3))


def test_two_columns_that_changed_places_are_named(columns, reference):
    keys = [KEYS[6], *KEYS[1:6], KEYS[0], KEYS[7]]
    report = score(np.column_stack([TIME, *(columns[1][k] for k in keys)]), reference)
    assert "columns_in_another_order" in codes(report)


def cells(*values, shape=None):
    found = np.empty(len(values), dtype=object)
    found[:] = values
    return found if shape is None else found.reshape(shape)


@pytest.mark.parametrize("form", ["tables", "parts", "sheet"])
@pytest.mark.parametrize("by", ["5", "7.3"])
def test_cells_of_matlab_are_read(form, by, columns, reference, tmp_path):
    tables = [np.column_stack([columns[n][k] for k in KEYS]) for n in (1, 2, 3)]
    times = [TIME[:, None]] * 3
    if form == "tables":
        saved = {"r": cells(*(np.hstack(x) for x in zip(times, tables, strict=True)))}
    elif form == "parts":
        saved = {"t": cells(*times), "y": cells(*tables)}
    else:
        rows = [["time", *KEYS], *np.hstack([times[0], tables[0]]).tolist()]
        flat = [x for row in rows for x in row]
        saved = {"r": cells(*flat, shape=(len(rows), 9))}
    path = tmp_path / "r.mat"
    if by == "5":
        scipy.io.savemat(path, saved)
    elif form == "sheet":
        pytest.skip("hundreds of references in a file of HDF5 tell no more")
    else:
        write_cells(path, saved)
    assert_right(score(path, reference), *KEYS, numbers=(1,) if form == "sheet" else (1, 2, 3))


def write_cells(path, saved):
    """Write cell arrays like MATLAB 7.3: references, column by column, to datasets in #refs#."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, x in saved.items():
            places = [file.create_dataset(f"#refs#/{name}{i}", data=y.T) for i, y in enumerate(x)]
            held = file.create_dataset(name, (len(places), 1), dtype=h5py.ref_dtype)
            held[:, 0] = [place.ref for place in places]
            held.attrs["MATLAB_class"] = np.bytes_(b"cell")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def test_a_table_of_version_7_3_is_named(tmp_path):
    path = tmp_path / "r.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["r"] = np.zeros((1, 6), dtype="u4")
        file["r"].attrs["MATLAB_class"] = np.bytes_(b"table")
        file["r"].attrs["MATLAB_object_decode"] = np.int32(3)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    with pytest.raises(InputError, match=r"found 'r', a table, .*writetable\(r, 'results.csv'\)"):
        read_results(path)


def test_the_solution_of_ode45_is_read_as_told(columns, reference, tmp_path):
    path = tmp_path / "r.mat"
    states = np.array([columns[2][k] for k in ("steer_angle", "roll_angle", "steer_rate")])
    sol = {"solver": "ode45", "extdata": {"odefun": "f"}, "x": TIME[None], "y": states,
           "stats": {"nsteps": 100.0}, "idata": {"f3d": np.zeros((3, 7, 101))}}  # fmt: skip
    scipy.io.savemat(path, {"sol": sol})
    with pytest.raises(
        InputError, match="found 'sol', a solution of ode45 with 3 states without names"
    ):
        read_results(path)
    report = score(path, reference, columns="t,steer,roll,steer_rate", maneuver=2)
    assert_right(report, "steer_angle", "roll_angle", "steer_rate", numbers=(2,))
