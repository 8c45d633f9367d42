"""Bad input gives one line: the file, the key, what was found and what was expected.

A syntax error names line and column instead of the key.

Each case changes one thing in a good file. Only `InputError` may be raised.
"""

import os
from fractions import Fraction

import pytest

from heyoka_bike.bicycle.parameters import read_bicycle, read_maneuvers
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.numbers.exact import Exact

# Each test takes milliseconds. The timeout only ends tests that hang, not tests on slow machines.
pytestmark = pytest.mark.timeout(60)

BICYCLE = """\
name = "test bicycle"
[parameters]
w = "1.02"
c = "0.08"
lam = "pi/10"
g = "9.81"
rR = "0.3"
mR = "2"
IRxx = "0.0603"
IRyy = "0.12"
xB = "0.3"
zB = "-0.9"
mB = { value = "85", unit = "kg" }
IBxx = "9.2"
IByy = "11"
IBzz = "2.8"
IBxz = "2.4"
xH = "0.9"
zH = "-0.7"
mH = "4"
IHxx = "0.05892"
IHyy = "0.06"
IHzz = "0.00708"
IHxz = "-0.00756"
rF = "0.35"
mF = "3"
IFxx = "0.1405"
IFyy = "0.28"
"""

MANEUVERS = """\
name = "test maneuvers"
[[maneuver]]
name = "first"
speed = "4.0"
roll_rate = "0.05"
duration = "10"
spacing = "0.01"
[[maneuver]]
speed = { value = "4.6", unit = "m/s" }
roll_rate = "0.5"
roll = "0.1"
steer = "-pi/20"
steer_rate = "0"
duration = "10"
spacing = "0.01"
"""

NUMBER = "expected a decimal number or an expression"

