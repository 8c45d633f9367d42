"""The prior odds against a cause follow from the number of entries in the tables."""

from math import log

import pytest

from generators.simulated_tables import right_program
from heyoka_bike.bicycle.parameters import PARAMETERS, START, benchmark
from heyoka_bike.scoring.diagnosis.hypothesis import KNOWN, OF_START, UNKNOWN, log_odds_before
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.forces import OF_THE_STATE
from heyoka_bike.scoring.diagnosis.programs.program import other_values
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


def test_a_term_that_is_missing_as_a_whole_is_as_likely_as_a_known_mistake(bicycle, reference):
    def log_odds(name, value):
        program = right_program(bicycle, reference)
        return log_odds_before([other_values({name: value}, {name: 1e-9}, program)])

    assert log_odds("weight_R", 1.0) == log_odds_before(MISTAKES[:1])
    costs_a_value = -THRESHOLDS.value_cost - UNKNOWN
    assert log_odds("weight_R", 0.98) == costs_a_value
    # A damping of 1 N m s is a value like any other.
    assert log_odds("steer_damping", 1.0) == costs_a_value
