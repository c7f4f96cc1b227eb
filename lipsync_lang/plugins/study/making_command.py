"""The commands that make a study and collect its answers."""

import argparse
import sys
from argparse import Namespace
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang import LipsyncError
from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.base.errors import count
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.files import argument_path
from lipsync_lang.base.files.reading import input_text
from lipsync_lang.base.terminal import progress
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, working
from lipsync_lang.commands.performing import motion_settings
from lipsync_lang.commands.registry import Add, command, family
from lipsync_lang.commands.shared_options import add_options, cleaning, option, repeated

if TYPE_CHECKING:
    from lipsync_lang import Performer
    from lipsync_lang.plugins.study.methods import Method, StudyCharacter
    from lipsync_lang.plugins.study.study_maker import StudyPlan
MAX_CONSENT_BYTES = 100_000

MAX_PAGE_BYTES = 60 * 10**6
"""Size of a page in bytes above which a phone may refuse it."""


family(
    "study", "ask people which of two methods they prefer, and report their choices",
    "study report study/",
)  # fmt: skip


@command("study new")
def _add_new(action: Add) -> None:
    new_ = action(
        new,
        "render pairs of clips, and write a page for raters to choose the better one",
        "study new script.csv -l english -c facefx --method ours --method keyframes --pairs 40 "
        "-o study",
    )
    _add_lines(new_)
    _add_clips(new_)
    _add_page(new_)
    option(
        new_, "-o, --output FOLDER", "the folder of the study; it must not hold another study",
        type=Path, required=True,
    )  # fmt: skip
    option(new_, "--workers N", "number of processes [one per core]", type=partial(_number, 1))
    add_options(new_, ["json"])


@command("study serve")
def _add_serve(action: Add) -> None:
    made = action(
        serve,
        "serve the page of a study, and append answers to a file",
        "study serve study --port 8080",
    )
    made.add_argument("folder", metavar="FOLDER", type=Path, help="the folder of the study")
    option(
        made, "--host ADDRESS",
        "the address to listen on; 0.0.0.0 admits other machines [127.0.0.1]", default="127.0.0.1",
    )  # fmt: skip
    option(made, "--port N", "the port [a free one]", type=int, default=0)
    repeated(
        made, "--origin URL",
        "a public address of the page, such as https://example.org; null for pages that are "
        "opened from files; may be repeated",
    )  # fmt: skip


def _add_lines(made: argparse.ArgumentParser) -> None:
    """Add the lines, and the options for reading and speaking them."""
    made.add_argument(
        "lines", metavar="LINES", nargs="*", type=argument_path,
        help="files or folders of lines: scripts, tables, timings; - is standard input",
    )  # fmt: skip
    lines = made.add_argument_group("lines")
    repeated(lines, "--text TEXT", "an additional line; may be repeated")
    option(lines, "--column NAME", "the text's column in tables, by name or number")
    option(lines, "--encoding NAME", "the encoding of all files [UTF-8]")
    add_options(lines, ["values", "language"])
    option(
        lines, "--audio FOLDER", "recordings named after the lines, instead of a voice", type=Path
    )
    option(lines, "--tts ENGINE", "speech engine [the language's]")


def _add_clips(made: argparse.ArgumentParser) -> None:
    """Add the methods and characters, and the options of the clips."""
    compared = made.add_argument_group("comparison")
    repeated(
        compared, "--method METHOD",
        "ours, keyframes, dominance, held, NAME=FOLDER of files named after the lines, "
        "NAME=character:OTHER, NAME=bank:FILE or NAME=motion:PRESET; give two or more",
    )  # fmt: skip
    for spelled, least, told in (
        ("--pairs N", 1, "largest number of pairs, chosen evenly [all]"),
        ("--checks N", 0, "number of attention checks [one for every ten pairs]"),
        ("--raters-see N", 1, "number of pairs that each rater sees [all]"),
    ):
        option(compared, spelled, told, type=partial(_number, least))
    option(compared, "--seed N", "seed of all random choices [1]", type=int, default=1)
    clips = made.add_argument_group("clips")
    repeated(
        clips, "-c, --character CHARACTER",
        "a character or a pose set [the project's]; may be repeated",
    )  # fmt: skip
    option(clips, "--model GLB", "film this model instead of the characters' own", type=Path)
    option(clips, "--fps N", "frames per second [30]", type=parse_rate, default=30.0)
    repeated(
        clips, "--set motion.NAME=VALUE",
        "change a motion setting of every method, or use a preset: --set motion=paper",
        dest="settings",
    )  # fmt: skip
    add_options(clips, ["path"])


