"""A line with music before or after it is searched without that sound, too."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, swept

import lipsync_lang as ll
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.sound.speech import sound as speech_sound
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.hearing.sphinx import features, line_search
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    FRAME_SECONDS,
    HOP_SAMPLES,
    PreparedSound,
    voice_span,
)
from lipsync_lang.sound.speech.hearing.sphinx.line_search import UnwrittenSpeech
from lipsync_lang.sound.speech.sound import SPEECH_RATE, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")

TEXT = "The hogs were fed chopped corn and garbage"
OTHER = "A large size in stockings is hard to sell"
SILENCE = PreparedSound.of(ll.Audio(np.zeros(8 * SPEECH_RATE, np.int16), SPEECH_RATE))


def music(seconds):
    """Two chords in turn with harmonics, struck twice a second."""
    times = np.arange(round(seconds * SPEECH_RATE)) / SPEECH_RATE
    chord = np.array([[220, 277, 330], [196, 247, 294]])[(times % 2).astype(int)]
    tones = sum(np.sin(2 * np.pi * chord * n * times[:, None]).sum(1) / n for n in range(1, 7))
    return tones * np.exp(-2 * (times % 0.5))


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


@pytest.fixture(scope="module")
def line(english):
    return resampled(english.speak(TEXT).audio, SPEECH_RATE)


def beside(line, first):
    """Return a line with five seconds of music as loud as it."""
    said, sound = line.samples.astype(float), music(5.0)
    sound *= said.std() / sound.std()
    whole = np.concatenate([sound, said] if first else [said, sound])
    return ll.Audio(np.clip(whole, -32768, 32767).astype(np.int16), SPEECH_RATE)


@pytest.mark.parametrize("first", swept([True, False]))
def test_music_beside_a_line_is_no_reason_to_doubt_it(english, line, first, monkeypatch):
    audio = beside(line, first)
    alone = aligned(english, line, TEXT, aligner="pocketsphinx")
    found = aligned(english, audio, TEXT, aligner="pocketsphinx")
    assert found.confidence >= DOUBTFUL
    assert "sound without text" in " ".join(found.remarks)
    assert [word.text for word in found.words] == TEXT.split()
    assert found.end == pytest.approx(audio.seconds)
    shift = 5.0 if first else 0.0
    starts = [
        (found.times[one.first] - shift, alone.times[other.first])
        for one, other in zip(found.words, alone.words, strict=True)
    ]
    assert max(abs(own - known) for own, known in starts) < 0.05
    monkeypatch.setattr(line_search, "CHANGE_DEPTH", 0)
    assert aligned(english, audio, TEXT, aligner="pocketsphinx").confidence < DOUBTFUL


@full
@pytest.mark.parametrize("first", [True, False])
def test_a_wrong_text_beside_music_is_doubted_still(english, line, first):
    try:
        found = aligned(english, beside(line, first), OTHER, aligner="pocketsphinx")
    except ll.SpeechError:
        return
    assert found.confidence < DOUBTFUL


@pytest.mark.parametrize(("of_part", "kept"), [(0.9, "part"), (0.7, "whole")])
def test_parts_are_searched_where_speech_is_unwritten(of_part, kept, monkeypatch):
    whole = line_search.FoundLine([], 0.8, None, (UnwrittenSpeech(1, 0, 50),))
    part = line_search.FoundLine([], of_part)
    monkeypatch.setattr(line_search, "_found", lambda *_: whole)
    monkeypatch.setattr(line_search, "_alone", lambda *_: part)
    models = SimpleNamespace(model=SimpleNamespace(front_end=lambda _: np.zeros((800, 3, 13))))
    found = line_search.found_line(models, SILENCE, [((1, 2),)])
    assert found is {"part": part, "whole": whole}[kept]
    surely = whole._replace(unwritten=())
    monkeypatch.setattr(line_search, "_found", lambda *_: surely)
    assert line_search.found_line(models, SILENCE, [((1, 2),)]) is surely


def test_the_sound_around_a_part_is_no_place_for_a_word_of_it(monkeypatch):
    margins = []

    def found(*_, margin=line_search.ORDER_MARGIN_FRAMES):
        margins.append(margin)
        return line_search.FoundLine([], 0.2)

    monkeypatch.setattr(line_search, "_found", found)
    models = SimpleNamespace(model=SimpleNamespace(front_end=lambda _: np.zeros((800, 3, 13))))
    line_search.found_line(models, SILENCE, [((1, 2),)])
    assert margins[0] == line_search.ORDER_MARGIN_FRAMES
    assert {*margins[1:]} == {0}


@given(
    st.lists(st.integers(120, 300), min_size=2, max_size=3),
    st.integers(0, 2**32 - 1),
)
def test_changes_of_a_sound_are_found(lengths, seed):
    chance = np.random.default_rng(seed)
    parts = [chance.normal(3.0 * n, 1.0 + n, (count, 4)) for n, count in enumerate(lengths)]
    changes = line_search.sound_changes(np.concatenate(parts), 2)
    known = np.cumsum(lengths)[:-1]
    step = line_search.CHANGE_STEP_FRAMES
    assert changes == sorted(changes)
    assert all(min(abs(at - one) for one in changes) <= step for at in known)


@given(st.integers(1, 700), st.integers(0, 2**32 - 1))
def test_each_part_leaves_out_a_second_or_more(count, seed):
    features = np.random.default_rng(seed).normal(size=(count, 3, 13))
    for first, stop in line_search.sound_parts(features):
        assert 0 <= first < stop <= count
        assert stop - first <= count - line_search.MIN_BESIDE_FRAMES


def with_noise(audio, first, seconds=5.0):
    """Return a line with white noise of a tenth of its peak before or after it."""
    said = audio.samples.astype(float)
    noise = np.random.default_rng(0).uniform(-1, 1, round(seconds * audio.rate))
    noise *= np.abs(said).max() / 10
    whole = np.concatenate([noise, said] if first else [said, noise])
    return ll.Audio(whole.astype(np.int16), audio.rate)


@pytest.mark.parametrize(
    ("language", "text"),
    swept(
        [
            ("german", "Der Hund bellt laut im Garten."),
            ("spanish", "El caballo blanco bebe agua."),
            ("italian", "La bambina porta il pane alla mamma."),
            ("english", "Four hours of steady work faced us."),
        ],
        quick=1,
    ),
)
@pytest.mark.parametrize("first", [True, False])
def test_white_noise_beside_a_line_moves_no_word(language, text, first):
    known = ll.speak(text, language).audio
    alone = ll.align(known, text, language, aligner="pocketsphinx")
    found = ll.align(with_noise(known, first), text, language, aligner="pocketsphinx")
    assert [word.text for word in found.words] == [word.text for word in alone.words]
    moved = [word.start for word in found.words] - np.array([word.start for word in alone.words])
    assert np.abs(moved - (5.0 if first else 0.0)).max() < 0.06
    assert found.end == pytest.approx(known.seconds + 5.0)
    assert "sound without text" in " ".join(found.remarks)


def frames_of(samples):
    """Return the number of frames of a sound; the last may be a part."""
    return -(-len(samples) // HOP_SAMPLES)


@given(st.integers(60, 400), st.integers(0, 2**32 - 1))
def test_a_long_sound_has_the_features_and_the_voice_of_one_block(line, block, seed):
    rng = np.random.default_rng(seed)
    noise = rng.normal(0, 900, (2, rng.integers(2 * SPEECH_RATE)))
    sound = np.concatenate([noise[0], line.samples, noise[1]])
    fronts = features.features, features.SphinxFrontEnd()
    whole = [next(front.hearings([sound]))[:] for front in fronts]
    span = voice_span([sound], frames_of(sound))
    size = block * HOP_SAMPLES
    blocks = [sound[start : start + size] for start in range(0, len(sound), size)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(features, "SECTION_FRAMES", block)
        assert voice_span(blocks, frames_of(sound)) == span
        for front, found in zip(fronts, whole, strict=True):
            assert next(front.hearings(blocks))[:] == pytest.approx(found, abs=1e-9)


def test_a_part_of_a_prepared_sound_has_its_samples_in_blocks_of_any_size(line):
    sound = PreparedSound.of(line)
    samples = sound.samples()
    assert len(samples) == len(sound) == len(line.samples)
    assert np.abs(samples).max() == pytest.approx(features.PEAK_AMPLITUDE, abs=20)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speech_sound, "BLOCK_SAMPLES", 1000)
        part = sound.part(20, 90).part(3, 10**6)
        assert max(map(len, part)) == 1000
        assert np.array_equal(part.samples(), samples[23 * HOP_SAMPLES : 90 * HOP_SAMPLES])


@given(st.integers(0, 30), st.integers(0, 30))
def test_some_features_are_those_of_the_whole(line, first, stop):
    found = next(features.features.hearings(PreparedSound.of(line)))
    assert np.array_equal(found[first:stop], found[:][first:stop])
    assert np.array_equal(found[first:], found[:][first:])


def test_a_search_for_words_keeps_the_cepstra_of_a_long_sound_alone(monkeypatch):
    noise = np.random.default_rng(0).normal(0, 900, 2**21) * np.repeat([1, 0.2], 2**20)
    sound, kept = PreparedSound.of(ll.Audio(noise.astype(np.int16), SPEECH_RATE)), []

    def laid(_models, heard, _words):
        kept.append(tracemalloc.get_traced_memory()[0] / heard[:][:, 0].nbytes)

    monkeypatch.setattr(line_search, "laid", laid)
    models = SimpleNamespace(model=SimpleNamespace(front_end=features.features))
    tracemalloc.start()
    line_search.best_heard(models, sound, [])
    tracemalloc.stop()
    # of both hearings: the second has less noise
    assert len(kept) == 2
    assert 2 <= max(kept) < 2.2


@given(st.floats(0, 3), st.floats(0, 3))
def test_the_voice_between_noises_keeps_all_frames(line, before, after):
    noisy = with_noise(with_noise(line, first=True, seconds=before), first=False, seconds=after)
    count = frames_of(noisy.samples)
    first, stop = voice_span([noisy.samples.astype(float)], count)
    assert first <= before / FRAME_SECONDS + 5
    assert stop >= count - after / FRAME_SECONDS - 5
    if max(before, after) < 0.9:
        assert (first, stop) == (0, count)


def test_a_line_that_ends_in_a_quiet_room_is_heard_as_a_whole(line):
    samples = np.pad(line.samples.astype(float), SPEECH_RATE * 2)
    samples += np.random.default_rng(0).normal(size=len(samples))
    noise = np.random.default_rng(0).normal(size=SPEECH_RATE * 2)
    for sound in (samples, noise, noise[:100]):
        assert voice_span([sound], frames_of(sound)) == (0, frames_of(sound))
