"""Mappings report a wrong name or number together with the available ones."""

from functools import cache

import pytest

from heyoka_bike import load_reference, read_bicycle, score
from heyoka_bike.scoring.series import compare
from heyoka_bike.system.resources import benchmark_bicycle


@cache
def held():
    reference = load_reference()
    array = [reference.times, *(reference[2][key] for key in ("roll_angle", "steer_angle"))]
    columns = {"time": array[0], "roll_angle": array[1], "steer_angle": array[2]}
    report = score(columns, maneuver=2)
    return {
        "values": reference[2].rows,
        "maneuver of the reference": reference[2],
        "report": report,
        "maneuver of a report": report[2],
        "series": compare({"a": columns, "b": columns}),
        "bicycle": read_bicycle(benchmark_bicycle()),
    }


@pytest.mark.parametrize("name", list(held()))
@pytest.mark.parametrize("asked", [1.5, None, ("roll_angle",), "roll angel"], ids=str)
def test_found_and_expected_are_said(name, asked):
    with pytest.raises(KeyError, match=r"found .*expected ") as caught:
        held()[name][asked]
    said = str(caught.value)
    assert str(asked).strip("()',") in said or repr(asked) in said


@pytest.mark.parametrize("name", ["values", "maneuver of the reference", "bicycle"])
def test_what_cannot_be_a_key_is_said_too(name):
    with pytest.raises(KeyError, match=r"found \['a'\] \(list\), expected "):
        held()[name][["a"]]
