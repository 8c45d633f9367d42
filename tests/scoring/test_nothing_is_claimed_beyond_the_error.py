"""A report states no more about definitions and energies than the file shows."""

import numpy as np
import pytest

from generators.made_results import exact_columns
from generators.mistaken_programs import correct
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.commands.options import BUDGET
from heyoka_bike.scoring.diagnosis.budget import DEFAULT_BUDGET
from heyoka_bike.scoring.diagnosis.programs.program import changed, initial_state
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.scoring.evidence.as_read import NotFinite
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.verdict import DoesNotCount, claim


def test_a_wrong_motion_shows_no_definition(reference):
    base = correct(reference)
    p = {k: float(v) for k, v in base.motion.bicycle.values.items()}
    swapped = {"IBxx": p["IBzz"] - p["IBxx"], "IBzz": p["IBxx"] - p["IBzz"]}
    motion = changed(base, swapped).motion
    asked = [
        MotionRequest(motion.bicycle, initial_state(motion.bicycle, s), reference[n].time)
        for n, s in motion.starts.items()
    ]
    parts = [
        Rows(n, reference[n].time, reference[n].time_lo, {k: x[k] for k in BENCHMARK_COLUMNS})
        for n, x in zip(motion.starts, Simulator().run_all(asked), strict=True)
    ]
    report = score(Results("x", "text", tuple(parts)), reference)
    assert {
        c.definition for m in report.maneuvers for c in m.columns if c.key == "forward_speed"
    } == {"hub_heading"}


def test_few_digits_show_no_other_energy(reference):
    m = reference[2]
    values = {k: np.array([float(f"{x:.4e}") for x in v]) for k, v in exact_columns(m).items()}
    rows = Rows(2, m.time, m.time_lo, values, quantum=dict.fromkeys(values, Quantum(10, 5)))
    report = score(Results("x", "text", (rows,)), reference)
    assert claim(report.maneuvers[0], 1e-3).reason == DoesNotCount.FEW_DIGITS


@pytest.mark.parametrize(("count", "words"), [(1, "1 value is not"), (2, "2 values are not")])
def test_a_count_agrees_with_its_verb(count, words):
    said = NotFinite(count=count, line=3, column=2, counted_by="line").message()
    assert said.startswith(words)


def test_the_help_has_the_budget():
    assert f"(default: {DEFAULT_BUDGET:g})" in BUDGET["--budget S"]