def _add_page(made: argparse.ArgumentParser) -> None:
    """Add the texts and questions of the page."""
    page = made.add_argument_group("text and questions of the page")
    option(
        page, "--title TEXT", "the page's title [Which face speaks better?]",
        default="Which face speaks better?",
    )  # fmt: skip
    option(
        page, "--consent FILE", "the text that raters agree to [a plain one]; - is standard input",
        type=argument_path,
    )  # fmt: skip
    repeated(
        page, "--ask 'LABEL: A|B'", "a question about the rater, with its choices; may be repeated"
    )
    repeated(
        page, "--question", "ask this of each pair [both]; may be repeated",
        choices=("accuracy", "naturalness"),
    )  # fmt: skip
    option(page, "--post URL", "send the answers to this address [save them as a file]")


def _number(least: int, text: str) -> int:
    if not (text.isascii() and text.isdecimal() and int(text) >= least):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of {least} or more")
    return int(text)


def new(options: Namespace) -> int:
    """Render the clips of a study, and write its key and its page."""
    from lipsync_lang.plugins.study.study_file import STUDY_NAME
    from lipsync_lang.plugins.study.study_maker import PAGE, make_study

    plan = _plan(options)
    with working("making the study"):
        made = make_study(
            plan,
            options.output,
            workers=options.workers,
            told=lambda what, done, of: progress(f"{what} {done} of {of} ..."),
        )
    checks = sum(pair.check is not None for pair in made.study.pairs)
    key, page = options.output / STUDY_NAME, options.output / PAGE
    if options.json:
        facts = {"study": made.study.study, "pairs": len(made.study.pairs), "checks": checks}
        done = {"rendered": made.rendered, "page_bytes": made.page_bytes}
        print(as_json(facts | done | {"left_out": made.remarks}))
    told = (
        f"{count(len(made.study.pairs) - checks, 'pair')}, {count(checks, 'attention check')}, "
        f"{count(made.rendered, 'clip')} rendered, page of {made.page_bytes / 1e6:.1f} MB"
    )
    if made.page_bytes > MAX_PAGE_BYTES:
        told += f"\nthe page is larger than {MAX_PAGE_BYTES // 10**6} MB; give fewer --pairs"
    print("\n".join((told, *made.remarks)), file=sys.stderr)
    print(f"wrote {key} for you and {page} for raters", file=sys.stderr)
    return FAULTS if made.remarks else SOUND


def _plan(options: Namespace) -> "StudyPlan":
    from lipsync_lang.plugins.study.methods import parse_methods
    from lipsync_lang.plugins.study.study_lines import study_lines
    from lipsync_lang.plugins.study.study_maker import StudyPlan
    from lipsync_lang.plugins.study.study_page import CONSENT, PageTexts, parse_asked
    from lipsync_lang.text.lines import read_lines

    remark = partial(print, file=sys.stderr)
    methods = parse_methods(options.method)
    how = {"column": options.column, "encoding": options.encoding, "cleaning": cleaning(options)}
    found = read_lines(options.lines, remark=remark, **how)
    lines = study_lines(found, options.text, options.audio, remark)
    characters = tuple(_cast(options, name) for name in dict.fromkeys(options.character))
    consent = CONSENT
    if options.consent is not None:
        consent = input_text(options.consent, MAX_CONSENT_BYTES, mend="shorten it")
        consent = consent.replace("\r\n", "\n")
    texts = PageTexts(consent, tuple(map(parse_asked, options.ask)), options.post)
    questions = tuple(dict.fromkeys(options.question)) or StudyPlan.questions
    return StudyPlan(
        lines, characters, methods, options.title, texts, questions, options.pairs, options.checks,
        options.raters_see, options.seed, options.tts,
    )  # fmt: skip


def _cast(options: Namespace, name: str) -> "StudyCharacter":
    """Return a character with its performers for the methods."""
    from lipsync_lang import resolve as resolve_pair
    from lipsync_lang.plugins.study.methods import StudyCharacter, with_bank

    def resolved(character: str | Path) -> "Performer":
        motion = motion_settings(options.settings)
        performer = resolve_pair(options.language, character, paths=options.path, motion=motion)
        return replace(performer, cleaning=cleaning(options))

    own = resolved(name)

    def other(method: "Method") -> "Performer":
        if method.how == "motion":
            return own.with_motion(method.what)
        if method.how == "character":
            return resolved(method.what)
        return with_bank(own, name, Path(method.what), resolved)

    model = options.model or own.model
    if model is None:
        raise LipsyncError(f"{name} has no model to film; name one with --model GLB")
    return StudyCharacter(own, model, other, options.fps)


def serve(options: Namespace) -> int:
    """Serve a study's page and append the answers to a file, until it is interrupted."""
    try:
        from lipsync_lang.plugins.study.answer_server import AnswerServer
    except ImportError:
        what = "the server needs Starlette and uvicorn"
        raise LipsyncError(f"{what}: {install_line('studio')}") from None

    with AnswerServer(options.folder, options.host, options.port, options.origin) as server:
        host = f"[{options.host}]" if ":" in options.host else options.host
        print(f"the study is at http://{host}:{server.port}/", flush=True)
        print(f"answers are appended to {server.answers}; close with Ctrl-C", file=sys.stderr)
        with suppress(KeyboardInterrupt):  # the usual end of a server
            server.run()
    return SOUND
