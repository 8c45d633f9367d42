"""Any bytes of an input file are read, or rejected with `InputError`."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle, read_maneuvers
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers

# The timeout only ends tests that hang, not tests on slow machines.
pytestmark = pytest.mark.timeout(300)

SHIPPED = {
    read_bicycle: benchmark_bicycle().read_bytes(),
    read_maneuvers: benchmark_maneuvers().read_bytes(),
}
READERS = pytest.mark.parametrize("read", list(SHIPPED), ids=lambda read: read.__name__)

# Pieces of text that may confuse a reader of TOML or of numbers; they are inserted anywhere.
PIECES = st.one_of(
    st.sampled_from(
        [
            b'"', b"'", b'"""', b"'''", b"[", b"]", b"[[", b"]]", b"{", b"}", b"=", b".", b",",
            b"#", b"\n", b"\r", b"\r\n", b"\t", b"\0", b"\\", b"\\u0000", b"\\U00110000", b"\xff",
            b"\xc3", b"\xef\xbb\xbf", b"-", b"e", b"e400", b"e-400", b"1e999999999", b"pi", b"nan",
            b"inf", b"true", b"1979-05-27T07:32:00Z", b"(", b")", b"*", b"/", b"/0", b"**", b"_",
            b"0x", b"value", b"unit", b"[parameters]\n", b"[[maneuver]]\n", b"[maneuver]\n",
            b"w = 1\n", b"x.y.z = 1\n", b"\xe2\x80\xae", b"\xf0\x9f\x9a\xb2", b"9" * 700,
            b"(" * 200, b"[" * 999,
        ]
    ),
    st.binary(max_size=8),
)  # fmt: skip


@st.composite
def damaged(draw, good, at_most):
    """Draw the good file with parts deleted, replaced, repeated or moved."""
    raw = good
    for _ in range(draw(st.integers(1, at_most))):
        start = draw(st.integers(0, len(raw)))
        end = min(len(raw), start + draw(st.integers(0, 40)))
        piece = draw(PIECES)
        match draw(st.sampled_from(["replace", "insert", "delete", "repeat", "cut", "flip"])):
            case "replace":
                raw = raw[:start] + piece + raw[end:]
            case "insert":
                raw = raw[:start] + piece + raw[start:]
            case "delete":
                raw = raw[:start] + raw[end:]
            case "repeat":
                raw = raw[:end] + raw[start:]
            case "cut":
                raw = raw[:start]
            case "flip":
                byte = bytes([raw[start] ^ 1 << draw(st.integers(0, 7))]) if start < end else b""
                raw = raw[:start] + byte + raw[start + 1 :]
    return raw


# Values for the TOML file: any value that TOML allows, but mainly numbers.
VALUES = st.one_of(
    st.text(max_size=30),
    st.text("0123456789.+-*/()e pi", max_size=30),
    st.integers(),
    st.floats(),
    st.booleans(),
    st.dates(),
    st.datetimes(),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(
        st.sampled_from(["value", "unit", "source", "other"]),
        st.one_of(st.text("0123456789kgm/s ", max_size=5), st.integers(), st.just("m")),
    ),
)


def _toml(value):
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            escaped = "".join(
                ch if ch.isalnum() and ch.isascii() else f"\\U{ord(ch):08x}" for ch in value
            )
            return f'"{escaped}"'
        case list():
            return "[" + ", ".join(map(_toml, value)) + "]"
        case dict():
            return "{" + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + "}"
        case int() | float():
            return repr(value)
    return value.isoformat()


def _read_or_refused(read, path, raw):
    path.write_bytes(raw)
    try:
        found, error = read(path), None
    except InputError as e:
        found, error = None, e
    if error is None:
        values = found.values.values() if read is read_bicycle else [m.speed for m in found]
        assert all(type(x) is Exact and x.is_moderate for x in values)
        return
    text = str(error)
    assert text.isprintable()
    assert len(text) < 700 + len(str(path))
    assert "expected" in text
    assert (error.line is None) == (error.column is None)
    if error.line is not None:
        lines = raw.decode("utf-8-sig", "replace").replace("\r\n", "\n").split("\n")
        assert 1 <= error.line <= len(lines)
        # An error may also be reported at the end of the line, one column after its last character.
        assert 1 <= error.column <= len(lines[error.line - 1]) + 1


def _check(read, tmp_path_factory, strategy, examples):
    path = tmp_path_factory.mktemp("fuzz") / "input.toml"

    @settings(
        max_examples=examples,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        database=None,
    )
    @given(strategy)
    def run(raw):
        _read_or_refused(read, path, raw)

    run()


def _one_value_changed(read):
    """Draw the shipped file with one value replaced."""
    good = SHIPPED[read].decode("utf-8").split("\n")
    numbered = [i for i, line in enumerate(good) if "value =" in line]

    def changed(place, value):
        lines = list(good)
        key = lines[place].partition("=")[0]
        lines[place] = f"{key} = {_toml(value)}"
        return "\n".join(lines).encode("utf-8")

    return st.builds(changed, st.sampled_from(numbered), VALUES)


STRATEGIES = {
    "damaged": lambda read: damaged(SHIPPED[read], 4),
    "ruined": lambda read: damaged(SHIPPED[read], 40),
    "values": _one_value_changed,
    "noise": lambda _: st.one_of(
        st.binary(max_size=200), st.text("[]{}=.,\"'\\#\n abc1", max_size=60).map(str.encode)
    ),
}
KINDS = pytest.mark.parametrize("kind", STRATEGIES)


@READERS
@KINDS
def test_input(read, kind, tmp_path_factory):
    _check(read, tmp_path_factory, STRATEGIES[kind](read), 50)


@pytest.mark.slow
@pytest.mark.timeout(4 * 3600)
@READERS
@KINDS
def test_much_input(read, kind, tmp_path_factory):
    _check(read, tmp_path_factory, STRATEGIES[kind](read), 20_000)


@READERS
def test_each_byte_lost_or_altered(read, tmp_path):
    """Change one byte at a time, every 17th; these include all classes of bytes in the files."""
    good = SHIPPED[read]
    for at in range(0, len(good), 17):
        for byte in (b"", b"\xff", b'"'):
            _read_or_refused(read, tmp_path / "input.toml", good[:at] + byte + good[at + 1 :])


def test_the_good_files_are_read(tmp_path):
    for read, raw in SHIPPED.items():
        _read_or_refused(read, tmp_path / "input.toml", raw)
        assert read(tmp_path / "input.toml")
    assert set(read_bicycle(benchmark_bicycle()).values) == set(PARAMETERS)
