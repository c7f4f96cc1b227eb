"""Speech synthesis: text to sound and a schedule of timed phonemes.

`ENGINES` maps names to engines; `speech_engine` registers one. An engine takes text and a voice
and returns a `Schedule`, with times in seconds from the start of its sound. The language pack
selects the voice.
"""

from lipsync_lang.sound.speech.speaking.speech_engines import (
    ENGINES,
    BatchEngine,
    Engine,
    speak_many,
    speech_engine,
)

__all__ = ["ENGINES", "BatchEngine", "Engine", "speak_many", "speech_engine"]
