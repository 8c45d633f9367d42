"""A request beyond a limit of time, memory, size, number or space is rejected in one line."""

import asyncio
import errno
import time
from dataclasses import replace
from multiprocessing import active_children
from threading import Thread
from types import SimpleNamespace

import pytest

pytest.importorskip("uvicorn")


from heyoka_bike.system.jobs import ProgressFuture
from heyoka_bike.workbench.serving import store, tasks, uploads
from heyoka_bike.workbench.serving.app import _status
from heyoka_bike.workbench.serving.queue import BusyError, QueuedTask, TaskQueue
from heyoka_bike.workbench.serving.store import ResultStore, file_name
from heyoka_bike.workbench.serving.tasks import Limits
from support.clusters import wait_for

BROWSER = {"accept": "text/html"}


def until(true, seconds=20.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_what_is_too_large_is_refused_before_it_is_read(serving):
    client = serving(upload=10_000)
    answer = client.post("/score", content=b"1 " * 200_000)
    assert answer.status_code == 413
    assert answer.json()["error"].startswith("found more than")
    assert client.post("/results", files={"file": ("a", b"1 " * 200_000)}).status_code == 413
    assert not list(client.folder.iterdir())


def test_what_lies_about_its_size_is_refused_too(serving):
    client = serving(upload=10_000)

    def pieces():
        for _ in range(100):
            yield b"1 " * 5000

    assert client.post("/score", content=pieces()).status_code == 413
    assert not list(client.folder.iterdir())


def test_so_many_files_and_no_more(serving):
    client = serving(files=3)
    four = [("file", (f"{i}.txt", b"1 2")) for i in range(4)]
    assert "Too many files" in client.post("/score", files=four).json()["error"]
    assert not list(client.folder.iterdir())


def test_requests_together_hold_so_much_and_no_more(serving, tmp_path):
    client = serving(upload=20_000, arriving_bytes=15_000)
    answer = client.post("/score", content=b"1 " * 9000)
    assert answer.status_code == 503
    assert answer.json()["error"] == "busy, try again in 5 s"
    # A rejected request takes no space in the folder.
    assert client.post("/score", content=b"1 " * 4000).status_code == 422
    assert not list(client.folder.iterdir())
    store = ResultStore(tmp_path, Limits(arriving_bytes=15_000))
    one, other = store.room(), store.room()
    store.grow(one, 8000)
    with pytest.raises(BusyError):
        store.grow(other, 8000)
    store.drop(one)
    store.drop(other)
    store.grow(store.room(), 8000)


def test_a_full_queue_says_when_to_try_again(serving, example):
    client = serving(waiting=1)
    files = {"file": (example.name, example.read_bytes())}
    answers = []
    threads = [
        Thread(target=lambda: answers.append(client.post("/score", files=files)))
        for _ in range(12)
    ]  # fmt: skip
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    codes = [answer.status_code for answer in answers]
    assert set(codes) == {200, 503}
    busy = next(answer for answer in answers if answer.status_code == 503)
    assert int(busy.headers["retry-after"]) >= 1
    assert busy.json()["error"].startswith("busy, try again in")
    assert not list(client.folder.iterdir())


def test_diagnoses_do_not_keep_files_waiting(tmp_path):
    """The test itself ends the calls, instead of processes."""
    calls = []

    class Calls:
        def submit(self, work, task, memory):
            calls.append(ProgressFuture())
            return calls[-1]

        def shutdown(self):
            pass

    async def work():
        found = TaskQueue(Limits(workers=2, waiting=6), lambda line: None)
        found._executors = {True: Calls(), False: Calls()}
        diagnose = tasks.Task("diagnose", tmp_path, ("a.txt",))
        working = found.submit(diagnose)
        await asyncio.sleep(0.01)
        assert working.state == "working"
        # One diagnosis runs at a time, and at most half of the places are for diagnoses that wait.
        waiting = [found.submit(diagnose) for _ in range(3)]
        for refused in (lambda: found.submit(diagnose), lambda: found.check("diagnose")):
            with pytest.raises(BusyError):
                refused()
        found.check("score")
        score = found.submit(replace(diagnose, kind="score"))
        await asyncio.sleep(0.01)
        assert [x.state for x in (working, *waiting)] == ["working", *["waiting"] * 3]
        calls[-1].set_result({"state": "done"})
        await asyncio.wait_for(score.over, 20.0)
        calls[0].set_result({"state": "done"})
        for queued in waiting:
            while queued.future is None:
                await asyncio.sleep(0.01)
            # Exactly one of the waiting diagnoses has started. End it before the next one.
            assert [x.state for x in waiting].count("working") == 1
            calls[-1].set_result({"state": "done"})
            await asyncio.wait_for(queued.over, 20.0)
        assert {x.state for x in (working, score, *waiting)} == {"done"}
        last = [found.submit(diagnose) for _ in range(2)]
        await found.close()
        assert [x.ending.message for x in last] == ["given up"] * 2
        assert not found.waiting()

    asyncio.run(asyncio.wait_for(work(), 60.0))


def test_what_takes_too_long_is_ended(serving, example):
    client = serving(score_seconds=0.001)
    answer = client.post("/score", files={"file": (example.name, example.read_bytes())})
    assert answer.status_code == 422
    assert "takes more than 0.001 s" in answer.json()["error"]


@pytest.mark.proof
def test_what_takes_too_much_memory_is_ended(serving, example):
    # The rows alone take 80 MB as numbers, and the comparison takes as much again.
    client = serving(memory=400_000_000, upload=60_000_000)
    rows = (" ".join(["1.25"] * 25) + "\n").encode() * 400_000
    answer = client.post("/score", content=rows)
    assert answer.status_code == 422, answer.text
    assert "memory" in answer.json()["error"]
    files = {"file": (example.name, example.read_bytes())}
    assert client.post("/score", files=files).status_code == 200


@pytest.mark.proof
def test_a_worker_that_is_killed_is_said_and_the_next_one_works(serving, example):
    client = serving()
    files = {"file": (example.name, example.read_bytes())}
    client.post("/score", files=files)
    seen = []

    def kill():
        until(active_children)
        for process in active_children():
            process.kill()
            seen.append(process)

    killer = Thread(target=kill)
    killer.start()
    answer = client.post("/score", files=files)
    killer.join()
    assert seen
    assert answer.status_code == 422
    assert "ended before it was done" in answer.json()["error"]
    assert client.post("/score", files=files).status_code == 200
    assert not list(client.folder.iterdir())


def test_a_client_that_leaves_frees_its_place(serving, example, monkeypatch):
    client = serving(look_seconds=0.001)
    monkeypatch.setattr(tasks, "FILES", tasks.FILES)
    job = client.server.queue.submit
    begun = []
    monkeypatch.setattr(
        client.server.queue, "submit", lambda task: begun.append(job(task)) or begun[-1]
    )

    async def left(self):
        return True

    monkeypatch.setattr("starlette.requests.Request.is_disconnected", left)
    client.post("/score", files={"file": (example.name, example.read_bytes())})
    assert begun[0].unwanted.is_set()
    assert begun[0].state == "failed"
    assert not list(client.folder.iterdir())


def test_results_leave_when_their_time_is_over(serving):
    client = serving(kept_seconds=0.3)
    place = client.post("/example").json()["location"]
    until(lambda: client.get(place).status_code == 404)
    client.server.store.sweep()
    assert not list(client.folder.iterdir())


def test_a_sweep_that_fails_is_not_the_last(serving, monkeypatch):
    swept = []

    def sweep(self):
        swept.append(self)
        raise FileNotFoundError("secret")

    monkeypatch.setattr(ResultStore, "sweep", sweep)
    client = serving(sweep_seconds=0.001)
    until(lambda: len(swept) > 2)
    assert client.lines[0].startswith("sweep: FileNotFoundError at ")
    assert "secret" not in "".join(client.lines)


def test_what_is_kept_in_the_middle_of_a_sweep_stays(tmp_path):
    store = ResultStore(tmp_path, Limits())

    class Arrived(dict):
        def __contains__(self, folder):
            if dict.__contains__(self, folder):
                store.keep(QueuedTask(tasks.Task("score", folder, ("a.txt",))))
            return dict.__contains__(self, folder)

    store._arrived = Arrived()
    folder = store.room()
    store.sweep()
    assert store.get(folder.name) is not None
    assert folder.is_dir()


@pytest.mark.proof
def test_the_oldest_results_make_room(serving):
    client = serving(kept=2)
    places = [client.post("/example").json()["location"] for _ in range(3)]
    client.server.store.sweep()
    assert [client.get(place, headers=BROWSER).status_code for place in places] == [404, 200, 200]
    assert len(list(client.folder.iterdir())) == 2


def test_a_result_is_removed_when_it_is_asked_for(serving):
    client = serving()
    place = client.post("/example").json()["location"]
    assert client.post(place.replace("score", "remove")).status_code == 303
    assert client.get(place).status_code == 404
    assert not list(client.folder.iterdir())


def test_a_diagnosis_that_is_not_offered_is_not_done(serving, example):
    client = serving(has_diagnosis=False)
    files = {"file": (example.name, example.read_bytes())}
    assert client.post("/diagnose", files=files).status_code == 404
    place = client.post("/example").json()["location"]
    assert "Why it differs" not in client.get(place, headers=BROWSER).text
    assert client.post(place.replace("score", "diagnose")).status_code == 404
    assert "/diagnose" not in client.get("/openapi.json").json()["paths"]


def test_only_names_that_were_told_are_answered(serving):
    client = serving(hosts=["bicycle.example"])
    assert client.get("/").status_code == 400
    for name, code in (("bicycle.example", 200), ("Bicycle.Example:80", 200), ("[::1]:80", 400)):
        assert client.get("/", headers={"host": name}).status_code == code
    assert client.get("/health").status_code == 200
    local = serving(hosts=["::1", "localhost"])
    for name, code in (("[::1]:8000", 200), ("localhost:1", 200), ("localhost.evil", 400)):
        assert local.get("/", headers={"host": name}).status_code == code


@pytest.mark.proof
def test_a_page_of_another_site_cannot_send_files(serving):
    client = serving()
    answer = client.post("/example", headers={"sec-fetch-site": "cross-site"})
    assert answer.status_code == 403
    # Without TLS, browsers send only the origin. The server's own forms are allowed to send it.
    client = serving(hosts=["bicycle.example", "::1"])
    host = {"host": "bicycle.example:8000"}
    assert client.get("/", headers=host).headers["referrer-policy"] == "same-origin"
    for origin, code in (
        ("http://evil.example", 403), ("null", 403), ("https://bicycle.example.evil", 403),
        ("http://bicycle.example:8000", 201), ("HTTP://Bicycle.Example:8000", 201),
        # A server with a different port or address on the same machine counts as a different site.
        ("http://bicycle.example:8001", 403), ("http://bicycle.example", 403),
        ("http://[::1]:8000", 403), ("", 403), ("http://", 403),
    ):  # fmt: skip
        assert client.post("/example", headers=host | {"origin": origin}).status_code == code
    # If the port is missing, the usual port of the scheme is meant.
    for asked, origin, code in (
        ("bicycle.example", "http://bicycle.example", 201),
        ("bicycle.example", "https://bicycle.example", 201),
        ("bicycle.example", "https://bicycle.example:443", 201),
        ("bicycle.example:80", "http://bicycle.example", 201),
        ("bicycle.example", "http://bicycle.example:443", 403),
        ("[::1]:8000", "http://[::1]:8000", 201),
        ("[::1]:8000", "http://[::1]:8001", 403),
    ):
        told = {"host": asked, "origin": origin}
        assert client.post("/example", headers=told).status_code == code
    # The origin is also checked if any host is allowed.
    client = serving(hosts=["*"])
    told = {"host": "127.0.0.1:8000", "origin": "http://127.0.0.1:9000"}
    assert client.post("/example", headers=told).status_code == 403
    same = host | {"origin": "null", "sec-fetch-site": "same-origin"}
    assert client.post("/example", headers=same).status_code == 201


def test_nothing_is_kept_on_the_way_and_nobody_is_led_elsewhere(serving):
    client = serving()
    place = client.post("/example").json()["location"]
    for address in (place, f"{place}.json", f"{place}.pdf", "/", "/nowhere", "/health"):
        assert client.get(address).headers["cache-control"] == "no-store"
    assert "max-age" in client.get("/static/serve.js").headers["cache-control"]
    assert client.get("/health/", headers={"host": "evil.example"}).status_code == 404


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("results.txt", "results.txt"),
        ("../../etc/passwd", "passwd"),
        ("C:\\Users\\me\\out.mat", "out.mat"),
        ("-", "results.txt"),
        ("--require", "require"),
        ("", "results.txt"),
        (".hidden", "hidden"),
        ("a\0b\n<script>.txt", "a_b__script_.txt"),
        ("Ergebnis für Fahrrad.csv", "Ergebnis für Fahrrad.csv"),
        ("x" * 300 + ".npy", "x" * 76 + ".npy"),
        # In UTF-8, each of these characters has four bytes.
        ("\U00020000" * 90 + ".npy", "\U00020000" * 59 + ".npy"),
    ],
)
def test_a_name_is_a_name_and_no_place(given, kept):
    assert file_name(given, set()) == kept


