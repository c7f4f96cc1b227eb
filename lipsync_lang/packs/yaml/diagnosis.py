"""Causes of YAML errors in plain words: where the mistake began, and how to mend it.

A parser tells where it gave up, which may be many lines below the mistake.
"""

import re
from typing import NamedTuple

from lipsync_lang.packs.yaml.events import YamlError

_WHOLE_QUOTES = re.compile(r"\"(?:\\.|[^\"\\])*\"|'(?:[^']|'')*'|(?<!\S)#.*")
_OPEN_QUOTE = re.compile(r"(?:^|[\s:,\[{-])([\"'])")
_KEY_LINE = re.compile(r"\s*(?:- )?[^\s#\"'\[{][^:#]*:(?:\s|$)")
_CURLY = re.compile("[“”„‘’‚]")
_COLON = re.compile(r":(?=\s|$)")
_CLOSING_BRACKETS = {"[": "]", "{": "}"}

_BAD_START = re.compile(
    "cannot start any token|comment or line break|alphabetic or numeric|indentation indic|directive"
)
"""Words of libyaml, and of ruamel.yaml without it, about text that begins with a sign of YAML."""

_BAD_ESCAPE = re.compile("escape c|hexadecimal|hexdecimal")


class Cause(NamedTuple):
    """The place of a mistake from 1, the mistake, and its cure."""

    line: int
    column: int
    what: str
    hint: str


def cause(  # noqa: PLR0911 one return for each cause
    text: str, error: YamlError, place: tuple[int, int]
) -> Cause | None:
    """Return the likely cause of a parser's error; None if the parser's words must do."""
    lines = [_WHOLE_QUOTES.sub(lambda found: "_" * len(found[0]), one) for one in text.splitlines()]
    line, column = place
    first = min(error.started or line, line)
    shown = lines[line - 1]
    if found := _open_quote(lines, line):
        return found
    for number in dict.fromkeys((line, first)):
        if curly := _CURLY.search(lines[number - 1]):
            what = f"curly quotes ({curly[0]}) are no quotes in YAML"
            return Cause(number, curly.start() + 1, what, 'write straight quotes (") instead')
    if _BAD_ESCAPE.search(error.problem):
        hint = "write `\\\\` for a backslash, `/` in paths, or use single quotes"
        return Cause(line, column, "a backslash in double quotes begins an escape", hint)
    signs = [at for at, sign in enumerate(shown[:column], 1) if sign in "@`%*&|>"]
    if signs and _BAD_START.search(error.problem):
        what = f"text may not begin with '{shown[signs[-1] - 1]}'"
        return Cause(line, signs[-1], what, "put the text into quotes")
    if "could not find expected ':'" in error.problem:
        return _colon(lines, first)
    if "expected ',' or" in error.problem:
        return _bracket(lines, first, line, column)
    if "flow node" in error.context:  # nothing follows a bracket, or a comma within it
        return _bracket(lines, 1, line, column)
    return _block(lines, line, column)


def _open_quote(lines: list[str], last: int) -> Cause | None:
    """Find a quote without an end in its line, before lines that look like keys."""
    for number, line in enumerate(lines[:last], 1):
        found = _OPEN_QUOTE.search(line)
        if found and (number == len(lines) or any(map(_KEY_LINE.match, lines[number:last]))):
            what = f"the text that begins with a quote ({found[1]}) here has no closing quote"
            return Cause(number, found.start(1) + 1, what, f"write {found[1]} at its end")
    return None


def _colon(lines: list[str], number: int) -> Cause:
    """Explain a line that lacks a colon, or the space after it."""
    line = lines[number - 1]
    key = line.strip()
    column = len(line) - len(line.lstrip()) + 1
    if tight := re.match(r"\s*(?:- )?[^\s:]+:(?=\S)", line):
        what = "a space is missing after the colon"
        return Cause(number, tight.end(), what, f"write `{line[: tight.end()].strip()} ...`")
    first, _, rest = key.partition(" ")
    mended = f"{first}: {rest}".rstrip()
    return Cause(number, column, f"'{first}' has no colon after it", f"write `{mended}`")


def _bracket(lines: list[str], first: int, line: int, column: int) -> Cause:
    """Explain a bracket that is not closed, or is closed by another."""
    opened: list[tuple[int, int, str]] = []
    for number, text in enumerate(lines[first - 1 : line], first):
        for at, sign in enumerate(text, 1):
            if (number, at) >= (line, column):
                break
            if sign in _CLOSING_BRACKETS:
                opened.append((number, at, sign))
            elif sign in _CLOSING_BRACKETS.values() and opened:
                opened.pop()
    number, at, sign = opened[-1] if opened else (first, 1, "[")
    closing = _CLOSING_BRACKETS[sign]
    if lines[line - 1][column - 1 : column] in set("]}") - {closing}:
        what = f"'{sign}' is closed by '{lines[line - 1][column - 1]}'"
        return Cause(line, column, what, f"write '{closing}' here")
    what = f"the bracket '{sign}' that opens here is not closed"
    return Cause(number, at, what, f"write '{closing}' at its end")


def _block(  # noqa: PLR0911 one return for each cause
    lines: list[str], line: int, column: int
) -> Cause | None:
    """Explain a line that does not fit those above: a colon, a bracket, a dash or a margin."""
    shown = lines[line - 1]
    stripped, margin = shown.strip(), len(shown) - len(shown.lstrip())
    above = next((n for n in range(line - 1, 0, -1) if lines[n - 1].strip()), 0)
    sign = shown[column - 1 : column]
    if sign and sign in "]}":
        return Cause(line, column, f"there is no open bracket for '{sign}'", "delete it")
    if re.match(r"-[^\s-]", stripped):
        return Cause(line, margin + 1, "a space is missing after the dash", "write `- ` before it")
    if re.search(r"(?:^|: )[\[{][^\]}]*[\]}]\s*[^\s,\]}#]", stripped):
        what = "text that begins with a bracket is read as a list or a mapping"
        return Cause(line, column, what, "put the text into quotes")
    if re.search(r"_{2,} *\S", shown) and shown[: column - 1].rstrip().endswith("_"):
        return Cause(line, column, "text goes on after its closing quote", "end it with the quote")
    if len(_COLON.findall(re.sub(r"[\[{].*", "", stripped))) > 1:
        what = "text with a colon and a space must be in quotes"
        return Cause(line, column, what, "put the text after the first colon into quotes")
    if above and not _COLON.search(lines[above - 1]) and lines[above - 1].lstrip()[:1] != "-":
        return _colon(lines, above)
    beside = len(lines[above - 1]) - len(lines[above - 1].lstrip()) if above else 0
    if margin != beside:
        what = f"the line is indented by {margin}, unlike the lines beside it"
        return Cause(line, margin + 1, what, f"line {above} is indented by {beside} spaces")
    return None
