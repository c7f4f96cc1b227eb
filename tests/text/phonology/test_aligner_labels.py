"""Labels of aligners are known in every language, and invisible marks are ignored."""

import csv
from functools import cache
from pathlib import Path

import pytest
from lanes import full, swept
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.packs.automatic import automatic
from lipsync_lang.packs.finding import IPA
from lipsync_lang.resolver.language_tables import tables_of
from lipsync_lang.resolver.nearest_phonemes import among, spelling
from lipsync_lang.text.phonology.ipa import Features, key
from lipsync_lang.text.phonology.labels import Notation, bare, ready

SPELLING = spelling(LIBRARY)
UNSEEN = SPELLING["unseen"]
SILENT = (("_", 1.0),)

PHONES = [
    row.split("\t")
    for row in (Path(__file__).parent / "aligner_labels.tsv").read_text("utf-8").splitlines()
    if not row.startswith("#")
]
assert len(PHONES) > 40


def notation(name):
    """IPA notation of a language, from a performer."""
    silences = LIBRARY.common().model.rests
    return ready(tables_of(LIBRARY.language(name).model), silences, SILENT, IPA, SPELLING)[IPA]


@pytest.mark.parametrize(("name", "source", "phones"), PHONES, ids=lambda text: text[:12])
def test_every_phone_of_an_aligner_is_known(name, source, phones):
    known = notation(name)
    assert [phone for phone in phones.split() if known.find(phone) is None] == [], source
    assert all(known.find(silent) == SILENT for silent in ("", "sil", "spn", "<eps>"))


CODES = {"portuguese-br": "por", "portuguese-pt": "por"}
"""Epitran codes of languages whose pack does not state one."""


@cache
def segmenter():
    """Epitran's table of features, which takes seconds to load."""
    return pytest.importorskip("panphon").FeatureTable().ipa_segs


@full
@pytest.mark.parametrize("name", LANGUAGES)
def test_every_segment_that_epitran_writes_is_known(name):
    epitran = pytest.importorskip("epitran")
    segments = segmenter()
    codes = {CODES.get(name, ""), *LIBRARY.language(name).model.aliases} - {""}
    folder = Path(epitran.__file__).parent / "data/map"
    maps = [path for code in sorted(codes) for path in folder.glob(f"{code}-*.csv")]
    if not maps:
        pytest.skip(f"Epitran reads no {name}")
    written = set()
    for path in maps:
        rows = csv.reader(path.read_text(encoding="utf-8").splitlines()[1:])
        written |= {segment for row in rows if len(row) > 1 for segment in segments(row[1])}
    known = notation(name)
    unknown = {segment for segment in written if known.find(segment) is None}
    assert not {segment for segment in unknown if bare(key(segment), UNSEEN)[0]}, "tones aside"


# What is dropped, and what is not

FEATURES = Features(LIBRARY.ipa().model.model_dump(mode="json", by_alias=True))
NEAR = among(LIBRARY, automatic("ipa:x", LIBRARY.common))


SHADES = {"\u031d", "˔", "\u031e", "˕", "\u031f", "˖", "\u0320", "˗"}
"""Marks of a slightly closer, opener, fronted or backed vowel."""


@pytest.mark.parametrize("mark", swept(UNSEEN, quick=[*UNSEEN][::24]))
def test_a_mark_that_is_dropped_changes_nothing_that_is_seen(mark):
    changed = []
    for letter in LIBRARY.ipa().model.letters:
        label = key(letter + mark)
        if bare(label, UNSEEN)[0] != key(letter):
            continue
        marked, plain = (FEATURES.read(text, own=(letter,)).sounds[0] for text in (label, letter))
        pairs = [(a, b) for a, b in zip(marked.features, plain.features, strict=True) if a != b]
        assert all(abs(a - b) < FEATURES.told_from for a, b in pairs), letter
        if coarse(label) != coarse(letter):
            changed.append(letter)
    assert bool(changed) == (mark in SHADES), changed


def coarse(label):
    """The common phonemes nearest to a label, without shades."""
    finer = LIBRARY.common().model.shades
    return [finer[p].like if p in finer else p for p, _ in NEAR.value(label)]


@pytest.mark.parametrize("label", ["š", "ž", "č", "ŝ", "ẑ", "s\u030c"])
def test_a_letter_that_is_written_with_a_mark_is_no_letter_without_it(label):
    table = dict.fromkeys("szc", SILENT)
    assert Notation(table, unseen=UNSEEN).find(label) is None


TABLE = {
    label: ((common, 1.0),)
    for label, common in {"t": "d", "tʲ": "sh", "p": "bmp", "k": "kg", "a": "aa", "ã": "ah"}.items()
}


@pytest.mark.parametrize(
    ("label", "common"),
    [
        ("t̪", "d"), ("t̪ʰ", "d"), ("ˈtː", "d"), ("tʼ", "d"), ("ⁿt", "d"), ("ʰtː", "d"),
        ("t̪ʲ", "sh"), ("tʲʰː", "sh"), ("k͈", "kg"), ("a˥˩", "aa"), ("a̰˨˩ˀ", "aa"),
        ("ã̰", "ah"), ("t̠", "d"), ("p̚", "bmp"),
    ],
)  # fmt: skip
def test_of_labels_that_look_the_same_the_one_with_most_marks_in_common_is_meant(label, common):
    assert Notation(TABLE, unseen=UNSEEN).find(label) == ((common, 1.0),)


@pytest.mark.parametrize(
    "label", ["kʷ", "tʷʰ", "p̪", "t̼", "a̹", "ä", "aᵘ", "a˞", "x", "x̪", "ʰ", "˥˩", "̪", "tʃ", "ta"]
)
def test_what_is_seen_is_never_dropped(label):
    assert Notation(TABLE, unseen=UNSEEN).find(label) is None


@pytest.mark.parametrize("label", ["t̪", "tʰ", "a6~"])
def test_a_notation_that_is_not_told_of_marks_drops_none(label):
    assert Notation(TABLE).find(label) is None


def test_what_is_likely_is_not_what_is_stated():
    assert Notation(TABLE, unseen=UNSEEN).stated("t̪") is None


def test_features_decide_where_a_language_asks_for_them():
    known = Notation({"t": (("kg", 1.0),)}, nearest=NEAR.value, unseen=UNSEEN)
    assert known.find("t") == (("kg", 1.0),)
    assert known.find("t̪") == (("d", 1.0),)
