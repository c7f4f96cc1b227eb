"""Azure's recognition of speech: words and, where pronunciation is assessed, their phonemes.

Offsets and durations count ticks of 100 ns. The first of several readings of the sound is the best.
Results are a JSON object, or several in a list or one on each line.
"""

from operator import methodcaller

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.readers.azure import TICKS_PER_SECOND
from lipsync_lang.schedules.timed_words import phones_or_words

NBEST_FIELD = "NBest"

RECOGNITION_FORM = (
    '{"NBest": [{"Words": [{"Word": "maps", "Offset": 1000000, "Duration": 5200000, "Phonemes": '
    '[{"Phoneme": "m", "Offset": 1000000, "Duration": 900000}]}]}]}'
)


@reader("azure-recognition", ".json", ".jsonl", sniff=methodcaller("mentions", NBEST_FIELD))
def read_azure_recognition(source: TimingFile) -> Timings:
    """Words that Azure has recognised, with phonemes where it has assessed their pronunciation."""
    phones: list[LabelRow] = []
    words: list[LabelRow] = []
    for line, result in source.events:
        for best in source.objects(result, NBEST_FIELD, RECOGNITION_FORM, line)[:1]:
            for word in source.objects(best, "Words", RECOGNITION_FORM, line):
                words.append(_row(source, word, "Word", line))
                spelled = source.objects(word, "Phonemes", RECOGNITION_FORM, line)
                phones += [_row(source, phone, "Phoneme", line) for phone in spelled]
    return phones_or_words(source, phones, words, rate=TICKS_PER_SECOND)


def _row(source: TimingFile, told: Json, name: str, line: int | None) -> LabelRow:
    start = source.number(told.get("Offset"), line)
    end = start + source.number(told.get("Duration"), line)
    return LabelRow(str(told.get(name, "")), start, end, line)
