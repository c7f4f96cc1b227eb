"""Japanese text to the kana of its reading.

Kanji, digits and Latin words do not say how they sound; Open JTalk's dictionary does, and knows
that 一本 is イッポン, that the particle は is ワ and へ is エ, and which vowels are long.
"""

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from itertools import pairwise
from typing import Any

from lipsync_lang import SpeechError
from lipsync_lang.base.extras import install_line
from lipsync_lang.text.phonology.g2p.g2p_engines import RESPELLERS, WHISPER

MAX_READ_CHARS = 1000
"""Maximum characters of a part; the dictionary's buffer is not much larger."""

_SENTENCE_MARKS = "。！？!?"
_SENTENCE = re.compile(rf"[^{_SENTENCE_MARKS}\n]+[{_SENTENCE_MARKS}]?")
"""A sentence with its mark: the dictionary needs that to tell the command 待て."""

_EDGES = " \t\r\u3000、，,・「」『』（）()【】〈〉《》［］[]…‥ー〜～―—–-"
"""Nothing is said of these where a sentence starts."""

_PLAIN_KANA = str.maketrans("ヲヂヅ’", f"オジズ{WHISPER}")
"""Towards the one spelling of a sound; the dictionary writes ’ after a whispered vowel."""

_MANNER = {"normalize_mode": "NFKC", "predict_nani": False, "use_sudachi_kanji_yomi": False}
"""The same on every computer, whatever else is installed there."""

_DRAWN_OUT = re.compile(r"(?<=[ぁ-ゖァ-ヺ])[~〜～]")
"""A wave dash after kana, which draws the vowel out as ー does; the dictionary pauses there."""

_WAVE_AS_LENGTH = str.maketrans("~〜～", "ーーー")

_SURROGATE = re.compile(r"[\ud800-\udfff]")
_KANA = re.compile(rf"[ァ-ヺー{WHISPER}]+")
_ENDING_TWICE = re.compile("動詞 .*テ [^て]て")
_INFLECTED = frozenset({"動詞", "形容詞", "助動詞"})
_FINAL = "基本形"


@RESPELLERS.register("kana")
def respell(text: str) -> list[tuple[str, str]]:
    """Cut a text into words, numbers and the gaps between them, each with its reading in kana.

    What is not speech, and what the dictionary cannot read, is spelled as it is. Numbers keep
    their counters, and verbs their endings, because these sound different by themselves.
    """
    pieces: list[tuple[str, str]] = []
    done = 0
    for start, stop in _sentences(text):
        if start > done:
            pieces.append((text[done:start], text[done:start]))
        pieces += _read(text[start:stop])
        done = stop
    if done < len(text):
        pieces.append((text[done:], text[done:]))
    return pieces


def _sentences(text: str) -> Iterator[tuple[int, int]]:
    """Yield (start, stop) of the parts of a text that may be spoken."""
    for found in _SENTENCE.finditer(text):
        stop = found.end()
        start = stop - len(found[0].lstrip(_EDGES))
        while stop - start > MAX_READ_CHARS:
            gap = max(text.rfind(mark, start, start + MAX_READ_CHARS) for mark in "、，, \u3000")
            until = gap + 1 if gap > start else start + MAX_READ_CHARS
            yield start, until
            start = until
        if start < stop:
            yield start, stop


def _read(sentence: str) -> list[tuple[str, str]]:
    """Return the words of a sentence with their kana; together they are the sentence."""
    reader = dictionary()
    # Half of a surrogate pair has no UTF-8, which the dictionary takes.
    plain = _SURROGATE.sub("\ufffd", sentence)
    plain = _DRAWN_OUT.sub(lambda wave: wave[0].translate(_WAVE_AS_LENGTH), plain)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what it is made of, about each other
        try:
            morphemes = reader.g2p_mapping(plain, **_MANNER)
        except ValueError:  # what it wrote cannot be traced back to the letters
            said = sentence.rstrip(_SENTENCE_MARKS)
            read = str(reader.g2p(plain[: len(said)], kana=True)).translate(_PLAIN_KANA)
            return [(said, read), (mark := sentence[len(said) :], mark)]
    if not morphemes:
        return [(sentence, sentence)]
    cuts: list[int] = []
    kana: list[str] = []
    before: dict[str, str] | None = None
    done = 0
    for morpheme in morphemes:
        start, stop = morpheme["char_span"]
        if before is None or (start < stop and not _belongs(before, morpheme)):
            cuts.append(done)
            kana.append("")
        done = max(done, stop)
        said = str(morpheme["pron"]).translate(_PLAIN_KANA)
        if said == "イウ" and morpheme["pos"] == "動詞":
            said = "ユー"  # 言う: the dictionary writes the spelling
        # 捨て: the dictionary says the ending of some stems in kanji, and then again
        again = before and f"{before['pos']} {before['pron']} {sentence[start - 1 : stop]}"
        if not (again and _ENDING_TWICE.fullmatch(again)):
            kana[-1] += said if _KANA.fullmatch(said) else sentence[start:stop]
        before = morpheme
    cut = (sentence[slice(*span)] for span in pairwise((*cuts, len(sentence))))
    return list(zip(cut, kana, strict=True))


def _belongs(before: dict[str, str], morpheme: dict[str, str]) -> bool:
    """Return True if a morpheme continues the word before; さん after a name does not."""
    if _number(before) and _number(morpheme):
        return True
    group = morpheme["pos_group1"]
    if morpheme["pos"] == "名詞":
        suffix = group == "接尾" and morpheme["pos_group2"] != "人名"
        return suffix and before["pos"] == "名詞"
    bent = before["pos"] in _INFLECTED and before["cform"] != _FINAL
    ends = morpheme["pos"] == "助動詞" or group in {"接続助詞", "接尾", "非自立"}
    return ends and (bent or before["pos_group1"] == "接続助詞")


def _number(morpheme: dict[str, str]) -> bool:
    return bool(morpheme["pos_group1"] == "数" or morpheme["pron"] == "テン")


@cache
def dictionary() -> Any:
    """Return Open JTalk's reader; its greeting on standard output is not for our users."""
    missing = SpeechError(
        "Japanese text is read by pyopenjtalk-plus, which is not installed; "
        f"get it with: {install_line('japanese')}"
    )
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            reader = import_module("pyopenjtalk")
    except ImportError:
        raise missing from None
    if not hasattr(reader, "g2p_mapping"):  # the library that it continues has the same name
        raise missing
    return reader
