"""Numbers preserve every written digit, from the text to the chosen precision."""

import math
import random
import re
import sys
from decimal import Decimal
from fractions import Fraction

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.system.resources import benchmark_bicycle

DIGITS = st.text("0123456789", min_size=1, max_size=60)
EXPONENT = st.one_of(
    st.just(""),
    st.builds("{}{}".format, st.sampled_from(["e", "E", "e+", "e-"]), st.integers(0, 200)),
)
DECIMAL = st.builds(
    "{}{}{}".format,
    st.one_of(
        DIGITS,
        st.builds("{}.{}".format, DIGITS, DIGITS),
        st.builds("{}.".format, DIGITS),
        st.builds(".{}".format, DIGITS),
    ),
    EXPONENT,
    st.just(""),
)


@given(DECIMAL)
def test_a_decimal_is_the_fraction_it_writes(text):
    assert Exact.parse(text) == Exact(Fraction(text))


@given(
    DECIMAL, st.sampled_from(["-{}", "- {}", "+{}", "({})", "  {}\t", "-(-{})", "--{}", "+-+-{}"])
)
def test_signs_brackets_and_blanks_change_nothing_else(text, form):
    minus = form.count("-") % 2
    assert Exact.parse(form.format(text)) == Exact(Fraction(text) * (-1) ** minus)


LEAF = st.one_of(
    st.integers(0, 10**6).map(str), st.decimals(0, 1000, places=4).map(str), st.just("pi")
)


def _grow(inner):
    operation = st.tuples(inner, st.sampled_from(["+", "-", "*", "/"]), inner)
    return st.one_of(
        operation.map(lambda x: "({}{}{})".format(*x)),
        operation.map(lambda x: "({} {} {})".format(*x)),
        inner.map("(-{})".format),
    )


class _Linear:
    """The value of an expression: rational and pi parts, or None if it is not linear in pi."""

    def __init__(self, rational, pi=0):
        self.parts = (Fraction(rational), Fraction(pi))

    def __add__(self, other):
        return _Linear(*(x + y for x, y in zip(self.parts, other.parts, strict=True)))

    def __neg__(self):
        return _Linear(*(-x for x in self.parts))

    def __sub__(self, other):
        return self + -other

    def __mul__(self, other):
        (a, b), (c, d) = self.parts, other.parts
        if b and d:
            raise ValueError("quadratic in pi")
        return _Linear(a * c, a * d + b * c)

    def __truediv__(self, other):
        if other.parts[1]:
            raise ValueError("divided by pi")
        return self * _Linear(1 / other.parts[0])


def _meaning(text):
    """Evaluate the same text in Python, with each decimal converted to `_Linear`."""
    code = re.sub(r"[0-9.]+(E[-+]?[0-9]+)?", lambda m: f"L('{m[0]}')", text)
    return eval(code, {"__builtins__": {}, "L": _Linear, "pi": _Linear(0, 1)})


@given(st.recursive(LEAF, _grow, max_leaves=12))
def test_an_expression_has_the_value_that_python_gives_it(text):
    try:
        expected = _meaning(text)
    except (ValueError, ZeroDivisionError):
        with pytest.raises(ValueError, match="found '"):
            Exact.parse(text)
    else:
        assert Exact.parse(text) == Exact(*expected.parts)


@pytest.mark.parametrize(
    ("text", "rational", "pi_multiple"),
    [
        ("pi/10", 0, Fraction(1, 10)),
        ("-pi", 0, -1),
        ("2*pi/3", 0, Fraction(2, 3)),
        ("pi*0.1 + 1/3", Fraction(1, 3), Fraction(1, 10)),
        ("18*pi/180", 0, Fraction(1, 10)),
        ("1 - 2 - 3", -4, 0),
        ("12/2/3", 2, 0),
        ("2+3*4", 14, 0),
        ("-2*-3", 6, 0),
        ("1e-30", Fraction(1, 10**30), 0),
        ("0.1", Fraction(1, 10), 0),
        ("007", 7, 0),
        ("pi-pi", 0, 0),
        ("(pi+1)*(2-1)/(4/2)", Fraction(1, 2), Fraction(1, 2)),
        ("0e400", 0, 0),
        ("1e-300", Fraction(1, 10**300), 0),
        ("1e400/1e400", 1, 0),
        ("9.81 + 1e-24", Fraction("9.810000000000000000000001"), 0),
    ],
)
def test_known_values(text, rational, pi_multiple):
    assert Exact.parse(text) == Exact(Fraction(rational), Fraction(pi_multiple))


@pytest.mark.parametrize(
    "text",
    [
        "", " ", ".", "+", "-", "*", "e5", "1e", "1e+", "1..2", "1.2.3", "1,02", "1.02 m", "1_000",
        "0x10", "1j", "inf", "-inf", "nan", "Infinity", "True", "None", "tau", "Pi", "PI", "π",
        "pi(2)", "2pi", "2(3)", "(2)(3)", "1 2", "pi pi", "2**3", "9**9**9", "9//2", "7%2", "1<2",
        "1;2", "1 # one", "lambda: 1", "pi.real", "(1).real", "[1]", "{1}", "'1'", '"1"', "f'1'",
        "abs(1)", "__import__('os')", "(", ")", "()", "(1", "1)", "((1)", "1+", "*1", "/1", "1\n",
        "\n1", "1\x00", "\x00", "١", "１.５", "½", "1\u00a0", "−1", "pi*pi", "1/pi",
        "pi/pi", "1/0", "1/(1-1)", "1/(pi-pi)", "1e401", "0e401", "1e401/1e401", "1e999999999",
        "1e-999999999", "1e" + "9" * 900, "1e301", "1e-301", "1e300*10", "1e400*1e400", "1" * 301,
        "1" * 601, "(" * 51 + "1" + ")" * 51, "(" * 1000, "(" * 10**6, "-" * 10**6, "1" * 10**6,
        "1+" * 10**6 + "1", "\ud800", "a" * 10**7,
    ],
    ids=lambda text: ascii(text[:20]),
)  # fmt: skip
def test_what_is_not_a_number_is_refused_in_one_short_line(text):
    with pytest.raises(ValueError, match=r"found '.*expected ") as caught:
        Exact.parse(text)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 250


