"""Interjections, stutters, lengthened words, abbreviations and numerals, read as sounds."""

import re

import pytest

from lipsync_lang import SpeechError
from lipsync_lang.text.phonology.g2p import SpokenWord, abbreviation_keys
from lipsync_lang.text.phonology.g2p.abbreviation_keys import Expansions
from lipsync_lang.text.phonology.g2p.number_words import roman
from lipsync_lang.text.phonology.g2p.spoken_forms import OwnWord, SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import read_words, respelled
from lipsync_lang.text.phonology.g2p.utterances import Utterances

FORMS = SpokenForms(
    interjections={
        "mm": OwnWord(("m",), "um"),
        "sh": OwnWord(("S",)),
        "pst": OwnWord(("p", "s", "t")),
        "haha": OwnWord(("h", "a", "h", "a")),
        "argh": OwnWord(("a", "g")),
    },
    abbreviations={"dr.": "doctor", "D.": "don", "St.": "saint", "z. b.": "zum bei",
                   "$#": "{1} dollars", "#/#": "{2} of {1}",
                   "etc.": "and so.", "‰": "per mil", "##:##": "{1} {2}"},
    counted=("chapter",),
    named=("louis",),
    ordinals=("first", "second"),
    doubled=("good",),
    hyphenated=("d-day",),
    vowels="aeiouy",
)  # fmt: skip


def spell(texts):
    """An engine whose labels are letters; it refuses a text with `%`."""
    return [
        SpeechError("no %")
        if "%" in text
        else read_words(text, lambda word: SpokenWord(word, tuple(word.lower())))
        for text in texts
    ]


def reader(forms=FORMS, words=()):
    return Utterances(forms, dict.fromkeys(words), "aeiou".__contains__)


def read(text, **how):
    """Words with their labels, as `word:labels`, a pause as itself."""
    (words,) = reader(**how).read([text], spell)
    return " ".join(f"{w.text}:{''.join(w.labels)}" if w.labels else w.text for w in words)


def test_texts_are_read_by_their_sounds():
    said = {
        "Mmmm, no": "Mmmm:mm , no:no",
        "no mm": "no:no mm:m",
        "Shhhh! hahaha": "Shhhh:SSS ! hahaha:hahaha",
        "ha-ha": "ha-ha:haha",
        "Argh, aaargh. Arghhh": "Argh:ag , aaargh:aag . Arghhh:agg",
        "5 mm": "5:5 mm:mm",  # millimetres
        "The PST zone": "The:the PST:pst zone:zone",  # letters, by the engine
        "B-b-but": "B-:bu b-:bu but:but",
        "St-stop": "St-:sto stop:stop",
        "I-I am": "I-:i I:i am:am",
        "y-you": "y-:yo you:you",
        "b... b… but no": "b:bu ... b:bu … but:but no:no",
        "t-shirt d-day e-mail so-so re-read": "t-shirt:t-shirt d-day:d-day e-mail:e-mail "
        "so-so:so-so re-read:re-read",
        "Nooo way": "Nooo:noo way:way",
        "gooood": "gooood:goood",
        "Heeeello": "Heeeello:heeello",
        "see III WWW": "see:see III:iii WWW:www",
        "z.b. Dr. Who": "z.b.:zumbei Dr.:doctor Who:who",
        "Dr. Mmm": "Dr.:doctor Mmm:mm",  # the full stop is no pause
        "a, etc. No etc. or": "a:a , etc.:andso . No:no etc.:andso or:or",
        "Type D. or D. Who, St. Jo in Main St.": "Type:type D:d . or:or D.:don Who:who , "
        "St.:saint Jo:jo in:in Main:main St:st",
        "$5.50 1/2 3‰ 10:30": "$5.50:5.50dollars 1/2:2of1 3:3 ‰:permil 10:30:1030",
        "Chapter IV, Louis II, Rocky XII I": "Chapter:chapter IV:4 , Louis:louis II:second , "
        "Rocky:rocky XII:12 I:i",
        "Chapter IIX": "Chapter:chapter IIX:iix",
        "漢字《かんじ》": "漢字《かんじ》:カンジ",
    }
    assert {text: read(text) for text in said} == said


