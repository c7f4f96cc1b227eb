"""Many texts at once: the same results as one by one, even if some fail."""

import os
import sys
from dataclasses import replace
from itertools import count, islice

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import Schedule
from lipsync_lang.sound.speech import ENGINES, speak_many
from lipsync_lang.sound.speech.results import BATCH_TEXTS
from lipsync_lang.sound.speech.speaking.espeak import MAX_ESPEAK_CHARS, Espeak
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.espeak import espeak_stream
from lipsync_lang.text.phonology.espeak.espeak_stream import TEXTS_AHEAD, close_idle
from lipsync_lang.text.phonology.espeak.process import WORKER
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES
from lipsync_lang.text.phonology.labels import Notation
from lipsync_lang.text.phonology.manner import Manner

needs_fork = pytest.mark.skipif(sys.platform == "win32", reason="no process can be forked there")

LETTERS = Notation({letter: ((letter, 1.0),) for letter in "abcdefghijklmnopqrstuvwxyz"})
MANNER = Manner(
    "letters",
    "spelling",
    notation="ipa",
    voice=("beeps", "high"),
    durations={"stop": 0.1, "silence": 0.2, "affricate": 0.1},
)
TEXTS = ["", "moi", "a b", "no!", "why?", "*stop* it", "no!", "so? what!", "\0", "z" * 2000, "moi"]


class Beeps:
    """A speech engine with a tenth of a second for each letter, which fails at `!`."""

    def speak(self, text, voice, *, words_per_minute=None):
        """Speak a text."""
        assert words_per_minute is None
        labels = tuple(filter(str.isalpha, text))
        if "!" in text or not labels:
            raise SpeechError(f"{voice} beeps cannot say '{text}'")
        return Schedule(labels, np.arange(len(labels) + 1) / 10, notation="ipa")


class Spelling:
    """A G2P engine of letters that fails at `?`, and counts what it reads."""

    calls = texts = 0

    def __call__(self, texts):
        """Read texts."""
        self.calls += 1
        for text in texts:
            self.texts += 1
            if "?" in text:
                raise SpeechError(f"spelling cannot read '{text}'")
            yield [SpokenWord(word, tuple(filter(str.isalpha, word))) for word in text.split()]


@pytest.fixture
def spelling(monkeypatch):
    """Register the engines, and return the engine of letters."""
    made = Spelling()
    monkeypatch.setitem(ENGINES.known, "beeps", Beeps())
    monkeypatch.setitem(G2P_ENGINES.known, "spelling", lambda _settings: made)
    return made


@pytest.fixture
def speaker(spelling):  # noqa: ARG001 registered
    """A speaker of a language that is spelled, and spoken by beeps."""
    return Speaker(MANNER, {"ipa": LETTERS})


def plain(result):
    """Return the values of a result for comparisons."""
    if isinstance(result, SpeechError):
        return str(result)
    audio = result.audio and (hash(result.audio.samples.tobytes()), result.audio.rate)
    return replace(result, audio=None).__repr__(), result.times.tobytes(), result.words, audio


def one_by_one(speaker, texts, **how):
    """Speak each text by itself."""
    for text in texts:
        try:
            yield speaker.speak(text, **how)
        except SpeechError as error:
            yield error


@pytest.mark.parametrize("engine", [None, "none"])
def test_many_are_what_each_is_by_itself(speaker, engine):
    together = [plain(one) for one in speaker.speak_many(TEXTS, engine=engine)]
    assert together == [plain(one) for one in one_by_one(speaker, TEXTS, engine=engine)]
    failed = [isinstance(one, str) for one in together]
    assert failed == [not t.strip("\0") or "?" in t or ("!" in t and not engine) for t in TEXTS]


def test_a_voice_that_also_reads_is_asked_for_nothing_else(spelling):
    direct = replace(MANNER, engine=None)
    found = list(Speaker(direct, {"ipa": LETTERS}).speak_many(["moi", "no!", "a"]))
    assert [one if isinstance(one, SpeechError) else one.language for one in found][::2] == [
        "letters",
        "letters",
    ]
    assert isinstance(found[1], SpeechError)
    assert spelling.calls == 0


def test_an_error_is_raised_at_its_turn_and_the_next_text_is_spoken(speaker, monkeypatch):
    monkeypatch.setattr(Speaker, "of", lambda *_: speaker)
    spoken = ll.speak(iter(["moi", "no!", "a"]), "letters")
    assert next(spoken).labels == tuple("moi")
    with pytest.raises(SpeechError, match="cannot say 'no!'"):
        next(spoken)
    assert next(spoken).labels == ("a",)
    read = ll.transcribe(["why?", "a"], "letters")
    with pytest.raises(SpeechError, match="cannot read"):
        next(read)
    assert next(read).labels == ("a",)


