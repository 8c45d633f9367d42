"""The outputs in the pages of the documentation are those of the commands above them."""

import pytest

from addresses import addresses
from blocks import BLOCK, committed, options, without_outputs
from outputs import DOCS, filled

_, SITE = addresses()

PAGE = """# A page

```{run} shown
echo one > file; cat file
```

```{run} python shown
print(open("file").read() * 2)
```

```text
something else
```

```{run} shown figure=a.svg alt="A"
false
```

![A](a.png)

```{run} python modules=no_such_module,os
import no_such_module
```

```{run} needs=no-such-program
no-such-program
```

```{run} code=3
exit 3
```

```text
no output
```
"""


def test_outputs_are_written_and_left_out_by_the_site():
    page = filled(PAGE)
    assert committed(page, "echo one > file; cat file\n") == "one"
    assert committed(page, 'print(open("file").read() * 2)') == "one\none"
    assert "something else" not in page
    assert filled(page) == page
    bare = without_outputs(page)
    assert "one\none" not in bare
    assert "![A]" not in bare
    assert bare.endswith("no output\n```\n")
    assert filled("```{run} shown\ntrue\n```\n") == "```{run} shown\ntrue\n```\n"
    assert [line for line in bare.splitlines() if "{run}" in line] == [
        line for line in PAGE.splitlines() if "{run}" in line
    ]


def test_a_block_that_fails_is_named():
    with pytest.raises(SystemExit, match="exit code 3 of\nexit 3"):
        filled("```{run}\nexit 3\n```\n")


EVERY = [page for page in sorted(DOCS.rglob("*.md")) if BLOCK.search(page.read_text("utf-8"))]


@pytest.mark.parametrize("page", EVERY, ids=lambda p: str(p.relative_to(DOCS)))
def test_every_block_that_prints_has_its_output_below(page):
    """Instead of the output, a block that needs another program may have a link to
    the built page."""
    text = page.read_text(encoding="utf-8")
    there = f"{SITE}/{page.relative_to(DOCS).with_suffix('.html').as_posix()}"
    for found in BLOCK.finditer(text):
        asked = options(found["asked"])
        if "shown" in asked:
            assert found["below"] or ("needs" in asked and there in text), found["source"]


# These are the pages that a new user reads first. The outputs of all pages are compared when the
# site is built.
@pytest.mark.proof
@pytest.mark.parametrize("name", ["start.md", "diagnosis.md", "check.md"])
def test_outputs_are_what_the_commands_print(name):
    text = (DOCS / name).read_text(encoding="utf-8")
    assert filled(text) == text, "run python docs/_site/outputs.py"
