"""Running batches on a Dask cluster. The only module that uses Dask."""

import logging
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import Any

import numpy as np

from .._version import __version__
from ..case.case import Case
from ..errors import UserError, extra
from ..maps.outcome import Outcome
from .batch import Batch, batches, compute
from .runner import Done, Study, invalid

PATIENCE = 15
"""Seconds to wait for a scheduler's answer."""
WORKERS_PATIENCE = 600
"""Seconds to wait for the first worker, which may be queued in a batch system."""
AHEAD = 2
"""Number of batches submitted per worker thread, so that no thread is idle while results are transferred."""
RETRIES = 3

_lane = ThreadPoolExecutor(1)
"""The computing thread of a worker process; Taichi needs the same thread every time."""


class ClusterError(UserError):
    """Raised if a cluster does not answer or cannot run taichiflap; one sentence with the address and the cure."""


def there(address: str, study: Study, pending: np.ndarray) -> Iterator[Done]:
    """Run cases on the scheduler at `address`, or on local worker processes for `"local:N"`; yields results in any
    order.

    If a worker dies, its batch is run again on another.

    Raises:
        ClusterError: if the scheduler does not answer, or the workers cannot run taichiflap.
    """
    distributed = extra("distributed", "cluster", "--cluster needs Dask", ClusterError)
    waiting = batches(study.case, study.design, pending, 1)
    refused: list[Done] = []
    with ExitStack() as stack:
        client = _connect(distributed, address, stack)
        _await_workers(distributed, client, address)
        coming = distributed.as_completed()
        running: dict[Any, Batch] = {}

        def send() -> None:
            most = AHEAD * max(1, sum(client.nthreads().values()))
            while len(running) < most and (batch := next(waiting, None)) is not None:
                if not isinstance(batch, Batch):
                    refused.append(invalid(*batch))
                    continue
                options = {"retries": RETRIES, "pure": False}
                future = client.submit(work, __version__, batch.cases, study.metrics, study.keep_series, **options)
                running[future] = batch
                coming.add(future)

        send()
        while running:
            future = next(coming)
            batch = running.pop(future)
            try:
                # Wait again if the worker that finished it has died meanwhile.
                outcomes = future.result()
            except Exception as error:
                raise ClusterError(f"--cluster {address}: a batch of cases failed on a worker: {error}") from None
            yield Done(batch.numbers, outcomes, batch.work)
            send()
    yield from refused


def work(version: str, cases: Sequence[Case], metrics: Sequence[str], keep_series: bool) -> list[Outcome]:
    """Run a batch in a worker process, on one thread.

    Raises:
        ClusterError: if the worker has another version of taichiflap.
    """
    if version != __version__:
        raise ClusterError(
            f"the worker has taichiflap {__version__} but the study was started with {version}; install the same "
            "version"
        )
    return _lane.submit(compute, cases, metrics, keep_series, 1).result()


def _connect(distributed: Any, address: str, stack: ExitStack) -> Any:
    place, _, count = address.partition(":")
    if place == "local":
        if not count.isdecimal() or not 1 <= int(count) <= 1024:
            raise ClusterError(f"--cluster {address}: write local:N with N worker processes, 1 to 1024")
        processes = {"n_workers": int(count), "threads_per_worker": 1, "processes": True, "host": "127.0.0.1"}
        options = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
        local = distributed.LocalCluster(**processes, **options)
        return stack.enter_context(distributed.Client(stack.enter_context(local)))
    began = time.monotonic()
    # Errors are reported here, in one sentence.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        return stack.enter_context(_within(PATIENCE + 1, lambda: distributed.Client(address, timeout=PATIENCE)))
    except Exception as error:  # any exception of Dask for another server's answer
        lines = str(error).splitlines() or ["no answer"]
        raise ClusterError(
            f"--cluster {address}: no Dask scheduler answers there, after {time.monotonic() - began:.0f} s "
            f"({lines[0]}); start one with: dask scheduler"
        ) from None


def _within(seconds: float, work: Callable[[], Any]) -> Any:
    """The result of some work, with a time limit, since Dask never stops waiting for a server that accepts a connection
    but does not answer.

    Raises:
        TimeoutError: if it takes longer.
    """
    found: list[Any] = []
    failed: list[Exception] = []

    def try_it() -> None:
        try:
            found.append(work())
        except Exception as error:  # raised again by the waiting thread
            failed.append(error)

    thread = threading.Thread(target=try_it, daemon=True)
    thread.start()
    thread.join(seconds)
    if failed:
        raise failed[0]
    if not found:
        raise TimeoutError("no answer")
    return found[0]


def _await_workers(distributed: Any, client: Any, address: str) -> None:
    """Wait for the first worker.

    Raises:
        ClusterError: if there is none after `WORKERS_PATIENCE`.
    """
    for patience in (PATIENCE, WORKERS_PATIENCE):
        try:
            client.wait_for_workers(1, timeout=patience)
        except (TimeoutError, distributed.TimeoutError):
            if patience == PATIENCE:
                print(f"--cluster {address}: no workers yet; waiting for {WORKERS_PATIENCE} s more", file=sys.stderr)
        else:
            return
    raise ClusterError(
        f"--cluster {address}: the scheduler has no workers, after {PATIENCE + WORKERS_PATIENCE} s; "
        f"start one with: dask worker {address}"
    )
