"""Files with times of words only: reading, repair of rounded times, and phonemes."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from lipsync_lang.base.errors import ScheduleError, SpeechError
from lipsync_lang.cli import main
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.timing import schedules
from lipsync_lang.schedules import SILENCE, LabelRow, Schedule, TimedWord, TimedWords, read_schedule
from lipsync_lang.schedules.timed_words import are_words, timed_words_of
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import timings_of
from lipsync_lang.sound.speech.filling import filled
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines.line_readers import read_lines
from lipsync_lang.text.phonology.g2p import SpokenWord

TABLE = "word,start,end\nmy,0.1,0.3\nmaps,0.3,0.8\n"


def made(*words, **asked):
    source = TimingFile(Path("words.csv"), b"", **asked)
    return timed_words_of(source, [LabelRow(*word) for word in words])


@pytest.mark.parametrize(
    "words",
    [
        [("hi", 0, 0.2), ('<break time="1s"/>', 0.2, 1.2), ("you", 1.2, 1.5)],
        [
            ("hi", 0, 0.2), ("<break", 0.2, 0.5), ('time="1s"', 0.5, 0.9), ("/>", 0.9, 1.2),
            ("you", 1.2, 1.5),
        ],
        [("<speak>hi", 0, 0.2), ('<break time="1s"/>', 0.2, 0.2), ("you</speak>", 1.2, 1.5)],
        [("hi<break", 0, 0.2), ('time="1s"/>you', 1.2, 1.5)],
    ],
)  # fmt: skip
def test_markup_among_the_words_is_not_said(words):
    assert spans(made(*words)) == [("hi", 0, 0.2), ("you", 1.2, 1.5)]


def test_signs_that_are_no_markup_stay():
    words = [("I", 0, 0.1), ("<3", 0.1, 0.2), ("a<b", 0.2, 0.3), ("<now", 0.3, 0.4)]
    assert [word.text for word in made(*words).words] == ["I", "<3", "a<b", "<now"]


def spans(timed):
    return [(word.text, round(word.start, 4), round(word.end, 4)) for word in timed.words]


def test_words_are_put_in_order_and_rounded_boundaries_meet():
    words = made((" maps\n", 0.392, 0.8, None, 0.9), ("my", 0.1, 0.4), ("", 0.8, 0.9), rate=1.0)
    assert spans(words) == [("my", 0.1, 0.396), ("maps", 0.396, 0.8)]
    assert words.words[1].confidence == 0.9
    assert spans(made(("my", 100, 400), rate=1000)) == [("my", 0.1, 0.4)]


def test_a_word_without_length_shares_the_time_of_its_neighbour():
    assert spans(made(("a", 0.2, 0.2), ("map", 0.2, 0.5))) == [("a map", 0.2, 0.5)]
    assert spans(made(("map", 0.2, 0.5), ("a", 0.5, 0.5))) == [("map a", 0.2, 0.5)]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([("a", 0.2, 0.2), ("map", 1, 1.5)], [("a map", 1, 1.5)]),
        ([("map", 0.2, 0.5), ("a", 0.6, 0.6), ("m", 2, 3)], [("map a", 0.2, 0.5), ("m", 2, 3)]),
        ([("map", 0.2, 0.5), ("a", 1.9, 1.9), ("m", 2, 3)], [("map", 0.2, 0.5), ("a m", 2, 3)]),
        ([("a", 0.2, 0.2), ("s", 1, 1), ("map", 2, 3)], [("a s map", 2, 3)]),
        ([("map", 0.2, 0.5), ("a", 4, 4), ("s", 5, 5)], [("map a s", 0.2, 0.5)]),
    ],
)
def test_a_word_without_length_stretches_no_neighbour_across_a_gap(words, said):
    assert spans(made(*words)) == said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([("", 0, 1)], "has no words"),
        ([("a", 0, 0.5), ("b", 0.4, 0.9, 7)], "csv:7: 'b', 0.4 to 0.9 s, starts before 'a'"),
        ([("a", 0.5, 0.2, 3)], "csv:3: 'a', 0.5 to 0.2 s, ends before it starts"),
        ([("a", -1, 0.2)], "starts below 0"),
        ([("a", 0.3, 0.3)], "has no length"),
    ],
)
def test_words_at_odd_times_are_refused_with_their_line(words, message):
    with pytest.raises(ScheduleError, match=message):
        made(*words)


def test_a_table_and_a_tier_of_words_are_timed_words(tmp_path):
    found = timings_of(TimingFile(Path("words.csv"), TABLE.encode()))
    assert spans(found) == [("my", 0.1, 0.3), ("maps", 0.3, 0.8)]
    tiers = 'File type = "ooTextFile"\nObject class = "TextGrid"\n0 1 <exists> 1\n'
    tiers += '"IntervalTier" "{}" 0 1 3 0 0.1 "" 0.1 0.8 "maps" 0.8 1 "<sil>"\n'
    for name, tier in (("words", None), ("Ann - words", None), ("Ann - words", "Ann")):
        grid = TimingFile(Path("a.TextGrid"), tiers.format(name).encode(), tier)
        assert spans(timings_of(grid)) == [("maps", 0.1, 0.8)]
    sentence = tiers.format("notes").replace("maps", "my maps").encode()
    grid = TimingFile(Path("a.TextGrid"), sentence, "notes")
    assert spans(timings_of(grid))[0] == ("my maps", 0.1, 0.8)
    (tmp_path / "words.csv").write_text(TABLE)
    with pytest.raises(ScheduleError, match=r"has timed words only.*fill_words"):
        read_schedule(tmp_path / "words.csv")


class Reader(Speaker):
    """A language whose words are read letter by letter; texts in `joined` become one word."""

    joined = ()

    def _read(self, texts):
        return [tuple(self._words(text)) for text in texts]

    def _words(self, text):
        for word in [text] if text in self.joined else text.split():
            known = {"m": "m", "a": "æ", "p": "p", "s": "s"}
            labels = tuple(known[c] for c in word if c in known)
            yield SpokenWord(word, labels) if labels else SpokenWord(word, (), unread=word)


@pytest.fixture(scope="module")
def speaker():
    english = Speaker.of("english")
    return Reader(english.manner, english.notations)


def test_phonemes_fill_each_word_and_silence_what_is_between(speaker):
    words = made(("pa", 0.1, 0.3), ("maps", 0.3, 0.8), ("=", 1.0, 1.2), ("ma", 1.5, 1.8, None, 0.7))
    schedule = filled(speaker, words)
    labels = (SILENCE, "p", "æ", "m", "æ", "p", "s", SILENCE, "m", "æ")
    assert schedule.labels == labels
    edges = [(schedule.times[w.first], schedule.times[w.stop]) for w in schedule.words]
    np.testing.assert_allclose(edges, [(0.1, 0.3), (0.3, 0.8), (1.5, 1.8)])
    assert [w.confidence for w in schedule.words] == [None, None, 0.7]
    told, mute = schedule.remarks
    assert told.endswith("the phonemes are estimated within each word")
    assert mute.endswith("words that cannot be read: '='")
    assert schedule.language == "english"


def test_words_that_the_reader_joins_are_read_one_by_one(speaker):
    words = made(("ma", 0.1, 0.3), ("pa", 0.3, 0.8))
    apart = filled(speaker, words)
    joining = Reader(speaker.manner, speaker.notations)
    joining.joined = ("ma pa",)
    assert filled(joining, words).labels == apart.labels
    assert [w.text for w in filled(joining, words).words] == ["ma", "pa"]


def test_a_subtitle_holds_several_words(speaker):
    schedule = filled(speaker, TimedWords((TimedWord("ma, pa maps", 1.0, 2.0),), "line.srt"))
    assert [w.text for w in schedule.words] == ["ma,", "pa", "maps"]
    assert (schedule.times[1], schedule.end) == (1.0, 2.0)
    with pytest.raises(SpeechError):
        filled(speaker, made(("=", 0.1, 0.3)))


def test_an_aligned_phrase_keeps_the_given_boundaries(speaker, monkeypatch):
    from lipsync_lang.schedules.schedule import Audio, Word
    from lipsync_lang.sound.speech import filling

    sound = Audio(np.zeros(16000, np.int16), 16000)
    cuts = []

    def found(_, recordings):
        for audio, _ in recordings:
            cuts.append(audio.seconds)
            yield Schedule(
                ("m", "æ", "p", "æ"),
                [0, 0.1, 0.4, 0.5, 0.6],
                (Word("ma", 0, 2), Word("pa", 2, 4)),
                notation=speaker.manner.notation,
                confidence=0.9,
            )

    monkeypatch.setattr(filling, "align_many", found)
    schedule = filled(speaker, made(("ma", 0.2, 0.4), ("pa", 0.4, 0.8)), audio=sound)
    np.testing.assert_allclose(schedule.times, [0, 0.2, 0.25, 0.4, 0.6, 0.8])
    assert cuts == [pytest.approx(0.7)]
    assert schedule.audio is sound
    assert schedule.remarks[0].endswith("aligned with the recording within each word")


def test_words_are_performed_by_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("words.csv").write_text(TABLE)
    line = ["run", "--schedule", "words.csv", "-l", "english", "-c", "facefx", "-o", "line.csv"]
    assert main(line) == 0
    assert "words.csv has times of words, but not of phonemes" in capsys.readouterr().err
    assert main([*line, "--notation", "ipa"]) == 2
    assert "leave out --notation" in capsys.readouterr().err


def test_labels_too_long_for_phones_are_words():
    assert are_words(["你", "好"])
    assert are_words(["안녕", "네"])
    assert not are_words(["tɕʰ", "aː˨˩˦", "spn", "ŋ", "AE1", "sil"])
    assert not are_words(["sil", ""])


def test_of_two_speakers_words_one_is_asked_for():
    rows = "Begin,End,Label,Type,Speaker\n0,1,maps,words,Ann\n0,1,moon,words,Bob\n"
    source = TimingFile(Path("a.csv"), rows.encode())
    with pytest.raises(ScheduleError, match="2 tiers hold words: 'Ann - words', 'Bob - words'"):
        timings_of(source)
    assert spans(timings_of(replace(source, tier="Bob"))) == [("moon", 0, 1)]


def test_a_script_of_timed_words_is_counted_by_its_text(tmp_path):
    (tmp_path / "words.csv").write_text(TABLE)
    (line,) = read_lines(tmp_path / "words.csv", remark=lambda _: None)
    assert (line.text, line.schedule, line.name) == ("my maps", None, "words")


def test_a_build_fills_the_timed_words_of_a_line(tmp_path, speaker):
    (tmp_path / "a.csv").write_text("word,start,end\nma,0.1,0.3\n")
    line = PlannedLine("a", "english", "facefx", "", "", "script.csv:2", "a.csv", None, ())
    (made,) = schedules(tmp_path, [line], SimpleNamespace(speaker=speaker))
    assert made.labels == (SILENCE, "m", "æ")
