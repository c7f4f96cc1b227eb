"""Commands that animate a line or explain its animation."""

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, count, lines_of, listed, listening
from lipsync_lang.commands.script_options import cleaning
from lipsync_lang.commands.spelling import as_options
from lipsync_lang.errors import LipsyncError, OutputError
from lipsync_lang.files import STANDARD_STREAM

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.delivery import Points
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule
    from lipsync_lang.schedules.timed_words import TimedWords


PAGE = "html"
"""Format that shows several takes."""


def run(options: Namespace) -> int:
    """Animate a line, and write it to all requested outputs."""
    from lipsync_lang.animations.animation_writers import parse_output
    from lipsync_lang.animations.keys import parse_keys
    from lipsync_lang.animations.rates import parse_offset
    from lipsync_lang.files import write_all

    error, lines = parse_keys(options.keys) if options.keys is not None else (None, False)
    writers = dict(map(parse_output, options.output))
    _refuse_same(options, [path for path, _ in map(parse_output, options.output)])
    if options.beside and not options.plot:
        raise LipsyncError("--beside draws a picture; name it with --plot FILE")
    if options.against and not any(writer.name == PAGE for writer in writers.values()):
        raise LipsyncError("--against needs a page; name it with -o line.html")
    performer = performer_for(options)
    animation = perform_line(options, performer, schedule_for(options, performer))
    offset = parse_offset(options.offset, animation.fps)
    shown = replace(
        _shown(options, animation, writers),
        offset=offset,
        key_error=error,
        key_lines=lines,
        against=_against(options, animation),
    )

    def writing(path: Path) -> Callable[[Any], None]:
        return lambda stream: writers[path].write(shown, stream)

    outputs = {path: writing(path) for path in writers}
    if options.plot:
        outputs[options.plot] = _plotting(options, animation)
    write_all(outputs)
    print(_summary(shown, list(outputs)), file=sys.stderr)
    if options.schedule is None and performer.speaker.manner.weak:
        print(performer.speaker.manner.weak, file=sys.stderr)
    for remark in (*_recognised(options, performer), *_overriding(options, performer)):
        print(remark, file=sys.stderr)
    for remark in dict.fromkeys(r for writer in writers.values() for r in writer.remarks(shown)):
        print(as_options(remark), file=sys.stderr)
    if options.check:
        from lipsync_lang.quality.check_animation import check

        print(check(animation), file=sys.stderr)
    return SOUND


def _against(options: Namespace, animation: "Animation") -> "dict[str, Animation]":
    """Return the takes to compare with, on the requested model, with the same cut as the line."""
    from lipsync_lang.commands.comparing import takes_against

    found = takes_against(options, animation) if options.against else {}
    if options.model is not None:
        own, same = options.model, animation.performer.model
        found = {n: replace(t, model=own) if t.model == same else t for n, t in found.items()}
    return {n: t.cut() for n, t in found.items()} if options.cut else found


def _recognised(options: Namespace, performer: "Performer") -> Iterable[str]:
    """Return a remark on the pose set and rig that were chosen for a model."""
    from lipsync_lang.packs.finding import is_model

    if is_model(options.character):
        compiled = performer.compiled
        rig = f" through rig {compiled.rig['name']}" if compiled.rig else ""
        yield f"{options.character}: performed with the poses of {compiled.poseset}{rig}"


def _overriding(options: Namespace, performer: "Performer") -> Iterable[str]:
    """Return remarks on packs of the current folder that shadow built-in packs."""
    from lipsync_lang.packs.finding import Finder
    from lipsync_lang.packs.yaml.faults import shown

    finder, compiled = Finder(options.path), performer.compiled
    paths = (
        *finder.overriding("language", compiled.language),
        *finder.overriding("poseset", compiled.poseset),
        *finder.overriding("character", compiled.character),
    )
    return (f"{shown(path)} replaces the built-in pack of the same name" for path in paths)


def _shown(options: Namespace, animation: "Animation", paths: Iterable[Path]) -> "Animation":
    """Return the animation to write: rig channels of the character, or poses."""
    if not options.poses:
        animation = animation.performer.rigged(animation)
    if options.model is not None:
        animation = replace(animation, model=options.model)
    for path in paths:
        if animation.model is not None and os.path.realpath(path) == os.path.realpath(
            animation.model
        ):
            raise OutputError(f"{path}: is the model of the character; name another file")
    return animation.cut() if options.cut else animation


def _plotting(options: Namespace, animation: "Animation") -> Callable[[Any], None]:
    """Return the plot function: processing stages, or several faces stacked."""
    from lipsync_lang.render.beside import plot_beside
    from lipsync_lang.render.plot import plot

    kind = plot_kind(options.plot)
    if not options.beside:
        return lambda stream: plot(animation, stream, kind)
    others = [performer_for(options, name) for name in options.beside]
    faces = [animation, *(one.perform(animation.schedule, fps=options.fps) for one in others)]
    return lambda stream: plot_beside(faces, stream, kind)


def plot_kind(path: Path) -> str:
    """Return a picture's format from its suffix; PNG for standard output."""
    return "png" if path == STANDARD_STREAM else path.suffix.lstrip(".")


def _refuse_same(options: Namespace, outputs: list[Path]) -> None:
    """Refuse duplicate outputs and outputs that overwrite an input."""
    given = {"the input schedule": options.schedule, "the input recording": options.audio}
    taken = {
        os.path.realpath(path): what
        for what, path in given.items()
        if path and path != STANDARD_STREAM  # standard input and standard output are distinct
    }
    for path in (*outputs, *([options.plot] if options.plot else [])):
        real = "-" if path == STANDARD_STREAM else os.path.realpath(path)
        if real in taken:
            raise OutputError(f"{path}: is also {taken[real]}; name another file")
        taken[real] = "an output"


