"""Options of commands, each spelled as the help shows it: `-o, --output FILE`."""

from argparse import _ActionsContainer
from typing import Any

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
