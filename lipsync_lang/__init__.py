"""Lip sync for any language and any character, from data that people can read and edit.

    import lipsync_lang as ll

    performer = ll.resolve("english", "facefx")
    schedule = ll.speak("Hello, world", "english")
    animation = performer.perform(schedule, fps=60)
    animation.save("hello.csv")
    print(animation.explain(0.42))

Importing this is light: speech, plotting and YAML are loaded when they are used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from lipsync_lang.version import __version__

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.errors import LipsyncError, PackError, ScheduleError, SpeechError
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.performing.resolving import resolve
    from lipsync_lang.quality.check_animation import check
    from lipsync_lang.schedules.schedule import Audio, Schedule, Word
    from lipsync_lang.schedules.timing_readers import read_schedule
    from lipsync_lang.speech.hearing import align, recognise
    from lipsync_lang.speech.speaking import speak, transcribe

_HOMES = {
    "Animation": "lipsync_lang.animations.animation",
    "Audio": "lipsync_lang.schedules.schedule",
    "LipsyncError": "lipsync_lang.errors",
    "PackError": "lipsync_lang.errors",
    "Performer": "lipsync_lang.performing.performer",
    "ScheduleError": "lipsync_lang.errors",
    "SpeechError": "lipsync_lang.errors",
    "Schedule": "lipsync_lang.schedules.schedule",
    "Word": "lipsync_lang.schedules.schedule",
    "align": "lipsync_lang.speech.hearing",
    "check": "lipsync_lang.quality.check_animation",
    "read_schedule": "lipsync_lang.schedules.timing_readers",
    "recognise": "lipsync_lang.speech.hearing",
    "resolve": "lipsync_lang.performing.resolving",
    "speak": "lipsync_lang.speech.speaking",
    "transcribe": "lipsync_lang.speech.speaking",
}

__all__ = [
    "Animation",
    "Audio",
    "LipsyncError",
    "PackError",
    "Performer",
    "Schedule",
    "ScheduleError",
    "SpeechError",
    "Word",
    "__version__",
    "align",
    "check",
    "read_schedule",
    "recognise",
    "resolve",
    "speak",
    "transcribe",
]


def __getattr__(name: str) -> object:
    """Import a public name where it lives, the first time it is asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module 'lipsync_lang' has no attribute '{name}'")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, loaded or not."""
    return sorted(__all__)