# For each case: the text to be replaced, its replacement, and the beginning of the message after
# the name of the file.
BICYCLES = [
    # Entries that are missing, unknown or given twice
    ('w = "1.02"\n', "", "parameters: found no entry 'w', expected one (wheel base)"),
    ('IFyy = "0.28"\n', "", "parameters: found no entry 'IFyy', expected one (axial"),
    ('name = "test bicycle"\n', "", "found no name of the bicycle, expected name ="),
    ("[parameters]\n", "", "found unknown entry 'w', expected one of: name,"),
    (BICYCLE, 'name = "b"\n', "found no table [parameters], expected a table"),
    (BICYCLE, 'name = "b"\nparameters = 3\n',
     "parameters: found an integer, expected a table [parameters]"),
    (BICYCLE, 'name = "b"\n[[parameters]]\n',
     "parameters: found a list, expected a table [parameters]"),
    (BICYCLE, "", "found an empty file, expected a table"),
    (BICYCLE, " \n\t\n", "found an empty file, expected a table"),
    (BICYCLE, "# nothing\n", "found no table [parameters], expected a table"),
    ('w = "1.02"', 'W = "1.02"', "parameters: found unknown entry 'W', expected 'w' or"),
    ('mB = {', "mb = {", "parameters: found unknown entry 'mb', expected 'mB' or"),
    ("[parameters]", "[parameter]", "found unknown entry 'parameter', expected"),
    ('unit = "kg"', 'units = "kg"',
     "parameters.mB: found unknown entry 'units', expected 'unit' or"),
    ('c = "0.08"', 'w = "0.08"', "4:11: found 'w = \"0.08\"', expected valid TOML (Cannot"),
    ('c = "0.08"', '"w" = 1', "4:8: found '\"w\" = 1', expected valid TOML (Cannot"),
    ('IFyy = "0.28"\n', "[parameters]\n", "28:12: found '[parameters]', expected valid TOML"),
    ('value = "85"', 'value = "85", value = "86"',
     "13:34: found 'mB = { value = \"85\", value = \"86\", unit"),
    # Texts that are not numbers
    ('"1.02"', '"one"', "parameters.w: found 'one', expected a decimal number or an"),
    ('"1.02"', '""', "parameters.w: found '', expected a decimal number or an"),
    ('"1.02"', '"1,02"', "parameters.w: found '1,02', expected a decimal number or an"),
    ('"1.02"', '"1.02 m"', "parameters.w: found '1.02 m', expected a decimal number or an"),
    ('"1.02"', "true", "parameters.w: found a boolean, expected a number as a decimal"),
    ('"1.02"', "[1.02]", "parameters.w: found a list, expected a number as a decimal"),
    ('"1.02"', "2007-08-08", "parameters.w: found a date or time, expected a number as a"),
    ('"1.02"', "07:32:00", "parameters.w: found a date or time, expected a number as a"),
    ('"1.02"', "{}", "parameters.w: found a table without 'value', expected an entry"),
    ('"1.02"', "{ value = { value = 1 } }",
     "parameters.w.value: found a table, expected a number as a decimal"),
    ('"1.02"', "nan", "parameters.w: found 'nan', expected a decimal number or an"),
    ('"1.02"', "-inf", "parameters.w: found '-inf', expected a decimal number or an"),
    ('"1.02"', '"inf"', "parameters.w: found 'inf', expected a decimal number or an"),
    ('"85"', '"nan"', "parameters.mB.value: found 'nan', expected a decimal number or an"),
    ('"85"', "false", "parameters.mB.value: found a boolean, expected a number as a decimal"),
    ('"1.02"', '"1e999999999"', "parameters.w: found '1e999999999', expected an exponent"),
    ('"1.02"', "1e999999999", "parameters.w: found '1e999999999', expected an exponent"),
    ('"1.02"', '"1e301"', "parameters.w: found '1e301', expected zero or a magnitude"),
    ('"1.02"', f'"{"1" * 700}"', "parameters.w: found"),
    ('"1.02"', f'"{"1" * 10**5}"', "3:2001: found a line of 100006 characters, expected at"),
    ('"1.02"', "1" * 10**5, "3:2001: found a line of 100004 characters, expected at"),
    ('"1.02"', "0x" + "f" * 1900, "parameters.w: found"),
    ('"1.02"', '"' + "(" * 500 + '"', "parameters.w: found"),
    ('"1.02"', '"9**9**9"', "parameters.w: found '9**9**9', expected a decimal number or"),
    ('"1.02"', '"lambda: 0"', "parameters.w: found 'lambda: 0', expected a decimal number or"),
    ('"1.02"', '"pi.real"', "parameters.w: found 'pi.real', expected a decimal number or"),
    ('"1.02"', "\"__import__('os')\"",
     "parameters.w: found '__import__('os')', expected a decimal"),
    ('"1.02"', '"1/0"', "parameters.w: found '1/0', a division by zero, expected a"),
    ('"pi/10"', '"pi*pi"', "parameters.lam: found 'pi*pi', a product of pi and pi, expected"),
    ('"pi/10"', '"1/pi"', "parameters.lam: found '1/pi', a division by pi, expected an"),
    ('"1.02"', '"pi/3"', "parameters.w: found 1.0471975511966, expected a number"),
    # Control characters and line ends, which the message must escape
    ('"1.02"', '"1\\n2"', "parameters.w: found '1\\n2', expected a decimal number or an"),
    ('"1.02"', '"\\u001b[31m1"', "parameters.w: found '\\x1b[31m1', expected a decimal number or"),
    ('"1.02"', '"\\u202e1"', "parameters.w: found '\\u202e1', expected a decimal number or"),
    ('"1.02"', '"""\n1.02\n"""', "parameters.w: found '1.02\\n', expected a decimal number or an"),
    ('w = "1.02"', '"w\\n" = "1.02"', "parameters: found unknown entry 'w\\n', expected 'w' or"),
    ('w = "1.02"', f'{"w" * 1000} = "1.02"', "parameters: found unknown entry"),
    # Wrong units
    ('unit = "kg"', 'unit = "lb"', "parameters.mB: found unit 'lb', expected 'kg'"),
    ('unit = "kg"', "unit = 1", "parameters.mB: found an integer as unit, expected 'kg'"),
    ('unit = "kg"', 'unit = ["kg"]', "parameters.mB: found a list as unit, expected 'kg'"),
    ('unit = "kg"', 'unit = "k\\ng"', "parameters.mB: found unit 'k\\ng', expected 'kg'"),
    ('unit = "kg"', "source = 5",
     "parameters.mB.source: found an integer, expected one line of text, at"),
    # Values outside the range of the model
    ('"85"', '"-85"',
     "parameters.mB (mass of the rear frame with rider): found -85 kg, expected zero or more"),
    ('"0.3"', '"0"',
     "parameters.rR (radius of the rear wheel): found 0 m, expected a positive number"),
    ('"0.35"', '"-0.35"',
     "parameters.rF (radius of the front wheel): found -0.35 m, expected a positive number"),
    ('"1.02"', '"0"', "parameters.w (wheel base): found 0 m, expected a positive number"),
    ('"1.02"', '"-1e-300"',
     "parameters.w (wheel base): found -1e-300 m, expected a positive number"),
    ('"9.81"', '"-9.81"', "parameters.g (gravity): found -9.81 N/kg, expected zero or more"),
    ('"9.2"', '"-9.2"',
     "parameters.IBxx (roll inertia of the rear frame with rider): found -9.2 kg m^2, expected"),
    ('"pi/10"', '"pi/2"',
     "parameters.lam (steer axis tilt from the vertical): found 1.5707963267949 rad, expected"),
    ('"pi/10"', '"-pi/2"',
     "parameters.lam (steer axis tilt from the vertical): found -1.5707963267949 rad, expected"),
    ('"pi/10"', '"18"',
     "parameters.lam (steer axis tilt from the vertical): found 18 rad, expected less than pi/2"),
    ('"2.4"', '"24"', "parameters.IBxz: found 24 kg m^2, expected at most the square"),
    ('"-0.00756"', '"-0.0756"', "parameters.IHxz: found -0.0756 kg m^2, expected at most the"),
    (BICYCLE, BICYCLE.replace('mH = "4"', "mH = 0").replace('mF = "3"', "mF = 0"),
     "parameters.mF: found 0 kg, and 0 kg for mH too, expected"),
    # Invalid TOML
    ('"1.02"', "", "3:5: found 'w =', expected valid TOML (Invalid value)"),
    ('"1.02"', "1.02 m", "3:10: found 'w = 1.02 m', expected valid TOML"),
    ('"1.02"', "1,02", "3:6: found 'w = 1,02', expected valid TOML (Expected"),
    ('"1.02"', "abc", "3:5: found 'w = abc', expected valid TOML (Invalid"),
    ('"1.02"', '"1.02', "3:10: found 'w = \"1.02', expected valid TOML (Illegal"),
    ('w = "1.02"', "w", "3:2: found 'w', expected valid TOML (Expected '='"),
    ('w = "1.02"', "= 1", "3:1: found '= 1', expected valid TOML (Invalid"),
    ('"1.02"', '"\\q"', "3:8: found 'w = \"\\q\"', expected valid TOML"),
    ('"1.02"', '"\t\x07"', "3:7: found 'w = \"\\t\\x07\"', expected valid TOML"),
    ('"1.02"', "[" * 1900, "found values nested too deeply, expected"),
    ('"1.02"', "{a=" * 600, "found values nested too deeply, expected"),
    ("[parameters]", "[parameters", "2:12: found '[parameters', expected valid TOML"),
    ('"1.02"', '"1.02\0"', "3:10: found 'w = \"1.02\\x00\"', expected valid TOML"),
    ('"1.02"', '"1.02"\r#', "3:11: found 'w = \"1.02\"\\r#', expected valid TOML"),
    ("test bicycle", "", "name: found '', expected one line of text, at most"),
    ("test bicycle", "a\\nb", "name: found 'a\\nb', expected one line of text, at"),
    ("test bicycle", "a" * 201, "name: found"),
    ('"test bicycle"', "1.5", "name: found a number, expected one line of text, at"),
]  # fmt: skip

