"""Ink: the spoken lines and choices of a story; logic, diverts and tags are left out.

A choice, ``* [Go.] I go.``, is what the player reads before the brackets close, and what is said
without them. ``Anna: Hello.`` names a speaker.
"""

import re
from collections.abc import Iterator

from lipsync_lang.text.lines.line_readers import Line, LineFile, reader
from lipsync_lang.text.lines.yarn import YARN_SPEAKER

INK_COMMENT = re.compile(r"(?<![\\:])//.*|/\*.*?\*/")
INK_LOGIC = re.compile(
    r"(?:==|~|VAR\b|CONST\b|LIST\b|EXTERNAL\b|INCLUDE\b|TODO:|[{}|]\s*$|->|else:)"
)
INK_MARKS = re.compile(r"(?:[*+-](?!>)\s*)+(?:\((\w+)\)\s*)?(?:\{[^{}|:]*\}\s*)*")
"""Bullets of choices and gathers, with their label and their conditions."""


@reader("ink", suffixes=[".ink"])
def read(source: LineFile) -> Iterator[Line]:
    """Ink scripts: lines and choices, without logic, diverts and tags."""
    for number, row in source.numbered():
        text = INK_COMMENT.sub("", row).strip()
        if INK_LOGIC.match(text):
            continue
        marks = INK_MARKS.match(text)
        text = re.sub(r"\[([^\[\]]*)\]", r" \1 ", text[marks.end() :]) if marks else text
        text = re.sub(r"\s*(?:<>|->.*|(?<!&)#.*)$", "", text).strip()
        who = YARN_SPEAKER.match(text)
        said = text[who.end() :] if who else text
        if said:
            name = (marks and marks[1]) or ""
            yield source.line(number, said, name=name, speaker=who["who"] if who else "")
