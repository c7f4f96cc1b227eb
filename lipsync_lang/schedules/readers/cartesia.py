"""Cartesia: the times of phonemes and of words that come with its speech, as JSON.

Answers of the stream are in one list, or one on each line. Those of times have a list of phonemes
or words, one of starts and one of ends, in seconds; the others hold sound.
"""

from operator import methodcaller

from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.rows import listed_rows
from lipsync_lang.schedules.timed_words import phones_or_words

TIMESTAMP_LISTS = {"phoneme_timestamps": "phonemes", "word_timestamps": "words"}
"""Fields with times, and the lists of their labels."""

CARTESIA_FORM = '{"phoneme_timestamps": {"phonemes": ["m"], "start": [0.1], "end": [0.19]}}'


@reader("cartesia", ".json", ".jsonl", sniff=methodcaller("mentions", *TIMESTAMP_LISTS))
def read_cartesia(source: TimingFile) -> Timings:
    """Times of phonemes and words that Cartesia gives with its speech."""
    found = {name: list[LabelRow]() for name in TIMESTAMP_LISTS}
    for line, answer in source.events:
        for name, labels in TIMESTAMP_LISTS.items():
            times = answer.get(name) if isinstance(answer, dict) else None
            if isinstance(times, dict):
                lists = [times.get(one) for one in (labels, "start", "end")]
                found[name] += listed_rows(source, *lists, form=CARTESIA_FORM, line=line)
    return phones_or_words(source, *found.values())