MANEUVER_FILES = [
    ('speed = "4.0"\n', "", "maneuver 1: found no entry 'speed', expected one (speed of"),
    ('roll_rate = "0.5"\n', "", "maneuver 2: found no entry 'roll_rate', expected one (rate"),
    ('roll = "0.1"', 'rol = "0.1"', "maneuver 2: found unknown entry 'rol', expected 'roll' or"),
    (MANEUVERS, "", "found an empty file, expected one or more"),
    (MANEUVERS, 'name = "m"', "found no table [[maneuver]], expected one or"),
    (MANEUVERS, "maneuver = 1", "maneuver: found an integer, expected tables [[maneuver]]"),
    (MANEUVERS, "maneuver = []", "found no table [[maneuver]], expected one or"),
    (MANEUVERS, "maneuver = [1]", "maneuver 1: found an integer, expected a table [[maneuver]]"),
    (MANEUVERS, "[maneuver]\nspeed = 1", "maneuver: found a table [maneuver], expected"),
    (MANEUVERS, "maneuver = [{ speed = 1, speed = 2 }]",
     "1:35: found 'maneuver = [{ speed = 1, speed = 2 }]',"),
    (MANEUVERS, 'maneuver = [{ speed = "x" }]',
     "maneuver 1: found no entry 'roll_rate', expected one (rate"),
    (MANEUVERS, "maneuver = [\n { speed = 1 },\n]",
     "maneuver 1: found no entry 'roll_rate', expected one (rate"),
    ('"4.6"', '"fast"', "maneuver 2, speed.value: found 'fast', expected a decimal number or an"),
    ('"m/s"', '"km"', "maneuver 2, speed: found unit 'km', expected 'm/s'"),
    ('duration = "10"', 'duration = "0"',
     "maneuver 1, duration (length of the run): found 0 s, expected a positive number"),
    ('duration = "10"', 'duration = "-10"',
     "maneuver 1, duration (length of the run): found -10 s, expected a positive number"),
    ('duration = "10"', 'duration = "pi"',
     "maneuver 1, duration: found 3.14159265358979, expected a number"),
    ('duration = "10"', 'duration = "10.005"',
     "maneuver 1, duration: found 10.005 s, expected a multiple of the spacing"),
    ('duration = "10"', 'duration = "0.001"',
     "maneuver 1, duration: found 0.001 s, expected a multiple of the spacing"),
    ('spacing = "0.01"', 'spacing = "0.03"',
     "maneuver 1, duration: found 10 s, expected a multiple of the spacing"),
    ('spacing = "0.01"', 'spacing = "0"',
     "maneuver 1, spacing (time between two rows): found 0 s, expected a positive number"),
    ('spacing = "0.01"', 'spacing = "1e-6"',
     "maneuver 1, spacing: found more than 1000001 rows, expected a longer"),
    ('spacing = "0.01"', 'spacing = "1e-300"',
     "maneuver 1, spacing: found more than 1000001 rows, expected a longer"),
    ('"0.1"', '"pi/2"',
     "maneuver 2, roll (lean of the rear wheel plane, right positive): found 1.5707963267949"),
    ('"-pi/20"', '"-pi"',
     "maneuver 2, steer (steer angle, right positive): found -3.14159265358979 rad, expected"),
    ('"-pi/20"', '"180"',
     "maneuver 2, steer (steer angle, right positive): found 180 rad, expected less than pi"),
    ('"first"', '"maneuver 2"',
     "maneuver 2, name: found 'maneuver 2', already the name of maneuver 1,"),
    ('[[maneuver]]\nspeed', '[[maneuver]]\nname = "first"\nspeed',
     "maneuver 2, name: found 'first', already the name of maneuver 1,"),
    ('"first"', '" "', "maneuver 1, name: found ' ', expected one line of text, at most"),
    ('"first"', "1", "maneuver 1, name: found an integer, expected one line of text, at"),
    ('"first"', f'"{"x" * 999}"', "maneuver 1, name: found"),
    ('"test maneuvers"', "[]", "name: found a list, expected one line of text, at"),
    ('"0.05"', "1979-05-27T07:32:00Z",
     "maneuver 1, roll_rate: found a date or time, expected a number as a"),
    ('speed = "4.0"', 'speed = "4.0"\nspeed = "5"',
     "5:12: found 'speed = \"5\"', expected valid TOML"),
]  # fmt: skip


