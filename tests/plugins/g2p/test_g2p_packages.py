"""Text to phonemes by packages for single languages, and guesses of vowels."""

import pytest
from lanes import full

from lipsync_lang import SpeechError
from lipsync_lang.plugins.g2p import niqqud, tashkeel
from lipsync_lang.text.phonology.g2p import Settings, SpokenWord, engine
from lipsync_lang.text.phonology.g2p.espeak_g2p import as_written
from lipsync_lang.text.phonology.g2p.g2p_engines import Rule
from lipsync_lang.text.phonology.g2p.tokens import plain


@full
def test_epitran_reads_and_refuses_plainly():
    pytest.importorskip("epitran", reason="the epitran extra is not installed")
    (found,) = engine("epitran", Settings("x", code="xho-Latn"))(["molo, 7"])
    assert [said.labels for said in found] == [("m", "ɔ", "l", "ɔ"), (), ()]
    assert found[-1].unread == "7"
    with pytest.raises(SpeechError, match="Epitran has no language 'xho-Latin'; did you mean"):
        engine("epitran", Settings("x", code="xho-Latin"))


def test_thaiphon_cuts_words_and_repeats():
    pytest.importorskip("thaiphon", reason="the thaiphon extra is not installed")
    pytest.importorskip("pythainlp", reason="the thaiphon extra is not installed")
    (found,) = engine("thaiphon", Settings("x"))(["ผมอายุ ปี มากๆ OK, ฿"])
    assert [(word.text, "".join(word.labels), word.unread) for word in found] == [
        ("ผม", "pʰom", ""), ("อายุ", "a:ju", ""), ("ปี", "pi:", ""),
        ("มาก", "ma:k̚", ""), ("ๆ", "ma:k̚", ""), ("OK", "", "OK"), (",", "", ""), ("฿", "", "฿"),
    ]  # fmt: skip


def test_thaiphon_leaves_out_a_word_whose_marks_have_no_letter():
    pytest.importorskip("thaiphon", reason="the thaiphon extra is not installed")
    pytest.importorskip("pythainlp", reason="the thaiphon extra is not installed")
    (found,) = engine("thaiphon", Settings("x"))(["อยู่ใตัอำนาจ"])  # a real misprint
    assert [said.text for said in found if said.unread]
    assert any(said.labels for said in found), "the words around it are read"


def test_vowel_marks_are_guessed_for_words_that_have_none(monkeypatch):
    def mark(text):
        return "".join(c + "\u064e" * ("\u0621" <= c <= "\u064a") for c in text)

    monkeypatch.setattr(tashkeel, "_marker", lambda: mark)
    text = "كتب، ذَهب (hello) " + "نعم " * 600
    pairs = tashkeel.respell(text)
    assert "".join(written for written, _ in pairs) == text
    read = "".join(spelled for _, spelled in pairs)
    assert read.startswith("كَتَب، ذَهب (hello) نَعَمَ"), "a word that has marks keeps them"
    words = [SpokenWord("كَتَب", ("k",)), SpokenWord(",", ()), SpokenWord("ذَهب (hello) نَعَمَ", ("h",))]
    first, _, second = as_written(words, pairs)
    assert (first.text, first.respelled) == ("كتب", "كَتَب")
    assert (second.text, second.respelled) == ("ذَهب (hello) نعم", "ذَهب (hello) نَعَمَ")
    pairs = tashkeel.respell("جدًا هنّ؟")
    assert pairs[1] == ("دً", "دَ"), "the marks of everyday spelling leave a word to be guessed"
    assert pairs[-2] == ("نّ", "ن"), "a short vowel is silent before a pause"
    monkeypatch.setattr(tashkeel, "_marker", lambda: lambda text: text[1:])
    assert tashkeel.respell("كتب") == [("كتب", "كتب")], "letters that a model changes are not taken"
    monkeypatch.setattr(tashkeel, "_marker", lambda: None)
    assert tashkeel.respell("كتب") == [("كتب", "كتب")], "without the extra"


def test_a_voice_of_sentences_reads_guessed_vowels_under_the_words_of_the_user():
    pytest.importorskip("dengjen_tashkeel_py", reason="the tashkeel extra is not installed")
    pytest.importorskip("espeakng_loader", reason="speaks")
    settings = Settings("x", voice="ar", respell="tashkeel")
    (found,) = engine("espeak", settings)(["ذهب الولد إلى المدرسة."])
    assert [word.text for word in found] == ["ذهب", "الولد", "إلى", "المدرسة"]
    assert "".join(found[0].labels) == "ðahaba"
    assert tashkeel.respell("\ud800 ذهب") == [("\ud800 ذهب", "\ud800 ذهب")]


def test_points_are_guessed_for_words_that_have_none():
    text = "הילד קרא ספר, שָׁלוֹם בית-דין ב-Cocoa " + "ילד " * 300
    pairs = niqqud.respell(text)
    assert "".join(written for written, _ in pairs) == text
    said = {written: plain(read) for written, read in pairs}
    assert (said["הילד"], said["ספר"]) == (plain("הַיֶּלֶד"), "סֵפֶר")
    assert said["שָׁלוֹם"] == plain("שָׁלוֹם"), "a word that has points keeps them"
    assert said["בית-דין"] == plain("בֵּית-דִּין")
    assert [one for one, _ in pairs if one in ("ב", "-", "Cocoa")] == ["ב", "-", "Cocoa"]
    assert niqqud.respell("") == [("", "")]
    assert dict(niqqud.respell("\ud800 ילד"))["ילד"] == "יֶלֶד"


def test_words_of_another_script_beside_respelled_ones_are_said_by_the_other_voice():
    pytest.importorskip("espeakng_loader", reason="speaks")
    points = (Rule("ב", ("b",)), Rule("ְ", ("e",)))
    settings = Settings(
        "x", rules=points, labels=["k", "əʊ", "ə"], respell="niqqud", foreign_voice="en-gb",
        foreign=(Rule("ː", ()),),
    )  # fmt: skip
    (found,) = engine("rules", settings)(["ב-Cocoa"])
    assert [word.text for word in found if word.labels] == ["ב", "Cocoa"]
    assert "".join(found[-1].labels).startswith("kəʊ")
