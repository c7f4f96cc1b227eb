"""Words of texts on disk, by text, language and version, so that a text is read once.

So are phonemes of recordings without a text, which are lines of a corpus. What was heard counts as
what was read does. It is likely in sum, and often wrong in a single place.

A damaged, locked or unwritable file costs only time: the texts are read again.
"""

import json
import re
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from glob import escape
from hashlib import blake2b, sha256
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

import numpy as np

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extras import PROGRAM
from lipsync_lang.packs.finding import IPA
from lipsync_lang.performing.performer import Performer
from lipsync_lang.resolver.cache import compiler, folder
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.sound.speech.hearing.recognition import recognised
from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import Line
from lipsync_lang.text.lines.line_readers import by_suffix
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES

READINGS_FILE = "readings.sqlite"

MAX_READINGS_BYTES = 2**29
"""Maximum size of the file, which is then deleted."""

KEY_BYTES = 16
"""Length of the digest of a text with its settings."""

HEARD_BY = "sound"
"""The recogniser, which hears every language."""


class ReadingCache:
    """Words of texts, as read with some settings."""

    def __init__(self, path: Path, settings: bytes) -> None:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if path.exists() and path.stat().st_size > MAX_READINGS_BYTES:
            path.unlink()
        self._settings = settings
        self._rows = sqlite3.connect(path, timeout=1)
        # A cache may be lost with the power; each commit would wait for the disk otherwise.
        self._rows.execute("PRAGMA synchronous = OFF")
        self._rows.execute("CREATE TABLE IF NOT EXISTS readings (key BLOB PRIMARY KEY, words TEXT)")

    def get(self, text: str) -> tuple[SpokenWord, ...] | None:
        """Return the words of a text; None if it was not read yet."""
        with suppress(sqlite3.Error, TypeError, ValueError):
            query = "SELECT words FROM readings WHERE key = ?"
            for (row,) in self._rows.execute(query, [self._key(text)]):
                return tuple(
                    SpokenWord(spelling, tuple(labels), respelled, unread, tuple(stress))
                    for spelling, labels, respelled, unread, stress in json.loads(row)
                )
        return None

    def update(self, read: Mapping[str, tuple[SpokenWord, ...]]) -> None:
        """Keep the words of texts."""
        rows = [(self._key(text), json.dumps(words)) for text, words in read.items()]
        with suppress(sqlite3.Error), self._rows:
            self._rows.executemany("INSERT OR REPLACE INTO readings VALUES (?, ?)", rows)

    def _key(self, text: str) -> bytes:
        written = text.encode("utf-8", "surrogatepass")
        return blake2b(written, key=self._settings, digest_size=KEY_BYTES).digest()


def reading_cache(performer: Performer) -> ReadingCache | None:
    """Return the words that a performer's language was read as; None if they cannot be kept."""
    manner, home = performer.speaker.manner, folder()
    if home is None or manner.engine not in G2P_ENGINES.modules:
        return None  # nobody knows when an engine of another package changes
    plain = manner.plain()
    # It was a set, whose order differs from process to process.
    plain["settings"]["labels"].sort()
    try:
        lexicon = manner.settings.file.read_bytes() if manner.settings.file else b""
        settings = json.dumps([plain, performer.compiled.notations, versions()], sort_keys=True)
        whole = sha256(settings.encode() + lexicon).digest()
        return ReadingCache(home / READINGS_FILE, whole)
    except (OSError, sqlite3.Error):
        return None


@cache
def versions() -> list[str]:
    """Return the digest of the program's code, and the versions of all libraries that it uses."""
    found = [compiler()]
    for requirement in requires(PROGRAM) or ():
        name = re.split(r"[^\w.-]", requirement)[0]
        with suppress(PackageNotFoundError):
            found.append(f"{name} {version(name)}")
    return sorted(set(found))


def is_recording(path: Path) -> bool:
    """Return True for the name of a recording."""
    return path.suffix.lower() in AUDIO_SUFFIXES


def unwritten(paths: Iterable[Path]) -> list[Path]:
    """Return the recordings among files and folders that have no text of their name beside them."""
    found: dict[Path, None] = {}
    for path in paths:
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        found |= dict.fromkeys(one for one in inside if is_recording(one))
    texts = by_suffix().keys()  # of files of lines and of timings
    return [
        one
        for one in found
        if texts.isdisjoint(p.suffix.lower() for p in one.parent.glob(f"{escape(one.stem)}.*"))
    ]


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
