"""Spellings of a sound: every spelling finds the same entry, and only that entry."""

from unicodedata import normalize

import pytest
from hypothesis import given
from hypothesis import strategies as st
from spellings import spelling_conflicts

from lipsync_lang.base.errors import PackError
from lipsync_lang.text.phonology.labels import Notation, normalise, recognise

ARPABET = {"AE": "ah", "AH": "ah", "IY": "ih", "T": "d", "TH": "th", "AX-H": "ah", "S": "s"}
SAMPA = {"2:": "yu", "9": "er", "3:": "er", "i:": "ih", "s": "s", "S": "sh", "t": "d", "T": "th"}
IPA = {"t͡ʃ": "sh", "ɡ": "kg", "ç": "h", "iː": "ih", "ɜː": "er", "n̩": "d", "y": "w", "yː": "yu"}
SILENCES = frozenset({"", "_", "sil", "<p:>", "H#"})
SILENT = (("_", 1.0),)


def value(common):
    return ((common, 1.0),)


def notation(table, **rest):
    return Notation({label: value(common) for label, common in table.items()}, **rest)


TABLES = {name: notation(t) for name, t in {"arpabet": ARPABET, "sampa": SAMPA, "ipa": IPA}.items()}
ENTRIES = [(name, label) for name, table in TABLES.items() for label in table.table]


@pytest.mark.parametrize(("name", "label"), ENTRIES)
@pytest.mark.parametrize("form", ["NFC", "NFD"])
@pytest.mark.parametrize("mark", ["", "ˈ", "ˌ", "'", '"', " "])
def test_every_label_is_found_in_every_composition_and_stress(name, label, form, mark):
    assert TABLES[name].find(mark + normalize(form, label)) == TABLES[name].table[label]


@pytest.mark.parametrize("label", ARPABET)
@pytest.mark.parametrize("digit", ["", "0", "1", "2"])
def test_arpabet_is_found_with_stress_digits_and_in_lower_case(label, digit):
    table = TABLES["arpabet"]
    assert table.find(label + digit) == table.table[label]
    assert table.find(label.lower() + digit) == table.table[label]
    assert table.find(label.title() + digit) == table.table[label]


@pytest.mark.parametrize("label", ["tʃ", "t͡ʃ", "t͜ʃ", "ʧ", "t\u200dʃ", "ˈtʃ"])
def test_ties_and_ligatures_are_one_spelling(label):
    assert TABLES["ipa"].find(label) == value("sh")


@pytest.mark.parametrize("label", ["g", "ɡ"])
def test_both_forms_of_g_are_one_letter(label):
    assert TABLES["ipa"].find(label) == value("kg")
    assert notation({"g": "kg"}).find(label) == value("kg")


@pytest.mark.parametrize("label", ["iː", "i:", "i", "iˑ", "iː˥", "iː˥˩", "i1", "i³", "ˈiː2"])
def test_length_and_tone_are_dropped_while_the_label_is_unknown(label):
    table = notation({"iː": "ih", "i": "ih"})
    assert table.find(label) == value("ih")


def test_length_tells_apart_where_the_table_says_so():
    assert TABLES["ipa"].find("yː") == TABLES["ipa"].find("y:") == value("yu")
    assert TABLES["ipa"].find("y") == value("w")


@pytest.mark.parametrize(
    ("label", "expected"), [("2:", "yu"), ("9", "er"), ("3:", "er"), ("S", "sh"), ("s", "s")]
)
def test_in_sampa_digits_and_case_are_phonemes(label, expected):
    assert TABLES["sampa"].find(label) == value(expected)


@pytest.mark.parametrize("label", ["2", "3", "I:", "tS", "x", "0"])
def test_what_the_table_lacks_is_not_guessed(label):
    assert TABLES["sampa"].find(label) is None


def test_a_compound_is_not_guessed():
    assert TABLES["arpabet"].find("TS") is None


@pytest.mark.parametrize("label", ["", " ", "_", "sil", "SIL", "Sil", "<p:>", "h#", "H#"])
def test_silence_is_found_in_any_case(label):
    table = notation(ARPABET, silences=SILENCES, silence=SILENT)
    assert table.find(label) == SILENT
    assert table.is_silence(label)


@pytest.mark.parametrize("label", ["sp", "SP"])
def test_a_label_of_the_table_comes_before_silence(label):
    table = notation({"sp": "s"}, silences={"sp"}, silence=SILENT)
    assert table.find(label) == value("s")


def test_a_suggestion_names_the_nearest_label():
    assert TABLES["arpabet"].suggest("AXH") == "did you mean 'AX-H'?"


def test_of_spellings_of_one_label_that_differ_in_value_the_first_wins_but_for_the_exact_one():
    table = notation({"g": "kg", "iː": "ih", "ɡ": "d", "i:": "ih", "tʃ": "sh", "t͡ʃ": "d"})
    assert spelling_conflicts(table.table) == [("g", "ɡ"), ("tʃ", "t͡ʃ")]
    assert [table.find(label) for label in ("g", "ɡ", "ˈg", "ˈɡ")] == [
        *map(value, ("kg", "d", "kg", "kg"))
    ]
    assert all(not spelling_conflicts(t.table) for t in TABLES.values())


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        (["S", "IY1", "T"], "arpabet"),
        (["s", "iy1", "t"], "arpabet"),
        (["S", "i:", "t"], "sampa"),
        (["t͡ʃ", "ˈiː", "ɡ"], "ipa"),
        (["t"], "arpabet"),  # equals: the first
        (["", "sil", "9"], "sampa"),
        ([], "arpabet"),
    ],
)
def test_the_notation_is_the_one_that_knows_most_labels(labels, expected):
    assert recognise(labels, TABLES) == expected


def test_silence_does_not_speak_for_a_notation():
    quiet = notation({"a": "aa"}, silences=SILENCES, silence=SILENT)
    assert recognise(["", "sil", "_", "T"], {"quiet": quiet, **TABLES}) == "arpabet"


def test_recognising_without_notations_says_so():
    with pytest.raises(PackError, match="no notation"):
        recognise(["a"], {})


@given(st.text(max_size=8))
def test_normalising_twice_is_normalising_once(label):
    assert normalise(normalise(label)) == normalise(label)


@given(st.text(max_size=8))
def test_composition_never_matters(label):
    assert normalise(normalize("NFD", label)) == normalise(normalize("NFC", label))


@given(
    st.dictionaries(st.text(max_size=5), st.sampled_from(["ah", "ih", "bmp"]), max_size=8),
    st.text(max_size=6),
)
def test_tables_of_anything_find_their_own_and_never_fail(table, label):
    found = notation(table, silences=SILENCES, silence=SILENT)
    for own, common in table.items():
        assert found.find(own) == value(common)
    assert found.find(label) is None or found.find(label) in {*map(value, table.values()), SILENT}
    assert found.find(label) == found.find(label)
    found.suggest(label)
