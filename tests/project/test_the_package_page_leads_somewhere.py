"""On a package index, every link and image of the README works or is left out."""

import importlib.util
import re
from pathlib import Path

import pytest

from addresses import addresses

ROOT = Path(__file__).resolve().parents[2]
REPOSITORY, SITE = "https://example.org/someone/bicycle", "https://someone.example.org/bicycle"
TAG = "v1.2.3"

MIXED = """\
[![shot](docs/a.png "the shot")](docs/b.md#part) and ![plain](a.svg), see [b *c*](b.md), [on](#on),
[out](https://example.org/x) <a href="docs/d.md"><img width="9" src="d.png"></a>

```sh
echo "[not](a.link)"
```
"""


@pytest.fixture(scope="module")
def made():
    spec = importlib.util.spec_from_file_location("package_page", ROOT / ".ci/package_page.py")
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def targets(text):
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.findall(r"\]\(([^)\s]+)", text) + re.findall(r"\b(?:src|href)=\"([^\"]*)\"", text)


def test_with_an_address_nothing_is_relative(made):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    before, after = targets(readme), targets(made.page(readme, REPOSITORY, TAG))
    assert len(before) == len(after) > 10
    for old, new in zip(before, after, strict=True):
        if old.startswith(("https:", "#")):
            assert new == old
            continue
        kind, _, path = new.removeprefix(f"{REPOSITORY}/").partition(f"/{TAG}/")
        assert path == old
        assert (ROOT / path.partition("#")[0]).exists()
        assert kind == ("raw" if path.endswith((".svg", ".png", ".gif")) else "blob")


def test_without_an_address_nothing_leads_nowhere(made):
    text = made.page((ROOT / "README.md").read_text(encoding="utf-8"), "", TAG)
    assert all(target.startswith(("https:", "#")) for target in targets(text))
    assert "](" not in re.sub(r"\]\((?:https:|#)", "", text)


def test_images_in_links_and_tags_are_told_apart(made):
    full = made.page(MIXED, REPOSITORY, TAG)
    raw, blob = f"{REPOSITORY}/raw/{TAG}", f"{REPOSITORY}/blob/{TAG}"
    assert f'[![shot]({raw}/docs/a.png "the shot")]({blob}/docs/b.md#part)' in full
    assert f"![plain]({raw}/a.svg), see [b *c*]({blob}/b.md), [on](#on)" in full
    assert f'<a href="{blob}/docs/d.md"><img width="9" src="{raw}/d.png"></a>' in full
    assert 'echo "[not](a.link)"' in full
    bare = made.page(MIXED, "", TAG)
    assert bare.startswith(" and , see b *c*, [on](#on),\n[out](https://example.org/x) \n")
    assert 'echo "[not](a.link)"' in bare


def test_the_addresses_that_are_told_replace_the_placeholders(made):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for placeholder, address in zip(addresses(), (REPOSITORY, SITE), strict=True):
        assert placeholder in readme
        full, bare = (made.told(readme, placeholder, x) for x in (address, ""))
        assert placeholder not in full
        assert full.count(address) == readme.count(placeholder)
        assert f"]({placeholder}" not in bare
    assert made.told("[a](x/b) `x/c` [d](y)", "x", "") == "a `x/c` [d](y)"


def test_only_addresses_that_are_told_are_given(made):
    assert made.addresses("", TAG) == {}
    assert made.addresses("", TAG, SITE) == {"Documentation": f"{SITE}/"}
    assert all(x.startswith(REPOSITORY) for x in made.addresses(REPOSITORY, TAG).values())
