"""Spread batches of work: in this process, over processes of this machine, or on a Dask cluster.

The work is a callable of a batch. It is pickled once, named by its content, and travels to each
worker once; so does what batches share, such as a performer. Results come in order of completion,
and their bytes do not depend on who worked. Few batches are on their way at any time, so that
millions of lines take no more memory than hundreds.

A process that dies (killed for lack of memory, say) takes the whole pool along, and nobody knows
which batch was to blame. So a new pool runs each batch that was on its way alone. A batch that
ends its process again then is lost; the others go on.
"""

import os
import pickle
from collections import OrderedDict, deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from threading import Lock
from typing import Any, Generic, NamedTuple, Self, TypeVar

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extensions import Extensions
from lipsync_lang.base.files.child_processes import child_pool

Batch = TypeVar("Batch")
Result = TypeVar("Result")

MAX_OPENED = 6
"""Maximum number of unpickled values in a worker: the work, and shared values."""

MAX_PACKED = 16
"""Maximum number of pickled values in memory."""

BATCHES_PER_WORKER = 2
"""Number of submitted batches per worker: a running one and a waiting one."""


RunOnCluster = Callable[[Iterator["Job"], str, Path | None], Generator[Any]]
"""Runs jobs on the machines of a scheduler, given its address and a folder; see `run_batches`."""

CLUSTERS: Extensions[RunOnCluster] = Extensions("clusters", "cluster")

cluster = CLUSTERS.register
"""Decorator that registers a function as the cluster of a name."""

DASK = "dask"
"""Name of the cluster that serves the addresses of schedulers."""


@dataclass(frozen=True)
class LostBatch(Generic[Batch]):
    """Batch whose worker died whenever it was run."""

    batch: Batch
    message: str
    """The reason, with a cure."""


def run_batches(  # noqa: PLR0913 the work, and settings of the workers
    work: Callable[..., Result],
    batches: Iterable[Batch],
    *,
    shared: Callable[[Batch], object] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    folder: Path | None = None,
) -> Generator[Result | LostBatch[Batch]]:
    """Run work on batches and yield the results in order of completion.

    A batch whose workers died again and again yields a `LostBatch`. Close the iterator when you
    stop early (`contextlib.closing`): this ends the processes. Raises LipsyncError if the number of
    workers is below 1; the scheduler is absent, of another version, without workers, or one of them
    does not see the folder. Errors of `work` are raised as they are.

    Parameters
    ----------
    work : called with a batch, and with what it shares if `shared` is given; it and its results
        can be pickled
    batches : read as they are needed
    shared : what a batch shares with others, such as a performer; the same object for all of them
    workers : processes; 1 for this process alone, None for one per processor
    scheduler : address of a Dask scheduler, such as ``tcp://host:8786``, instead of processes
    folder : folder that every worker of a cluster must see under the same path

    Examples
    --------
    >>> from lipsync_lang.production.builds.workers import run_batches
    >>> list(run_batches(sum, [(1, 2), (3, 4)], workers=1))
    [3, 7]
    """
    if workers is not None and workers < 1:
        raise LipsyncError(f"{workers} workers: give 1 or more")
    if scheduler is not None and workers is not None:
        raise LipsyncError("name either a scheduler or a number of workers; a cluster has its own")
    count = workers or os.cpu_count() or 1
    if scheduler is None and count == 1:
        return (work(one) if shared is None else work(one, shared(one)) for one in batches)
    jobs = pack_jobs(work, batches, shared)
    if scheduler is None:
        return run_in_processes(jobs, count)
    return CLUSTERS.find(DASK)(jobs, scheduler, folder)


# On the way


class Parcel(NamedTuple):
    """Pickled value, named by its content."""

    key: str
    content: bytes | None
    """None on the way to a worker that should have it."""

    @property
    def bare(self) -> "Parcel":
        """The name without the value."""
        return Parcel(self.key, None)


def parcel_of(value: object) -> Parcel:
    """Pickle a value; equal content has the same key in every process."""
    content = pickle.dumps(value, pickle.HIGHEST_PROTOCOL)
    return Parcel(blake2b(content, digest_size=16).hexdigest(), content)


class Job(NamedTuple):
    """Batch on its way to a worker."""

    work: Parcel
    shared: Parcel | None
    batch: Any

    @property
    def bare(self) -> "Job":
        """The job for a worker that has its values."""
        return Job(self.work.bare, self.shared and self.shared.bare, self.batch)

    @property
    def key(self) -> tuple[str, ...]:
        """Keys of the values that the worker needs."""
        return (self.work.key, self.shared.key) if self.shared else (self.work.key,)

    def run(self) -> Any:
        """Run the job in a worker; return `MissingValues` if it came without a value not here.

        Threads of a process take turns: performers and engines are not made for several at once.
        """
        with _at_work:
            parcels = [parcel for parcel in (self.work, self.shared) if parcel is not None]
            lacking = [p.key for p in parcels if p.content is None and p.key not in opened]
            if lacking:
                return MissingValues(tuple(lacking))
            values = []
            for key, content in parcels:
                if key not in opened and content is not None:
                    opened[key] = pickle.loads(content)  # noqa: S301 of our own parent
                    if len(opened) > MAX_OPENED:
                        opened.popitem(last=False)
                opened.move_to_end(key)
                values.append(opened[key])
            work, *more = values
            return work(self.batch, *more)


def pack_jobs(
    work: Callable[..., Any], batches: Iterable[Batch], shared: Callable[[Batch], object] | None
) -> Iterator[Job]:
    """Yield batches with their work and their shared state, each pickled once."""
    parcel = parcel_of(work)
    known: OrderedDict[int, tuple[object, Parcel]] = OrderedDict()  # keeps the object: ids recur
    for batch in batches:
        if shared is None:
            yield Job(parcel, None, batch)
            continue
        value = shared(batch)
        if id(value) not in known:
            known[id(value)] = value, parcel_of(value)
            if len(known) > MAX_PACKED:
                known.popitem(last=False)
        known.move_to_end(id(value))
        yield Job(parcel, known[id(value)][1], batch)


# In a worker


class MissingValues(NamedTuple):
    """Answer of a worker without a value."""

    keys: tuple[str, ...]


opened: OrderedDict[str, Any] = OrderedDict()
_at_work = Lock()


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
            # One that ends within an answer would leave its reader waiting for the rest of it,
            # as long as a writer is open: this is the last one.
            self.executor._result_queue._writer.close()  # type: ignore[attr-defined]  # noqa: SLF001
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
                    one = job if sent < self._count else job.bare
                    running[self.executor.submit(one.run)] = job
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
