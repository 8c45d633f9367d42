"""Units in headings are tried. Unknown units and units that contradict the values are reported."""

import numpy as np
import pytest

from generators.made_results import is_right_in_part
from heyoka_bike.scoring.reading.names.heading import parse_heading
from heyoka_bike.scoring.reading.names.heading_units import _WORDS, quantities, unknown_unit
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.units import UNITS, factor

DEGREES = 180 / np.pi


def report_of(reference, tmp_path, heading, factors):
    """Score maneuver 2 as a file: time, roll, speed and kinetic energy, each multiplied by its
    factor."""
    m = reference[2]
    keys = ("roll_angle", "forward_speed", "kinetic_energy")
    columns = [x * m.rows[key] for x, key in zip(factors[1:], keys, strict=True)]
    table = np.column_stack([factors[0] * m.time, *columns])
    path = tmp_path / "r.csv"
    np.savetxt(path, table, fmt="%.15g", delimiter=",", header=heading, comments="")
    return score(path, reference)


def findings(report, *codes):
    return [f for f in report.findings if f.code in codes]


@pytest.mark.parametrize(
    ("heading", "factors", "units"),
    [
        ("t [ms],roll [mrad],v [km/h],T [kJ]", (1e3, 1e3, 3.6, 1e-3), ("mrad", "km h-1", "kJ")),
        ("t [s],roll [\u00b5rad],v [cm/s],T [MJ]", (1, 1e6, 1e2, 1e-6), ("urad", "cm s-1", "MJ")),
        ("t,roll (arcmin),v (mph),T (ft lbf)", (1, 60 * DEGREES, 1 / 0.44704, 1 / 1.35581794833),
         ("arcminute", "mile h-1", "foot lbf")),
        ("t,roll [rev],v [ft/s],T [Wh]", (1, 0.5 / np.pi, 1 / 0.3048, 1 / 3600),
         ("revolution", "foot s-1", "W h")),
        ("t,roll [rad],v [knots],T [mJ]", (1, 1, 3600 / 1852, 1e3), ("rad", "knot", "mJ")),
        ("t,roll,v,T [kcal]", (1, 1, 1, 1 / 4184), ("rad", "m s-1", "kcal")),
        ("t,roll,v,T [cal]", (1, 1, 1, 1 / 4.184), ("rad", "m s-1", "cal")),
        ("t,roll,v,T (BTU)", (1, 1, 1, 1 / 1055.05585262), ("rad", "m s-1", "BTU")),
        ("t,roll,v,T [kWh]", (1, 1, 1, 1 / 3.6e6), ("rad", "m s-1", "kW h")),
        ("t,roll,v,T [eV]", (1, 1, 1, 1 / 1.602176634e-19), ("rad", "m s-1", "eV")),
    ],
)  # fmt: skip
def test_units_that_are_named_are_tried(heading, factors, units, reference, tmp_path):
    report = report_of(reference, tmp_path, heading, factors)
    (m,) = report.maneuvers
    assert tuple(c.as_understood.unit for c in m.columns) == units
    # The energy in the unit with pounds was written with 12 digits.
    assert all(c.as_understood.measures.scd > 11 for c in m.columns)
    assert not findings(report, "unit_unknown", "unit_contradicted")


@pytest.mark.parametrize("zero", [0.0, -300.0])
def test_each_energy_has_the_unit_that_its_heading_names(zero, reference, tmp_path):
    m = reference[2]
    keys = ("roll_angle", "roll_rate", "potential_energy", "kinetic_energy", "mechanical_energy")
    roll, rate, potential, kinetic, whole = (m.rows[key] for key in keys)
    table = np.column_stack([m.time, roll, rate, potential + zero, kinetic, (whole + zero) / 1e3])
    path = tmp_path / "r.csv"
    heading = "t,roll_angle,roll_rate,V [J],T,E [kJ]"
    np.savetxt(path, table, fmt="%.15g", delimiter=",", header=heading, comments="")
    report = score(path, reference)
    assert is_right_in_part(report)
    assert not findings(report, "unit_contradicted")
    taken = {c.key: c.as_understood for c in report.maneuvers[0].columns}
    assert [taken[key].unit for key in keys[2:]] == ["J", "J", "kJ"]
    offset = taken["mechanical_energy"].offset
    assert offset == pytest.approx(zero, abs=1e-9)
    assert offset == taken["potential_energy"].offset


