"""Files of labels: HTK and HTS, ESPS (Festival, Buckeye), TIMIT, BAS Partitur, Gentle."""

import json
import subprocess
import sys

import numpy as np
import pytest
from timing_texts import spoken

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError

HH_AY = "0 1000000 hh\n1000000 3000000 ay\n"


# HTK and HTS


def test_htk_counts_in_100_nanoseconds(read):
    schedule = read("line.lab", HH_AY)
    assert schedule.labels == ("hh", "ay")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.3])
    assert schedule.lines == (1, 2)
    assert read("line.lab", "0 100 hh\n100 300 ay\n", rate=1000).end == pytest.approx(0.3)


def test_times_with_a_point_are_seconds(read):
    assert read("line.lab", "0.0 0.1 hh\n0.1 0.3 ay\n").end == pytest.approx(0.3)
    assert read("line.lab", "0 0.3 hh\n").end == pytest.approx(0.3)


def test_words_follow_the_scores(read):
    text = "0 2 sil -9.5 SIL -9\n2 4 h -1.5 -3 hi\n4 8 ay -2e1\n8 9 y -1 -1 you\n"
    schedule = read("line.lab", text, rate=10)
    assert spoken(schedule)[1:] == [("hi", ("h", "ay")), ("you", ("y",))]
    last = read("line.lab", "0 2 h -1 -1 hi\n2 4 ay -1\n", rate=10)
    assert spoken(last) == [("hi", ("h", "ay"))]


@pytest.mark.parametrize(
    "context",
    ["x^x-{}+hh=iy@x_x/A:0_0", "xx^sil-{}+i=z/A:-2+1+3/B:xx-xx_xx", "a^b-{}+c=d@1_2/A:1_1-x+y"],
)
@pytest.mark.parametrize("phone", ["sil", "m", "ax-h", "N"])
def test_the_phone_stands_in_its_context(read, context, phone):
    assert read("line.lab", f"0 1000000 {context.format(phone)}\n").labels == (phone,)


def test_states_of_one_phone_are_joined(read):
    rows = [("x^x-m+a=b/A:0", 2), ("x^x-m+a=b/A:0", 3), ("x^m-m+b=c/A:1", 2), ("x^m-m+b=c/A:1", 3)]
    text = "".join(f"{at} {at + 1} {name}[{state}]\n" for at, (name, state) in enumerate(rows))
    schedule = read("line.lab", text, rate=10)
    assert schedule.labels == ("m", "m")
    np.testing.assert_allclose(schedule.times, [0, 0.2, 0.4])


MASTER = '#!MLF!#\n"*/one.lab"\n0 1000000 a\n.\n"C:\\data\\two.rec"\n0 2000000 b\n.\n'


def test_a_master_file_is_read_one_utterance_at_a_time(read):
    assert read("all.mlf", MASTER, tier="two").labels == ("b",)
    assert read("all.mlf", MASTER, tier="one").end == pytest.approx(0.1)
    assert read("all.mlf", MASTER[: MASTER.index('"C:')]).labels == ("a",)
    with pytest.raises(ScheduleError, match=r"2 utterances: 'one', 'two'; .*`tier=.one.`"):
        read("all.mlf", MASTER)
    with pytest.raises(ScheduleError, match=r"no tier is named 'twoo'; did you mean 'two'\?"):
        read("all.mlf", MASTER, tier="twoo")
    with pytest.raises(ScheduleError, match="has no phonemes"):
        read("all.mlf", "#!MLF!#\n")


def test_the_first_of_several_transcriptions_is_read(read):
    schedule = read("line.lab", HH_AY + "///\n0 3000000 oops\n")
    assert schedule.labels == ("hh", "ay")
    assert "line.lab:3: has other transcriptions, which are not read" in schedule.remarks[0]


@pytest.mark.parametrize("text", ["hello there\n", "“Ja”, sagt sie\nund geht\n", "日本語\n"])
def test_a_transcript_is_told_from_timings(read, text):
    with pytest.raises(ScheduleError, match=r"lab:1: is a transcript without times; align it"):
        read("line.lab", text)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HH_AY + "3000000 oops\n", r"lab:3: '3000000 oops' is not a start, an end and a label"),
        (HH_AY + "2000000 4000000 t\n", r"lab:3: 't', 0.2 to 0.4 s, starts before 'ay' ends"),
        (HH_AY + "3000000 2000000 t\n", r"lab:\d: .*(overlap|ends before it starts)"),
        ("-2000000 0 t\n" + HH_AY, r"lab:1: 't'.* starts below 0"),
    ],
)
def test_a_fault_says_the_line(read, text, told):
    with pytest.raises(ScheduleError, match=told):
        read("line.lab", text)


