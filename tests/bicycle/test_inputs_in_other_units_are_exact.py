"""A bicycle measured in mm, deg and kg mm^2 is the same, to the last digit."""

from fractions import Fraction

import pytest

from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle, read_maneuvers
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.exact import Exact, shortest_decimal
from heyoka_bike.numbers.unit import factor

WORKSHOP = {
    "m": ("mm", 1000),
    "kg": ("g", 1000),
    "kg m^2": ("kg mm^2", 10**6),
    "N/kg": ("mm/s^2", 1000),
}


def written(bicycle, **changes):
    entries = []
    for symbol, parameter in PARAMETERS.items():
        unit, factor_ = WORKSHOP.get(parameter.unit, ("deg", 1))
        value = (
            "18" if symbol == "lam" else shortest_decimal(bicycle[symbol].rational * factor_, 20)
        )
        entry = f'value = "{value}", unit = "{unit}"'
        entries.append(f"{symbol} = {{ {changes.get(symbol, entry)} }}")
    return "\n".join(['name = "workshop"', "[parameters]", *entries]) + "\n"


def test_a_bicycle_in_workshop_units_is_the_same(tmp_path, bicycle):
    path = tmp_path / "mine.toml"
    path.write_text(written(bicycle), encoding="utf-8")
    assert read_bicycle(path).values == bicycle.values
    # The file contains 18 degrees, which are pi/10.
    assert read_bicycle(path)["lam"] == Exact(Fraction(0), Fraction(1, 10))


def test_an_uncertainty_is_in_the_unit_of_its_value(tmp_path, bicycle):
    path = tmp_path / "mine.toml"
    path.write_text(written(bicycle, w='value = "1020", unit = "mm", uncertainty = "2"'), "utf-8")
    assert read_bicycle(path).uncertainties["w"].rational == Fraction(2, 1000)


def test_a_maneuver_may_be_in_km_h_and_degrees(tmp_path):
    path = tmp_path / "mine.toml"
    text = (
        '[[maneuver]]\nspeed = { value = "18", unit = "km/h" }\nduration = "1"\nspacing = "0.1"\n'
        'roll_rate = { value = "90", unit = "deg/s" }\nroll = { value = "10", unit = "deg" }\n'
    )
    path.write_text(text, encoding="utf-8")
    (maneuver,) = read_maneuvers(path)
    assert maneuver.speed == Exact(Fraction(5))
    assert maneuver.roll_rate == Exact(Fraction(0), Fraction(1, 2))
    assert maneuver.roll == Exact(Fraction(0), Fraction(1, 18))


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('value = "18", unit = "mm"', "lam: found unit 'mm', expected 'rad'"),
        ('value = "pi/10", unit = "deg"', "lam.value: found 0.314159265358979 deg, expected"),
        ('value = "91", unit = "deg"', "found 1.58824961931484 rad, expected less than pi/2"),
    ],
)  # fmt: skip
def test_what_the_unit_does_not_fit_is_refused(tmp_path, bicycle, entry, said):
    path = tmp_path / "mine.toml"
    path.write_text(written(bicycle, lam=entry), encoding="utf-8")
    with pytest.raises(InputError) as e:
        read_bicycle(path)
    assert said in str(e.value)


def test_a_length_out_of_range_in_its_unit_is_refused(tmp_path, bicycle):
    path = tmp_path / "mine.toml"
    path.write_text(written(bicycle, w='value = "1e-299", unit = "mm"'), encoding="utf-8")
    with pytest.raises(InputError, match=r"found 1e-299 mm, .* in SI units"):
        read_bicycle(path)


@pytest.mark.parametrize(
    ("unit", "si", "size"),
    [
        ("kg mm^2", "kg m2", "1/1000000"), ("kg\u00b7mm\u00b2", "kg m^2", "1/1000000"),
        ("deg/s", "rad s-1", "pi/180"), ("\u00b0", "rad", "pi/180"), ("1/s", "rad s-1", "1"),
        ("km/h", "m s-1", "5/18"), ("N mm", "J", "1/1000"), ("N/kg", "m/s^2", "1"),
        ("J", "N m", "1"),
        ("t mm^2", "kg m^2", "1/1000"), ("m s^-2", "m/s2", "1"), ("in", "m", "0.0254"),
        ("kg m^2/s", "kg m2 s-1", "1"), ("m", "kg", None), ("", "m", None), ("furlong", "m", None),
        ("m^99", "m", None), ("deg^2", "rad", None), ("m/", "m", None),
    ],
)  # fmt: skip
def test_units_have_exact_sizes(unit, si, size):
    assert factor(unit, si) == (None if size is None else Exact.parse(size))
