"""Orthography profiles: tables of a language's graphemes and their sounds, in the form of CLDF.

Tabs divide the columns, and the first line names them. Each further line has a grapheme, under
`Grapheme`, and its sounds, with spaces between them, under `IPA` or another column. ``NULL`` is no
sound. The form has no comments: ``#`` is a grapheme like others. Graphemes are kept decomposed
(NFD), so that a mark may be a grapheme of its own. In a grapheme, ``^`` is the start of a word and
``$`` its end.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from io import StringIO
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple
from unicodedata import combining, normalize

from lipsync_lang.base.errors import SpeechError, did_you_mean
from lipsync_lang.base.files.reading import MIB_BYTES, input_text
from lipsync_lang.text.phonology.g2p.g2p_engines import Settings
from lipsync_lang.text.phonology.g2p.tokens import APOSTROPHES, counts

GRAPHEME, SOUNDS = "Grapheme", "IPA"
"""Names of the columns, unless a pack names another one for the sounds."""

BY_PROFILE = "segments"
"""The backend of phonemizer that reads by a profile."""

MUTE = "NULL"

ADD = f"add a line for each, with its sounds, or {MUTE} if it is mute"
"""Advice on letters without a grapheme."""

START, END = "^", "$"

MAX_PROFILE_BYTES = 4 * MIB_BYTES
"""Maximum size of a profile in bytes; one of 300 graphemes has some 10,000."""

MAX_GRAPHEME_CHARS = 12
"""Maximum length of a grapheme. The search of phonemizer doubles with each few characters."""


class ProfileRow(NamedTuple):
    """A grapheme of a profile, decomposed, with its sounds; or the mistake in its line."""

    line: int
    grapheme: str = ""
    sounds: tuple[str, ...] = ()
    wrong: str = ""
    mend: str = ""


class Graphemes:
    """Graphemes with their sounds, and words cut into them: the longest that fits comes first.

    A capital that the profile does not state is read as its small letter.
    """

    def __init__(self, rows: Sequence[ProfileRow]) -> None:
        self.sounds = {row.grapheme: row.sounds for row in rows}
        for row in rows:
            one = row.grapheme
            for spelling in (one.casefold(), one.upper(), one[:1].upper() + one[1:]):
                self.sounds.setdefault(normalize("NFD", spelling), row.sounds)
        longest_first = sorted(self.sounds, key=len, reverse=True)
        self._pattern = re.compile("|".join([*map(re.escape, longest_first), "."]), re.DOTALL)
        self._bounded = any(START in one or END in one for one in self.sounds)

    def cut(self, word: str) -> tuple[list[str], str]:
        """Return the graphemes of a word, and its letters that have none."""
        spelled = _plain(word)
        parts = self._pattern.findall(f"{START}{spelled}{END}" if self._bounded else spelled)
        unread = [
            # A mark is shown on its letter.
            normalize("NFC", before + part) if combining(part[0]) else part
            for before, part in pairwise(["", *parts])
            if part not in self.sounds and counts(part)
        ]
        return [part for part in parts if part in self.sounds], "".join(unread)


def lacking(settings: Settings, unread: Iterable[str]) -> Iterator[str]:
    """Yield advice on the letters of a text that the profile of its language lacks."""
    letters = " ".join(one for one in unread if counts(one))
    if settings.backend == BY_PROFILE and settings.file and letters:
        yield f"{settings.file.name}: has no grapheme for {letters}; {ADD}"


def read_profile(path: Path, column: str = SOUNDS) -> Graphemes:
    """Read a profile; raise `SpeechError` for the first mistake in it."""
    rows = list(profile_rows(path, column))
    for row in rows:
        if row.wrong:
            raise SpeechError(f"{path}:{row.line}: {row.wrong}; {row.mend}")
    return Graphemes(rows)


def profile_rows(path: Path, column: str = SOUNDS) -> Iterator[ProfileRow]:
    """Yield the graphemes of a profile, and the mistakes in it, line by line.

    Raise `SpeechError` if the file cannot be read as text.
    """
    mend = "keep one line for each grapheme"
    text = input_text(path, MAX_PROFILE_BYTES, error=SpeechError, mend=mend)
    places: list[int] = []
    first: dict[str, int] = {}
    # Lines end as in all files; `splitlines` would also cut at rarer characters.
    for number, line in enumerate(StringIO(text, newline=None), start=1):
        if not line.strip():
            continue
        try:
            (cells,) = csv.reader([line], delimiter="\t", strict=True)
        except csv.Error:
            mend = 'write a mark that is a grapheme as four: """"'
            yield ProfileRow(number, wrong="a quotation mark is not closed", mend=mend)
            continue
        cells = [cell.strip() for cell in cells]
        if not places:
            missing = next((name for name in (GRAPHEME, column) if name not in cells), None)
            if missing is not None:
                hint = did_you_mean(missing, filter(None, cells))
                mend = f"{hint}; the first line names the columns, and tabs divide them"
                yield ProfileRow(number, wrong=f"there is no column '{missing}'", mend=mend)
                return
            places = [cells.index(GRAPHEME), cells.index(column)]
            continue
        grapheme, sounds = (cells[at] if at < len(cells) else "" for at in places)
        row = _row(number, _plain(grapheme), sounds, column)
        if row.grapheme in first and not row.wrong:
            wrong = f"'{grapheme}' is in line {first[row.grapheme]} already"
            row = ProfileRow(number, wrong=wrong, mend="keep one of the two lines")
        first.setdefault(row.grapheme, number)
        yield row
    if not first:
        mend = "write one a line, with its sounds"
        yield ProfileRow(1, wrong="there are no graphemes", mend=mend)


def _row(number: int, grapheme: str, sounds: str, column: str) -> ProfileRow:
    if not grapheme:
        wrong, mend = "the grapheme is empty", "write it, or delete the line"
    elif len(grapheme) > MAX_GRAPHEME_CHARS or any(map(str.isspace, grapheme)):
        wrong = f"{grapheme[: 2 * MAX_GRAPHEME_CHARS]!r} is no grapheme"
        mend = f"write at most {MAX_GRAPHEME_CHARS} characters of one word"
    elif not sounds:
        wrong = f"'{grapheme}' has no sounds"
        mend = f"write its sounds under `{column}`, or {MUTE} if it is mute"
    else:
        return ProfileRow(number, grapheme, tuple(one for one in sounds.split() if one != MUTE))
    return ProfileRow(number, wrong=wrong, mend=mend)


def _plain(text: str) -> str:
    return normalize("NFD", text).translate(APOSTROPHES)
