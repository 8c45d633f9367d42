"""libFuzzer with sanitizers finds no input that breaks the header of ``export --checker``.

For a longer run use ``-max_total_time=600`` instead of ``-runs``.
"""

import shutil
import subprocess
from pathlib import Path
from random import Random

import pytest

from heyoka_bike.cli import main

TARGET = Path(__file__).parents[1] / "support" / "fuzz_header.c"
FLAGS = (
    "-g", "-O2", "-fsanitize=fuzzer,address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=all",
)  # fmt: skip

pytestmark = pytest.mark.proof


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    if (clang := shutil.which("clang")) is None:
        pytest.skip("clang is not installed")
    folder = tmp_path_factory.mktemp("fuzz")
    (folder / "empty.c").write_text(
        "#include <stddef.h>\nint LLVMFuzzerTestOneInput(const unsigned char *x, size_t n)"
        "{ return (void)x, (void)n, 0; }\n"
    )
    if subprocess.run([clang, *FLAGS, "empty.c"], cwd=folder, capture_output=True).returncode:
        pytest.skip(
            "clang has no libFuzzer: apt install libclang-rt-14-dev, or that of its version"
        )
    assert main(["export", "--checker", "-o", f"{folder}/"]) == 0
    command = [clang, *FLAGS, f"-I{folder}", str(TARGET), "-o", "fuzz", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "fuzz"


def test_no_input_breaks_it(program):
    corpus, random = program.parent / "corpus", Random(1)
    corpus.mkdir()
    for i in range(60):
        (corpus / f"{i}").write_bytes(random.randbytes(random.randint(20, 600)))
    asked = ("-runs=600", "-seed=1", "-max_len=1000", "-len_control=0", "-detect_leaks=0")
    run = subprocess.run(
        [program, *asked, corpus], cwd=program.parent, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr[-4000:]
    assert "Done 6" in run.stderr