def _the_one_error(read, path):
    with pytest.raises(InputError) as caught:
        read(path)
    error = caught.value
    text = str(error)
    assert text.isprintable(), "the message contains control characters"
    assert len(text) < 600 + len(str(path))
    assert "found" in text or "cannot be read" in text
    assert "expected" in text
    assert error.exit_code is Exit.INPUT
    assert error.__cause__ is None
    return error


def _written(tmp_path, text):
    path = tmp_path / "input.toml"
    path.write_bytes(text.encode("utf-8"))
    return path


def _check(read, good, case, tmp_path):
    old, new, said = case
    assert good.count(old), "the old text is not in the file"
    path = _written(tmp_path, good.replace(old, new, 1))
    error = _the_one_error(read, path)
    separator = "" if said[0].isdigit() else " "
    assert str(error).startswith(f"{path}:{separator}{said}")


def _ids(case):
    return ascii(case[1][:30] or f"no {case[0][:20]}")


def test_the_files_that_the_cases_change_are_good(bicycle, tmp_path):
    assert read_bicycle(_written(tmp_path, BICYCLE)).values == bicycle.values
    first, second = read_maneuvers(_written(tmp_path, MANEUVERS))
    assert (first.name, second.name) == ("first", "maneuver 2")
    assert second.steer == Exact(Fraction(0), Fraction(-1, 20))
    assert second.roll == Exact(Fraction(1, 10))


