"""`heyoka-bike --cite` prints the content of CITATION.cff, as text and for BibTeX."""

import re
from pathlib import Path

import pytest

pytest.importorskip("yaml")

import yaml

from heyoka_bike.cli import main
from heyoka_bike.commands.citation import works
from heyoka_bike.reference.manifest import PUBLISHED_VERSION
from heyoka_bike.version import __version__

CFF = yaml.safe_load((Path(__file__).resolve().parents[2] / "CITATION.cff").read_text())


def said_of(entry):
    names = [a.get("name") or f"{a['family-names']}, {a['given-names']}" for a in entry["authors"]]
    return tuple(names), entry["title"]


def test_it_agrees_with_the_citation_file():
    program, data, *others = works()
    assert said_of(CFF) == (program.authors, program.fields["title"])
    assert str(CFF["version"]) == program.fields["version"] == __version__
    assert PUBLISHED_VERSION in data.fields["howpublished"]
    known = {said_of(entry): entry for entry in CFF["references"]}
    for work in (data, *others):
        entry = known[work.authors, work.fields["title"]]
        for field in work.fields.keys() & {"journal", "doi"}:
            assert entry[field] == work.fields[field]
        assert str(entry.get("year", entry.get("date-released")))[:4] == work.fields["year"]


def test_both_forms_are_printed(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--cite"])
    assert ended.value.code == 0
    out = capsys.readouterr().out
    text, _, bibtex = out.partition("\n\n")
    for work in works():
        assert work.fields["title"] in " ".join(text.split())
        (entry,) = re.findall(r"^@\w+{\w+,\n.*?^}$", work.bibtex, re.M | re.S)
        assert entry in bibtex
        assert f"title = {{{{{work.fields['title']}}}}}" in entry
    assert "author = {{The heyoka_bike developers}}" in bibtex
    assert "author = {Biscani, Francesco and Izzo, Dario}" in bibtex
    assert max(map(len, text.splitlines())) <= 100
