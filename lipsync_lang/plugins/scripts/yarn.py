"""Yarn Spinner scripts: the spoken lines and options of nodes.

A file is a list of nodes: headers up to ``---``, then a body up to ``===``. A body holds lines such
as ``Anna: Hello. #line:a1``, options (``-> Hello.``), groups of lines (``=> Hello.``), commands
(``<<stop>>``) and comments (``//``). The tag ``#line:`` names a line.
"""

import re
from collections.abc import Iterator

from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

YARN_COMMENT = re.compile(r"(?<![\\:])//.*")
"""Pattern of a comment, but not within the address of a page."""

COMMAND = re.compile(r"<<(?:[^<>]|>(?!>)|<(?!<))*>>")
JUMP = re.compile(r"\[\[(?:(?P<text>[^\[\]|]*)\|)?[^\[\]|]*\]\]\s*$")
"""Pattern of an option of the first version: ``[[Text|Node]]``, or a jump without a text."""

YARN_SPEAKER = re.compile(r"(?P<who>[^\s:.,;!?\"<{\[\\#][^:.,;!?\"<{\[\\#\n]{0,39}):(?:\s+|$)")
MAX_NAME_WORDS = 2
"""Maximum number of words before a colon at the end of a line that are a name, and not spoken."""

YARN_ESCAPE = re.compile(r"\\([:#/<>])")
CHARACTER = re.compile(
    r"\[character\s+name\s*=\s*\"?(?P<who>[^\"\[\]]*)\"?[^\[\]]*\]|\[/character\]"
)
NAMING_TAG = "line:"


@reader("yarn", suffixes=[".yarn"])
def read(source: LineFile) -> Iterator[Line]:
    """Yarn Spinner scripts: lines and options of nodes, with their `#line:` tags."""
    within = met = False
    number = 0
    for number, row in source.numbered():
        text = row.strip()
        if text == "===":
            within = False
        elif not within:
            within = text == "---"
            met |= within
        else:
            yield from _spoken(source, number, text)
    if number and not met:
        raise source.fault(number, "has no Yarn node; the body of a node begins with a line `---`")


def _spoken(source: LineFile, number: int, text: str) -> Iterator[Line]:
    """Yield the line of a row, if it has one."""
    pieces = COMMAND.sub(" ", YARN_COMMENT.sub("", text)).strip().split("#")
    name = ""
    # Tags stand at the end, so the first piece from there that is none ends the search.
    while len(pieces) > 1:
        tag = pieces[-1].strip()
        if len(tag.split()) != 1 or pieces[-2][-1:].strip():
            break  # a hash within the text
        if tag.startswith(NAMING_TAG):
            name = tag.removeprefix(NAMING_TAG)
        pieces.pop()
    text = "#".join(pieces).removeprefix("->").removeprefix("=>").strip()
    if jump := JUMP.match(text):
        text = jump["text"] or ""
    stated = CHARACTER.search(text)
    text = CHARACTER.sub("", text).strip() if stated else text
    found = speaker_before(text)
    speaker = ((stated and stated["who"]) or (found["who"] if found else "")).strip()
    said = YARN_ESCAPE.sub(r"\1", text[found.end() if found else 0 :]).strip()
    if said:
        yield source.line(number, said, name=name, speaker=speaker)


def speaker_before(text: str) -> re.Match[str] | None:
    """Return the name and the colon that a text begins with; None for a sentence with a colon."""
    found = YARN_SPEAKER.match(text)
    alone = found is not None and found.end() == len(text)
    return None if alone and text.count(" ") >= MAX_NAME_WORDS else found