@pytest.mark.parametrize("case", BICYCLES, ids=_ids)
def test_bicycle(case, tmp_path):
    _check(read_bicycle, BICYCLE, case, tmp_path)


@pytest.mark.parametrize("case", MANEUVER_FILES, ids=_ids)
def test_maneuvers(case, tmp_path):
    _check(read_maneuvers, MANEUVERS, case, tmp_path)


READERS = pytest.mark.parametrize("read", [read_bicycle, read_maneuvers])


@READERS
@pytest.mark.parametrize(
    ("raw", "line", "column", "fragment"),
    [
        (BICYCLE.encode("utf-16"), 1, 1, "found UTF-16 text, expected UTF-8"),
        (b"\xfe\xff" + BICYCLE.encode("utf-16-be"), 1, 1, "found UTF-16 text, expected UTF-8"),
        (BICYCLE.encode("utf-16-le"), 1, 2, "expected valid TOML"),
        (b"\x7fELF\x02\x01\x01\x00", 1, 1, "expected valid TOML"),
        (bytes(range(256)), 1, 1, "found byte 0x80, expected UTF-8 text"),
        (b'name = "\xe9t\xe9"', 1, 9, "found byte 0xe9, expected UTF-8 text"),
        (b'name = "a"\r\nx = "\xc3\xa9\xff"', 2, 7, "found byte 0xff, expected UTF-8 text"),
        (b'\xef\xbb\xbfname = "\xff"', 1, 9, "found byte 0xff, expected UTF-8 text"),
        (b"\0" * 1000, 1, 1, "found '\\x00\\x00"),
        (b"\0", 1, 1, "found '\\x00'"),
        (b"a" * 10**5, 1, 2001, "found a line of 100000 characters, expected at most 2000"),
        (b"#\n" * 10**6, None, None, "found more than 200000 bytes, expected a short TOML file"),
        (b"[" * 10**7, None, None, "found more than 200000 bytes, expected a short TOML file"),
    ],
    ids=lambda x: ascii(x[:12]) if isinstance(x, bytes) else None,
)
def test_what_is_not_text(read, raw, line, column, fragment, tmp_path):
    path = tmp_path / "input.toml"
    path.write_bytes(raw)
    error = _the_one_error(read, path)
    assert fragment in error.message
    if raw != bytes(range(256)):
        assert (error.line, error.column) == (line, column)


@READERS
def test_slow_for_tomllib(read, tmp_path):
    """Dotted keys of a thousand parts take tomllib a time that grows with the square."""
    deep = ".".join(["a"] * 990)
    lines = [f"[{deep}]", *(f"b{i} = 1" for i in range(2000))]
    _the_one_error(read, _written(tmp_path, "\n".join(lines)))
    _the_one_error(read, _written(tmp_path, f"x = {{ {deep} = 1 }}"))


