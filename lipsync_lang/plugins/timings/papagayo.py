"""Papagayo and Papagayo-NG: `.pgo`, text, and `.pg2`, JSON.

Both count frames from 0. Voices have phrases, phrases have words, and words have the start frames
of their mouth shapes. A word includes its last frame. Between words the mouth rests. A `.pg2` names
the set of its shapes; those of a `.pgo` are Preston Blair's, the program's default.
"""

from collections.abc import Sequence
from typing import NamedTuple

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.rows import Start, shapes_of
from lipsync_lang.schedules.tiers import Tier, only

PRESTON_BLAIR_NOTATION = "preston-blair"

SOUND_SET_PREFIX = "cmu"
"""Prefix of the name of a set with sounds instead of mouth shapes."""

PAPAGAYO_HEADER = "lipsync version 1"


class PapagayoWord(NamedTuple):
    """A word: its first and last frame, and the start frames of its mouth shapes."""

    text: str
    first: float
    last: float
    starts: Sequence[Start]
    line: int | None


Voices = dict[str, list[PapagayoWord]]


def sniff(source: TimingFile) -> bool:
    """Return True if the file has the program's header, or voices and a frame rate."""
    return source.head.startswith(PAPAGAYO_HEADER) or source.holds("voices", "fps")


@reader("papagayo", ".pgo", ".pg2", sniff=sniff, tiers=True)
def read_papagayo(source: TimingFile) -> Schedule:
    """Papagayo's .pgo and .pg2: mouth shapes or sounds by frames, with words; one voice."""
    written = source.holds("voices", "fps")
    fps, notation, voices = _of_json(source) if written else _of_text(source)
    named = [Tier(name, ()) for name, spoken in voices.items() if spoken or source.tier is not None]
    words = sorted(voices[only(source, named, "voices").name], key=lambda word: word.first)
    rows, spans = [], []
    for number, word in enumerate(words):
        following = words[number + 1].first if number + 1 < len(words) else float("inf")
        # The last frame is shown whole, unless the next word begins on it.
        end = min(word.last + 1, max(following, word.last))
        spans.append(LabelRow(word.text, word.first, end, word.line))
        stops = [*(start for _, start, _ in word.starts[1:]), end]
        rows += [
            LabelRow(s[0], s[1], stop, s[2]) for s, stop in zip(word.starts, stops, strict=True)
        ]
    if notation is None:
        return schedule_of(source, rows, words=spans, rate=fps)
    return shapes_of(source, rows, words=spans, notation=notation, rate=fps)


class _PapagayoLines:
    """Lines of a `.pgo`, taken one after the other."""

    def __init__(self, source: TimingFile) -> None:
        self.source = source
        self.rows = source.text.split("\n")
        self.number = 0

    def next(self) -> str:
        """Return the next line; raise an error at the end of the file."""
        if self.number == len(self.rows):
            raise self.source.fault("ends too early; save it again", self.number)
        self.number += 1
        return self.rows[self.number - 1].strip()

    def count(self, text: str | None = None) -> int:
        """Return a number of frames or of items."""
        text = self.next() if text is None else text
        if not text.isdecimal() or len(text) > 9:  # noqa: PLR2004 no line has a billion frames
            raise self.source.fault(f"{text[:40]!r} is not a number of frames", self.number)
        return int(text)

    def fields(self, count: int) -> list[str]:
        """Return the fields of the next line; the first may contain spaces."""
        found = self.next().rsplit(None, count - 1)
        if len(found) != count:
            raise self.source.fault(f"needs {count} parts, but has {len(found)}", self.number)
        return found


def _of_text(source: TimingFile) -> tuple[float, str, Voices]:
    lines = _PapagayoLines(source)
    if lines.next() != PAPAGAYO_HEADER:
        raise source.fault(f"does not start with '{PAPAGAYO_HEADER}'", 1)
    lines.next()  # the sound
    fps = lines.count()
    if not fps:
        raise source.fault("has 0 frames per second", lines.number)
    lines.count()  # the length of the sound
    voices: Voices = {}
    for _ in range(lines.count()):
        words = voices.setdefault(lines.next(), [])
        lines.next()  # its text
        for _ in range(lines.count()):
            for _ in range(3):  # a phrase, its first and its last frame
                lines.next()
            for _ in range(lines.count()):
                text, first, last, count = lines.fields(4)
                at, start, end = lines.number, lines.count(first), lines.count(last)
                starts: list[Start] = []
                for _ in range(lines.count(count)):
                    frame, label = lines.fields(2)
                    starts.append((label, lines.count(frame), lines.number))
                words.append(PapagayoWord(text, start, end, starts, at))
    return fps, PRESTON_BLAIR_NOTATION, voices


def _of_json(source: TimingFile) -> tuple[float, str | None, Voices]:
    whole = source.json
    fps = source.number(whole["fps"])
    if fps <= 0:
        raise source.fault("the field fps must be above 0")
    name = str(whole.get("phoneme_set") or PRESTON_BLAIR_NOTATION)
    notation = None if name.lower().startswith(SOUND_SET_PREFIX) else name.lower().replace("_", "-")
    voices: Voices = {}
    for voice in _parts(source, whole, "voices"):
        words = voices.setdefault(str(voice.get("name", "")), [])
        for phrase in _parts(source, voice, "phrases"):
            for word in _parts(source, phrase, "words"):
                starts: list[Start] = [
                    (str(part.get("text", "")), source.number(part.get("frame")), None)
                    for part in _parts(source, word, "phonemes")
                ]
                first = source.number(word.get("start_frame"))
                last = source.number(word.get("end_frame"))
                words.append(PapagayoWord(str(word.get("text", "")), first, last, starts, None))
    return fps, notation, voices


def _parts(source: TimingFile, whole: Json, name: str) -> list[Json]:
    return source.object_list(whole.get(name), f"`{name}` must be a list of objects")
