"""The command that animates a line, and writes it to files."""

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.animations.rates import parse_offset
from lipsync_lang.base.errors import LipsyncError, OutputError, count
from lipsync_lang.base.files import STANDARD_STREAM, write_all
from lipsync_lang.commands.output import SOUND, as_options, listed, tell_all
from lipsync_lang.commands.performing import (
    LINE_PAGE,
    perform_line,
    performer_for,
    plot_kind,
    schedule_for,
)
from lipsync_lang.commands.registry import handler

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.animations.animation_writers import Writer
    from lipsync_lang.performing.performer import Performer


@handler(
    "run",
    "animate text or timed phonemes",
    'run "Hello, world" -l english -c facefx -o hello.csv -o hello.wav -o hello.html',
)
def run(options: Namespace) -> int:
    """Animate a line, and write it to all requested outputs."""
    from lipsync_lang.animations.animation import ExportSettings
    from lipsync_lang.animations.animation_writers import parse_output

    error, lines = _keys(options.keys)
    writers = dict(map(parse_output, options.output))
    # With the list as given: in the dictionary, the second of two equal outputs hides the first.
    _refuse_same(options, [path for path, _ in map(parse_output, options.output)])
    if options.against and not any(writer.name == LINE_PAGE for writer in writers.values()):
        raise LipsyncError("--against needs a page; name it with -o line.html")
    performer = performer_for(options)
    formats = {str(path): [writer.name] for path, writer in writers.items()}
    formats |= {str(options.plot): ["plot"]} if options.plot else {}
    schedule = schedule_for(options, performer, formats)
    # takes of other methods have no gestures, and a comparison is of the lips
    watched = any(writer.shows for writer in writers.values())
    usual = "all" if watched and not options.against else None
    animation = perform_line(options, performer, schedule, usual)
    offset = parse_offset(options.offset, animation.fps)
    shown = _shown(options, performer, animation, writers)
    against = _against(options, performer, animation)
    own = {"pose_names": options.poses, "frame_rate": options.stated_fps}
    shown = replace(shown, export=ExportSettings(offset, error, lines, against, **own))
    # Files that people watch have gestures unasked, and files for engines only on request.
    spoken = shown if options.gestures is not None else shown.without_gestures()
    outputs: dict[Path, Callable[[Any], None]] = {
        path: partial(one.write, shown if one.shows else spoken) for path, one in writers.items()
    }
    if options.plot:
        outputs[options.plot] = _plotting(options, animation.without_gestures())
    write_all(outputs)
    print(_summary(performer, spoken, list(outputs)), file=sys.stderr)
    tell_all(_remarks(options, performer, spoken, writers.values()))
    if options.check:
        from lipsync_lang.reports.quality.check_animation import check

        print(check(spoken), file=sys.stderr)
    return SOUND


def _keys(text: str | None) -> tuple[float | None, bool]:
    """Parse `--keys`, without an import if it is not given."""
    if text is None:
        return None, False
    from lipsync_lang.animations.keys import parse_keys

    return parse_keys(text)


def _against(
    options: Namespace, performer: "Performer", animation: "Animation"
) -> "dict[str, Animation]":
    """Return the takes to compare with, on the requested model, with the same cut as the line."""
    found = {name: _take(options, performer, animation, name) for name in options.against}
    if options.model is not None:
        own, same = options.model, performer.model
        found = {n: replace(t, model=own) if t.model == same else t for n, t in found.items()}
    return {n: t.cut() for n, t in found.items()} if options.cut else found


def _remarks(
    options: Namespace, performer: "Performer", spoken: "Animation", writers: "Iterable[Writer]"
) -> Iterator[str]:
    """Yield remarks on the language, the character and the files of a line."""
    from lipsync_lang.packs.finding import is_model

    compiled = performer.compiled
    if options.schedule is None and performer.speaker.manner.weak:
        yield performer.speaker.manner.weak
    if is_model(options.character):
        rig = f" through rig {compiled.rig['name']}" if compiled.rig else ""
        yield f"{options.character}: performed with the poses of {compiled.poseset}{rig}"
    yield from _overriding(options, performer)
    # a model without a bone or shape of gestures that nobody asked for is no cause for a remark
    remarks = dict.fromkeys(remark for writer in writers for remark in writer.remarks(spoken))
    yield from (as_options(remark) for remark in remarks if remark not in compiled.report.idle)


