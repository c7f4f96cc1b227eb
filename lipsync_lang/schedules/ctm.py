"""CTM, of phones: ``file channel start duration label [confidence]`` in every line.

Lines that begin with two semicolons are comments. What Kaldi adds to a phone to say where in its
word it stands (``_B``, ``_I``, ``_E`` or ``_S``) is no part of the label.
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
    """Tell whether the first line that is no comment is a sound."""
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
    """Name them after the file, the channel or both, as far as these tell them apart."""
    telling = [at for at in (0, 1) if len({key[at] for key in tiers}) > 1] or [0]
    return [Tier(" ".join(key[at] for at in telling), tuple(rows)) for key, rows in tiers.items()]
