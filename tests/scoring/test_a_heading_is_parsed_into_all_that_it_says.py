"""One parse of a heading gives its column, its maneuver and its unit; tables keep them together."""

import pytest

from heyoka_bike import read_results
from heyoka_bike.scoring.reading.names.heading import Heading, parse_heading


@pytest.mark.parametrize(
    ("text", "key", "maneuver", "unit", "known_unit"),
    [
        ("roll_angle", "roll_angle", None, None, None),
        ("m2_roll_angle_deg", "roll_angle", 2, "deg", "degree"),
        ("V3 [kJ]", "potential_energy", 3, "kJ", "kJ"),
        ("t [ms]", "time", None, "ms", "ms"),
        ("roll_angle [m]", "roll_angle", None, "m", None),
        ("brake force [N]", None, None, "N", None),
    ],
)
def test_all_is_in_one_heading(text, key, maneuver, unit, known_unit):
    heading = parse_heading(text)
    assert heading == Heading(text, key, maneuver, unit, is_ending="_deg" in text)
    assert heading.known_unit == known_unit
    assert heading.is_time is (key == "time")


def test_the_columns_of_a_table_keep_what_their_headings_say(tmp_path):
    path = tmp_path / "result.csv"
    path.write_text(
        "t [ms],m2_roll_deg,m2_v [km/h],m2_T [kJ]\n0,0,14.4,1\n10,1,14.4,1\n20,2,14,1\n"
    )
    (rows,) = read_results(path).maneuvers
    assert rows.maneuver == 2
    assert rows.units == {
        "time": "ms", "roll_angle": "degree", "forward_speed": "km h-1", "kinetic_energy": "kJ"
    }  # fmt: skip
