"""Ren'Py scripts: dialogue, menus and translations.

The reader takes say statements: ``e "Hello"``, ``e happy @ wave "Hello"``, ``"Eileen" "Hello"``, a
lone ``"Narration"``, and ``extend "and more"``. It also takes the choices of menus, texts in triple
quotes (an empty line in them starts another line), and ``new`` of translations. It skips Python,
screens, styles, motion of images and the like.
"""

import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import md5
from itertools import groupby, islice

from lipsync_lang.base.errors import count
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

STRING = r"""(?:\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|`(?:\\.|[^`\\])*`)"""
TRIPLE = r"(?:\"\"\"(?:\\.|[^\\])*?\"\"\"|\'\'\'(?:\\.|[^\\])*?\'\'\'|```(?:\\.|[^\\])*?```)"
TOKENS = re.compile(
    rf"{TRIPLE}|{STRING}|(?P<comment>#[^\n]*)|(?P<lone>[\"'`].*)|(?P<opening>[\[({{])"
    r"|(?P<closing>[\])}])|(?P<comma>,)",
    re.DOTALL,
)
"""Strings, which may contain `#` and line ends; comments; a quote that is not closed, with all
after it; brackets and commas."""

IDENTIFIER = r"[^\W\d]\w*"
SPEAKER_START = re.compile(rf"{IDENTIFIER}|{STRING}|(?=\()", re.DOTALL)
MEMBER = re.compile(rf"\s*\.\s*{IDENTIFIER}")
"""A part of an object, after its name: ``d.e``; brackets may follow, too."""

SPOKEN = re.compile(
    r"(?P<attributes>(?:\s*+(?:@|-?\s*+(?!r[\"'`])[-\w]++))*+)\s*+"
    rf"(?P<raw>r?)(?P<what>{TRIPLE}|{STRING})",
    re.DOTALL,
)
"""Attributes of an image, and the text."""

ATTRIBUTE = re.compile(r"@|-?\s*[-\w]+")
CLAUSE = re.compile(rf"\s*(?:(?P<silent>nointeract)\b|id\s+(?P<name>{IDENTIFIER})|with\b\s*)")
CONDITION = re.compile(r"\s*if\s.*:", re.DOTALL)
KEYWORD = re.compile(rf"\s*({IDENTIFIER})\s*=(?!=)\s*")

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

QUOTES = ('"', "'", "`")
TRIPLE_QUOTES = tuple(3 * quote for quote in QUOTES)


SCRIPT_LABEL = re.compile(
    r"(?:label\s+|menu\s+|call\b.*\bfrom\s+)(?P<name>\.?[^\W\d][\w.]*)(?P<hidden>.*\bhide\s*:)?",
    re.DOTALL,
)
TRANSLATE_BLOCK = re.compile(r"translate\s+\w+\s+(?!strings\b)(?P<name>\w+)\s*:")
OLD_TEXT = re.compile(r"old\s+[\"'](?P<text>.*)[\"']$", re.DOTALL)
BEFORE_DIALOGUE = re.compile(r"voice\b|nvl\s+clear\b")
"""Pattern of statements that belong to the line after them."""

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
        self._outer: list[tuple[int, str]] = []
        """Labels that local ones belong to, each with its indent."""
        self._in_menu = False
        self._used: dict[str, int] = {}
        """Given names, each with the number of its copies."""

    def notice(self, statement: str, indent: int) -> None:
        """Notice a statement that is not a line."""
        if not indent:
            block = TRANSLATE_BLOCK.match(statement)
            self._block = block["name"] if block else ""
        while self._outer and self._outer[-1][0] > indent:
            self._outer.pop()
        if label := SCRIPT_LABEL.match(statement):
            outer, local, inner = label["name"].partition(".")
            outer = outer or (self._outer[-1][1] if self._outer else "")
            if not statement.startswith("call"):  # its label has no local ones
                self._outer.append((indent, outer))
            name = f"{outer}{local}{inner}"
            if not name.startswith("_") and not label["hidden"]:
                self._label = name
        original = OLD_TEXT.match(statement)
        self.original = original["text"] if original else ""
        kept = BEFORE_DIALOGUE.match(statement)
        self._before = f"{self._before}{statement}\r\n" if kept else ""
        if statement.endswith(":"):  # a menu, or one of its choices
            self._in_menu = statement.startswith("menu")

    def of(self, said: "SayStatement", text: str) -> str:
        """Return the name of a line, one of those of a statement; empty for the caption of a menu.

        The `text` is as it is written.
        """
        before, self._before = self._before, ""
        if self._in_menu and not said.words:
            return ""
        if self._block or said.stated:
            return self._unused(said.stated or self._block, "-")
        ends = ["nointeract"] if self._in_menu or said.silent else []
        ends += [*filter(None, [said.arguments]), *([f"with {said.effect}"] if said.effect else [])]
        # Ren'Py digests each statement with this line end, on every system.
        code = f"{before}{' '.join([*said.words, _spelled(text, raw=said.raw), *ends])}\r\n"
        digest = md5(code.encode("utf-8", "replace"), usedforsecurity=False).hexdigest()[:8]
        # A line before the first label has the digest alone.
        return self._unused(f"{self._label}_{digest}".replace(".", "_").lstrip("_"), "_")

    def _unused(self, name: str, mark: str) -> str:
        own = name
        while own in self._used:
            self._used[name] += 1
            own = f"{name}{mark}{self._used[name]}"
        self._used[own] = 0
        return own