def test_files_of_one_name_stay_apart():
    taken = set()
    assert [file_name(n, taken) for n in ("a.txt", "A.TXT", "a.txt", "a")] == [
        "a.txt", "A (2).TXT", "a (3).txt", "a",
    ]  # fmt: skip


def test_names_and_headings_are_text_on_every_page(serving):
    client = serving()
    bad = "<img src=x onerror=alert(1)>"
    rows = f"time,{bad}\n0,1\n1,2\n".encode()
    for content in (rows, b"<script>alert(1)</script>"):
        answer = client.post("/results", files={"file": (bad + ".csv", content)}, headers=BROWSER)
        text = client.get(answer.headers["location"], headers=BROWSER).text
        assert "<img" not in text
        assert "<script>alert" not in text


def test_no_script_runs_but_the_packages_own(serving):
    client = serving()
    place = client.post("/example").json()["location"]
    wait_for(lambda: "page" in client.get(place.replace("results", "jobs")).json())
    policy = client.get(place, headers=BROWSER).headers["content-security-policy"]
    assert "script-src 'sha256-" in policy
    assert "unsafe-inline" not in policy.split("script-src")[1]
    policy = client.get("/", headers=BROWSER).headers["content-security-policy"]
    assert "unsafe" not in policy
    for header, value in (("x-content-type-options", "nosniff"), ("x-frame-options", "DENY")):
        assert client.get("/").headers[header] == value