def test_texts_are_read_in_batches_and_a_repeated_one_once(speaker, spelling):
    list(speaker.speak_many([f"moi{chr(97 + n % 20)}" for n in range(2 * BATCH_TEXTS)]))
    assert (spelling.calls, spelling.texts) == (2, 40)


def test_an_engine_that_fails_at_all_is_not_asked_for_each_text(speaker, monkeypatch):
    calls = []

    def broken(texts):
        calls.append(len(texts))
        raise SpeechError("spelling is not installed")

    monkeypatch.setitem(G2P_ENGINES.known, "spelling", lambda _settings: broken)
    found = list(speaker.speak_many([f"a{n}" for n in range(100)]))
    assert [str(one) for one in found] == ["spelling is not installed"] * 100
    assert len(calls) == 2


@pytest.mark.parametrize("engine", [None, "none"])
def test_texts_without_end_are_taken_a_batch_at_a_time(speaker, engine):
    taken = []

    def endless():
        for number in count():
            taken.append(number)
            yield "moi" if number % 2 else "no!"

    spoken = speaker.speak_many(endless(), engine=engine)
    assert taken == []
    for done in range(1, BATCH_TEXTS + 10):
        next(spoken)
        assert len(taken) <= done + BATCH_TEXTS + 1
    spoken.close()


@pytest.mark.parametrize("name", [None, "beeps"])
def test_what_fails_for_all_texts_is_the_error_of_each(speaker, name):
    speaker.manner = replace(MANNER, voice=("nobody", "x") if name is None else None)
    found = list(speaker.speak_many(["a", "b"], engine=name))
    assert [type(one) for one in found] == [SpeechError] * 2
    assert list(speaker.speak_many([], engine=name)) == []


def test_an_engine_that_answers_too_little_is_blamed(speaker, monkeypatch):
    class Lazy(Beeps):
        """A speech engine that speaks the first text alone."""

        def speak_many(self, texts, voice, *, words_per_minute=None):
            """Speak one text."""
            for text in islice(texts, 1):
                yield self.speak(text, voice, words_per_minute=words_per_minute)

    monkeypatch.setitem(ENGINES.known, "beeps", Lazy())
    found = list(speaker.speak_many(["moi", "why?", "a"]))
    assert found[0].labels == tuple("moi")
    assert [str(one)[:10] for one in found[1:]] == ["spelling c", "the engine"]


# eSpeak NG

SPOKEN = [
    "Good morning, everyone, and welcome.", "", "Hello", "你好，世界。", "...", "Hello\0 world",
    "x" * 300, "10,000 of the best", "Hello", "Grüß Gott " * 20,
]  # fmt: skip

FAULTY = f"""
import os, sys, time
sys.path.insert(0, {str(WORKER.parent)!r})
import espeak_worker as worker
speak, many, parent = worker.collect, worker.speak_many, []
def collect(library, text):
    if "abort" in text:
        print("out of order", file=sys.stderr, flush=True)
        os.abort()
    if "hang" in text:
        time.sleep(600)
    if "chatter" in text:
        os.write(2, b"x" * (1 << 20))
    if "kill" in text and parent:
        os.kill(parent[0], 9)
        time.sleep(600)
    if "noise" in text and parent:
        os.write(out.fileno(), b"noise")
    return speak(library, text)
def speak_many(request, stream):
    global out
    out = stream
    parent.append(os.getpid())
    many(request, stream)
worker.collect, worker.speak_many = collect, speak_many
worker.main()
"""


@pytest.fixture
def faulty(tmp_path):
    """A speech engine that crashes, hangs or is killed if the text says so."""
    pytest.importorskip("espeakng_loader")
    worker = tmp_path / "faulty.py"
    worker.write_text(FAULTY, "utf-8")
    return Espeak(worker=worker)


@full
@pytest.mark.parametrize("language", ["english", "mandarin", "japanese", "tagalog"])
@pytest.mark.parametrize("engine", [None, "none"])
def test_real_engines_say_the_same_of_many(language, engine):
    pytest.importorskip("espeakng_loader")
    speaker = Speaker.of(language)
    together = [plain(one) for one in speaker.speak_many(SPOKEN, engine=engine)]
    assert together == [plain(one) for one in one_by_one(speaker, SPOKEN, engine=engine)]
    assert [isinstance(one, str) for one in together][:3] == [False, True, False]


@full
@pytest.mark.parametrize("how", [{}, {"words_per_minute": 250}])
@pytest.mark.parametrize("voice", ["en-us+m2", "de", "cmn-latn-pinyin"])
def test_voices_say_the_same_of_many(voice, how):
    pytest.importorskip("espeakng_loader")
    texts = [*SPOKEN[::2], "x" * (MAX_ESPEAK_CHARS + 1), "Good night " * 200]
    together = list(speak_many(texts, voice, **how))
    alone = [next(speak_many([text], voice, **how)) for text in texts]
    assert list(map(plain, together)) == list(map(plain, alone))