@dataclass
class SayStatement:
    """The parts of a say statement, in the spelling of Ren'Py."""

    words: list[str]
    """The speaker, and attributes."""
    what: str
    """The text in its quotes."""
    line: int
    """Number of lines of the file before the text."""
    raw: bool = False
    """True if a backslash in the text is one."""
    silent: bool = False
    stated: str = ""
    """The identifier that the statement has."""
    arguments: str = ""
    effect: str = ""
    block: bool = False
    """True for a choice of a menu."""


def _saying(text: str) -> SayStatement | None:
    """Return the parts of a statement; None if it is not spoken."""
    found, who = SPOKEN.match(text), ""
    said = found and not found["attributes"] and _clauses(text, found)
    if said:
        return said
    end = _expression(text, SPEAKER_START)
    found = SPOKEN.match(text, end) if end else None
    if found is None:
        return None
    who = text[:end]
    first = re.match(IDENTIFIER, who)
    if first and OTHER_STATEMENTS.fullmatch(first[0]):
        return None
    said = _clauses(text, found)
    if said:
        named = ATTRIBUTE.findall(found["attributes"])
        said.words = [who, *("".join(one.split()) for one in named)]
    return said


def _clauses(text: str, found: re.Match[str]) -> SayStatement | None:
    """Return the parts from the text of a statement on; None if it does not end like one."""
    line = text.count("\n", 0, found.start("what"))
    said, at = SayStatement([], found["what"], line, raw=bool(found["raw"])), found.end()
    while at < len(text):
        bracket = re.compile(r"\s*\(").match(text, at)
        if bracket and not said.arguments:
            end = _closing(text, bracket.end() - 1)
            if not end:
                return None
            said.arguments, at = _arguments(text[bracket.end() : end - 1]), end
            continue
        clause = CLAUSE.match(text, at)
        if clause is None:
            break
        said.silent |= clause["silent"] is not None
        said.stated = clause["name"] or said.stated
        at = clause.end()
        if not clause["silent"] and not clause["name"]:
            end = _expression(text, re.compile(IDENTIFIER), at, commas=True)
            if not end:
                return None
            said.effect, at = text[at:end], end
    rest = text[at:].strip()
    said.block = rest.endswith(":")
    return said if rest in ("", ":") or CONDITION.fullmatch(text, at) else None


def _expression(text: str, start: re.Pattern[str], at: int = 0, *, commas: bool = False) -> int:
    """Return the end of an expression such as `d["x"].e`; 0 if there is none."""
    found = start.match(text, at)
    end = found.end() if found else 0
    while found:
        bracket = re.compile(r"\s*[\[({]").match(text, end)
        closed = _closing(text, bracket.end() - 1) if bracket else 0
        member = None if closed else MEMBER.match(text, end)
        more = None if closed or member or not commas else re.compile(r",\s*").match(text, end)
        if not closed and not member and not more:
            break
        end = closed or (member or more or found).end()
        if more and (found := start.match(text, end)):
            end = found.end()
    return end