def test_the_log_has_no_names_and_no_contents(serving):
    client = serving()
    client.post("/results", files={"file": ("secret-project.txt", b"secret-value 1 2\n")})
    place = client.post("/example").json()["location"]
    client.get(place)
    log = "\n".join(client.lines)
    assert "POST /results" in log
    assert "secret" not in log
    assert place.split("/")[2] not in log


def test_a_fault_of_the_program_is_said_without_its_insides(serving, monkeypatch, example):
    client = serving()

    def submit(*_):
        raise RuntimeError("what nobody should see")

    monkeypatch.setattr(client.server.queue._executors[False], "submit", submit)
    answer = client.post("/score", files={"file": (example.name, example.read_bytes())})
    assert answer.status_code == 500
    assert "see" not in answer.json()["error"].replace("server", "")
    assert any("RuntimeError at" in line for line in client.lines)


def test_a_fault_of_the_server_has_no_names_in_its_log(serving, monkeypatch, example):
    client = serving()

    def told():
        raise OSError(errno.EIO, "Input/output error", "/store/secret-key/files/secret-name.txt")

    monkeypatch.setattr(client.server.store, "room", told)
    answer = client.post("/score", files={"file": (example.name, example.read_bytes())})
    assert answer.status_code == 500
    assert "internal error of the server" in answer.json()["error"]
    assert any(line.startswith("OSError at ") for line in client.lines)
    assert "secret" not in "".join(client.lines)


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_said(serving, monkeypatch, example, number):
    client = serving()
    files = {"file": (example.name, example.read_bytes())}

    def full(*_):
        raise OSError(number, "no room", "/store/secret-key")

    monkeypatch.setattr(uploads.shutil, "copyfileobj", full)
    answer = client.post("/score", files=files)
    assert (answer.status_code, answer.json()["error"]) == (507, "the server's disk is full")
    assert "507" in client.lines[-1]
    assert not list(client.folder.iterdir())
    monkeypatch.undo()
    assert client.post("/score", files=files).status_code == 200
    assert client.get("/health").status_code == 200
    monkeypatch.setattr(store.shutil, "disk_usage", lambda folder: SimpleNamespace(free=10**6))
    assert client.get("/health").status_code == 507
    assert client.get("/health").json()["status"] == "full"


