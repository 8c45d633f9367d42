"""Numbers that a script is given, as this project's bicycle and maneuver: exactly those numbers."""

from fractions import Fraction

from heyoka_bike import Bicycle, Maneuver
from heyoka_bike.numbers.exact import Exact

ROWS = 1001


def bicycle_of(p):
    """The bicycle of parameters in binary64."""
    return Bicycle("bicycle", {name: Exact(Fraction(value)) for name, value in p.items()})


def maneuver_of(speed, roll_rate, rate):
    """Upright and straight, `rate` rows a second."""
    start = (Exact(Fraction(speed)), Exact(Fraction(roll_rate)))
    return Maneuver("maneuver", *start, Fraction(ROWS - 1, rate), Fraction(1, rate))
