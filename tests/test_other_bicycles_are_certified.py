"""The sets of docs/bicycles.md come out again: steps, certified bound, published numbers."""

import pytest
from bicycle_table import committed, set_of


@pytest.mark.slow
@pytest.mark.parametrize("name", committed("sets"))
def test_the_set_of_the_page_is_made_again(name, tmp_path):
    assert committed("sets")[name] == set_of(name, tmp_path / "set")
