"""Sound as bytes: formats, headers that lie, torn ends, and parts of any size."""

import io
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.live.sound_bytes import PCM_FORMATS, SampleForm, checked_form, sounds

TONE = (np.sin(np.arange(4000) / 5) * 0.5).astype(np.float32)


def encoded(format_, samples=TONE):
    """Return samples as bytes of a format."""
    kind, size = PCM_FORMATS[format_]
    if kind == 3:
        return samples.astype(f"<f{size}").tobytes()
    whole = np.rint(samples * (2.0 ** (8 * size - 1) - 1)).astype(np.int64) + 128 * (size == 1)
    return b"".join(int(one).to_bytes(size, "little", signed=size > 1) for one in whole)


def wav(samples=TONE, rate=16_000, format_="s16", channels=1, **stated):
    """Return a WAV file, whose header states other numbers if asked."""
    kind, size = PCM_FORMATS[format_]
    data = encoded(format_, np.repeat(samples, channels))
    block = stated.get("block", size * channels)
    bits = stated.get("bits", 8 * size)
    form = struct.pack("<HHIIHH", stated.get("kind", kind), channels, rate, 0, block, bits)
    chunks = b"fmt " + struct.pack("<I", len(form)) + form + stated.get("between", b"")
    chunks += b"data" + struct.pack("<I", stated.get("size", len(data))) + data
    return b"RIFF" + struct.pack("<I", 4 + len(chunks)) + b"WAVE" + chunks


def heard(raw, form=None, parts=None):
    """Return the rates and the sound of bytes, and the messages."""
    stream, told = io.BytesIO(raw), []
    sizes = iter(parts or ())

    def read(most):
        return stream.read(max(min(next(sizes, most), most), 1))

    found = [*sounds(read, form or SampleForm(), told.append)]
    whole = np.concatenate([np.zeros(0), *(one for _, one in found)])
    return list(dict.fromkeys(rate for rate, _ in found)), whole, told


@pytest.mark.parametrize("format_", PCM_FORMATS)
@pytest.mark.parametrize("channels", [1, 2])
def test_every_format_is_heard_with_and_without_a_header(format_, channels):
    close = 0.01 if format_ == "u8" else 1e-4
    rates, sound, told = heard(wav(rate=44_100, format_=format_, channels=channels))
    assert (rates, told) == ([44_100], [])
    assert np.abs(sound - TONE).max() < close
    raw = encoded(format_, np.repeat(TONE, channels))
    rates, sound, told = heard(raw, SampleForm(48_000, format_, channels))
    assert (rates, told) == ([48_000], [])
    assert np.abs(sound - TONE).max() < close


@given(st.lists(st.integers(1, 700), max_size=60))
def test_the_sound_is_the_same_in_any_parts(parts):
    for raw in (wav(), encoded("s16"), wav(between=b"LIST\x03\0\0\0abc\0")):
        rates, sound, told = heard(raw, parts=parts)
        assert (rates, told) == ([16_000], [])
        assert np.array_equal(sound, heard(encoded("s16"))[1])


@pytest.mark.parametrize("size", [0, 0xFFFF_FFFF, 0x7FFF_FFFF])
def test_a_header_of_a_stream_states_no_length(size):
    _, sound, told = heard(wav(size=size))
    assert (len(sound), told) == (len(TONE), [])


def test_what_a_header_hides_or_lacks_is_told_and_heard():
    rates, sound, told = heard(wav(size=4000))
    assert (rates, len(sound)) == ([16_000], len(TONE))
    assert told == ["the sound goes on after the 0.12 s that its WAV header states"]
    _, sound, told = heard(wav(size=16_000))
    assert (len(sound), told) == (
        len(TONE), ["the sound ends after 0.25 s; its WAV header states 0.50 s"],
    )  # fmt: skip
    rates, sound, told = heard(wav(rate=7))
    assert (rates, len(sound)) == ([16_000], len(TONE))
    assert told == ["the WAV header states 7 samples per second; it is heard at 16000"]
    _, sound, told = heard(wav(block=6))
    assert len(sound) == len(TONE)
    assert "states 6 bytes per sample, but 1 channels of 16 bits have 2" in told[0]


def test_a_file_after_another_may_have_another_rate():
    tags = b"LIST\x04\0\0\0tags"
    rates, sound, told = heard(wav() + tags + wav(rate=48_000, format_="f32"))
    assert (rates, told) == ([16_000, 48_000], [])
    assert len(sound) == 2 * len(TONE)


def test_a_torn_end_is_told():
    _, sound, told = heard(encoded("s16")[:-1])
    assert len(sound) == len(TONE) - 1
    assert told == ["the sound ends within a sample: 1 of 2 bytes are left out"]
    assert [len(heard(raw)[1]) for raw in (b"", b"\1\0", b"\1\0\1")] == [0, 1, 1]


def test_a_wrong_format_is_noticed():
    assert "give --format f32" in heard(encoded("f32"))[2][0]
    assert "give --format s16" in heard(encoded("s16"), SampleForm(format="f32"))[2][0]
    noise = np.random.default_rng(0).normal(0, 0.2, 4000)
    for format_ in ("s16", "f32"):
        for samples in (TONE, TONE * 1e-3, noise, np.zeros(4000)):
            form = SampleForm(format=format_)
            assert heard(encoded(format_, samples.clip(-1, 1)), form)[2] == []


def test_samples_that_are_no_numbers_are_silent():
    raw = np.array([np.nan, np.inf, -np.inf, 1e30, 0.5] * 10, "<f4").tobytes()
    sound = SampleForm(format="f32").samples(raw)
    assert sound[:5].tolist() == [0, 1, -1, 1, 0.5]


@pytest.mark.parametrize(
    ("raw", "match"),
    [
        (b"fLaC" + bytes(50), "the sound is FLAC"),
        (b"OggS" + bytes(50), "the sound is Ogg"),
        (b"\0\0\0\x1cftypisom" + bytes(50), "the sound is MPEG-4"),
        (wav(kind=6, bits=8), "states format 6 with 8 bits"),
        (wav(bits=12), "12 bits"),
        (wav()[:30], "has no samples"),
        (b"RIFF\0\0\0\0WAVE" + bytes(99), "has no samples"),
    ],
)
def test_other_sound_is_refused(raw, match):
    with pytest.raises(LipsyncError, match=rf"{match}.*ffmpeg"):
        heard(raw)


@pytest.mark.parametrize(
    ("stated", "match"),
    [
        ((100, None), "`rate=100`: give the samples per second"),
        (("16k", None), "from 8000 to 192000"),
        ((True, None), "rate"),
        ((None, "s61"), "did you mean 's16'"),
        ((None, 16), "not a format of samples"),
    ],
)
def test_an_odd_rate_or_format_is_refused(stated, match):
    with pytest.raises(LipsyncError, match=match):
        checked_form(*stated)
    assert checked_form(48_000, "f32") == (48_000, "f32", 1)
