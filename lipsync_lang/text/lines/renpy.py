"""Ren'Py scripts: dialogue, menus and translations.

The reader takes say statements: ``e "Hello"``, ``e happy @ wave "Hello"``, ``"Eileen" "Hello"``, a
lone ``"Narration"``, and ``extend "and more"``. It also takes the choices of menus, texts in triple
quotes (an empty line in them starts another line), and ``new`` of translations. It skips Python,
screens, styles, motion of images and the like.
"""

import re
from collections import deque
from collections.abc import Iterator
from itertools import groupby, islice

from lipsync_lang.text.lines.line import Line
from lipsync_lang.text.lines.line_readers import LineFile, reader
from lipsync_lang.text.lines.renpy_names import DialogueNames

STRING = r"""(?:\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|`(?:\\.|[^`\\])*`)"""
TRIPLE = r"(?:\"\"\"(?:\\.|[^\\])*?\"\"\"|'''(?:\\.|[^\\])*?''')"
TOKENS = re.compile(
    rf"{TRIPLE}|{STRING}|(?P<comment>#[^\n]*)|(?P<lone>[\"'`])|(?P<opening>[\[({{])|(?P<closing>[\])}}])",
    re.DOTALL,
)
"""Strings, which may contain `#` and line ends; comments; a quote that is not closed; brackets."""

SAYS = re.compile(
    rf"(?:(?P<who>[^\W\d]\w*)(?P<attributes>(?:\s+@|\s+-?[^\W\d]\w*)*)\s+|(?P<name>{STRING})\s+)?"
    rf"(?P<what>{TRIPLE}|{STRING})",
    re.DOTALL,
)

ARGUMENTS_END = re.compile(r"\)(?=\s+(?:nointeract|with|id|if)\b)")
CLAUSE = re.compile(r"(?:nointeract|with|id)\b[^\"']*")
CONDITION = re.compile(r"(?:^|\s)if\s")

BLOCKS = re.compile(
    r"(?:init\b.*\bpython|(?:init\s+)?(?:-?\d+\s+)?(?:python|screen|style|transform|layeredimage"
    r"|image|testcase|testsuite)|camera|scene|show|translate\s+\w+\s+(?:python|style))\b"
)
"""Starts of blocks without dialogue."""

OTHER_STATEMENTS = re.compile(
    r"(?:call|camera|default|define|elif|else|hide|if|image|import|in|init|jump|label|menu|nvl|old|on"
    r"|pass|pause|play|queue|return|rpy|scene|show|stop|translate|voice|while|window|with)"
)
"""First words of statements without dialogue."""

NOT_SPEAKERS = frozenset(("extend", "new", "narrator"))
"""First words of say statements that are not the name of a speaker."""

MAX_STATEMENT_LINES = 200
"""Maximum number of lines of the file in one string."""

TRIPLE_QUOTES = ('"""', "'''")


@reader("renpy", suffixes=[".rpy"])
def read(source: LineFile) -> Iterator[Line]:
    """Ren'Py scripts: spoken lines, choices of menus, and translations."""
    passed, names = -1, DialogueNames()
    for number, statement in _statements(source):
        indent = len(statement) - len(statement.lstrip())
        text = statement.strip()
        if 0 <= passed < indent:
            continue
        passed = indent if BLOCKS.match(text) and text.endswith(":") else -1
        said = None if passed >= 0 else SAYS.match(text)
        ends = said and _ends(text[said.end() :])
        if said is None or ends is None or OTHER_STATEMENTS.fullmatch(said["who"] or ""):
            names.notice(text, indented=indent > 0)
            continue
        yield from _said(source, number, said, ends, names)
        if text.endswith(":"):
            names.notice(text, indented=True)


def _said(
    source: LineFile, number: int, said: re.Match[str], ends: tuple[str, str], names: DialogueNames
) -> Iterator[Line]:
    who = said["who"] or (said["name"] or "''")[1:-1]
    speaker = "" if who in NOT_SPEAKERS else who
    words = [*filter(None, (said["who"] or said["name"],)), *(said["attributes"] or "").split()]
    whole = said["what"]
    parts = [(number, whole[1:-1])]
    if whole[:3] in TRIPLE_QUOTES:
        rows = groupby(enumerate(whole[3:-3].split("\n"), number), lambda row: bool(row[1].strip()))
        parts = [
            (first, "\n".join([text, *(row for _, row in more)]).strip())
            for says, ((first, text), *more) in rows
            if says
        ]
    for first, text in parts:
        unnamed = who == "new" or ends[1].endswith(":")
        name = "" if unnamed else names.of(words, text, *ends)
        original = "" if name else names.original or text
        if text.strip():
            yield source.line(first, text, name=name, speaker=speaker, original=original)


def _ends(tail: str) -> tuple[str, str] | None:
    """Return the arguments after a line, and its clause or condition; None if it is no line.

    Each part is looked for once: one expression for all of them takes cubic time to fail.
    """
    tail, arguments = tail.strip(), ""
    if tail.startswith("("):
        end = ARGUMENTS_END.search(tail)
        cut = end.end() if end else tail.rfind(")") + 1
        if not cut:
            return None
        arguments, tail = tail[:cut], tail[cut:].lstrip()
    clause = CLAUSE.match(tail)
    if tail in ("", ":") or (clause and clause.end() == len(tail)):
        return arguments, tail
    condition = CONDITION.search(tail, 0, clause.end() if clause else len("if "))
    return (arguments, tail) if condition is not None and tail.endswith(":") else None


def _statements(source: LineFile) -> Iterator[tuple[int, str]]:
    """Yield (line, statement without comments); a statement ends when its brackets are closed."""
    parts: list[tuple[int, str]] = []
    depth = 0
    for number, text, opened in _closed_lines(source):
        parts.append((number, text))
        depth = max(0, depth + opened)
        if not depth and not text.endswith("\\"):
            yield parts[0][0], "\n".join(part for _, part in parts)
            parts.clear()
    if depth:
        where = f"{source.path}:{parts[0][0]}"
        source.remark(f"{where}: a bracket is not closed here, so each line is read alone")
    yield from parts


def _closed_lines(source: LineFile) -> Iterator[tuple[int, str, int]]:
    """Yield (line, text, brackets left open); lines are joined until their strings are closed."""
    ahead: deque[tuple[int, str]] = deque()
    lines = source.numbered()
    while ahead or (ahead := deque(islice(lines, 1))):
        number, text = ahead.popleft()
        whole, closed, opened = _without_comments(text)
        taken: list[tuple[int, str]] = []
        while not closed and len(taken) < MAX_STATEMENT_LINES:
            more = [ahead.popleft()] if ahead else [*islice(lines, 1)]
            if not more:
                break
            taken += more
            text += "\n" + more[0][1]
            whole, closed, opened = _without_comments(text)
        if not closed:  # a lone quote, such as an apostrophe in a statement of the game's own
            ahead.extendleft(reversed(taken))
        if whole.strip() and closed:
            yield number, whole.rstrip(), opened
        elif not closed and SAYS.match(whole.split("\n")[0].strip() + '"'):
            source.remark(f"{source.path}:{number}: left out: a quote is not closed here")


def _without_comments(text: str) -> tuple[str, bool, int]:
    """Return a text without comments, True if its strings are closed, and open brackets."""
    kinds = [found.lastgroup for found in TOKENS.finditer(text)]
    if "comment" in kinds:
        text = TOKENS.sub(lambda found: "" if found["comment"] else found[0], text)
    return text, "lone" not in kinds, kinds.count("opening") - kinds.count("closing")
