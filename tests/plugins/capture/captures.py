"""Captures for tests: the curves of a known face, with errors."""

from dataclasses import replace

import numpy as np

import lipsync_lang as ll
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.performer import Performer
from lipsync_lang.plugins.capture.fit_lines import CapturedLine, lay_lines
from lipsync_lang.plugins.capture.fit_values import FitFace
from lipsync_lang.resolver.retouch import OpenPair

SOUNDS = tuple(
    "M P B F V TH DH T D N S Z SH CH JH L R K G NG HH W Y "  # noqa: SIM905 a table of words
    "IY IH EH AE AA AO UH UW AH ER EY AY OW AW OY".split()
)

LEAST_SECONDS = 0.015
"""Minimum length of a sound after errors of timings."""

FPS = 60


def open_pair(language="english", character="facefx"):
    """Return a pair with its packs, and its performer."""
    pair = OpenPair.open(Library(project=None), language, character)
    return pair, Performer(pair.compiled, pair.compiled.motion)


def random_lines(random, count, sounds=38):
    """Return schedules of random sounds of about four seconds each."""
    return [
        ll.Schedule(
            ["_", *random.choice(SOUNDS, sounds), "_"],
            np.concatenate(([0, 0.3], 0.3 + np.cumsum(lengths), [0.6 + lengths.sum()])),
            notation="arpabet",
        )
        for lengths in random.uniform(0.05, 0.14, (count, sounds))
    ]


def captured(performer, schedules, random=None, *, jitter=0.0, noise=0.0, speaker=""):  # noqa: PLR0913
    """Capture a performer: weights with `noise`, timings with errors of `jitter` seconds."""
    out = []
    for number, schedule in enumerate(schedules):
        shown = performer.perform(schedule, FPS)
        values, times = shown.weights, np.array(schedule.times)
        if random is not None:
            values = values + random.normal(0, noise, values.shape)
            times[1:-1] += random.normal(0, jitter, len(times) - 2)
            for at in range(1, len(times)):
                times[at] = max(times[at], times[at - 1] + LEAST_SECONDS)
        told = replace(schedule, times=times)
        gains = np.eye(len(shown.poses))
        name = f"line{number:02}"
        out.append(
            CapturedLine(name, told, shown.times, shown.poses, values, gains, speaker=speaker)
        )
    return out


def changed_face(pair, performer, random, schedules):
    """Return a performer with randomly changed targets, as the truth of a fit."""
    face = FitFace.of(pair, lay_lines(performer, captured(performer, schedules), FPS))
    start = face.start
    weights, dominance = start.weights.copy(), start.dominance.copy()
    free = face.free(start)
    count = int(free.sum())
    moved = weights[free] * random.uniform(0.6, 1.4, count) + random.normal(0, 0.05, count)
    weights[free] = np.where(weights[free] > 0, np.clip(moved, 0.02, 1), 0)
    named = free.any(axis=1)
    dominance[named] += random.normal(0, 0.4, int(named.sum()))
    truth = replace(start, weights=weights, dominance=dominance)
    return Performer(replace(pair.compiled, tables=face.tables_with(truth)), pair.compiled.motion)


def rms(errors):
    """Return the root mean square of errors."""
    return float(np.sqrt(np.mean(np.square(errors))))