def test_words_of_the_pack_are_no_interjections():
    assert read("mm", words=["mm"]) == "mm:mm"


def test_a_voice_reads_spellings_that_are_words():
    (words,) = reader().read(["Mmm, th-that dr. is nooo"], spell)
    assert [word.respelled or word.text for word in words] == [
        "um", ",", "tha", "that", "doctor", "is", "no"
    ]  # fmt: skip


def test_ordinary_texts_are_left_to_the_engine_and_errors_stay_with_their_text():
    assert reader().ordinary("no, 3 good e-mails")
    assert not reader().ordinary("no, mm")
    one, other = reader().read(["mm 5%", "mm"], spell)
    assert isinstance(one, SpeechError)
    assert other == (SpokenWord("mm", ("m",), "um"),)


@pytest.mark.parametrize(("numeral", "value"), [("XIV", 14), ("MMXXIV", 2024), ("IIX", 0), ("", 0)])
def test_roman_numerals(numeral, value):
    assert roman(numeral) == value


def test_expressions_are_compiled_only_where_a_text_begins_like_their_key(monkeypatch):
    made = []
    monkeypatch.setattr(
        abbreviation_keys, "_expression", lambda key: made.append(key) or re.compile("x")
    )
    assert Expansions(FORMS).find("So, dear, he drew a street.") == []
    assert made == []
    assert Expansions(FORMS).find("dr. who") == []
    assert made == ["dr."]


def test_capitals_are_spelled_if_all_have_names():
    names = {"P": "pe", "S": "es", "G": "ge", "R": "er", "T": "te"}
    forms = SpokenForms(letters=names, interjections={"pst": OwnWord((), "pst")})
    read = [one.read for one in Expansions(forms).find("PPS, PST! GRRR, PPPS, NATO; xGPS, GPSTPS")]
    assert read == ["pe pe es"]


def test_capitals_of_syllables_are_words_and_those_with_a_vowel_where_all_is_shouted():
    forms = SpokenForms(letters={"O": "o", "R": "er", "T": "te"}, vowels="o")
    read = [one.read for one in Expansions(forms).find("a TORO OTR. OTTO, TRO! RT! RO и TO, x OOT")]
    assert read == ["o te er", "er te", "er o", "te o"]


def test_a_numeral_that_is_a_word_is_one_where_a_sentence_goes_on():
    words = {"I": ("of", "^said")}
    forms = SpokenForms(named=("henry",), ordinals=("the first",), numeral_words=words)
    text = "Henry I of Blois, Henry I. When I met Henry I offered him a drink, Henry I said."
    assert [one.start for one in Expansions(forms).find(text)] == [6, 24]
    assert [one.start for one in Expansions(forms).find("Henry I said. “Henry I said.”")] == [6, 21]


def test_a_numeral_before_a_word_is_read_as_its_digits():
    keys = {"im #. *": "im {1:nth}n {2}", "#. *": "{1:nth}r {2}"}
    forms = SpokenForms(
        abbreviations=keys, numbers={"nth": ("erste", "zweite")}, numerals_like={"~.": "#."}
    )
    said = {
        "Da, im II. Stock.": "Da, im zweiten Stock.",
        "Der II. Stock": "Der zweiter Stock",
        "Teil II. Das geht": "Teil II. Das geht",
        "Teil II ist da": "Teil II ist da",
        "im XXX. Stock": "im 30n Stock",
    }
    for text, read in said.items():
        assert respelled(text, Expansions(forms).find(text)) == read


def test_keys_are_whole_words():
    found = Expansions(FORMS).find("undr. drab 21/2/3 x:10:30:5")
    assert {one.read for one in found} == {" "}, "only slashes go"
