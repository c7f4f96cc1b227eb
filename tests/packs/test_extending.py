"""Fields that a language adds to those of the one it extends, and fields that it replaces."""

import pytest

import lipsync_lang as ll
from lipsync_lang.packs.library import Library
from lipsync_lang.sound.speech.speaking.speaker import Speaker

CHILD = """kind: language
format: 1
name: child
tag: {tag}-x-child
extends: {parent}
"""


@pytest.fixture
def child(folder):
    (folder / "languages").mkdir()

    def made(more, parent="mandarin", tag="cmn"):
        text = CHILD.format(parent=parent, tag=tag) + more
        (folder / "languages" / "child.yaml").write_text(text, "utf-8")
        return Library().language("child").model

    return made


def test_a_child_adds_to_the_engine_of_its_parent(child):
    parent = Library().language("mandarin").model.g2p
    g2p = child("g2p: {engine: pypinyin, readings: [{from: 长, to: zhang3}]}\n").g2p
    assert g2p.readings[0].spelling == "长"
    assert g2p.readings[1:] == parent.readings
    assert (g2p.corrections, g2p.foreign) == (parent.corrections, parent.foreign)
    assert g2p.notation == parent.notation


@pytest.mark.parametrize(
    "g2p", ["{engine: pypinyin, replace: true}", "{engine: rules, rules: [{from: a, to: a}]}"]
)
def test_a_child_with_another_engine_or_by_its_wish_has_its_own_alone(child, g2p):
    made = child(f"g2p: {g2p}\n").g2p
    assert not made.corrections
    assert not made.readings


def test_a_label_of_a_child_replaces_that_of_its_parent_in_any_spelling(child):
    table = child("notations: {ipa: {g: d}}\n", "english", "en").notations["ipa"]
    assert "ɡ" not in table
    assert table["g"].value == (("d", 1.0),)
    assert {*Library().language("english").model.notations["ipa"]} - {*table} == {"ɡ"}


def test_another_voice_keeps_no_corrections_of_the_first(child):
    made = child("g2p: {engine: espeak, voice: en-gb}\n", "english", "en").g2p
    assert (made.voice, made.corrections) == ("en-gb", ())


WORDS = "words: {和: han4, 垃圾: [l, aa, s], 企业: [kg, iy], 電腦: dian4 nao3}\n"


def test_words_of_a_script_without_spaces_are_found_in_a_sentence(child):
    pytest.importorskip("pypinyin", reason="the extra mandarin is not installed")
    child(WORDS)
    speaker = Speaker.of("child")
    (read,) = speaker.transcribe(["我和你说垃圾企业是电脑。"])
    labels = {word.text: word.labels for word in read.words}
    assert labels["和"] == ("h", "an")
    assert labels["电脑"] == ("d", "ian", "n", "ao")
    assert {"垃圾", "企业"} <= set(labels)
    assert "laas" in "".join(read.phonemes)
    assert "kgiy" in "".join(read.phonemes)


def test_a_tone_is_no_number(child):
    pytest.importorskip("pypinyin", reason="the extra mandarin is not installed")
    child("words: {和: han4}\n")
    (read,) = Speaker.of("child").transcribe(["和"])
    assert read.words[0].labels == ("h", "an")
    assert read.words[0].respelled == "han4"


def test_a_reading_needs_a_syllable_for_each_character(child):
    pytest.importorskip("pypinyin", reason="the extra mandarin is not installed")
    child("words: {企业: qi4}\n")
    with pytest.raises(ll.SpeechError, match="1 syllables for 2 characters"):
        list(Speaker.of("child").transcribe(["企业"]))


def test_an_inherited_word_is_dropped(child):
    before = Library().language("english").model.words
    word, reading = next((one, r) for one, r in before.items() if r.phonemes or r.say or r.ipa)
    model = child(f"words: {{{word!r}: null}}\n", "english", "en")
    assert model.words[word] == type(reading)(dropped=True)
    assert len(model.words) == len(before)
    assert reading != model.words[word]


def test_a_dropped_word_is_read_by_the_engine(child, folder):
    pytest.importorskip("espeakng_loader", reason="the extra speech is not installed")
    (folder / "languages" / "mother.yaml").write_text(
        CHILD.format(parent="english", tag="en").replace("child", "mother")
        + "words: {papa: [s, iy], mama: [s, iy]}\n"
    )
    child("words: {papa: null}\n", "mother", "en")
    (plain,) = Speaker.of("english").transcribe(["papa"])
    (read,) = Speaker.of("child").transcribe(["papa"])
    assert read.phonemes == plain.phonemes
    (kept,) = Speaker.of("child").transcribe(["mama"])
    assert kept.phonemes == ("s", "iy")


def test_a_child_keeps_what_is_said_of_its_parents_labels_and_notes(child):
    parent = Library().language("english").model
    model = child("", "english", "en")
    assert model.stress_digits == parent.stress_digits != ()
    assert model.asides == parent.asides != ()
    assert child("stress_digits: []\n", "english", "en").stress_digits == ()
    assert child("", "hebrew", "he").weak == Library().language("hebrew").model.weak
