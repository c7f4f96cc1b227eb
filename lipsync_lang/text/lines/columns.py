"""Columns of a table of lines: which of them is the text, the line's name, the speaker.

A column may be named after a language: by the language's name, title, tag or an alias of it, alone
("German", "de"), with a region ("de-AT"), in brackets ("German (de)"), or beside a word for text
("text_de"). Spaces, underscores, accents and the case of letters make no difference.
"""

import re
from collections.abc import Collection, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, shortlist
from lipsync_lang.text.phonology.language_names import folded_language

if TYPE_CHECKING:
    from lipsync_lang.text.lines.line_readers import LineFile

TEXT_COLUMNS = ("text", "line", "dialogue", "dialog", "subtitle", "message", "source", "string")
# Keys before ids: tables of Unity Localization have both, and its ids are long numbers.
NAME_COLUMNS = ("line_id", "lineid", "key", "keys", "id", "name", "identifier")
SPEAKER_COLUMNS = ("speaker", "character", "who", "actor", "role")
"""Names of columns, in small letters, most likely first."""

BESIDE_LANGUAGES = (*TEXT_COLUMNS, "translation", "version", "vo", "voice")
"""Words beside the name of a language in the name of a text column."""

USUAL_WORDS = {"id", "no"}
"""Tags of languages that mean something else in names of columns, such as "voice_id", "line no"."""

MAX_TITLE_ROWS = 10
"""Number of rows at the start of a table among which the names of its columns are looked for."""

LIKENESS = 0.75
"""Least similarity of a mistyped column; languages are more alike than that by chance."""

_BRACKETED = re.compile(r"(.*?)[-([{]+([^()\[\]{}]*)[)\]}]+")
_BESIDE_TEXT = re.compile(
    rf"(?:(?:{'|'.join(BESIDE_LANGUAGES)})-(.+)|(.+)-(?:{'|'.join(BESIDE_LANGUAGES)}))"
)
_TAG = re.compile(r"[a-z]{2,3}-(?:[a-z]{2}|[0-9]{3})")
_REGION = r"-(?:[a-z]{2}|[0-9]{3})"


def head_row(rows: Sequence[Sequence[str]]) -> int:
    """Return the index of the row that names the columns: the first one, unless that is a title.

    A title has fewer cells than the row of names below it, which has a column of ids.
    """
    counts = [sum(bool(one.strip()) for one in row) for row in rows]
    names = (at for at, row in enumerate(rows) if first_column(row, NAME_COLUMNS) >= 0)
    return next((at for at in names if counts[at] > counts[0]), 0)


def first_column(head: Sequence[str], known: Sequence[str], taken: Collection[int] = ()) -> int:
    """Return the index of the column with the first known name, or -1."""
    found = [(name.strip(), at) for at, name in enumerate(head) if at not in taken]
    # Of equal names the first column is to stay.
    folded = {name.casefold(): at for name, at in reversed(found)}
    return next((folded[name] for name in known if name in folded), -1)


def stated_column(source: "LineFile", head: Sequence[str], asked: str) -> int:
    """Return the index of a column by name, or by number from 1."""
    folded = [name.casefold() for name in head]
    if asked in head:
        return head.index(asked)
    if asked.casefold() in folded:
        return folded.index(asked.casefold())
    if asked.isdecimal() and 1 <= int(asked) <= len(head):
        return int(asked) - 1
    own = folded_language(asked) in map(folded_language, source.names)
    if own and (at := language_column(head, source.names)) >= 0:
        return at
    near = get_close_matches(asked, head, 1, LIKENESS)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    raise lacking(source, head, f"has no column '{asked}'{hint}")


def known_column(
    source: "LineFile",
    head: Sequence[str],
    asked: str | None,
    known: Sequence[str],
    taken: Collection[int] = (),
) -> int:
    """Return the index of the stated column, or of the one with the first known name, or -1."""
    return first_column(head, known, taken) if asked is None else stated_column(source, head, asked)


def text_column(head: Sequence[str]) -> int:
    """Return the index of the column that is most likely the text in any language, or -1."""
    if (known := first_column(head, TEXT_COLUMNS)) >= 0:
        return known
    others = (*NAME_COLUMNS, *SPEAKER_COLUMNS)
    other = [at for at, name in enumerate(head) if name.casefold() not in others]
    return other[0] if len(other) == 1 else -1


def language_column(head: Sequence[str], names: Sequence[str]) -> int:
    """Return the index of the column that is named after a language, or -1.

    `names` are the name, title, tag and aliases of the language, the likeliest first.
    """
    wholes = [folded_language(name) for name in head]
    forms = [_forms(whole) for whole in wholes]
    asked = list(dict.fromkeys(folded_language(name) for name in names if name))
    for name in asked:
        if name in wholes and _is_free(head, wholes.index(name)):
            return wholes.index(name)
    for name in asked:
        regional = re.compile(re.escape(name) + _REGION)
        own = [at for at, form in enumerate(forms) if name in form]
        local = [at for at, form in enumerate(forms) if any(map(regional.fullmatch, form))]
        # A region counts only if no column has the language alone; two columns leave it open.
        for at, *others in filter(None, (own, local)):
            if not others and _is_free(head, at):
                return at
    return -1


def lacking(source: "LineFile", head: Sequence[str], what: str) -> LipsyncError:
    """Return an error that lists the first columns."""
    end = "" if what.endswith((".", "?")) else "."
    return source.fault(1, f"{what}{end} Its columns: {shortlist(head, MAX_KNOWN)}")


def _is_free(head: Sequence[str], at: int) -> bool:
    """Return False for the only column of ids: the tag "id" of a language is a usual name there."""
    ids = head[at].casefold() in NAME_COLUMNS
    return not ids or first_column(head, NAME_COLUMNS, [at]) >= 0


def language_parts(name: str) -> tuple[str, ...]:
    """Return the parts of a column's name that may be a language, the whole name first."""
    parts = _forms(folded_language(name))
    likely = (part for part in parts if part not in USUAL_WORDS)
    # In "line in it" stands no tag such as "in-it".
    written = name.replace("_", "-").casefold()
    return (name, *(part for part in likely if not _TAG.fullmatch(part) or part in written))


def _forms(whole: str) -> tuple[str, ...]:
    """Return what else a column may be named after: its parts without brackets and text words.

    "Chinese (Simplified)" may be named after "Chinese", "Simplified" and "Chinese Simplified".
    """
    bracketed = _BRACKETED.fullmatch(whole)
    inner = [part.strip("-") for part in bracketed.groups()] if bracketed else []
    parts = [whole, *inner, *(["-".join(inner)] if bracketed else [])]
    beside = [found for part in parts if (found := _BESIDE_TEXT.fullmatch(part))]
    return (*parts, *(one for found in beside for one in found.groups() if one))
