"""``heyoka-bike export`` as a user runs it: file names, contents, refusals, and a full disk."""

import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.cli import main
from support.export_programs import STEM, need
from support.without_packages import HEAVY, python

FILES = {
    "c": (".c", ".h"), "fortran": (".f90",), "matlab": (".m",), "json": (".json",),
    "csv": (".csv",), "netcdf": (".nc",),
}  # fmt: skip


def run(*arguments, capsys):
    code = main(["export", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.parametrize("name", FILES)
def test_files_go_into_the_folder_and_are_named(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code, out, err = run("--format", name, capsys=capsys)
    assert (code, err) == (0, "")
    assert out.splitlines() == [STEM + suffix for suffix in FILES[name]]
    assert sorted(p.name for p in tmp_path.iterdir()) == out.split()
    # Write to a new folder, and to a folder whose name contains a dot.
    for folder in ("new/inner", "v1.0/"):
        assert run("--format", name, "-o", folder, capsys=capsys)[0] == 0
        for suffix in FILES[name]:
            made = tmp_path / folder / (STEM + suffix)
            assert made.read_bytes() == (tmp_path / (STEM + suffix)).read_bytes()


@pytest.mark.parametrize("name", FILES)
def test_every_file_says_what_it_is(name, tmp_path, reference, capsys):
    options = ("--columns", "yaw,roll_angle_zyx", "--maneuver", "2")
    assert run("--format", name, "-o", tmp_path, *options, capsys=capsys)[0] == 0
    for suffix in FILES[name]:
        path = tmp_path / (STEM + suffix)
        if name == "netcdf":
            with h5py.File(path) as f:
                text = f.attrs["comment"]
        else:
            # The description is at the beginning of the file, before the first number.
            text = path.read_text("ascii")[:2500].partition('"schema_version"')[0]
        words = " ".join(text.replace('",\n  "', " ").replace("\n", " ").split())
        words = " ".join(w for w in words.split() if w not in ("//", "!", "%", "#"))
        for expected in (
            "Uncontrolled bicycle", reference.dataset_version, reference.content_sha256,
            "MIT, Copyright", "SI units", "positive to the right",
            "2: 'maneuver 2', forward speed 23/5 m/s",
            "yaw [rad]: yaw angle: direction of the heading from the initial one",
            "roll_angle_zyx [rad]: roll angle: roll of the rear frame's attitude R = Rz Ry Rx",
        ):  # fmt: skip
            assert expected in words, expected
        assert "maneuver 1" not in words
        assert "steer_rate" not in words


EQUATIONS = {
    "c": (".c", ".h"), "fortran": (".f90",), "matlab": (".m",), "julia": (".jl",),
    "python": (".py",), "rust": (".rs",),
}  # fmt: skip


@pytest.mark.parametrize("language", EQUATIONS)
def test_equations_of_any_bicycle_and_maneuvers(language, tmp_path, capsys):
    options = ("--bicycle", "pista", "--maneuvers", "benchmark", "-o", tmp_path)
    assert run("--equations", language, *options, capsys=capsys)[0] == 0
    written = {p.suffix: p.read_text("ascii") for p in tmp_path.iterdir()}
    assert set(written) == set(EQUATIONS[language])
    assert {p.stem for p in tmp_path.iterdir()} == {"bicycle"}
    for text in written.values():
        assert "rR = 0.332088156971 m: radius of the rear wheel" in text
        assert "MIT, Copyright" in text
        assert "'maneuver 3': forward speed 8 m/s, roll rate 0.05 rad/s" in text
        assert ("residual_3" in text) is (language in ("c", "python"))


MODELS = {"urdf": ".urdf", "sdf": ".sdf", "mjcf": ".xml"}


@pytest.mark.parametrize("name", MODELS)
def test_models_of_any_bicycle_and_maneuvers(name, tmp_path, capsys):
    options = ("--bicycle", "pista", "--maneuvers", "benchmark", "-o", tmp_path)
    assert run("--model", name, *options, capsys=capsys)[0] == 0
    (path,) = tmp_path.iterdir()
    assert path.name == f"bicycle{MODELS[name]}"
    text = path.read_text("ascii")
    assert "rR = 0.332088156971 m: radius of the rear wheel" in text
    assert "MIT, Copyright" in text
    assert "start_3: 'maneuver 3'" in text


@pytest.mark.parametrize(
    ("width", "said"),
    [
        ("-0.01", "found '-0.01', expected zero or more, without pi"),
        ("pi/100", "found 'pi/100', expected zero or more, without pi"),
        ("thin", "found 'thin', expected a decimal number or an expression"),
    ],
)
def test_a_width_that_is_none_is_refused(width, said, tmp_path, capsys):
    code, _, err = run("--model", "sdf", f"--tyre={width}", "-o", tmp_path, capsys=capsys)
    assert (code, err.count("\n")) == (1, 1)
    assert f"heyoka-bike: --tyre: {said}" in err
    assert not list(tmp_path.iterdir())


def test_what_engines_refuse_is_said(tmp_path, capsys):
    options = ("--model", "mjcf", "--bicycle", "two-mass-skate", "-o", tmp_path)
    code, _, err = run(*options, capsys=capsys)
    assert code == 0
    assert "inertia matrix of B is only semidefinite: most engines refuse this" in err
    assert "R has no mass: most engines refuse this or change it\n" in err
    assert err.endswith(
        "use --nearest-valid-inertia to write the nearest bicycle that every engine loads\n"
    )
    assert run("--model", "mjcf", "-o", tmp_path, capsys=capsys)[2] == ""


def test_julia_is_well_formed(tmp_path, capsys):
    """Only a parser checks the source: neither Debian nor PyPI has a package of Julia."""
    julia = pytest.importorskip("tree_sitter_julia", reason="tree-sitter-julia is not installed")
    sitter = pytest.importorskip("tree_sitter", reason="tree-sitter is not installed")
    assert run("--equations", "julia", "-o", tmp_path, capsys=capsys)[0] == 0
    text = (tmp_path / "bicycle.jl").read_bytes()
    parser = sitter.Parser(sitter.Language(julia.language()))
    assert not parser.parse(text).root_node.has_error
    assert parser.parse(text.replace(b"return f", b"return (f", 1)).root_node.has_error


def test_comments_tell_how_to_compile(tmp_path, capsys):
    expected = {
        "c": "cc -std=c99 -O2 your-code.c selection.c -lm",
        "fortran": "gfortran -O2 selection.f90 your-code.f90",
        "matlab": "selection(1, 'roll_angle', 0:0.01:1)",
    }
    for name, line in expected.items():
        output = tmp_path / f"selection{FILES[name][0]}"
        assert run("--format", name, "-o", output, capsys=capsys)[0] == 0
        assert line in output.read_text()
    assert '#include "selection.h"' in (tmp_path / "selection.c").read_text()
    assert "function values = selection(" in (tmp_path / "selection.m").read_text()


def test_the_header_is_for_cpp_too(tmp_path, capsys):
    assert run("--format", "c", "-o", tmp_path, capsys=capsys)[0] == 0
    (tmp_path / "main.cpp").write_text(
        f'#include "{STEM}.h"\nint main() {{ return bicycle_evaluate(1, 0, 0.0) != 0.0; }}\n'
    )
    strict = ["-Wall", "-Wextra", "-pedantic", "-Werror"]
    for command in (
        [need("gcc"), "-std=c99", "-c", f"{STEM}.c"],
        [need("g++"), "-std=c++98", *strict, "-Wno-comment", "main.cpp", f"{STEM}.o"],
        ["./a.out"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True, timeout=120)


def test_the_same_options_write_the_same_bytes(tmp_path, capsys):
    for name in FILES:
        for folder in ("a", "b"):
            assert run("--format", name, "-o", tmp_path / folder, capsys=capsys)[0] == 0
        for suffix in FILES[name]:
            a, b = ((tmp_path / x / (STEM + suffix)).read_bytes() for x in "ab")
            assert a == b, name


def test_columns_are_the_benchmarks_or_all_or_those_named(tmp_path, capsys):
    for options, names in (
        ((), BENCHMARK_COLUMNS),
        (("--columns", "all"), [c.name for c in COLUMNS]),
        (("--columns", "yaw, roll_angle,yaw"), ["yaw", "roll_angle"]),
    ):
        assert run("--format", "fortran", "-o", tmp_path, *options, capsys=capsys)[0] == 0
        lines = (tmp_path / f"{STEM}.f90").read_text().splitlines()
        found = [x.split("::")[1].split()[0] for x in lines if "parameter, public" in x]
        assert found == [f"bicycle_{name}" for name in names]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "one of the arguments --format --equations --model --checker --page"),
        (["--format", "cobol"], "found 'cobol', expected one of c, fortran, matlab, json, csv"),
        (["--format", "c", "--maneuver", "4"], "--maneuver: found 4, expected 1 to 3"),
        (["--format", "c", "--columns", "roll"], "found 'roll', expected all or some of roll_an"),
        (["--format", "c", "--columns", ""], "found '', expected all or some of roll_angle"),
        (["--format", "c", "--columns", "yaw,"], "found '', expected all or some of roll_angle"),
        (["--format", "c", "--digits", "32"], "--digits needs --format csv"),
        (["--format", "csv", "--digits", "20"], "--digits: found 20, expected 17 or 32"),
        (["--format", "c", "-o", "x.cpp"], "found 'x.cpp', expected a file ending in .c or .h"),
        (["--format", "json", "-o", "x.txt"], "found 'x.txt', expected a file ending in .json"),
        (["--format", "matlab", "-o", "2b.m"], "found '2b', expected the name of a function"),
        (["--format", "c", "-o", 'a"b.c'], "expected a name of letters, digits and _ + - ."),
        (["--format", "csv", "-o", "-"], "found '-', expected a file or a folder"),
        (["--format", "csv", "-o", "/proc/nowhere/x.csv"], "/proc/nowhere/x.csv: cannot be"),
        (["--format", "csv", "-o", "file/x.csv"], "file/x.csv: cannot be written: "),
        (
            ["--format", "csv", "-o", "file"],
            "found 'file', expected a file ending in .csv, or a folder",
        ),
        (["--format", "csv", "-o", "there"], "cannot be written: Is a directory"),
        (["--format", "csv", "-o", "x" * 300 + ".csv"], "cannot be written: File name too long"),
        (["--format", "csv", "--reference", "there"], "no manifest.json found, expected a folder"),
        (["--format", "c", "--equations", "c"], "--equations: not allowed with argument --format"),
        (["--format", "c", "--bicycle", "pista"], "--bicycle cannot be combined with --format"),
        (["--equations", "c", "--digits", "32"], "--digits cannot be combined with --equations"),
        (
            ["--equations", "c", "--reference", "x"],
            "--reference cannot be combined with --equations",
        ),
        (["--checker", "--digits", "17"], "--digits cannot be combined with --checker"),
        (["--checker", "--page"], "--page: not allowed with argument --checker"),
        (["--checker", "-o", "x.c"], "found 'x.c', expected a file ending in .h, or a folder"),
        (["--page", "--reference", "x"], "--reference cannot be combined with --page"),
        (["--page", "-o", "x.txt"], "found 'x.txt', expected a file ending in .html"),
        (["--equations", "cpp"], "'cpp', expected one of c, fortran, matlab, julia, python, rust"),
        (["--equations", "rust", "-o", "x.c"], "found 'x.c', expected a file ending in .rs"),
        (["--equations", "python", "-o", "1st.py"], "found '1st', expected the name of a module"),
        (
            ["--equations", "matlab", "-o", "if.m"],
            "'if' is a reserved word, expected another name of a module",
        ),
        (["--equations", "rust", "-o", "fn.rs"], "'fn' is a reserved word"),
        (["--equations", "fortran", "-o", "Sin.f90"], "'Sin' is a name in the code itself"),
        (["--equations", "julia", "-o", "rates.jl"], "'rates' is a name in the code itself"),
        (["--equations", "c", "--bicycle", "no-one"], "bicycle: found 'no-one', expected"),
        (["--equations", "c", "--maneuvers", "no-one"], "maneuvers: found 'no-one', expected"),
    ],
)
def test_refusals_are_one_line_and_leave_nothing(
    arguments, expected, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("old")
    Path("there", f"{STEM}.csv").mkdir(parents=True)
    before = sorted(tmp_path.rglob("*"))
    try:
        code, out, err = run(*arguments, capsys=capsys)
    except SystemExit as e:
        code, (out, err) = e.code, capsys.readouterr()
    assert (code, out) == (1, "")
    assert expected in err
    assert err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before
    assert Path("file").read_text() == "old"


def test_a_damaged_set_is_refused(folder, tmp_path, capsys):
    damaged = tmp_path / "set"
    shutil.copytree(folder, damaged)
    path = damaged / "uncontrolled-bicycle.h5"
    path.write_bytes(path.read_bytes()[:-1])
    out = tmp_path / "out"
    code, _, err = run("--format", "c", "--reference", damaged, "-o", out, capsys=capsys)
    assert code == 1
    assert "does not match manifest.json" in err
    assert err.count("\n") == 1
    assert not out.exists()


def test_a_folder_without_the_right_to_write(tmp_path, capsys, monkeypatch):
    """The test replaces the error of the system, because the superuser may write to read-only
    folders."""
    usual = Path.open

    def refuse(path, *args, **kwargs):
        if path.parent == tmp_path:
            raise PermissionError(13, "Permission denied", str(path))
        return usual(path, *args, **kwargs)

    monkeypatch.setattr(Path, "open", refuse)
    code, out, err = run("--format", "c", "-o", tmp_path / "selection.c", capsys=capsys)
    assert (code, out) == (1, "")
    assert err == f"heyoka-bike: {tmp_path / 'selection.c'}: cannot be written: Permission denied\n"


def test_files_that_belong_together_are_replaced_together(tmp_path, capsys):
    (tmp_path / "selection.c").write_text("old")
    (tmp_path / "selection.h").mkdir()
    code, out, err = run("--format", "c", "-o", tmp_path / "selection.c", capsys=capsys)
    assert (code, out) == (1, "")
    assert err == f"heyoka-bike: {tmp_path / 'selection.h'}: cannot be written: Is a directory\n"
    assert (tmp_path / "selection.c").read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["selection.c", "selection.h"]


def limited(shell, name, output):
    """Export in a separate process, after a line of shell code."""
    command = [sys.executable, "-m", "heyoka_bike", "export", "--format", name, "-o", str(output)]
    return subprocess.run(
        ["bash", "-c", f'{shell}; exec "$@"', "bash", *command],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip


# Test one format that consists of two files, and one format that a library writes.
@pytest.mark.parametrize("name", ["c", "netcdf"])
def test_a_file_that_may_not_grow_leaves_the_old_ones(name, tmp_path):
    selection = [tmp_path / f"selection{suffix}" for suffix in FILES[name]]
    for path in selection:
        path.write_text("old")
    done = limited("ulimit -f 64", name, selection[0])
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"heyoka-bike: {selection[0]}: cannot be written: File too large\n"
    assert sorted(tmp_path.iterdir()) == sorted(selection)
    assert all(path.read_text() == "old" for path in selection)


@pytest.fixture
def small_disk(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(disk)], capture_output=True
    )
    if mounted.returncode:
        pytest.skip("mounting a small disk is not allowed here")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.skipif(sys.platform != "linux", reason="mounts a tmpfs")
@pytest.mark.parametrize("name", FILES)
def test_a_full_disk_leaves_nothing(name, small_disk, capsys):
    old = small_disk / f"{STEM}{FILES[name][-1]}"
    old.write_text("old")
    code, out, err = run("--format", name, "-o", small_disk, capsys=capsys)
    assert (code, out) == (1, "")
    assert err.endswith("cannot be written: No space left on device\n")
    assert err.count("\n") == 1
    assert list(small_disk.iterdir()) == [old]
    assert old.read_text() == "old"


def test_exporting_needs_numpy_and_h5py_only(tmp_path):
    code = f"""
from heyoka_bike.cli import main
for name in {list(FILES)}:
    assert main(["export", "--format", name, "-o", {str(tmp_path)!r}]) == 0
"""
    done = python(code, HEAVY)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("kind", "suffix"), [("--page", ".html"), ("--checker", ".h")])
def test_page_and_checker_take_the_place_behind_them(kind, suffix, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(kind, "new/inner", capsys=capsys)[:2] == (0, f"new/inner/{STEM}{suffix}\n")
    assert run(kind, f"mine{suffix}", capsys=capsys)[:2] == (0, f"mine{suffix}\n")
    assert run(kind, "", capsys=capsys)[:2] == (0, f"{STEM}{suffix}\n")
    code, _, err = run(kind, "a", "-o", "b", capsys=capsys)
    assert code == 1
    assert err == f"heyoka-bike: {kind}: found 'a' and -o 'b', expected one of them\n"
    assert not (tmp_path / "a").exists()
