"""Ren'Py scripts: dialogue, menus and translations.

The reader takes say statements: ``e "Hello"``, ``e happy @ wave "Hello"``, ``"Eileen" "Hello"``, a
lone ``"Narration"``, and ``extend "and more"``. It also takes the choices of menus, texts in triple
quotes (an empty line in them starts another line), and ``new`` of translations. It skips blocks of
Python, screens, styles and the like.
"""

import re
from collections import deque
from collections.abc import Iterator
from itertools import groupby, islice

from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import LineFile, reader

STRING = r"""(?:\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|`(?:\\.|[^`\\])*`)"""
TRIPLE = r"(?:\"\"\"(?:\\.|[^\\])*?\"\"\"|'''(?:\\.|[^\\])*?''')"
TOKENS = re.compile(rf"{TRIPLE}|{STRING}|(?P<comment>#[^\n]*)|(?P<lone>[\"'`])", re.DOTALL)
"""Strings, which may contain `#` and line ends; comments; and a quote that is never closed."""

SAYS = re.compile(
    rf"(?:(?P<who>[^\W\d]\w*)(?P<attributes>(?:\s+@|\s+-?[^\W\d]\w*)*)\s+|(?P<name>{STRING})\s+)?"
    rf"(?P<what>{TRIPLE}|{STRING})",
    re.DOTALL,
)

ARGUMENTS_END = re.compile(r"\)(?=\s+(?:nointeract|with|id|if)\b)")
CLAUSE = re.compile(r"(?:nointeract|with|id)\b[^\"']*")
CONDITION = re.compile(r"(?:^|\s)if\s")

BLOCKS = re.compile(
    r"(?:init\b.*\bpython|python|screen|style|transform|layeredimage|image\s.*:|testcase"
    r"|translate\s+\w+\s+(?:python|style))\b"
)
"""Starts of blocks without dialogue."""

TRANSLATES = re.compile(r"translate\s+\w+\s+(?P<name>\w+)\s*:")

OTHER_STATEMENTS = re.compile(
    r"(?:call|camera|default|define|elif|else|hide|if|image|import|in|init|jump|label|menu|nvl|old|on"
    r"|pass|pause|play|queue|return|rpy|scene|show|stop|translate|voice|while|window|with)"
)
"""First words of statements without dialogue."""

NOT_SPEAKERS = frozenset(("extend", "new", "narrator"))
"""First words of say statements that are not the name of a speaker."""

MAX_STATEMENT_LINES = 200
"""Maximum number of lines of the file in one statement."""

TRIPLE_QUOTES = {'"""': 3, "'''": 3}


@reader("renpy", suffixes=[".rpy"])
def read(source: LineFile) -> Iterator[Line]:
    """Ren'Py scripts: spoken lines, choices of menus, and translations."""
    passed, name = -1, ""
    for number, statement in _statements(source):
        indent = len(statement) - len(statement.lstrip())
        text = statement.strip()
        if 0 <= passed < indent:
            continue
        passed = indent if BLOCKS.match(text) and text.endswith(":") else -1
        if not indent:
            block = TRANSLATES.match(text)
            name = block["name"] if block and block["name"] != "strings" else ""
        if passed < 0:
            yield from _said(source, number, text, name)


def _said(source: LineFile, number: int, text: str, name: str) -> Iterator[Line]:
    found = SAYS.match(text)
    if (
        found is None
        or not _ends(text[found.end() :])
        or OTHER_STATEMENTS.fullmatch(found["who"] or "")
    ):
        return
    who = found["who"] or _inner(found["name"] or "''")
    speaker = "" if who in NOT_SPEAKERS else who
    whole = found["what"]
    if whole[:3] not in TRIPLE_QUOTES:
        if _inner(whole).strip():
            yield source.line(number, _inner(whole), name=name, speaker=speaker)
        return
    rows = enumerate(whole[3:-3].split("\n"), start=number)
    for says, part in groupby(rows, key=lambda row: bool(row[1].strip())):
        first, *more = part
        if says:
            spoken = "\n".join([first[1], *(row for _, row in more)])
            yield source.line(first[0], spoken, name=name, speaker=speaker)


def _ends(tail: str) -> bool:
    """Test for a valid end of a statement: arguments, a clause, and the condition of a choice.

    Each part is looked for once: one expression for all of them takes cubic time to fail.
    """
    tail = tail.strip()
    if tail.startswith("("):
        end = ARGUMENTS_END.search(tail)
        cut = end.end() if end else tail.rfind(")") + 1
        if not cut:
            return False
        tail = tail[cut:].lstrip()
    clause = CLAUSE.match(tail)
    if clause and clause.end() == len(tail):
        return True
    condition = CONDITION.search(tail, 0, clause.end() if clause else len("if "))
    return tail in ("", ":") or (condition is not None and tail.endswith(":"))


def _inner(string: str) -> str:
    return string[1:-1]


def _statements(source: LineFile) -> Iterator[tuple[int, str]]:
    """Yield (line, statement without comments); a statement ends when its strings are closed."""
    ahead: deque[tuple[int, str]] = deque()
    lines = source.numbered()
    while ahead or (ahead := deque(islice(lines, 1))):
        number, text = ahead.popleft()
        whole, closed = _without_comments(text)
        taken: list[tuple[int, str]] = []
        while not closed and len(taken) < MAX_STATEMENT_LINES:
            more = [ahead.popleft()] if ahead else [*islice(lines, 1)]
            if not more:
                break
            taken += more
            text += "\n" + more[0][1]
            whole, closed = _without_comments(text)
        if not closed:  # a lone quote, such as an apostrophe in a statement of the game's own
            ahead.extendleft(reversed(taken))
        if whole.strip() and closed:
            yield number, whole
        elif not closed and SAYS.match(whole.split("\n")[0].strip() + '"'):
            source.remark(f"{source.path}:{number}: left out: a quote is not closed here")


def _without_comments(text: str) -> tuple[str, bool]:
    """Return a statement without its comment, and True if all its strings are closed."""
    closed = True

    def kept(found: re.Match[str]) -> str:
        nonlocal closed
        closed &= not found["lone"]
        return "" if found["comment"] is not None else found[0]

    return TOKENS.sub(kept, text), closed
