"""Executors: processes of this machine, and the workers of a Dask cluster. Both are only a map."""

import multiprocessing
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from ...common.errors import InputError

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class Here(Executor):
    """Does each task at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *arguments: Any, **more: Any) -> Future[Any]:
        """The task's result, or what it raised."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*arguments, **more))
        except Exception as error:  # whatever a task raises is what its future holds
            future.set_exception(error)
        return future


@contextmanager
def process_pool(workers: int) -> Iterator[Executor]:
    """Processes with one thread of linear algebra each; what waits is dropped when the block is left."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


@contextmanager
def dask_executor(scheduler: str | None, workers: int) -> Iterator[tuple[Executor, int]]:
    """The workers of a Dask cluster and their number: of a running scheduler, or of one of this machine.

    Args:
        scheduler: its address, "tcp://host:8786"; None for a cluster of one's own.
        workers: of a cluster of one's own.

    Raises:
        InputError: if Dask is not installed, no scheduler answers, it has no workers, or they have another version.
    """
    try:
        import distributed
    except ModuleNotFoundError:
        raise InputError("--scheduler needs Dask: pip install 'dynident[fleet]'") from None
    try:
        client = (
            distributed.Client(scheduler, timeout=10, set_as_default=False)
            if scheduler
            else distributed.Client(n_workers=workers, threads_per_worker=1, dashboard_address=None)
        )
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(f"no scheduler answers at {scheduler}: {error}") from None
    with client:
        count = len(client.scheduler_info(n_workers=-1)["workers"])
        if not count:
            raise InputError(f"the scheduler at {scheduler} has no workers: start 'dask worker {scheduler}'")
        yield client.get_executor(pure=False), count
