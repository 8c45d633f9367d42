"""The datasets of docs/reference/other-bicycles.md are reproduced: steps, bound, numbers."""

import pytest

from bicycle_table import NAMES, committed, set_of


def test_every_bicycle_has_a_set():
    assert list(committed("sets")) == NAMES


@pytest.mark.slow
@pytest.mark.parametrize("name", committed("sets"))
def test_the_set_of_the_page_is_made_again(name, tmp_path):
    assert committed("sets")[name] == set_of(name, tmp_path / "set")
