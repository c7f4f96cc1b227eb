"""Text in ordinary letters: composed, of ordinary width, without invisible marks.

Unicode writes one letter in several ways. Engines, lexicons and rules know one of them, and misread
the others without a word: a decomposed ``ü`` becomes an ``u``, a full-width ``５`` is lost.
"""

import re
from unicodedata import normalize

UNUSUAL = re.compile(
    "(?:["
    "０-９Ａ-Ｚａ-ｚ＇－＋＝％＆＃＠＄＾＿｜￠-￦"  # full width
    "\uff66-\uffdc"  # half-width kana and hangul
    "\u2460-\u2473\u3380-\u33df\u203c\u2047-\u2049"  # numbers in circles, units, double marks
    "\u01c4-\u01cc\u01f1-\u01f3\u0132\u0133\ufb00-\ufb4f"  # ligatures
    "\ufb50-\ufd3d\ufd50-\ufdfb\ufe70-\ufefc"  # shapes of Arabic letters
    "\U0001d400-\U0001d7ff"  # letters of formulas
    "]|(?<=[0-9０-９])[．，：／](?=[0-9０-９]))+"
)
"""Compatibility characters that are ordinary letters, digits and signs in another shape."""

UNSEEN = re.compile("[\u00ad\u034f\u061c\u200e\u200f\u202a-\u202e\u2060-\u2069\ufeff]+")
"""Soft hyphens, directions of writing, and spaces without width."""

APOSTROPHE = re.compile("(?<=[^\\W\\d_])[’‘ʼ´`′](?=[^\\W\\d_])")
"""An apostrophe within a word, in any of its spellings."""


def ordinary(text: str) -> str:
    """Return a text in ordinary letters.

    Letters are composed (NFC); letters and digits of full width, half width or another shape become
    their ordinary selves; an apostrophe within a word is ``'``. Characters without a shape of their
    own, such as marks of direction, are left out.

    >>> ordinary("u\u0308ber ５０ lʼami")
    "über 50 l'ami"
    """
    if text.isascii():
        return APOSTROPHE.sub("'", text) if "`" in text else text
    text = UNUSUAL.sub(lambda found: normalize("NFKC", found[0]), UNSEEN.sub("", text))
    return APOSTROPHE.sub("'", normalize("NFC", text))
