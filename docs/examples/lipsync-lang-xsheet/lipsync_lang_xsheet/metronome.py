"""A speech engine: every letter lasts a beat. Its voices are numbers of beats in a minute."""

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import SILENCE, Schedule
from lipsync_lang.sound.speech import speech_engine


@speech_engine("metronome")
class Metronome:
    """Letters in time, without a sound."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Return the letters of a text as phonemes."""
        del words_per_minute  # the voice says how fast
        if not voice.isdecimal() or int(voice) == 0:
            raise SpeechError(f"metronome: no voice '{voice}'; give beats in a minute, such as 600")
        beat = 60 / int(voice)
        labels = [letter if letter.isalpha() else SILENCE for letter in text]
        spans = [(label, n * beat, (n + 1) * beat) for n, label in enumerate(labels)]
        return Schedule.from_intervals(spans, source="metronome")

    def voices(self) -> dict[str, str]:
        """Return the usual tempi."""
        return {"480": "eight letters in a second", "600": "ten letters in a second"}
