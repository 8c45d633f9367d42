"""``heyoka-bike import`` converts files of other programs to the 26 parameters, or refuses in
one line."""

import random
import re
import tomllib
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from heyoka_bike.bicycle.foreign.imported import Imported, import_bicycle
from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.exports.models import MODELS, render
from heyoka_bike.system.resources import collection, find_input
from support.model_files import about

# Files are read with 15 digits, so the error is half a unit of the fifteenth digit.
ROUNDOFF = 5e-15
READ = tuple(MODELS)


def run(*arguments, capsys):
    code = main(["import", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def written(bicycle, folder, kind):
    path = folder / f"model{MODELS[kind].suffix}"
    path.write_bytes(render(kind, bicycle, ()))
    return path


def changed(folder, bicycle, old, new):
    """A URDF file in which one text is replaced with another."""
    text = render("urdf", bicycle, ()).decode()
    assert old in text
    path = folder / "model.urdf"
    path.write_text(text.replace(old, new))
    return path


@pytest.mark.parametrize("kind", READ)
def test_what_is_exported_comes_back(kind, tmp_path):
    for name in collection("bicycles"):
        if name == "two-mass-skate":
            continue  # the next test covers it
        bicycle = read_bicycle(find_input("bicycles", name))
        found = import_bicycle(written(bicycle, tmp_path, kind)).bicycle
        for symbol in PARAMETERS:
            if (kind == "urdf" and symbol == "g") or not bicycle[symbol].is_rational:
                continue
            # Every published value has fewer than 15 digits.
            assert found[symbol] == bicycle[symbol], f"{name} {symbol}"


def test_wheels_without_mass_come_back(tmp_path):
    skate = read_bicycle(find_input("bicycles", "two-mass-skate"))
    found = import_bicycle(written(skate, tmp_path, "urdf")).bicycle
    assert found["mR"].is_zero
    assert float(found["mB"]) == float(skate["mB"])


@pytest.mark.parametrize("kind", READ)
def test_the_benchmark_comes_back_as_printed(kind, bicycle, tmp_path, capsys):
    path = written(bicycle, tmp_path, kind)
    code, out, err = run(path, capsys=capsys)
    said = "heyoka-bike: bicycle: g is set to 9.81 m/s^2, because URDF files contain no gravity\n"
    assert (code, err) == (0, said if kind == "urdf" else "")
    made = tmp_path / "mine.toml"
    assert run(path, "-o", made, capsys=capsys)[1] == f"{made}\n"
    assert made.read_text() == out
    found = read_bicycle(made)
    for symbol in PARAMETERS:
        if symbol != "lam":  # a decimal file cannot contain a multiple of pi exactly
            assert found[symbol] == bicycle[symbol], symbol
    assert float(found["lam"]) == pytest.approx(float(bicycle["lam"]), rel=ROUNDOFF)


def test_another_model_in_other_axes_is_the_same_bicycle(bicycle, tmp_path):
    """The model is rotated by a quarter turn and lifted; its frame has two links, one with
    principal axes."""
    text = render("urdf", bicycle, ()).decode()
    text = text.replace('<robot name="bicycle">', '<robot name="my own"><link name="world"/>')
    text = text.replace(
        "</robot>",
        '<joint name="stand" type="fixed"><parent link="world"/><child link="B"/>'
        '<origin xyz="3 -2 0.5" rpy="0 0 1.5707963267948966192313216916397514"/></joint>'
        '<link name="rider"><inertial><origin xyz="0.1 0 0"/><mass value="40"/>'
        '<inertia ixx="1" iyy="2" izz="3" ixz="-0.5"/></inertial></link>'
        '<joint name="seat" type="fixed"><parent link="B"/><child link="rider"/>'
        '<origin xyz="0.1 0 1"/></joint></robot>',
    )
    text = re.sub(r'<mass value="85"/>', '<mass value="45"/>', text)
    path = tmp_path / "turned.urdf"
    path.write_text(text)
    found = import_bicycle(path)
    assert found.bicycle.name == "my own"
    parts = ((45, 0.3, -0.9), (40, 0.2, -1.0))
    x, z = (sum(p[0] * p[i] for p in parts) / 85 for i in (1, 2))
    wanted = {
        "mB": 85, "xB": x, "zB": z,
        "IBxx": 9.2 + 1 + sum(m * (b - z) ** 2 for m, _, b in parts),
        "IBzz": 2.8 + 3 + sum(m * (a - x) ** 2 for m, a, _ in parts),
        "IBxz": 2.4 + 0.5 - sum(m * (a - x) * (b - z) for m, a, b in parts),
        "w": 1.02, "c": 0.08, "lam": 0.3141592653589793, "IHxz": -0.00756, "xH": 0.9,
    }  # fmt: skip
    for symbol, right in wanted.items():
        assert float(found.bicycle[symbol]) == pytest.approx(right, rel=1e-13), symbol


def test_quaternions_angles_and_principal_axes_of_mjcf(bicycle, tmp_path):
    """The rear frame's principal moments are 10, 11 and 2; the tangent of their tilt is 1/3."""
    text = render("mjcf", bicycle, ()).decode()
    text = text.replace(
        'mass="85" fullinertia="9.2 11 2.8 0 -2.4 0"',
        'mass="85" diaginertia="10 11 2" euler="0 18.434948822922010648 0"',
    ).replace('angle="radian" ', "")
    path = tmp_path / "model.xml"
    path.write_text(text)
    found = import_bicycle(path).bicycle
    for symbol in ("IBxx", "IByy", "IBzz", "IBxz"):
        assert float(found[symbol]) == pytest.approx(float(bicycle[symbol]), rel=1e-14)
    half = "0.98708745763749671 0 0.16018224300696726 0"
    path.write_text(text.replace('euler="0 18.434948822922010648 0"', f'quat="{half}"'))
    found = import_bicycle(path).bicycle
    assert float(found["IBxz"]) == pytest.approx(2.4, rel=1e-14)


@pytest.mark.parametrize("kind", READ)
def test_three_angles_turn_in_the_order_of_the_format(kind, bicycle, tmp_path):
    """The rear frame's inertia is given in axes that are rotated by three angles."""
    angles = (0.3, -0.2, 0.5)
    x, y, z = map(about, np.eye(3), angles)
    axes = x @ y @ z if kind == "mjcf" else z @ y @ x
    i = axes.T @ np.array([[9.2, 0, -2.4], [0, 11, 0], [-2.4, 0, 2.8]]) @ axes
    elements = [repr(float(i[j, k])) for j, k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    said = " ".join(map(str, angles))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    inertia = " ".join(f'{name}="{x}"' for name, x in zip(names, elements, strict=True))
    text = render(kind, bicycle, ()).decode()
    for old, new in (
        ('xyz="0.3 0 0.9" rpy="0 0 0"', f'xyz="0.3 0 0.9" rpy="{said}"'),
        ('ixx="9.2" iyy="11" izz="2.8" ixy="0" ixz="-2.4" iyz="0"', inertia),
        ("<pose>0.3 0 0.9 0 0 0", f"<pose>0.3 0 0.9 {said}"),
        (
            "<ixx>9.2</ixx><iyy>11</iyy><izz>2.8</izz><ixy>0</ixy><ixz>-2.4</ixz><iyz>0</iyz>",
            "".join(f"<{n}>{x}</{n}>" for n, x in zip(names, elements, strict=True)),
        ),
        ('"9.2 11 2.8 0 -2.4 0"', f'"{" ".join(elements)}" euler="{said}"'),
    ):
        text = text.replace(old, new)
    assert said in text
    path = tmp_path / "model"
    path.write_text(text)
    found = import_bicycle(path)
    assert not [note for note in found.notes if "left out" in note]
    for symbol in ("IBxx", "IByy", "IBzz", "IBxz"):
        right = float(bicycle[symbol])
        assert float(found.bicycle[symbol]) == pytest.approx(right, rel=1e-13)


@pytest.mark.parametrize("kind", READ)
def test_damaged_files_are_refused_or_read(kind, bicycle, tmp_path):
    """Words of the file are deleted, doubled, or replaced with other words."""
    text, draw = render(kind, bicycle, ()).decode().partition("-->")[2], random.Random(5)
    words = re.split(r"(?<=[ >\"])|(?=[ <\"])", text)
    path = tmp_path / "damaged"
    for _ in range(60):
        i, j = draw.randrange(len(words)), draw.randrange(len(words))
        put = draw.choice(("", words[i] * 2, words[j], "-0", "1e999", "nan"))
        path.write_text("".join([*words[:i], put, *words[i + 1 :]]))
        with suppress(InputError):
            import_bicycle(path)


@pytest.mark.parametrize(
    ("old", "new", "note"),
    [
        ('ixy="0" ixz="-2.4"', 'ixy="0.3" ixz="-2.4"', "the inertia of B has xy = 0.3 kg m^2"),
        (
            '<origin xyz="0.3 0 0.9"', '<origin xyz="0.3 0.02 0.9"',
            "the centre of mass of B is 0.02 m off the plane of the rear wheel",
        ),
        (
            'xyz="0 0 0.3" rpy', 'xyz="0 0.01 0.3" rpy',
            "the front wheel is -0.01 m off the plane of the rear wheel",
        ),
        ('ixx="0.1405"', 'ixx="0.15"', "the inertia of F differs by 0.00475 kg m^2 from that of a "
         "wheel"),
    ],
)  # fmt: skip
def test_what_cannot_be_held_is_said(old, new, note, bicycle, tmp_path, capsys):
    code, _, err = run(changed(tmp_path, bicycle, old, new), capsys=capsys)
    assert code == 0
    assert f"bicycle: left out: {note}; no parameter of the bicycle describes this\n" in err


def test_a_parameter_file_with_and_without_uncertainties(tmp_path, capsys):
    right = read_bicycle(find_input("bicycles", "browser"))
    uncertain, plain = tmp_path / "BrowserBenchmark.txt", tmp_path / "benchmark-browser.yml"
    lines = {s: str(float(right[s])) for s in PARAMETERS}
    deviations = {s: str(float(right.uncertainties[s])) for s in right.uncertainties}
    uncertain.write_text(
        "# measured\n" + "".join(f"{s} = {x}+/-{deviations[s]}\n" for s, x in lines.items())
    )
    plain.write_text("".join(f"{s}: {x}\n" for s, x in lines.items()) + "v: 5.0\n")
    found = import_bicycle(uncertain)
    assert found.bicycle.values == right.values
    assert found.bicycle.uncertainties == right.uncertainties
    assert import_bicycle(plain).bicycle.values == right.values
    code, out, err = run(uncertain, capsys=capsys)
    assert code == 0
    assert "BrowserBenchmark: warning: moments of inertia of B violate the triangle" in err
    made = tmp_path / "made.toml"
    made.write_text(out)
    again = read_bicycle(made)
    assert (again.values, again.uncertainties) == (right.values, right.uncertainties)
    assert "v is left out" in run(plain, capsys=capsys)[2]


def test_small_values_as_the_package_uncertainties_writes_them(bicycle, tmp_path):
    lines = {s: str(float(bicycle[s])) for s in PARAMETERS} | {"c": "(3.0+/-0.1)e-05"}
    path = tmp_path / "a.txt"
    path.write_text("".join(f"{s} = {x}\n" for s, x in lines.items()))
    found = import_bicycle(path)
    assert found.bicycle["c"] == Exact.parse("3e-5")
    assert found.bicycle.uncertainties == {"c": Exact.parse("1e-6")}


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("(1.0+/-0.1)e-99999999", "expected an exponent between -400 and 400"),
        ("(1.0+/-0.1)e+99999999", "expected an exponent between -400 and 400"),
        ("(1e300+/-1e299)e300", "expected zero or a magnitude between 1e-300 and 1e300"),
        ("(1e-300+/-1e-300)e-300", "expected zero or a magnitude between 1e-300 and 1e300"),
        ("1e-99999999", "expected an exponent between -400 and 400"),
        ("1+/-1e-99999999", "expected an exponent between -400 and 400"),
        ("1.02+/--1", "expected a number, or one +/- its standard deviation"),
        ("1.02+/-+1", "expected a number, or one +/- its standard deviation"),
        ("(1.0+/--0.1)e-05", "expected a number, or one +/- its standard deviation"),
    ],
)
def test_values_of_no_size_and_negative_deviations_are_refused(value, told, tmp_path, capsys):
    path = tmp_path / "a.txt"
    path.write_text(f"w = {value}\n")
    code, out, err = run(path, capsys=capsys)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert "a.txt:1:5: w: found " in err
    assert told in err


@pytest.mark.parametrize("size", ["", " ", "x", "1e-99999999"])
def test_a_shape_without_a_size_is_refused(size, bicycle, tmp_path, capsys):
    text = render("mjcf", bicycle, ()).decode()
    path = tmp_path / "bicycle.xml"
    path.write_text(re.sub(r' size="[^"]*"', f' size="{size}"', text))
    code, out, err = run(path, capsys=capsys)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert f"size of <geom>: found {size!r}, expected a number" in err


PLAIN = "w = 1\n"
ROBOT = '<robot name="a">\n  {}\n</robot>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "found no w, c, lam, "),
        (PLAIN, "found no c, lam, "),
        (PLAIN + "w = 2\n", ":2:1: found w again, after line 1"),
        (PLAIN + "IHzz = 0.0292/-0.0003\n", ":2:8: IHzz: found '0.0292/-0.0003', expected a num"),
        (PLAIN + "c = 0.1, 0.2\n", ":2:5: c: found '0.1, 0.2', expected a number"),
        (PLAIN + "  tilt = 1\n", ":2:3: found unknown parameter 'tilt'"),
        (PLAIN + "something else\n", ":2:1: found 'something else', expected a line such as"),
        ("<robot", ":1:1: found XML that is not well-formed"),
        ("<world/>", ":1:1: found <world>, expected <robot> (URDF), <sdf> or <mujoco> (MJCF)"),
        ("<sdf/>", ":1:1: found no model, expected exactly one non-static <model> with joints"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><robot/>', "found a document type declaration"),
        ("<a>" * 300, "found elements nested more than 200 deep"),
        ("<robot/>", ":1:1: found links that do not form a single tree"),
        (ROBOT.format('<link name="B"/>'), ":1:1: found 1 bodies that move (B), expected 4"),
        (ROBOT.format("<link/>"), ":2:3: found no name in <link>, expected one"),
        (
            ROBOT.format('<link name="B"><inertial><mass value="heavy"/></inertial></link>'),
            ":2:28: value of <mass>: found 'heavy', expected a number",
        ),
        ("<mujoco/>", ":1:1: found no <worldbody> in <mujoco>, expected one"),
    ],
)  # fmt: skip
def test_refusals_are_one_line(text, said, tmp_path, capsys):
    path = tmp_path / "bad.txt"
    path.write_text(text)
    code, out, err = run(path, "-o", tmp_path / "out.toml", capsys=capsys)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert err.startswith(f"heyoka-bike: {path}")
    assert said in err
    assert not (tmp_path / "out.toml").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('type="continuous"', 'type="prismatic"', "found a joint of type 'prismatic', expected"),
        ('<child link="F"/>', '<child link="Q"/>', "found link 'Q', expected the name of a link"),
        ('radius="0.35"', 'radius="0.36"', "lowest point -0.01 m above the rear wheel's"),
        (
            '<axis xyz="0.30901699437494742 0 -', '<axis xyz="0.30901699437494742 0.1 -',
            "found a steer axis that is horizontal or leans sideways",
        ),
        ('value="85"', 'value="-85"', "mB (mass of the rear frame with rider): found -85 kg"),
        ('ixz="-2.4"', 'ixz="-24"', "IBxz: found 24 kg m^2, expected at most the square root"),
        (
            "</robot>",
            '<link name="bell"/><joint name="b" type="revolute"><parent link="H"/>'
            '<child link="bell"/></joint></robot>',
            "found 5 bodies that move (B, R, H, F, bell), expected 4",
        ),
    ],
)  # fmt: skip
def test_models_that_are_no_bicycle_are_refused(old, new, said, bicycle, tmp_path, capsys):
    code, out, err = run(changed(tmp_path, bicycle, old, new), capsys=capsys)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert said in err


