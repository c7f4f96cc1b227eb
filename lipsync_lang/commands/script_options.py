"""Options for the text of scripts: values of placeholders, and the project's unspoken passages."""

from argparse import Namespace, _ActionsContainer

from lipsync_lang.errors import LipsyncError
from lipsync_lang.lines.markup import Cleaning


def add_values(made: _ActionsContainer) -> None:
    """Add the values of placeholders; the project supplies the default."""
    made.set_defaults(unspoken=())
    made.add_argument(
        "--value", metavar="NAME=TEXT", action="append", default=[], dest="values",
        help="speak this text for the placeholder [NAME], {NAME} or $NAME; may be repeated",
    )  # fmt: skip


def cleaning(options: Namespace) -> Cleaning:
    """Return the values of placeholders, and the project's passages that are not spoken."""
    values: dict[str, str] = {}
    for one in options.values:
        name, equals, value = one.partition("=")
        if not (name.strip() and equals):
            raise LipsyncError(f"--value {one}: write NAME=TEXT (--value player=Ada)")
        values[name.strip()] = value
    return Cleaning(values, options.unspoken)
