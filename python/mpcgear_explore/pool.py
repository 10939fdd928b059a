"""Workers by Dask: threads here, each waiting for a process, or a cluster behind a scheduler."""

import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import dask
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, wait
from distributed.client import ClosedClientError

from mpcgear_explore.worker import StudyStopped

_OWN = "127.0.0.1:0"
"""Where Dask shows itself, for this machine alone; without an address it would be for everyone."""


class Crashed(Exception):
    """A task took its workers with it, more often than Dask tries."""


@contextmanager
def _scheduler() -> Iterator[None]:
    """A scheduler that does not answer any more stops the study."""
    try:
        yield
    except (CancelledError, ClosedClientError, OSError) as error:
        raise StudyStopped("the scheduler is gone; start it, its workers and this command again") from error


class Pool:
    """Where tasks run."""

    def __init__(self, workers: int, scheduler: str | None) -> None:
        """Starts `workers` here, or goes to `scheduler`. Raises StudyStopped where nobody answers."""
        # What matters of a lost task or scheduler is told by the study itself.
        logging.getLogger("distributed").setLevel(logging.ERROR)
        dask.config.set({"distributed.admin.tick.limit": "60s", "distributed.comm.timeouts.connect": "10s"})
        self._cluster: LocalCluster | None = None
        if scheduler is None:
            # A trial is a process of its own, so workers need none.
            self._cluster = LocalCluster(
                n_workers=1,
                threads_per_worker=workers,
                processes=False,
                memory_limit=0,
                dashboard_address=_OWN,
                worker_dashboard_address=_OWN,
            )
        try:
            self._client = Client(self._cluster if scheduler is None else scheduler)
            self._client.wait_for_workers(1, timeout=60)
        except (OSError, TimeoutError) as error:
            raise StudyStopped(f"no worker at {scheduler or 'this machine'}: {error}") from error

    def __enter__(self) -> "Pool":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close(timeout=5)
        if self._cluster is not None:
            self._cluster.close(timeout=5)

    @property
    def workers(self) -> int:
        """Tasks that run at the same time now. Raises StudyStopped where the scheduler is gone."""
        with _scheduler():
            return max(int(sum(self._client.nthreads().values())), 1)

    def submit(self, task: Callable[[Any], Any], argument: Any) -> Future[Any]:
        """Starts a task. Raises StudyStopped where the scheduler is gone."""
        with _scheduler():
            return self._client.submit(task, argument, pure=False)

    def finished(self, futures: Iterable[Future[Any]]) -> set[Future[Any]]:
        """Waits until one of them is done; those that are. Raises StudyStopped where the scheduler is gone."""
        with _scheduler():
            done: set[Future[Any]] = wait(list(futures), return_when="FIRST_COMPLETED").done
            return done

    def result(self, future: Future[Any]) -> Any:
        """Result of a task. Raises Crashed, and StudyStopped where the scheduler is gone."""
        try:
            with _scheduler():
                return future.result()
        except KilledWorker as error:
            raise Crashed(f"its workers died: {error}") from error
