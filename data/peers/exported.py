"""The file of ``heyoka-bike export --model``, for programs of engines that read one."""

from fractions import Fraction

from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.exports.models import render


def model(p, kind, width):
    """Its text, with wheels of a width [m]; numbers are the decimals that they show."""
    exact = {symbol: Exact(Fraction(repr(float(x)))) for symbol, x in p.items()}
    bicycle = benchmark()[0].replace(**exact)
    return render(kind, bicycle, (), Fraction(repr(float(width))), has_visuals=False).decode()
