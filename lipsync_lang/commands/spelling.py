"""Arguments of Python as options of the command line.

Messages name arguments the way Python writes them, in backquotes: `unknown='rest'`. The command
line prints the same messages with its options in their place: --unknown rest.
"""

import re

OPTIONS = {
    name: f"--{name.replace('_', '-')}"
    for name in (
        "aligner", "audio", "channels", "column", "cut", "encoding", "fps", "gaps", "model",
        "notation", "offset", "rate", "read_as", "recogniser", "schedule", "tier", "unknown",
    )
} | {"engine": "--tts", "paths": "--path"}  # fmt: skip
"""Arguments that messages name, and the option that gives each."""

_ARGUMENT = re.compile(r"`([a-z_]+)(?:=(['\"]?)([^`]*?)\2)?`")
_PLAIN = re.compile(r"[\w.,@%+:/-]+")


def as_options(message: str) -> str:
    """Return a message with options in place of the arguments that it names."""
    return _ARGUMENT.sub(_option, message)


def _option(found: re.Match[str]) -> str:
    name, _, value = found.groups()
    if name not in OPTIONS:
        return found[0]
    if value is None:
        return OPTIONS[name]
    return f"{OPTIONS[name]} {value}" if _PLAIN.fullmatch(value) else f'{OPTIONS[name]} "{value}"'
