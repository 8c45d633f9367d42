"""Jobs on a Dask cluster, by its interface of `concurrent.futures`."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any
from uuid import uuid4

from heyoka_bike.errors import InputError, MissingPackageError, VersionsDifferError, WorkerLostError
from heyoka_bike.system.jobs import Hands, Outcome, Told, carried_out
from heyoka_bike.system.versions import versions

_ANSWERS = 5  # [s] in which a scheduler does
_APART = 0.2  # [s] between two words of a job


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """A running Dask scheduler.

    Parameters
    ----------
    address
        Such as ``tcp://127.0.0.1:8786``, or a scheduler file.
    """
    try:
        import distributed
    except ImportError:
        raise MissingPackageError(
            "--cluster needs Dask: pip install 'heyoka_bike[cluster]'"
        ) from None
    # It says in many lines what is said here in one.
    for name in [x for x in logging.root.manager.loggerDict if x.startswith("distributed")]:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    given = {"scheduler_file": address} if Path(address).is_file() else {"address": address}

    class Client(distributed.Client):  # type: ignore[misc]
        def __del__(self) -> None:
            """One that found nobody to talk to has nothing to close."""

    try:
        client = Client(**given, timeout=_ANSWERS, set_as_default=False)
    except Exception as e:  # whatever answers there may say anything
        why = " ".join(str(e).split()) or type(e).__name__
        raise InputError(
            f"--cluster: found no Dask scheduler at {address} within {_ANSWERS} s ({why:.100}), "
            "expected the address of one that runs, such as tcp://127.0.0.1:8786"
        ) from None
    try:
        cluster = Cluster(client, address)
        cluster.check()
        yield cluster
    finally:
        with suppress(Exception):
            client.close(timeout=_ANSWERS)


class Cluster:
    """The workers of a scheduler."""

    def __init__(self, client: Any, address: str) -> None:
        self.client, self.address = client, address

    def check(self) -> None:
        """Refuse workers of other versions; those that come later refuse their jobs."""
        try:
            found = self.client.run(versions, on_error="return")
            threads = self.client.nthreads()
        except Exception as e:
            raise self.lost() from e
        for worker, there in found.items():
            if isinstance(there, ImportError):
                raise VersionsDifferError(
                    f"{worker}: found no heyoka_bike, expected {versions()['heyoka_bike']}"
                )
            if isinstance(there, BaseException):
                raise VersionsDifferError(f"{worker}: cannot tell its versions: {there}")
            check_versions(versions(), there, worker)
        if not found:
            _say(f"no worker at {self.address} yet: waiting for one")
        for worker, count in threads.items():
            if count > 1:
                _say(
                    f"{worker} has {count} threads and does one job at a time: start workers with "
                    "--nthreads 1, one for each processor"
                )

    def lost(self) -> WorkerLostError:
        """For when the scheduler is gone."""
        return WorkerLostError(
            f"--cluster: the scheduler at {self.address} ended or does not answer any more"
        )

    @contextmanager
    def at_work(self, count: int, told: Told) -> Iterator[Hands]:
        """See `jobs.Crew`."""
        hands = _Remote(self, told)
        try:
            yield hands
        finally:
            hands.close()


class _Remote:
    """The client's side; that a worker ends the scheduler answers by itself, three times."""

    tries = 1

    def __init__(self, cluster: Cluster, told: Told) -> None:
        self.cluster, self.told = cluster, told
        self.topic = f"heyoka_bike-{uuid4()}"
        self.heard: SimpleQueue[tuple[int, str, float]] = SimpleQueue()
        self.executor = cluster.client.get_executor(pure=False, retries=0)
        cluster.client.subscribe_topic(self.topic, lambda event: self.heard.put(event[1]))
        self.begun: list[Future[Any]] = []

    def free(self) -> bool:
        return True

    def submit(self, i: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Future[Any]:
        try:
            future: Future[Any] = self.executor.submit(
                _run, versions(), self.topic, i, work, arguments
            )
        except Exception as e:
            raise self.cluster.lost() from e
        self.begun.append(future)
        return future

    def look(self) -> None:
        with suppress(Empty):
            while True:
                self.told(*self.heard.get_nowait())
        if self.cluster.client.status != "running":
            raise self.cluster.lost()

    def is_lost(self, error: Exception) -> bool:
        if isinstance(error, CancelledError):
            raise self.cluster.lost() from None
        return type(error).__name__ == "KilledWorker"

    def close(self) -> None:
        with suppress(Exception):
            self.executor.shutdown(wait=False, cancel_futures=True)
        with suppress(Exception):
            self.cluster.client.unsubscribe_topic(self.topic)


def check_versions(here: dict[str, str], there: dict[str, str], worker: str) -> None:
    """Raise `VersionsDifferError` that names the first package of another version."""
    for name, expected in here.items():
        if (found := there.get(name, "none")) != expected:
            raise VersionsDifferError(
                f"worker {worker}: found {name} {found}, expected {expected} as here: results "
                "might differ"
            )


class _UnwantedError(Exception):
    """Nobody waits for this job any more."""


def _run(
    here: dict[str, str], topic: str, i: int, work: Callable[..., Any], arguments: tuple[Any, ...]
) -> Outcome:
    """A job, on a worker."""
    from distributed import get_worker

    worker = get_worker()
    check_versions(here, versions(), worker.address)
    key = worker.get_current_task()
    return carried_out(work, arguments, _Teller(worker, key, topic, i))


class _Teller:
    """What a job tells goes to the client; it ends where nobody wants its result any more."""

    def __init__(self, worker: Any, key: Any, topic: str, i: int) -> None:
        self.worker, self.key, self.topic, self.i = worker, key, topic, i
        self.at = 0.0
        self.last = ""

    def __call__(self, stage: str, t: float) -> None:
        task = self.worker.state.tasks.get(self.key)
        if task is None or task.state == "cancelled":
            raise _UnwantedError
        now = monotonic()
        if stage != self.last or now > self.at + _APART:
            self.last, self.at = stage, now
            self.worker.log_event(self.topic, (self.i, stage, t))


def _say(text: str) -> None:
    print(f"heyoka-bike: {text}", file=sys.stderr)
