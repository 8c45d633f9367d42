"""The median without NumPy's masked arrays equals NumPy's to the last bit."""

import numpy as np
import pytest

from heyoka_bike.numbers.double import median


@pytest.mark.parametrize("count", [1, 2, 3, 10, 1001])
def test_the_median_equals_numpys(count):
    x = np.random.default_rng(count).normal(size=(7, count)) * 10.0 ** np.arange(-3, 4)[:, None]
    assert np.array_equal(median(x), np.median(x, axis=-1))
    assert median(x[0].tolist()) == np.median(x[0])