def test_a_report_without_room_is_no_fault_of_its_file(tmp_path, monkeypatch, example):
    place = tmp_path / tasks.FILES
    place.mkdir()
    (place / "file.txt").write_bytes(example.read_bytes())

    def full(*_):
        raise OSError(errno.ENOSPC, "no room")

    monkeypatch.setattr("os.fsync", full)
    monkeypatch.chdir(tmp_path)
    ending = tasks.TaskEnding(**tasks.work(tasks.Task("score", tmp_path, ("file.txt",)), 10**9))
    assert (ending.state, ending.message) == ("failed", "the server's disk is full")
    assert _status(ending) == 507


@pytest.mark.parametrize(
    ("field", "text", "said"),
    [
        # The texts are rejected because of their length, before any of the million steps, columns
        # or digits is parsed.
        ("step", "0.1," * 1_000_000, "step: found 4000000 characters, expected at most 10000"),
        ("columns", "," * 1_000_000, "columns: found 1000000 characters"),
        ("require", "scd>=" + "1" * 100_000 + "x", "require: found 100006 characters"),
        ("step", "1/3," * 1000, "step: found 1001 for 1 files, expected one for each"),
    ],
)
def test_options_are_short(serving, field, text, said):
    client = serving()
    answer = client.post("/score", files={"file": ("a.txt", b"1 2")}, data={field: text})
    assert answer.status_code == 400
    assert answer.json()["error"].startswith(said)
    # Options in the query of the address have the same limits as those in a form.
    answer = client.post(f"/score?{'&'.join(['require=scd>1'] * 60)}", content=b"1 2")
    assert answer.json()["error"] == "found 60 options, expected at most 50"


