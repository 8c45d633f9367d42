"""The resolution of each column is found from the text or from the type of the array."""

import numpy as np
import pytest

from heyoka_bike.scoring.evidence.contradictions import FewDigits
from heyoka_bike.scoring.reading.results import Quantum
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.reading.text import rows as text_rows
from heyoka_bike.scoring.score import score

RNG = np.random.default_rng(1)
COUNT = 300
# The sizes are those of angles, speeds and energies. Some values are small or zero.
VALUES = RNG.standard_normal((COUNT, 8)) * 10.0 ** np.array([-1, 0, 0, 2, 3, 3, -2, 0])
VALUES[:5, 6] = 0
VALUES[5:9, 6] *= 1e-7
KEY = ["roll_angle", "roll_rate", "forward_speed", "potential_energy", "kinetic_energy",
       "mechanical_energy", "steer_angle", "steer_rate"]  # fmt: skip


def written(tmp_path, form, values=VALUES, time="{:.2f}"):
    path = tmp_path / "results.txt"
    lines = (
        " ".join([time.format(i / 100), *(form.format(x) for x in row)])
        for i, row in enumerate(values.tolist())
    )
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(params=["quick", "careful"], autouse=True)
def reader(request, monkeypatch):
    if request.param == "careful":
        monkeypatch.setattr(text_rows, "parse_block", lambda *_: None)


@pytest.mark.parametrize(
    ("form", "quantum", "significant"),
    [
        ("{:.17g}", Quantum(2, digits=53), 17),
        ("{!r}", Quantum(2, digits=53), 17),
        ("{:.16e}", Quantum(2, digits=53), 17),
        # These formats print more digits than binary64 numbers have.
        ("{:.18e}", Quantum(2, digits=53), 17),
        ("{:.24e}", Quantum(2, digits=53), 17),
        ("{:.16g}", Quantum(10, digits=16), 16),
        ("{:.15g}", Quantum(10, digits=15), 15),
        ("{:.9e}", Quantum(10, digits=10), 10),
        ("{:.6g}", Quantum(10, digits=6), 6),
        ("{:.4E}", Quantum(10, digits=5), 5),
        ("{:+.8e}", Quantum(10, digits=9), 9),
    ],
)
def test_significant_digits(form, quantum, significant, tmp_path):
    results = read_results(written(tmp_path, form))
    (rows,) = results.maneuvers
    for key in KEY:
        assert rows.quantum[key] == quantum
    assert not rows.lo
    assert results.significant_digits == significant
    assert rows.quantum["time"] == Quantum(10, places=2)


@pytest.mark.parametrize(("places", "significant"), [(3, 2), (6, 5), (8, 7), (12, 11)])
def test_digits_after_the_point(places, significant, tmp_path):
    results = read_results(written(tmp_path, f"{{:.{places}f}}"))
    (rows,) = results.maneuvers
    for key in KEY:
        assert rows.quantum[key] == Quantum(10, places=places)
    # The steer angles are below 0.1, so with these formats they have fewer significant digits than
    # the other columns.
    assert np.abs(VALUES[:, 6]).max() < 0.1
    assert results.significant_digits == significant


def test_more_places_than_binary64_has(tmp_path):
    """With 16 decimal places only the energies, which exceed 100, have all digits of binary64."""
    (rows,) = read_results(written(tmp_path, "{:.16f}")).maneuvers
    assert rows.quantum["kinetic_energy"] == Quantum(2, digits=53)
    assert rows.quantum["steer_angle"] == Quantum(10, places=16)


def test_digits_beyond_binary64(tmp_path):
    from fractions import Fraction

    path = tmp_path / "x"
    sevenths = [Fraction(int(x * 10**6), 7 * 10**6) for x in VALUES[:, 4]]
    digits = [f"{float(x):.17g}" for x in VALUES[:, 1]]

    def decimal(x):
        scaled = round(abs(x) * 10**30)
        return f"{'-' if x < 0 else ''}{scaled // 10**30}.{scaled % 10**30:030d}"

    path.write_text("time roll speed\n" + "".join(
        f"{i} {digits[i]} {decimal(x)}\n" for i, x in enumerate(sevenths)))  # fmt: skip
    results = read_results(path)
    (rows,) = results.maneuvers
    assert list(rows.lo) == ["forward_speed"]
    exact = [Fraction(decimal(x)) for x in sevenths]
    assert rows.values["forward_speed"].tolist() == [float(x) for x in exact]
    assert rows.lo["forward_speed"].tolist() == [float(x - Fraction(float(x))) for x in exact]
    assert rows.quantum["forward_speed"].base == 10
    assert rows.quantum["forward_speed"].digits > 30
    assert rows.quantum["roll_angle"] == Quantum(2, digits=53)
    assert results.significant_digits == 17


