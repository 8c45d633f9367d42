"""Numbers that are parsed together equal those of Python's `float` and of exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from heyoka_bike.scoring.reading.digits import places_of, significant
from heyoka_bike.scoring.reading.text.blocks import parse_block

sign = st.sampled_from(["", "-", "+"])
digits = st.text("0123456789", min_size=1, max_size=22)
mantissa = st.one_of(
    digits,
    st.tuples(digits, digits).map(".".join),
    digits.map("{}.".format),
    digits.map(".{}".format),
)
exponent = st.one_of(
    st.just(""),
    st.integers(-30, 30).map("e{}".format),
    st.integers(-400, 400).map("e{:+04d}".format),
)
number = st.tuples(sign, mantissa, exponent).map("".join)


def exact_parts(token):
    hi = float(token)
    if hi == 0 or not np.isfinite(hi):
        return hi, 0.0
    return hi, float(Fraction(token) - Fraction(hi))


rows = given(st.lists(number, min_size=1, max_size=6), st.sampled_from([b"", b",", b";", b"\t"]))


@settings(max_examples=100, deadline=None)
@rows
@example(["9007199254740993", "9007199254740992.5", "0.1e23", "1e23", "8.5e22"], b"")
@example(["9223372036854775807", "9223372036854775808", "-9223372036854775808", "9e18"], b"")
@example(["-9223372036854775809", "-99999999999999999999", "99999999999999999999"], b"")
@example(["179769313486231580793e289", "2.4703282292062328e-324", "4.9e-324", "-0"], b"")
def test_any_number(tokens, separator):
    check(tokens, separator)


@pytest.mark.proof
@settings(max_examples=1000, deadline=None)
@rows
def test_any_of_many_numbers(tokens, separator):
    check(tokens, separator)


def check(tokens, separator):
    line = (separator or b" ").join(token.encode() for token in tokens) + b"\n"
    block = parse_block(line * 2, len(tokens), separator, range(len(tokens)), 10)
    assert block is not None
    for j, token in enumerate(tokens):
        hi, lo = exact_parts(token)
        assert block.values[j].tolist() == [hi, hi]
        assert block.lo[j].tolist() == [lo, lo]
        plain = token.partition("e")[0].lstrip("+-0.").replace(".", "")
        assert block.written[j][0] == token
        assert significant(token) == plain
        has_places = "e" not in token
        assert places_of(token) == (len(token.partition(".")[2]) if has_places else -1)
    assert block.lines.tolist() == [0, 1]


@pytest.mark.parametrize("form", ["{:.17g}", "{:.16e}", "{:.18e}", "{!r}", "{:.20f}", "{:.3f}"])
def test_many_numbers(form):
    rng = np.random.default_rng(1)
    values = rng.standard_normal((3000, 5)) * 10.0 ** rng.integers(-20, 20, (3000, 5))
    text = "".join(" ".join(form.format(x) for x in row) + "\n" for row in values.tolist())
    block = parse_block(text.encode(), 5, b"", [0, 3], 100)
    tokens = [line.split() for line in text.splitlines()]
    assert np.transpose(block.values).tolist() == [[float(x) for x in row] for row in tokens]
    for j in (0, 3):
        assert block.lo[j].tolist() == [exact_parts(row[j])[1] for row in tokens]
    assert sorted(block.lo) == [0, 3]


@pytest.mark.parametrize("places", range(5))
def test_numbers_halfway_between_two(places):
    """Numbers halfway between two binary64 numbers are the hardest to round."""
    rng = np.random.default_rng(places)
    least, most = 2 ** (53 - places), min(2 ** (54 - places), 9 * 10 ** (18 - places))
    tokens = []
    for n in rng.integers(least, most, 2000).tolist():
        eighths = int(rng.integers(2**places)) | 1
        below = f"{eighths * 10**places // 2**places:0{places}d}"
        tokens.append(f"{n}.{below}" if places else str(n | 1))
    block = parse_block(("\n".join(tokens) + "\n").encode(), 1, b"", [0], 10)
    assert block.values[0].tolist() == [float(token) for token in tokens]
    assert block.lo[0].tolist() == [exact_parts(token)[1] for token in tokens]


@pytest.mark.parametrize(
    "text",
    ["1 2 3\n", "1\n", "1 2\n3\n", "1 2\n3 4", "1 x\n", "1 2.3.4\n", "1 2e3e4\n", "1 e5\n",
     "1 5e\n", "1 2e3.5\n", "1 .\n", "1 -.\n", "1 -\n", "- 1\n", "- 1 2\n", "1-2\n", "1-2 -\n",
     "1 2e +5\n", "1 --2\n", "1 +-2\n", "1 0x2\n", "1 1_0\n", "1 nan\n", "1 inf\n", "1 2#\n",
     "1 2\0\n", "1 \xb2\n", "1,2\n", "1 2,\n", "", "\n", "\n\n", "1 2d5\n", "1 2E5\n",
     "1 5e 2\n", "- 1 2-3\n", "e1 2-3\n", ". 2-3\n", "1e 2-3\n", "5.-1 2\n", "1 2.e-\n"],
)  # fmt: skip
def test_anything_else_is_left_to_the_careful_reader(text):
    assert parse_block(text.encode("latin-1"), 2, b"", [0], 10) is None


@pytest.mark.parametrize(
    "text",
    [
        "1 2\n",
        "1,,2\n",
        ",1,2\n",
        "1,2,,\n",
        "1,2\n3 4\n",
        "1,2 3\n",
        "1;2\n",
    ],
)
def test_separators_are_counted(text):
    assert parse_block(text.encode(), 2, b",", [0], 10) is None


def test_separators_at_the_end_and_blanks():
    block = parse_block(b"\n 1,\t2,\n\n3,4\n5, 6\n  \n", 2, b",", [], 10)
    assert np.array(block.values).tolist() == [[1, 3, 5], [2, 4, 6]]
    assert block.lines.tolist() == [1, 3, 4]
