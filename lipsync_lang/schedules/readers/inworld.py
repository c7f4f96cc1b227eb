"""Inworld: the times of words and of the phones in them that come with its speech, as JSON.

Answers of a stream are in one list, or one on each line, some within a ``result``. Times are
seconds. A voice without phones gives words alone.
"""

from operator import methodcaller

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.rows import listed_rows
from lipsync_lang.schedules.timed_words import phones_or_words

INWORLD_FIELD = "timestampInfo"

INWORLD_FORM = (
    '{"timestampInfo": {"wordAlignment": {"words": ["maps"], "wordStartTimeSeconds": [0.1], '
    '"wordEndTimeSeconds": [0.62], "phoneticDetails": [{"wordIndex": 0, "phones": [{"phoneSymbol": '
    '"m", "startTimeSeconds": 0.1, "durationSeconds": 0.09}]}]}}}'
)


@reader("inworld", ".json", ".jsonl", sniff=methodcaller("mentions", INWORLD_FIELD))
def read_inworld(source: TimingFile) -> Timings:
    """Times of words and phones that Inworld gives with its speech."""
    phones: list[LabelRow] = []
    words: list[LabelRow] = []
    for line, answer in source.events:
        whole = _object(source, answer, line)
        stamps = _object(source, whole.get("result", whole), line).get(INWORLD_FIELD)
        if stamps is None:
            continue
        aligned = _object(source, _object(source, stamps, line).get("wordAlignment"), line)
        names = ("words", "wordStartTimeSeconds", "wordEndTimeSeconds")
        found = listed_rows(source, *map(aligned.get, names), form=INWORLD_FORM, line=line)
        # Spaces and punctuation stand among the words.
        words += [row for row in found if any(map(str.isalnum, row.label))]
        for detail in source.objects(aligned, "phoneticDetails", INWORLD_FORM, line):
            for phone in source.objects(detail, "phones", INWORLD_FORM, line):
                start = source.number(phone.get("startTimeSeconds"), line)
                end = start + source.number(phone.get("durationSeconds"), line)
                phones.append(LabelRow(str(phone.get("phoneSymbol", "")), start, end, line))
    return phones_or_words(source, phones, words)


def _object(source: TimingFile, value: object, line: int | None) -> Json:
    if not isinstance(value, dict):
        raise source.fault(f"has no alignment of words; the form is {INWORLD_FORM}", line)
    return value