@READERS
def test_no_such_file(read, tmp_path):
    error = _the_one_error(read, tmp_path / "none.toml")
    assert error.message == "cannot be read (No such file or directory), expected a TOML file"
    assert error.file == str(tmp_path / "none.toml")
    assert (error.line, error.column) == (None, None)


@READERS
def test_a_directory(read, tmp_path):
    assert "found a directory, expected a TOML file" in str(_the_one_error(read, tmp_path))
    assert "found a directory" in str(_the_one_error(read, ""))


@READERS
def test_names_that_no_file_has(read, tmp_path):
    for name in ("a\0b", "a" * 300, "x/" * 3000, "\ud800", "a\nb", "\x1b[31m"):
        _the_one_error(read, tmp_path / name)
    _the_one_error(read, "y" * 10**6)
    below = _written(tmp_path, BICYCLE) / "below"
    assert "cannot be read" in str(_the_one_error(read, below))


@READERS
def test_a_file_name_with_a_line_end(read, tmp_path):
    path = tmp_path / "two\nlines.toml"
    path.write_text("[", "utf-8")
    assert "two\\nlines.toml:1:2: found" in str(_the_one_error(read, path))


@READERS
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_does_not_keep_us_waiting(read, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "found a pipe or device" in str(_the_one_error(read, tmp_path / "pipe"))


@READERS
@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="needs device files")
def test_a_device_that_never_ends(read):
    assert "found a pipe or device" in str(_the_one_error(read, "/dev/zero"))


@READERS
@pytest.mark.skipif(os.name == "nt", reason="needs file modes")
def test_a_file_we_may_not_read(read, tmp_path, monkeypatch):
    path = _written(tmp_path, BICYCLE)
    path.chmod(0)
    if os.access(path, os.R_OK):
        # The superuser may read every file, so the test itself raises the error of the operating
        # system.
        def refuse(*args, **kwargs):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(type(path), "open", refuse)
    assert "cannot be read (Permission denied)" in str(_the_one_error(read, path))


@READERS
def test_every_length_of_a_good_file_cut_short(read, tmp_path):
    good = BICYCLE if read is read_bicycle else MANEUVERS
    for length in range(0, len(good) - 8, 7):
        try:
            read(_written(tmp_path, good[:length]))
        except InputError:
            _the_one_error(read, _written(tmp_path, good[:length]))


FINE = [
    ("\n", "\r\n"),
    ('name = "test bicycle"', '\ufeffname = "test bicycle"'),
    ('w = "1.02"', "w = 1.02"),
    ('w = "1.02"', "w.value = 1.02"),
    ('w = "1.02"', 'w = { value = 1.02, unit = "m", name = "base", symbol = "w", source = "T1" }'),
    ('w = "1.02"', "'w' = '1.02'"),
    ('w = "1.02"', '"\\u0077" = """1.02"""'),
    ('w = "1.02"', 'w = "102/100"'),
    ('mB = { value = "85", unit = "kg" }', "mB = 85"),
    ('mB = { value = "85", unit = "kg" }', "mB = 0x55"),
    ('mB = { value = "85", unit = "kg" }', 'mB.value = "85"\nmB.unit = "kg"'),
    ('IFyy = "0.28"', '[parameters.IFyy]\nvalue = "0.28"\nunit = "kg m^2"'),
    ("[parameters]", '[ "parameters" ] # with [brackets] = and quotes "'),
    ("[parameters]\n", '[sources]\ntable = "1"\n[parameters]\n'),
]
"""Other ways to write the same bicycle."""


@pytest.mark.parametrize(("old", "new"), FINE, ids=lambda x: ascii(x[:20]))
def test_other_spellings_are_understood(bicycle, old, new, tmp_path):
    assert old in BICYCLE
    path = tmp_path / "input.toml"
    path.write_bytes(BICYCLE.replace(old, new).encode("utf-8"))
    assert read_bicycle(path).values == bicycle.values


