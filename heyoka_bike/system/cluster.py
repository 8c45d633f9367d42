"""Calls on a Dask cluster, by its interface of `concurrent.futures`."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any
from uuid import uuid4
from weakref import WeakValueDictionary

from heyoka_bike.errors import InputError, SchedulerLostError, VersionsDifferError, required
from heyoka_bike.system.jobs import ProgressFuture, reporting, throttled
from heyoka_bike.system.log import complain
from heyoka_bike.system.machine import versions

_TIMEOUT = 5  # [s], limit for connecting to a scheduler, and for closing the connection
_ERRORS_OF_LOSS = ("FutureCancelledError", "FuturesCancelledError", "CommClosedError")
"""Names of the errors in calls of Dask after the connection to the scheduler is lost."""


@contextmanager
def connected(address: str) -> Iterator[ClusterExecutor]:
    """Connect to a running Dask scheduler.

    Parameters
    ----------
    address
        Address such as ``tcp://127.0.0.1:8786``, or the path of a scheduler file.
    """
    said = "--cluster needs Dask: pip install 'heyoka_bike[cluster]'"
    distributed: Any = required("distributed", said)
    # Silence the loggers of distributed: the error below replaces the many lines that they would
    # print.
    for name in [x for x in logging.root.manager.loggerDict if x.startswith("distributed")]:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    given = {"scheduler_file": address} if Path(address).is_file() else {"address": address}

    class Client(distributed.Client):  # type: ignore[misc]
        def __del__(self) -> None:
            """Do nothing: a client that found no scheduler has nothing to close."""

    try:
        client = Client(**given, timeout=_TIMEOUT, set_as_default=False)
    except Exception as e:  # another program at this address may cause any error
        why = " ".join(str(e).split()) or type(e).__name__
        raise InputError(
            f"--cluster: found no Dask scheduler at {address} within {_TIMEOUT} s ({why:.100}), "
            "expected the address of one that runs, such as tcp://127.0.0.1:8786"
        ) from None
    try:
        cluster = ClusterExecutor(client, address)
        cluster.check()
        yield cluster
    finally:
        with suppress(Exception):
            client.close(timeout=_TIMEOUT)


class ClusterExecutor(Executor):
    """Executor on the workers of a scheduler, which starts a call again if its worker ends.

    A call raises `BrokenExecutor` after it has ended three workers, and `SchedulerLostError` if the
    scheduler is gone.
    """

    def __init__(self, client: Any, address: str) -> None:
        self.client, self.address = client, address
        self._executor = client.get_executor(pure=False, retries=0)
        self._topic = f"heyoka_bike-{uuid4()}"
        self._numbers = count()
        self._futures: WeakValueDictionary[int, ProgressFuture] = WeakValueDictionary()
        client.subscribe_topic(self._topic, self._hear)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> ProgressFuture:
        """Run a call as soon as a worker is free."""
        future, number = ProgressFuture(), next(self._numbers)
        self._futures[number] = future
        try:
            call = self._executor.submit(_run, versions(), self._topic, number, fn, args, kwargs)
        except Exception as e:
            raise self._lost() from e
        future.add_done_callback(lambda _: call.cancel())
        call.add_done_callback(partial(self._end, future))
        return future

    def _hear(self, event: tuple[float, tuple[int, str, float]]) -> None:
        number, stage, t = event[1]
        if (future := self._futures.get(number)) is not None:
            future.progress = stage, t

    def _end(self, future: ProgressFuture, call: Future[Any]) -> None:
        """Copy the result or the error of Dask's call to the future."""
        if not future.set_running_or_notify_cancel():
            return
        error = None if call.cancelled() else call.exception()
        if call.cancelled() or type(error).__name__ in _ERRORS_OF_LOSS:
            error = self._lost()
        if type(error).__name__ == "KilledWorker":
            error = BrokenExecutor("its worker ended")
        if error is None:
            future.set_result(call.result())
        else:
            future.set_exception(error)

    def check(self) -> None:
        """Reject workers with other versions; workers that join later reject their jobs."""
        try:
            found = self.client.run(versions, on_error="return")
            threads = self.client.nthreads()
        except Exception as e:
            raise self._lost() from e
        for worker, there in found.items():
            if isinstance(there, ImportError):
                raise VersionsDifferError(
                    f"{worker}: found no heyoka_bike, expected version {versions()['heyoka_bike']}"
                )
            if isinstance(there, BaseException):
                raise VersionsDifferError(f"{worker}: its versions cannot be read: {there}")
            check_versions(versions(), there, worker)
        if not found:
            complain(f"no worker at {self.address} yet: waiting for one")
        for worker, many in threads.items():
            if many > 1:
                complain(
                    f"{worker} has {many} threads and does one job at a time: start workers with "
                    "--nthreads 1, one for each processor"
                )

    def _lost(self) -> SchedulerLostError:
        """Return the error for a scheduler that is gone."""
        return SchedulerLostError(
            f"--cluster: the scheduler at {self.address} ended or does not answer any more; start "
            "it and its workers again, then repeat the command"
        )


def check_versions(here: dict[str, str], there: dict[str, str], worker: str) -> None:
    """Raise an error that names the first package whose versions differ."""
    for name, expected in here.items():
        if (found := there.get(name, "none")) != expected:
            raise VersionsDifferError(
                f"worker {worker}: found {name} {found}, expected {expected} as in this process; "
                "results might differ"
            )


class _UnwantedError(Exception):
    """Ends a call for whose result nobody waits any more."""


def _run(
    here: dict[str, str], topic: str, number: int, fn: Callable[..., Any], args: Sequence[Any],
    kwargs: Mapping[str, Any],
) -> Any:  # fmt: skip
    """Run a call on a worker, and report its progress."""
    from distributed import get_worker

    worker = get_worker()
    check_versions(here, versions(), worker.address)
    key = worker.get_current_task()
    report = throttled(lambda stage, t: worker.log_event(topic, (number, stage, t)))

    def report_if_wanted(stage: str, t: float) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            raise _UnwantedError
        report(stage, t)

    reporting.set(report_if_wanted)
    return fn(*args, **kwargs)
