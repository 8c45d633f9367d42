"""Clients that wait while the server is being stopped get the documented answer."""

import asyncio
import json

import pytest

pytest.importorskip("uvicorn")

from heyoka_bike.workbench.serving.app import Guard


def asked(begins):
    """Return the messages of a cancelled request's answer, partly sent before or not."""
    sent, log = [], []

    async def app(scope, receive, send):
        if begins:
            await send({"type": "http.response.start", "status": 200, "headers": []})
        await asyncio.sleep(60)

    async def send(message):
        sent.append(message)

    async def receive():
        return {"type": "http.request", "body": b"", "more_body": False}

    async def run():
        scope = {"type": "http", "method": "POST", "path": "/score", "headers": [],
                 "query_string": b"", "client": None, "server": ("x", 80)}  # fmt: skip
        task = asyncio.create_task(Guard(app, ["*"], log.append)(scope, receive, send))
        await asyncio.sleep(0.05)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        return task.cancelled()

    return asyncio.run(run()), sent, log


def test_an_answer_that_has_not_begun_is_503_in_json():
    is_cancelled, (start, body), log = asked(begins=False)
    assert not is_cancelled
    assert start["status"] == 503
    headers = dict(start["headers"])
    assert headers[b"retry-after"] == b"10"
    assert headers[b"content-type"] == b"application/json"
    assert json.loads(body["body"]) == {"error": "the server is being stopped, try again in 10 s"}
    assert [line.split()[:3] for line in log] == [["POST", "/score", "503"]]


def test_an_answer_that_has_begun_is_broken_off():
    is_cancelled, sent, _ = asked(begins=True)
    assert is_cancelled
    assert [message["type"] for message in sent] == ["http.response.start"]