@pytest.mark.parametrize("charset", ["punycode", "unicode_escape", "undefined", "zlib"])
def test_a_form_is_in_utf_8(serving, charset):
    client = serving()
    form = b'--x\r\nContent-Disposition: form-data; name="pasted"\r\n\r\n1 \\ud800\r\n--x--\r\n'
    headers = {"content-type": f"multipart/form-data; boundary=x; charset={charset}"}
    answer = client.post("/score", content=form, headers=headers)
    assert answer.status_code == 400
    assert answer.json()["error"] == "found a form in another encoding, expected UTF-8"
    headers = {"content-type": "multipart/form-data; boundary=x; charset=UTF-8"}
    assert client.post("/score", content=form, headers=headers).status_code == 422
    assert not list(client.folder.iterdir())


def test_rows_that_are_pasted_are_bounded_for_they_are_in_memory(serving):
    client = serving(field=10_000)
    for field in ("pasted", "columns"):
        answer = client.post("/score", files={"file": ("", b"")}, data={field: "1 " * 6000})
        assert answer.status_code == 400
        assert "Part exceeded maximum size of 9KB" in answer.json()["error"]
    assert client.post("/score", files={"file": ("a", b"1 " * 60000)}).status_code == 422
    assert not list(client.folder.iterdir())
