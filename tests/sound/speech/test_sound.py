"""Recordings: every usual format is read, and other files are refused with a message."""

import struct
import sys
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.performing.effort import frame_levels, levels
from lipsync_lang.pipeline.levels import Level
from lipsync_lang.sound.speech import sound
from lipsync_lang.sound.speech.hearing.align.spectrum import heard_in, mel_power, samples_of
from lipsync_lang.sound.speech.hearing.sphinx import features
from lipsync_lang.sound.speech.hearing.sphinx.features import PreparedSound
from lipsync_lang.sound.speech.sound import (
    FASTEST,
    MAX_SOUND_SECONDS,
    SLOWEST,
    read_audio,
    resampled,
)

soundfile = pytest.importorskip("soundfile")

RATE = 16_000
TONE = np.rint(8000 * np.sin(2 * np.pi * 440 * np.arange(RATE // 2) / RATE)).astype(np.int16)


def written(path, samples=TONE, rate=RATE, **form):
    soundfile.write(path, samples, rate, **form)
    return path


@pytest.mark.parametrize(
    ("name", "subtype"),
    [
        ("a.wav", "PCM_16"), ("a.wav", "PCM_24"), ("a.wav", "PCM_32"), ("a.wav", "FLOAT"),
        ("a.wav", "DOUBLE"), ("a.flac", "PCM_16"), ("a.flac", "PCM_24"), ("a.aiff", "PCM_16"),
        ("a.w64", "PCM_16"), ("a.rf64", "PCM_16"), ("a.caf", "PCM_16"), ("a.au", "PCM_16"),
    ],
)  # fmt: skip
def test_what_is_kept_without_loss_comes_back_as_it_was(tmp_path, name, subtype):
    audio = read_audio(written(tmp_path / name, TONE / 32768, subtype=subtype))
    assert audio.rate == RATE
    assert np.array_equal(audio.samples, TONE)


@pytest.mark.parametrize(
    ("name", "form"),
    [
        ("a.ogg", {}), ("a.mp3", {}), ("a.opus", {"format": "OGG", "subtype": "OPUS"}),
        ("a.wav", {"subtype": "ULAW"}), ("a.wav", {"subtype": "IMA_ADPCM"}),
    ],
)  # fmt: skip
def test_what_is_kept_with_loss_comes_back_alike(tmp_path, name, form):
    audio = read_audio(written(tmp_path / name, **form))
    assert audio.rate == RATE
    assert audio.seconds == pytest.approx(0.5, abs=0.1)
    middle = slice(2000, 6000)
    heard = np.abs(np.fft.rfft(audio.samples[middle].astype(float)))
    assert heard.argmax() * RATE / 4000 == pytest.approx(440, abs=5)


def test_channels_are_mixed_down(tmp_path):
    both = np.stack([TONE, np.zeros_like(TONE)], axis=1)
    audio = read_audio(written(tmp_path / "a.wav", both))
    assert audio.samples.ndim == 1
    assert np.abs(audio.samples - TONE / 2).max() <= 0.5


@pytest.mark.parametrize("name", ["a.wav", "a.ogg"])
def test_a_voice_in_one_channel_is_heard_and_a_channel_can_be_chosen(tmp_path, name):
    low = np.rint(8000 * np.sin(2 * np.pi * 110 * np.arange(RATE // 2) / RATE)).astype(np.int16)
    path = written(tmp_path / name, np.stack([TONE, low], axis=1))
    for channel, hertz in ((1, 440), (2, 110)):
        heard = np.abs(np.fft.rfft(read_audio(path, channel).samples[2000:6000].astype(float)))
        assert heard.argmax() * RATE / 4000 == pytest.approx(hertz, abs=5)
    for channel in (0, 3, -1):
        with pytest.raises(SpeechError, match=f"has no channel {channel}; .* numbered 1 to 2"):
            read_audio(path, channel)


def test_channels_that_cancel_each_other_out_are_not_mixed(tmp_path):
    """A plug with swapped wires reverses one channel."""
    quiet = written(tmp_path / "a.wav", np.stack([-(TONE // 2), TONE // 2 + TONE % 2], axis=1))
    assert np.abs(read_audio(quiet).samples).max() > 3900
    louder = written(tmp_path / "b.wav", np.stack([-(TONE // 10 * 9), TONE], axis=1))
    assert np.array_equal(read_audio(louder).samples, TONE)
    silent = written(tmp_path / "c.wav", np.zeros((100, 2), np.int16))
    assert not read_audio(silent).samples.any()


def test_what_is_too_loud_is_cut_off_and_does_not_wrap(tmp_path):
    loud = np.array([2.0, -2.0, np.nan, 0.5] * 10)
    audio = read_audio(written(tmp_path / "a.wav", loud, subtype="FLOAT"))
    assert audio.samples[:4].tolist() == [32767, -32768, 0, 16384]


@pytest.mark.parametrize("rate", [SLOWEST, 11_025, 44_100, 96_000, FASTEST])
def test_every_usual_rate_is_read(tmp_path, rate):
    assert read_audio(written(tmp_path / "a.wav", rate=rate)).rate == rate


@pytest.mark.parametrize("rate", [SLOWEST - 1, FASTEST + 1])
def test_odd_rates_are_refused(tmp_path, rate):
    with pytest.raises(ll.SpeechError, match=rf"a\.wav: {rate} samples per second; .*resample"):
        read_audio(written(tmp_path / "a.wav", rate=rate))


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(ll.SpeechError, match=r"none\.wav: cannot be read: No such file"):
        read_audio(tmp_path / "none.wav")


def test_a_folder_is_no_recording(tmp_path):
    with pytest.raises(ll.SpeechError, match="cannot be read"):
        read_audio(tmp_path)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "the file is empty.*; copy or record it again"),
        (b"hello " * 100, "the file contains text.*; give the recording itself"),
        ("<!DOCTYPE html><p>schön</p>".encode() * 30, "the file contains text"),
        (b"RIFF" + bytes(100), "; save it as WAV"),
        (bytes(3000), "; save it as WAV"),
    ],
    ids=["empty", "text", "page", "riff", "zeros"],
)
def test_what_is_no_sound_is_told(tmp_path, content, told):
    path = tmp_path / "a b.wav"
    path.write_bytes(content)
    with pytest.raises(ll.SpeechError, match=rf"a b\.wav: not a readable recording \(.*{told}"):
        read_audio(path)


def test_a_recording_of_nothing_is_told(tmp_path):
    with pytest.raises(ll.SpeechError, match=r"a\.wav: has no sound"):
        read_audio(written(tmp_path / "a.wav", TONE[:0]))


@pytest.mark.parametrize("name", ["a.wav", "a.aiff", "a.flac"])
def test_a_recording_that_is_cut_short_is_told(tmp_path, name):
    path = written(tmp_path / name)
    path.write_bytes(path.read_bytes()[:-3000])
    with pytest.raises(ll.SpeechError, match=rf"{name}: (ends after|not a readable recording)"):
        read_audio(path)


def test_a_header_that_leaves_the_length_open_is_believed(tmp_path):
    path = written(tmp_path / "a.wav")
    content = bytearray(path.read_bytes())
    at = content.index(b"data") + 4
    content[at : at + 4] = content[4:8] = b"\xff\xff\xff\xff"
    path.write_bytes(content)
    assert np.array_equal(read_audio(path).samples, TONE)


def variable_mp3(path, samples):
    """Write an MP3 of variable rate whose first frame states no length."""
    try:
        written(path, samples, bitrate_mode="VARIABLE", compression_level=0.0)
    except (TypeError, soundfile.LibsndfileError):
        pytest.skip("this libsndfile does not write MP3")
    content = path.read_bytes()
    stating = max(content.find(b"Xing"), content.find(b"Info"))
    assert stating > 0
    path.write_bytes(content[content.find(b"\xff\xf3", stating) :])


@pytest.mark.parametrize("loud_first", [True, False])
@pytest.mark.parametrize("tag", [b"", b"ID3\x04\0\0" + bytes([0, 0, 1, 0]) + bytes(128)])
def test_an_mp3_of_variable_rate_without_a_length_is_read_to_its_end(tmp_path, loud_first, tag):
    time = np.arange(4 * RATE) / RATE
    sweep = np.where((time < 2) == loud_first, 0.4 * np.sin(900 * time * time), 0.0)
    path = tmp_path / "a.mp3"
    # in two channels that cancel each other out, so that it is read twice
    variable_mp3(path, np.column_stack([sweep, -sweep]))
    path.write_bytes(tag + path.read_bytes())
    audio = read_audio(path)
    assert audio.seconds == pytest.approx(4, abs=0.2)
    loud = np.abs(audio.samples) > 2000
    assert np.median(np.flatnonzero(loud)) / RATE == pytest.approx(1 if loud_first else 3, abs=0.2)


@full
def test_samples_that_an_mp3_states_and_does_not_have_are_not_made_up(data):
    file = data / "recordings/mfa_tests/common_voice_en_22058267.mp3"
    sound = read_audio(file)
    assert len(sound.samples) == len(soundfile.read(file)[0])
    assert len(sound.samples) < soundfile.info(file).frames


def test_a_recording_of_more_than_two_hours_is_refused_unread(tmp_path):
    rate = SLOWEST
    path = tmp_path / "a.flac"
    with soundfile.SoundFile(path, "w", rate, 1) as sound:
        minute = np.zeros(60 * rate, np.int16)
        for _ in range(int(MAX_SOUND_SECONDS // 60) + 1):
            sound.write(minute)
    with pytest.raises(ll.SpeechError, match=r"121 minutes.*120"):
        read_audio(path)


def test_without_a_library_the_extra_is_named(tmp_path, monkeypatch):
    path = written(tmp_path / "a.wav")
    monkeypatch.setitem(sys.modules, "soundfile", None)
    with pytest.raises(ll.SpeechError, match=r'pip install "lipsync-lang\[audio\]"'):
        read_audio(path)


@full
@given(st.sampled_from([8000, 11_025, 22_050, 44_100, 48_000]), st.integers(1, 3000))
def test_a_resampled_sound_lasts_as_long(rate, count):
    audio = ll.Audio(np.zeros(count, np.int16), rate)
    assert abs(resampled(audio, RATE).seconds - audio.seconds) <= 1 / RATE


@full
@given(
    rate=st.sampled_from([SLOWEST, 8000, 11_025, 22_050, 44_100, 48_000]),
    count=st.integers(1, 4000), block=st.integers(700, 3000),
)  # fmt: skip
def test_a_sound_is_resampled_in_blocks_as_in_one(rate, count, block):
    samples = np.random.default_rng(count).integers(-(2**15), 2**15, count).astype(np.int16)
    whole = resampled(ll.Audio(samples, rate), RATE).samples
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sound, "BLOCK_SAMPLES", block)
        assert np.array_equal(resampled(ll.Audio(samples, rate), RATE).samples, whole)


def most_bytes(made):
    """Return the peak of memory that a function takes, once its libraries are there.

    It is the least of three: threads of earlier tests may take memory beside it.
    """
    made()
    peaks = []
    for _ in range(3):
        tracemalloc.start()
        try:
            made()
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    return min(peaks)


def test_a_long_sound_is_measured_in_less_memory_than_two_of_its_features(monkeypatch):
    noise = np.random.default_rng(0).normal(0, 900, 2**21).astype(np.int16)
    prepared = PreparedSound.of(ll.Audio(noise, RATE))
    monkeypatch.setattr(features, "SECTION_FRAMES", 100)
    monkeypatch.setattr(sound, "BLOCK_SAMPLES", 2**14)
    frames = len(noise) // features.HOP_SAMPLES
    found = frames * 3 * features.CEPSTRA * 8
    assert most_bytes(lambda: features.voice_span(prepared, frames)) < found * 0.55
    assert most_bytes(lambda: next(features.features.hearings(prepared))) < found * 2.1


def test_a_long_sound_is_prepared_in_little_more_memory_than_its_own(tmp_path, monkeypatch):
    long = ll.Audio(np.resize(TONE, 2**23), 3 * RATE)
    assert most_bytes(lambda: resampled(long, RATE)) < 2**23 * 6
    slow = ll.Audio(np.resize(TONE, 2**23), RATE)
    path = tmp_path / "long.wav"
    soundfile.write(path, slow.samples[: 2**22], RATE)
    monkeypatch.setattr(sound, "BLOCK_SAMPLES", 2**16)
    assert most_bytes(lambda: read_audio(path)) < 2**22 * 3
    assert most_bytes(lambda: PreparedSound.of(slow).samples()) < 2**23 * 11
    timed = ll.Schedule(("a",) * 400, np.arange(401.0).tolist(), audio=slow)
    spans = (0.0, 2.0)
    said = np.ones(400, bool)
    assert most_bytes(lambda: levels(timed, said, 1.0, spans, -24.0)) < 2**23 * 5
    slow_level = Level(np.array([50.0, 250.0]), np.ones(2))
    assert most_bytes(lambda: frame_levels(slow_level, timed, 1.0, spans)) < 2**23 * 5


def test_a_resampled_tone_is_the_same_tone():
    there = resampled(ll.Audio(TONE, RATE), 44_100)
    back = resampled(there, RATE)
    assert there.rate == 44_100
    assert np.abs(back.samples[200:-200] - TONE[200:-200].astype(int)).max() < 80


def header(channels=1, rate=RATE, size=800, stated=None):
    """Return a WAV of silence, with a header that may be false."""
    form = struct.pack("<HHIIHH", 1, channels, rate, rate * 2, 2, 16)
    body = b"WAVEfmt " + struct.pack("<I", 16) + form
    body += b"data" + struct.pack("<I", size if stated is None else stated) + bytes(size)
    return b"RIFF" + struct.pack("<I", len(body)) + body


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (header(channels=0), "not a readable recording"),
        (header(rate=0), "not a readable recording|samples per second"),
        (header(channels=300, size=600_000), "has 1,000 samples on 300 channels, more than"),
        (header(stated=2**30), "before the end that its header states"),
    ],
    ids=["no channels", "no rate", "many channels", "more than there is"],
)
def test_a_header_that_lies_is_told(content, message, tmp_path):
    path = tmp_path / "a.wav"
    path.write_bytes(content)
    with pytest.raises(SpeechError, match=message):
        read_audio(path)


def chunk(name, content, padding=b"\0"):
    """Return a chunk of a WAV file."""
    return name + struct.pack("<I", len(content)) + content + padding * (len(content) % 2)


@pytest.mark.parametrize("stated", [0, 2, 1000])
@pytest.mark.parametrize("content", [bytes(2 * RATE), TONE.tobytes() * 2], ids=["silence", "tone"])
def test_a_sound_that_goes_on_after_its_stated_end_is_told(tmp_path, stated, content):
    """A recorder that crashed never wrote the length."""
    path = tmp_path / "a.wav"
    path.write_bytes(header(size=0, stated=stated)[:44] + content)
    seconds = (len(content) - stated) / RATE / 2
    with pytest.raises(
        SpeechError,
        match=rf"a\.wav: goes on for {seconds:.2f} s after the "
        r".*open the file",
    ):
        read_audio(path)


@pytest.mark.parametrize(
    "after",
    [
        chunk(b"LIST", b"INFO" + bytes(40)),
        chunk(b"id3 ", bytes(20_001)) + chunk(b"iXML", bytes(9001)),
        chunk(b"id3 ", bytes(20_001), padding=b"") + chunk(b"iXML", bytes(9001), padding=b""),
        b"TAG" + bytes(125),
        b"\0",
    ],
    ids=["list", "odd chunks", "odd chunks without padding", "tag", "a byte"],
)
def test_what_other_programs_write_after_the_sound_is_passed_over(tmp_path, after):
    path = tmp_path / "a.wav"
    path.write_bytes(written(path).read_bytes() + after)
    assert np.array_equal(read_audio(path).samples, TONE)


@pytest.mark.parametrize("stated", [None, 0xFFFF_FFFF], ids=["stated", "open"])
def test_ten_hours_are_refused_unread(tmp_path, stated):
    path, size = tmp_path / "a.wav", 10 * 3600 * RATE * 2
    with path.open("wb") as file:
        file.write(header(size=0, stated=size if stated is None else stated)[:44])
        file.truncate(44 + size)  # a file of holes, which takes no room
    tracemalloc.start()
    with pytest.raises(SpeechError, match=r"a\.wav: lasts 600 minutes.*120"):
        read_audio(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1_000_000


@pytest.mark.parametrize("scale", [0.001, 0.01, 100.0])
def test_quiet_and_loud_recordings_keep_their_tone(tmp_path, scale):
    path = written(tmp_path / "a.wav", TONE / 32768 * scale, subtype="FLOAT")
    heard = np.abs(np.fft.rfft(read_audio(path).samples[2000:6000].astype(float)))
    assert heard[1:].argmax() + 1 == 110


@pytest.mark.parametrize("level", [0.001, 1.0])
def test_speech_is_found_at_any_level_and_beside_a_constant(level):
    """The level of a recording and a constant offset in it have no effect."""
    rng = np.random.default_rng(1)
    voice = rng.normal(0, 1500, 2 * RATE) * np.repeat([1, 0.003, 1, 0.003], RATE // 2)
    plain = heard_in(mel_power(samples_of(ll.Audio(voice.astype(np.int16), RATE)))[0]).spoken
    other = np.rint(voice * 10 * level + 9000).astype(np.int16)
    heard = heard_in(mel_power(samples_of(ll.Audio(other, RATE)))[0]).spoken
    assert np.mean(plain != heard) < 0.03
    assert 0.4 < plain.mean() < 0.6


def test_a_small_file_that_unpacks_to_hours_of_samples_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(sound, "MAX_SAMPLES", len(TONE) - 1)
    with pytest.raises(SpeechError, match=r"8,000 samples.*7,999 "):
        read_audio(written(tmp_path / "a.flac"))


def test_samples_that_are_no_numbers_are_heard_as_silence_or_full_scale(tmp_path):
    odd = np.array([[3e38, 3e38], [np.nan, 0], [np.inf, 0], [-np.inf, -np.inf]] * 50, np.float32)
    audio = read_audio(written(tmp_path / "a.wav", odd, subtype="FLOAT"))
    assert audio.samples[:4].tolist() == [32767, 0, 32767, -32768]
