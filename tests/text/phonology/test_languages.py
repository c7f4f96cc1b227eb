"""Every language pack: its tests pass, its inventory is complete, and each phoneme has a test."""

import csv
import gzip
import re
from functools import cache
from unicodedata import normalize

import pytest
from lanes import skip_if_its_reader_was_removed, swept
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.sound.speech.speaking.speaker import transcribe
from lipsync_lang.text.phonology.labels import Notation, normalise

every_pack = pytest.mark.parametrize("pack", LANGUAGES, indirect=True)

NEEDS = {"espeak": ["espeakng_loader"], "pypinyin": ["pypinyin", "opencc"], "epitran": ["epitran"],
         "thaiphon": ["thaiphon", "pythainlp"],
         "kana": ["pyopenjtalk"]}  # fmt: skip
"""Packages that an engine or a respeller needs."""

SILENCE = LIBRARY.common().model.silence
SHADES = LIBRARY.common().model.shades


@pytest.fixture
def pack(request):
    """A language pack by name."""
    return LIBRARY.language(request.param).model


def table(pack, name):
    """The table of one notation, as a performer uses it."""
    return Notation({label: s.to for label, s in pack.notations[name].items()})


def becomes(labels, notation):
    """Return the common phonemes of labels; unknown labels stay as they are."""
    found = [(label, notation.find(label)) for label in labels]
    return [p for label, value in found for p in ((f"?{label}",) if value is None else value)]


@every_pack
def test_every_test_says_who_says_so(pack):
    assert pack.tests, f"{pack.name} has no tests"
    assert not [test.text for test in pack.tests if not test.source]


@every_pack
def test_what_the_sources_hear_becomes_what_the_tests_say(pack):
    """Only the maps are tested, without an engine."""
    wrong = {
        test.text: (" ".join(said), " ".join(test.phonemes))
        for test in pack.tests
        if test.ipa
        and not test.accepts(said := becomes(test.ipa.split(), table(pack, "ipa")), SHADES)
    }
    assert not wrong, "(mapped, stated)"


@pytest.mark.parametrize("pack", swept(LANGUAGES, quick=LANGUAGES[::9]), indirect=True)
def test_text_becomes_what_the_tests_say(pack):
    """The text goes through the pack's own engine."""
    if pack.g2p is None:
        pytest.skip(f"{pack.name} does not read text")
    skip_if_its_reader_was_removed(pack.g2p)
    needs = [*NEEDS.get(pack.g2p.engine, []), *NEEDS.get(pack.g2p.respell, [])]
    for module in needs:
        pytest.importorskip(module, reason="its engine is not installed")
    texts = [test.text for test in pack.tests]
    wrong = {
        test.text: (" ".join(said), " ".join(test.read or test.phonemes), " ".join(heard.labels))
        for test, heard in zip(pack.tests, transcribe(texts, pack.name), strict=True)
        if not test.accepts(said := [p for p in heard.phonemes if p != SILENCE], SHADES, read=True)
        or heard.unmapped
    }
    assert not wrong, "(read, stated, labels)"


@every_pack
def test_every_phoneme_of_the_inventory_is_mapped_or_absent_for_a_reason(pack):
    if pack.inventory is None:
        pytest.skip(f"{pack.name} names no inventory")
    notation = table(pack, "ipa")
    lost = [s for s in pack.inventory.segments if notation.find(s) is None]
    assert set(lost) == set(pack.inventory.absent), "neither mapped nor absent, or both"


@every_pack
def test_every_mapped_phoneme_is_reached_by_a_test(pack):
    if pack.inventory is None:
        pytest.skip(f"{pack.name} names no inventory")
    heard = {normalise(segment) for test in pack.tests for segment in test.ipa.split()}
    silent = [
        segment
        for segment in pack.inventory.segments
        if segment not in pack.inventory.absent
        and normalise(pack.inventory.spelled.get(segment, segment)) not in heard
    ]
    assert not silent


@cache
def phoible(folder):
    """Return the segments of every inventory of PHOIBLE, by number."""
    found = {}
    with gzip.open(folder / "phonology" / "phoible_inventories.tsv.gz", "rt", "utf-8") as lines:
        for row in csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE):
            found.setdefault(row["inventory_id"], set()).add(row["phoneme_raw"])
    return found


@every_pack
def test_the_inventory_is_the_one_it_names(pack, data):
    named = re.match(r"PHOIBLE (\d+)", pack.inventory.source) if pack.inventory else None
    if named is None:
        pytest.skip(f"{pack.name} names no PHOIBLE inventory")
    stated = {normalize("NFC", segment) for segment in pack.inventory.segments}
    assert stated == {normalize("NFC", segment) for segment in phoible(data)[named[1]]}


@every_pack
def test_what_a_language_adds_it_also_uses(pack):
    used = {p for labels in pack.notations.values() for s in labels.values() for p in s.to}
    assert set(pack.adds) <= used
