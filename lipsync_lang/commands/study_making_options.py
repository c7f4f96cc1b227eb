"""Options of the commands that make and serve a study."""

import argparse
from pathlib import Path

from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.commands import studies
from lipsync_lang.commands.script_options import add_values
from lipsync_lang.commands.shared_options import Add, add_json, add_language, add_path
from lipsync_lang.files import argument_path


def add_new(action: Add) -> None:
    """Add `study new`."""
    new_ = action(
        "new",
        studies.new,
        "render pairs of clips, and write a page for raters to choose the better one",
        "study new script.csv -l english -c facefx --method ours --method keyframes --pairs 40 "
        "-o study",
    )
    _add_lines(new_)
    _add_compared(new_)
    _add_clips(new_)
    _add_page(new_.add_argument_group("text and questions of the page"))
    new_.add_argument(
        "-o", "--output", metavar="FOLDER", type=Path, required=True,
        help="the folder of the study; it must not hold another study",
    )  # fmt: skip
    new_.add_argument(
        "--workers", metavar="N", type=_positive, help="number of processes [one per core]"
    )
    add_json(new_)


def add_serve(action: Add) -> None:
    """Add `study serve`."""
    made = action(
        "serve",
        studies.serve,
        "serve the page of a study, and append answers to a file",
        "study serve study --port 8080",
    )
    made.add_argument("folder", metavar="FOLDER", type=Path, help="the folder of the study")
    made.add_argument(
        "--host", metavar="ADDRESS", default="127.0.0.1",
        help="the address to listen on; 0.0.0.0 admits other machines [127.0.0.1]",
    )  # fmt: skip
    made.add_argument("--port", metavar="N", type=int, default=0, help="the port [a free one]")
    made.add_argument(
        "--origin", metavar="URL", action="append", default=[],
        help="a public address of the page, such as https://example.org; null for pages that are "
        "opened from files; may be repeated",
    )  # fmt: skip


def _add_lines(made: argparse.ArgumentParser) -> None:
    """Add the lines, and the options for reading and speaking them."""
    made.add_argument(
        "lines", metavar="LINES", nargs="*", type=argument_path,
        help="files or folders of lines: scripts, tables, timings; - is standard input",
    )  # fmt: skip
    lines = made.add_argument_group("lines")
    lines.add_argument(
        "--text", metavar="TEXT", action="append", default=[],
        help="an additional line; may be repeated",
    )  # fmt: skip
    lines.add_argument(
        "--column", metavar="NAME", help="the text's column in tables, by name or number"
    )
    lines.add_argument("--encoding", metavar="NAME", help="the encoding of all files [UTF-8]")
    add_values(lines)
    add_language(lines)
    lines.add_argument(
        "--audio", metavar="FOLDER", type=Path,
        help="recordings named after the lines, instead of a voice",
    )  # fmt: skip
    lines.add_argument("--tts", metavar="ENGINE", help="speech engine [the language's]")


def _add_compared(made: argparse.ArgumentParser) -> None:
    """Add the methods, and the number of pairs of clips."""
    compared = made.add_argument_group("comparison")
    compared.add_argument(
        "--method", metavar="METHOD", action="append", default=[],
        help="ours, keyframes, dominance, held, NAME=FOLDER of files named after the lines, "
        "NAME=character:OTHER, NAME=bank:FILE or NAME=motion:PRESET; give two or more",
    )  # fmt: skip
    compared.add_argument(
        "--pairs", metavar="N", type=_positive, help="largest number of pairs, chosen evenly [all]"
    )
    compared.add_argument(
        "--checks", metavar="N", type=_whole,
        help="number of attention checks [one for every ten pairs]",
    )  # fmt: skip
    compared.add_argument(
        "--raters-see", metavar="N", type=_positive,
        help="number of pairs that each rater sees [all]",
    )  # fmt: skip
    compared.add_argument(
        "--seed", metavar="N", type=int, default=1, help="seed of all random choices [1]"
    )


def _add_clips(made: argparse.ArgumentParser) -> None:
    """Add the characters, and the options of the clips."""
    clips = made.add_argument_group("clips")
    clips.add_argument(
        "-c", "--character", metavar="CHARACTER", action="append", default=[],
        help="a character or a pose set [the project's]; may be repeated",
    )  # fmt: skip
    clips.add_argument(
        "--model", metavar="GLB", type=Path, help="film this model instead of the characters' own"
    )
    clips.add_argument(
        "--fps", metavar="N", type=parse_rate, default=30.0, help="frames per second [30]"
    )
    clips.add_argument(
        "--set", metavar="motion.NAME=VALUE", action="append", default=[], dest="settings",
        help="change a motion setting of every method, or use a preset: --set motion=paper",
    )  # fmt: skip
    add_path(clips)


def _add_page(page: argparse._ArgumentGroup) -> None:
    """Add the texts and questions of the page."""
    page.add_argument(
        "--title", metavar="TEXT", default="Which face speaks better?",
        help="the page's title [Which face speaks better?]",
    )  # fmt: skip
    page.add_argument(
        "--consent", metavar="FILE", type=argument_path,
        help="the text that raters agree to [a plain one]; - is standard input",
    )  # fmt: skip
    page.add_argument(
        "--ask", metavar="'LABEL: A|B'", action="append", default=[],
        help="a question about the rater, with its choices; may be repeated",
    )  # fmt: skip
    page.add_argument(
        "--question", choices=("accuracy", "naturalness"), action="append", default=[],
        help="ask this of each pair [both]; may be repeated",
    )  # fmt: skip
    page.add_argument(
        "--post", metavar="URL", help="send the answers to this address [save them as a file]"
    )


def _positive(text: str) -> int:
    return _number(text, 1)


def _whole(text: str) -> int:
    return _number(text, 0)


def _number(text: str, least: int) -> int:
    if not (text.isascii() and text.isdecimal() and int(text) >= least):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of {least} or more")
    return int(text)