def test_brackets_signs_and_terms_as_many_as_fit_are_fine():
    assert Exact.parse("(" * 50 + "1" + ")" * 50) == Exact(1)
    assert Exact.parse("-" * 598 + "1") == Exact(1)
    assert Exact.parse("1" + "+1" * 299) == Exact(300)
    assert Exact.parse("0." + "3" * 598).rational == Fraction("0." + "3" * 598)


def test_python_may_be_told_to_convert_few_digits():
    """640 is the minimum of PYTHONINTMAXSTRDIGITS."""
    before = sys.get_int_max_str_digits()
    try:
        sys.set_int_max_str_digits(640)
        x = Exact.parse("0." + "3" * 598)
        assert str(x) == "3" * 598 + "/1" + "0" * 598
        with pytest.raises(ValueError, match="found '111"):
            Exact.parse("1" * 900)
        with pytest.raises(ValueError, match="at most 640 digits"):
            Exact.parse("(1 + 1e-350)*(1 + 1e-350)")
    finally:
        sys.set_int_max_str_digits(before)


@given(st.fractions(), st.fractions())
def test_sign_is_that_of_the_number(rational, pi_multiple):
    x = Exact(rational, pi_multiple)
    with mpmath.workdps(60):
        value = mpmath.mpf(rational.numerator) / rational.denominator
        value += mpmath.pi * pi_multiple.numerator / pi_multiple.denominator
        assert x.sign == mpmath.sign(value)


@pytest.mark.parametrize("digits", [5, 15, 16, 17, 40, 300, 900])
def test_sign_is_decided_however_close_to_zero(digits):
    with mpmath.workdps(digits + 20):
        below = Fraction(int(mpmath.floor(mpmath.pi * mpmath.mpf(10) ** digits)), 10**digits)
    above = below + Fraction(1, 10**digits)
    for scale in (1, Fraction(1, 7), 10**50):
        assert Exact(-below * scale, Fraction(scale)).sign == 1
        assert Exact(-above * scale, Fraction(scale)).sign == -1
        assert Exact(below * scale, Fraction(-scale)).sign == -1
        assert Exact(above * scale, Fraction(-scale)).sign == 1
    assert ZERO.sign == 0


@pytest.mark.parametrize("value", [0.5, True, "1", Decimal("0.1"), None, 1j, math.pi])
def test_nothing_but_integers_and_fractions_becomes_exact(value):
    with pytest.raises(TypeError, match="expected a Fraction"):
        Exact(value)
    with pytest.raises(TypeError, match="expected a Fraction"):
        Exact(Fraction(0), value)


def test_integers_become_fractions():
    """The quotient of two integers would be a float."""
    x = Exact(1, 2)
    assert type(x.rational) is Fraction
    assert type(x.pi_multiple) is Fraction


@given(st.fractions(), st.fractions())
def test_number_is_the_exact_value_rounded_once_or_twice(rational, pi_multiple):
    a, b = Multiprecision(50), Multiprecision(90)
    x = Exact(rational, pi_multiple)
    scale = abs(a.number(rational)) + 4 * abs(a.number(pi_multiple)) + 1
    # The tolerance allows for four roundings at 50 digits.
    assert abs(b.context.mpf(a.number(x)) - b.number(x)) < scale * b.context.mpf("1e-49")


def _with_numbers(path, numbers, tmp_path):
    """Return the bicycle file with the value of each symbol replaced."""
    lines = []
    for line in path.read_text("utf-8").split("\n"):
        symbol = line.partition("=")[0].strip()
        lines.append(f"{symbol} = {numbers[symbol]}" if symbol in numbers else line)
    copy = tmp_path / "copy.toml"
    copy.write_text("\n".join(lines), "utf-8")
    return copy


@pytest.mark.parametrize("quote", ['"', ""], ids=["quoted", "bare"])
@pytest.mark.parametrize("seed", range(3))
def test_no_parameter_passes_through_a_float(quote, seed, tmp_path):
    """Forty random digits are preserved, also in bare TOML floats."""
    rng = random.Random(seed)
    texts = {}
    for symbol in PARAMETERS:
        digits = f"{rng.randrange(10**40):040}"
        first = "1." if symbol not in {"IBxz", "IHxz"} else "0."
        texts[symbol] = first + digits if symbol != "lam" else "0." + digits
    numbers = {symbol: f"{quote}{text}{quote}" for symbol, text in texts.items()}
    bicycle = read_bicycle(_with_numbers(benchmark_bicycle(), numbers, tmp_path))
    for symbol, text in texts.items():
        x = bicycle[symbol]
        assert x == Exact(Fraction(text))
        assert type(x.rational) is Fraction


def test_no_maneuver_passes_through_a_float(maneuvers):
    for maneuver in maneuvers:
        for x in (maneuver.speed, maneuver.roll_rate, maneuver.roll, maneuver.steer):
            assert type(x) is Exact
            assert type(x.rational) is Fraction
        assert type(maneuver.duration) is Fraction
        assert type(maneuver.spacing) is Fraction
        # As binary64, 0.05 would be a fraction with the denominator 2^57.
        assert maneuver.roll_rate.rational.denominator <= 20
