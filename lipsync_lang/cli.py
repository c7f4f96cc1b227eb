"""The command line: parse, call, print. What a command does is done elsewhere.

Data goes to stdout, words to stderr. Exit 0: sound; 1: faults were found; 2: misuse.
"""

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang import __version__
from lipsync_lang.errors import LipsyncError, OutputError

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule

SOUND, FAULTS, MISUSE = 0, 1, 2

Command = Callable[[argparse.Namespace], int]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    options = parser().parse_args(arguments)
    command: Command = options.command
    try:
        code = command(options)
        sys.stdout.flush()
    except LipsyncError as error:
        print(f"lipsync-lang: {error}", file=sys.stderr)
        return FAULTS if hasattr(error, "faults") else MISUSE
    except BrokenPipeError:  # the reader of our output has seen enough
        sys.stdout = None
        return SOUND
    except KeyboardInterrupt:
        return 130
    return code


def parser() -> argparse.ArgumentParser:
    """Describe every command; `docs/reference/commands.md` is printed from this."""
    top = argparse.ArgumentParser(
        prog="lipsync-lang",
        description="Lip sync for any language and any character, from data you can edit.",
        epilog="Try: lipsync-lang run 'Hello, world' -l english -c facefx -o hello.csv",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"lipsync-lang {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def add(name: str, command: Command, title: str, example: str) -> argparse.ArgumentParser:
        made = commands.add_parser(
            name,
            help=title,
            description=f"{title[0].upper()}{title[1:]}.",
            epilog=f"example:\n  lipsync-lang {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(command=command)
        return made

    run_ = add(
        "run",
        run,
        "animate text or timed phonemes",
        "run 'Hello, world' -l english -c facefx -o hello.csv -o hello.wav --plot hello.png",
    )
    _add_line(run_)
    run_.add_argument(
        "-o", "--output", metavar="FILE", type=Path, action="append", default=[],
        help="write the animation; the suffix names the format, and -o may be repeated",
    )  # fmt: skip
    run_.add_argument("--plot", metavar="FILE", type=Path, help="draw every stage to a picture")
    run_.add_argument("--cut", action="store_true", help="leave out lead-in and tail")

    explain_ = add(
        "explain",
        explain,
        "say why each pose stands where it stands at a time",
        "explain 'Hello, world' -l english -c facefx --at 0.42",
    )
    _add_line(explain_)
    explain_.add_argument(
        "--at", metavar="SECONDS", type=float, required=True, help="the time asked about"
    )
    _add_json(explain_)

    resolve_ = add(
        "resolve",
        resolve,
        "show what of a language-character pair comes from which layer, and its gaps",
        "resolve -l english -c facefx",
    )
    _add_pair(resolve_)
    _add_json(resolve_)

    validate_ = add(
        "validate",
        validate,
        "list every fault of every pack found, or of the files given",
        "validate languages/finnish.yaml",
    )
    validate_.add_argument("paths", metavar="PATH", type=Path, nargs="*", help="a file or a folder")
    _add_path(validate_)
    _add_json(validate_)

    schema_ = add(
        "schema",
        schema,
        "print the JSON Schema of a kind of pack",
        "schema language > language.json",
    )
    schema_.add_argument("kind", metavar="KIND", nargs="?", help="without it, the kinds are listed")

    for kind, title in (
        ("languages", "list language packs, or show one"),
        ("posesets", "list pose sets, or show one"),
        ("characters", "list characters, or show one"),
    ):
        packs_ = add(kind, packs, title, f"{kind} list")
        packs_.set_defaults(kind=kind[:-1])
        packs_.add_argument("action", choices=("list", "show"), nargs="?", default="list")
        packs_.add_argument("name", metavar="NAME", nargs="?", help="the pack to show")
        _add_path(packs_)
        _add_json(packs_)

    bank_ = add(
        "bank", bank, "draft bigrams to look at or to edit", "bank draft -l english -c facefx"
    )
    actions = bank_.add_subparsers(title="actions", metavar="ACTION", required=True)
    draft_ = actions.add_parser(
        "draft",
        help="draft bigrams from a pose set's targets",
        description="Draft bigrams from a pose set's targets, as YAML to look at or to edit.",
        epilog="example:\n  lipsync-lang bank draft -l english -c facefx --write l-ow h-eh",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    draft_.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    _add_pair(draft_)
    draft_.add_argument(
        "--write", action="store_true", help="put them into a bank; what is there already stays"
    )
    draft_.add_argument(
        "--to", metavar="FILE", type=Path,
        help="the bank to write to [posesets/NAME/banks/common.yaml of this folder]",
    )  # fmt: skip

    formats_ = add("formats", formats, "list what can be read and written", "formats")
    _add_json(formats_)
    return top


def _add_path(made: argparse.ArgumentParser) -> None:
    made.add_argument(
        "--path", metavar="FOLDER", type=Path, action="append", default=[],
        help="look for packs here first; may be repeated",
    )  # fmt: skip


def _add_json(made: argparse.ArgumentParser) -> None:
    made.add_argument("--json", action="store_true", help="print JSON")


def _add_pair(made: argparse.ArgumentParser) -> None:
    made.add_argument(
        "-l", "--language", metavar="LANGUAGE", required=True, help="name or tag of a language"
    )
    made.add_argument(
        "-c", "--character", metavar="CHARACTER", required=True, help="a character or a pose set"
    )
    _add_path(made)


def _add_line(made: argparse.ArgumentParser) -> None:
    made.add_argument("text", metavar="TEXT", nargs="?", help="what to say")
    _add_pair(made)
    made.add_argument(
        "--schedule", metavar="FILE", type=Path, help="timed phonemes, instead of text"
    )
    made.add_argument("--notation", metavar="NAME", help="the notation of the schedule's labels")
    made.add_argument("--tts", metavar="ENGINE", help="another speech engine than the language's")
    made.add_argument("--fps", metavar="N", type=float, default=60.0, help="frames per second [60]")
    made.add_argument(
        "--set", metavar="motion.NAME=VALUE", action="append", default=[], dest="settings",
        help="change a motion setting, or take a preset: --set motion=paper",
    )  # fmt: skip
    made.add_argument(
        "--gaps", choices=("error", "rest"), default="error",
        help="bigrams that nothing answers [error]",
    )  # fmt: skip
    made.add_argument(
        "--unknown", choices=("error", "rest"), default="error",
        help="labels that no notation maps [error]",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Animate a line and write it wherever it is wanted."""
    from lipsync_lang.animations.registry import find_writer
    from lipsync_lang.files import write_all

    writers = {path: find_writer(path) for path in options.output}
    if len(writers) < len(options.output):
        raise OutputError("two outputs have the same name")
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
    print(_summary(animation, list(outputs)), file=sys.stderr)
    return SOUND


def _perform(options: argparse.Namespace) -> "Animation":
    from dataclasses import replace

    performer = _performer(options)
    performer = replace(performer, unknown=options.unknown)
    return performer.perform(_schedule(options, performer), fps=options.fps)


def _performer(options: argparse.Namespace) -> "Performer":
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


def _schedule(options: argparse.Namespace, performer: "Performer") -> "Schedule":
    from lipsync_lang.schedules.registry import read_schedule
    from lipsync_lang.speaking import speak_as

    if (options.text is None) == (options.schedule is None):
        raise LipsyncError("give either a TEXT to speak or timed phonemes with --schedule FILE")
    if options.schedule is not None:
        return read_schedule(options.schedule, notation=options.notation)
    voice = performer.compiled.voice
    return speak_as(options.text, performer.language, voice, engine=options.tts)


def _summary(animation: "Animation", written: list[Path]) -> str:
    words = len(animation.schedule.words)
    told = (
        f"{len(animation.schedule)} phonemes{f', {words} words' if words else ''}, "
        f"{animation.times[0]:.2f} to {animation.times[-1]:.2f} s, {len(animation.times)} frames "
        f"of {len(animation.poses)} poses at {animation.fps:g} fps"
    )
    if not written:
        return f"{told}\nnothing was written; name files with -o line.csv or --plot line.png"
    return told + "".join(f"\nwrote {path}" for path in written)


def explain(options: argparse.Namespace) -> int:
    """Explain one frame."""
    explanation = _perform(options).explain(options.at)
    print(_json(explanation.to_dict()) if options.json else explanation)
    return SOUND


def resolve(options: argparse.Namespace) -> int:
    """Print a resolver's report; gaps are faults."""
    from dataclasses import asdict

    from lipsync_lang.resolver import resolve as resolve_pair

    report = resolve_pair(
        options.language, options.character, paths=options.path, gaps="rest"
    ).report
    print(_json(asdict(report)) if options.json else report)
    return FAULTS if report.gaps else SOUND


def validate(options: argparse.Namespace) -> int:
    """Print every fault; warnings alone leave the packs sound."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.validate import validate as find_faults

    library = Library(options.path)
    faults = find_faults(library, options.paths or None)
    if options.json:
        print(_json([fault.to_dict() for fault in faults]))
    else:
        for fault in faults:
            print(fault)
    real = sum(fault.severity == "fault" for fault in faults)
    print(f"{real} faults, {len(faults) - real} warnings", file=sys.stderr)
    return FAULTS if real else SOUND


def schema(options: argparse.Namespace) -> int:
    """Print a schema, or the kinds that have one."""
    from lipsync_lang.packs.schema import kinds
    from lipsync_lang.packs.schema import schema as make_schema

    if options.kind is None:
        print("\n".join(kinds()))
    else:
        print(_json(make_schema(options.kind)))
    return SOUND


def packs(options: argparse.Namespace) -> int:
    """List packs of a kind, shadowed ones included, or show one."""
    from lipsync_lang.packs import describe
    from lipsync_lang.packs.library import Library

    library = Library(options.path)
    if options.action == "show":
        if options.name is None:
            raise LipsyncError(f"name the {options.kind} to show")
        told = describe.show(library, options.kind, options.name)
    else:
        told = describe.listing(library, options.kind)
    print(_json(told.data) if options.json else told.text)
    return SOUND


def bank(options: argparse.Namespace) -> int:
    """Draft bigrams; print them as YAML or put them into a bank."""
    from lipsync_lang.banks.write import draft_bigrams, draft_yaml, write_drafts
    from lipsync_lang.packs.library import Library

    library = Library(options.path)
    drafts = draft_bigrams(library, options.language, options.character, options.bigrams)
    if options.write or options.to:
        print(write_drafts(drafts, options.to), file=sys.stderr)
    else:
        print(draft_yaml(drafts), end="")
    return SOUND


def formats(options: argparse.Namespace) -> int:
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


def _json(data: object) -> str:
    return json.dumps(data, ensure_ascii=False, indent=2, default=str)


if __name__ == "__main__":
    sys.exit(main())
