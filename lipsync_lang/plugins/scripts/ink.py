"""Ink: the spoken lines and choices of a story; logic, diverts and tags are left out.

A choice, ``* Hello[, Bo.] there.``, is two lines: the one that the player reads, "Hello, Bo.", and
the one that is said, "Hello there." ``Anna: Hello.`` names a speaker. A block in braces may take
several rows, and each of its branches is spoken. Of alternatives within a row, the first is.
"""

import re
from collections.abc import Iterator

from lipsync_lang.plugins.scripts.yarn import speaker_before
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

INK_COMMENT = re.compile(r"(?<![\\:])//.*|/\*(?:.*?(?P<closed>\*/)|.*)")
INK_LOGIC = re.compile(r"=|~|VAR\b|CONST\b|LIST\b|EXTERNAL\b|INCLUDE\b|TODO:|->|<-")
INK_MARKS = re.compile(r"(?:[*+-](?!>)\s*)+(?:\((\w+)\)\s*)?(?:\{[^{}|:]*\}\s*)*")
"""Bullets of choices and gathers, with their label and their conditions."""

INK_BRACE = re.compile(r"(?<!\\)[{}]")
INK_SEQUENCE = re.compile(r"\s*(?:stopping|cycle|shuffle|once)(?:\s+(?:once|stopping))?\s*:")
INK_TEST = re.compile(r"(?:\"[^\"]*\"|\|\||[^\":|{}])*:")
"""A condition or a value up to its colon."""

INK_INLINE = re.compile(r"(?<!\\)\{((?:\\.|[^{}\\])*)\}")
INK_BAR = re.compile(r"(?<![\\|])\|(?!\|)")
INK_TAIL = re.compile(r"<>\s*$|->.*|(?<![\\&])#.*")
"""Glue, a divert or a tag after a text."""

INK_HASH = re.compile(r"\\#\s*(?=[^\W\d])")
"""A hash that is text, before a word; it has no sound, and without it the word is no tag."""

INK_BRACKETS = re.compile(r"(.*?)(?<!\\)\[(.*?)(?<!\\)\](.*)")
MAX_INK_DEPTH = 32
"""Maximum depth of blocks, and of alternatives within each other."""

HELD = str.maketrans("{}", "\x01\x02")
FREED = str.maketrans("\x01\x02", "{}")
"""Braces of a value, while those around them are read."""


@reader("ink", suffixes=[".ink"])
def read(source: LineFile) -> Iterator[Line]:
    """Ink scripts: lines, and choices as shown and as said, without logic, diverts and tags."""
    blocks: list[bool] = []
    commented = False
    for number, row in source.numbered():
        text = f"/*{row}" if commented else row
        remarks = list(INK_COMMENT.finditer(text))
        commented = any(one[0].startswith("/*") and not one["closed"] for one in remarks)
        text = INK_COMMENT.sub("", text).strip()
        if text.startswith("=="):  # a knot, before which every block is closed
            blocks.clear()
        if not INK_LOGIC.match(text):
            for part in _parts(text, blocks):
                yield from _lines(source, number, part)


def _parts(text: str, blocks: list[bool]) -> Iterator[str]:
    """Yield the parts of a row outside the heads of blocks.

    `blocks` are those that are open, with True if their branches have conditions.
    """
    while True:
        if blocks and re.match(r"-(?!>)", text):
            test = INK_TEST.match(text) if blocks[-1] else None
            text = text[test.end() if test else 1 :]
        opened: list[int] = []
        start = 0
        for found in INK_BRACE.finditer(text):
            if found[0] == "{":
                opened.append(found.start())
            elif opened:
                opened.pop()
            else:
                yield text[start : found.start()]
                start = found.end()
                del blocks[-1:]
        if not opened or len(blocks) >= MAX_INK_DEPTH:
            yield text[start:]
            return
        yield text[start : opened[0]]
        text = text[opened[0] + 1 :]
        listed = INK_SEQUENCE.match(text)
        blocks.append(listed is None)
        text = text.lstrip()
        head = None if text.startswith("-") else listed or INK_TEST.match(text)
        text = text[head.end() :].lstrip() if head else text


def _lines(source: LineFile, number: int, text: str) -> Iterator[Line]:
    """Yield the lines of a part of a row: two for a choice with brackets."""
    marks = INK_MARKS.match(text.strip())
    name = (marks and marks[1]) or ""
    text = text.strip()[marks.end() :] if marks else text
    for _ in range(MAX_INK_DEPTH):
        text, count = INK_INLINE.subn(_alternative, text)
        if not count:
            break
    text = text.translate(FREED)
    brackets = INK_BRACKETS.fullmatch(text) if marks else None
    texts = [text]
    if brackets:
        before, shown, after = brackets.groups()
        texts = [before + shown, before + after]
    for at, whole in enumerate(texts):
        one = INK_TAIL.sub("", whole, count=1).strip()
        who = speaker_before(one)
        said = INK_HASH.sub("", one[who.end() :] if who else one)
        said = re.sub(r"\\(.)", r"\1", said)
        if said:
            yield source.line(
                number, said, name=f"{name}-{at}" if name and at else name,
                speaker=who["who"] if who else "",
            )  # fmt: skip


def _alternative(found: re.Match[str]) -> str:
    """Return the first alternative that has words; a value in held braces."""
    inner = found[1].strip()
    inner = inner[1:] if re.match(r"-(?!>)", inner) else inner
    # A sequence has a mark (`&!~`) or bars; a colon in it is text.
    test = None if inner[:1] in "&!~" else INK_TEST.match(inner)
    if test is None and not INK_BAR.search(inner):
        return found[0].translate(HELD)
    ways = INK_BAR.split(inner[test.end() :] if test else inner.lstrip("&!~"))
    return next((way for one in ways if (way := INK_TAIL.sub("", one).strip())), "")
