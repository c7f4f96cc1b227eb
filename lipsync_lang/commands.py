"""What the commands do: call, print. What is worth knowing is done elsewhere.

Data goes to stdout, words to stderr; each command returns its exit code.
"""

import json
import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.errors import LipsyncError, OutputError

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.packs.faults import Fault
    from lipsync_lang.packs.library import Library
    from lipsync_lang.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule

SOUND, FAULTS, MISUSE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""


def run(options: Namespace) -> int:
    """Animate a line and write it wherever it is wanted."""
    from lipsync_lang.animations.registry import find_writer
    from lipsync_lang.files import write_all

    _refuse_same(options)
    writers = {path: find_writer(path) for path in options.output}
    animation = _perform(options)
    shown = animation.cut() if options.cut else animation

    def writing(path: Path) -> Callable[[Any], None]:
        return lambda stream: writers[path].write(shown, stream)

    outputs = {path: writing(path) for path in writers}
    if options.plot:
        from lipsync_lang.render.plot import plot

        picture = options.plot
        outputs[picture] = lambda stream: plot(animation, stream, picture.suffix.lstrip("."))
    write_all(outputs)
    print(_summary(shown, list(outputs)), file=sys.stderr)
    return SOUND


def _refuse_same(options: Namespace) -> None:
    """Refuse to write a file twice, or over the schedule."""
    taken = {os.path.realpath(options.schedule): "the schedule"} if options.schedule else {}
    for path in (*options.output, *([options.plot] if options.plot else [])):
        real = os.path.realpath(path)
        if real in taken:
            raise OutputError(f"{path}: is {taken[real]} already; name another file")
        taken[real] = "an output"


def _perform(options: Namespace) -> "Animation":
    from dataclasses import replace

    performer = _performer(options)
    performer = replace(performer, unknown=options.unknown)
    schedule = _schedule(options, performer)
    return performer.perform(schedule, fps=options.fps, line=options.line)


def _performer(options: Namespace) -> "Performer":
    from lipsync_lang.resolver import resolve as resolve_pair

    return resolve_pair(
        options.language,
        options.character,
        paths=options.path,
        gaps=options.gaps,
        motion=_motion(options.settings),
    )


def _motion(settings: list[str]) -> dict[str, object]:
    """Read ``motion.window=0.1`` and ``motion=paper``."""
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


def _schedule(options: Namespace, performer: "Performer") -> "Schedule":
    from lipsync_lang.schedules.registry import read_schedule

    if (options.text is None) == (options.schedule is None):
        raise LipsyncError("give either a TEXT to speak or timed phonemes with --schedule FILE")
    if options.schedule is not None:
        if options.tts is not None:
            raise LipsyncError("--tts speaks a TEXT; leave it out with --schedule")
        return read_schedule(options.schedule, notation=options.notation)
    if options.notation is not None:
        raise LipsyncError("--notation is that of a --schedule; leave it out with a TEXT")
    return performer.speaker.speak(options.text, engine=options.tts)


def _summary(animation: "Animation", written: list[Path]) -> str:
    words = len(animation.schedule.words)
    spoken = _count(len(animation.schedule), "phoneme")
    told = (
        f"{spoken}, {_count(words, 'word') + ', ' if words else ''}"
        f"{animation.times[0]:.2f} to {animation.times[-1]:.2f} s, "
        f"{_count(len(animation.times), 'frame')} of {_count(len(animation.poses), 'pose')} "
        f"at {animation.fps:g} fps"
    )
    if animation.schedule.estimated:
        told += "\ntimes are estimated by classes of sounds; nothing speaks them"
    if animation.schedule.unread:
        told += f"\nnot read: {' '.join(animation.schedule.unread)}"
    if not written:
        return f"{told}\nnothing was written; name files with -o line.csv or --plot line.png"
    return told + "".join(f"\nwrote {path}" for path in written)


def explain(options: Namespace) -> int:
    """Explain one frame."""
    explanation = _perform(options).explain(options.at)
    print(_json(explanation.to_dict()) if options.json else explanation)
    return SOUND


def resolve(options: Namespace) -> int:
    """Print a resolver's report; gaps are faults."""
    from dataclasses import asdict

    from lipsync_lang.resolver import resolve as resolve_pair

    report = resolve_pair(
        options.language, options.character, paths=options.path, gaps="rest"
    ).report
    print(_json(asdict(report)) if options.json else report)
    return FAULTS if report.gaps else SOUND


