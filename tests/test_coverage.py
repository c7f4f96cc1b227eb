"""Coverage: needs of lines, bigrams of a character, and the next work."""

import csv
import io
import json
from collections import Counter
from itertools import pairwise
from types import SimpleNamespace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, full

from lipsync_lang import LipsyncError, Schedule
from lipsync_lang.coverage import coverage, plan, scripts
from lipsync_lang.coverage.changes import read_document, since
from lipsync_lang.coverage.document_schema import written
from lipsync_lang.coverage.facts import authored
from lipsync_lang.coverage.forms import FORMS, Asked
from lipsync_lang.coverage.report import Coverage
from lipsync_lang.lines import Line, read_lines
from lipsync_lang.packs.library import Library

LANGUAGE = """\
kind: language
format: 1
name: toy
tag: art-x-toy
title: Toy
adds: [yu]
g2p: {engine: rules, notation: ipa, rules: [{from: q, to: t}]}
notations:
  ipa: {a: aa, i: ih, u: w, y: yu, t: d, m: bmp, s: s}
"""

BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  aa-d: {status: %s, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
  w-d: {status: edited, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
"""


BANK_OF_THREE = """\
kind: bank
format: 1
name: three
poseset: facefx
trigrams:
  d-aa-d: {status: edited, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
  bmp-ih-s: {curves: {}}
"""


@pytest.fixture
def packs(tmp_path, monkeypatch):
    """Folder with a language without a voice, and a bank."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "languages/toy.yaml", LANGUAGE)
    bank(tmp_path, "drafted")
    return tmp_path


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def bank(folder, status):
    return write(folder / "posesets/facefx/banks/common.yaml", BANK % status)


def lines(*texts):
    return [Line(text, f"a.txt:{number}") for number, text in enumerate(texts, 1)]


def report(*texts, **options):
    return coverage(lines(*texts), "toy", "facefx", **options).reports[0]


# Counting


def test_trigrams_count_for_the_bigrams_that_they_play(packs):
    before = report("tata ta", "mi")
    write(packs / "posesets/facefx/banks/three.yaml", BANK_OF_THREE)
    told = report("tata ta", "mi")  # d aa d aa d aa; bmp ih
    (one, idle) = told.trigrams
    assert (one.trigram, one.count, one.places) == ("d-aa-d", 2, ("a.txt:1",))
    assert (idle.trigram, idle.count, idle.places) == ("bmp-ih-s", 0, ())
    needs = {row.bigram: row for row in told.bigrams}
    assert {name: row.in_trigrams for name, row in needs.items()} == {
        "d-aa": 2, "aa-d": 2, "bmp-ih": 0,
    }  # fmt: skip
    assert not needs["d-aa"].authored, "the last one plays as a bigram"
    assert needs["aa-d"].authored
    assert (before.authored.percent, told.authored.percent) == (0, 66.6667)
    assert (before.left.bigrams, told.left.bigrams) == (3, 2)
    assert told.next_hour.percent == 33.3333
    assert [row.bigram for row in told.bigrams if not row.authored] == ["d-aa", "bmp-ih"]
    for status in ("drafted", "approved"):
        write(packs / "posesets/facefx/banks/three.yaml", BANK_OF_THREE.replace("edited", status))
        again = report("tata ta", "mi")
        assert again.trigrams[0].status == status
        assert again.authored.percent == (0 if status == "drafted" else 66.6667)


def test_a_break_is_within_no_trigram_and_silence_may_begin_one(packs):
    text = BANK_OF_THREE.replace("d-aa-d", "_-d-aa")
    write(packs / "posesets/facefx/banks/three.yaml", text)
    assert report("ta, ta").trigrams[0].count == 2
    whole = coverage([Line("tata", "a.txt:1", gaps=(2,))], "toy", "facefx").reports[0]
    assert whole.trigrams[0].count == 1
    assert {row.bigram: row.in_trigrams for row in whole.silence}["_-d"] == 1


@pytest.mark.usefixtures("packs")
def test_characters_with_other_trigrams_are_counted_apart(packs):
    anna = "kind: character\nformat: 1\nname: anna\nposeset: facefx\n"
    write(packs / "characters/anna.yaml", anna + BANK_OF_THREE.partition("facefx\n")[2])
    plain, own = coverage(lines("tata"), "toy", ["facefx", "anna"]).reports
    assert (plain.trigrams, own.trigrams[0].count) == ((), 1)
    assert plain.authored.percent == 0 < own.authored.percent


@pytest.mark.parametrize("form", ["text", "html", "json"])
def test_trigrams_are_told(packs, form):
    write(packs / "posesets/facefx/banks/three.yaml", BANK_OF_THREE)
    out = io.StringIO()
    found = coverage(lines("tata ta"), "toy", "facefx")
    FORMS.find(form)(found, out, Asked())
    assert "d-aa-d" in out.getvalue()


@pytest.mark.usefixtures("packs")
def test_a_small_corpus_counted_by_hand():
    found = coverage(lines("tata mi", "ta, ta"), "toy", "facefx")
    told = found.reports[0]
    # d aa d aa bmp ih; d aa _ d aa
    assert told.phonemes | {"d": 4, "aa": 4, "bmp": 1, "ih": 1} == told.phonemes
    assert sum(told.phonemes.values()) == 10
    counts = {one.bigram: one.count for one in told.bigrams}
    assert counts == {"d-aa": 4, "aa-d": 1, "aa-bmp": 1, "bmp-ih": 1}
    assert {one.bigram: one.count for one in told.silence} == {"_-d": 3, "aa-_": 2, "ih-_": 1}
    assert told.occurrences == 7
    assert len(told.unused) == 22 * 22 - 4
    assert (told.lines, told.words) == (2, 4)
    assert (found.corpus.lines, found.corpus.words, found.corpus.files) == (2, 4, ("a.txt",))
    first = told.bigrams[0]
    assert (first.percent, first.running) == (57.1429, 57.1429)
    assert (first.example, first.places) == ("tata", ("a.txt:1", "a.txt:2"))
    across = next(one for one in told.bigrams if one.bigram == "aa-bmp")
    assert across.example == "", "it lies between two words"


@pytest.mark.usefixtures("packs")
def test_what_is_needed_and_what_is_left_by_hand():
    told = report("tata mi", "ta, ta")
    assert told.needed == {"90": 4, "95": 4, "99": 4, "100": 4}
    assert (told.left.bigrams, told.left.hours) == (4, 0.33)
    hour = report("tata mi", "ta, ta", minutes=30).next_hour
    assert (hour.bigrams, hour.percent) == (("d-aa", "aa-d"), 71.4286)
    assert report("ta", minutes=90).next_hour.bigrams == ()
    assert [(s.place, s.bigrams) for s in told.sentences] == [
        ("a.txt:1", ("aa-d", "aa-bmp", "d-aa", "bmp-ih"))
    ]


@pytest.mark.parametrize(("status", "counted"), [("drafted", 0), ("edited", 1), ("approved", 1)])
def test_a_draft_is_never_authored(packs, status, counted):
    bank(packs, status)
    told = report("tata")
    stated = next(one for one in told.bigrams if one.bigram == "aa-d")
    assert (stated.layer, stated.status) == ("shared", status)
    assert told.authored.bigrams == counted
    assert told.left.bigrams == 2 - counted
    assert told.authored.percent == pytest.approx(counted * 33.3333)
    assert ("aa-d" in told.next_hour.bigrams) is not counted
    tried = {name for sentence in told.sentences for name in sentence.bigrams}
    assert tried == {one.bigram for one in told.bigrams if not one.authored}


@pytest.mark.usefixtures("packs")
def test_what_is_borrowed_is_not_authored():
    told = report("yt ut")
    by_name = {one.bigram: one for one in told.bigrams}
    assert (by_name["yu-d"].layer, by_name["yu-d"].status) == ("like", "edited")
    assert not by_name["yu-d"].authored
    assert by_name["w-d"].authored
    assert not authored("gap", "")
    assert not authored("draft", "drafted")


@pytest.mark.usefixtures("packs")
def test_what_is_not_read_or_mapped_is_named_with_its_first_place():
    told = report("ta 7", "taq 7", "keks")
    found = [(one.what, one.count, one.place) for one in told.unread]
    assert found == [("7", 2, "a.txt:1"), ("keks", 1, "a.txt:3")]


@pytest.mark.usefixtures("packs")
def test_timed_phonemes_are_counted_as_they_are():
    schedule = Schedule(("t", "a", "_", "x"), [0, 0.1, 0.2, 0.3, 0.4], notation="ipa")
    found = coverage([Line("ta", "a.json:1", schedule=schedule)], "toy", "facefx")
    told = found.reports[0]
    assert {one.bigram: one.count for one in told.bigrams} == {"d-aa": 1}
    assert {one.bigram: one.count for one in told.silence} == {"_-d": 1, "aa-_": 1}
    assert [(one.what, one.count, one.place) for one in told.unmapped] == [("x", 1, "a.json:1")]


# Gaps


def heard(told):
    """Count each bigram, including those with silence."""
    return Counter({one.bigram: one.count for one in (*told.bigrams, *told.silence)})


def gapped(text, *gaps):
    return coverage([Line(text, "a.txt:1", gaps=gaps)], "toy", "facefx").reports[0]


@pytest.mark.usefixtures("packs")
def test_what_lies_around_a_placeholder_does_not_follow_on_each_other(tmp_path):
    path = write(tmp_path / "a.txt", "ta {name} mi\n%s ta\nta, $who. Mi\nt<i>a</i> mi\n")
    one, two, three, four = (
        heard(coverage([line], "toy", "facefx").reports[0]) for line in read_lines(path)
    )
    assert one == {"_-d": 1, "d-aa": 1, "bmp-ih": 1, "ih-_": 1}
    assert two == {"d-aa": 1, "aa-_": 1}
    assert three == {"_-d": 1, "d-aa": 1, "aa-_": 1, "_-bmp": 1, "bmp-ih": 1, "ih-_": 1}
    assert four == {"_-d": 1, "d-aa": 1, "aa-bmp": 1, "bmp-ih": 1, "ih-_": 1}


@pytest.mark.usefixtures("packs")
@costly()
@given(st.text("ta mi,.", max_size=12), st.lists(st.integers(0, 12), max_size=3))
def test_a_gap_takes_away_and_never_adds(text, gaps):
    inside = sorted(gap for gap in gaps if gap <= len(text))
    assert heard(gapped(text, *inside)) <= heard(gapped(text))


@pytest.mark.usefixtures("packs")
def test_what_is_not_read_stands_between_its_neighbours():
    told = report("ta 7 mi")
    assert heard(told) == {"_-d": 1, "d-aa": 1, "bmp-ih": 1, "ih-_": 1}
    told = report("taxmi")
    assert heard(told) == {}, "where in the word the x stands is not known"
    assert told.phonemes | {"d": 1, "aa": 1, "bmp": 1, "ih": 1} == told.phonemes


def test_a_label_without_a_map_stands_between_its_neighbours(packs):
    lexicon = "g2p: {engine: lexicon, notation: ipa, file: words.tsv}"
    given = [x for x in LANGUAGE.splitlines() if "g2p" not in x]
    write(packs / "languages/toy.yaml", "\n".join([*given, lexicon, ""]))
    write(packs / "languages/words.tsv", "taqmi\tt a Q m i\n")
    told = report("taqmi")
    assert [(one.what, one.count) for one in told.unmapped] == [("Q", 1)]
    assert heard(told) == {"_-d": 1, "d-aa": 1, "bmp-ih": 1, "ih-_": 1}
    assert {one.example for one in told.bigrams} == {"taqmi"}
    schedule = Schedule(("t", "a", "x", "m", "i"), [0, 1, 2, 3, 4, 5], notation="ipa")
    timed = coverage([Line("", "a.json:1", schedule=schedule)], "toy", "facefx").reports[0]
    assert heard(timed) == heard(told)


# Other scripts


WRITTEN = LANGUAGE.replace(
    "rules: [", "rules: [{from: да, to: [t, a]}, {from: м, to: m}, {from: и, to: i}, "
) + ("tests:\n- {text: ta mi, phonemes: [d, aa, bmp, ih]}\n")
"""The toy language in Latin letters, with one known word and one spelled word in Cyrillic."""


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
    monkeypatch.setattr("lipsync_lang.coverage.corpus.BATCH_LINES", 1)
    monkeypatch.setattr("lipsync_lang.coverage.scripts.MAX_NAMES", 0)
    assert coverage(lines(*texts), "toy", "facefx") == whole


def test_a_word_in_capitals_is_judged_as_if_it_were_in_small_letters():
    class Shouted:
        manner = SimpleNamespace(words={})

        def transcribe(self, texts):
            spelled = (text.isupper() or len(text) == 1 for text in texts)
            for text, letters in zip(texts, spelled, strict=True):
                yield SimpleNamespace(phonemes=[*text.lower()] if letters else [text])

    others = scripts.OtherScripts(Shouted(), {"LATIN"})
    assert others.spelled([SimpleNamespace(text="ta ДА", place="here")]) == [[]]
    assert [(one.what, one.counted) for one in others.tallies()] == [("ДА", True)]


@full
def test_a_voice_reads_words_of_other_languages_and_spells_what_it_has_no_voice_for():
    pytest.importorskip("phonemizer", reason="the speech extra is not installed")
    texts = ("Он сказал hello world и ушёл.", "Он сказал 会議 и ушёл.", "Он ушёл.", "I love you")
    told = coverage(lines(*texts), "russian", "facefx").reports[0]
    counted = {one.what: one.counted for one in told.other_scripts}
    latin = dict.fromkeys(("hello", "world", "I", "love", "you"), True)
    assert counted == {**latin, "会議": False}
    assert "h-ah" in heard(told), "of hello"
    spelled = coverage(lines("Он сказал 会議 и ушёл."), "russian", "facefx").reports[0]
    assert (spelled.words, "sh-ay" in heard(spelled)) == (4, False), "not 'Chinese letter'"


@full
def test_real_lines_in_another_script_are_not_taken_for_speech(data):
    pytest.importorskip("phonemizer", reason="the speech extra is not installed")
    path = data / "text/the_question_lines.tsv"
    told = coverage(read_lines(path, column="japanese"), "russian", "facefx").reports[0]
    read = [one.what for one in told.other_scripts if one.counted]
    assert read == ["Interactive"]
    assert {one.example for one in told.bigrams} == {"Interactive"}
    assert sum(one.count for one in told.other_scripts) > 500


@pytest.mark.usefixtures("packs")
def test_lines_that_hold_nothing_cover_nothing():
    told = report("...", "", "7")
    assert (told.occurrences, told.bigrams, told.authored.percent) == (0, (), 0)
    assert told.needed == {"90": 0, "95": 0, "99": 0, "100": 0}


@pytest.mark.usefixtures("packs")
def test_no_lines_at_all_are_refused():
    with pytest.raises(LipsyncError, match="there are no lines"):
        coverage([], "toy", "facefx")


@pytest.mark.usefixtures("packs")
@pytest.mark.parametrize("minutes", [0, -1, float("nan"), float("inf")])
def test_minutes_are_a_number_above_zero(minutes):
    with pytest.raises(LipsyncError, match="above 0"):
        report("ta", minutes=minutes)


@full
@pytest.mark.usefixtures("packs")
def test_many_lines_are_counted_as_few_are(monkeypatch):
    texts = ["tata mi", "ta, ta", "", "ut sa", "yt"] * 5
    whole = coverage(lines(*texts), "toy", "facefx")
    monkeypatch.setattr("lipsync_lang.coverage.corpus.BATCH_LINES", 3)
    monkeypatch.setattr("lipsync_lang.coverage.corpus.MAX_MEMORY_BYTES", 10)
    assert coverage(iter(lines(*texts)), "toy", "facefx") == whole


@pytest.mark.usefixtures("packs")
def test_several_languages_and_characters_and_what_they_share():
    found = coverage(lines("tyt"), ["toy", "toy"], ["facefx", "crab"])
    assert [(r.language, r.character) for r in found.reports] == [
        ("toy", "facefx"), ("toy", "crab")
    ]  # fmt: skip
    (shared,) = found.shared
    assert (shared.phonemes, shared.bigrams, shared.used) == (("yu",), 43, 2)


def test_words_of_a_character_are_its_own(packs):
    write(
        packs / "characters/ann.yaml",
        "kind: character\nformat: 1\nname: ann\nposeset: facefx\n"
        "pronunciations: {toy: {ta: [s, ih]}}\n",
    )
    plain, own = coverage(lines("ta"), "toy", ["facefx", "ann"]).reports
    assert [one.bigram for one in plain.bigrams] == ["d-aa"]
    assert [one.bigram for one in own.bigrams] == ["s-ih"]


# Plans


COUNTS = st.lists(st.integers(0, 50), min_size=1, max_size=30)


@given(COUNTS)
def test_running_totals_rise_to_all(counts):
    order = plan.ranked(np.array(counts))
    found = [counts[n] for n in order]
    assert found == sorted((c for c in counts if c), reverse=True)
    needed = list(plan.needed(found).values())
    assert needed == sorted(needed)
    assert needed[-1] == len(found)


@given(COUNTS)
def test_what_is_needed_is_enough_and_no_more(counts):
    found = sorted((c for c in counts if c), reverse=True)
    for share, number in plan.needed(found).items():
        wanted = int(share) * sum(found)
        assert 100 * sum(found[:number]) >= wanted
        assert not number or 100 * sum(found[: number - 1]) < wanted


SETS = st.lists(st.sets(st.integers(0, 20), max_size=8), max_size=25)


def packed(sets):
    starts = np.cumsum([0, *map(len, sets)])
    return np.array([m for s in sets for m in sorted(s)], np.uint16), starts


@given(SETS, st.sets(st.integers(0, 25)))
def test_a_cover_covers_all_that_can_be_and_nothing_twice(sets, wanted):
    members, starts = packed(sets)
    found = plan.cover(members, starts, np.array(sorted(wanted), np.int64))
    there = set().union(*sets) & wanted
    new = [member for _, members in found for member in members]
    assert sorted(new) == sorted(there)
    assert len({number for number, _ in found}) == len(found)
    for number, members in found:
        assert members, "each set has something new"
        assert set(members) <= sets[number]


@given(SETS, st.sets(st.integers(0, 25)))
def test_no_set_of_a_cover_can_be_spared(sets, wanted):
    members, starts = packed(sets)
    chosen = [n for n, _ in plan.cover(members, starts, np.array(sorted(wanted), np.int64))]
    there = set().union(*sets) & wanted
    for one in chosen:
        assert not there <= set().union(*(sets[n] for n in chosen if n != one))


def test_a_cover_takes_the_shorter_of_equals():
    members, starts = packed([{1, 2, 7, 8, 9}, {1, 2}, {3}])
    assert plan.cover(members, starts, np.array([1, 2, 3])) == [(1, [1, 2]), (2, [3])]


# The document


def test_the_schema_is_the_one_that_is_written(root):
    there = (root / "docs/reference/coverage.schema.json").read_text(encoding="utf-8")
    assert there == written(), "run python -m lipsync_lang.coverage.document_schema > that file"


SHAPE = {
    "": ["format", "corpus", "minutes", "reports", "shared"],
    "corpus": ["files", "lines", "words"],
    "reports": [
        "language", "language_title", "character", "poseset", "lines", "words", "phonemes",
        "occurrences", "bigrams", "silence", "unused", "needed", "authored", "left", "next_hour",
        "sentences", "unread", "unmapped",
    ],
    "bigrams": [
        "bigram", "count", "percent", "running", "layer", "status", "example", "places",
    ],
    "sentences": ["place", "text", "bigrams"],
    "shared": ["language", "phonemes", "bigrams"],
}  # fmt: skip
"""First keys of version 1 of the document; new keys come after them."""


@pytest.mark.usefixtures("packs")
def test_the_document_has_the_keys_of_its_version():
    document = coverage(lines("tata"), "toy", "facefx").to_dict()
    told = document["reports"][0]
    parts = {
        "": document,
        "corpus": document["corpus"],
        "reports": told,
        "bigrams": told["bigrams"][0],
        "sentences": told["sentences"][0],
        "shared": document["shared"][0],
    }
    for name, keys in SHAPE.items():
        assert list(parts[name])[: len(keys)] == keys
    assert document["format"] == "lipsync-lang coverage 1"
    assert json.loads(json.dumps(document)) == document
    assert Coverage.model_validate(document).to_dict() == document
    assert document["minutes"] == 5
    assert isinstance(document["minutes"], int)


@full
def test_real_sentences_are_counted_soundly(data):
    pytest.importorskip("phonemizer", reason="the speech extra is not installed")
    path = data / "text/harvard-sentences.txt"
    told = coverage(read_lines([path]), "english", "facefx").reports[0]
    running = [one.running for one in told.bigrams]
    assert running == sorted(running)
    assert running[-1] == 100
    assert sum(one.count for one in told.bigrams) == told.occurrences
    assert len(told.bigrams) + len(told.unused) == 441
    assert max(told.phonemes, key=told.phonemes.get) == "d"
    assert not told.unread
    assert not told.unmapped
    tried = [name for sentence in told.sentences for name in sentence.bigrams]
    assert sorted(tried) == sorted(one.bigram for one in told.bigrams)
    assert len(told.sentences) < 100
    assert all(a.count >= b.count for a, b in pairwise(told.bigrams))


# The command


@pytest.fixture
def script(packs):
    """A file of lines."""
    return write(packs / "script.txt", "tata <b>mi</b>\nta, ta\n")


def run(cli, *more):
    return cli("coverage", "script.txt", "-l", "toy", "-c", "facefx", *more)


@pytest.mark.usefixtures("script")
def test_text_says_first_what_to_do_next(cli):
    ended = run(cli)
    assert ended.code == 0
    assert ended.err == ""
    shown = ended.out.splitlines()
    assert shown[0] == "1 file, 2 lines, 4 words"
    assert "not spoken: </b> (1, script.txt:1)" in shown[1]
    assert "next: draw 4 bigrams" in shown[4]
    assert shown[5].strip() == (
        "lipsync-lang bank draft -l toy -c facefx --write d-aa aa-d aa-bmp bmp-ih"
    )
    assert "0 of 4 bigrams" in shown[6]
    assert "no mapping for" not in ended.out


@pytest.mark.usefixtures("script")
def test_what_is_suggested_can_be_typed(cli):
    command = next(x for x in run(cli).out.splitlines() if "lipsync-lang bank" in x)
    assert cli(*command.split()[1:]).code == 0


@pytest.mark.parametrize("form", FORMS)
def test_every_form_can_be_written_and_printed(cli, script, form):
    out = script.parent / "out" / f"a.{form}"
    out.parent.mkdir()
    assert run(cli, "--format", form, "-o", out).code == 0
    printed = run(cli, "--format", form)
    assert printed.code == 0
    assert out.read_text("utf-8") == printed.out


@pytest.mark.parametrize(
    ("name", "start"),
    [("a.json", '{\n  "format"'), ("a.csv", "language,"), ("a.xml", "<?xml"), ("a.txt", "1 file")],
)
def test_the_suffix_of_a_file_names_its_form(cli, script, name, start):
    assert run(cli, "-o", name).code == 0
    assert (script.parent / name).read_text("utf-8").startswith(start)


@pytest.mark.usefixtures("script")
def test_a_table_has_a_row_per_bigram(cli):
    rows = list(csv.DictReader(io.StringIO(run(cli, "--format", "csv").out)))
    assert [row["bigram"] for row in rows if row["silence"] == "no"] == [
        "d-aa", "aa-d", "aa-bmp", "bmp-ih"
    ]  # fmt: skip
    assert {row["authored"] for row in rows} == {"no"}


@pytest.mark.parametrize(("percent", "code"), [(0, 0), (14, 0), (15, 1)])
def test_too_little_authored_fails_a_build(cli, script, percent, code):
    bank(script.parent, "approved")
    ended = run(cli, "--format", "junit", "--fail-under", percent)
    assert ended.code == code
    (suite,) = ET.fromstring(ended.out)  # noqa: S314 our own
    cases = suite.findall("testcase")
    assert suite.get("tests") == str(len(cases)) == "5"
    assert suite.get("failures") == str(len(suite.findall("testcase/failure"))) == str(code)
    assert suite.get("skipped") == str(len(suite.findall("testcase/skipped"))) == "3"
    assert ("under 15 %" in ended.err) == bool(code)


def test_what_changed_since(cli, script):
    assert run(cli, "-o", "old.json").code == 0
    bank(script.parent, "edited")
    write(script, "tata\nsi\n")
    ended = run(cli, "--against", "old.json")
    assert "since old.json:" in ended.out
    assert "toy on facefx: 0 % to 25.0 % authored, 4 to 2 left" in ended.out
    assert "    authored: aa-d" in ended.out
    assert "    newly needed: s-ih" in ended.out
    assert "    no longer needed: aa-bmp, bmp-ih" in ended.out
    document = json.loads(run(cli, "--against", "old.json", "--format", "json").out)
    assert list(document)[-1] == "since"
    assert document["since"]["reports"][0]["authored"] == ["aa-d"]


@pytest.mark.usefixtures("packs")
def test_a_report_that_only_one_has_is_named():
    old = coverage(lines("ta"), "toy", "facefx")
    new = coverage(lines("ta"), "toy", "crab")
    assert set(since(old, new, "old").since.unmatched) == {"toy on facefx", "toy on crab"}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "lipsync-lang coverage 2"}', "\0"])
def test_an_older_document_must_be_one(packs, text):
    with pytest.raises(LipsyncError, match=r"is not a 'lipsync-lang coverage 1' document"):
        read_document(write(packs / "old.json", text))
    with pytest.raises(LipsyncError, match="cannot be read"):
        read_document(packs / "gone.json")


def test_languages_may_have_columns_of_their_own(cli, packs):
    write(packs / "a.csv", "id,one,two\n1,ta,mi\n")
    write(packs / "languages/other.yaml", LANGUAGE.replace("toy", "other"))
    ended = cli(
        "coverage", "a.csv", "-l", "toy", "-l", "other", "-c", "facefx", "--column", "one",
        "--column", "other=two", "--format", "json",
    )  # fmt: skip
    document = json.loads(ended.out)
    assert [r["bigrams"][0]["bigram"] for r in document["reports"]] == ["d-aa", "bmp-ih"]
    assert document["corpus"]["lines"] == 2
    assert len(document["shared"]) == 2


@pytest.fixture
def both(packs, cli):
    """Count a language in two columns, with more options."""
    write(packs / "a.csv", "id,one,two\n1,tyt,mi\n2,,uta\n")
    columns = ("--column", "toy=one", "--column", "toy=two")
    return lambda *more: cli("coverage", "a.csv", "-l", "toy", "-c", "facefx", *columns, *more)


def test_a_language_may_have_several_columns(both):
    document = json.loads(both("--format", "json").out)
    assert [(r["language"], r["column"], r["lines"]) for r in document["reports"]] == [
        ("toy", "one", 1), ("toy", "two", 2)
    ]  # fmt: skip
    (shared,) = document["shared"]
    assert shared["used"] == 2, "of both columns together"


def test_every_form_tells_the_columns_of_a_language_apart(both):
    text = both().out.splitlines()
    for label in ("toy (one)", "toy (two)"):
        assert (
            sum(line.startswith((f"{label} on facefx:", f"{label}  facefx")) for line in text) == 2
        )
    rows = csv.DictReader(io.StringIO(both("--format", "csv").out))
    assert {row["column"] for row in rows} == {"one", "two"}
    suites = ET.fromstring(both("--format", "junit").out)  # noqa: S314 our own
    names = [suite.get("name") for suite in suites]
    assert names == ["all reports together", "toy (one) on facefx", "toy (two) on facefx"]
    page = both("--format", "html").out
    assert page.count("<th>Toy (one)</th>") == page.count("<th>Toy (two)</th>") == 1
    failed = both("--fail-under", "100").err
    assert "toy (one) on facefx: 0 % are authored" in failed


@full
def test_what_changed_is_told_for_each_column(both, packs):
    assert both("-o", "old.json").code == 0
    bank(packs, "edited")
    write(packs / "a.csv", "id,one,two\n1,tyt,mi\n2,ta,uta\n")
    ended = both("--against", "old.json")
    assert "toy (one) on facefx:" in ended.out.partition("since")[2]
    assert "toy (two) on facefx:" in ended.out.partition("since")[2]
    assert "in only one of the documents" not in ended.out
    document = json.loads(both("--against", "old.json", "--format", "json").out)
    assert [change["column"] for change in document["since"]["reports"]] == ["one", "two"]
    assert document["since"]["reports"][0]["new"] == ["d-aa"]


@pytest.mark.usefixtures("script")
def test_a_column_that_nothing_has_is_told(cli):
    ended = run(cli, "--column", "en")
    assert ended.code == 0
    assert ended.err == "--column en: not used, because no file is a table\n"


@pytest.mark.parametrize("form", ["text", "junit", "html"])
def test_words_in_another_script_are_told_in_every_form_for_people(cli, packs, form):
    write(packs / "languages/toy.yaml", WRITTEN)
    write(packs / "script.txt", "ta да mi\nta ми\n")
    shown = run(cli, "--format", form).out
    assert "да" in shown
    assert "not counted" in shown
    if form == "text":
        assert "in another script, read by the voice: да (1, script.txt:1)" in shown
        assert "in another script, not counted: ми (1, script.txt:2)" in shown


@pytest.mark.parametrize(
    ("more", "match"),
    [
        (["--fail-under", "101"], "give a percentage, 0 to 100"),
        (["--fail-under", "nan"], "give a percentage, 0 to 100"),
        (["--minutes", "0"], "above 0"),
        (["--against", "gone.json"], "gone.json: cannot be read"),
        (["--encoding", "klingon"], "unknown encoding"),
        (["--column", "a", "--column", "b"], "there is already --column a"),
        (["-l", "klingonese"], "klingonese"),
        (["-c", "nobody"], "nobody"),
        (["-o", "./script.txt"], "is an input"),
        (["-o", "gone/a.json"], "the folder gone does not exist"),
    ],
)
@pytest.mark.usefixtures("script")
def test_what_cannot_be_done_says_why(cli, more, match):
    ended = run(cli, *more)
    assert ended.code == 2
    assert match in ended.err
    assert ended.out == ""


@pytest.mark.usefixtures("script")
def test_a_terminal_is_told_how_far_it_is(cli, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    ended = run(cli)
    assert ended.err == "\x1b[2K0 lines, script.txt\r\x1b[2K\r"


def test_a_language_that_does_not_read_says_so(cli, packs):
    silent = "".join(x for x in LANGUAGE.splitlines(keepends=True) if "g2p" not in x)
    write(packs / "languages/toy.yaml", silent)
    write(packs / "script.txt", "ta\n")
    ended = run(cli)
    assert ended.code == 2
    assert "toy does not read text" in ended.err


def test_an_empty_folder_says_so(cli, packs):
    (packs / "script.txt").mkdir()
    write(packs / "script.txt/a.png", "x")
    ended = run(cli)
    assert ended.code == 2
    assert "a.png: left out: no reader for '.png'" in ended.err
    assert "there are no lines" in ended.err


def test_a_share_that_is_met_exactly_needs_no_more():
    assert plan.needed([90, 5, 4, 1]) == {"90": 1, "95": 2, "99": 3, "100": 4}
