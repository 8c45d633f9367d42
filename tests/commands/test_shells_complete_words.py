"""Shells complete commands, options, formats and files with words from the program."""

import os
import shutil
import subprocess

import pytest

from heyoka_bike.cli import main
from heyoka_bike.commands.options import SHELLS

pytest.importorskip("shtab")

TRY = """
source completion
COMP_WORDS=({words})
COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
_shtab_heyoka_bike heyoka-bike "${{COMP_WORDS[-1]}}" "${{COMP_WORDS[-2]}}"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
CHECKS = {"bash": ["-n"], "zsh": ["-n"], "fish": ["-n"], "tcsh": ["-f"]}


def completion(shell, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--print-completion", shell])
    assert ended.value.code == 0
    return capsys.readouterr().out


@pytest.mark.skipif(os.name == "nt", reason="the bash of Windows has other paths")
@pytest.mark.skipif(not shutil.which("bash"), reason="no bash")
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("heyoka-bike sc", {"score"}),
        ("heyoka-bike export --format ''", {"c", "fortran", "matlab", "json", "csv", "netcdf"}),
        ("heyoka-bike score --format j", {"json", "junit"}),
        ("heyoka-bike score --re", {"--require", "--reference"}),
        ("heyoka-bike score my-f", {"my-file.txt", "my-folder"}),
        ("heyoka-bike score --reference my", {"my-folder"}),
        ("heyoka-bike plot --figure stab", {"stability"}),
        ("heyoka-bike generate --bicycle my-b", {"my-bicycle.toml"}),
    ],
)
def test_bash_completes(words, expected, capsys, tmp_path):
    (tmp_path / "completion").write_text(completion("bash", capsys))
    (tmp_path / "my-folder").mkdir()
    for name in ("my-file.txt", "my-bicycle.toml"):
        (tmp_path / name).touch()
    run = subprocess.run(
        ["bash", "--norc", "-c", TRY.format(words=words)],
        cwd=tmp_path, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert set(run.stdout.split()) == expected, run.stderr


@pytest.mark.parametrize("shell", SHELLS)
def test_what_is_printed_is_of_that_shell(shell, capsys, tmp_path):
    text = completion(shell, capsys)
    assert "heyoka-bike" in text
    assert "certify" in text
    if shutil.which(shell):
        path = tmp_path / "completion"
        path.write_text(text)
        run = subprocess.run([shell, *CHECKS[shell], path], capture_output=True, timeout=60)
        assert (run.returncode, run.stderr) == (0, b"")


def test_another_shell_is_refused_and_guessed(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--print-completion", "bsh"])
    assert ended.value.code == 1
    assert "did you mean bash?" in capsys.readouterr().err
