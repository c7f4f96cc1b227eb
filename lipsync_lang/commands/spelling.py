"""Translation of Python argument names in messages to command-line options.

Messages name arguments in Python syntax and backquotes: `unknown='rest'`. The command line
substitutes its options: --unknown rest.
"""

import re

OPTIONS = {
    name: f"--{name.replace('_', '-')}"
    for name in (
        "aligner", "alpha", "audio", "channels", "column", "correlation", "cut", "encoding", "fps",
        "gaps", "language", "model", "notation", "offset", "pairs", "power", "rate", "raters",
        "read_as", "recogniser", "schedule", "share", "tier", "unknown",
    )
} | {"engine": "--tts", "paths": "--path"}  # fmt: skip
"""Option names by Python argument name."""

_ARGUMENT = re.compile(r"`([a-z_]+)(?:=(['\"]?)([^`]*?)\2)?`")
_PLAIN = re.compile(r"[\w.,@%+:/-]+")


def as_options(message: str) -> str:
    """Replace the argument names in a message by options."""
    return _ARGUMENT.sub(_option, message)


def _option(found: re.Match[str]) -> str:
    name, _, value = found.groups()
    if name not in OPTIONS:
        return found[0]
    if value is None:
        return OPTIONS[name]
    return f"{OPTIONS[name]} {value}" if _PLAIN.fullmatch(value) else f'{OPTIONS[name]} "{value}"'
