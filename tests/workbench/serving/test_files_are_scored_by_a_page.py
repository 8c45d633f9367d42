"""A file sent to the server gets the command's report, as a page and as JSON."""

import json
import re
import subprocess
import sys
import time

import jsonschema
import numpy as np
import pytest

pytest.importorskip("uvicorn")


from heyoka_bike.workbench.serving.pages import description
from heyoka_bike.workbench.serving.tasks import Limits

BROWSER = {"accept": "text/html"}


def sent(client, *paths, **fields):
    files = [("file", (path.name, path.read_bytes())) for path in paths]
    return client.post("/results", files=files, data=fields, headers=BROWSER)


def page(client, answer):
    """Return the final page in the browser."""
    assert answer.status_code == 303, answer.text
    place = answer.headers["location"]
    for _ in range(200):
        found = client.get(place, headers=BROWSER)
        if "data-state" not in found.text:
            return place, found
        time.sleep(0.1)
    raise AssertionError("never done")


def test_the_json_is_that_of_the_command(client, example, tmp_path):
    answer = client.post("/score", files={"file": (example.name, example.read_bytes())})
    assert answer.status_code == 200
    said = subprocess.run(
        [sys.executable, "-m", "heyoka_bike", "score", example.name, "--format", "json"],
        cwd=example.parent, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert answer.text == said.stdout


def test_a_body_is_a_file_and_the_query_its_options(client, example):
    rows = [line.split() for line in example.read_text().splitlines() if line[:1].isdigit()]
    nine = "\n".join(" ".join(row[:1] + row[9:17]) for row in rows)
    answer = client.post("/score?maneuver=2&filename=mine.txt", content=nine)
    assert answer.status_code == 200
    assert answer.json()["file"]["path"] == "mine.txt"
    assert [m["maneuver"] for m in answer.json()["maneuvers"]] == [2]
    assert client.post("/score?maneuver=4", content=nine).json() == {
        "error": "maneuver: found '4', expected 1 to 3"
    }


def test_options_count_in_the_query_and_in_the_form(client, example):
    files = {"file": (example.name, example.read_bytes())}
    for asked in (
        client.post("/score?require=scd >= 6&require=1.coverage > 0.9", files=files),
        client.post("/score", files=files, data={"require": ["scd >= 6", "1.coverage > 0.9"]}),
    ):
        said = asked.json()
        assert not said["passed"]
        assert [r["met"] for r in said["requirements"]] == [False, True]
    for query, message in (
        ("maneuvre=2", "; did you mean maneuver?"),
        ("maneuver=7", "maneuver: found '7', expected 1 to 3"),
        ("maneuver=1&maneuver=2", "found maneuver twice, expected it once"),
        ("require=nonsense > 1", "nonsense"),
        ("units=deg", "found the option 'units', expected one of maneuver, columns"),
    ):
        for answer in (
            client.post(f"/score?{query}", files=files),
            client.post(f"/score?{query}", content=example.read_bytes()),
        ):
            assert answer.status_code == 400
            assert message in answer.json()["error"]
    whole = client.post("/score?maneuver=2", files=files)
    assert whole.status_code == 422
    error = whole.json()["error"]
    assert "found the number of maneuver 2 for results of maneuvers 1, 2 and 3" in error


def test_a_browser_gets_the_report_with_links_to_more(client, example):
    place, found = page(client, sent(client, example))
    assert "1.6 correct digits" in found.text
    assert f'action="{place.replace("score", "diagnose")}"' in found.text
    # HTML allows style elements only in the head of a page.
    assert found.text.count("<style>") == 1
    assert "Beside page.css" in found.text
    for suffix, kind in ((".json", "application/json"), (".csv", "text/csv"),
                         (".xml", "application/xml"), (".html", "text/html")):  # fmt: skip
        taken = client.get(place + suffix)
        assert taken.status_code == 200
        assert taken.headers["content-type"].startswith(kind)
        assert "attachment" in taken.headers["content-disposition"]
    # The downloaded report is the report of the command, without the links of the server.
    assert 'class="bar"' not in client.get(place + ".html").text


def test_pasted_rows_are_a_file(client, example):
    pasted = {"pasted": example.read_text()}
    answer = client.post("/results", data=pasted, files={"file": ("", b"")}, headers=BROWSER)
    _, found = page(client, answer)
    assert "pasted.txt" in found.text
    assert "1.6 correct digits" in found.text


def test_several_files_are_several_programs(client, example):
    other = example.with_name("scipy-rtol1e-10.txt")
    place, found = page(client, sent(client, example, other, name="Mine, Theirs"))
    assert "Mine" in found.text
    assert "Theirs" in found.text
    assert "Why it differs" not in found.text
    document = client.get(place + ".json").json()
    assert [run["name"] for run in document["runs"]] == ["Mine", "Theirs"]


def test_programs_without_energies_have_no_measure_of_them(client, example):
    rows = np.loadtxt(example)
    text = "t,roll\n" + "".join(f"{t:.17g},{roll:.17g}\n" for t, roll in rows[:, :2])
    files = [("file", (f"{name}.csv", text.encode())) for name in ("mine", "theirs")]
    _, found = page(client, client.post("/results", files=files, headers=BROWSER))
    assert "roll angle in maneuver 1</td>" in found.text


def test_runs_of_one_program_show_its_order(client, example):
    finer = example.with_name("exudyn-h0.001.txt")
    place, _ = page(client, sent(client, example, finer, step="0.01,0.001"))
    document = client.get(place + ".json").json()
    assert document["is_one_program"]
    assert document["convergence"]


@pytest.mark.proof
def test_a_replay_is_drawn(client, example):
    place, _ = page(client, sent(client, example))
    asked = client.post(place.replace("score", "replay"), headers=BROWSER)
    _, found = page(client, asked)
    assert "<canvas" in found.text
    assert client.get(place.replace("score", "replay.json")).status_code == 404


def test_the_example_is_scored_with_one_click(client):
    _, found = page(client, client.post("/example", headers=BROWSER))
    assert "exudyn-h0.01.txt" in found.text


@pytest.mark.proof
def test_a_diagnosis_is_a_job_with_progress(client, example):
    begun = client.post("/diagnose", files={"file": (example.name, example.read_bytes())})
    assert begun.status_code == 202
    shares = set()
    for _ in range(1200):
        said = client.get(begun.headers["location"]).json()
        shares.add(said["progress"])
        if said["state"] not in ("waiting", "working"):
            break
        time.sleep(0.1)
    assert said["state"] == "done"
    assert len(shares) > 3
    codes = [f["code"] for f in client.get(said["result"]).json()["findings"]]
    assert "no_mistake_found" in codes or "integration_error" in codes
    shown = client.get(said["page"], headers=BROWSER).text
    assert '<main>\n<section class="answer"><h2>Why it differs</h2>' in shown
    assert "order" in shown


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("notes.txt", b"all is well\n", "found"),
        ("a.png", b"\x89PNG\r\n\x1a\n" + bytes(100), "found a picture"),
        ("p.npy", b"\x80\x04K\x01.", "found a pickle"),
        ("z.zip", b"PK\x05\x06" + bytes(18), "archive"),
        ("nan.txt", b"nan " * 25 + b"\n" + b"nan " * 25, "found"),
    ],
)
def test_what_cannot_be_scored_is_said_in_one_line(client, name, content, said):
    answer = client.post("/score", files={"file": (name, content)})
    assert answer.status_code == 422
    assert answer.json()["error"].startswith(f"{name}: ") or name in answer.json()["error"]
    assert said in answer.json()["error"]
    assert "\n" not in answer.json()["error"]
    _, found = page(
        client, client.post("/results", files={"file": (name, content)}, headers=BROWSER)
    )
    assert found.status_code == 422
    assert 'role="alert"' in found.text


