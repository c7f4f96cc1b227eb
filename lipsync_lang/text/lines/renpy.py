"""Ren'Py scripts: dialogue, menus and translations.

The reader takes say statements: ``e "Hello"``, ``e happy @ wave "Hello"``, ``"Eileen" "Hello"``, a
lone ``"Narration"``, and ``extend "and more"``. It also takes the choices of menus, texts in triple
quotes (an empty line in them starts another line), and ``new`` of translations. It skips Python,
screens, styles, motion of images and the like.
"""

import re
from collections import deque
from collections.abc import Iterator, Sequence
from hashlib import md5
from itertools import groupby, islice

from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

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


SCRIPT_LABEL = re.compile(
    r"(?:label\s+|menu\s+|call\b.*\bfrom\s+)(?P<name>\.?[^\W\d][\w.]*)(?!.*\bhide\s*:)"
)
TRANSLATE_BLOCK = re.compile(r"translate\s+\w+\s+(?!strings\b)(?P<name>\w+)\s*:")
OLD_TEXT = re.compile(r"old\s+[\"'](?P<text>.*)[\"']$", re.DOTALL)
BEFORE_DIALOGUE = re.compile(r"voice\b|nvl\s+clear\b")
"""Pattern of statements that belong to the line after them."""

ID_CLAUSE = re.compile(r"\bid (?P<name>\w+)")
WITH_CLAUSE = re.compile(r"\bwith (?P<effect>.+?)(?= nointeract\b| id\b|$)")
STRING_ESCAPE = re.compile(r"\\(?:u([0-9a-fA-F]{1,4})|(.))", re.DOTALL)
ESCAPE_MEANINGS = {"n": "\n", "{": "{{", "[": "[[", "%": "%%"}
STRING_SPELLINGS = str.maketrans({"\\": "\\\\", "\n": "\\n", '"': '\\"'})


class DialogueNames:
    """Identifiers of the dialogue of a file, whose statements pass by in order.

    A line shares its identifier with its translations and with files of voices: the last label, and
    a digest of the statement in a fixed spelling, such as ``start_915cb944``.
    """

    def __init__(self) -> None:
        self.original = ""
        """The text whose translation follows."""
        self._label = self._block = self._before = ""
        self._in_menu = False
        self._used: dict[str, int] = {}
        """Given names, each with the number of its copies."""

    def notice(self, statement: str, *, indented: bool) -> None:
        """Notice a statement that is not a line."""
        if not indented:
            block = TRANSLATE_BLOCK.match(statement)
            self._block = block["name"] if block else ""
        if (label := SCRIPT_LABEL.match(statement)) and not label["name"].startswith("_"):
            local = label["name"].startswith(".")
            self._label = (self._label.partition(".")[0] if local else "") + label["name"]
        original = OLD_TEXT.match(statement)
        self.original = original["text"] if original else ""
        kept = BEFORE_DIALOGUE.match(statement)
        self._before = f"{self._before}{statement}\r\n" if kept else ""
        if statement.endswith(":"):  # a menu, or one of its choices
            self._in_menu = statement.startswith("menu")

    def of(self, words: Sequence[str], text: str, arguments: str, clause: str) -> str:
        """Return the name of a line; empty for the caption of a menu.

        `words` come before the text: who speaks, and attributes. `text` is as it is written, and
        `clause` is what follows the arguments.
        """
        before, self._before = self._before, ""
        if self._in_menu and not words:
            return ""
        clause = " ".join(clause.split())
        stated = ID_CLAUSE.search(clause)
        if self._block or stated:
            return self._unused(stated["name"] if stated else self._block, "-")
        silent = ["nointeract"] if self._in_menu or "nointeract" in clause.split() else []
        effect = WITH_CLAUSE.search(clause)
        ends = [*silent, *filter(None, [arguments]), *([effect[0]] if effect else [])]
        code = f"{before}{' '.join([*words, _spelled(text), *ends])}\r\n"
        digest = md5(code.encode("utf-8", "replace"), usedforsecurity=False).hexdigest()[:8]
        return self._unused(f"{self._label}_{digest}".replace(".", "_").lstrip("_"), "_")

    def _unused(self, name: str, mark: str) -> str:
        own = name
        while own in self._used:
            self._used[name] += 1
            own = f"{name}{mark}{self._used[name]}"
        self._used[own] = 0
        return own


def _spelled(text: str) -> str:
    """Return a text in quotes, with the spaces and escapes of a statement that Ren'Py writes."""

    def meaning(found: re.Match[str]) -> str:
        code, one = found.groups()
        return chr(int(code, 16)) if code else ESCAPE_MEANINGS.get(one, one)

    plain = STRING_ESCAPE.sub(meaning, re.sub(r"[ \n]+", " ", text)).translate(STRING_SPELLINGS)
    return '"' + re.sub(r"(?<= ) ", r"\\ ", plain) + '"'


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
