"""CTM of phones: ``file channel start duration label [confidence]`` in every line.

Lines that begin with two semicolons are comments. Kaldi appends the place in the word to a phone
(``_B``, ``_I``, ``_E`` or ``_S``), which is removed from the label.
"""

import re
from collections import defaultdict

from lipsync_lang.schedules.rows import LabelRow, schedule_of
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.tiers import Tier, only
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import reader

COMMENT = ";;"
SOUND = re.compile(r"\s*(\S+)\s+(\S+)\s+(-?[\d.]+)\s+(-?[\d.]+)\s+(\S+?)(?:_[BIES])?(?:\s.*)?")


def sniff(source: TimingFile) -> bool:
    """Return True if the first line that is not a comment is a phone."""
    lines = [line for line in source.head.split("\n") if line.strip()]
    return bool(SOUND.fullmatch(next((x for x in lines if not x.startswith(COMMENT)), "")))


@reader("ctm", ".ctm", sniff=sniff, tiers=True)
def read_ctm(source: TimingFile) -> Schedule:
    """CTM of phones, as Kaldi writes it; of several files or channels, one is named."""
    tiers: dict[tuple[str, str], list[LabelRow]] = defaultdict(list)
    for number, line in source.lines:
        if line.startswith(COMMENT):
            continue
        found = SOUND.fullmatch(line)
        if not found:
            raise source.fault("is no sound; it is FILE CHANNEL START DURATION LABEL", number)
        start, length = source.time(found[3], number), source.time(found[4], number)
        tiers[found[1], found[2]].append(LabelRow(found[5], start, start + length, number))
    return schedule_of(source, only(source, _named(tiers), "files or channels").rows)


def _named(tiers: dict[tuple[str, str], list[LabelRow]]) -> list[Tier]:
    """Return tiers named after the file, the channel or both, whichever differ."""
    telling = [at for at in (0, 1) if len({key[at] for key in tiers}) > 1] or [0]
    return [Tier(" ".join(key[at] for at in telling), tuple(rows)) for key, rows in tiers.items()]