# ESPS


def test_festival_writes_when_a_segment_ends(read):
    schedule = read("line.lab", "#\n0.2200 100 pau\n0.2900 100 hh\n0.5000 100 ax\n")
    assert schedule.labels == ("pau", "hh", "ax")
    np.testing.assert_allclose(schedule.times, [0, 0.22, 0.29, 0.5])


def test_a_header_is_skipped_and_further_fields_are_left(read):
    text = (
        "signal a\ncolor 122\nseparator ;\nnfields 2\n#\n 0.1 122 ae; n\n 0.2 -1\n 0.4 122 s; x\n"
    )
    schedule = read("line.seg", text)
    assert schedule.labels == ("ae", "_", "s")


def test_words_of_a_corpus_are_beside_its_phones(read, tmp_path):
    words = "#\n0.1 122 {B_TRANS}; B; B; null\n0.3 122 hi; hh ay; hh ay; UH\n0.4 122 <SIL>; S; S;\n"
    (tmp_path / "line.WORDS").write_text(words)
    phones = "#\n0.1 122 {B_TRANS}\n0.2 122 hh\n0.3 122 ay\n0.4 122 SIL\n"
    assert spoken(read("line.phones", phones)) == [("hi", ("hh", "ay"))]
    (tmp_path / "line.WORDS").write_text("#\nwhat\n")
    with pytest.raises(ScheduleError, match=r"line\.WORDS:2: 'what' is not a time, a colour and"):
        read("line.phones", phones)
    with pytest.raises(ScheduleError, match=r"words: has timed words only"):
        read("line.words", words)
    with pytest.raises(ScheduleError, match=r"phones:2: .* is not a time"):
        read("line.phones", "#\nae+1\n")
    noted = "#\n0.1 122 ae+1; *\n0.2 122 ++noise++\n"
    assert read("noted.phones", noted).labels == ("ae", "++noise++")


# TIMIT


def test_timit_counts_samples_and_has_words_beside_it(read, tmp_path):
    (tmp_path / "line.WRD").write_text("1600 4800 she\n")
    schedule = read("line.PHN", "0 1600 h#\n1600 3200 sh\n3200 4800 iy\n4800 6400 h#\n")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.3, 0.4])
    assert spoken(schedule) == [("she", ("sh", "iy"))]
    assert read("line.PHN", "0 800 sh\n800 1600 iy\n", rate=8000).end == pytest.approx(0.2)


def test_two_numbers_and_a_label_need_a_suffix_or_a_name(read):
    text = "0 1600 sh\n1600 3200 iy\n"
    with pytest.raises(ScheduleError, match=r"may be .*htk.*timit.*; choose one \(`read_as="):
        read("line.xyz", text)
    assert read("line.xyz", text, read_as="timit").end == pytest.approx(0.2)


# BAS Partitur


def test_formats_of_our_plug_ins_compete_with_the_built_in_ones():
    code = (
        "from lipsync_lang.schedules.timing_readers import TIMING_READERS as known\n"
        "from lipsync_lang.animations.animation_writers import WRITERS\n"
        "print({'htk', 'json'} <= known.built_in().keys(), 'csv' == [*WRITERS.built_in()][0])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stdout.split() == [b"True", b"True"]


def test_an_option_says_which_of_two_formats_a_file_has(folder, cli):
    (folder / "line.odd").write_text("0 1600 HH\n", "utf-8")
    run = ("run", "-l", "english", "-c", "facefx", "--schedule", "line.odd", "-o", "line.csv")
    asked = cli(*run)
    assert asked.code == 2
    assert "may be htk or timit; choose one" in asked.err
    assert cli(*run, "--read-as", "timit").code == 0


def test_partitur_counts_samples_at_its_own_rate(read):
    text = "LHD: 1\nSAM: 8000\nLBD:\nORT:\t0\tja\nMAU:\t0\t799\t-1\t<p:>\nMAU:\t800\t799\t0\tj\n"
    schedule = read("line.par", text + "MAU:\t1600\t799\t0\ta:\n")
    assert schedule.labels == ("<p:>", "j", "a:")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.3])
    assert spoken(schedule) == [("ja", ("j", "a:"))]
    with pytest.raises(ScheduleError, match=r"par:7: a phone needs a start, a duration, a link"):
        read("line.par", text + "MAU:\t1600\n")
    with pytest.raises(ScheduleError, match=r"states no rate \(SAM: 16000\)"):
        read("line.par", text.replace("SAM: 8000\n", ""))
    with pytest.raises(ScheduleError, match="has no tier MAU; align its words"):
        read("line.par", text.split("MAU", 1)[0])


