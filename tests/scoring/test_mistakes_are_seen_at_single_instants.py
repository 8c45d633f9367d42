"""A mistake in a model is found from single states, without a simulation, at the level it
enters."""

import re

import pytest

import checked_mistakes as made  # the module is in docs/_site
from marked_parts import split  # the module is in docs/_site

SOME = ("sign_IBxz", "trail_normal", "centre_B_from_hub", "no_gyroscopic", "linearised_no_c1")
BY_CODE = {m.code: m for m in made.IN_MODEL}
HOW_TO_MEND = (
    "docs/reference/checked-mistakes.md lacks a mistake or has one too many: run "
    "`python docs/_site/checked_mistakes.py`"
)


def table():
    text = made.PAGE.read_text(encoding="utf-8")
    return split(text, "mistakes")[1].strip()


@pytest.mark.proof
@pytest.mark.parametrize("code", SOME)
def test_a_mistake_is_seen_where_it_enters(code):
    expected, found = made.outcome(BY_CODE[code])
    assert found.failed.level.name == expected
    assert f"| `{code}` | {expected} | `{found.failed.columns[0].key}` |" in table()


@pytest.mark.proof
def test_the_right_program_makes_none():
    computed = made.computed(made.RIGHT)
    columns = {f"{k} [{made.UNITS[k]}]": x for k, x in computed.items() if k in made.UNITS}
    numbers = made.np.arange(1, len(made.known_states()) + 1)
    assert made.check({"state": numbers, **columns}).passed


def test_nearly_all_are_seen_at_the_right_level():
    said = re.match(r"Of (\d+) .* model (\d+) are seen, (\d+)", table())
    count, seen, right = map(int, said.groups())
    assert re.findall(r"^\| `([\w.]+)` \|", table(), re.MULTILINE) == list(BY_CODE), HOW_TO_MEND
    assert count == len(BY_CODE), HOW_TO_MEND
    assert min(seen, right) >= 0.95 * count


@pytest.mark.slow
def test_the_table_is_what_the_script_makes():
    assert table() == "\n".join(made.lines())
