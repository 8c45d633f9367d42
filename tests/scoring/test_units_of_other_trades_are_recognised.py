"""Rates in revolutions per minute and speeds in miles per hour are recognised without a heading."""

import numpy as np
import pytest

from generators.made_results import made
from heyoka_bike import score
from heyoka_bike.scoring.reading.results import Quantum

FACTORS = {
    "revolution min-1": (("roll_rate", "steer_rate"), 60 / (2 * np.pi)),
    "mile h-1": (("forward_speed",), 3600 / 1609.344),
}


@pytest.mark.parametrize("unit", FACTORS)
def test_the_unit_is_recognised(reference, unit):
    keys, factor = FACTORS[unit]
    report = score(made(reference, lambda k, v, n: v * factor if k in keys else v), reference)
    assert report.is_right
    for m in report.maneuvers:
        for c in m.columns:
            assert (c.as_understood.unit == unit) == (c.key in keys)


def test_all_of_them_together(reference):
    factors = {k: factor for keys, factor in FACTORS.values() for k in keys}
    report = score(made(reference, lambda k, v, n: v * factors.get(k, 1.0)), reference)
    assert report.is_right


@pytest.mark.parametrize("off", [0.97, 1.03])
def test_a_speed_that_is_off_is_no_unit(reference, off):
    report = score(
        made(reference, lambda k, v, n: v * off * 3600 / 1609.344 if k == "forward_speed" else v),
        reference,
    )
    assert not report.is_right


def test_the_grid_of_a_text_is_not_finer_than_binary64(reference):
    """In a table with 15 decimal places, adjacent binary64 numbers near 794 J are still 1e-13 J
    apart."""
    quantum = {k: Quantum(10, places=15) for k in ("potential_energy", "kinetic_energy")}
    quantum |= {"mechanical_energy": Quantum(10, places=15)}
    names = tuple(quantum)
    report = score(made(reference, names=names, quantum=quantum), reference)
    for m in report.maneuvers:
        assert m.consistency.energy_sum_floor >= 1e-13
        assert m.consistency.energy_sum_floor >= m.consistency.energy_sum / 2
        for c in m.columns:
            assert c.floor >= np.spacing(m.part.reference.scale(c.key)) / 4