def _perform(options: Namespace) -> "Animation":
    performer = performer_for(options)
    return perform_line(options, performer, schedule_for(options, performer))


def perform_line(options: Namespace, performer: "Performer", schedule: "Schedule") -> "Animation":
    """Perform a line with the requested delivery options."""
    return performer.perform(
        schedule,
        fps=options.fps,
        line=options.line,
        styles=levels("--style", options.styles),
        dials=levels("--dial", options.dials),
        intensity=options.intensity,
    )


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
        options.language,
        character or options.character,
        paths=options.path,
        gaps=options.gaps,
        unknown=options.unknown,
        motion=motion_settings(options.settings),
        shades=options.shades,
    )
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


def schedule_for(options: Namespace, performer: "Performer") -> "Schedule":
    """Return timed phonemes of a text, a schedule file or a recording."""
    _refuse_idle(options)
    if options.schedule is not None:
        return _timed(options, performer)
    if options.audio is None:
        return performer.speaker.speak(options.text, engine=options.tts)
    from lipsync_lang.speech.hearing import aligned, recognised
    from lipsync_lang.speech.sound import read_audio

    speaker = performer.speaker
    audio = options.audio
    if options.audio_channel is not None:
        audio = read_audio(audio, options.audio_channel)
    with listening(f"listening to {options.audio}"):
        if options.text is None:
            return recognised(speaker, audio, recogniser=options.recogniser)
        return aligned(speaker, audio, options.text, aligner=options.aligner)


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
    from lipsync_lang.schedules.timed_words import TimedWords
    from lipsync_lang.schedules.timing_readers import read_timings

    found = read_timings(
        options.schedule,
        options.notation,
        read_as=options.read_as,
        tier=options.tier,
        rate=options.rate,
        encoding=options.encoding,
    )
    if isinstance(found, TimedWords):
        return _filled(options, performer, found)
    if options.audio is None:
        return found
    from lipsync_lang.speech.sound import with_sound

    return with_sound(found, options.audio, options.audio_channel)


def _filled(options: Namespace, performer: "Performer", words: "TimedWords") -> "Schedule":
    from lipsync_lang.speech.filling import filled
    from lipsync_lang.speech.sound import read_audio

    if options.notation is not None:
        raise LipsyncError(
            f"{options.schedule} has timed words, not phonemes; leave out --notation"
        )
    if options.audio is None:
        return filled(performer.speaker, words)
    with listening(f"listening to {options.audio}"):
        return filled(
            performer.speaker, words, audio=read_audio(options.audio, options.audio_channel)
        )


def _summary(animation: "Animation", written: list[Path]) -> str:
    from lipsync_lang.performing.label_remarks import label_remarks

    words = len(animation.schedule.words)
    spoken = count(len(animation.schedule), "phoneme")
    told = (
        f"{spoken}, {count(words, 'word') + ', ' if words else ''}"
        f"{animation.times[0]:.2f} to {animation.times[-1]:.2f} s, "
        f"{count(len(animation.times), 'frame')} of {count(len(animation.poses), 'pose')} "
        f"at {animation.fps:g} fps"
    )
    if animation.schedule.estimated:
        told += "\ntimes are estimated by classes of sounds; there is no voice"
    if animation.schedule.dropped:
        told += f"\nnot spoken: {listed(animation.schedule.dropped)}"
    if animation.schedule.unread:
        told += f"\nnot read: {' '.join(animation.schedule.unread)}"
    if animation.schedule.confidence is not None:
        how = "recognised" if animation.schedule.recognised else "aligned"
        told += f"\n{how} with a confidence of {animation.schedule.confidence:.2f}"
    remarks = (
        *animation.schedule.remarks,
        *label_remarks(animation.performer.labels, animation.schedule),
    )
    told += "".join(f"\n{as_options(remark)}" for remark in remarks)
    if not written:
        return f"{told}\nno file was written; name files with -o line.csv or --plot line.png"
    return told + "".join(f"\nwrote {path}" for path in written if path != STANDARD_STREAM)


def explain(options: Namespace) -> int:
    """Explain one frame."""
    explanation = _perform(options).explain(options.at)
    print(as_json(explanation.to_dict()) if options.json else explanation)
    return SOUND


def transcribe(options: Namespace) -> int:
    """Print the phonemes and common phonemes of texts, word by word."""
    from lipsync_lang.authoring.printing import transcript_table
    from lipsync_lang.speech.speaking import Speaker

    texts = [options.text] if options.text is not None else lines_of(options.file)
    speaker = Speaker.of(options.language, options.path, cleaning(options))
    heard = list(speaker.transcribe(texts))
    if options.json:
        print(as_json([speaker.told(transcript) for transcript in heard]))
    else:
        print("\n\n".join(transcript_table(speaker.told(t)) for t in heard))
    for transcript in heard:
        for remark in transcript.remarks:
            print(f"{transcript.text[:40]}: {remark}", file=sys.stderr)
    if speaker.manner.weak:
        print(speaker.manner.weak, file=sys.stderr)
    lost = [t for t in heard if t.unmapped or t.unread]
    for transcript in lost:
        for what, which in (
            ("no mapping for", transcript.unmapped),
            ("not read:", transcript.unread),
        ):
            if which:
                print(f"{transcript.text[:40]}: {what} {' '.join(which)}", file=sys.stderr)
    return FAULTS if any(t.unmapped for t in lost) else SOUND
