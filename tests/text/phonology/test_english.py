"""English compared with the paper's Table 1, which is repeated here, and with CMUdict."""

import re
from itertools import chain

import pytest
from places import ROOT
from shipped import LIBRARY
from spellings import spelling_conflicts

from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.text.phonology.labels import Notation, recognise

FOLDER = ROOT / "languages"

TABLE_1 = """
ae ah cat
ah ah cut
ax ah ago
aa aa father
ao ao dog
ey eh ate
eh eh pet
er er fur
ih ih fill
iy ih feel
w w with
uw w too
uh w book
ow ow go
aw aw foul
oy oy toy
ay ay bite
h h help
r r red
l l lid
s s sit
z s zap
sh sh she
ch sh chin
jh sh joy
zh sh pleasure
y sh yard
th th thin
dh th then
f f fork
v f vat
d d dig
t d talk
n d no
ng d sing
k kg cut
g kg gut
p bmp put
b bmp big
m bmp mat
"""
ROWS = [tuple(line.split()) for line in TABLE_1.split("\n") if line]
CLASSES = {"vowel", "glide", "liquid", "nasal", "stop", "fricative", "affricate", "silence"}


def load(name):
    return read_yaml(FOLDER / f"{name}.yaml").data


COMMON = load("common")
RESTS = (*COMMON["silence_labels"], *COMMON["noise_labels"])
ENGLISH = load("english")
for name, table in ENGLISH["notations"].items():
    usual = COMMON["usual"].get(name, {})
    table.update({label: usual[label] for label, entry in table.items() if entry is None})


def sequence(entry):
    return [entry] if isinstance(entry, str) else entry["to"] if isinstance(entry, dict) else entry


def notation(table):
    return Notation(
        {
            label: tuple((common, 1 / len(sequence(entry))) for common in sequence(entry))
            for label, entry in table.items()
        },
        silences=RESTS,
        silence=((COMMON["silence"], 1.0),),
    )


NOTATIONS = {name: notation(table) for name, table in ENGLISH["notations"].items()}


SEEN = {"ae": "ah", "ng": "d"}
"""Shades that Table 1 groups by sound, and `like` by appearance."""

MOUTHS = {name: shade["like"] for name, shade in COMMON["shades"].items()} | SEEN


def mouths(phonemes):
    """Phonemes of Table 1, without shades."""
    return [MOUTHS.get(phoneme, phoneme) for phoneme in phonemes]


def common(name, labels):
    found = [NOTATIONS[name].find(label) for label in labels]
    assert None not in found, labels
    return mouths(phoneme for phoneme, _ in chain(*found))


def test_the_table_has_forty_phonemes_and_twenty_one_mouths():
    assert len({phoneme for phoneme, _, _ in ROWS}) == len(ROWS) == 40
    assert {mouth for _, mouth, _ in ROWS} == set(COMMON["base"])
    assert len(COMMON["base"]) == 21


def test_every_base_phoneme_is_declared_in_full():
    phonemes = COMMON["phonemes"]
    assert set(COMMON["base"]) | {COMMON["silence"], "yu"} == set(phonemes)
    for name, phoneme in phonemes.items():
        assert phoneme["title"], name
        assert phoneme["class"] in CLASSES
        assert phoneme.get("like", "w") in COMMON["base"]
    for name in COMMON["base"]:
        assert phonemes[name]["ipa"], name
        assert [phonemes[name]["example"], name] in [[word, mouth] for _, mouth, word in ROWS]


def test_no_sound_is_meant_by_two_common_phonemes():
    sounds = list(chain.from_iterable(p["ipa"] for p in COMMON["phonemes"].values()))
    assert len(sounds) == len(set(sounds))


OTHERWISE = {
    "a": "the vowel of cat, as British voices write it",
    "o": "the vowel of go, as an aligner writes it in India and Nigeria",
}
"""IPA letters with another meaning in English transcriptions than in the common phonemes."""


def test_common_sounds_and_english_agree():
    other = set()
    for name in COMMON["base"]:
        for sound in COMMON["phonemes"][name]["ipa"]:
            if sound != "ʂ" and common("ipa", [sound]) != [name]:  # which English does not have
                other.add(sound)
    assert other == set(OTHERWISE)