@needs_fork
def test_batches_share_a_worker_until_another_voice_speaks():
    pytest.importorskip("espeakng_loader")
    close_idle()
    engine, workers = Espeak(), []
    for voice in ("en-us", "en-us", "de"):
        first, second = engine.speak_many(["a", "b"], voice)
        assert plain(first) != plain(second)
        assert plain(first) == plain(engine.speak("a", voice)), "as fresh as a first text"
        (stream,) = espeak_stream.IDLE.values()
        workers.append(stream.worker)
    assert workers[0] is workers[1]
    assert [one.poll() is None for one in workers] == [False, False, True]
    left = engine.speak_many(["a", "b"], "de")
    next(left)
    left.close()
    assert not espeak_stream.IDLE, "a worker that owes an answer serves nobody else"
    assert workers[2].poll() is not None


@needs_fork
def test_a_sound_of_several_reads_comes_from_one_worker():
    pytest.importorskip("espeakng_loader")
    engine = Espeak()
    list(engine.speak_many(["a", "b"], "en-us"))
    (stream,) = espeak_stream.IDLE.values()
    long, _ = engine.speak_many(["one two three four five six seven", "b"], "en-us")
    assert long.audio.samples.nbytes > 1 << 16, "more than a pipe holds"
    assert [*espeak_stream.IDLE.values()] == [stream], "it was not lost"


@needs_fork
def test_a_forked_process_has_a_worker_of_its_own():
    pytest.importorskip("espeakng_loader")
    list(Espeak().speak_many(["a", "b"], "en-us"))
    child = os.fork()
    if not child:
        os._exit(len(espeak_stream.IDLE))
    assert os.waitpid(child, 0)[1] == 0
    assert len(espeak_stream.IDLE) == 1


@full
@needs_fork
def test_a_text_that_crashes_or_hangs_is_told_and_the_others_are_spoken(faulty):
    faulty.patience = 10  # a busy machine starts a worker in time
    texts = ["one", "abort", "two", "hang", "three", "chatter", "four"]
    found = dict(zip(texts, faulty.speak_many(texts, "en-us"), strict=True))
    told = {text: str(one) for text, one in found.items() if isinstance(one, SpeechError)}
    assert set(told) == {"abort", "hang"}
    assert "crashed (SIGABRT)" in told["abort"]
    assert "'abort' (out of order)" in told["abort"]
    assert "did not finish within 10 s with 'hang'" in told["hang"]
    assert plain(found["two"]) == plain(faulty.speak("two", "en-us"))


@full
@needs_fork
@pytest.mark.parametrize("fault", ["kill", "noise"])
def test_a_worker_that_is_lost_is_replaced(faulty, fault):
    texts = ["one", f"{fault} it", *(f"number {n}" for n in range(2 * TEXTS_AHEAD))]
    found = list(faulty.speak_many(texts, "en-us"))
    assert list(map(plain, found)) == [plain(faulty.speak(text, "en-us")) for text in texts]


@full
@needs_fork
def test_few_texts_are_taken_ahead_of_speech(faulty):
    faulty.patience = 10  # a busy machine starts a worker in time
    texts = iter([f"number {n}" for n in range(100)])
    spoken = faulty.speak_many(texts, "en-us")
    next(spoken)
    spoken.close()
    assert 1 < len(list(texts)) - (100 - TEXTS_AHEAD - 2) < TEXTS_AHEAD


@full
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"python": "nothing/python"}, "cannot be started"),
        ({"voice": "qqq"}, "no voice 'qqq'"),
        ({"voice": "en-us+qqq"}, "no voice variant 'qqq'"),
        ({"script": "import os; os.abort()"}, "crashed|ended with code"),
        ({"script": "print('hello')"}, "an unreadable answer|ended with code 0"),
        ({"script": "import time; time.sleep(600)", "patience": 0.5}, "did not finish within"),
    ],
)
def test_an_engine_that_does_not_start_is_the_error_of_all(faulty, change, message):
    change = dict(change)
    voice = change.pop("voice", "en-us")
    if script := change.pop("script", ""):
        faulty.worker.write_text(script, "utf-8")
    found = list(replace(faulty, **change).speak_many(["one", "", "two", "three"], voice))
    assert "no text to speak" in str(found.pop(1))
    assert all(isinstance(one, SpeechError) for one in found)
    assert len(set(map(str, found))) == 1
    with pytest.raises(SpeechError, match=message):
        raise found[0]
