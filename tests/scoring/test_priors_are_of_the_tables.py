"""The prior odds against a cause follow from the number of entries in the tables."""

from math import log

import pytest

from heyoka_bike.bicycle.parameters import PARAMETERS, START, benchmark
from heyoka_bike.scoring.diagnosis.hypothesis import KNOWN, OF_START, UNKNOWN, log_odds_before
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.forces import OF_THE_STATE
from heyoka_bike.scoring.diagnosis.residual.residual import UNKNOWNS
from heyoka_bike.scoring.diagnosis.search import OF_MODEL


def test_the_prior_of_a_mistake_of_the_library():
    codes = {m.code for m in (*MISTAKES, *OF_MODEL)}
    assert pytest.approx(log(len(codes))) == KNOWN
    assert log_odds_before(MISTAKES[:1]) == -KNOWN


def test_the_prior_of_a_parameter():
    assert pytest.approx(log(len({*UNKNOWNS, *OF_THE_STATE}))) == UNKNOWN
    assert {*PARAMETERS} < {*UNKNOWNS}


def test_the_prior_of_an_initial_value():
    _, maneuvers = benchmark()
    assert pytest.approx(log(len(START) * len(maneuvers))) == OF_START