def test_columns_that_are_not_understood_are_asked_for_in_the_form(client, example):
    rows = b"Zeit;Rollwinkel\n0,0;0,0\n0,1;0,1\n"
    _, found = page(
        client, client.post("/results", files={"file": ("a.csv", rows)}, headers=BROWSER)
    )
    assert "Options are fields of the form" in found.text
    _, found = page(
        client, client.post("/results", files={"file": ("a.csv", b"")}, headers=BROWSER)
    )
    assert "Options are fields of the form" not in found.text


def test_examples_name_the_address_that_was_asked(client):
    found = client.get("/api", headers=BROWSER | {"host": "bicycle.example.org:8080"})
    assert "webwrite(&#x27;http://bicycle.example.org:8080/score&#x27;" in found.text


def test_a_request_without_a_file_says_what_is_expected(client):
    for answer in (
        client.post("/score"),
        client.post("/score", data={"file": "no file"}),
        client.post("/score", files={"other": ("a.txt", b"1 2")}),
        client.post("/score", content=b"--x", headers={"content-type": "multipart/form-data"}),
        client.post("/results", files={"file": ("", b"")}),
    ):
        assert answer.status_code == 400, answer.text
        assert "expected" in answer.json()["error"] or "form" in answer.json()["error"]


def test_what_is_not_there_is_said(client):
    for place in ("/nowhere", "/results/none/score", "/jobs/none/score", "/static/../app.py",
                  "/static/app.py", "/leaderboard"):  # fmt: skip
        answer = client.get(place, headers=BROWSER)
        assert answer.status_code == 404
        assert 'role="alert"' in answer.text
        assert client.get(place, headers={"accept": "application/json"}).json()["error"]
    assert client.get("/score").status_code == 405


@pytest.mark.proof
def test_the_description_of_the_interface_is_true(client, example):
    found = client.get("/openapi.json").json()
    assert found == description(Limits())
    validate = pytest.importorskip("openapi_spec_validator").validate
    validate(found)
    # Generators of client code do not follow nested references.
    assert not re.findall(r'"#/components/schemas/\w+/', json.dumps(found))
    schemas = found["components"]["schemas"]
    answer = client.post("/score", files={"file": (example.name, example.read_bytes())})
    jsonschema.validate(answer.json(), {"$ref": "#/components/schemas/score", **found})
    refused = client.post("/score", content=b"no numbers\n")
    jsonschema.validate(refused.json(), schemas["error"])
    place = client.post("/example").json()["location"].replace("results", "jobs")
    jsonschema.validate(client.get(place).json(), schemas["job"])


def test_the_server_says_that_it_works(client):
    assert client.get("/health").json()["status"] == "ok"


def test_pages_load_nothing_from_elsewhere(client):
    for place in ("/", "/api"):
        text = client.get(place, headers=BROWSER).text
        assert not re.findall(r'(?:src|href|action)="(?!/|data:|#)', text)
    _, found = page(client, client.post("/example", headers=BROWSER))
    assert "http://" not in found.headers["content-security-policy"]
    json.dumps(found.headers["content-security-policy"])
