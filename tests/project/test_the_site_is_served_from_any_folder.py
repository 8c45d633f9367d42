"""The judge, data and schemas are next to the pages; links also work if the site is
in a subfolder."""

import json
import re
import shutil
import subprocess
from decimal import Decimal
from hashlib import sha256

import jsonschema
import pytest
import yaml

from beside_pages import CITED, EXAMPLE, write
from certified_texts import DIGITS, rounded
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder
from support.browser import browser
from support.pages import Page
from support.site import broken, served

ROOT = data_folder().parent
FOLDER = "some/where"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The root of a server with the site in a subfolder. Its pages are replaced by stand-ins."""
    root = tmp_path_factory.mktemp("site")
    write(root / FOLDER)
    for page in ("index.html", "files.html"):
        (root / FOLDER / page).write_text("<p>", "ascii")
    return root


@pytest.fixture(scope="module")
def rows(reference):
    text = (reference.folder / "uncontrolled-bicycle-50digits.txt").read_text("ascii")
    return {cells[0]: cells[1:] for cells in map(str.split, text.splitlines())}


def test_the_judge_is_the_page_that_export_writes(site, tmp_path):
    assert main(["export", "--page", "-o", f"{tmp_path}/"]) == 0
    judge = site / FOLDER / "judge"
    made = (tmp_path / "uncontrolled_bicycle.html").read_bytes()
    assert (judge / "index.html").read_bytes() == made
    assert main(["score", str(judge / EXAMPLE)]) == 0
    assert b"bicycle_judge" in (judge / "uncontrolled_bicycle.h").read_bytes()


def test_the_data_are_the_reference_with_its_hashes(site, folder):
    data = site / FOLDER / "data"
    listed = dict(
        reversed(line.split("  ")) for line in (data / "SHA256SUMS").read_text("ascii").splitlines()
    )
    names = {
        path.relative_to(data).as_posix() for path in data.rglob("*") if path.is_file()
    } - {"SHA256SUMS", "index.html"}  # fmt: skip
    assert names == {*listed}
    for name, digest in listed.items():
        assert sha256((data / name).read_bytes()).hexdigest() == digest
    manifest = json.loads((data / "manifest.json").read_text(encoding="utf-8"))
    hashes = {entry["file"]: entry["sha256"] for entry in manifest["files"]}
    assert hashes.items() <= listed.items()
    page = (data / "index.html").read_text(encoding="utf-8")
    assert all(digest in page for digest in listed.values())


def test_the_schema_is_that_of_a_score(site, tmp_path):
    schema = json.loads((site / FOLDER / "score.schema.json").read_text(encoding="utf-8"))
    out = tmp_path / "score.json"
    assert main(["score", str(data_folder() / "peers" / EXAMPLE), "-o", str(out)]) == 0
    jsonschema.validate(json.loads(out.read_text(encoding="utf-8")), schema)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_plain_pages_have_the_digits_of_the_text(site, rows, number):
    text = (site / FOLDER / "data" / f"maneuver-{number}.txt").read_text("ascii")
    lines = text.splitlines()
    first, last = map(int, re.search(r"lines (\d+) to (\d+)", text).groups())
    assert lines[first - 3].split() == ["time", *BENCHMARK_COLUMNS]
    values = [line.split() for line in lines[first - 1 : last]]
    assert lines[last:] == []
    assert [row[0] for row in values] == [f"{Decimal(i) / 2:f}" for i in range(21)]
    for time, *found in values:
        exact = rows[time][8 * (number - 1) : 8 * number]
        for written, value in zip(found, exact, strict=True):
            assert len(re.sub(r"e.*|[-.]", "", written)) == DIGITS
            error = abs(Decimal(written) - Decimal(value))
            unit = Decimal(written).adjusted() - DIGITS + 1
            assert error <= Decimal((0, (5,), unit - 1))


def test_digits_that_are_not_decided_are_refused():
    assert rounded("1.23456789012345499e-2") == "1.23456789012345e-2"
    assert rounded("0") == "0.00000000000000e+0"
    for text in ("1.234567890123455", "1.2345678901234"):
        with pytest.raises(ValueError, match="expected digits that decide 15"):
            rounded(text)


@pytest.mark.proof
def test_links_of_these_parts_resolve_in_a_subfolder(site):
    with served(site) as address:
        checked, found = broken(address, f"/{FOLDER}/", [f"/{FOLDER}/data/", f"/{FOLDER}/judge/"])
        assert found == []
        assert len(checked) > 20
        # The check must find broken links, and links that leave the folder.
        bad = site / FOLDER / "bad.html"
        bad.write_text('<a href="no.html"><a href="#no"><a href="/x"><a href="#p" id="p">', "ascii")
        _, found = broken(address, f"/{FOLDER}/", [f"/{FOLDER}/bad.html"])
        bad.unlink()
        assert [link for _, link in found] == ["no.html", "#no", "/x"]


@browser
def test_an_address_shows_its_value_with_all_digits(site, rows, visited):
    maneuver, column, time = re.fullmatch(r"(\d)\.(\w+)@(.+)", CITED).groups()
    value = rows[time][8 * (int(maneuver) - 1) + BENCHMARK_COLUMNS.index(column)]
    with served(site) as address:
        page = f"{address}/{FOLDER}/data/"
        for within, shown in (
            (f"#{CITED}", f'id="value">{value}<'),
            (f"#{CITED}0", f'id="value">{value}<'),
            ("#2.roll_angle@7.315", "has no row at 7.315 s"),
            ("#4.roll_angle@1", "expected a maneuver from 1 to 3"),
        ):
            is_told = f"document.documentElement.innerHTML.includes({json.dumps(shown)})"
            visited(f"{page}{within}", until=is_told)
        assert 'id="value"></code>' in visited(page).content()


def test_the_page_of_data_loads_nothing_from_elsewhere(site):
    text = (site / FOLDER / "data" / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    (policy,) = [a["content"] for a in page.all("meta") if "http-equiv" in a]
    assert policy.startswith("default-src 'none'; connect-src 'self'; img-src data:;")
    assert not re.search(r"(?:src|href)=\"https?:", text)
    named = {a["for"] for a in page.all("label")}
    assert {a["id"] for a in [*page.all("input"), *page.all("select")]} == named


def test_the_workflow_publishes_what_the_command_of_contributing_builds():
    flow = yaml.safe_load((ROOT / ".github/workflows/pages.yml").read_text(encoding="utf-8"))
    build, deploy = flow["jobs"]["build"]["steps"], flow["jobs"]["deploy"]["steps"]
    command = re.search(r"grep -m1 -- '(.*)\$' CONTRIBUTING.md", build[2]["run"])[1]
    lines = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()
    (line,) = [line for line in lines if line.endswith(command)]
    assert " -W " in line
    assert build[-1]["with"]["path"] == line.split()[-1]
    assert [step["uses"].partition("@")[0] for step in (build[-1], deploy[-1])] == [
        "actions/upload-pages-artifact", "actions/deploy-pages",
    ]  # fmt: skip
    used = [step["uses"] for step in (*build, *deploy) if "uses" in step]
    assert all(re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", use) for use in used)


@pytest.mark.skipif(not shutil.which("sha256sum"), reason="no sha256sum")
@pytest.mark.proof
def test_the_list_of_hashes_is_read_by_its_program(site):
    subprocess.run(
        ["sha256sum", "--strict", "--quiet", "-c", "SHA256SUMS"],
        cwd=site / FOLDER / "data", check=True, timeout=60,
    )  # fmt: skip
