"""Identifiers of dialogue in Ren'Py, which a line and its translations share.

An identifier is the last label, and a digest of the statement in a fixed spelling, such as
``start_915cb944``. Translations state it, and files of voices have it as their name.
"""

import re
from collections.abc import Sequence
from hashlib import md5

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
    """Names of the dialogue of a file, whose statements pass by in order."""

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
