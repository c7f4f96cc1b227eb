"""ElevenLabs: the times of characters that come with its speech, as JSON.

An answer has an `alignment` with characters, their starts, and their ends in seconds or durations
in milliseconds. Answers of a stream are in one list, or one on each line. Characters between spaces
make a word.
"""

import re

from lipsync_lang.schedules import LabelRow, TimedWords, TimingFile, reader, timed_words_of
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND, listed_rows
from lipsync_lang.schedules.timing_file import first_item, plain_fields

STARTS = re.compile(r'"char(acter)?_?start_?times?_?\w{2,7}"\s*:', re.IGNORECASE)
"""The name of the list of starts, which ends with its unit."""

ELEVENLABS_FORM = (
    '{"alignment": {"characters": ["H", "i"], "character_start_times_seconds": [0.0, 0.1], '
    '"character_end_times_seconds": [0.1, 0.3]}}'
)

CONTAINERS = ("alignment", "normalizedalignment")
"""Fields that hold times, the better one first: the other's numbers are written out."""


def sniff(source: TimingFile) -> bool:
    """Return True if the file names starts of characters, at its start or within an alignment."""
    if STARTS.search(source.head):
        return '"timestampInfo"' not in source.head  # another service's
    whole = source.document
    first = plain_fields(first_item(whole) or whole)
    held = [plain_fields(first.get(name)) for name in CONTAINERS]
    return any(times.keys() & {"characters", "chars"} for times in held)


@reader("elevenlabs", ".json", ".jsonl", sniff=sniff)
def read_elevenlabs(source: TimingFile) -> TimedWords:
    """Times of characters that ElevenLabs gives with its speech, joined to words."""
    words: list[list[LabelRow]] = [[]]
    rate, latest = None, 0.0
    for line, answer in source.events:
        plain = plain_fields(answer)
        held = plain_fields(next((plain[name] for name in CONTAINERS if plain.get(name)), plain))
        times = {re.sub("^character", "char", name): one for name, one in held.items()}
        if "chars" not in times:  # an answer without times ends a stream
            continue
        rate = MILLISECONDS_PER_SECOND if "charstarttimesms" in times else None
        starts, ends, lengths = (
            next((one for name, one in times.items() if name.startswith(f"char{part}")), None)
            for part in ("start", "end", "duration")
        )
        lists = times["chars"], starts, lengths if ends is None else ends
        for one in listed_rows(
            source, *lists, form=ELEVENLABS_FORM, line=line, durations=ends is None
        ):
            # a stream whose answers were sorted or merged would give words of mixed letters
            if one.start < latest:
                raise source.fault(f"{one.label!r} starts before the character before it", line)
            latest = one.start
            if one.label.isspace():
                words.append([])
            else:
                words[-1].append(one)
    joined = [
        LabelRow("".join(one.label for one in spelled), spelled[0].start, spelled[-1].end)
        for spelled in words
        if spelled
    ]
    return timed_words_of(source, joined, rate=rate)
