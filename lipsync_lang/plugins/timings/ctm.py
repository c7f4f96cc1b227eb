"""CTM of phones or words: ``file channel start duration label [confidence]`` in every line.

Lines that begin with two semicolons are comments. Kaldi appends the place in the word to a phone
(``_B``, ``_I``, ``_E`` or ``_S``), which is removed from the label.
"""

import re
from collections import defaultdict

from lipsync_lang.schedules import (
    LabelRow,
    TimingFile,
    Timings,
    reader,
    schedule_of,
    timed_words_of,
)
from lipsync_lang.schedules.tiers import Tier, only
from lipsync_lang.schedules.timed_words import are_words

CTM_COMMENT = ";;"
CTM_CONFIDENCE = r"0?\.\d+|[01]|1\.0*"
CTM_LINE = re.compile(
    r"\s*(\S+)\s+(\S+)\s+(-?[\d.]+)\s+(-?[\d.]+)\s+(\S+?)(?:_[BIES])?(?:\s+(\S.*))?\s*"
)


def sniff(source: TimingFile) -> bool:
    """Return True if the first line that is not a comment is a phone."""
    lines = [line for line in source.head.split("\n") if line.strip()]
    return bool(CTM_LINE.fullmatch(next((x for x in lines if not x.startswith(CTM_COMMENT)), "")))


@reader("ctm", ".ctm", sniff=sniff, tiers=True)
def read_ctm(source: TimingFile) -> Timings:
    """CTM of phones or words, as Kaldi writes it; of several files or channels, one is named."""
    tiers: dict[tuple[str, str], list[LabelRow]] = defaultdict(list)
    form = "a sound; write FILE CHANNEL START DURATION LABEL"
    for number, found in source.matches(CTM_LINE, form, comments=CTM_COMMENT):
        start, length = source.time(found[3], number), source.time(found[4], number)
        # With more fields behind it, the next one is no probability for sure.
        sure = float(found[6]) if re.fullmatch(CTM_CONFIDENCE, found[6] or "") else None
        row = LabelRow(found[5], start, start + length, number, sure)
        tiers[found[1], found[2]].append(row)
    # Tiers are named after the file, the channel or both, whichever differ.
    telling = [at for at in (0, 1) if len({key[at] for key in tiers}) > 1] or [0]
    named = [Tier(" ".join(key[at] for at in telling), tuple(r)) for key, r in tiers.items()]
    rows = only(source, named, "files or channels").rows
    if are_words(row.label for row in rows):
        return timed_words_of(source, rows)
    return schedule_of(source, rows)
