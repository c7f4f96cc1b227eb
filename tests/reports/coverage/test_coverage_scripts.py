"""Words in another script than their language: named, and counted if the voice reads them."""

from types import SimpleNamespace

import pytest
from coverage_packs import WRITTEN, heard, lines, report, write
from lanes import full

from lipsync_lang.packs.library import Library
from lipsync_lang.reports.coverage import coverage, scripts
from lipsync_lang.text.lines import read_lines


@pytest.mark.parametrize(
    ("character", "found"),
    [
        ("a", "LATIN"), ("Ａ", "LATIN"), ("я", "CYRILLIC"), ("字", "CJK"), ("ｱ", "KATAKANA"),
        ("ー", ""), ("№", ""), ("1", ""), ("\u0301", ""), ("’", ""), ("\ud800", ""),
    ],
)  # fmt: skip
def test_letters_have_scripts_and_nothing_else_has(character, found):
    assert scripts.script(character) == found


@full
def test_every_language_with_tests_is_known_to_be_written_in_something(root):
    packs = sorted((root / "languages").glob("*.yaml"))
    written_in = {}
    for path in packs:
        if "kind: language\n" in path.read_text("utf-8"):
            pack = Library(()).language(path.stem).model
            written_in[path.stem] = scripts.scripts_of(pack)
            assert bool(written_in[path.stem]) == bool(pack.tests)
    assert len(written_in) > 20
    assert written_in["japanese"] > {"CJK", "HIRAGANA"}


def test_words_in_another_script_are_named_and_what_is_spelled_is_not_counted(packs):
    write(packs / "languages/toy.yaml", WRITTEN)
    told = report("ta да-да mi", "ta МИ mi", "tи, и ﬁ!", "ta")
    found = [(one.what, one.count, one.place, one.counted) for one in told.other_scripts]
    assert found == [
        ("и", 2, "a.txt:3", False),
        ("МИ", 1, "a.txt:2", False),
        ("да-да", 1, "a.txt:1", True),
    ]
    assert {one.script for one in told.other_scripts} == {"CYRILLIC"}
    assert heard(report("ta да mi")) == heard(report("ta ta mi"))
    assert heard(report("ta ми mi")) == {"_-d": 1, "d-aa": 1, "bmp-ih": 1, "ih-_": 1}
    assert report("ta МИ mi").words == 2


def test_a_language_that_does_not_say_how_it_is_written_has_no_other_scripts(packs):
    write(packs / "languages/toy.yaml", WRITTEN.split("tests:", maxsplit=1)[0])
    told = report("ta ми")
    assert told.other_scripts == ()
    assert "aa-bmp" in heard(told)


def test_a_word_that_a_language_or_a_character_says_its_way_counts(packs):
    write(packs / "languages/toy.yaml", WRITTEN + "words: {ми: [s, ih]}\n")
    told = report("ta МИ", "ta им")
    assert [one.what for one in told.other_scripts] == ["им"]
    assert {"aa-s", "s-ih"} < heard(told).keys()
    write(
        packs / "characters/ann.yaml",
        "kind: character\nformat: 1\nname: ann\nposeset: facefx\n"
        "pronunciations: {toy: {им: [s, aa]}}\n",
    )
    (own,) = coverage(lines("ta им"), "toy", "ann").reports
    assert own.other_scripts == ()
    assert {"aa-s", "s-aa"} < heard(own).keys()


@pytest.mark.usefixtures("packs")
def test_many_words_in_other_scripts_are_judged_as_few_are(packs, monkeypatch):
    write(packs / "languages/toy.yaml", WRITTEN)
    texts = ["ta да mi", "ми ta", "mi им", "ta да"]
    whole = coverage(lines(*texts), "toy", "facefx")
    monkeypatch.setattr("lipsync_lang.reports.coverage.corpus.BATCH_LINES", 1)
    monkeypatch.setattr("lipsync_lang.reports.coverage.scripts.MAX_JUDGED_PHRASES", 0)
    assert coverage(lines(*texts), "toy", "facefx") == whole


def test_a_word_in_capitals_is_judged_as_if_it_were_in_small_letters():
    class Shouted:
        def has_entry(self, _):
            return False

        def transcribe(self, texts):
            spelled = (text.isupper() or len(text) == 1 for text in texts)
            for text, letters in zip(texts, spelled, strict=True):
                yield SimpleNamespace(phonemes=[*text.lower()] if letters else [text])

    others = scripts.OtherScripts(Shouted(), {"LATIN"})
    assert others.spelled([SimpleNamespace(text="ta ДА", place="here")]) == [[]]
    assert [(one.what, one.counted) for one in others.tallies()] == [("ДА", True)]


@full
def test_a_voice_reads_words_of_other_languages_and_spells_what_it_has_no_voice_for():
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    texts = ("Он сказал thunder rises и ушёл.", "Он сказал 会議 и ушёл.", "Он ушёл.", "I love you")
    told = coverage(lines(*texts), "russian", "facefx").reports[0]
    counted = {one.what: one.counted for one in told.other_scripts}
    latin = dict.fromkeys(("thunder", "rises", "I", "love", "you"), True)
    assert counted == {**latin, "会議": False}
    assert "th-ah" in heard(told), "of thunder"
    spelled = coverage(lines("Он сказал 会議 и ушёл."), "russian", "facefx").reports[0]
    assert (spelled.words, "sh-ay" in heard(spelled)) == (4, False), "not 'Chinese letter'"


@full
def test_real_lines_in_another_script_are_not_taken_for_speech(data):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    path = data / "text/the_question_lines.tsv"
    told = coverage(read_lines(path, column="japanese"), "russian", "facefx").reports[0]
    read = [one.what for one in told.other_scripts if one.counted]
    assert read == ["Interactive"]
    assert {one.example for one in told.bigrams} == {"Interactive"}
    assert sum(one.count for one in told.other_scripts) > 500
