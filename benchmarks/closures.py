"""Closures of the lips in an alignment, each judged where it can be heard.

A stop inside speech is judged by its onset, the moment at which the lips press. A stop after a
pause is silent until its release, and one before a pause is silent from its onset on, so a first
stop is judged by its release, and a last one by its onset. A nasal sounds throughout: its onset
counts everywhere. The pauses are those of the known labels.

How closures are paired: both sequences of labels become common phonemes, silence left out, and the
longest runs that agree are matched (difflib). A closure counts where the phoneme on the other side
of the judged boundary is matched, too; an edge of the text has none on its outer side.
"""

from collections.abc import Iterable, Iterator
from difflib import SequenceMatcher
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.schedules import SILENCE, Schedule
from lipsync_lang.sound.speech.speaking.speaker import Speaker

CLOSURE = "bmp"
"""The common phoneme of pressed lips."""

NASALS = ("m", "M", "ɱ")
"""First signs of labels of nasals, in the notations of the known labels."""

FRAMES_OFF = 2 / 60

PLACES = {
    "nasal": "onset of a nasal",
    "inside": "onset of a stop inside speech",
    "first": "release of a first stop",
    "last": "onset of a last stop",
}
"""Kinds of closures, and the moments by which they are judged."""


class Sounded(NamedTuple):
    """A common phoneme with its time; `pause` tells which of its sides is silent."""

    name: str
    label: str
    start: float
    end: float
    pause: tuple[bool, bool]


def sounded(schedule: Schedule, speaker: Speaker) -> list[Sounded]:
    """Return the labels of a schedule without silence; those of several phonemes have no name."""
    notation = speaker.notations[schedule.notation or "ipa"]
    names = []
    for label in schedule.labels:
        found = [name for name, _ in notation.find(label) or ()]
        names.append(found[0] if len(found) == 1 else label)
    silent = [True, *(name == SILENCE for name in names), True]
    times = schedule.times.tolist()
    return [
        Sounded(name, label, times[n], times[n + 1], (silent[n], silent[n + 2]))
        for n, (name, label) in enumerate(zip(names, schedule.labels, strict=True))
        if name != SILENCE
    ]


def place_of(one: Sounded) -> str:
    """Return the kind of a closure."""
    if one.label.startswith(NASALS):
        return "nasal"
    before, after = one.pause
    return "first" if before else "last" if after else "inside"


def closures(found: Schedule, known: Schedule, speaker: Speaker) -> Iterator[tuple[str, float]]:
    """Yield for each paired closure its kind, and aligned less known seconds."""
    here, there = sounded(found, speaker), sounded(known, speaker)
    names = [[one.name for one in some] for some in (here, there)]
    for a, b, size in SequenceMatcher(None, *names, autojunk=False).get_matching_blocks():
        for n in range(size):
            one, true = here[a + n], there[b + n]
            if true.name != CLOSURE:
                continue
            place = place_of(true)
            if place == "first":
                if n + 1 < size:
                    yield place, one.end - true.end
            elif n or not (a or b):
                yield place, one.start - true.start


def by_place(off: Iterable[tuple[str, float]]) -> dict[str, dict[str, Any]]:
    """Return the number of closures of each kind, their median error, and the share far off."""
    rows = list(off)
    found = {}
    for place in PLACES:
        late = np.abs([seconds for one, seconds in rows if one == place])
        if len(late):
            median, share = float(np.median(late)) * 1000, float(np.mean(late > FRAMES_OFF))
            found[place] = {"closures": len(late), "median_ms": median, "off": share}
    return found


def print_places(found: dict[str, dict[str, Any]]) -> None:
    """Print a row for each kind of closure."""
    for place, one in found.items():
        print(f"  {PLACES[place]:30}{one['closures']:6}{one['median_ms']:8.1f}{one['off']:8.0%}")
