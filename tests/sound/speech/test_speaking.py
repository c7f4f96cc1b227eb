"""Reading and speaking text: estimated times, joined times, and words with their own sound."""

import json
import tracemalloc
from textwrap import dedent

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, needs_plug_ins, swept

from lipsync_lang import SpeechError, resolve, speak
from lipsync_lang.authoring.printing import transcript_table
from lipsync_lang.packs.library import Library
from lipsync_lang.schedules import Schedule
from lipsync_lang.sound.speech.speaking.joining import estimate, join
from lipsync_lang.sound.speech.speaking.speaker import Speaker, transcribe
from lipsync_lang.sound.speech.speaking.transcripts import Transcript
from lipsync_lang.text.phonology.align import BAND_SOUNDS, align
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.labels import Notation
from lipsync_lang.text.phonology.manner import Manner

KINDS = {**dict.fromkeys(("ah", "ih", "ow"), "vowel"), "d": "stop", "s": "fricative",
         "sh": "fricative"}  # fmt: skip
DURATIONS = {"vowel": 0.1, "stop": 0.05, "fricative": 0.08, "affricate": 0.12, "silence": 0.3}
TABLE = {"a": ("ah",), "i": ("ih",), "o": ("ow",), "t": ("d",), "s": ("s",), "ts": ("d", "s"),
         "ai": ("ah", "ih"), "mute": ()}  # fmt: skip
NOTATION = Notation({label: tuple((s, 1 / len(to)) for s in to) for label, to in TABLE.items()})
MANNER = Manner("test", "rules", notation="ipa", kinds=KINDS, durations=DURATIONS)

RULED = """\
    kind: language
    format: 1
    name: ruled
    tag: qaa
    g2p: {engine: rules, rules: [{from: x, to: [k, s]}, {from: q, to: []}]}
    durations: {vowel: 0.2}
    notations: {ipa: {a: ah, k: kg, s: s, t: d, m: bmp}}
    words: {Taxa: [d, ow]}
    """


@pytest.fixture
def ruled(tmp_path):
    """A folder with a language that no voice speaks."""
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages" / "ruled.yaml").write_text(dedent(RULED), "utf-8")
    return tmp_path


def transcript(*words, unread=()):
    """A transcript of words given as text and labels."""
    said = tuple(SpokenWord(text, tuple(labels.split())) for text, labels in words)
    text = " ".join(text for text, _ in words)
    return Transcript(text, "test", "ipa", said, unread=unread)


# Alignment


@pytest.mark.parametrize(
    ("said", "heard", "found"),
    [
        ("d ah s", "d ah s", [0, 1, 2]),
        ("d ah s", "_ d ih sh _", [-1, 0, 1, 2, -1]),
        ("d ah s", "d s", [0, 2]),
        ("d s", "d ah s", [0, -1, 1]),
        ("d ah _ s", "d ah _ s", [0, 1, 2, 3]),
        ("d _ s", "d s", [0, 2]),
        ("", "d", [-1]),
        ("d", "", []),
    ],
)
def test_sounds_are_found_in_each_other(said, heard, found):
    assert align(said.split(), heard.split(), KINDS, "_").tolist() == found


sounds = st.lists(st.sampled_from([*KINDS, "_"]), max_size=30)


@given(sounds, sounds)
def test_an_alignment_rises_and_pauses_meet_only_pauses(said, heard):
    found = align(said, heard, KINDS, "_")
    taken = found[found >= 0]
    assert len(found) == len(heard)
    assert (np.diff(taken) > 0).all()
    assert all((said[i] == "_") == (heard[j] == "_") for j, i in enumerate(found) if i >= 0)


@given(sounds)
def test_what_is_the_same_is_found_where_it_is(said):
    assert align(said, said, KINDS, "_").tolist() == list(range(len(said)))


