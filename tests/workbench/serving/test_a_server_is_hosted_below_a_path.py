"""Below a path every link, form, redirect and address stays below it, with any proxy."""

import re
import time
from dataclasses import replace

import pytest

pytest.importorskip("uvicorn")


from heyoka_bike.cli import main
from support.clusters import wait_for

BROWSER = {"accept": "text/html"}
ROOT = "/science/bicycle"
# Pattern of all links that a browser or the script follows.
ADDRESSES = re.compile(r'(?:href|action|src|data-state)="([^"#][^"]*)"')
OUTSIDE = re.compile(r"https?:|data:|mailto:")


@pytest.fixture(params=["kept", "taken away"])
def ask(request, serving):
    """Request an address as a browser does; a proxy may remove the path."""
    client = serving(root=ROOT, board="<style></style>\n</head><body>\n<main>\nboard</main></body>")

    def asked(method, address, **more):
        assert address.startswith(f"{ROOT}/"), address
        path = address.removeprefix(ROOT) if request.param == "taken away" else address
        return client.request(method, path, headers=BROWSER, **more)

    asked.lines, asked.server = client.lines, client.server
    return asked


def addresses(text):
    return {x for x in ADDRESSES.findall(text) if not OUTSIDE.match(x)}


@pytest.mark.proof
def test_every_address_of_every_page_leads_below_it(ask, example, monkeypatch):
    files = {"file": (example.name, example.read_bytes())}
    with monkeypatch.context() as patched:
        patched.setattr(ask.server, "limits", replace(ask.server.limits, page_seconds=0.0))
        report = ask("POST", f"{ROOT}/results", files=files).headers["location"]
    not_done = ask("GET", report).text
    (state,) = re.findall('data-state="([^"]*)"', not_done)
    assert all(x.startswith(f"{ROOT}/") for x in addresses(not_done))
    while ask("GET", state).json()["state"] != "done":
        time.sleep(0.05)
    replay = ask("POST", report.replace("score", "replay")).headers["location"]
    bad = ask("POST", f"{ROOT}/results", files={"file": ("bad.txt", b"no numbers")})
    waiting, seen = [f"{ROOT}/", f"{ROOT}/leaderboard", report, replay, f"{ROOT}/none"], set()
    waiting.append(bad.headers["location"])
    while waiting:
        seen.add(place := waiting.pop())
        answer = ask("GET", place)
        expected = {f"{ROOT}/none": 404, bad.headers["location"]: 422}.get(place, 200)
        assert answer.status_code == expected, place
        if "text/html" not in answer.headers["content-type"] or "attachment" in str(answer.headers):
            continue
        found = addresses(answer.text)
        assert found, place
        posts = set(re.findall(r'<form [^>]*action="([^"]*)"', answer.text))
        assert all(x.startswith(f"{ROOT}/") for x in found), place
        waiting += sorted(found - posts - seen)
    expected = {"", "api", "leaderboard", "openapi.json", "static/page.css", "static/serve.js"}
    assert {f"{ROOT}/{name}" for name in expected} <= seen
    assert {line.split()[1] for line in ask.lines} <= {
        "/", "/results", "/leaderboard", "/none", "/static", "/api", "/openapi.json", "/jobs",
    }  # fmt: skip
    removed = ask("POST", report.replace("score", "remove"))
    assert removed.headers["location"] == f"{ROOT}/"
    assert ask("GET", report).status_code == 404


def test_programs_are_told_addresses_below_it(ask, example):
    said = ask("GET", f"{ROOT}/openapi.json").json()
    assert said["servers"] == [{"url": ROOT}]
    assert f"http://127.0.0.1{ROOT}/score" in ask("GET", f"{ROOT}/api").text
    begun = ask("POST", f"{ROOT}/diagnose", content=b"no numbers")
    assert begun.status_code == 202
    assert begun.headers["location"] == begun.json()["job"]
    assert ask("GET", begun.json()["job"]).json()["job"] == begun.json()["job"]
    page = ask("POST", f"{ROOT}/example").headers["location"]
    job = page.replace("results", "jobs")
    wait_for(lambda: "page" in ask("GET", job).json())
    done = ask("GET", job).json()
    assert done["page"] == page
    assert ask("GET", done["result"]).json()["schema_version"]
    assert ask("GET", f"{ROOT}/health").json()["status"] == "ok"
    again = page.removesuffix("/score")
    assert ask("GET", again).headers["location"] == page


@pytest.mark.parametrize("path", ["bicycle", "/a b", "//a", "/a?b", "https://example.org", '/"'])
def test_what_is_no_path_is_refused(path, capsys):
    assert main(["serve", "--root-path", path]) == 1
    assert "--root-path: found" in capsys.readouterr().err
