"""Damaged uploads get an answer of one line each, without errors or remaining files."""

import random
import re
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

pytest.importorskip("uvicorn")


WRITTEN = Path(__file__).parents[2] / "scoring" / "written"
# [bytes] Larger files take long to read, but test no other code.
LARGEST = 400_000
ANSWERS = {200, 400, 413, 422}


def seeds(example):
    files = [
        p for p in sorted(WRITTEN.rglob("*")) if p.is_file() and p.suffix not in (".py", ".md")
    ]
    found = [(p.name, p.read_bytes()) for p in files if p.stat().st_size <= LARGEST]
    assert len(found) > 20
    return [*found, (example.name, example.read_bytes()[:60_000])]


def damaged(content, rng):
    """Return the bytes with one to three kinds of damage."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 3)):
        kind, at = rng.randrange(7), rng.randrange(len(data) + 1)
        if kind == 0:
            for _ in range(rng.randint(1, 20)):
                if data:
                    data[rng.randrange(len(data))] = rng.randrange(256)
        elif kind == 1:
            del data[at:]
        elif kind == 2:
            del data[at : at + rng.randint(1, 300)]
        elif kind == 3:
            data[at:at] = rng.randbytes(rng.randint(1, 300))
        elif kind == 4:
            # Most formats store sizes and counts in this form.
            data[at : at + 8] = rng.choice((0, 1, 2**31 - 1, 2**40, 2**63 - 1)).to_bytes(
                8, "little"
            )
        elif kind == 5:
            data[at:at] = rng.choice(
                (b"nan ", b"1e999 ", b"-inf,", b"\0", b"\n" * 100, b'"', b"<script>")
            )
        else:
            data += data[at : at + 5000]
    return bytes(data)


def sends(client, example, count, seed):
    rng, found, answers = random.Random(seed), seeds(example), Counter()
    for _ in range(count):
        name, content = rng.choice(found)
        body = damaged(content, rng)
        if rng.random() < 0.1:
            # In this case the form itself is damaged.
            form = b'--x\r\nContent-Disposition: form-data; name="file"; filename="' + name.encode()
            form += b'"\r\n\r\n' + body[:20_000] + b"\r\n--x--\r\n"
            headers = {"content-type": "multipart/form-data; boundary=x"}
            answer = client.post("/score", content=damaged(form, rng), headers=headers)
        else:
            answer = client.post("/score", files={"file": (name, body)})
        answers[answer.status_code] += 1
        assert answer.status_code in ANSWERS, (name, answer.text)
        if answer.status_code != 200:
            line = answer.json()["error"]
            assert line
            assert "\n" not in line
            assert not re.search(r"Traceback|File \"|ended before it was done", line), (name, line)
    return answers


# If a form is unreadable, Starlette leaves its file to the garbage collector, which closes the
# file.
@pytest.mark.filterwarnings("ignore:Unclosed file <tempfile.SpooledTemporaryFile:ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.proof
@pytest.mark.timeout(600)
def test_hundreds_of_damaged_uploads(serving, example):
    client = serving()
    answers = sends(client, example, 200, 1)
    assert answers[200]
    assert answers[422]
    assert not list(client.folder.iterdir())


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_ten_thousand_damaged_uploads(serving, example):
    client = serving(workers=2)
    with ThreadPoolExecutor(2) as pool:
        halves = [pool.submit(sends, client, example, 5000, seed) for seed in (2, 3)]
    answers = halves[0].result() + halves[1].result()
    print(dict(answers))
    assert answers.total() == 10_000
    assert not list(client.folder.iterdir())