def test_long_texts_are_aligned_in_a_band():
    said = [name for _ in range(500) for name in ("d", "ah", "s", "ih", "sh", "ow")]
    heard = [name for number, name in enumerate(said) if number % 17]
    found = align(said, heard, KINDS, "_")
    assert np.mean([i >= 0 and said[i] == heard[j] for j, i in enumerate(found)]) > 0.99


# Joining


def schedule(text):
    """A schedule a tenth of a second per label."""
    labels = text.split()
    return Schedule(tuple(labels), np.arange(len(labels) + 1) / 10, notation="ipa")


def rows(joined):
    """Labels and their times, in tenths."""
    return [(label, *(float(round(10 * t, 3)) for t in joined.times[i : i + 2])) for i, label in
            enumerate(joined.labels)]  # fmt: skip


def test_labels_get_the_times_they_were_heard_at():
    joined = join(transcript(("ta", "t a"), ("so", "s o")), schedule("_ t i s o _"), MANNER,
                  {"ipa": NOTATION})  # fmt: skip
    assert rows(joined) == [("_", 0, 1), ("t", 1, 2), ("a", 2, 3), ("s", 3, 4), ("o", 4, 5),
                            ("_", 5, 6)]  # fmt: skip
    assert [(w.text, w.first, w.stop) for w in joined.words] == [("ta", 1, 3), ("so", 3, 5)]
    assert not joined.estimated


def test_what_the_voice_does_not_say_shares_and_what_it_adds_belongs():
    joined = join(transcript(("tasi", "t a s i")), schedule("t a i o"), MANNER, {"ipa": NOTATION})
    assert rows(joined) == [("t", 0, 1), ("a", 1, 1.5), ("s", 1.5, 2), ("i", 2, 4)]


def test_pauses_are_the_voices():
    joined = join(transcript(("ta", "t a"), (",", ""), ("so", "s o")), schedule("t _ a s o"),
                  MANNER, {"ipa": NOTATION})  # fmt: skip
    assert [label for label, _, _ in rows(joined)] == ["t", "_", "a", "s", "o"]


labels = st.lists(st.sampled_from(["a", "i", "o", "t", "s", "ts", "ai"]), min_size=1, max_size=12)


@given(labels, st.lists(st.sampled_from(["a", "i", "t", "s", "ts", "_"]), min_size=1, max_size=14))
def test_every_label_gets_some_time_in_its_order(said, heard):
    voice = schedule(" ".join(heard))
    if set(heard) == {"_"}:
        return
    joined = join(transcript(("word", " ".join(said))), voice, MANNER, {"ipa": NOTATION})
    assert [label for label in joined.labels if label != "_"] == said
    assert joined.start == voice.start
    assert joined.end == voice.end


def test_nothing_readable_is_a_message():
    with pytest.raises(SpeechError, match=r"'7'; it cannot read 7"):
        join(transcript(("7", ""), unread=("7",)), schedule("t"), MANNER, {"ipa": NOTATION})


# Estimating


def test_times_are_estimated_by_class():
    made = estimate(transcript(("tai", "t ai"), (".", ""), ("tso:", "ts o:"), ("!", "")), MANNER,
                    NOTATION)  # fmt: skip
    assert made.estimated
    assert made.audio is None
    assert list(np.diff(made.times).round(3)) == [0.05, 0.2, 0.3, 0.12, 0.15]
    assert made.labels == ("t", "ai", "_", "ts", "o:")
    assert [w.text for w in made.words] == ["tai", "tso:"]


def test_a_language_without_a_voice_takes_its_own_lengths(ruled):
    made = speak("Kaxa, tam!", "ruled", paths=[ruled])
    assert made.labels == ("k", "a", "k", "s", "a", "_", "t", "a", "m")
    assert made.estimated
    assert made.language == "ruled"
    defaults = Library().common().model.durations
    assert np.diff(made.times)[:2] == pytest.approx([defaults["stop"], 0.2])
    assert made.times[6] - made.times[5] == pytest.approx(defaults["silence"])


