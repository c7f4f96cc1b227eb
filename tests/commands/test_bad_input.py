"""Common mistakes: every message names the problem, its place and its remedy."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from lanes import full, needs_espeak
from packs_tree import POSESET, plant, put
from shipped import LIBRARY
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.base.errors import (
    LipsyncError,
    ModelError,
    OutputError,
    PackError,
    ScheduleError,
    SpeechError,
    shortlist,
)
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.resolver.settings import motion_with
from lipsync_lang.schedules.readers.textgrid import read_textgrid
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.text.phonology.espeak.process import EspeakProcess


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


@pytest.fixture
def read(tmp_path):
    """Read JSON as a schedule; values other than bytes are converted to JSON first."""

    def from_json(document):
        path = tmp_path / "line.json"
        content = document if isinstance(document, bytes) else json.dumps(document).encode()
        path.write_bytes(content)
        return ll.read_schedule(path, read_as="json")

    return from_json


def rows(*triples):
    return [{"label": label, "start": a, "end": b} for label, a, b in triples]


# Names


@pytest.mark.parametrize(
    ("language", "character", "message"),
    [
        ("englsh", "facefx", "unknown language 'englsh': did you mean 'english'"),
        ("qqqq", "facefx", "unknown language 'qqqq': known: .*english"),
        ("", "facefx", "unknown language '': known: "),
        ("../english", "facefx", "unknown language '../english': "),
        ("common", "facefx", "unknown language 'common'"),
        ("english", "facfx", "unknown character 'facfx': did you mean 'facefx'"),
        ("english", "posesets/facefx", "unknown character "),
        ("english", "", "unknown character '': known: .*facefx"),
    ],
)
def test_unknown_names_are_told_with_the_nearest(language, character, message):
    with pytest.raises(PackError, match=message):
        ll.resolve(language, character)


@needs_espeak
@pytest.mark.parametrize(
    ("language", "name"),
    [
        ("maltese", "mt"),
        ("mt", "mt"),
        ("MT", "mt"),
        ("haw", "haw"),
        ("irish", "ga"),
        ("latin", "la"),
    ],
)
def test_a_language_without_a_pack_is_told_with_its_voice(language, name):
    with pytest.raises(PackError, match=f"'{language}'; 'espeak:{name}' works without one"):
        ll.resolve(language, "facefx")


def test_without_a_voice_the_known_languages_are_told(monkeypatch):
    def voices(_):
        raise SpeechError("no eSpeak NG")

    monkeypatch.setattr(EspeakProcess, "voices", voices)
    with pytest.raises(PackError, match="unknown language 'maltese'"):
        ll.resolve("maltese", "facefx")


@pytest.mark.parametrize("name", ["face.fbx", "FACE.BLEND", "face.obj", "face.ma"])
def test_a_model_of_another_format_is_told_how_to_export_it(name, tmp_path):
    (tmp_path / name).write_bytes(b"Kaydara FBX Binary")
    with pytest.raises(ModelError, match=r"export the model as GLB .* or VRM"):
        ll.resolve("english", str(tmp_path / name))


def test_an_avatar_in_vrm_stands_in_place_of_a_character(tmp_path):
    model = glb(tmp_path / "face.vrm", *LIBRARY.poseset("vrm").model.poses)
    assert ll.resolve("english", str(model)).compiled.poseset == "vrm"


def test_an_unknown_pose_is_told_with_the_nearest(performer):
    animation = performer.perform(ll.Schedule(("AH",), [0, 0.1]))
    with pytest.raises(LipsyncError, match="unknown pose 'opne'; did you mean 'open'"):
        animation["opne"]


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ("QZ", r"phoneme 1 \('QZ', 0.1 to 0.2 s\) is not in the arpabet of english; did you .*'Q'"),
        ("hello", r"phoneme 1 \('hello', 0.1 to 0.2 s\) .* known: AA, "),
        ("\x1b[2J", r"phoneme 1 \('\\x1b\[2J', 0.1 to 0.2 s\)"),
        ("ʘ", r"phoneme 1 \('ʘ', 0.1 to 0.2 s\)"),
    ],
)
def test_an_unknown_label_is_told_with_index_time_and_the_nearest(label, message, read, performer):
    schedule = read(rows(("HH", 0, 0.1), (label, 0.1, 0.2), ("AH0", 0.2, 0.3)))
    with pytest.raises(ScheduleError, match=rf"line.json: {message}") as caught:
        performer.perform(schedule)
    assert "Add the labels to english's notations" in str(caught.value)
    assert replace(performer, unknown="rest").perform(schedule).weights.any()


def test_an_unknown_label_of_a_textgrid_is_told_likewise(tmp_path, performer):
    text = (
        'File type = "ooTextFile"\nObject class = "TextGrid"\n\n0\n0.3\n<exists>\n1\n'
        '"IntervalTier"\n"phones"\n0\n0.3\n2\n0.1\n0.2\n"HH"\n0.2\n0.3\n"OWW"\n'
    )
    path = tmp_path / "line.TextGrid"
    path.write_text(text)
    message = r"line.TextGrid:16: phoneme 2 \('OWW', 0.2 to 0.3 s\) .*arpabet.*did you mean 'OW'"
    with pytest.raises(ScheduleError, match=message):
        performer.perform(ll.read_schedule(path))
    with pytest.raises(ScheduleError, match=r"line.TextGrid: no tier looks like phones"):
        read_textgrid(TimingFile(path, path.read_bytes().replace(b"phones", b"tones")))


def test_many_unknown_labels_are_a_screenful(performer):
    schedule = ll.Schedule(("??",) * 50, np.arange(51) / 10)
    with pytest.raises(ScheduleError, match=r"phoneme 7 .*\n\.\.\. and 42 more\n"):
        performer.perform(schedule)


def test_two_faults_of_a_pack_are_told_at_once_with_their_places(tmp_path, cli, monkeypatch):
    plant(tmp_path)
    monkeypatch.chdir(tmp_path)
    broken = POSESET.replace("priority: [open, FV", "priority: [opne, FV").replace(
        "{FV: 0.9}", "{FW: 0.9}"
    )
    put(tmp_path, "posesets/face/poseset.yaml", broken)
    for command in (
        ["resolve", "-l", "parent", "-c", "face"],
        ["run", "moi", "-l", "parent", "-c", "face"],
        ["validate", "posesets"],
    ):
        ended = cli(*command)
        assert ended.code == 1, command
        told = ended.err + ended.out
        assert re.search(r"posesets/face/poseset.yaml:15:12: P201 .*'opne'", told), told
        assert re.search(r"posesets/face/poseset.yaml:\d+:\d+: P201 .*'FW'", told), told
        assert "did you mean 'open'" in told


def test_a_name_without_end_is_cut_out_of_a_message_but_no_fault_of_many():
    told = str(ScheduleError(f"line.json: phoneme 0 ('{'a' * 10**6}') has no length; leave it out"))
    assert len(told) < 5_000
    assert told.startswith("line.json: phoneme 0 ('aaa")
    assert told.endswith("aaa') has no length; leave it out")
    many = [Fault("a.yaml", line, 1, "P001", "a fault") for line in range(1, 1000)]
    assert str(PackFaults(many)).count("P001") == 999


# Text


@needs_espeak
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "there is no text to speak; write at least one word"),
        (" \n\t ", "there is no text to speak; write at least one word"),
        ("xy" * 25_001, "the text has 50002 characters, more than 50000; speak it line by line"),
    ],
    ids=lambda text: text[:12],
)
def test_text_without_sound_is_refused(text, message):
    with pytest.raises(SpeechError, match=message):
        ll.speak(text, "english")


@needs_espeak
@pytest.mark.parametrize(
    "text", ["I 😀 you", "привет", "你好", "a\0b", "<b>bold</b>", "ok 😀", "x" * 60, "\udc80 hi"]
)
def test_odd_text_is_spoken_or_refused_in_words(text, performer):
    try:
        schedule = ll.speak(text, "english")
    except SpeechError as error:
        assert "; " in str(error)  # noqa: PT017 both ends are right
    else:
        animation = replace(performer, unknown="rest").perform(schedule)
        assert np.isfinite(animation.weights).all()


@full
@needs_espeak
def test_ten_thousand_characters_are_spoken(performer):
    text = ("Please buy five more maps before Bob moves away. " * 205)[:10_000]
    schedule = ll.speak(text, "english")
    animation = performer.perform(schedule, fps=30)
    assert len(schedule.words) > 1800
    assert animation.weights.shape[0] > 30 * 400


def test_a_language_without_a_voice_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    put(tmp_path, "languages/mute.yaml", "kind: language\nformat: 1\nname: mute\ntag: qaa\n")
    with pytest.raises(SpeechError, match="mute has no voice: add a `tts` to its pack, or a `g2p`"):
        ll.speak("hello", "mute")


# Schedules

MISTIMED = [
    ([("HH", 0, 0.1), ("AH", 0.05, 0.2)], r"phoneme 1 \('AH'\) starts at 0.05 s.* overlap. Move"),
    ([("HH", 0.1, 0.2), ("AH", 0, 0.1)], r"phoneme 1 \('AH'\) starts at 0 s.* rows in order"),
    ([("HH", 0, 0.1), ("AH", 0.2, 0.3)], r"phoneme 1 \('AH'\) starts .* a gap. Write silence the"),
    ([("HH", 0.2, 0.1)], r"phoneme 0 \('HH'\), 0.2 to 0.1 s, .* run backwards; put them in order"),
    ([("HH", 0, 0.1), ("AH", 0.1, 0.05), ("B", 0.6, 0.7)], r"phoneme 1 .* backwards"),
    ([("HH", 0, 0.1), ("AH", 0.1, 0.1)], r"phoneme 1 .* no length; give it some time, or leave"),
    ([("HH", 0, float("nan"))], r"phoneme 0 \('HH'\): time is nan; every time must be a finite"),
    ([("HH", 0, float("inf"))], r"phoneme 0 \('HH'\): time is inf; every time must be a finite"),
    ([("HH", float("-inf"), 0)], r"phoneme 0 \('HH'\): time is -inf; every time must be a fin"),
    ([("HH", 0, 10**400)], r"phoneme 0 \('HH'\): time is (inf|1000+); every time must be a finite"),
    (
        [("HH", 0, 80), ("AH", 80, 200), ("L", 200, 290)],
        "its sounds last 90 s each; .* milliseconds",
    ),
    (
        [("HH", 0, 80_000), ("AH", 80_000, 90_000)],
        "reaches 90000 s, more than a day; .* milliseconds",
    ),
    ([("HH", False, True)], r"phoneme 0 \('HH'\): False is not a time; times are numbers of sec"),
    ([("HH", "0", "0.1")], r"phoneme 0 \('HH'\): '0' is not a time; times are numbers of seconds"),
    ([("HH", 0, None)], r"phoneme 0 \('HH'\): None is not a time; times are numbers of seconds"),
    ([("HH", [0], {})], r"phoneme 0 \('HH'\): \[0.*\] is not a time; times are numbers of seconds"),
    ([], "has no phonemes; give at least one, with its start and end"),
]


@pytest.mark.parametrize(("triples", "message"), MISTIMED)
def test_mistimed_schedules_are_refused_with_the_row(triples, message, read):
    with pytest.raises(ScheduleError, match=f"^line: {message}"):
        ll.Schedule.from_intervals(triples, source="line")
    with pytest.raises(ScheduleError, match=rf"line.json: {message}"):
        read(rows(*triples))


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (b"", ":1:1: not JSON: .*; correct the file"),
        (b'[{"label": "HH",}]', r":1:\d+: not JSON: .*; correct the file"),
        (b"[" * 100_000, "is nested too deep"),
        (b'{"phonemes": ' * 50_000, "is nested too deep"),
        (
            '[{"label": "é"}]'.encode("latin-1"),
            r":1: is not UTF-8 or UTF-16 text \(byte 12\); save",
        ),
        ('{"phonemes": 5}'.encode("utf-16"), "has no list of phonemes; the form is "),
        (b"\xff\xd8\xff\xe0", r"is not UTF-8 or UTF-16 text \(byte 0\)"),
        (None, "has no list of phonemes; the form is "),
        (5, "has no list of phonemes; the form is "),
        ({}, "has no list of phonemes; the form is "),
        ({"phonemes": None}, "has no list of phonemes; the form is "),
        ({"phonemes": {"label": "HH"}}, "has no list of phonemes; the form is "),
        (["HH"], "phoneme 0 needs label, start and end; the form is "),
        ([*rows(("HH", 0, 1)), {"label": "AH", "start": 1}], "phoneme 1 needs label, start and"),
        ([{"label": 5, "start": 0, "end": 1}], "phoneme 0 needs label, start and end; the form"),
    ],
    ids=lambda value: str(value)[:24],
)
def test_json_of_another_form_is_refused_with_the_form(document, message, read):
    with pytest.raises(ScheduleError, match=rf"line\.json.*{message}"):
        read(document)


@pytest.mark.parametrize("content", ["", "{}", "[]", "null", '{"name": "package"}'])
def test_json_of_no_known_form_is_told_all_that_there_are(content, tmp_path):
    path = tmp_path / "line.json"
    path.write_text(content)
    with pytest.raises(ScheduleError, match=r"line\.json: has none of the formats that") as caught:
        ll.read_schedule(path)
    assert "\n  json: Phonemes and words" in str(caught.value)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({}, "words must be a list; the form is "),
        ([5], "word 0 needs text, start and end; the form is "),
        ([{"text": "hi", "start": 0}], "word 0 needs text, start and end; the form is "),
        ([{"text": "hi", "start": "0", "end": 1}], r"word 0 \('hi'\): '0' is not a time; times"),
        ([{"text": "hi", "start": None, "end": 1}], r"word 0 \('hi'\): None is not a time; times"),
        ([{"text": "hi", "start": 0, "end": True}], r"word 0 \('hi'\): True is not a time; times"),
        ([{"text": "hi", "start": 0, "end": float("nan")}], r"word 0 \('hi'\): time is nan; every"),
        ([{"text": "hi", "start": 0.1, "end": 0}], r"word 0 \('hi'\), 0.1 to 0 s, .* backwards"),
    ],
)
def test_words_of_another_form_are_refused(words, message, read):
    with pytest.raises(ScheduleError, match=rf"line\.json: {message}"):
        read({"phonemes": rows(("HH", 0, 0.1)), "words": words})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nowhere.json", "nowhere.json: cannot be read: No such file or directory; check the path"),
        ("folder.json", "folder.json: cannot be read: .*; check the path"),
        ("line.odd", r"line.odd: no reader for this suffix; known: .*\.json"),
        ("line", r"line: no reader for this suffix; known: .*\.json"),
        ("", "cannot be read: Is a directory; check the path"),
        ("nul\0.json", "cannot be read: .*embedded null .*; check the path"),
    ],
)
def test_files_that_cannot_be_read_are_told(name, message, tmp_path):
    (tmp_path / "folder.json").mkdir()
    for plain in ("line.odd", "line"):
        (tmp_path / plain).write_text("nothing of the kind")
    with pytest.raises(ScheduleError, match=message):
        ll.read_schedule(tmp_path / name)


def test_a_file_too_large_is_not_read(tmp_path):
    path = tmp_path / "line.json"
    with path.open("wb") as stream:
        stream.truncate(65 * 2**20)
    with pytest.raises(
        ScheduleError, match=r"line.json: is larger than 64 MB; check that it is a schedule"
    ):
        ll.read_schedule(path)


@pytest.mark.parametrize("seconds", [1e-9, 0.005, 0.1, 3, 9])
def test_a_single_phoneme_is_performed(seconds, performer):
    animation = performer.perform(ll.Schedule(("P",), [0, seconds]))
    assert animation["PBM"].max() >= 0.8
    assert not animation.weights[[0, -1]].any()


def test_silence_alone_stays_at_rest(performer):
    animation = performer.perform(ll.Schedule(("_",), [0, 60]))
    assert not animation.weights.any()


@full
def test_a_hundred_thousand_phonemes_are_performed(performer):
    labels = ("P", "AA1", "S", "OW0") * 25_000
    schedule = ll.Schedule(labels, np.arange(100_001) * 0.07)
    animation = performer.perform(schedule, fps=12)
    assert animation.weights.shape[0] == pytest.approx(84_000, abs=20)
    assert np.isfinite(animation.weights).all()


def test_a_notation_the_language_lacks_is_told_with_the_nearest(performer):
    schedule = ll.Schedule(("AH",), [0, 0.1], notation="arpa", source="line")
    with pytest.raises(ScheduleError, match=r"line: english has no notation 'arpa'; .*'arpabet'"):
        performer.perform(schedule)


# Settings and outputs


@pytest.mark.parametrize("fps", [0, -1, float("nan"), float("inf"), 1e9])
def test_rates_nobody_plays_are_refused(fps, performer):
    with pytest.raises(LipsyncError, match="frames per second: give a number from 1 to 1000"):
        performer.perform(ll.Schedule(("AH",), [0, 0.1]), fps=fps)


@pytest.mark.parametrize("value", [True, None, "wide", float("nan"), -0.1, 11, [0.1]])
def test_motion_out_of_range_is_refused(value, performer):
    with pytest.raises(LipsyncError, match=r"motion.window is .*; it is a number from 0 to 10, as"):
        motion_with(performer.motion, {"window": value})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nowhere/a.csv", "a.csv: the folder .*nowhere does not exist; make it first"),
        ("folder.csv", "folder.csv: is a folder; name a file in it"),
        ("file/a.csv", "file/a.csv: cannot be written: Not a directory; name another place"),
        ("a.xyz", "a.xyz: no writer for '.xyz'; use one of .*\\.csv, "),
        ("a", "a: has no suffix; use one of .*\\.csv, "),
        ("nul\0.csv", "cannot be written: .*embedded null .*; name another place"),
        ("a.wav", "no sound to write: here has no audio; speak text in a language with a voice"),
    ],
)
def test_outputs_that_cannot_be_written_are_told(name, message, performer, tmp_path):
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").touch()
    animation = performer.perform(ll.Schedule(("AH",), [0, 0.1], source="here"))
    with pytest.raises(OutputError, match=message):
        animation.save(tmp_path / name)
    assert {p.name for p in tmp_path.iterdir()} == {"folder.csv", "file"}


def test_a_long_list_names_a_few_and_counts_the_others():
    assert shortlist("abc", 3) == "a, b, c"
    assert shortlist("abcdefg", 3) == "a, b, c and 4 more"
    assert shortlist([], 3) == ""