def test_without_tables_at_all(bicycle, tmp_path):
    lines = BICYCLE.split("\n")
    flat = [lines[0], *(f"parameters.{line}" for line in lines[2:] if line)]
    path = _written(tmp_path, "\n".join(flat))
    assert read_bicycle(path).values == bicycle.values


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('w = "1.02"', 'w.value = "x"', "parameters.w.value"),
        ('w = "1.02"', 'w . "value" = "x"', "parameters.w.value"),
        ('IFyy = "0.28"', '[parameters.IFyy]\nvalue = "x"', "parameters.IFyy.value"),
        ('IFyy = "0.28"', '[parameters.IFyy]\nunit = "kg m^2"', "parameters.IFyy"),
        ('w = "1.02"', '# w = 1\nw = "x"', "parameters.w"),
        ('name = "test bicycle"', 'sources = [1, [2, "[x]"], { a = "}" }]\nname = 1', "name"),
    ],
)
def test_the_key_is_named_in_other_spellings(old, new, key, tmp_path):
    assert old in BICYCLE
    error = _the_one_error(read_bicycle, _written(tmp_path, BICYCLE.replace(old, new, 1)))
    assert error.message.startswith(f"{key}: found ")


@pytest.mark.parametrize(
    ("changes", "warnings"),
    [
        ({"IByy": "0"}, ["inertia matrix of B is only semidefinite",
                         "moments of inertia of B violate the triangle inequality"]),
        ({"IByy": "12.1"}, ["moments of inertia of B violate the triangle inequality"]),
        ({"IByy": "12"}, []),
        ({"IByy": "7"}, ["moments of inertia of B violate the triangle inequality"]),
        ({"IHxx": "0", "IHzz": "0", "IHxz": "0", "IHyy": "0"},
         ["inertia matrix of H is only semidefinite"]),
        ({"IBxx": "9", "IBzz": "4", "IBxz": "-6", "IByy": "13"},
         ["inertia matrix of B is only semidefinite"]),
        ({"IRxx": "0"}, ["inertia matrix of R is only semidefinite",
                         "moments of inertia of R violate the triangle inequality"]),
        ({"IFxx": "0.14"}, []),
        ({"IFxx": "0.1399"}, ["moments of inertia of F violate the triangle inequality"]),
        ({"mR": "0", "IRxx": "0", "IRyy": "0"}, ["inertia matrix of R is only semidefinite"]),
    ],
)  # fmt: skip
def test_idealised_inertia_is_a_warning(bicycle, changes, warnings, tmp_path):
    """Bodies made of points, rods and discs are valid."""
    text = BICYCLE
    for symbol, value in changes.items():
        line = next(x for x in text.split("\n") if x.startswith(f"{symbol} ="))
        text = text.replace(line, f'{symbol} = "{value}"')
    read = read_bicycle(_written(tmp_path, text))
    assert list(read.warnings) == warnings
    again = bicycle.replace(**{symbol: Exact.parse(value) for symbol, value in changes.items()})
    assert again.warnings == read.warnings
    assert again.values == read.values


@pytest.mark.parametrize(
    ("changes", "fragment"),
    [
        ({"x": Exact(1)}, "found unknown parameter 'x'"),
        ({"w": Exact(0)}, "w (wheel base): found 0 m, expected a positive number"),
        ({"mB": 85.0}, "mB: found float, expected an Exact"),
        ({"mB": "85"}, "mB: found str, expected an Exact"),
        ({"mB": Exact(Fraction(10**400))}, "mB: found a magnitude out of range, expected"),
        ({"mB": Exact(Fraction(1, 10**400))}, "mB: found a magnitude out of range, expected"),
        ({"w": Exact(Fraction(1), Fraction(1))}, "expected a number without pi"),
        ({"mR": Exact(0), "mB": Exact(0)}, "the rear assembly needs a mass"),
    ],
)
def test_a_changed_bicycle_is_checked_too(bicycle, changes, fragment):
    with pytest.raises(InputError) as caught:
        bicycle.replace(**changes)
    assert fragment in caught.value.message
    assert caught.value.file is None
    assert str(caught.value).isprintable()