@full
def test_a_voice_can_be_left_out():
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    made = speak("Hello, world", "english", engine="none")
    assert made.estimated
    assert [w.text for w in made.words] == ["Hello", "world"]
    heard = [label for label in speak("Hello, world", "english").labels if label != "_"]
    assert [label for label in made.labels if label != "_"] == heard


def test_what_is_not_read_is_named(ruled, cli):
    assert speak("tam 77 & $", "ruled", paths=[ruled]).unread == ("7", "$")
    ended = cli("run", "tam 77", "-l", "ruled", "-c", "facefx", "--path", str(ruled))
    assert ended.code == 0
    assert "times are estimated" in ended.err
    assert "not read: 7" in ended.err
    with pytest.raises(SpeechError, match=r"'77'; it cannot read 7"):
        speak("77", "ruled", paths=[ruled])


def test_transcribe_names_what_is_not_spoken(ruled, cli):
    ended = cli("transcribe", "tam {who} 77 www.tam.com", "-l", "ruled", "--path", str(ruled))
    assert ended.code == 0
    assert "tam 77: not read: 7\n" in ended.err
    assert "tam 77: not spoken: {who} www.tam.com\n" in ended.err


# Words with a sound of their own


def test_a_packs_own_words_override_its_engine(ruled):
    (heard,) = transcribe(["taxa taxata"], "ruled", paths=[ruled])
    assert heard.phonemes == ("d", "ow", "d", "ah", "kg", "s", "ah", "d", "ah")
    performer = resolve("ruled", "facefx", paths=[ruled])
    made = performer.speaker.speak("taxa")
    ids, _, _ = performer.common_phonemes(made)
    assert [performer.compiled.phonemes[i] for i in ids] == ["d", "ow"]


@full
def test_a_character_says_words_its_own_way(ruled):
    folder = ruled / "characters"
    folder.mkdir()
    (folder / "bo.yaml").write_text(dedent("""\
        kind: character
        format: 1
        name: bo
        poseset: facefx
        pronunciations: {ruled: {Tam: [bmp, ah]}}
        """), "utf-8")  # fmt: skip
    own, plain = (resolve("ruled", who, paths=[ruled]) for who in ("bo", "facefx"))
    (heard,) = own.speaker.transcribe(["tam taxa"])
    assert heard.phonemes == ("bmp", "ah", "d", "ow")
    (heard,) = plain.speaker.transcribe(["tam"])
    assert heard.phonemes == ("d", "ah", "bmp")