def test_constant_columns_are_written_like_the_others(tmp_path):
    values = VALUES.copy()
    values[:, 2] = 4
    values[:, 6] = 0
    results = read_results(written(tmp_path, "{:.12g}", values))
    (rows,) = results.maneuvers
    assert rows.quantum["forward_speed"] == rows.quantum["steer_angle"] == Quantum(10, digits=12)
    assert results.significant_digits == 12
    (rows,) = read_results(written(tmp_path, "{:.5f}", values)).maneuvers
    assert rows.quantum["forward_speed"] == rows.quantum["steer_angle"] == Quantum(10, places=5)


def test_nothing_but_constants(tmp_path):
    results = read_results(written(tmp_path, "{:g}", np.zeros((5, 8))))
    assert results.significant_digits is None


def test_values_that_are_not_finite_do_not_count(tmp_path):
    values = VALUES.copy()
    values[3] = np.nan
    values[7, 2] = np.inf
    (rows,) = read_results(written(tmp_path, "{:.4f}", values)).maneuvers
    assert {rows.quantum[key] for key in KEY} == {Quantum(10, places=4)}


@pytest.mark.parametrize(
    ("form", "quantum"),
    [("{:.4f}", Quantum(10, places=4)), ("{:g}", Quantum(10, places=2)),
     ("{:.17g}", Quantum(2, digits=53)), ("{:.7e}", Quantum(10, digits=8))],
)  # fmt: skip
def test_times(form, quantum, tmp_path):
    (rows,) = read_results(written(tmp_path, "{:.5g}", time=form)).maneuvers
    assert rows.quantum["time"] == quantum


def test_single_precision_in_text(tmp_path):
    single = VALUES.astype(np.float32).astype(float)
    results = read_results(written(tmp_path, "{:.17g}", single))
    assert {results.maneuvers[0].quantum[key] for key in KEY} == {Quantum(2, digits=24)}
    assert results.significant_digits == 7


@pytest.mark.parametrize(
    ("dtype", "bits", "significant"),
    [("f8", 53, 16), ("f4", 24, 7), ("f2", 11, 3), ("g", np.finfo("g").nmant + 1, None)],
)
def test_arrays(dtype, bits, significant):
    table = np.column_stack([np.arange(COUNT), VALUES]).astype(dtype)
    results = read_results(table)
    assert {results.maneuvers[0].quantum[key] for key in KEY} == {Quantum(2, digits=bits)}
    if significant is not None:
        assert results.significant_digits == significant


def test_single_precision_in_double_precision_arrays():
    table = np.column_stack([np.arange(COUNT), VALUES.astype("f4")]).astype("f8")
    table[:, 3] = np.round(table[:, 3])
    results = read_results(table)
    quantum = results.maneuvers[0].quantum
    assert quantum["roll_angle"] == Quantum(2, digits=24)
    # Integers do not show how many digits were written, so the column counts as exact.
    assert quantum["forward_speed"] == Quantum(2, digits=53)
    assert results.significant_digits == 7


def test_all_rows_count_in_a_small_file(tmp_path):
    """Only one of the last rows has more than two decimal places."""
    values = np.round(VALUES[:40], 2)
    values[39] = VALUES[39]
    (rows,) = read_results(written(tmp_path, "{!r}", values)).maneuvers
    assert {rows.quantum[key].digits for key in KEY} <= {16, 53}


def test_digits_limit_a_column_only_if_they_do_in_every_maneuver(reference, tmp_path):
    """A column that is wrong in one maneuver is not limited by its digits."""
    columns = {"time": reference[1].time}
    for n in reference:
        columns |= {f"m{n}_{key}": reference[n][key].copy() for key in ("roll_angle", "roll_rate")}
    columns["m2_roll_angle"] *= 1.001
    path = tmp_path / "r.csv"
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt="%.9e", delimiter=",", header=",".join(columns), comments="")
    (found,) = [x for x in score(path, reference).seen if isinstance(x, FewDigits)]
    assert found.keys == ("roll_rate",)


def test_a_constant_near_a_single_precision_number_shows_no_precision(tmp_path, reference):
    """One number in ten with nine digits is near one, so a single number shows nothing."""
    near = float(f"{float(np.float32(1581.28)):.9g}")
    path = tmp_path / "constant.csv"
    time = np.arange(101) / 10
    rows = "\n".join(f"{t:g},{near:.9g}" for t in time)
    path.write_text(f"time,m1_mechanical_energy\n{rows}\n")
    (m,) = score(path, reference).maneuvers
    assert m.part.quantum["mechanical_energy"].base == 10
