"""Speech: text in, sound and a schedule out.

Engines are kept in `ENGINES` by name, and `speech_engine` makes one known. Each takes text and a
voice and gives a `Schedule` whose times are seconds from the start of its sound. Which voice speaks
a language is the language pack's business.
"""

from lipsync_lang.speech.speech_engines import ENGINES, Engine, speak, speech_engine

__all__ = ["ENGINES", "Engine", "speak", "speech_engine"]