@full
def test_words_that_an_engine_runs_together_are_told_apart_to_be_overridden(tmp_path):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages" / "own.yaml").write_text(dedent("""\
        kind: language
        format: 1
        name: own
        tag: qaa
        extends: english
        words: {end: [bmp]}
        """), "utf-8")  # fmt: skip
    (merged,) = transcribe(["out of the end"], "english")
    (apart,) = transcribe(["out of the end"], "own", paths=[tmp_path])
    assert [word.text for word in merged.words] == ["out of the end"]
    assert merged.phonemes[-3:] == ("eh", "n", "d")
    assert apart.phonemes == (*merged.phonemes[:-3], "bmp")


def test_labels_that_nothing_maps_are_named(ruled):
    speaker = Speaker.of("ruled", [ruled])
    odd = Speaker(speaker.manner, {"ipa": Notation({"a": (("ah", 1.0),)})})
    (heard,) = odd.transcribe(["kaxa"])
    assert heard.unmapped == ("k", "s")


def test_a_manner_comes_back_from_json(ruled):
    manner = Speaker.of("ruled", [ruled]).manner
    again = Manner.from_plain(json.loads(json.dumps(manner.plain())))
    assert again == manner
    plain = Manner.from_plain(json.loads(json.dumps(Speaker.of("english").manner.plain())))
    assert plain.voice == ("espeak", "en-us")
    assert plain.direct


def test_a_language_that_reads_nothing_says_what_to_do(tmp_path):
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages" / "mute.yaml").write_text(
        "kind: language\nformat: 1\nname: mute\ntag: qaa\nnotations: {ipa: {a: aa}}\n"
    )
    with pytest.raises(
        SpeechError,
        match=r"mute has no voice.*`tts`.*"
        r"`g2p`",
    ):
        speak("a", "mute", paths=[tmp_path])
    with pytest.raises(SpeechError, match=r"mute does not read text.*`g2p`"):
        list(transcribe(["a"], "mute", paths=[tmp_path]))


def test_transcripts_are_printed_and_are_data(cli, ruled):
    ended = cli("transcribe", "taxa, qaka", "-l", "ruled", "--path", str(ruled))
    assert ended.out.splitlines() == [
        "word  ipa        common phonemes",
        "taxa  t a k s a  d ow",
        ",",
        "qaka  a k a      ah kg ah",
    ]
    told = json.loads(cli("transcribe", "7ma", "-l", "qaa", "--path", str(ruled), "--json").out)
    assert told[0]["phonemes"] == ["bmp", "ah"]
    assert told[0]["unread"] == ["7"]
    file = ruled / "lines.txt"
    file.write_text("ka\n\nma\n", "utf-8")
    lines = cli("transcribe", "--file", str(file), "-l", "ruled", "--path", str(ruled))
    assert lines.out.count("common phonemes") == 2
    assert cli("transcribe", "-l", "ruled", "--path", str(ruled)).code == 2


def test_what_is_mapped_automatically_says_what_it_loses(ruled):
    file = ruled / "languages" / "ruled.yaml"
    file.write_text(file.read_text("utf-8").replace("tag: qaa", "tag: qaa\nautomatic: true"))
    speaker = Speaker.of("ruled", [ruled])
    told = speaker.to_json(
        Transcript("tʼap", "ruled", "ipa", (SpokenWord("tʼap", ("tʼ", "a", "p")),))
    )
    assert told["automatic"] == {
        "tʼ": {"common": ["d"], "distance": 0, "loses": ["ejection"]},
        "p": {"common": ["bmp"], "distance": 0, "loses": []},
    }
    lines = transcript_table(told).splitlines()
    assert lines[-2:] == [
        "2 labels mapped automatically; these are not exact:",
        "  tʼ  d  loses ejection",
    ]


@needs_plug_ins
def test_a_hebrew_voice_speaks_the_sounds_of_the_guessed_points():
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    schedule = speak("בעולמות", "hebrew")
    assert "".join(label for label in schedule.labels if label != "_").endswith("ʔolamot")
    assert resolve("hebrew", "facefx").perform(schedule).weights.any()


PAUSING = [(" - ", " "), (" -- ", " "), ("—", " "), (" (", ") "), (' "', '" '), (" '", "' "),
           (" “", "” "), (" ", "; "), (" / ", " … "), ("-", " ")]  # fmt: skip
"""Signs before and after a word."""


@pytest.mark.parametrize("language", swept(["english", "german", "russian"]))
def test_pauses_at_dashes_brackets_and_quotes_are_those_of_the_voice(language):
    texts = [f"papa{left}mama{right}papa" for left, right in PAUSING]
    said = [transcript.words for transcript in transcribe(texts, language)]
    spoken = list(speak(texts, language))
    for words, schedule in zip(said, spoken, strict=True):
        read = [label for word in words for label in word.labels or ["_"]]
        assert read == list(schedule.labels[1:-1])
    assert sum("_" in schedule.labels[1:-1] for schedule in spoken) > len(texts) / 2


def test_long_texts_are_aligned_in_little_more_memory_than_a_byte_for_each_move():
    said = [f"{number * number % 7}" for number in range(4000)]
    table = len(said) * (2 * BAND_SOUNDS + 1)
    peaks = []
    for _ in range(3):  # threads of earlier tests may take memory beside it
        tracemalloc.start()
        found = align(said, said, {}, "_")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert found.tolist() == [*range(len(said))]
    assert min(peaks) < 1.2 * table, "names and costs take as much as the packed moves"
