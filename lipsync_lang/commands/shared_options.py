"""Options of commands, spelled as the help shows them, and those that several commands share."""

import argparse
from argparse import Namespace, _ActionsContainer
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files import argument_path

if TYPE_CHECKING:
    from lipsync_lang.text.lines.markup import Cleaning


MAX_ROW_DIGITS = 10

Options = _ActionsContainer
"""A command, or a group of its options."""


def option(made: Options, spelled: str, told: str, **how: Any) -> None:
    """Add an option.

    Parameters
    ----------
    made : the command, or a group of its options
    spelled : short and long form, and the name of the value if it has one
    told : its help
    how : further arguments of `argparse`, such as `type` and `default`

    Examples
    --------
    >>> import argparse
    >>> made = argparse.ArgumentParser(prog="greet")
    >>> option(made, "-n, --number N", "how often", type=int)
    >>> flag(made, "--loud", "in capitals")
    >>> repeated(made, "--name NAME", "whom; may be repeated")
    >>> made.parse_args(["-n", "2", "--name", "Ada", "--name", "Bob"])
    Namespace(number=2, loud=False, name=['Ada', 'Bob'])
    """
    *short, last = spelled.split(", ")
    name, _, value = last.partition(" ")
    if value:
        how["metavar"] = value
    made.add_argument(*short, name, help=told, **how)


def flag(made: Options, spelled: str, told: str, **how: Any) -> None:
    """Add an option without a value, which is False unless it is given."""
    option(made, spelled, told, action="store_true", **how)


def repeated(made: Options, spelled: str, told: str, **how: Any) -> None:
    """Add an option that may be repeated, for a list of its values."""
    option(made, spelled, told, action="append", default=[], **how)


def add_words(made: argparse.ArgumentParser) -> None:
    """Add the verbosity options."""
    words = made.add_mutually_exclusive_group()
    flag(words, "-q, --quiet", "print errors only")
    flag(words, "-v, --verbose", "print each step and its reason")


def add_path(made: Options) -> None:
    """Add the pack search path; the project supplies the default."""
    made.set_defaults(in_project=True)
    repeated(
        made, "--path FOLDER", "search this folder for packs first; may be repeated", type=Path
    )


def add_layout(made: Options) -> None:
    """Add the options that say where a table begins."""
    option(made, "--sheet NAME", "the only sheet to read of a spreadsheet [all of a script]")
    option(
        made, "--header-row N",
        "the row of a table that names the columns, from 1 [the first, or the one below a title]",
        type=parse_row,
    )  # fmt: skip


def parse_row(text: str) -> int:
    """Return the number of a row."""
    if not (text.isascii() and text.isdecimal() and len(text) < MAX_ROW_DIGITS and int(text)):
        raise argparse.ArgumentTypeError(f"'{text}' is no number of a row; give 1 or more")
    return int(text)


def add_json(made: Options) -> None:
    """Add the option for JSON output."""
    flag(made, "--json", "print JSON")


def add_json_form(made: Options) -> None:
    """Add the option for JSON output to commands with several `--format` values."""
    option(
        made, "--json", "the same as --format json", action="store_const", const="json",
        dest="format",
    )  # fmt: skip


def add_output(made: Options) -> None:
    """Add the option for the files to write instead of printing."""
    repeated(
        made, "-o, --output FILE",
        "write to a file; - is standard output; may be repeated [print it]", type=argument_path,
    )  # fmt: skip


def add_language(made: Options) -> None:
    """Add the option for the language; the project supplies the default."""
    option(made, "-l, --language LANGUAGE", "name or tag of a language [the project's]")


def add_pair(made: Options, *, models: bool = False) -> None:
    """Add the language and character options; `models` if a model may stand for a character."""
    face = (
        "a character, a pose set or a model (.glb, .vrm, .gltf)"
        if models
        else "a character or a pose set"
    )
    add_language(made)
    option(made, "-c, --character CHARACTER", f"{face} [the project's]")
    add_path(made)


