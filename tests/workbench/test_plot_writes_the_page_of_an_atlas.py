"""`heyoka-bike plot --figure atlas` writes an atlas's page, or reports why it cannot."""

import json
import re
from importlib.util import find_spec

import pytest

pytest.importorskip("heyoka")


from heyoka_bike.cli import main
from heyoka_bike.errors import Exit

pytestmark = pytest.mark.skipif(
    find_spec("zarr") is None or find_spec("heyoka") is None, reason="no zarr or no heyoka"
)


@pytest.mark.proof
def test_the_page_is_of_that_atlas(small_atlas, tmp_path, capsys):
    out = tmp_path / "new" / "atlas.html"
    assert main(["plot", "--figure", "atlas", str(small_atlas), "-o", str(out)]) == Exit.OK
    assert capsys.readouterr().out == f"{out}\n"
    text = out.read_text(encoding="utf-8")
    found = json.loads(re.search(r'id="data">\n(.*?)\n<', text, re.S)[1])
    assert [axis["values"] for axis in found["axes"]] == [
        [3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
        pytest.approx([0.3, 0.9, 1.5, 2.1, 2.7, 3.3]),
    ]
    assert main(["plot", "--figure", "atlas", str(small_atlas), "-o", str(out)]) == Exit.OK
    assert out.read_text(encoding="utf-8") == text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "--figure atlas needs DIR, the folder of the atlas"),
        (["nowhere"], "nowhere: no atlas can be read"),
        (["nowhere", "--maneuver", "2"], "--maneuver cannot be used with the page of an atlas"),
        (["nowhere", "--format", "png"], "--format cannot be used with the page of an atlas"),
    ],
)
def test_bad_input_gives_one_line(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    code = main(["plot", "--figure", "atlas", "-o", "x.html", *arguments])
    error = capsys.readouterr().err
    assert code == Exit.INPUT
    assert error.startswith(f"heyoka-bike: {message}")
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