def test_what_is_no_file_is_refused(tmp_path, capsys):
    binary = tmp_path / "a"
    binary.write_bytes(b"w = 1\n\xff")
    for path, said in (
        (tmp_path / "none", "cannot be read (No such file or directory), expected a parameter"),
        (tmp_path, "found a folder, pipe or device"),
        (binary, "a:2: found a byte that is not UTF-8"),
    ):
        code, _, err = run(path, capsys=capsys)
        assert (code, err.count("\n")) == (1, 1)
        assert said in err
    with pytest.raises(InputError, match="found more than 1000000 bytes"):
        import_bicycle(_large(tmp_path))


def _large(folder):
    path = folder / "large"
    path.write_bytes(b"#" * 1_000_001)
    return path


def test_the_file_is_not_overwritten(bicycle, tmp_path, capsys):
    path = written(bicycle, tmp_path, "urdf")
    before = path.read_bytes()
    code, _, err = run(path, "-o", path, capsys=capsys)
    assert (code, path.read_bytes()) == (1, before)
    assert err.count("\n") >= 1


@given(st.text(), st.text())
@example("tab\t, line\n, DEL \x7f, NUL \0", 'C:\\bikes\\new "one".urdf')
@example("\u2028\x85", "half a surrogate \udcff")
def test_any_name_is_written_as_toml(name, source):
    bicycle = read_bicycle(find_input("bicycles", "benchmark"))
    text = Imported(replace(bicycle, name=name), (), source).toml()
    found = tomllib.loads(text)
    assert (found["name"], found["source"]) == tuple(
        x.encode("utf-8", "replace").decode() for x in (name, source)
    )
