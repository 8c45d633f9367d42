"""Which parameters of a test belong to which tier."""

import pytest

ONE_MANEUVER = [
    pytest.param(2, marks=pytest.mark.proof),
    *(pytest.param(number, marks=pytest.mark.slow) for number in (1, 3)),
]
"""Numbers of the maneuvers: one with the proofs; `verify` and `certify` speak of all three there.

The others, in which nothing but the number differs, by ``-m slow``. The test itself has no mark: it
would be of two tiers.
"""
