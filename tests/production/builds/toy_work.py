"""Work for batches, in a module because processes and clusters import it by name."""

import os
import signal
import time
from io import BytesIO
from pathlib import Path

from places import ROOT, TESTS

import lipsync_lang as ll
from lipsync_lang.animations.animation_writers import WRITERS

FATAL = "fatal"

WORKER_ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join(map(str, (ROOT, TESTS, TESTS / "production/builds"))),
}
"""Environment of processes that import this module."""


def lines():
    sounds = ("M", "AA", "S", "UW", "F", "IY")
    return [
        (n, ll.Schedule((sounds[n % 6], "AA", sounds[(n + 1) % 6]), [0, 0.1, 0.3, 0.4]))
        for n in range(24)
    ]


def doubled(batch):
    return [2 * number for number in batch]


def named(batch, shared):
    return batch, shared["name"], len(shared["weight"])


LENGTH = 32_000_000
"""Bytes of an answer that takes a while to send."""


def lengthy(_):
    return bytes(LENGTH)


def refused(batch):
    raise ValueError(f"no {batch}")


def deadly(batch):
    """End the process on one batch, in every run."""
    if batch == FATAL:
        os.kill(os.getpid(), signal.SIGKILL)
    return batch


def deadly_once(batch):
    """End the process of the batch that finds no file, and leave the file."""
    number, file = batch
    if file is not None and not Path(file).exists():
        Path(file).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def leisurely(batch):
    time.sleep(0.05)
    return os.getpid(), batch


def written(batch, performer):
    """Return the number of a line and its CSV."""
    number, schedule = batch
    out = BytesIO()
    WRITERS["csv"].write(performer.perform(schedule, 30), out)
    return number, out.getvalue()
