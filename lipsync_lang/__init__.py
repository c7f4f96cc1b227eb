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

__version__ = "0.1.0"

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.errors import LipsyncError, PackError, ScheduleError, SpeechError
    from lipsync_lang.hearing import align, recognise
    from lipsync_lang.performer import Performer
    from lipsync_lang.quality.checks import check
    from lipsync_lang.resolver import resolve
    from lipsync_lang.schedules.registry import read_schedule
    from lipsync_lang.schedules.schedule import Audio, Schedule, Word
    from lipsync_lang.speaking import speak, transcribe

_HOMES = {
    "Animation": "lipsync_lang.animations.animation",
    "Audio": "lipsync_lang.schedules.schedule",
    "LipsyncError": "lipsync_lang.errors",
    "PackError": "lipsync_lang.errors",
    "Performer": "lipsync_lang.performer",
    "ScheduleError": "lipsync_lang.errors",
    "SpeechError": "lipsync_lang.errors",
    "Schedule": "lipsync_lang.schedules.schedule",
    "Word": "lipsync_lang.schedules.schedule",
    "align": "lipsync_lang.hearing",
    "check": "lipsync_lang.quality.checks",
    "read_schedule": "lipsync_lang.schedules.registry",
    "recognise": "lipsync_lang.hearing",
    "resolve": "lipsync_lang.resolver",
    "speak": "lipsync_lang.speaking",
    "transcribe": "lipsync_lang.speaking",
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
