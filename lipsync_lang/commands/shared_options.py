"""Options of commands, spelled as the help shows them.

`options.json` lists them by command, and the sets that several commands share. A row has the
spelling, the help, and further arguments of `argparse` if there are any; a text names a set.
"""

import argparse
import json
from argparse import Namespace, _ActionsContainer
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files import argument_path

if TYPE_CHECKING:
    from lipsync_lang.text.lines.cleaning import Cleaning


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


def parse_row(text: str) -> int:
    """Return the number of a row."""
    if not (text.isascii() and text.isdecimal() and len(text) < MAX_ROW_DIGITS and int(text)):
        raise argparse.ArgumentTypeError(f"'{text}' is no number of a row; give 1 or more")
    return int(text)


KINDS: dict[str, Any] = {
    "file": argument_path,
    "float": float,
    "int": int,
    "path": Path,
    "rate": parse_rate,
    "row": parse_row,
    "yes or no": argparse.BooleanOptionalAction,
}
"""Types and actions by their names in `options.json`."""


@cache
def option_sets() -> dict[str, list[Any]]:
    """Return the rows of `options.json`, by the names of commands and shared sets."""
    found: dict[str, list[Any]] = json.loads(
        Path(__file__).with_name("options.json").read_text("utf-8")
    )
    return found


def add_options(made: Options, rows: Iterable[Any]) -> None:
    """Add rows to a command, or to a group of its options.

    A row is one of `options.json`, or the name of a set there, such as `path`, `pair` or `json`.
    """
    for row in rows:
        match row:
            case str():
                add_options(made, option_sets()[row])
            case {"group": title, "options": own}:
                add_options(made.add_argument_group(title), own)
            case {"defaults": values}:
                made.set_defaults(**values)
            case [spelled, told, *how]:
                _add_row(made, spelled, told, **dict(*how))


def _add_row(made: Options, spelled: str, told: str, **how: Any) -> None:
    for key in how.keys() & {"type", "action"}:
        how[key] = KINDS.get(how[key], how[key])
    named = spelled.startswith("-") and " " not in spelled.rpartition(", ")[2]
    if how.pop("repeated", False):
        repeated(made, spelled, told, **how)
    elif named and not how.keys() & {"action", "choices"}:
        flag(made, spelled, told, **how)
    else:
        option(made, spelled, told, **how)


def cleaning(options: Namespace) -> "Cleaning":
    """Return the values of placeholders, and the project's passages that are not spoken."""
    from lipsync_lang.text.lines.cleaning import Cleaning

    values: dict[str, str] = {}
    for one in options.values:
        name, equals, value = one.partition("=")
        if not (name.strip() and equals):
            raise LipsyncError(f"--value {one}: write NAME=TEXT (--value player=Ada)")
        values[name.strip()] = value
    return Cleaning(values, tuple(options.unspoken))