def test_units_that_are_not_named_are_not_tried(reference, tmp_path):
    report = report_of(reference, tmp_path, "t,roll,v,T [J]", (1, 1e3, 1e2, 1))
    (m,) = report.maneuvers
    assert all(c.as_understood.unit in UNITS[c.unit] for c in m.columns)
    assert m.columns[0].as_understood.measures.scd < 0


@pytest.mark.parametrize(
    ("heading", "factors", "said"),
    [
        ("t,Roll (deg),speed [m/s],KE [J]", (1, 1, 3.6, 1),
         [("roll_angle", "degree", "rad"), ("forward_speed", "m s-1", "km h-1")]),
        ("t,Roll [mrad],speed [m/s],KE [kJ]", (1, DEGREES, 1, 1),
         [("roll_angle", "mrad", "degree"), ("kinetic_energy", "kJ", "J")]),
        ("t,Roll (deg),speed [m/s],KE [J]", (1, DEGREES, 1, 1), []),
        # The motion is wrong, but the report still states how its columns were interpreted.
        ("t,Roll (deg),speed [m/s],KE [J]", (1, 1.3, 1.3, 1.3), [("roll_angle", "degree", "rad")]),
    ],
)  # fmt: skip
def test_units_that_contradict_the_values_are_told(heading, factors, said, reference, tmp_path):
    report = report_of(reference, tmp_path, heading, factors)
    found = findings(report, "unit_contradicted")
    assert [tuple(f.evidence.values()) for f in found] == said
    assert all(f.severity == "warning" for f in found)


@pytest.mark.parametrize("written", [DEGREES, 1])
def test_a_heading_is_believed_of_a_motion_that_tells_nothing(written, reference, tmp_path):
    # The column resembles a motion of the linearised equations at 4 m/s: its roll angle is a few
    # times too large and out of phase.
    m = reference[1]
    roll = -3 * written * np.roll(m.rows["roll_angle"], 60)
    heading = "t,m1_roll_deg" if written == DEGREES else "t,m1_roll_rad"
    path = tmp_path / "r.csv"
    table = np.column_stack([m.time, roll])
    np.savetxt(path, table, fmt="%.15g", delimiter=",", header=heading, comments="")
    report = score(path, reference)
    (column,) = report.maneuvers[0].columns
    assert column.as_understood.unit == ("degree" if written == DEGREES else "rad")
    assert column.as_understood.measures.max_abs_error < 1


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("v [furlong/h]", "furlong/h"), ("v (furlong/h)", "furlong/h"),
        ("t [fortnight]", "fortnight"),
        ("phi(t)", None), ("v [m/s]", None), ("roll [2]", None), ("roll [m2]", None),
        (r"\dot{\phi}", None),
        ("roll (right positive)", None), ("roll [-]", None), ("roll [SI]", None), ("roll", None),
    ],
)  # fmt: skip
def test_units_that_are_not_known_are_told(name, unit, tmp_path):
    assert unknown_unit(name) == unit
    names = [name, "phi"] if name.startswith("t") else ["t", name]
    results = read_results({n: np.arange(9.0) for n in names})
    found = [f for f in results.findings if f.code == "unit_unknown"]
    assert [f.evidence["unit"] for f in found] == ([] if unit is None else [unit])
    assert all(f"'{unit}'" in f.message and f.severity == "warning" for f in found)


def test_every_unit_that_a_heading_may_name_can_be_converted():
    spelt = {f"{word}{per}" for word in _WORDS for per in ("", "/s", " per min")}
    named = {unit for word in spelt for unit in quantities(word).values()}
    assert {"degree s-1", "revolution min-1", "foot", "W h", "mile h-1", "knot"} <= named
    assert all(factor(u)[0] > 0 for u in named)


@pytest.mark.parametrize(
    ("name", "key", "unit"),
    [
        ("T [MJ]", "kinetic_energy", "MJ"), ("T [mJ]", "kinetic_energy", "mJ"),
        ("T [KJ]", "kinetic_energy", "kJ"), ("E_pot [kN m]", "potential_energy", "kJ"),
        ("roll rate [rpm]", "roll_rate", "revolution min-1"),
        ("roll rate [deg/min]", "roll_rate", "degree min-1"),
        ("roll_deg", "roll_angle", "degree"), ("roll", "roll_angle", None),
        ("roll_angle [kg]", "roll_angle", None), ("roll_angle [m]", "roll_angle", None),
    ],
)  # fmt: skip
def test_units_of_names(name, key, unit):
    heading = parse_heading(name)
    assert (heading.key, heading.known_unit) == (key, unit)
