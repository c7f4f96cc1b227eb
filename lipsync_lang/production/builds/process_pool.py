"""Batches in processes of this machine, some of which may die.

A process that dies (killed for lack of memory, say) takes the whole pool along, and nobody knows
which batch was to blame. So a new pool runs each batch that was on its way alone. A batch that
ends its process again then is lost; the others go on.
"""

import os
from collections import deque
from collections.abc import Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Self

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.child_processes import child_pool, deaf_to_interrupts
from lipsync_lang.production.builds.workers import (
    BATCHES_PER_WORKER,
    Job,
    LostBatch,
    MissingValues,
    run_job,
)

MAX_DEATHS = 2
"""Maximum number of processes that a batch may end while it runs alone."""

WORKERS_ENDED = (
    "worker processes end as soon as they start: build in one process (workers=1), and in a script "
    'of your own, put the call under `if __name__ == "__main__":`'
)


def run_in_processes(jobs: Iterator[Job], count: int) -> Generator[Any]:
    """Run jobs in `count` processes and yield their results; see `run_batches`."""
    alone = deque[Job]()
    while True:
        with _Pool(count) as pool:
            yield from pool.run(jobs, count * BATCHES_PER_WORKER)
            alone += pool.unfinished
        if not alone:
            return
        yield from _run_alone(alone)


def _run_alone(jobs: deque[Job]) -> Iterator[Any]:
    """Run jobs one at a time, to find the job that ends its process."""
    deaths = 0
    while jobs:
        with _Pool(1) as pool:
            try:  # if even an empty task fails, the jobs are not to blame
                pool.executor.submit(os.getpid).result()
            except BrokenProcessPool:
                raise LipsyncError(WORKERS_ENDED) from None
            while jobs:
                yield from pool.run(iter((jobs[0],)), 1)
                if pool.unfinished:
                    break
                jobs.popleft()
                deaths = 0
        if pool.unfinished:
            deaths += 1
            if deaths >= MAX_DEATHS:
                message = (
                    "its worker process died twice, the second time with only these lines (out of "
                    "memory?); build them separately with --workers 1"
                )
                yield LostBatch(jobs.popleft().batch, message)
                deaths = 0


class _Pool:
    """Processes that end with the block, with their parent, or with a signal to it."""

    def __init__(self, count: int) -> None:
        self.executor = child_pool(count)
        self.unfinished: list[Job] = []
        """Unfinished jobs when a process died."""
        self._sent: dict[tuple[str, ...], int] = {}
        self._count = count

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is not None:
            for process in list((self.executor._processes or {}).values()):  # noqa: SLF001 public from 3.14 on
                process.kill()
        self.executor.shutdown(cancel_futures=True)

    def run(self, jobs: Iterator[Job], room: int) -> Iterator[Any]:
        """Yield results until the jobs are done or a process has died."""
        running: dict[Future[Any], Job] = {}
        again = deque[Job]()
        broken = False
        while not broken:
            while len(running) < room and (job := again.popleft() if again else next(jobs, None)):
                # A job carries its values until every process should have them.
                sent = self._sent.get(job.key, 0)
                self._sent[job.key] = sent + 1
                try:
                    with deaf_to_interrupts():
                        one = job if sent < self._count else job.bare
                        running[self.executor.submit(run_job, one)] = job
                except BrokenProcessPool:
                    again.appendleft(job)
                    broken = True
                    break
            if not running:
                break
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                job = running.pop(future)
                try:
                    result = future.result()
                except BrokenProcessPool:
                    self.unfinished.append(job)
                    broken = True
                    continue
                if isinstance(result, MissingValues):
                    self._sent.pop(job.key, None)
                    again.append(job)
                else:
                    yield result
        self.unfinished += again
        for future, job in running.items():  # all of them end with the pool
            if future.exception() is None and not isinstance(future.result(), MissingValues):
                yield future.result()
            else:
                self.unfinished.append(job)