def _overriding(options: Namespace, performer: "Performer") -> Iterable[str]:
    """Return remarks on packs of the current folder that shadow built-in packs."""
    from lipsync_lang.packs.finding import Finder, Kind
    from lipsync_lang.packs.yaml.pack_files import shown

    finder, compiled = Finder(options.path), performer.compiled
    kinds: tuple[Kind, ...] = ("language", "poseset", "character")
    paths = (path for kind in kinds for path in finder.overriding(kind, getattr(compiled, kind)))
    return (f"{shown(path)} replaces the built-in pack of the same name" for path in paths)


def _shown(
    options: Namespace, performer: "Performer", animation: "Animation", paths: Iterable[Path]
) -> "Animation":
    """Return the animation to write: rig channels of the character, or poses."""
    if not options.poses:
        animation = performer.rigged(animation)
    if options.model is not None:
        animation = replace(animation, model=options.model)
    model = animation.model and os.path.realpath(animation.model)
    for path in paths:
        if model and os.path.realpath(path) == model:
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


def _refuse_same(options: Namespace, outputs: list[Path]) -> None:
    """Refuse a file as the text, idle options, and outputs that overwrite an input or another."""
    if options.beside and not options.plot:
        raise LipsyncError("--beside draws a picture; name it with --plot FILE")
    if options.text and Path(options.text).suffix and os.path.isfile(options.text):  # noqa: PTH113 any text
        raise LipsyncError(
            f"{options.text}: is a file, and TEXT is the text to say; `lipsync-lang new --from "
            "TABLE` and `build` make all lines of a script, and --schedule reads timings"
        )
    given = {"the input schedule": options.schedule, "the input recording": options.audio}
    taken = {
        os.path.realpath(path): what
        for what, path in given.items()
        if path and path != STANDARD_STREAM  # standard input and standard output are distinct
    }
    for path in (*outputs, *([options.plot] if options.plot else [])):
        # Two names of one file, by a link or by `./`, would overwrite each other.
        real = "-" if path == STANDARD_STREAM else os.path.realpath(path)
        if real in taken:
            raise OutputError(f"{path}: is also {taken[real]}; name another file")
        taken[real] = "an output"


def _summary(performer: "Performer", animation: "Animation", written: list[Path]) -> str:
    from lipsync_lang.performing.label_reader import label_remarks

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
    remarks = (*animation.schedule.remarks, *label_remarks(performer.labels, animation.schedule))
    told += "".join(f"\n{as_options(remark)}" for remark in remarks)
    if not written:
        return f"{told}\nno file was written; name files with -o line.csv or --plot line.png"
    return told + "".join(f"\nwrote {path}" for path in written if path != STANDARD_STREAM)


def _take(
    options: Namespace, performer: "Performer", animation: "Animation", name: str
) -> "Animation":
    from lipsync_lang.animations.animation_readers import ANIMATION_READERS
    from lipsync_lang.reports.quality.baselines import BASELINES
    from lipsync_lang.reports.quality.fitting import on_model, read_for

    if name in BASELINES:
        return on_model(BASELINES[name](performer, animation.schedule, options.fps), performer)
    path = Path(name)
    if path.is_file() or path.suffix.lower() in ANIMATION_READERS.suffixes():
        read, _ = read_for(performer, path, animation.schedule)
        return on_model(read, performer)
    try:
        other = performer_for(options, name)
    except LipsyncError as error:
        known = ", ".join(BASELINES)
        what = f"--against {name}: not a file, a plain method ({known}) or a character: {error}"
        raise LipsyncError(what) from None
    return other.rigged(other.perform(animation.schedule, options.fps))
