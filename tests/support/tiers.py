"""Assignment of a test's parameters to tiers."""

import pytest

ONE_MANEUVER = [
    pytest.param(2, marks=pytest.mark.proof),
    *(pytest.param(number, marks=pytest.mark.slow) for number in (1, 3)),
]
"""Numbers of the maneuvers: one runs with the proofs, where `verify` and `certify` cover all three.

The others differ only in the number and run by ``-m slow``. The test itself has no mark, because
it would belong to two tiers."""
