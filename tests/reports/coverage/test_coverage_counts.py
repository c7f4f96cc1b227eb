"""Counts: bigrams and trigrams that lines need, and which of them a character has."""

import io
import json
from contextlib import chdir
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from coverage_packs import BANK_OF_THREE, LANGUAGE, bank, heard, lines, report, write
from hypothesis import example, given
from hypothesis import strategies as st
from lanes import costly, full

from lipsync_lang import LipsyncError, Schedule, resolve
from lipsync_lang.base.presentation.wording import percent
from lipsync_lang.pipeline.track import lay_track
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.report import Coverage, authored, schema
from lipsync_lang.text.lines import Line, read_lines


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


SHADED = LANGUAGE.replace("{a: aa,", "{a: aa, æ: ae, k: kg, ŋ: ng,")
BANK = "kind: bank\nformat: 1\nname: {}\nposeset: facefx\nbigrams:\n"
STATED = "  {}: {{status: {}, curves: {{open: [[0, 0], [0.5, 0.4], [1, 0]]}}}}\n"
SOME = ["kg-aa", "kg-ae", "ng-aa", "ng-ae", "aa-kg", "ae-ng", "aa-d", "ae-d"]
STATUSES = st.dictionaries(st.sampled_from(SOME), st.sampled_from(["drafted", "edited"]))


def drawn_by_hand(texts, character):
    """Count the bigrams that play in lines, and those that a person drew, from the tracks."""
    performer = resolve("toy", character)
    compiled, played, drawn = performer.compiled, 0, 0
    for text in texts:
        sounds = performer.common_phonemes(timed(text))
        track = lay_track(*sounds, compiled.tables, performer.motion)
        spoken = (track.ids[:-1] != 0) & (track.ids[1:] != 0)
        origins = [compiled.origins[row] for row in track.rows[spoken].tolist()]
        played += len(origins)
        drawn += sum(authored(one.layer, one.status) for one in origins)
    return played, drawn


@costly()
@given(
    texts=st.lists(st.text("aækŋt", min_size=2, max_size=6), min_size=1, max_size=4),
    shared=STATUSES, own=STATUSES,
)  # fmt: skip
@example(texts=["kæ"], shared={"kg-aa": "edited", "kg-ae": "drafted"}, own={})
@example(texts=["kæ"], shared={"kg-ae": "edited"}, own={"kg-aa": "drafted"})
def test_what_counts_as_drawn_is_played_and_what_is_drawn_next_plays(texts, shared, own):
    with TemporaryDirectory() as folder, chdir(folder):
        write(Path("languages/toy.yaml"), SHADED)
        paths = Path("posesets/facefx/banks/common.yaml"), Path("characters/anna.yaml")
        anna = "kind: character\nformat: 1\nname: anna\nposeset: facefx\nbigrams:\n"
        heads = BANK.format("common"), anna
        banks = [dict(shared), dict(own)]

        def told():
            for path, head, stated in zip(paths, heads, banks, strict=True):
                rows = "".join(STATED.format(*one) for one in stated.items())
                write(path, head + rows if stated else head.replace("bigrams:\n", ""))
            found = coverage(
                [Line(text, f"a.txt:{n}", schedule=timed(text)) for n, text in enumerate(texts)],
                "toy", "anna", minutes=60,
            ).reports[0]  # fmt: skip
            played, drawn = drawn_by_hand(texts, "anna")
            assert found.occurrences == played
            assert found.authored.percent == percent(drawn, played)
            return found, drawn

        before, drawn = told()
        for name in before.next_hour.bigrams:
            (row,) = (row for row in before.bigrams if row.bigram == name)
            banks["anna" in row.stated][name] = "edited"
            gain = row.count
            after, now = told()
            assert now == drawn + gain
            assert name not in after.next_hour.bigrams


def timed(text):
    return Schedule(tuple(text), np.arange(len(text) + 1) / 10, notation="ipa")


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
    FORMS.find(form)(found, out, FormOptions())
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


def test_a_fitted_bigram_is_left_and_comes_last(packs):
    bank(packs, "fitted")
    assert report("tata", minutes=60).next_hour.bigrams == ("d-aa",)
    told = report("ta ta ta at", minutes=60)
    assert told.next_hour.bigrams != ("aa-d",)
    whole, out = coverage(lines("ta ta ta at"), "toy", "facefx", minutes=60), io.StringIO()
    FORMS.find("text")(whole, out, FormOptions())
    assert "1 of them fitted, to be checked" in out.getvalue()


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
    monkeypatch.setattr("lipsync_lang.reports.coverage.corpus.BATCH_LINES", 3)
    monkeypatch.setattr("lipsync_lang.reports.coverage.corpus.MAX_MEMORY_BYTES", 10)
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


# The document


def test_the_schema_is_the_one_that_is_written(root):
    there = (root / "docs/reference/coverage.schema.json").read_text(encoding="utf-8")
    written = json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"
    assert there == written, "run python docs/build_reference.py"


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
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
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
