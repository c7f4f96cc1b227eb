"""Formats of timings in JSON that differ in their paths and the names of their fields alone."""

from lipsync_lang.schedules.records import RecordFormat, RecordList
from lipsync_lang.schedules.timing_readers import TIMING_READERS

RECORD_FORMATS = (
    RecordFormat(
        "azure-recognition",
        "Words that Azure has recognised, with phonemes where it has assessed their pronunciation.",
        mentions=("NBest",),
        # The first of several readings of the sound is the best.
        words=RecordList("Word", "Offset", "NBest[0].Words", duration="Duration", unnamed=True),
        # Languages without names of phonemes have their times alone.
        phonemes=RecordList(
            "Phoneme", "Offset", "NBest[0].Words.Phonemes", duration="Duration", unnamed=True
        ),
        unit="ticks",
        form='{"NBest": [{"Words": [{"Word": "maps", "Offset": 1000000, "Duration": 5200000, '
        '"Phonemes": [{"Phoneme": "m", "Offset": 1000000, "Duration": 900000}]}]}]}',
    ),
)

for one in RECORD_FORMATS:
    TIMING_READERS.add(one.name, one.reader(), __name__)
