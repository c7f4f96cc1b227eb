"""Put a library of the kernel, with sanitizers, in place of the built one; and fuzz its arguments.

    LD_PRELOAD=libasan.so LIPSYNC_LANG_TEST_KERNEL=FILE python -m pytest -p sanitized_kernel ...
    LD_PRELOAD=libasan.so LIPSYNC_LANG_TEST_KERNEL=FILE python sanitized_kernel.py SECONDS SEED

A sanitizer ends the process at the first access out of bounds or undefined step.
"""

import faulthandler
import importlib.util
import os
import sys
import time
from dataclasses import replace
from random import Random

LIBRARY = "LIPSYNC_LANG_TEST_KERNEL"
"""Environment variable: the library that takes the place of the built one."""

MODULE = "lipsync_lang.pipeline._kernel"

if LIBRARY in os.environ:
    spec = importlib.util.spec_from_file_location(MODULE, os.environ[LIBRARY])
    sys.modules[MODULE] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[MODULE])

REFUSALS = (ValueError, TypeError, OverflowError, IndexError, BufferError, MemoryError)
"""Errors that the kernel may raise for arguments that it could not read."""

COUNTS = (-(2**63), -1, 0, 1, 2, 3, 511, 513, 7_000, 2**44, 2**63 - 1)
NUMBERS = (float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 1e-300, 1.0, 59.94, 1e300)


def recorded():
    """Return real arguments of each function of the kernel, by its name."""
    import numpy as np

    import lipsync_lang as ll
    from lipsync_lang.pipeline import kernel

    calls = {}

    class Recorder:
        def __getattr__(self, name):
            real = getattr(sys.modules[MODULE], name)

            def called(*arguments):
                calls.setdefault(name, []).append(arguments)
                return real(*arguments)

            return called

    kernel.compiled = Recorder()
    times = np.cumsum([0.1, 0.1, 0.05, 0.2, 0.1, 0.3])
    words = ll.Word("no", 0, 2, emphasis=1.0), ll.Word("who", 3, 4)
    hum = ll.Audio(np.arange(8000, dtype=np.int16) % 99, 8000)
    labels = "M", "AA1", "B", "UW", "F"
    marked = ll.Schedule(labels, times, words=words, notation="arpabet", audio=hum)
    line = replace(marked, labels=("M", "AA", "B", "UW", "F"), words=())
    for character in ("arkit", "facefx"):
        performer = ll.resolve("english", character)
        performer.perform(line)
        performer.perform(marked)
        stream = performer.stream(60, notation="arpabet")
        for number, label in enumerate(line.labels):
            stream.feed(label, times[number], times[number + 1])
            stream.frames()
        stream.finish()
        stream.frames()
    draw(performer.rigged(performer.perform(line)))
    return calls


def draw(animation):
    """Draw a small picture of a built-in model."""
    from lipsync_lang.render.model.picture import Artist
    from lipsync_lang.render.staging import staged

    Artist(staged(animation), 12).draw(0.3)


def damaged(rng, value, calls):
    """Return another argument in place of a real one."""
    import numpy as np

    kind = rng.randrange(8)
    if isinstance(value, tuple) and value and kind < 7:
        at = rng.randrange(len(value))
        return (*value[:at], damaged(rng, value[at], calls), *value[at + 1 :])
    if isinstance(value, np.ndarray) and value.size and kind < 7:
        return damaged_array(rng, value, kind)
    if isinstance(value, int) and kind < 7:
        return rng.choice((*COUNTS, value - 1, value + 1))
    if isinstance(value, float) and kind < 7:
        return rng.choice(NUMBERS)
    every = [one for made in calls.values() for arguments in made for one in arguments]
    return rng.choice((None, b"", "x", *rng.choices(every, k=3)))


def damaged_array(rng, value, kind):
    """Return an array of another size, kind of number, order or content."""
    import numpy as np

    if kind == 0:
        return value.ravel()[: rng.randrange(value.size)].copy()
    if kind == 1:
        return np.concatenate((value.ravel(), value.ravel()))
    if kind == 2:
        return value.astype(rng.choice(("i1", "i4", "f4", "f8", "c16", "O")))
    if kind == 3:
        return value[::-1] if value.ndim == 1 else np.asfortranarray(value)
    other = value.copy()
    places = [rng.randrange(value.size) for _ in range(rng.choice((1, 1, 5, value.size)))]
    odd = NUMBERS if value.dtype.kind == "f" else COUNTS
    for place in places:
        with np.errstate(all="ignore"):
            other.flat[place] = np.array(rng.choice(odd)).astype(value.dtype)
    return other


def main(seconds, seed):
    """Call the kernel with damaged arguments until a time; print the counts of answers."""
    calls = recorded()
    needed = {"bank", "plan", "utter", "weigh", "energies", "fill", "shade", "average"}
    assert needed <= set(calls), sorted(calls)
    rng, answers, end = Random(seed), {}, time.monotonic() + seconds  # noqa: S311 no secret
    while time.monotonic() < end:
        name = rng.choice(sorted(calls))
        arguments = list(rng.choice(calls[name]))
        for _ in range(rng.choice((1, 1, 2))):
            at = rng.randrange(len(arguments))
            arguments[at] = damaged(rng, arguments[at], calls)
        faulthandler.dump_traceback_later(120, exit=True)
        try:
            getattr(sys.modules[MODULE], name)(*arguments)
            answer = f"{name} performed"
        except REFUSALS:
            answer = f"{name} refused"
        faulthandler.cancel_dump_traceback_later()
        answers[answer] = answers.get(answer, 0) + 1
    print(sum(answers.values()), answers)  # noqa: T201 a command


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]))
