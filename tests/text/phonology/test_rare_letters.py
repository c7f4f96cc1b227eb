"""Foreign names with letters that a voice lacks."""

from unicodedata import normalize

import pytest
from lanes import swept

from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.g2p.rare_letters import RareLetters, plainer

pytest.importorskip("espeakng_loader", reason="the extra speech is not installed")

NAMES = ("Nguyễn", "Phạm", "Trần", "Đỗ", "Hoàng Thị Hồng", "Adébáyọ̀", "Ọláolú", "Ḥasan", "Ṣalāḥ")
LANGUAGES = ("english", "german", "french", "spanish", "italian", "polish", "finnish", "turkish")


@pytest.mark.parametrize("language", swept(LANGUAGES, quick=2))
def test_a_name_with_rare_letters_is_a_word_and_not_numbers(language):
    speaker = Speaker.of(language)
    spellings = [*NAMES, *(normalize("NFD", name) for name in NAMES)]
    for name, read in zip(spellings, speaker.transcribe(spellings), strict=True):
        letters = [one for one in normalize("NFC", name) if one.isalpha()]
        assert len(read.labels) <= len(letters) + 2, (name, read.labels)
        texts = "".join(word.text for word in read.words)
        assert texts == normalize("NFC", name).replace(" ", "")
    (told,) = next(speaker.transcribe(["Phạm and Phạm"])).advice
    assert told.endswith("lacks letters of this text, and reads 'ạ' as 'a'")


@pytest.mark.parametrize("name", ["Phạm", normalize("NFD", "Phạm")])
def test_a_name_is_spoken_as_it_is_read(name):
    speaker = Speaker.of("english")
    (odd, usual) = speaker.speak_many([f"Mister {name} knows.", "Mister Pham knows."])
    assert odd.labels == usual.labels
    assert odd.end == pytest.approx(usual.end, abs=0.05)
    assert [word.text for word in odd.words] == ["Mister", "Phạm", "knows"]


@pytest.mark.parametrize(
    ("language", "text"), [("vietnamese", "Nguyễn Phạm"), ("yoruba", "ọjọ́ ẹ̀kọ́")]
)
def test_languages_keep_letters_of_their_own(language, text):
    (read,) = Speaker.of(language).transcribe([text])
    assert not read.advice


def test_an_ordinary_text_asks_the_engine_nothing():
    def refuse(words):
        raise AssertionError(words)

    rare = RareLetters(refuse)
    assert not [*rare.found_in("Łukasz Đorđe Øyvind Guðrún Dvořák İstanbul, Zoë! Вот 你好")]


def test_a_letter_is_tried_once_and_in_either_form():
    asked = []

    def count(words):
        asked.extend(words)
        return [12 if "ễ" in word else None if "ɓ" in word else 4 for word in words]

    rare = RareLetters(count)
    text = "Nguyễn " + normalize("NFD", "NGUYỄN") + " ɓe ọ"
    found = [(one.start, text[one.start : one.stop], one.read) for one in rare.found_in(text)]
    assert found[0] == (0, "Nguyễn", "Nguyên")
    assert found[-1][1:] == ("ɓe", "be")
    assert rare.instead("ọ") == {}
    count_of = len(asked)
    assert [*rare.found_in(text)]
    assert len(asked) == count_of


def test_letters_lose_no_more_marks_than_they_must():
    assert [plainer(one) for one in "ễộớạḥⱥɓƁш"] == [*"êôơah", "a", "b", "B", "ш"]
