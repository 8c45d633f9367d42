"""Accelerations of the linearised bicycle are those of SymPy's bicycle."""

import json
from pathlib import Path

import mpmath
import pytest

from heyoka_bike.bicycle.stability.linear import linearise

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "linear.json").read_text("utf-8"))
SYMPY = ANCHORS["accelerations"]


def _rows(linear):
    """Coefficients of (lean, steer, lean rate, steer rate) in both accelerations, by power of v."""
    inverse = mpmath.matrix(linear.M) ** -1
    gravity, centrifugal, rates = (
        -(inverse * mpmath.matrix(m)) for m in (linear.K0, linear.K2, linear.C1)
    )
    for i in (0, 1):
        of_angles = [{"1": linear.g * gravity[i, j], "v^2": centrifugal[i, j]} for j in (0, 1)]
        yield of_angles + [{"v": rates[i, j]} for j in (0, 1)]


@pytest.mark.parametrize("i", [0, 1], ids=["lean", "steer"])
def test_accelerations(bicycle, i):
    with mpmath.workdps(40):
        found = list(_rows(linearise(bicycle, 30)))[i]
        expected = SYMPY[("lean_acceleration", "steer_acceleration")[i]]
        for entry, printed in zip(found, expected, strict=True):
            assert {power for power, x in entry.items() if x} == set(printed)
            for power, text in printed.items():
                # The tolerance is one unit of the last of SymPy's 15 printed digits, because SymPy
                # computed with 15 digits only.
                unit = mpmath.mpf(10) ** -len(text.partition(".")[2])
                assert abs(entry[power] - mpmath.mpf(text)) < unit
