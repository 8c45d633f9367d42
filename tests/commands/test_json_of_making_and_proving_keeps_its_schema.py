"""`generate` and `certify --format json` print one document that follows the shipped schema."""

import json
from importlib.resources import files
from pathlib import Path

import jsonschema
import pytest

from heyoka_bike.cli import main
from heyoka_bike.commands import certify, generate
from heyoka_bike.errors import InputError

MANEUVER = """
[[maneuver]]
name = "short"
speed = "4.6"
roll_rate = "0.5"
duration = "0.1"
spacing = "0.05"
"""


def check(document, name):
    schema = json.loads(
        (files("heyoka_bike.commands") / "schemas" / f"{name}-1.schema.json").read_text()
    )
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema)
    # The schema must describe every key of the document.
    assert set(document) == set(schema["properties"])
    return schema["properties"]


@pytest.mark.proof
def test_what_was_made_and_proved_is_told(tmp_path, capsys):
    (tmp_path / "m.toml").write_text(MANEUVER)
    out = str(tmp_path / "set")
    options = ["--maneuvers", str(tmp_path / "m.toml"), "--out", out, "--workers", "1"]
    assert main(["generate", *options, "--format", "json"]) == 0
    text, err = capsys.readouterr()
    assert err == ""
    document = json.loads(text)
    parts = check(document, "generate")
    (made,) = document["sets"]
    assert sorted(made["written"]) == sorted(p.name for p in Path(out).iterdir())
    (maneuver,) = made["maneuvers"]
    assert set(maneuver) == set(
        parts["sets"]["items"]["properties"]["maneuvers"]["items"]["properties"]
    )
    assert (maneuver["maneuver"], maneuver["duration"]) == ("short", "1/10")
    assert 0 < float(maneuver["bound"]) < 1e-60
    assert document["failed"] == []

    assert main(["certify", out, "--workers", "1", "--format", "json"]) == 0
    text, err = capsys.readouterr()
    assert err == ""
    document = json.loads(text)
    parts = check(document, "certify")
    (proved,) = document["maneuvers"]
    assert set(proved) == set(parts["maneuvers"]["items"]["properties"])
    (certified,) = json.loads((Path(out) / "certificate.json").read_text())["maneuvers"]
    assert {key: proved[key] for key in certified} == certified
    # The same bound is now proved from the files alone.
    assert float(proved["bound"]) < 1e-60


def test_what_was_not_made_is_told():
    failed = {Path("sets/pista"): InputError("nothing there", file="x.toml")}
    document = generate._document([], failed)
    check(json.loads(json.dumps(document)), "generate")
    (entry,) = document["failed"]
    assert entry == {
        "folder": str(Path("sets/pista")), "message": "x.toml: nothing there", "exit_code": 1,
    }  # fmt: skip


def test_facts_are_told():
    facts = [{"about": "maneuver 1", "statement": "It comes back."}]
    check(certify._document("here", {"after-ten-seconds.json": []}, facts=facts), "certify")


@pytest.mark.parametrize("command", ["generate", "certify"])
def test_another_format_is_refused(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--format", "jsno"])
    assert ended.value.code == 1
    assert "found 'jsno', expected table or json; did you mean json?" in capsys.readouterr().err
