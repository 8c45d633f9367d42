"""The numbers of a row are counted at once if the row is plain, else one by one, with equal
results."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heyoka_bike.scoring.reading.text.dialects import DIALECTS

PARTS = ["1", "-2.5", "+.5", "3.", "1e-3", "1D+05", "1.5-100", "1-100", "nan", "1.#IND", "x", "1 2",
         "", "0x1", "1e", "1_0", "'4'", "5,5", "٣"]  # fmt: skip


def one_by_one(dialect, line):
    found = [dialect.number(field) for field in dialect.split(line)]
    return len(found) if found and None not in found else None


@pytest.mark.parametrize("dialect", DIALECTS, ids=repr)
@given(parts=st.lists(st.sampled_from(PARTS), min_size=1, max_size=6), mixed=st.booleans())
def test_counts_are_the_same(dialect, parts, mixed):
    line = (dialect.separator or " ").join(parts) if not mixed else " ".join(parts)
    assert dialect.count(line) == one_by_one(dialect, line)
