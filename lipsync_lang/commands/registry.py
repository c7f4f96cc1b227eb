"""Registry of commands, and the functions that add them to the parser.

A command of the program is a `handler` with its help; `options.json` has its options. A command of
a distribution is a function that adds it with its options, under `command`, and an entry point of
the group `lipsync_lang.commands`. A name such as `bank fit` is an action of a command.
"""

import argparse
from collections.abc import Callable, Iterator
from typing import Protocol

from lipsync_lang.base.extensions import Extensions
from lipsync_lang.commands.shared_options import add_options, option_sets

Handler = Callable[[argparse.Namespace], int]
"""A command handler: options in, exit code out."""

Subparsers = argparse._SubParsersAction  # noqa: SLF001 the commands of a parser, or actions of one


class Add(Protocol):
    """Adds a command to a parser, with an example of its arguments."""

    def __call__(  # noqa: D102 the class says it
        self, handler: Handler | None, title: str, example: str, *, more: str = ""
    ) -> argparse.ArgumentParser: ...


AddCommand = Callable[[Add], object]

SHARED_MODULES = {
    "languages": "packs", "posesets": "packs", "characters": "packs", "voices": "listing",
    "formats": "listing",
}  # fmt: skip
"""Modules of the commands that share one; each of the others has one of its own name."""

COMMANDS: Extensions[AddCommand] = Extensions(
    "commands",
    "command",
    modules={
        name: f"{__package__}.{SHARED_MODULES.get(name, name)}"
        for name in (
            "new", "doctor", "run", "transcribe", "explain", "stills", "live", "studio", "resolve",
            "validate", "schema", "coverage", "check", "build", "languages", "posesets",
            "characters", "bank", "models", "voices", "formats", "completion",
        )
    },
)  # fmt: skip
"""Functions that add commands, by the names of the commands, in the order of the help."""


def command(name: str) -> Callable[[AddCommand], AddCommand]:
    """Register a function ``(add) -> None`` that adds a command, or an action such as `bank fit`.

    Examples
    --------
    >>> from lipsync_lang.commands.registry import Add, command
    >>> @command("greet")
    ... def add_greet(add: Add) -> None:
    ...     add(lambda options: print("Hello") or 0, "say hello", "greet")
    """
    return COMMANDS.register(name)


def handler(name: str, title: str, example: str, *, more: str = "") -> Callable[[Handler], Handler]:
    """Register the decorated function as the handler of a command, or of an action.

    `title` is its line in the help of all commands, `more` goes on from it in its own help, and
    `example` are arguments.
    """

    def register(handle: Handler) -> Handler:
        COMMANDS.add(name, lambda add: add(handle, title, example, more=more), handle.__module__)
        return handle

    return register


def add_command(
    known: "Subparsers[argparse.ArgumentParser]", name: str, *, whole: bool = True
) -> None:
    """Add a command, or an action such as `bank fit`, to a parser; its title alone if not whole."""

    def add(
        handler: Handler | None, title: str, example: str, *, more: str = ""
    ) -> argparse.ArgumentParser:
        made = known.add_parser(
            name.rpartition(" ")[2],
            help=title,
            description=f"{title[0].upper()}{title[1:]}{more}.",
            epilog=f"example:\n  lipsync-lang {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(command=handler)
        add_options(made, option_sets().get(name, ()) if whole else ())
        return made

    COMMANDS[name](add)


def family(name: str, title: str, example: str) -> None:
    """Register a command of actions: all commands whose names begin with its own."""

    @command(name)
    def add_family(add: Add) -> None:
        made = add(None, title, example)
        actions = made.add_subparsers(title="actions", metavar="ACTION", required=True)
        # Actions of plug-ins belong here too, in whatever order their packages were found.
        for other in sorted(COMMANDS):
            if other.startswith(f"{name} "):
                add_command(actions, other)


def leaves(
    made: argparse.ArgumentParser, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], argparse.ArgumentParser]]:
    """Yield every command that can run by itself, with its full name."""
    below = [action for action in made._actions if isinstance(action, Subparsers)]  # noqa: SLF001
    if path and not any(action.required for action in below):
        yield path, made
    for action in below:
        for name, child in action.choices.items():
            yield from leaves(child, (*path, name))
