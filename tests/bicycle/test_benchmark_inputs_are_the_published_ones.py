"""The shipped bicycle and maneuvers are those of the publications.

The values are typed from Table 1 of Meijaard, Papadopoulos, Ruina and Schwab: Linearized dynamics
equations for the balance and steer of a bicycle: a benchmark and review, Proc. R. Soc. A 463 (2007)
1955-1982, doi:10.1098/rspa.2007.1857. The maneuvers are from the text of the IFToMM benchmark
"Uncontrolled bicycle". Its axes are x forward, y to the right, z down. Inertias are matrix
elements; the xz element of the rear frame is +2.4.
"""

from fractions import Fraction

import pytest

from heyoka_bike.bicycle.parameters import PARAMETERS, STATE_INPUTS
from heyoka_bike.numbers.exact import Exact

TABLE_1 = {
    "w": Fraction(102, 100),
    "c": Fraction(8, 100),
    "g": Fraction(981, 100),
    # Rear wheel R
    "rR": Fraction(3, 10),
    "mR": Fraction(2),
    "IRxx": Fraction(603, 10_000),
    "IRyy": Fraction(12, 100),
    # Rear body and frame B
    "xB": Fraction(3, 10),
    "zB": Fraction(-9, 10),
    "mB": Fraction(85),
    "IBxx": Fraction(92, 10),
    "IBxz": Fraction(24, 10),
    "IByy": Fraction(11),
    "IBzz": Fraction(28, 10),
    # Front handlebar and fork assembly H
    "xH": Fraction(9, 10),
    "zH": Fraction(-7, 10),
    "mH": Fraction(4),
    "IHxx": Fraction(5892, 100_000),
    "IHxz": Fraction(-756, 100_000),
    "IHyy": Fraction(6, 100),
    "IHzz": Fraction(708, 100_000),
    # Front wheel F
    "rF": Fraction(35, 100),
    "mF": Fraction(3),
    "IFxx": Fraction(1405, 10_000),
    "IFyy": Fraction(28, 100),
}
"""Table 1, except the steer axis tilt, pi/10."""

UNITS = {"w": "m", "c": "m", "lam": "rad", "g": "N/kg", "r": "m", "x": "m", "z": "m", "m": "kg"}
"""Units by symbol, or by its first letter; inertias are in kg m^2."""


def test_every_parameter_is_checked_here():
    assert set(TABLE_1) | {"lam"} == set(PARAMETERS)
    assert len(PARAMETERS) == 26


@pytest.mark.parametrize("symbol", TABLE_1)
def test_parameter(bicycle, symbol):
    assert bicycle[symbol] == Exact(TABLE_1[symbol])


def test_steer_axis_tilt_is_a_tenth_of_pi(bicycle):
    assert bicycle["lam"] == Exact(Fraction(0), Fraction(1, 10))


def test_parameters_are_fractions(bicycle):
    for x in bicycle.values.values():
        assert type(x.rational) is Fraction
        assert type(x.pi_multiple) is Fraction


def test_the_bicycle_is_not_unusual(bicycle):
    assert bicycle.warnings == ()


@pytest.mark.parametrize("symbol", PARAMETERS)
def test_unit(symbol):
    expected = UNITS.get(symbol) or UNITS.get(symbol[0], "kg m^2")
    assert PARAMETERS[symbol].unit == expected


def test_maneuvers(maneuvers):
    """Each maneuver starts upright and straight, and lasts 10 s in rows of 0.01 s."""
    assert [m.name for m in maneuvers] == ["maneuver 1", "maneuver 2", "maneuver 3"]
    speeds = [m.speed.fraction() for m in maneuvers]
    roll_rates = [m.roll_rate.fraction() for m in maneuvers]
    assert speeds == [Fraction(4), Fraction(46, 10), Fraction(8)]
    assert roll_rates == [Fraction(5, 100), Fraction(5, 10), Fraction(5, 100)]
    for m in maneuvers:
        assert m.roll.is_zero
        assert m.steer.is_zero
        assert m.steer_rate.is_zero
        assert not m.is_straight
        assert type(m.duration) is Fraction
        assert type(m.spacing) is Fraction
        assert m.duration == 10
        assert m.spacing == Fraction(1, 100)
        assert m.rows == 1001
        assert m.time(7) == Fraction(7, 100)
        assert m.time(m.rows - 1) == m.duration


def test_units_of_the_state():
    units = {key: parameter.unit for key, parameter in STATE_INPUTS.items()}
    assert units == {
        "speed": "m/s",
        "roll_rate": "rad/s",
        "roll": "rad",
        "steer": "rad",
        "steer_rate": "rad/s",
        "duration": "s",
        "spacing": "s",
    }
