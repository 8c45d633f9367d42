"""If an error does not fall with the tolerance or step, it is rounding, noise or a wrong model."""

from dataclasses import replace

import numpy as np
import pytest

from generators.made_results import codes, made, smooth_error
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.series import score_files, score_series
from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"
TOLERANCES = (1e-9, 1e-10)


def run(reference, path, size=0.0, noise=0.0, seed=0):
    """Write a file with a smooth error and noise, both relative to the scale of each column."""
    random = np.random.default_rng(seed)

    def change(key, values, number):
        scale = np.max(np.abs(values))
        wrong = smooth_error(reference, number, size * scale) if size else 0.0
        return values + wrong + noise * scale * random.standard_normal(len(values))

    return replace(made(reference, change), path=path)


def series(reference, coarse, fine, **more):
    runs = [run(reference, "coarse.txt", **coarse), run(reference, "fine.txt", seed=1, **fine)]
    return score_series(runs, reference, **(more or {"tolerances": TOLERANCES}))


def found(scored, code):
    return [f for f in scored.findings if f.code == code]


@pytest.mark.parametrize(("fall", "how"), [(10.0, "in proportion to the tolerance"),
                                           (10**0.5, "to the power 0.5")])  # fmt: skip
def test_the_exponent_of_the_tolerance_is_said(reference, fall, how):
    scored = series(reference, {"size": 1e-6}, {"size": 1e-6 / fall})
    assert codes(scored) == ["tolerance"]
    assert how in scored.findings[0].message
    assert scored.findings[0].evidence["exponent"] == pytest.approx(np.log10(fall), abs=1e-3)


def test_a_real_solver_follows_its_tolerance(reference):
    runs = [read_results(PEERS / f"scipy-rtol1e-{n}.txt") for n in (10, 4, 7)]
    scored = score_series(runs, reference, tolerances=(1e-10, 1e-4, 1e-7))
    assert [r.tolerance for r in scored.runs] == [1e-4, 1e-7, 1e-10]
    assert codes(scored) == ["tolerance"]
    assert scored.findings[0].evidence["exponent"] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("sizes", [{"tolerances": TOLERANCES}, {"steps": (0.01, 0.005)}])
@pytest.mark.parametrize("error", [{"size": 1e-13}, {"noise": 3e-14}])
def test_near_the_last_digits_it_is_the_arithmetic(reference, error, sizes):
    """Correct programs reach this limit too, whatever the shape of the error."""
    scored = series(reference, error, error, **sizes)
    (said,) = found(scored, "limited_by_rounding")
    assert "not the model" in said.message
    assert not found(scored, "error_stays")


def test_another_curve_in_each_run_is_noise(reference):
    scored = series(reference, {"noise": 1e-8}, {"noise": 1e-8})
    assert found(scored, "noise_does_not_fall")
    assert not found(scored, "error_stays")


@pytest.mark.parametrize("sizes", [{"tolerances": TOLERANCES}, {"steps": (0.01, 0.005)}])
def test_the_same_curve_is_that_of_the_model(reference, sizes):
    scored = series(reference, {"size": 1e-4, "noise": 1e-7}, {"size": 1e-4}, **sizes)
    (said,) = found(scored, "error_stays")
    assert "comes from the model" in said.message
    assert len(said.evidence["columns"]) == 24
    assert not found(scored, "limited_by_rounding")


def test_tolerances_say_that_files_are_of_one_program(reference):
    runs = [run(reference, "a.txt", 1e-6), run(reference, "b.txt", 1e-7)]
    assert score_files(runs, reference, tolerances=TOLERANCES).is_one_program


def test_equal_tolerances_do_not_tell_runs_apart(reference):
    scored = series(reference, {"size": 1e-6}, {"size": 1e-7}, tolerances=(1e-9, 1e-9))
    assert "steps_unknown" in codes(scored)


def test_as_many_as_files(reference):
    with pytest.raises(InputError, match="tolerance: found 1 value for 2 files"):
        series(reference, {"size": 1e-6}, {"size": 1e-7}, tolerances=(1e-9,))


def test_the_command_takes_them(capsys):
    files = [str(PEERS / f"scipy-rtol1e-{n}.txt") for n in (7, 10)]
    assert main(["score", *files, "--tolerance", "1e-7,1e-10"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "tolerances 1e-07 to 1e-10" in said
    assert "in proportion to the tolerance" in said
    assert main(["score", *files, "--tolerance", "1e-7,0"]) == 1
    assert "--tolerance: found '0', expected more than zero" in capsys.readouterr().err


def test_single_precision_is_told_by_score(reference):
    def change(key, values, number):
        return values.astype(np.float32).astype(np.float64)

    said = score(made(reference, change), reference).findings[-1]
    assert said.code == "single_precision"
    assert said.message.startswith("All values are")


def test_noise_of_single_precision_is_told_by_its_size(reference):
    """The sum of two single-precision numbers is not itself a single-precision number."""

    def change(key, values, number):
        half = (values / 3).astype(np.float32).astype(np.float64)
        return half + (values - half).astype(np.float32).astype(np.float64)

    assert "single_precision" in codes(score(made(reference, change), reference))


@pytest.mark.parametrize("name", ["exudyn-h0.001", "exudyn-loose-newton", "scipy-rtol1e-4",
                                  "scipy-rtol1e-7", "scipy-rtol1e-10"])  # fmt: skip
def test_programs_in_double_precision_are_not_accused_of_it(reference, name):
    assert "single_precision" not in codes(score(read_results(PEERS / f"{name}.txt"), reference))
