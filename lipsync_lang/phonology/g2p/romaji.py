"""Romaji, Japanese in Latin letters, to kana by its syllables."""

import re
from unicodedata import normalize

_VOWELS = "aiueo"

_ROWS = {
    "": "ア イ ウ エ オ", "k": "カ キ ク ケ コ", "s": "サ シ ス セ ソ", "t": "タ チ ツ テ ト",
    "n": "ナ ニ ヌ ネ ノ", "h": "ハ ヒ フ ヘ ホ", "m": "マ ミ ム メ モ", "y": "ヤ - ユ - ヨ",
    "r": "ラ リ ル レ ロ", "w": "ワ - - - オ", "g": "ガ ギ グ ゲ ゴ", "z": "ザ ジ ズ ゼ ゾ",
    "d": "ダ ジ ズ デ ド", "b": "バ ビ ブ ベ ボ", "p": "パ ピ プ ペ ポ",
    "f": "ファ フィ フ フェ フォ", "j": "ジャ ジ ジュ ジェ ジョ", "ts": "- - ツ - -",
    "sh": "シャ シ シュ シェ ショ", "ch": "チャ チ チュ チェ チョ", "ky": "キャ - キュ - キョ",
    "gy": "ギャ - ギュ - ギョ", "ny": "ニャ - ニュ - ニョ", "hy": "ヒャ - ヒュ - ヒョ",
    "my": "ミャ - ミュ - ミョ", "ry": "リャ - リュ - リョ", "by": "ビャ - ビュ - ビョ",
    "py": "ピャ - ピュ - ピョ",
}  # fmt: skip
"""Kana of each first consonant before the five vowels; `-` for a syllable that there is not."""

_KANA = {
    start + vowel: kana
    for start, row in _ROWS.items()
    for vowel, kana in zip(_VOWELS, row.split(), strict=True)
    if kana != "-"
}

_SYLLABLE = re.compile(
    r"(?P<long>(?<=o)[ou]|(?<=u)u|(?<=a)a|(?<=e)e|\u0304|\u0302)"
    r"|(?P<double>(?P<first>[kstpgdbzjfc])(?=(?P=first))|t(?=ch))"
    r"|(?P<nasal>n(?![aiueoy])'?|m(?=[bmp]))"
    rf"|(?P<start>[kstnhmyrwgzdbpfjc]{{0,2}})(?P<vowel>[{_VOWELS}])"
)


def romaji_kana(word: str) -> str:
    """Return the kana of a word in romaji; empty for a word that has other syllables.

    >>> romaji_kana("Kōhii"), romaji_kana("gakkou"), romaji_kana("string")
    ('コーヒイ', 'ガッコー', '')
    """
    text, kana, at = normalize("NFD", word.lower()), "", 0
    while at < len(text):
        found = _SYLLABLE.match(text, at)
        if found is None:
            return ""
        if found["long"] or found["double"] or found["nasal"]:
            kana += "ー" if found["long"] else "ッ" if found["double"] else "ン"
        elif found[0] in _KANA:
            kana += _KANA[found[0]]
        else:
            return ""
        at = found.end()
    return kana
