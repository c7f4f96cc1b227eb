"""Batches on a Dask cluster, which runs a lost worker's batches elsewhere.

Values that batches share are a task of their own, named by its content: each worker fetches it
once, from the scheduler or from another worker, and it is made again if all its workers are gone.
Clients with the same packs share it; changed packs are another task.

The scheduler and its workers are trusted: Dask sends pickles.
"""

import logging
import pickle
import platform
import time
import warnings
from collections import OrderedDict
from collections.abc import Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from lipsync_lang import LipsyncError
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.files.temporary import sweep, temporary_name
from lipsync_lang.base.files.writing import cannot_write
from lipsync_lang.production.builds.workers import Job, LostBatch, Parcel, cluster

if TYPE_CHECKING:
    from distributed import Client, Future

BUSY_BATCHES = 2
"""Number of submitted batches that keeps a worker busy: a running one and a waiting one."""

LIMIT_SECONDS = 10
"""Time limit for answers of a scheduler and its workers."""

RETRIES = 2
"""Number of runs of a batch after an error, on any free worker."""

COUNT_SECONDS = 5.0
"""Interval at which workers are counted."""

MAX_SHARED = 8
"""Maximum number of shared values in workers."""

CHECKED = ("distributed", "numpy")
"""Packages that must have the same version everywhere; with another numpy, bytes may differ."""

PACKAGE = "lipsync-lang"

PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64"}
"""Other names of families of processors, as systems call them."""

MARK = "seen"
"""Name of the file that tests the access of workers to the project's folder."""


@cluster("dask")
def run_on_cluster(jobs: Iterator[Job], address: str, folder: Path | None) -> Generator[Any]:
    """Run jobs on a cluster and yield their results; see `run_batches`."""
    with _client(address) as client, sight_mark(folder) as mark:
        check_versions(client, address)
        check_sight(client, folder, mark)
        yield from _ClusterRun(client, address, mark).results(jobs)


@contextmanager
def _client(address: str) -> "Iterator[Client]":
    """Connect to a scheduler."""
    try:
        import distributed
    except ImportError:
        what = "Dask is not installed here; install it"
        raise LipsyncError(f"{what}: {install_line('cluster')}") from None
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # errors are told by us, once
    warnings.filterwarnings("ignore", "Sending large graph")

    class Calm(distributed.Client):  # type: ignore[misc]  # a class without types
        """Client whose deletion does not wait 20 s for a missing scheduler."""

        def __del__(self) -> None:
            pass

    start = "start one with `dask scheduler`, and name the address that it prints"
    try:
        _greet(address)
        client = Calm(address, timeout=LIMIT_SECONDS, set_as_default=False)
    except (ValueError, TypeError, KeyError) as error:
        what = f"'{address}' is not the address of a Dask scheduler ({error})"
        raise LipsyncError(f"{what}; {start}, such as tcp://host:8786") from None
    except (OSError, RuntimeError) as error:
        why = f" ({error})" if str(error) else ""
        raise LipsyncError(
            f"{address}: no Dask scheduler answers within {LIMIT_SECONDS} s{why}; {start}"
        ) from None
    try:
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=LIMIT_SECONDS)


def _greet(address: str) -> None:
    """Greet a Dask server, since a client would wait forever for another server."""
    import asyncio

    from distributed import Security
    from distributed.comm import connect

    async def greeting() -> None:
        security = Security().get_connection_args("client")
        comm = await connect(address, timeout=LIMIT_SECONDS, **security)
        # An orderly close may wait for a server that does not speak Dask's protocol.
        comm.abort()

    asyncio.run(asyncio.wait_for(greeting(), LIMIT_SECONDS + 1))


def check_versions(client: "Client", address: str) -> None:
    """Raise an error if there are no workers, or if one has other versions than this machine.

    Warn of workers with processors of another family, of which lines may differ by a rounding.
    """
    try:
        client.wait_for_workers(1, timeout=LIMIT_SECONDS)
    except TimeoutError:
        raise LipsyncError(
            f"{address}: the scheduler has no workers; start one with "
            f"`dask worker {address} --nthreads 1` for each processor"
        ) from None
    found = client.get_versions(packages=[PACKAGE])
    own = _versions(found["client"])
    named = {"the scheduler": found["scheduler"], **found["workers"]}
    for name, answer in named.items():
        versions = _versions(answer)
        for package, wanted in own.items():
            if name == "the scheduler" and package in {"numpy", PACKAGE}:
                continue  # it only passes things on
            if versions[package] != wanted:
                raise LipsyncError(
                    f"{address}: {name} has {package} {versions[package] or '(none)'}, this "
                    f"machine {wanted}; install the same versions on all machines: "
                    f'pip install "lipsync-lang[cluster]=={own[PACKAGE]}" '
                    f"distributed=={own['distributed']} numpy=={own['numpy']}"
                )
    here = _processor(found["client"])
    for kind in {_processor(answer) for answer in found["workers"].values()} - {here}:
        warnings.warn(
            f"{address}: has workers with processors of another family ({kind}, this machine "
            f"{here}), so their lines may differ in the last digits; use workers of one family "
            "if every byte counts",
            stacklevel=2,
        )


