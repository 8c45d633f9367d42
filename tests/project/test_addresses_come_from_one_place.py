"""The addresses of the repository and the site are in pyproject.toml; all pages use these."""

import re
import shutil
import subprocess
import sys

import addresses as made

OURS = re.compile(r"https://(?:github\.com/[\w.-]+|[\w.-]+\.github\.io)/heyoka_bike\b")


def test_pages_name_the_addresses_of_the_project():
    found = {
        address
        for page in made.pages()
        for address in OURS.findall(page.read_text(encoding="utf-8"))
    }
    assert found
    assert found <= {*made.addresses()}


def test_a_command_writes_others_everywhere(tmp_path):
    for page in made.pages():
        copy = tmp_path / page.relative_to(made.ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(page, copy)
    script = tmp_path / "docs" / "_site" / "addresses.py"
    script.parent.mkdir()
    shutil.copyfile(made.__file__, script)
    new = ("https://example.org/us/bicycle", "https://us.example.org/bicycle")
    subprocess.run([sys.executable, script, new[0], f"{new[1]}/"], check=True, timeout=60)
    texts = [page.read_text(encoding="utf-8") for page in made.pages(tmp_path)]
    assert made.addresses(tmp_path / "pyproject.toml") == new
    assert not any(OURS.search(text) for text in texts)
    assert not any(old in text for old in made.addresses() for text in texts)
    assert sum(text.count(new[1]) for text in texts) > 3