def add_line(made: argparse.ArgumentParser) -> None:
    """Add the options of a line: character, text and delivery."""
    made.add_argument("text", metavar="TEXT", nargs="?", help="the text to say")
    add_pair(made.add_argument_group("speaker"), models=True)
    said = made.add_argument_group("line")
    option(
        said, "--audio FILE",
        "a recording of the TEXT or of the --schedule; alone, its speech is recognised", type=Path,
    )  # fmt: skip
    option(
        said, "--audio-channel N", "channel of the recording, counted from 1 [all, mixed]", type=int
    )
    option(said, "--aligner NAME[:MODEL]", "aligner and its model [the language's]")
    option(said, "--recogniser NAME[:MODEL]", "recogniser and its model [the language's]")
    option(
        said, "--schedule FILE", "timed phonemes instead of text; - is standard input",
        type=argument_path,
    )  # fmt: skip
    option(said, "--read-as FORMAT", "the schedule's format [by its suffix and content]")
    option(said, "--tier NAME", "the schedule's tier, speaker or channel, if it has several")
    option(
        said, "--rate N",
        "units per second of the schedule's times: 1000 for milliseconds, 16000 for samples",
        type=float,
    )  # fmt: skip
    option(said, "--encoding NAME", "the schedule's encoding [UTF-8]")
    option(said, "--notation NAME", "the notation of the schedule's labels")
    option(said, "--line NAME", "the id of the line, for its edits in the character's file")
    option(said, "--tts ENGINE", "speech engine; none estimates times [the language's]")
    add_values(said)
    how = made.add_argument_group("performance")
    add_manner(how)
    option(
        how, "--intensity X",
        "effect of loudness on the mouth: 0 for none, 1 as the pose set states, at most 2 [1 if "
        "there is sound]", type=float,
    )  # fmt: skip
    option(
        how, "--gestures NAME[:FACTOR],...",
        "make these gestures of the pose set: all, none, or such as blink,accent:0.5 [the "
        "project's, or all in pages and videos alone]",
    )  # fmt: skip
    option(
        how, "--idle SECONDS",
        "rest so long after the line, with gestures of silence [the project's, or 0]", type=float,
    )  # fmt: skip


def add_manner(how: Options) -> None:
    """Add the options of delivery that need no whole line."""
    repeated(
        how, "--style NAME:SHARE",
        "blend in a style: --style angry:0.5; varying over seconds: --style angry:0@1,1@2.5",
        dest="styles",
    )  # fmt: skip
    repeated(
        how, "--dial REGION:LEVEL",
        "scale the poses of a region, 0 to 2: --dial jaw:0.5 mumbles; may vary as in --style",
        dest="dials",
    )  # fmt: skip
    add_motion(how)
    option(
        how, "--shades",
        "perform shades (finer sounds), or each as its parent phoneme [the project's, or yes; no "
        "with motion=paper]", action=argparse.BooleanOptionalAction,
    )  # fmt: skip
    option(
        how, "--gaps", "treatment of bigrams without data [error]", choices=("error", "rest"),
        default="error",
    )  # fmt: skip
    option(
        how, "--unknown",
        "treatment of unmapped labels; nearest uses the features of IPA [nearest]",
        choices=("error", "rest", "nearest"), default="nearest",
    )  # fmt: skip


def add_motion(how: Options) -> None:
    """Add the frame rate and the settings of motion."""
    option(
        how, "--fps N",
        "frames per second, such as 24, 23.976 or 24000/1001 [the project's, or 60]",
        type=parse_rate,
    )  # fmt: skip
    repeated(
        how, "--set motion.NAME=VALUE",
        "change a motion setting, or use a preset: --set motion=paper", dest="settings",
    )  # fmt: skip


def add_values(made: Options) -> None:
    """Add the values of placeholders; the project supplies the default."""
    made.set_defaults(unspoken=())
    repeated(
        made, "--value NAME=TEXT",
        "speak this text for the placeholder [NAME], {NAME} or $NAME; may be repeated",
        dest="values",
    )  # fmt: skip


def cleaning(options: Namespace) -> "Cleaning":
    """Return the values of placeholders, and the project's passages that are not spoken."""
    from lipsync_lang.text.lines.markup import Cleaning

    values: dict[str, str] = {}
    for one in options.values:
        name, equals, value = one.partition("=")
        if not (name.strip() and equals):
            raise LipsyncError(f"--value {one}: write NAME=TEXT (--value player=Ada)")
        values[name.strip()] = value
    return Cleaning(values, options.unspoken)
