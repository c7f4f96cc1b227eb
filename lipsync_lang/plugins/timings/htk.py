"""HTK and HTS labels: a start, an end and a label on each line, in units of 100 ns.

Scores may follow the label, and then the word that starts there. HTS writes the phone between `-`
and `+`, within its context. The states of one phone, `[2]` to `[6]`, are joined. Times with a
decimal point are seconds, as in files of WaveSurfer. A master label file holds many utterances,
each under its name in quotes; `tier` selects one.
"""

import re
from pathlib import PureWindowsPath

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.tiers import Tier, only

UNITS_PER_SECOND = 1e7
"""Units of 100 ns per second."""

MASTER = "#!MLF!#"

NEXT_BEST = "///"
"""The line between one transcription and the next best."""

HTK_NUMBER = r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"
TIMED = re.compile(rf"\s*({HTK_NUMBER})[ \t]+({HTK_NUMBER})[ \t]+(\S+)([^\n]*)", re.ASCII)
CONTEXT = re.compile(
    r"[^-^]*+\^[^-]*+-(?P<phone>.[^+]*+)\+[^=]*+=.*?(?P<state>\[\d+\])?", re.DOTALL
)
"""A full context: two phones before, the phone, and two after."""

TRANSCRIPT = (
    "is a transcript without times; align it with its recording, and give the TextGrid that comes "
    "out, or give the recording with its text (`audio`)"
)

NumberedLines = list[tuple[int, str]]


def sniff(source: TimingFile) -> bool:
    """Return True if the file starts with two times and a label, or is a master label file.

    A `.lab` of words without times is accepted as well: `read_htk` then explains the mistake.
    """
    text = source.head.strip()
    numbered = re.search(r"^[ \t]*[-+#\d]", text, re.MULTILINE)
    prose = text[:1].isprintable() and text[:1] not in "<{[" and numbered is None
    if prose and source.path.suffix.lower() == ".lab":
        return True
    timed = TIMED.fullmatch(source.first_line) is not None
    return timed or source.first_line.startswith(MASTER)


@reader("htk", ".lab", ".mlf", sniff=sniff, tiers=True)
def read_htk(source: TimingFile) -> Schedule:
    """HTK and HTS labels, full-context ones included, and one utterance of a master label file."""
    lines = _utterance(source)
    cut = next((at for at, (_, line) in enumerate(lines) if line.strip() == NEXT_BEST), None)
    told = []
    if cut is not None:
        told = [f"{source.path}:{lines[cut][0]}: has other transcriptions, which are not read"]
    rows: list[LabelRow] = []
    words: list[LabelRow] = []
    state, rate = "", UNITS_PER_SECOND
    for number, line in lines[:cut]:
        found = TIMED.fullmatch(line)
        if found is None:
            numbered = re.match(r"\s*[-+]?\d", line)
            shown = f"{line.strip()[:40]!r} is not a start, an end and a label"
            raise source.fault(shown if numbered else TRANSCRIPT, number)
        start, end = source.time(found[1], number), source.time(found[2], number)
        # HTK counts in whole units; a point is WaveSurfer's
        if "." in found[1] + found[2]:
            rate = 1.0
        context = CONTEXT.fullmatch(found[3])
        whole = found[3].removesuffix((context and context["state"]) or "")
        # HTS has a row for each of five states of a phone
        if context and context["state"] and rows and whole == state:
            rows[-1] = rows[-1]._replace(end=end)
            continue
        state = whole
        rows.append(LabelRow(context["phone"] if context else found[3], start, end, number))
        scored = found[4].split()  # the word stands after the scores
        word = next((part for part in scored if not re.fullmatch(HTK_NUMBER, part)), None)
        if word:
            words.append(LabelRow(word, start, end, number))
    # A word stands beside its first phone alone.
    stops = [*(word.start for word in words[1:]), rows[-1].end if rows else 0.0]
    words = [
        word._replace(end=max(stop, word.end)) for word, stop in zip(words, stops, strict=False)
    ]
    return schedule_of(source, rows, words=words, rate=rate, remarks=told)


def _utterance(source: TimingFile) -> NumberedLines:
    """Return the lines of the utterance named by ``source.tier``, or of the only one."""
    lines = source.lines
    if not lines or not lines[0][1].startswith(MASTER):
        return lines
    parts: dict[str, NumberedLines] = {}
    into: NumberedLines = []
    for number, line in lines[1:]:
        text = line.strip()
        if text.startswith('"'):
            # this class splits at both slashes: the file may come from any system
            into = parts.setdefault(PureWindowsPath(text.strip('"')).stem, [])
        elif text != ".":
            into.append((number, line))
    return parts[only(source, [Tier(name, ()) for name in parts], "utterances").name]
