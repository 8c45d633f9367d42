"""``score --format badge`` writes the JSON that shields.io reads, and agrees with the verdict."""

import json

import pytest

from generators import sample_reports as sample
from heyoka_bike.cli import main
from heyoka_bike.showing.formats import badge
from heyoka_bike.showing.wording.verdict_text import verdict
from heyoka_bike.system.resources import data_folder

# Colours that have a name in the documentation of shields.io
NAMED = {"brightgreen", "green", "yellowgreen", "yellow", "orange", "red", "blue", "lightgrey"}


def read(scored):
    text = badge.render(scored)
    assert text.endswith("}\n")
    found = json.loads(text)
    assert set(found) == {"schemaVersion", "label", "message", "color"}
    assert found["schemaVersion"] == 1
    assert found["color"] in NAMED
    return found["message"], found["color"]


def test_word_digits_and_colour():
    assert read(sample.perfect()) == ("right, 32.0 correct digits", "brightgreen")
    assert read(sample.half())[1] != "brightgreen"
    message, color = read(sample.rough())
    assert (message.split(",")[0], color) == ("wrong", "red")
    assert "-" not in message
    assert read(sample.sample(1e-7))[1] == "brightgreen"
    assert read(sample.sample(1e-4))[1] == "yellow"


@pytest.mark.parametrize("make", [sample.sample, sample.perfect, sample.half, sample.one_row])
def test_it_says_the_words_of_the_verdict(make):
    report = make()
    word = read(report)[0].split(",")[0]
    assert word in verdict(report)


def test_a_result_file_as_a_badge(capsys, tmp_path):
    file = str(data_folder() / "peers" / "exudyn-h0.01.txt")
    assert main(["score", file, "--format", "badge", "-o", str(tmp_path / "badge.json")]) == 0
    assert json.loads((tmp_path / "badge.json").read_text())["message"] == (
        "wrong, 1.6 correct digits"
    )
    # A suffix without --format selects the format of the report, not that of the badge.
    assert main(["score", file, "-o", str(tmp_path / "report.json")]) == 0
    assert "maneuvers" in json.loads((tmp_path / "report.json").read_text())
