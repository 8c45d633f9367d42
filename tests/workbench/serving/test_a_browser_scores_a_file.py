"""In a real browser a file is dropped, scored, replayed, compared and rejected, without errors."""

import re
import socket
import threading
import time

import pytest

pytest.importorskip("uvicorn")

import uvicorn

from generators.submissions import copied
from heyoka_bike.reference.load import load_reference
from heyoka_bike.showing.document.html import render
from heyoka_bike.showing.wording.origin_text import origin
from heyoka_bike.workbench.leaderboard.document import document
from heyoka_bike.workbench.leaderboard.ranking import leaderboard
from heyoka_bike.workbench.serving.app import Server
from heyoka_bike.workbench.serving.tasks import Limits
from support.browser import DROP, wait_until

pytestmark = [pytest.mark.proof, pytest.mark.timeout(300)]
WIDTHS = {"phone": 400, "tablet": 820, "desk": 1280}


def board(folder):
    """Return the leaderboard of two published submissions."""
    found = leaderboard(str(copied(folder)), [load_reference()], lambda share: None)
    return render(document(found, origin(("leaderboard", "results"))))


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The address of a server on a free port of this machine."""
    bound = socket.socket()
    bound.bind(("127.0.0.1", 0))
    limits = Limits(workers=2, upload=2_000_000, files=4)
    store = tmp_path_factory.mktemp("store")
    server = Server(store, limits, board=board(store.with_name("board")), log=lambda line: None)
    running = uvicorn.Server(uvicorn.Config(server.app, log_config=None))
    thread = threading.Thread(target=running.run, kwargs={"sockets": [bound]}, daemon=True)
    thread.start()
    while not running.started:
        time.sleep(0.05)
    yield f"http://127.0.0.1:{bound.getsockname()[1]}/"
    running.should_exit = True
    thread.join(timeout=20)


@pytest.fixture(params=WIDTHS)
def page(request, chromium, address):
    """A page at each width; the test fails if the browser reports an error."""
    scheme = "dark" if request.param == "phone" else "light"
    context = chromium.new_context(
        viewport={"width": WIDTHS[request.param], "height": 900}, color_scheme=scheme
    )
    found = context.new_page()
    complaints = []
    found.on("console", lambda m: complaints.append(m.text) if m.type != "log" else None)
    found.on("pageerror", lambda e: complaints.append(str(e)))
    found.on(
        "request",
        lambda r: complaints.append(r.url) if not r.url.startswith((address, "data:")) else None,
    )
    found.goto(address)
    found.complaints = complaints
    yield found
    context.close()


def fits(page):
    """Return whether the page needs no horizontal scrolling."""
    return page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_drop_score_replay_and_back(page, example):
    assert fits(page)
    page.evaluate(DROP, [example.name, example.read_text()])
    page.wait_for_url(re.compile("/results/.*/score"))
    page.wait_for_selector(".verdict")
    assert "1.6 correct digits" in page.inner_text(".verdict")
    assert fits(page)
    # The server's page has its own styles in addition to those of the report.
    assert page.locator(".lines .error").first.is_visible()
    line = page.locator('path[data-name="roll angle"]').first
    entry = page.get_by_role("button", name="roll angle", pressed=True).first
    entry.focus()
    page.keyboard.press("Space")
    assert not line.is_visible()
    assert page.get_by_role("button", name="roll angle", pressed=False).count() == 1
    page.get_by_role("button", name="Replay").click()
    page.wait_for_selector("canvas")
    wait_until(page, "document.querySelector('.clock').textContent !== ''")
    assert fits(page)
    page.go_back()
    assert "1.6 correct digits" in page.inner_text(".verdict")
    with page.expect_download() as taken:
        page.get_by_role("link", name="JSON").click()
    assert taken.value.suggested_filename == "exudyn-h0.01-report.json"
    page.get_by_role("button", name="Remove").click()
    page.wait_for_selector("form.upload")
    assert not page.complaints


def test_choose_two_files_and_compare(page, example):
    page.set_input_files("input[type=file]", [example, example.with_name("scipy-rtol1e-10.txt")])
    page.get_by_text("What the file does not say").click()
    page.get_by_label("Names").fill("Mine, Theirs")
    page.get_by_role("button", name="Score", exact=True).click()
    page.wait_for_url(re.compile("/results/.*/score"))
    page.locator("main", has_text="Mine").wait_for()
    assert not page.complaints


def test_paste_by_keyboard_alone(page, example):
    summary = page.get_by_text("or paste text")
    summary.focus()
    page.keyboard.press("Enter")
    page.get_by_label("Rows of numbers").fill(example.read_text())
    page.get_by_role("button", name="Score", exact=True).focus()
    page.keyboard.press("Enter")
    page.wait_for_url(re.compile("/results/.*/score"))
    assert not page.complaints


def test_what_is_refused_is_said_in_place(page, example):
    page.get_by_role("button", name="Score", exact=True).click()
    assert "Choose a file" in page.inner_text(".problem")
    sent = []
    page.on("request", lambda r: sent.append(r.url))
    page.set_input_files(
        "input[type=file]",
        {"name": "large.txt", "mimeType": "text/plain", "buffer": b"1 " * 2_000_000},
    )
    page.get_by_role("button", name="Score", exact=True).click()
    assert "Nothing was sent" in page.inner_text(".problem")
    assert not sent
    page.set_input_files("input[type=file]", [])
    page.evaluate(DROP, ["<b>notes.txt", "all is well"])
    page.wait_for_url(re.compile("/results/.*/score"))
    page.locator("[role=alert]", has_text="b_notes.txt").wait_for()
    # The browser itself prints a message about the answer 422.
    assert "Failed to load" in "".join(page.complaints)


def test_the_leaderboard_and_back(page):
    page.get_by_role("link", name="Leaderboard").click()
    page.wait_for_url(re.compile("/leaderboard"))
    assert page.locator("#H1 table tbody tr").count() == 2
    assert fits(page)
    page.get_by_role("link", name="Score a file").click()
    page.wait_for_selector("form.upload")
    assert not page.complaints


def test_a_slow_connection_shows_how_much_is_sent(chromium, address, example):
    page = chromium.new_page()
    page.goto(address)
    slow = {"offline": False, "latency": 200, "downloadThroughput": -1}
    page.context.new_cdp_session(page).send(
        "Network.emulateNetworkConditions", slow | {"uploadThroughput": 200_000}
    )
    # Sending this file takes one second on the slow connection.
    page.evaluate(DROP, [example.name, example.read_text()])
    page.locator(".busy", has_text=re.compile("sending .* of ")).wait_for()
    page.wait_for_url(re.compile("/results/.*/score"))
    page.locator(".verdict", has_text="1.6 correct digits").wait_for()
    page.close()


def test_why_it_differs(chromium, address, example):
    page = chromium.new_page()
    page.goto(address)
    page.get_by_role("button", name="Try it with an example").click()
    page.get_by_role("button", name="Why it differs").click()
    page.wait_for_selector(".answer", timeout=120_000)
    # The example file was made with Exudyn's trapezoidal rule.
    assert "the trapezoidal rule with a step of 0.01 s" in page.inner_text(".answer")
    page.close()


def test_without_script_the_same_pages_work(chromium, address, example):
    context = chromium.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(address)
    page.set_input_files("input[type=file]", example)
    page.get_by_role("button", name="Score", exact=True).click()
    page.wait_for_selector(".verdict", timeout=30_000)
    context.close()
