"""Tags, aliases and titles of languages, found by regular expressions instead of a YAML parser.

A look-up by tag searches every language's file, and parsing them all would take too long.
"""

import re
from pathlib import Path

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.yaml.source import read_bytes
from lipsync_lang.text.phonology.language_names import folded_language

_TAG_FIELD = re.compile(rb"^tag:[ \t]*[\"']?([A-Za-z0-9-]+)", re.MULTILINE)
_ALIASES = re.compile(
    rb"^aliases:[ \t]*(?P<listed>\[[^\]]*\]|(?:(?:[ \t]*#[^\n]*|[ \t\r]*)\n[ \t]*-[ \t][^\n]*)+)",
    re.MULTILINE,
)
_LIST_SIGNS = re.compile(r"[\[\],]|^[ \t]*-[ \t]", re.MULTILINE)
_TITLE_FIELD = re.compile(rb"^title:[ \t]*[\"']?([^\"'#\r\n]+)", re.MULTILINE)
_YAML_COMMENT = re.compile(rb"#[^\n]*")


def answers_of(path: Path) -> list[str]:
    """Return the tag and then the aliases of a language's file, folded; empty if unreadable.

    Aliases may be a list in brackets, on one line or several, or one item per line.
    """
    try:
        content = read_bytes(path)
    except PackError:
        return []
    tag, aliases = _TAG_FIELD.search(content), _ALIASES.search(content)
    listed = _YAML_COMMENT.sub(b"", aliases["listed"]).decode("utf-8", "ignore") if aliases else ""
    stated = [item.strip(" \t\r\n\"'") for item in _LIST_SIGNS.split(listed)]
    found = [*([tag[1].decode("ascii")] if tag else []), *filter(None, stated)]
    return list(dict.fromkeys(map(folded_language, found)))


def named_as(path: Path) -> list[str]:
    """Return the name, title, tag and aliases of a language's file, folded."""
    try:
        title = _TITLE_FIELD.search(read_bytes(path))
    except PackError:
        title = None
    stated = title[1].decode("utf-8", "ignore").strip() if title else ""
    names = [path.stem, *([stated] if stated else []), *answers_of(path)]
    return list(dict.fromkeys(map(folded_language, names)))
