"""Results of a fleet's recordings as they come, from workers that may be lost."""

from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from itertools import islice

from .engine import Here, process_pool
from .worker import Done, Plan, Task, reduce_batch

_AHEAD = 3  # batches that wait for each worker
_TRIES = 2  # processes that a log may kill by itself
_KILLED = "KilledWorker"  # what Dask raises for a task that each worker died of
KILLS = "ends whatever process reads it, alone too: look at this log, and report it if it is a good one"
"""Why a log is refused that no worker survives."""


def results_of(
    plan: Plan, batches: Sequence[Sequence[Task]], executor: Executor | None, workers: int
) -> Iterator[Done | str]:
    """Results as they come, by an executor, by processes, or by this one alone."""
    if executor is None and workers > 1:
        return _by_processes(plan, batches, workers)
    return _by(executor or Here(), plan, batches, workers)


def _by(executor: Executor, plan: Plan, batches: Sequence[Sequence[Task]], workers: int) -> Iterator[Done | str]:
    """Results as they come, a few batches ahead of the workers.

    Where the engine says that a batch kills whatever worker does it, its recordings are tried one by one.
    """
    waiting, pending = iter(batches), dict[Future[list[Done]], Sequence[Task]]()

    def submit(batch: Sequence[Task]) -> None:
        pending[executor.submit(reduce_batch, plan, batch)] = batch

    for batch in islice(waiting, _AHEAD * workers):
        submit(batch)
    while pending:
        finished, _ = wait(pending, return_when=FIRST_COMPLETED)
        for future in sorted(finished, key=_failed):  # what is there is not lost with what failed
            batch = pending.pop(future)
            try:
                yield from future.result()
            except BrokenExecutor:
                raise
            except Exception as error:  # of the engine: a worker's own end in a reason
                if type(error).__name__ != _KILLED:
                    raise BrokenExecutor(f"{type(error).__name__}: {error}") from error
                yield "a task killed its workers"
                if len(batch) == 1:
                    yield Done(batch[0].key, b"", KILLS)
                else:
                    for task in batch:
                        submit([task])
            for following in islice(waiting, 1):
                submit(following)


def _failed(future: Future[list[Done]]) -> bool:
    return future.cancelled() or future.exception() is not None


def _by_processes(plan: Plan, batches: Sequence[Sequence[Task]], workers: int) -> Iterator[Done | str]:
    """Results by processes of this machine; lost ones are replaced, a log that kills each of them is refused."""
    left = {task.key: task for batch in batches for task in batch}
    while left:
        try:
            with process_pool(workers) as pool:
                for done in _by(pool, plan, [[task] for task in left.values()], workers):
                    assert isinstance(done, Done)
                    del left[done.key]
                    yield done
        except BrokenExecutor:
            yield f"a worker was lost with {len(left)} recordings to go: it is replaced"
            for task in list(left.values())[: 2 * workers]:  # they begin in this order
                done = _alone(plan, task)
                del left[task.key]
                yield done


def _alone(plan: Plan, task: Task) -> Done:
    """One recording by a process of its own, and by another where that is lost.

    Raises:
        BrokenExecutor: if such processes are lost without any recording.
    """
    for _ in range(_TRIES):
        with process_pool(1) as pool:
            pool.submit(_there).result()
            try:
                (done,) = pool.submit(reduce_batch, plan, [task]).result()
            except BrokenExecutor:
                continue
            return done
    return Done(task.key, b"", KILLS)


def _there() -> None:
    """What a process does that is there at all."""
