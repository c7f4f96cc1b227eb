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
    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.errors import (
        AnimationError,
        LipsyncError,
        ModelError,
        OutputError,
        PackError,
        ScheduleError,
        SpeechError,
    )
    from lipsync_lang.packs.yaml.faults import PackFaults
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.performing.resolving import resolve
    from lipsync_lang.pipeline.motion import Motion
    from lipsync_lang.quality.check_animation import check
    from lipsync_lang.quality.figures import Figure, Finding, Quality
    from lipsync_lang.resolver.compiled import Report
    from lipsync_lang.rigs.channel import Channel
    from lipsync_lang.schedules.schedule import Audio, Schedule, Word
    from lipsync_lang.schedules.timed_words import TimedWord, TimedWords
    from lipsync_lang.schedules.timing_readers import read_schedule, read_timings
    from lipsync_lang.speech.filling import fill_words
    from lipsync_lang.speech.hearing import align, recognise
    from lipsync_lang.speech.sound import read_audio
    from lipsync_lang.speech.speaking import Transcript, speak, transcribe

_HOMES = {
    "Animation": "lipsync_lang.animations.animation",
    "AnimationError": "lipsync_lang.errors",
    "Audio": "lipsync_lang.schedules.schedule",
    "Channel": "lipsync_lang.rigs.channel",
    "Explanation": "lipsync_lang.animations.explanation",
    "Figure": "lipsync_lang.quality.figures",
    "Finding": "lipsync_lang.quality.figures",
    "LipsyncError": "lipsync_lang.errors",
    "ModelError": "lipsync_lang.errors",
    "Motion": "lipsync_lang.pipeline.motion",
    "OutputError": "lipsync_lang.errors",
    "PackError": "lipsync_lang.errors",
    "PackFaults": "lipsync_lang.packs.yaml.faults",
    "Performer": "lipsync_lang.performing.performer",
    "Quality": "lipsync_lang.quality.figures",
    "Report": "lipsync_lang.resolver.compiled",
    "Schedule": "lipsync_lang.schedules.schedule",
    "ScheduleError": "lipsync_lang.errors",
    "SpeechError": "lipsync_lang.errors",
    "TimedWord": "lipsync_lang.schedules.timed_words",
    "TimedWords": "lipsync_lang.schedules.timed_words",
    "Transcript": "lipsync_lang.speech.speaking",
    "Word": "lipsync_lang.schedules.schedule",
    "align": "lipsync_lang.speech.hearing",
    "check": "lipsync_lang.quality.check_animation",
    "fill_words": "lipsync_lang.speech.filling",
    "read_audio": "lipsync_lang.speech.sound",
    "read_schedule": "lipsync_lang.schedules.timing_readers",
    "read_timings": "lipsync_lang.schedules.timing_readers",
    "recognise": "lipsync_lang.speech.hearing",
    "resolve": "lipsync_lang.performing.resolving",
    "speak": "lipsync_lang.speech.speaking",
    "transcribe": "lipsync_lang.speech.speaking",
}

__all__ = [
    "Animation",
    "AnimationError",
    "Audio",
    "Channel",
    "Explanation",
    "Figure",
    "Finding",
    "LipsyncError",
    "ModelError",
    "Motion",
    "OutputError",
    "PackError",
    "PackFaults",
    "Performer",
    "Quality",
    "Report",
    "Schedule",
    "ScheduleError",
    "SpeechError",
    "TimedWord",
    "TimedWords",
    "Transcript",
    "Word",
    "__version__",
    "align",
    "check",
    "fill_words",
    "read_audio",
    "read_schedule",
    "read_timings",
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
