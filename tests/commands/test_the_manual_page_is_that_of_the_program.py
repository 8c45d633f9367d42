"""The manual page and the list of environment variables agree with the program."""

import re
import shutil
import subprocess

import pytest

import heyoka_bike
import man_page
from heyoka_bike.cli import ENVIRONMENT, main, parser
from heyoka_bike.system.resources import data_folder

PACKAGE = data_folder().parent / "heyoka_bike"
READ = re.compile(r"environ(?:\.get\(|\.setdefault\(|\[)\s*\"?([A-Za-z_]+)")


def test_the_page_is_that_of_the_parser():
    assert man_page.page() == man_page.PAGE.read_text(encoding="utf-8"), (
        "run python docs/_site/man_page.py"
    )


def test_every_command_and_option_is_on_it():
    text = man_page.PAGE.read_text(encoding="utf-8").replace(r"\-", "-")
    for action in parser()._actions:
        for name, command in (action.choices or {}).items() if action.nargs == "A..." else ():
            assert f".SS {name}\n" in text
            for option in command._actions:
                assert all(f"\\fB{x}\\fR" in text for x in option.option_strings)
    assert heyoka_bike.__version__ in text


@pytest.mark.skipif(not shutil.which("mandoc"), reason="no mandoc")
def test_mandoc_reads_it():
    run = subprocess.run(
        ["mandoc", "-Tlint", "-Wwarning", man_page.PAGE], capture_output=True, text=True, timeout=60
    )
    # No version has been published yet, so the page has no date.
    assert [line for line in run.stdout.splitlines() if "missing date" not in line] == []


def test_every_variable_that_is_read_is_told(capsys):
    text = "\n".join(path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py"))
    read = {name for name in READ.findall(text) if name.isupper()}
    # The pages also contain VARIABLE, which is the name of a constant and not of a variable.
    assert read - {"VARIABLE"} == set(ENVIRONMENT)
    with pytest.raises(SystemExit):
        main(["--help"])
    out = capsys.readouterr().out
    assert all(f"  {name} " in out for name in ENVIRONMENT)