def _processor(answer: dict[str, Any]) -> str:
    name = str(answer["host"]["machine"]).lower()
    return PROCESSORS.get(name, name)


def _versions(answer: dict[str, Any]) -> dict[str, str | None]:
    packages = answer["packages"]
    python = ".".join(str(packages["python"]).split(".")[:2])
    return {"Python": python, **{n: packages.get(n) for n in (*CHECKED, PACKAGE)}}


@contextmanager
def sight_mark(folder: Path | None) -> Iterator[str]:
    """Write a file into the project's folder while the block runs, and yield its path."""
    if folder is None:
        yield ""
        return
    folder = folder.resolve()
    path = folder / temporary_name(MARK)
    sweep(folder, again=True)  # the file of a killed process
    try:
        path.touch()
    except OSError as error:
        raise cannot_write(folder, error, "copy the project to another folder") from None
    try:
        yield str(path)
    finally:
        path.unlink(missing_ok=True)


def check_sight(client: "Client", folder: Path | None, mark: str) -> None:
    """Raise an error if a worker does not see the project's folder."""
    if folder is None:
        return
    try:
        seen = client.run(_sees, mark)
    except (ImportError, AttributeError) as error:
        what = f"a worker of the cluster has another lipsync-lang ({error})"
        raise LipsyncError(f"{what}; install the same on all machines") from None
    blind = sorted(worker for worker, sees in seen.items() if not sees)
    if blind:
        more = f" and {len(blind) - 1} more" if len(blind) > 1 else ""
        what = f"the worker {blind[0]}{more} does not see this folder"
        mend = "share it under the same path with every machine of the cluster"
        raise LipsyncError(f"{folder.resolve()}: {what}; {mend}")


def _sees(mark: str) -> bool:
    return not mark or Path(mark).exists()


class _ClusterRun:
    """Jobs that pass through a cluster, a few at a time."""

    def __init__(self, client: "Client", address: str, mark: str) -> None:
        self._client, self._address, self._mark = client, address, mark
        self._values: OrderedDict[str, Future] = OrderedDict()
        self._room = 0
        """Number of submitted batches that keeps every worker busy."""
        self._counted = 0.0

    def results(self, jobs: Iterator[Job]) -> Iterator[Any]:
        """Yield results in order of completion."""
        from distributed import as_completed

        running: dict[Future, Job] = {}
        completed = as_completed(loop=self._client.loop)
        try:
            while True:
                if time.monotonic() - self._counted > COUNT_SECONDS:
                    # The scheduler may be away for a while; the last number serves meanwhile.
                    with suppress(OSError, ValueError):
                        self._room = BUSY_BATCHES * max(1, len(self._client.nthreads()))
                    self._counted = time.monotonic()
                while len(running) < self._room and (job := next(jobs, None)):
                    batch = pickle.dumps(job.batch)  # Dask would look for tasks in tuples
                    values = [self._value(p) for p in (job.work, job.shared) if p is not None]
                    settings = {"retries": RETRIES, "pure": False, "key": f"lipsync-{uuid4()}"}
                    future = self._client.submit(run_there, self._mark, batch, *values, **settings)
                    running[future] = job
                    completed.add(future)
                if not running:
                    return
                future = next(completed)
                yield self._result(future, running.pop(future))
        finally:
            with suppress(Exception):
                self._client.cancel(list(running), force=True)

    def _value(self, parcel: Parcel) -> "Future":
        """Return the task of a shared value, which every worker fetches once."""
        if parcel.key not in self._values:
            self._values[parcel.key] = self._client.submit(
                Parcel, parcel.key, parcel.content, key=f"lipsync-packed-{parcel.key}"
            )
            if len(self._values) > MAX_SHARED:
                # Dask keeps a value as long as somebody holds its future; dropping it frees the
                # workers.
                self._values.popitem(last=False)
        self._values.move_to_end(parcel.key)
        return self._values[parcel.key]

    def _result(self, future: "Future", job: Job) -> Any:
        from concurrent.futures import CancelledError

        from distributed import KilledWorker

        try:
            return pickle.loads(future.result())  # noqa: S301 of our workers
        except KilledWorker:
            message = (
                "the workers that had these lines died, one after another (out of memory?); give "
                "them more memory, or build the lines here"
            )
            return LostBatch(job.batch, message)
        except (CancelledError, OSError) as error:
            if isinstance(error, OSError) and error.errno is not None:
                raise  # of the work itself
            raise LipsyncError(
                f"{self._address}: the scheduler is gone; finished lines are kept: start it again, "
                "and build again"
            ) from None


def run_there(mark: str, batch: bytes, *parcels: Parcel) -> bytes:
    """Run a batch in a worker, which may have joined after the start."""
    if not _sees(mark):
        raise LipsyncError(
            f"{Path(mark).parent}: the worker on {platform.node()} does not see this folder; share "
            "it under the same path with every machine of the cluster"
        )
    work, *more = parcels
    job = Job(work, more[0] if more else None, pickle.loads(batch))  # noqa: S301 of our client
    return pickle.dumps(job.run())