def validate(options: Namespace) -> int:
    """Print every fault; warnings alone leave the packs sound."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.validate import validate as find_faults

    library = Library(options.path)
    faults = find_faults(library, options.paths or None)
    if not options.no_tests:
        faults = sorted({*faults, *_failing(library, options.paths)})
    if options.json:
        print(_json([fault.to_dict() for fault in faults]))
    else:
        for fault in faults:
            print(fault)
    real = sum(fault.severity == "fault" for fault in faults)
    warned = _count(len(faults) - real, "warning")
    print(f"{_count(real, 'fault')}, {warned}", file=sys.stderr)
    return FAULTS if real else SOUND


def _failing(library: "Library", paths: list[Path]) -> Iterator["Fault"]:
    """Try the tests of the languages in question, telling which is at work."""
    from lipsync_lang.authoring.trial import doubts, languages_in, try_out

    silence = library.common().model.silence
    for pack in languages_in(library, paths):
        with _working(f"trying {pack.model.name}"):
            yield from try_out(library, pack).faults(silence)
            yield from doubts(library, pack)


@contextmanager
def _working(what: str) -> Iterator[None]:
    """Say on a terminal what is at work, and wipe it out afterwards."""
    shows = sys.stderr is not None and sys.stderr.isatty()
    if shows:
        print(f"{what} ...", end="\r", file=sys.stderr, flush=True)
    try:
        yield
    finally:
        if shows:
            print("\x1b[2K", end="\r", file=sys.stderr, flush=True)


def schema(options: Namespace) -> int:
    """Print a schema, or the kinds that have one."""
    from lipsync_lang.packs.schema import kinds
    from lipsync_lang.packs.schema import schema as make_schema

    if options.kind is None:
        print("\n".join(kinds()))
    else:
        print(_json(make_schema(options.kind)))
    return SOUND


def packs(options: Namespace) -> int:
    """List packs of a kind, shadowed ones included, or show one."""
    from lipsync_lang.packs import describe
    from lipsync_lang.packs.library import Library

    library = Library(options.path)
    if options.action == "new":
        return _new_language(library, options)
    if options.action == "show":
        if options.name is None:
            raise LipsyncError(f"name the {options.kind} to show: {options.kind}s show NAME")
        if options.kind == "language":
            return _show_language(library, options)
        told = describe.show(library, options.kind, options.name)
    elif options.name is not None:
        raise LipsyncError(f"list takes no name; did you mean: {options.kind}s show {options.name}")
    else:
        told = describe.listing(library, options.kind)
    print(_json(told.data) if options.json else told.text)
    return SOUND


def _new_language(library: "Library", options: Namespace) -> int:
    from lipsync_lang.authoring.draft import Wanted, draft

    if options.name is None:
        raise LipsyncError("name the new language: languages new NAME --voice sw")
    wanted = Wanted(
        options.name,
        tag=options.tag,
        title=options.title,
        voice=options.voice,
        epitran=options.epitran,
        lexicon=options.lexicon,
        inventory=options.inventory,
        inventory_id=options.inventory_id,
        texts=_lines(options.text) if options.text else (),
    )
    with _working(f"drafting {options.name}"):
        made = draft(library, wanted)
    print(made.write(), file=sys.stderr)
    return SOUND


def _show_language(library: "Library", options: Namespace) -> int:
    from lipsync_lang.authoring.language import describe
    from lipsync_lang.authoring.table import language_table

    with _working(f"trying {options.name}"):
        told = describe(library, library.language(options.name))
    print(_json(told) if options.json else language_table(told))
    return SOUND


def bank(options: Namespace) -> int:
    """Draft bigrams; print them as YAML or put them into a bank."""
    from lipsync_lang.banks.write import draft_yaml, write_drafts
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.drafts import draft_bigrams

    library = Library(options.path)
    drafts = draft_bigrams(library, options.language, options.character, options.bigrams)
    if options.write or options.to:
        print(write_drafts(drafts, options.to), file=sys.stderr)
    else:
        print(draft_yaml(drafts), end="")
    return SOUND


def transcribe(options: Namespace) -> int:
    """Print what texts become: their phonemes and common phonemes, word by word."""
    from lipsync_lang.authoring.table import transcript_table
    from lipsync_lang.speaking import Speaker

    texts = [options.text] if options.text is not None else _lines(options.file)
    speaker = Speaker.of(options.language, options.path)
    heard = list(speaker.transcribe(texts))
    if options.json:
        print(_json([speaker.told(transcript) for transcript in heard]))
    else:
        print("\n\n".join(transcript_table(speaker.told(t)) for t in heard))
    lost = [t for t in heard if t.unmapped or t.unread]
    for transcript in lost:
        for what, which in (("no map for", transcript.unmapped), ("not read:", transcript.unread)):
            if which:
                print(f"{transcript.text[:40]}: {what} {' '.join(which)}", file=sys.stderr)
    return FAULTS if any(t.unmapped for t in lost) else SOUND


def _lines(file: Path | None) -> list[str]:
    """Return the lines of a file that hold text."""
    if file is None:
        raise LipsyncError("give a TEXT, or a file of lines with --file FILE")
    try:
        lines = file.read_text("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise LipsyncError(
            f"{file}: is not UTF-8 text (byte {error.start}); save it as UTF-8"
        ) from None
    return [line for line in lines if line.strip()]


def voices(options: Namespace) -> int:
    """Print the voices of a speech engine."""
    from lipsync_lang.authoring.table import columns
    from lipsync_lang.errors import did_you_mean
    from lipsync_lang.speech import ENGINES

    if options.engine not in ENGINES:
        raise LipsyncError(
            f"no speech engine '{options.engine}'; {did_you_mean(options.engine, ENGINES)}"
        )
    found = ENGINES[options.engine].voices()
    print(_json(found) if options.json else "\n".join(columns(sorted(found.items()))))
    return SOUND


def formats(options: Namespace) -> int:
    """Print every registered reader and writer."""
    from lipsync_lang.animations.registry import load_writers
    from lipsync_lang.schedules.registry import load_readers

    rows = [
        *(("read", r.name, " ".join(r.suffixes), r.title) for r in load_readers().values()),
        *(("write", w.name, w.suffix, w.title) for w in load_writers().values()),
    ]
    if options.json:
        keys = ("direction", "name", "suffix", "title")
        print(_json([dict(zip(keys, row, strict=True)) for row in rows]))
    else:
        for direction, name, suffix, title in rows:
            print(f"{direction:<6}{name:<10}{suffix:<12}{title}")
    return SOUND


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


def _json(data: object) -> str:
    """Return JSON that the output can hold."""
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    plain = not encoding.lower().startswith("utf")
    return json.dumps(data, ensure_ascii=plain, indent=2, default=str)