def test_the_shades_of_english_are_those_that_common_sounds_mean():
    said = {sound for sequence_ in map(sequence, ENGLISH["notations"]["ipa"].values())
            for sound in sequence_} & {*COMMON["shades"]}  # fmt: skip
    assert said == {"ae", "ax", "axr", "iy", "uh", "oa", "ey", "n", "ng", "ch", "xi", "y"}
    for name in said - {"xi"}:
        first = COMMON["shades"][name]["ipa"][0]
        assert [phoneme for phoneme, _ in NOTATIONS["ipa"].find(first)] == [name]


MARKS = {"sapi": ["-", "!", "&", ",", ".", "?", "1", "2"], "sapi-ids": [*"12345689"]}
"""Labels of boundaries and stress, which have no sound, by notation."""

SILENT_NUMBER = "7"


@pytest.mark.parametrize("name", ["arpabet", "sapi"])
@pytest.mark.parametrize(("phoneme", "mouth", "word"), ROWS)
def test_table_1_is_the_papers(name, phoneme, mouth, word):
    assert common(name, [phoneme]) == [mouth]
    if name == "arpabet":
        label = "HH" if phoneme == "h" else phoneme.upper()
        assert ENGLISH["examples"][label] == word


def test_sapi_is_table_1_and_marks_without_a_sound():
    sapi = {p: to for p, to in ENGLISH["notations"]["sapi"].items() if p not in MARKS["sapi"]}
    assert dict(zip(sapi, mouths(sapi.values()), strict=True)) == {p: m for p, m, _ in ROWS}
    for name, marks in MARKS.items():
        assert [ENGLISH["notations"][name][mark] for mark in marks] == [()] * len(marks)


def test_the_numbers_of_sapi_are_its_phonemes_in_order():
    names, numbers = ENGLISH["notations"]["sapi"], ENGLISH["notations"]["sapi-ids"]
    spoken = sorted(name for name in names if name not in MARKS["sapi"])
    assert {str(at): names[name] for at, name in enumerate(spoken, 10)} == {
        at: to for at, to in numbers.items() if at not in {*MARKS["sapi-ids"], SILENT_NUMBER}
    }
    assert common("sapi-ids", [SILENT_NUMBER]) == ["_"]


@pytest.mark.parametrize("name", NOTATIONS)
def test_every_label_is_text_and_maps_to_phonemes_there_are(name):
    for label, entry in ENGLISH["notations"][name].items():
        assert isinstance(label, str), label
        if label in MARKS.get(name, ()) or (name, label) == ("sapi-ids", SILENT_NUMBER):
            continue
        assert sequence(entry), label
        assert set(sequence(entry)) <= {*COMMON["base"], *COMMON["shades"]}, label
    assert spelling_conflicts(NOTATIONS[name].table) == []


@pytest.mark.parametrize("name", NOTATIONS)
def test_every_mouth_is_reached(name):
    reached = chain.from_iterable(map(sequence, ENGLISH["notations"][name].values()))
    silent = {"_"} if name == "sapi-ids" else set()
    assert set(mouths(reached)) == {*COMMON["base"], *silent}


IPA = "æ ʌ ə ɑː ɔː eɪ ɛ ɝ ɪ iː w uː ʊ oʊ aʊ ɔɪ aɪ h ɹ l s z ʃ tʃ dʒ ʒ j θ ð f v d t n ŋ k ɡ p b m"
SAMPA = "{ V @ A: Q eI e 3: I i: w u: U @U aU OI aI h r l s z S tS dZ Z j T D f v d t n N k g p b m"


@pytest.mark.parametrize(("name", "labels"), [("ipa", IPA), ("sampa", SAMPA)])
def test_table_1_in_the_other_notations(name, labels):
    assert common(name, labels.split()) == [mouth for _, mouth, _ in ROWS]


LABELS = {
    "arpabet": ["HH" if phoneme == "h" else phoneme.upper() for phoneme, _, _ in ROWS],
    "sapi": [phoneme for phoneme, _, _ in ROWS],
    "ipa": IPA.split(),
    "sampa": SAMPA.split(),
}
"""The forty phonemes of Table 1, as each notation writes them."""


@pytest.mark.parametrize("name", LABELS)
def test_the_papers_english_has_all_forty_phonemes_as_table_1(name):
    table = LIBRARY.language("paper-english").model.notations[name]
    assert [table[label].to for label in LABELS[name]] == [(mouth,) for _, mouth, _ in ROWS]