def test_a_phone_of_two_words_belongs_to_the_first(read):
    text = "LHD: 1\nSAM: 10\nORT:\t0\thast\nORT:\t1\tdu\n"
    phones = "MAU:\t0\t0\t0\tas\nMAU:\t1\t0\t0,1\tt\nMAU:\t2\t0\t1\tu:\n"
    assert spoken(read("line.par", text + phones)) == [("hast", ("as", "t")), ("du", ("u:",))]


# Gentle


def gentle(*words):
    return json.dumps({"transcript": "...", "words": list(words)})


def aligned(word, start, *phones):
    phones = [{"phone": phone, "duration": length} for phone, length in phones]
    return {"case": "success", "word": word, "alignedWord": word, "start": start, "phones": phones}


def test_gentle_lists_phones_by_their_lengths(read):
    text = gentle(
        aligned("hi", 0.1, ("hh_B", 0.1), ("ay_E", 0.2)), aligned("oh", 0.5, ("ow_S", 0.1))
    )
    schedule = read("line.json", text)
    assert schedule.labels == ("_", "hh", "ay", "_", "ow")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.4, 0.5, 0.6])
    assert spoken(schedule) == [("hi", ("hh", "ay")), ("oh", ("ow",))]
    assert not schedule.remarks


def test_words_that_gentle_did_not_hear_are_told_of(read):
    lost = {"case": "not-found-in-audio", "word": "there"}
    (told,) = read("line.json", gentle(aligned("hi", 0, ("hh_B", 0.1)), lost)).remarks
    assert told.endswith("line.json: not found in the recording, so the mouth rests: there")
    with pytest.raises(ScheduleError, match="no word was found in the recording; align"):
        read("line.json", gentle(lost))


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ({"case": "success", "word": "x", "start": 0}, "a word has no list of phones; the form is"),
        (aligned("x", "0.1s", ("hh", 0.1)), "'0.1s' is not a time; times are finite numbers"),
        (aligned("x", float("nan"), ("hh", 0.1)), "nan is not a time"),
        (aligned("x", 0, ("hh", float("inf"))), "inf is not a time"),
        (aligned("x", 0, ("hh", 10**400)), "1000.* is not a time"),
        (aligned("x", 0, ("hh", -0.1)), "0 to -0.1 s, ends before it starts"),
        (aligned("x", [], ("hh", 1)), "list is not a time"),
    ],
)
def test_times_that_are_none_are_refused(read, word, told):
    with pytest.raises(ScheduleError, match=told):
        read("line.json", gentle(word))


# Files of others


def test_every_file_of_labels_is_read_or_refused_with_its_reason(data):
    folder = data / "alignments"
    read = {
        "english_hts/*.lab": 40,
        "polyglotdb/buckeye/*.phones": 25,
        "polyglotdb/timit/*.PHN": 43,
        "polyglotdb/partitur/*": 19,
    }
    for pattern, count in read.items():
        paths = sorted(folder.glob(pattern))
        assert paths
        assert {len(ll.read_schedule(path)) for path in paths} == {count}
    refused = {
        "mfa_tests/lab/*.lab": "is a transcript without times",
        "polyglotdb/buckeye/*.words": "has timed words only",
        "polyglotdb/timit/*.WRD": "has timed words only",
    }
    for pattern, reason in refused.items():
        paths = sorted(folder.glob(pattern))
        assert paths
        for path in paths:
            with pytest.raises(ScheduleError, match=reason):
                ll.read_schedule(path)


def test_japanese_full_contexts_are_performed(data):
    performer = ll.resolve("japanese", "facefx")
    paths = sorted((data / "alignments" / "japanese_hts").glob("*.lab"))
    assert paths
    for path in paths:
        schedule = ll.read_schedule(path)
        assert schedule.labels[0] == schedule.labels[-1] == "sil"
        assert performer.perform(schedule).weights.any()


def test_words_of_corpora_are_found(data):
    folder = data / "alignments" / "polyglotdb"
    words = {
        "buckeye/test.phones": "that's that's that whatever they call it",
        "timit/test.PHN": "she had your dark suit in greasy wash water all year",
        "partitur/partitur_test.par,2": "wer möchte keinen Kuchen",
    }
    for name, text in words.items():
        schedule = ll.read_schedule(folder / name)
        assert " ".join(word.text for word in schedule.words) == text


def test_english_corpora_are_performed(data):
    performer = ll.resolve("english", "facefx")
    folder = data / "alignments"
    names = ("polyglotdb/buckeye/test.phones", "polyglotdb/timit/test.PHN")
    for name in (*names, "english_hts/arctic_a0009_phone.lab"):
        assert performer.perform(ll.read_schedule(folder / name)).weights.any()
