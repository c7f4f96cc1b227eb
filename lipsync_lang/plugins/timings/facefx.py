"""Phoneme lists of FaceFX Studio, as scripts of its `phonlist` command.

``phonlist -append -phoneme "HH" -startTime 0 -endTime 0.1`` adds a phoneme, in seconds.
``phonlist -group -startIndex 0 -endIndex 1 -wordText "hi"`` joins phonemes to a word, by their
numbers from 0, and ``phonlist -clear`` starts anew. Flags have short names (`-a`, `-ph`), and a
prompt (`%`) may stand before a command. Other commands are no timings.
"""

import shlex

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of

LIST_COMMAND = "phonlist"

LIST_FLAGS = {
    "a": "append",
    "c": "clear",
    "g": "group",
    "ph": "phoneme",
    "st": "starttime",
    "et": "endtime",
    "si": "startindex",
    "ei": "endindex",
    "wt": "wordtext",
}
"""Long names of short flags."""

BARE_FLAGS = {"append", "clear", "group"}
"""Flags without a value."""


def sniff(source: TimingFile) -> bool:
    """Return True if one of the first lines is a `phonlist` command."""
    return any(_is_list(line) for line in source.head.split("\n"))


@reader("facefx", ".fxl", sniff=sniff)
def read_facefx(source: TimingFile) -> Schedule:
    """Scripts of FaceFX Studio whose `phonlist` commands list phonemes and words."""
    phones: list[LabelRow] = []
    words: list[LabelRow] = []
    for number, line in source.lines:
        if not _is_list(line):
            continue
        flags = _flags(source, line, number)
        if "clear" in flags:
            phones, words = [], []
        elif "append" in flags:
            start, end = (source.time(flags.get(name), number) for name in ("starttime", "endtime"))
            phones.append(LabelRow(flags.get("phoneme", ""), start, end, number))
        elif "group" in flags:
            first, last = (
                _place(source, flags.get(name, ""), len(phones), number)
                for name in ("startindex", "endindex")
            )
            if last < first:
                raise source.fault(f"a group from {first} to {last}; swap the two", number)
            text = flags.get("wordtext", "")
            words.append(LabelRow(text, phones[first].start, phones[last].end, number))
    return schedule_of(source, phones, words=words)


def _is_list(line: str) -> bool:
    return line.strip().lstrip("% ").split(" ", 1)[0].casefold() == LIST_COMMAND


def _flags(source: TimingFile, line: str, number: int) -> dict[str, str]:
    """Return the flags of a command by their long names in small letters, with their values."""
    try:
        parts = shlex.split(line.strip().rstrip(";"))
    except ValueError:
        raise source.fault("a quotation mark is not closed; add the second one", number) from None
    found: dict[str, str] = {}
    rest = iter(parts[1:])
    for part in rest:
        name = part.lstrip("-").casefold()
        name = LIST_FLAGS.get(name, name)
        found[name] = "" if name in BARE_FLAGS else next(rest, "")
    return found


def _place(source: TimingFile, text: str, count: int, number: int) -> int:
    """Return the number of a phoneme of a word."""
    if text.isdecimal() and int(text) < count:
        return int(text)
    known = f"they have the numbers 0 to {count - 1}" if count else "there is none above"
    raise source.fault(f"{text!r} is not the number of a phoneme; {known}", number)
