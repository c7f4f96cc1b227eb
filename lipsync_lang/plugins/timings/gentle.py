"""Gentle's JSON: words with their times, and the lengths of the phones in each.

Times are seconds. The letter after the underscore of a phone such as `ae_I` is its place in the
word. Words that Gentle did not find in the sound have no times: if there is time for them between
two others, they are taken to be said there, without phonemes; else the mouth rests. Remarks name
them.
"""

import re

from lipsync_lang.base.errors import shortlist
from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.timing_file import first_item

LEAST_WORD_SECONDS = 0.1
"""Shortest time of a word that was not found."""

UNREAD = "oov"
"""Label of a word without phonemes, as Gentle writes it for words that its dictionary lacks."""

PLACE = re.compile(r"_[BEIS]$")
"""A phone at the beginning, end or inside of a word, or a single phone."""

GENTLE_FORM = (
    '{"words": [{"word": "a", "start": 0.1, "phones": [{"phone": "ah_S", "duration": 0.1}]}]}'
)


def sniff(source: TimingFile) -> bool:
    """Return True if the first word has phones, or states how it was aligned."""
    first = first_item(source.document.get("words")) if source.holds("words") else None
    return isinstance(first, dict) and bool(first.keys() & {"case", "phones", "alignedWord"})


@reader("gentle", ".json", sniff=sniff)
def read_gentle(source: TimingFile) -> Schedule:
    """Words and phones of the aligner Gentle."""
    words = source.json.get("words") if isinstance(source.json, dict) else None
    rows: list[LabelRow] = []
    spans: list[LabelRow] = []
    lost: list[str] = []
    waiting: list[str] = []
    placed: list[str] = []
    for word in source.object_list(words, f"has no list of words; the form is {GENTLE_FORM}"):
        text = str(word.get("word") or word.get("alignedWord") or "")
        if word.get("start") is None:
            waiting.append(text)
            continue
        start = at = source.number(word["start"])
        if spans and waiting and start - spans[-1].end >= LEAST_WORD_SECONDS * len(waiting):
            rows.append(LabelRow(UNREAD, spans[-1].end, start))
            spans.append(LabelRow(" ".join(waiting), spans[-1].end, start))
            placed += waiting
        else:
            lost += waiting
        waiting = []
        what = f"a word has no list of phones; the form is {GENTLE_FORM}"
        for phone in source.object_list(word.get("phones"), what):
            end = at + source.number(phone.get("duration"))
            rows.append(LabelRow(PLACE.sub("", str(phone.get("phone", ""))), at, end))
            at = end
        spans.append(LabelRow(text, start, at))
    lost += waiting
    if lost and not rows:
        raise source.fault("no word was found in the recording; align it again")
    told = [
        f"{source.path}: not found in the recording, so {what}: {shortlist(some)}"
        for some, what in (
            (lost, "the mouth rests"), (placed, "they are doubtful where they fill a gap"),
        )
        if some
    ]  # fmt: skip
    return schedule_of(source, rows, words=spans, remarks=told)
