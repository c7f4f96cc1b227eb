"""Audio of the speech as a WAV file."""

import wave
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from lipsync_lang.animations.writers import Animation, binary_writer
from lipsync_lang.base.errors import OutputError


@binary_writer("wav", suffix=".wav")
def write_wav(animation: Animation, out: BinaryIO) -> None:
    """The speech, 16 bit mono; its first sample is time zero of the curves."""
    audio = animation.schedule.audio
    if audio is None:
        what = f"there is no sound to write: {animation.schedule.source} has no audio"
        cure = "speak text in a language with a voice (`tts` in its pack)"
        raise OutputError(f"{what}; {cure}, or omit the .wav")
    write_samples(audio.samples, audio.rate, out)


def write_samples(samples: npt.NDArray[np.int16], rate: int, out: BinaryIO) -> None:
    """Write mono samples as a WAV file."""
    with wave.open(out, "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(rate)
        sound.writeframes(samples.astype("<i2").tobytes())