def _closing(text: str, at: int) -> int:
    """Return the end of the bracket that opens there; 0 if it stays open."""
    depth = 0
    for found in TOKENS.finditer(text, at):
        depth += {"opening": 1, "closing": -1}.get(found.lastgroup or "", 0)
        if not depth:
            return found.end()
    return 0


def _arguments(text: str) -> str:
    """Return arguments, without their brackets, in the spelling of Ren'Py, with brackets."""
    parts, depth, start = list[str](), 0, 0
    for found in (*TOKENS.finditer(text), None):
        kind = found.lastgroup if found else "comma"
        depth += {"opening": 1, "closing": -1}.get(kind or "", 0)
        if kind == "comma" and not depth:
            part = text[start : found.start() if found else len(text)].lstrip()
            parts.append(KEYWORD.sub(r"\1=", part, count=1) if KEYWORD.match(part) else part)
            start = found.end() if found else 0
    stars = (re.sub(r"^(\*+)\s*", r"\1", part) for part in parts)
    return f"({', '.join(stars if parts[-1].strip() else [*stars][:-1])})"


def _spelled(text: str, *, raw: bool) -> str:
    """Return a text in quotes, with the spaces and escapes of a statement that Ren'Py writes."""

    def meaning(found: re.Match[str]) -> str:
        code, one = found.groups()
        return chr(int(code, 16)) if code else ESCAPE_MEANINGS.get(one, one)

    plain = text if raw else STRING_ESCAPE.sub(meaning, re.sub(r"[ \n]+", " ", text))
    return '"' + re.sub(r"(?<= ) ", r"\ ", plain.translate(STRING_SPELLINGS)) + '"'


@reader("renpy", suffixes=[".rpy"])
def read(source: LineFile) -> Iterator[Line]:
    """Ren'Py scripts: spoken lines, choices of menus, and translations."""
    passed, left, names = -1, 0, DialogueNames()
    for number, statement in _statements(source):
        indent = len(statement) - len(statement.lstrip())
        text = statement.strip()
        if 0 <= passed < indent:
            continue
        passed = indent if BLOCKS.match(text) and text.endswith(":") else -1
        said = None if passed >= 0 else _saying(text)
        if said is None:
            names.notice(text, indent)
            continue
        # Ren'Py writes an empty text for what is to be translated; a script has none.
        left += not said.what.strip("\"'` ")
        yield from _said(source, number, said, names)
        if said.block:
            names.notice(text, indent)
    if left:
        what = count(left, "empty or untranslated line", "empty or untranslated lines")
        source.remark(f"{source.path}: left out {what}")


def _said(
    source: LineFile, number: int, said: SayStatement, names: DialogueNames
) -> Iterator[Line]:
    who = next(iter(said.words), "")
    # A call that changes how a character speaks, such as `e(what_size=3)`, is the character.
    speaker = who[1:-1] if who[:1] in QUOTES else who.partition("(")[0].strip()
    speaker = "" if speaker in NOT_SPEAKERS else speaker
    whole, first = said.what, number + said.line
    parts = [(first, whole[1:-1])]
    if whole[:3] in TRIPLE_QUOTES:
        rows = groupby(enumerate(whole[3:-3].split("\n"), first), lambda row: bool(row[1].strip()))
        parts = [
            (begun, "\n".join([text, *(row for _, row in more)]).strip())
            for says, ((begun, text), *more) in rows
            if says
        ]
        if said.raw:
            parts = [(first, whole[3:-3])]
    for begun, text in parts:
        name = "" if who == "new" or said.block else names.of(said, text)
        original = "" if name else names.original or text
        if text.strip():
            yield source.line(begun, text, name=name, speaker=speaker, original=original)


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
        elif not closed and _saying(whole.split("\n")[0].strip() + '"'):
            source.remark(f"{source.path}:{number}: left out: a quote is not closed here")


def _without_comments(text: str) -> tuple[str, bool, int]:
    """Return a text without comments, True if its strings are closed, and open brackets."""
    kinds = [found.lastgroup for found in TOKENS.finditer(text)]
    if "comment" in kinds:
        text = TOKENS.sub(lambda found: "" if found["comment"] else found[0], text)
    return text, "lone" not in kinds, kinds.count("opening") - kinds.count("closing")
