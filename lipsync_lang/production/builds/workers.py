"""Spread batches of work: in this process, over processes of this machine, or on a Dask cluster.

The work is a callable of a batch. It is pickled once, named by its content, and travels to each
worker once; so does what batches share, such as a performer. Results come in order of completion,
and their bytes do not depend on who worked. Few batches are on their way at any time, so that
millions of lines take no more memory than hundreds.
"""

import os
import pickle
from collections import OrderedDict
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from threading import Lock
from typing import Any, Generic, NamedTuple, TypeVar

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extensions import Extensions

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

    Close the iterator when you stop early (`contextlib.closing`): this ends the processes.

    Parameters
    ----------
    work : called with a batch, and with what it shares if `shared` is given; it and its results
        can be pickled
    batches : read as they are needed
    shared : what a batch shares with others, such as a performer; the same object for all of them
    workers : processes; 1 for this process alone, None for one per processor
    scheduler : address of a Dask scheduler, such as ``tcp://host:8786``, instead of processes
    folder : folder that every worker of a cluster must see under the same path

    Yields
    ------
    What `work` returns, or a `LostBatch` for a batch whose workers died again and again

    Raises
    ------
    LipsyncError
        The number of workers is below 1; the scheduler is absent, of another version, without
        workers, or one of them does not see the folder. Errors of `work` are raised as they are.

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
        from lipsync_lang.production.builds.process_pool import run_in_processes

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


def run_job(job: Job) -> Any:
    """Run a job in a worker; return `MissingValues` if it came without a value that is not here.

    Threads of a process take turns: performers and engines are not made for several at once.
    """
    with _at_work:
        parcels = [parcel for parcel in (job.work, job.shared) if parcel is not None]
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
        return work(job.batch, *more)
