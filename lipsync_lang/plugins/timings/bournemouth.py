"""The Bournemouth Forced Aligner: segments of speech with their phones and words, in JSON.

Times are milliseconds. A phone may end before the next one of its word starts, where the aligner is
sure of the middle alone: it lasts until the next one then. Version 2.0.0 may write
`overflow` as the IPA of a phone; its label beside holds the sound.
"""

from bisect import bisect_right
from operator import attrgetter

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND
from lipsync_lang.schedules.timing_file import first_item

BOURNEMOUTH_FORM = (
    '{"segments": [{"phoneme_ts": [{"ipa_label": "m", "start_ms": 0, "end_ms": 80}], '
    '"words_ts": [{"word": "maps", "start_ms": 0, "end_ms": 400}]}]}'
)

NO_IPA = "overflow"


def sniff(source: TimingFile) -> bool:
    """Return True if the first segment has phones."""
    first = first_item(source.document.get("segments")) if source.holds("segments") else None
    return isinstance(first, dict) and "phoneme_ts" in first


@reader("bournemouth", ".json", sniff=sniff)
def read_bournemouth(source: TimingFile) -> Schedule:
    """Phones and words of the Bournemouth Forced Aligner."""
    rows: list[LabelRow] = []
    words: list[LabelRow] = []
    told: set[str] = set()
    for segment in source.objects(source.json, "segments", BOURNEMOUTH_FORM):
        spans = _rows(source, segment, "words_ts", "word")
        phones = _rows(source, segment, "phoneme_ts", "ipa_label", "phoneme_label")
        # The last word that starts before a phone's middle is the phone's, unless it has ended.
        starts = [word.start for word in spans]
        middles = [(phone.start + phone.end) / 2 for phone in phones]
        numbers = [bisect_right(starts, middle) - 1 for middle in middles]
        inside = [n >= 0 and at < spans[n].end for n, at in zip(numbers, middles, strict=True)]
        joined = list(phones)
        for at in range(len(phones) - 1):
            together = inside[at] and inside[at + 1] and numbers[at] == numbers[at + 1]
            if together and phones[at].end < phones[at + 1].start:
                joined[at] = phones[at]._replace(end=phones[at + 1].start)
        if joined != phones:
            what = "there are gaps between the sounds of a word; each sound is extended to the next"
            told.add(f"{source.path}: {what}")
        rows += joined
        words += spans
    return schedule_of(source, rows, words=words, rate=MILLISECONDS_PER_SECOND, remarks=told)


def _rows(source: TimingFile, segment: Json, name: str, *labels: str) -> list[LabelRow]:
    """Return the rows of a list by time; the first of `labels` that a row has is its label."""
    rows = []
    for one in source.objects(segment, name, BOURNEMOUTH_FORM):
        stated = [str(one[label]) for label in labels if label in one]
        text = next((label for label in stated if label != NO_IPA), "")
        start, end = source.number(one.get("start_ms")), source.number(one.get("end_ms"))
        rows.append(LabelRow(text, start, end))
    return sorted(rows, key=attrgetter("start"))
