"""docs/examples/checker runs correctly next to the header, and fails if the example is wrong."""

import subprocess

import numpy as np
import pytest

from generators.published_columns import published_table
from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder
from support.export_programs import need

EXAMPLES = data_folder().parent / "docs" / "examples" / "checker"
LIBRARY = "cc -std=c99 -O1 -shared -fPIC library.c -o libbicycle.so -lm"
LANGUAGES = {
    "C++": (("cmake", "ctest"), "test_my_bicycle.cpp",
            "cmake -B build && cmake --build build && ctest --test-dir build -V"),
    "Fortran": (("gfortran",), "my_bicycle.f90",
                "cc -std=c99 -O1 -c library.c && gfortran -Wall -Werror my_bicycle.f90 library.o "
                "-lm -o my_bicycle && ./my_bicycle"),
    "Python": (("python3",), "my_bicycle.py", f"{LIBRARY} && python3 -I my_bicycle.py"),
    "Rust": (("rustc",), "my_bicycle.rs",
             f"{LIBRARY} && rustc -L . my_bicycle.rs && LD_LIBRARY_PATH=. ./my_bicycle"),
}  # fmt: skip


def shell(line, folder):
    return subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True,
                          timeout=300)  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    for path in EXAMPLES.iterdir():
        (tmp_path / path.name).write_text(path.read_text())
    assert main(["export", "--checker", "-o", f"{tmp_path}/"]) == 0
    return tmp_path


@pytest.mark.proof
@pytest.mark.parametrize("language", LANGUAGES)
def test_an_example_passes_and_fails_as_it_should(language, folder):
    tools, name, line = LANGUAGES[language]
    for tool in ("cc", *tools):
        need(tool)
    done = shell(line, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "right; the worst column " in done.stdout
    text = (folder / name).read_text()
    small = "1.0e-9" if language == "Fortran" else "1e-9"
    assert text.count(small) == 1
    (folder / name).write_text(text.replace(small, small.replace("-9", "-5")))
    done = shell(line, folder)
    assert done.returncode != 0
    assert "close; the worst column " in done.stdout


@pytest.mark.slow
def test_catch2_names_the_columns_that_are_wrong(folder):
    for tool in ("cmake", "ctest"):
        need(tool)
    line = "cmake -B build && cmake --build build && ctest --test-dir build -V -R catch"
    done = shell(line, folder)
    if "No tests were found" in done.stdout + done.stderr:
        pytest.skip("Catch2 is not installed")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "All tests passed (27 assertions in 1 test case)" in done.stdout
    path = folder / "catch_my_bicycle.cpp"
    text = path.read_text()
    assert text.count("* (1 +") == 1
    path.write_text(text.replace("* (1 +", "* (1 + (i == 6) * 1e-5 +"))
    done = shell(line, folder)
    assert done.returncode != 0
    assert "assertions: 27 | 21 passed | 6 failed" in done.stdout
    assert done.stdout.count("found.digits >= 6") == 3


@pytest.mark.proof
def test_octave_passes_and_fails_as_it_should(folder, reference):
    for tool in ("octave-cli", "mkoctfile"):
        need(tool)
    line = "mkoctfile --mex check_bicycle.c && octave-cli --norc my_bicycle.m"
    table = published_table(reference)
    np.savetxt(folder / "my-results.txt", table)
    done = shell(line, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "right; the worst column has 14.0" in done.stdout
    table[:, 1:] *= 1 + 1e-5
    np.savetxt(folder / "my-results.txt", table)
    assert shell(line, folder).returncode == 1
