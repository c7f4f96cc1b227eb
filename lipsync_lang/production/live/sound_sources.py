"""Sources of live sound: standard input, a microphone or a recording."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from time import sleep
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.extras import extras, install_line
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.production.live.sound_bytes import Pcm, SampleForm, sounds
from lipsync_lang.sound.speech.sound import INT16_FULL_SCALE, read_audio
from lipsync_lang.text.lines.line_readers import Remark

STANDARD_INPUT = "-"

MICROPHONE, MICROPHONE_EXTRA = "mic", "microphone"

BLOCKS_PER_SECOND = 100
"""Blocks that a microphone returns in a second."""

RETRY_SECONDS = 2.0
"""Time after which a microphone that stopped is opened again."""


class SoundFeed:
    """A thread that offers the sound of a source to a voice until its end; `error` stopped it."""

    def __init__(self, source: Iterator[Pcm], voice: LiveVoice) -> None:
        self.error: LipsyncError | None = None
        self.voice = voice
        self._thread = Thread(target=self._work, args=(source, voice), daemon=True)
        self._thread.start()

    @property
    def alive(self) -> bool:
        """True until the source has ended."""
        return self._thread.is_alive()

    def _work(self, source: Iterator[Pcm], voice: LiveVoice) -> None:
        rate = 0
        try:
            for rate, samples in source:
                voice.offer(rate, samples)
            if not rate:
                self.error = LipsyncError(
                    "no sound came before the end of the input; check the program that sends it"
                )
        except LipsyncError as error:
            self.error = error
        finally:
            voice.end()


def open_source(text: str, form: SampleForm, rate: int | None, tell: Remark) -> Iterator[Pcm]:
    """Open a source of sound: `-`, `mic`, `mic:DEVICE`, or a file.

    Raises LipsyncError if the device or the file cannot be opened.

    Parameters
    ----------
    form : the form of raw samples
    rate : the rate that the user asked for; a microphone has its own otherwise
    """
    if text == STANDARD_INPUT:
        return sounds(_standard_input(), form, tell)
    if is_microphone(text):
        return Microphone(text.partition(":")[2], rate, tell).sound()
    audio = read_audio(text)
    return iter([(audio.rate, (audio.samples / INT16_FULL_SCALE).astype(np.float32))])


def is_microphone(text: str | None) -> bool:
    """Return True if a source is a microphone, which keeps its own time."""
    return text is not None and text.partition(":")[0] == MICROPHONE and not Path(text).exists()


def _standard_input() -> Any:
    """Return a function that reads bytes as soon as they arrive."""
    try:
        number = sys.stdin.fileno()
    except (OSError, ValueError, AttributeError):
        raise LipsyncError("standard input is closed; pipe sound to it") from None
    if os.isatty(number):
        raise LipsyncError(
            "standard input is a terminal; pipe sound to it, or listen to --audio mic"
        )
    return lambda most: os.read(number, most)


class Microphone:
    """A microphone, by a part of its name or its number; the usual one without either."""

    def __init__(self, device: str, rate: int | None, tell: Remark) -> None:
        self.library, self.tell = _sounddevice(), tell
        self.device, self.name = _device(device)
        self.rate = rate
        self._stream = self._open()

    def sound(self) -> Iterator[Pcm]:
        """Yield sound forever; one that stops is named, and opened again."""
        lost = False
        while True:
            try:
                stream = self._stream or self._open()
                if lost:
                    self.tell(f"the microphone '{self.name}' is back")
                lost, self._stream = False, None
                with stream:
                    yield from self._blocks(stream)
            except (self.library.PortAudioError, LipsyncError) as error:
                self._stream = None
                if not lost:
                    why = str(error).partition(" [")[0]
                    self.tell(f"the microphone '{self.name}' stopped ({why}); is it plugged in?")
                lost = True
                sleep(RETRY_SECONDS)

    def _blocks(self, stream: Any) -> Iterator[Pcm]:
        rate = round(stream.samplerate)
        while True:
            samples, overflowed = stream.read(rate // BLOCKS_PER_SECOND)
            if overflowed:
                self.tell("some sound of the microphone was lost; this machine is busy")
            yield rate, samples[:, 0] / np.float32(INT16_FULL_SCALE)

    def _open(self) -> Any:
        """Open the microphone at the rate asked for, or its own."""
        how: dict[str, Any] = {"device": self.device, "channels": 1, "dtype": "int16"}
        try:
            stream = self.library.InputStream(samplerate=self.rate, latency="low", **how)
            stream.start()
        except (self.library.PortAudioError, ValueError) as error:
            at = "" if self.rate is None else f" at {self.rate} samples per second"
            raise LipsyncError(
                f"the microphone '{self.name}' does not open{at} ({error}); "
                + ("leave out --rate, or " if at else "close programs that use it, or ")
                + "choose another: lipsync-lang live --list"
            ) from None
        return stream


class Device(NamedTuple):
    """A microphone of this machine."""

    number: int
    name: str
    rate: int
    """Its own samples per second."""
    usual: bool
    """True for the one that the system uses if none is named."""


def devices() -> list[Device]:
    """Return the microphones of this machine."""
    library = _sounddevice()
    # PortAudio has a pair of usual devices: for input and for output.
    usual = library.default.device[0]
    return [
        Device(number, one["name"], round(one["default_samplerate"]), number == usual)
        for number, one in enumerate(library.query_devices())
        if one["max_input_channels"] > 0
    ]


def _device(text: str) -> tuple[int | None, str]:
    known = devices()
    if not known:
        raise LipsyncError("this machine has no microphone; plug one in, or pipe sound: --audio -")
    if not text:
        return next(((one.number, one.name) for one in known if one.usual), (None, "usual"))
    for one in known:
        if text == str(one.number) or text.casefold() in one.name.casefold():
            return one.number, one.name
    hint = did_you_mean(text, [one.name for one in known])
    raise LipsyncError(f"no microphone is named '{text}'; {hint}")


def _sounddevice() -> Any:
    try:
        import sounddevice
    except ImportError:
        raise LipsyncError(
            f"a microphone needs the package sounddevice: {install_line(MICROPHONE_EXTRA)}"
        ) from None
    except OSError:  # its wheels bring the library for Windows and macOS only
        system = next(one.system for one in extras() if one.name == MICROPHONE_EXTRA)
        raise LipsyncError(f"a microphone needs {system}") from None
    except Exception as error:  # noqa: BLE001 its own error, which cannot be imported then
        why = str(error).partition(" [")[0]
        raise LipsyncError(f"the sound of this machine does not start ({why})") from None
    return sounddevice
