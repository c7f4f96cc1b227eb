"""Recordings without a text as lines of a corpus: their phonemes are heard, and kept on disk.

What was heard counts as what was read does. It is likely in sum, and often wrong in a single place.
"""

import json
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from glob import escape
from hashlib import sha256
from pathlib import Path

import numpy as np

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.finding import IPA
from lipsync_lang.reports.coverage.reading_cache import READINGS_FILE, ReadingCache, versions
from lipsync_lang.resolver.cache import folder
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.sound.speech.hearing.recognition import recognised
from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import Line
from lipsync_lang.text.lines.line_readers import by_suffix
from lipsync_lang.text.phonology.g2p import SpokenWord

HEARD_BY = "sound"
"""The recogniser, which hears every language."""


def is_recording(path: Path) -> bool:
    """Return True for the name of a recording."""
    return path.suffix.lower() in AUDIO_SUFFIXES


def unwritten(paths: Iterable[Path]) -> list[Path]:
    """Return the recordings among files and folders that have no text of their name beside them."""
    found: dict[Path, None] = {}
    for path in paths:
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        found |= dict.fromkeys(one for one in inside if is_recording(one))
    return [one for one in found if not any(map(is_text, one.parent.glob(f"{escape(one.stem)}.*")))]


def is_text(path: Path) -> bool:
    """Return True for the name of a file of lines or timings."""
    return path.suffix.lower() in by_suffix()


def heard_lines(
    recordings: Iterable[Path], speaker: Speaker, remark: Callable[[str], None]
) -> Iterator[Line]:
    """Yield each recording as a line with a schedule, whose labels count and whose times do not.

    A recording that cannot be read is left out with a remark.
    """
    kept = _kept(speaker)
    for path in recordings:
        try:
            # By content: a renamed or copied recording is heard once.
            key = sha256(path.read_bytes()).hexdigest()
            words = kept.get(key) if kept else None
            if words is None:
                labels = recognised(speaker, path, recogniser=HEARD_BY).labels
                words = (SpokenWord("", tuple(labels)),)
                if kept:
                    kept.update({key: words})
        except (SpeechError, OSError) as error:
            remark(f"{path}: left out: {str(error).removeprefix(f'{path}: ')}")
            continue
        labels = words[0].labels
        # Labels count, and their times do not; equal steps make it a valid schedule.
        schedule = Schedule(
            labels, np.arange(len(labels) + 1.0), notation=IPA,
            language=speaker.manner.language, source="recording", recognised=True,
        )  # fmt: skip
        yield Line("", f"{path}:1", path.stem, schedule=schedule)


def _kept(speaker: Speaker) -> ReadingCache | None:
    """Return what was heard in a language before; None if nothing can be kept."""
    home, notation = folder(), speaker.notations.get(IPA)
    if home is None or notation is None:
        return None
    settings = json.dumps([HEARD_BY, sorted(notation.table), versions()])
    with suppress(OSError, sqlite3.Error):
        return ReadingCache(home / READINGS_FILE, sha256(settings.encode()).digest())
    return None
