"""Lines of the commands that perform one: performers, schedules and animations by options."""

from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files import STANDARD_STREAM
from lipsync_lang.commands.output import listening, tell_all
from lipsync_lang.commands.shared_options import cleaning

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.delivery import Points
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule

LINE_PAGE = "html"
"""Format that shows several takes."""


def plot_kind(path: Path) -> str:
    """Return a picture's format from its suffix; PNG for standard output."""
    return "png" if path == STANDARD_STREAM else path.suffix.lstrip(".")


def perform(options: Namespace) -> "Animation":
    """Perform the line of the options on its character."""
    performer = performer_for(options)
    return perform_line(options, performer, schedule_for(options, performer))


def perform_line(
    options: Namespace, performer: "Performer", schedule: "Schedule", gestures: str | None = None
) -> "Animation":
    """Perform a line with the requested delivery options; `gestures` if no option states any.

    A line of the script has edits or none, as in a build.
    """
    named = options.line
    if getattr(options, "from_script", False) and named not in performer.compiled.line_edits:
        named = None
    return performer.perform(
        schedule.resting(options.idle or 0.0), fps=options.fps, line=named,
        styles=levels("--style", options.styles),
        dials=levels("--dial", options.dials), intensity=options.intensity,
        gestures=gestures if options.gestures is None else options.gestures,
    )  # fmt: skip


def levels(option: str, stated: list[str]) -> "dict[str, Points | float]":
    """Parse ``angry:0.5`` (constant level) or ``angry:0@1,1@2.5`` (level at seconds)."""
    found: dict[str, Points | float] = {}
    for one in stated:
        name, _, level = one.partition(":")
        try:
            parts = [part.partition("@") for part in level.split(",")]
            points = [(float(at or 0), float(value)) for value, _, at in parts]
        except ValueError:  # also raised without a colon: then the number is missing
            raise LipsyncError(
                f"{option} {one}: write NAME:NUMBER ({option} {name or 'NAME'}:0.5) or "
                f"NAME:NUMBER@SECONDS,... ({option} {name or 'NAME'}:0@1,1@2.5)"
            ) from None
        found[name] = points[0][1] if len(points) == 1 else points
    return found


def performer_for(options: Namespace, character: str | None = None) -> "Performer":
    """Return the performer of the named pair, or of another character."""
    from lipsync_lang.performing.resolving import resolve as resolve_pair

    performer = resolve_pair(
        options.language, character or options.character, paths=options.path, gaps=options.gaps,
        unknown=options.unknown, motion=motion_settings(options.settings), shades=options.shades,
    )  # fmt: skip
    tell_all(performer.compiled.report.idle)
    return replace(performer, cleaning=cleaning(options))


def motion_settings(settings: list[str]) -> dict[str, object]:
    """Parse ``motion.window=0.1`` and ``motion=paper``."""
    change: dict[str, object] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if name == "motion" and equals:
            change["preset"] = value
        elif name.startswith("motion.") and equals:
            change[name.removeprefix("motion.")] = value
        else:
            raise LipsyncError(
                f"--set {setting}: write motion.NAME=VALUE (--set motion.window=0.1) "
                "or motion=PRESET (--set motion=paper)"
            )
    return change


def schedule_for(
    options: Namespace, performer: "Performer", outputs: "Mapping[str, list[str]] | None" = None
) -> "Schedule":
    """Return timed phonemes of a text, a schedule file or a recording.

    Extras that the line or its `outputs`, each with its formats, lack are refused together before.
    """
    from lipsync_lang.performing.delivery import marked_text
    from lipsync_lang.sound.speech.needed_extras import engines_of, refuse_missing

    _refuse_idle(options)
    # All that is missing is told at once, before minutes of listening.
    needed = dict(outputs or {})
    if options.text is not None:
        manner, heard = performer.speaker.manner, options.audio is not None
        needed[manner.language] = [
            *engines_of(manner, spoken=not heard, heard=heard, tts=options.tts)
        ]
    refuse_missing(needed)
    if options.schedule is not None:
        return _timed(options, performer)
    text = options.text and marked_text(performer.compiled, options.text, options.line)
    if options.audio is None:
        return performer.speaker.speak(text, engine=options.tts)
    from lipsync_lang.sound.speech.hearing.alignment import aligned
    from lipsync_lang.sound.speech.hearing.recognition import recognised
    from lipsync_lang.sound.speech.sound import read_audio

    speaker = performer.speaker
    audio = options.audio
    if options.audio_channel is not None:
        audio = read_audio(audio, options.audio_channel)
    with listening(f"listening to {options.audio}"):
        if text is None:
            return recognised(speaker, audio, recogniser=options.recogniser)
        return aligned(speaker, audio, text, aligner=options.aligner)


def _refuse_idle(options: Namespace) -> None:
    """Refuse options without effect, naming the option that they depend on."""
    text, schedule, audio = (
        getattr(options, name) is not None for name in ("text", "schedule", "audio")
    )
    if (text and schedule) or not (text or schedule or audio):
        raise LipsyncError(
            "give a TEXT to speak, timed phonemes with --schedule FILE, or a recording with "
            "--audio FILE"
        )
    if options.tts is not None and (schedule or audio):
        given = "--schedule" if schedule else "--audio"
        raise LipsyncError(f"--tts speaks a TEXT; leave it out with {given}")
    for name in ("notation", "read_as", "tier", "rate", "encoding"):
        if getattr(options, name) is not None and not schedule:
            option = f"--{name.replace('_', '-')}"
            given = "a TEXT" if text else "a recording alone"
            raise LipsyncError(f"{option} needs a --schedule; leave it out with {given}")
    if options.audio_channel is not None and not audio:
        raise LipsyncError("--audio-channel needs a recording; give one with --audio")
    if options.aligner is not None and not (text and audio):
        raise LipsyncError("--aligner aligns a TEXT with a recording; give both TEXT and --audio")
    if options.recogniser is not None and (text or schedule):
        raise LipsyncError("--recogniser needs only --audio; leave out the text and the schedule")


def _timed(options: Namespace, performer: "Performer") -> "Schedule":
    """Return the timings of a file, with the recording; timed words are filled with phonemes."""
    from lipsync_lang.schedules.timed_words import TimedWords, words_without_phonemes
    from lipsync_lang.schedules.timing_readers import read_timings

    found = read_timings(
        options.schedule, options.notation, read_as=options.read_as, tier=options.tier,
        rate=options.rate, encoding=options.encoding,
    )  # fmt: skip
    audio, channel = options.audio, options.audio_channel
    if audio is None and not isinstance(found, TimedWords) and not words_without_phonemes(found):
        return found  # without the imports for sound
    from lipsync_lang.sound.speech.filling import with_phonemes
    from lipsync_lang.sound.speech.sound import read_audio, with_sound

    if not isinstance(found, TimedWords):
        whole = with_phonemes(performer.speaker, found)
        return whole if audio is None else with_sound(whole, audio, channel)
    if options.notation is not None:
        what = f"{options.schedule} has timed words, not phonemes; leave out --notation"
        raise LipsyncError(what)
    if audio is None:
        return with_phonemes(performer.speaker, found)
    with listening(f"listening to {audio}"):
        return with_phonemes(performer.speaker, found, audio=read_audio(audio, channel))
