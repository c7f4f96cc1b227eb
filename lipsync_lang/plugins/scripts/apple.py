"""Apple's .strings and .stringsdict: a text for each key, and its plural forms."""

import plistlib
import re
from collections.abc import Iterator
from itertools import product
from typing import Any
from xml.parsers.expat import ExpatError

from lipsync_lang.text.lines.entries import ScriptEntry, entry_lines, whole_file
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

QUOTED_TEXT = r"\"((?:[^\"\\]|\\.)*)\""
APPLE_PAIR = re.compile(
    rf"\s*+(?:/\*(?P<note>.*?)\*/|//(?P<row>[^\n]*)"
    rf"|(?:{QUOTED_TEXT}|(?P<bare>[\w.-]+))\s*+=\s*+{QUOTED_TEXT}\s*+;)",
    re.DOTALL,
)
"""A comment, or a key and its text."""

APPLE_ESCAPE = re.compile(r"\\(?:U([0-9A-Fa-f]{4})|(.))", re.DOTALL)
PLURAL = re.compile(r"%(?:\d+\$)?#@(\w+)@")
FORMAT_KEY, KIND_KEY = "NSStringLocalizedFormatKey", "NSStringFormatSpecTypeKey"
CATEGORIES = ("zero", "one", "two", "few", "many", "other")


@reader("strings", suffixes=[".strings"])
def read_strings(source: LineFile) -> Iterator[Line]:
    """Apple's .strings: a text for each key; comments may name the speaker."""
    return entry_lines(source, _pairs(source, whole_file(source).text))


def _pairs(source: LineFile, text: str) -> Iterator[ScriptEntry]:
    at, line = 0, 1
    notes: list[str] = []
    while found := APPLE_PAIR.match(text, at):
        begun = found.end() - len(found[0].lstrip())
        line, at = line + text.count("\n", at, begun), begun
        note = found["note"] if found["row"] is None else found["row"]
        if note is not None:
            notes.append(note.strip())
        else:
            key, said = found["bare"] or found[3] or "", found[5]
            key, said = (APPLE_ESCAPE.sub(_apple_escape, one) for one in (key, said))
            yield ScriptEntry(line, key, said, notes=tuple(notes))
            notes = []
        line, at = line + text.count("\n", at, found.end()), found.end()
    if rest := text[at:].lstrip():
        line += text.count("\n", at, len(text) - len(rest))
        what = f'not a pair: {rest.splitlines()[0][:40]}; write "key" = "text";'
        raise source.fault(line, what)


def _apple_escape(found: re.Match[str]) -> str:
    code, one = found.groups()
    # The cleaning of texts reads `\n` as the end of a row, as in other scripts.
    return chr(int(code, 16)) if code else found[0] if one == "n" else one


@reader("stringsdict", suffixes=[".stringsdict"])
def read_stringsdict(source: LineFile) -> Iterator[Line]:
    """Apple's .stringsdict: each plural form of a text."""
    file = whole_file(source)
    try:
        # The reader of the standard library refuses entities.
        whole = plistlib.loads(file.text.encode(), fmt=plistlib.FMT_XML)
    except (ExpatError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise source.fault(1, f"not a property list: {error}; export it again") from None
    if not isinstance(whole, dict):
        raise source.fault(1, "has no keys; check that it is a .stringsdict")
    found = (
        ScriptEntry(file.line_of(f"<key>{key}</key>") or 1, f"{key}-{form}" if form else key, text)
        for key, fields in whole.items()
        if isinstance(fields, dict)
        for form, text in _forms(fields)
    )
    return entry_lines(source, found)


def _forms(fields: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield (name, text) of each combination of plural forms."""
    text = str(fields.get(FORMAT_KEY, ""))
    # Two plurals of six forms make 36 texts; a third would make 216.
    names = list(dict.fromkeys(PLURAL.findall(text)))[:2]
    given = [fields[name] for name in names if isinstance(fields.get(name), dict)]
    ways = [[one for one in CATEGORIES if one in each] for each in given]
    for forms in product(*ways):
        said = text
        for name, fields_of, form in zip(names, given, forms, strict=False):
            # A backslash would be an escape in the replacement of `re.sub`.
            instead = str(fields_of[form]).replace("\\", r"\\")
            said = re.sub(rf"%(?:\d+\$)?#@{name}@", instead, said)
        yield "-".join(forms), said
