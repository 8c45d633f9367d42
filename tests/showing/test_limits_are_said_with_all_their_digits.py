"""A limit of eq. (1) is said as it was given: a rounded one would contradict its own verdict."""

import pytest

from heyoka_bike.showing.wording.number_text import limit_words


@pytest.mark.parametrize(("limit", "said"), [
    (1e-3, "1e-3 %"), (5e-3, "5e-3 %"), (2.5e-3, "2.5e-3 %"), (1e-4, "1e-4 %"), (1e-10, "1e-10 %"),
    (0.1, "1e-1 %"), (1.0, "1 %"), (12.5, "12.5 %"), (1 / 3, "3.33333333333e-1 %"),
])  # fmt: skip
def test_no_digit_is_lost(limit, said):
    assert limit_words(limit) == said