def test_the_papers_english_has_no_shades():
    tables = LIBRARY.language("paper-english").model.notations.values()
    said = {name for table in tables for sounds in table.values() for name in sounds.to}
    assert said <= {*COMMON["base"], COMMON["silence"]}


def test_default_english_departs_from_table_1_in_two_parents_for_a_reason():
    parents = {name: shade["like"] for name, shade in COMMON["shades"].items()}
    table = ENGLISH["notations"]["sapi"]
    departs = {one: m for one, m, _ in ROWS if parents.get(table[one], table[one]) != m}
    assert departs == SEEN
    for phoneme in departs:
        assert ENGLISH["reasons"][phoneme.upper()].startswith("Table 1 has it with")


def test_every_silence_is_text_and_found_by_every_notation():
    assert len(RESTS) == len(set(RESTS))
    for label in RESTS:
        assert isinstance(label, str)
        assert label == label.lower()
        for name, table in NOTATIONS.items():
            assert common(name, [label, label.upper()]) == ["_", "_"], (table, label)


def test_examples_and_reasons_are_of_labels_there_are():
    arpabet = ENGLISH["notations"]["arpabet"]
    assert set(ENGLISH["examples"]) <= set(arpabet)
    assert set(ENGLISH["reasons"]) <= {*arpabet, *ENGLISH["notations"]["ipa"]}


@pytest.mark.parametrize("case", ENGLISH["tests"], ids=lambda case: case["text"])
def test_what_texts_must_become_follows_from_their_source(case):
    dictionary, _, labels = case["source"].partition(": ")
    assert dictionary == "CMUdict"
    found = [NOTATIONS["arpabet"].find(label) for label in labels.split()]
    assert [phoneme for phoneme, _ in chain(*found)] == list(case["phonemes"])


def test_the_texts_reach_all_forty_phonemes():
    # CMUdict writes the first vowel of "ago" AH0
    sources = [case["source"].partition(": ")[2].replace("AH0", "AX0") for case in ENGLISH["tests"]]
    heard = {re.sub(r"\d", "", label) for source in sources for label in source.split()}
    assert {("HH" if p == "h" else p.upper()) for p, _, _ in ROWS} <= heard


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        ("HH AH0 L OW1 sil", "arpabet"),
        ("hh ah l ow", "arpabet"),
        ("D @ b { r @ l", "sampa"),
        ("ð ə b ˈæ ɹ əl", "ipa"),
        ("h aj m ɐ ɲ iː", "ipa"),
    ],
)
def test_the_notation_is_recognised(labels, expected):
    assert recognise(labels.split(), NOTATIONS) == expected


# What the engine's American voice writes over some 800 sentences, stress marks left out
ENGINE = (
    "t n s ə ð d l k ɹ z ɪ p w f m b ɛ æ eɪ aɪ v iː h ɐ oʊ ʌ ɚ ɡ uː ɑː ŋ ʃ ɜː tʃ i ɔː ɔːɹ ɑːɹ aʊ θ "
    "dʒ j ɔ ᵻ ɾ ʊ əl ɛɹ ɔɪ ɪɹ aɪɚ ʊɹ ʔ n̩ iə ʒ aɪə x ʲ"
)
# The phone set of MFA's English dictionaries: US, UK, India and Nigeria
MFA = (
    "a aj aw aː b bʲ c cʰ cʷ d dʒ dʲ d̪ e ej eː f fʲ h i iː j k kp kʰ kʷ l m mʲ m̩ n n̩ o ow oː p pʰ "
    "pʲ pʷ s t tʃ tʰ tʲ tʷ t̪ u uː v vʲ w z æ ç ð ŋ ɐ ɑ ɑː ɒ ɒː ɔ ɔj ɖ ə əw ɚ ɛ ɛː ɜ ɜː ɝ ɟ ɟʷ "
    "ɡ ɡʷ ɪ ɫ ɫ̩ ɱ ɲ ɹ ɾ ɾʲ ɾ̃ ʃ ʈ ʈʲ ʈʷ ʉ ʉː ʊ ʋ ʎ ʒ ʔ θ"
)


@pytest.mark.parametrize("labels", [ENGINE, MFA], ids=["engine", "mfa"])
def test_every_symbol_of_a_known_source_is_mapped(labels):
    assert common("ipa", labels.split())
