"""Whisper and its relatives: words or segments with their times, as JSON.

Read are WhisperX, whisper-timestamped, faster-whisper, stable-ts, whisper.cpp, the answers of
OpenAI's service and of Hugging Face's pipelines, and Vosk's results, which look the same. A word
without times, such as a number in WhisperX, fills the gap between its neighbours, or between one of
them and an end of the segment. Without a gap, it shares the times of the word before it. A segment
without words is timed as a whole.
"""

from collections import defaultdict
from collections.abc import Sequence
from itertools import groupby, zip_longest
from typing import Any, NamedTuple

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, TimedWords, TimingFile, reader, timed_words_of
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND
from lipsync_lang.schedules.tiers import Tier, only
from lipsync_lang.schedules.timed_words import TYPICAL_WORD_SECONDS
from lipsync_lang.schedules.timing_file import first_item

SEGMENT_LISTS = ("segments", "transcription", "chunks", "result", "words")
"""Fields of the document that hold segments or words, in the order in which they are looked for."""

TEXT_FIELDS = ("word", "text")
CONFIDENCES = ("probability", "confidence", "score", "conf", "p")

LEAST_GAP_SECONDS = 0.05
"""Shortest gap that words without times fill; a shorter one is rounding."""

WHISPER_FORM = '{"segments": [{"words": [{"word": "maps", "start": 0.1, "end": 0.62}, ...]}, ...]}'


class RecognisedPart(NamedTuple):
    """A word or a segment with the name of its speaker; times of None are unknown."""

    text: str
    start: float | None
    end: float | None
    confidence: float | None
    speaker: str


def sniff(source: TimingFile) -> bool:
    """Return True if the first item of a known list has a text, and times or words."""
    if source.holds("phonemes"):
        return False
    first = first_item(_items(source.document))
    if not isinstance(first, dict) or not first.keys() & {*TEXT_FIELDS, "words"}:
        return False
    return bool(first.keys() & {"start", "timestamp", "offsets", "timestamps"}) and (
        first.keys().isdisjoint({"phoneme_ts", "case", "phones", "alignedWord"})
    )


@reader("whisper", ".json", sniff=sniff, tiers=True)
def read_whisper(source: TimingFile) -> TimedWords:
    """Words of Whisper's relatives (WhisperX, faster-whisper, whisper.cpp, ...) and of Vosk."""
    said: defaultdict[str, list[LabelRow]] = defaultdict(list)
    for item in _objects(source, _items(source.json)):
        words = item.get("words") or item.get("tokens")
        parts = _joined(source, item, words) if isinstance(words, list) else [_part(source, item)]
        for one in parts:
            if one.start is not None:
                end = one.start + TYPICAL_WORD_SECONDS if one.end is None else one.end
                row = LabelRow(one.text, one.start, end, confidence=one.confidence)
                said[one.speaker].append(row)
    speakers = [Tier(name, ()) for name in said]
    chosen = only(source, speakers, "speakers").name if speakers else ""
    rate = MILLISECONDS_PER_SECOND if source.holds("transcription") else None
    return timed_words_of(source, said[chosen], rate=rate, guess=True)


def _items(document: object) -> object:
    """Return the list of segments or words of a document."""
    if not isinstance(document, dict):
        return document
    lists = [document[name] for name in SEGMENT_LISTS if isinstance(document.get(name), list)]
    words = document.get("words")
    if not lists:
        return None
    nested = any(isinstance(one, dict) and one.get("words") for one in lists[0])
    return words if words and isinstance(words, list) and not nested else lists[0]


def _objects(source: TimingFile, items: object) -> list[Json]:
    what = f"has no list of segments or words; the form is {WHISPER_FORM}"
    return source.object_list(items, what)


def _joined(source: TimingFile, item: Json, words: list[Any]) -> list[RecognisedPart]:
    """Return the words of a segment; untimed ones and parts of words are joined to a neighbour."""
    in_parts = not item.get("words")  # tokens of the model, which split words
    groups: list[list[RecognisedPart]] = []
    timed = False
    segment = _part(source, item)
    speaker = {"speaker": item.get("speaker")}
    given = [_part(source, speaker | word) for word in _objects(source, words)]
    for one in given if in_parts else _in_gaps(given, segment):
        if one.text.startswith("[_"):  # a mark of the model's, not a word
            continue
        inside = in_parts and not one.text.startswith(" ")
        if groups and (inside or one.start is None or not timed):
            groups[-1].append(one)
        else:
            groups.append([one])
            timed = False
        timed = timed or one.start is not None
    if groups and not any(one.start is not None for one in groups[0]):
        return [segment]
    joined = []
    for parts in groups:
        times = [one for one in parts if one.start is not None]
        ends = [one.end for one in times if one.end is not None]
        text = ("" if in_parts else " ").join(one.text for one in parts)
        joined.append(times[0]._replace(text=text, end=ends[-1] if ends else None))
    return joined


def _in_gaps(words: Sequence[RecognisedPart], segment: RecognisedPart) -> list[RecognisedPart]:
    """Let successive words without times be one part, which fills the gap around them."""
    runs = [[*run] for _, run in groupby(words, lambda one: one.start is None)]
    parts: list[RecognisedPart] = []
    for run, after in zip_longest(runs, runs[1:]):
        start = parts[-1].end if parts else segment.start
        end = after[0].start if after else segment.end
        gap = 0.0 if start is None or end is None else end - start
        if run[0].start is None and gap >= LEAST_GAP_SECONDS and len(runs) > 1:
            text = " ".join(one.text for one in run)
            parts.append(run[0]._replace(text=text, start=start, end=end))
        else:
            parts += run
    return parts


def _part(source: TimingFile, item: Json) -> RecognisedPart:
    text = next((item[name] for name in TEXT_FIELDS if isinstance(item.get(name), str)), "")
    pair: list[Any] = [item.get("start"), item.get("end")]
    if isinstance(item.get("timestamp"), list):
        # the last chunk of a pipeline may lack its end
        pair = [*item["timestamp"], None, None][:2]
    elif isinstance(item.get("offsets"), dict):
        pair = [item["offsets"].get("from"), item["offsets"].get("to")]
    start, end = (None if one is None else source.number(one) for one in pair)
    sure = next((item[name] for name in CONFIDENCES if name in item), None)
    speaker = item.get("speaker")
    sure = float(sure) if isinstance(sure, (int, float)) and 0 <= sure <= 1 else None
    # laughter and music are written like words
    text = "" if item.get("type") == "audio_event" else text
    return RecognisedPart(text, start, end, sure, speaker if isinstance(speaker, str) else "")
