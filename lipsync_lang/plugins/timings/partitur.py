"""BAS Partitur: tiers of a spoken text; each line begins with the name of its tier.

``MAU: start duration link label`` is a phone, in samples at the rate of `SAM`; the duration is one
sample short. The link is the number of the word, or -1. ``ORT: link word`` gives its spelling.
"""

import re

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of

PHONES, WORDS, RATE = "MAU", "ORT", "SAM"


def sniff(source: TimingFile) -> bool:
    """Return True if the file starts with Partitur's header."""
    return re.match(r"\s*LHD:", source.head) is not None


@reader("partitur", ".par", sniff=sniff)
def read_partitur(source: TimingFile) -> Schedule:
    """BAS Partitur with a tier of MAUS, and the words of its text."""
    rows: list[LabelRow] = []
    words: dict[str, str] = {}
    spans: dict[str, LabelRow] = {}
    rate = None
    for number, line in source.lines:
        tier, _, rest = line.strip().partition(":")
        if tier == RATE:
            rate = source.time(rest, number)
        elif tier == WORDS:
            link, _, word = rest.strip().partition("\t")
            words[link.strip()] = word.strip()
        elif tier == PHONES:
            parts = rest.split(None, 3)
            if len(parts) != 4:  # noqa: PLR2004 start, duration, link, label
                raise source.fault("a phone needs a start, a duration, a link and a label", number)
            start = source.time(parts[0], number)
            end = start + source.time(parts[1], number) + 1
            # A phone of two words, or between them, goes to the first.
            link = re.split("[,;]", parts[2])[0]
            rows.append(LabelRow(parts[3], start, end, number))
            spans[link] = spans.get(link, rows[-1])._replace(end=end)
    if not rows:
        raise source.fault(f"has no tier {PHONES}; align its words with the recording first")
    if not rate or rate < 0:
        raise source.fault(f"states no rate ({RATE}: 16000); write it into the header")
    spoken = [row._replace(label=words[link]) for link, row in spans.items() if link in words]
    return schedule_of(source, rows, words=spoken, rate=rate)
