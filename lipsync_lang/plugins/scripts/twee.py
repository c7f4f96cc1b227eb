"""Twee, the text of Twine's stories: the rows and links of passages.

A passage begins with ``:: Name [tags]``. The text of a link is a line: ``[[Go.->Hall]]``. Macros of
SugarCube, Harlowe and Chapbook are left out, and so are passages of scripts, styles and data.
"""

import re
from collections.abc import Iterator

from lipsync_lang.plugins.scripts.yarn import speaker_before
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

HEAD_END = re.compile(r"(?<!\\)[\[{]")
PASSAGE_TAGS = re.compile(r"(?<!\\)\[([^\]]*)\]")
UNSPOKEN_PASSAGES = ("StoryTitle", "StoryData", "StoryInit", "StorySettings", "StorySubtitle")
UNSPOKEN_TAGS = frozenset({"script", "stylesheet", "widget", "annotation"})
LINK = re.compile(r"\[\[([^\[\]]*)\](?:\[[^\[\]]*\])?\]")
MACRO = re.compile(r"<<[^<>]*>>|/\*(?:.*?\*/|.*)|<!--(?:.*?-->|.*)|/%(?:.*?%/|.*)")
HARLOWE = re.compile(r"\([a-z][\w-]*:[^()]*(?:\([^()]*\)[^()]*)*\)")
"""A macro in round brackets, with others in it."""

TWEE_NAMES = re.compile(r"\W+")


@reader("twee", suffixes=[".twee", ".tw"])
def read(source: LineFile) -> Iterator[Line]:
    """Twee's passages: rows and texts of links, named by their passage."""
    passage, count, within = "", 0, False
    for number, row in source.numbered():
        if row.startswith("::"):
            passage, count = HEAD_END.split(row[2:], maxsplit=1)[0].strip(), 0
            found = PASSAGE_TAGS.search(row)
            tags = found[1].split() if found else []
            within = passage not in UNSPOKEN_PASSAGES and UNSPOKEN_TAGS.isdisjoint(tags)
            continue
        text = HARLOWE.sub(" ", MACRO.sub(" ", row)) if within else ""
        links = [_shown(found[1]) for found in LINK.finditer(text)]
        # A macro of Harlowe leaves the brackets of its hook: `(if: $met)[Hello again.]`.
        for said in (LINK.sub(" ", text).strip().strip("[]"), *links):
            who = speaker_before(said)
            spoken = said[who.end() :] if who else said
            if any(map(str.isalnum, spoken)):
                count += 1
                name = f"{TWEE_NAMES.sub('-', passage)}-{count}"
                yield source.line(number, spoken, name=name, speaker=who["who"] if who else "")


def _shown(link: str) -> str:
    """Return the text of a link: ``Text->Target``, ``Target<-Text`` or ``Text|Target``."""
    text, arrow, _ = link.rpartition("->")
    if arrow:
        return text.strip()
    _, arrow, text = link.partition("<-")
    return text.strip() if arrow else link.partition("|")[0].strip()
