"""Write values as YAML the way packs are written by hand.

Numbers, text and short collections stand on one line. A mapping that holds curves (lists of lists)
is a block with a line for each pose.
"""

import json
import re
from collections.abc import Mapping, Sequence

from lipsync_lang.packs.yaml.source import Data

INDENT = 2
"""Spaces by which a level is indented where the file shows no other habit."""

MAX_FLOW_CHARS = 100
"""Characters of a mapping that is written on one line without being asked to."""

CURVES = "curves"
"""The field of packs with a mapping of curves, in blocks even while it has none."""

_SPELLING = r"\w\u0300-\u036f\u02b0-\u02ff"
"""Letters with their accents, and with marks of the IPA."""

PLAIN_SCALAR = re.compile(rf"[^\W\d](?:[{_SPELLING} ./'()-]*[{_SPELLING})'-])?")
"""Text that means itself without quotes, unless it is a reserved word."""

RESERVED_WORDS = {"true", "false", "yes", "no", "on", "off", "y", "n", "null"}
"""Words that some version of YAML reads as booleans or null, so they need quotes."""


def as_scalar(text: str) -> str:
    """Return text as a YAML scalar, quoted if a plain one could be misread."""
    plain = PLAIN_SCALAR.fullmatch(text) and text.casefold() not in RESERVED_WORDS
    # quotes and escapes of JSON are valid in YAML
    return text if plain else json.dumps(text, ensure_ascii=False)


def on_one_line(value: Data) -> str:
    """Return a value as YAML on one line: `0.5`, `{open: 0.75}`, `[[0, 0], [1, 1]]`."""
    if isinstance(value, Mapping):
        inner = (f"{as_scalar(key)}: {on_one_line(one)}" for key, one in value.items())
        return "{" + ", ".join(inner) + "}"
    if isinstance(value, str):
        return as_scalar(value)
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(on_one_line, value)) + "]"
    if isinstance(value, float):
        return _number(value)
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return str(value)


def wants_block(value: Data) -> bool:
    """Return True for a mapping that holds curves or may do so, or is too long for a line."""
    return (
        isinstance(value, Mapping)
        and bool(value)
        and (
            CURVES in value
            or any(_is_curve(one) or wants_block(one) for one in value.values())
            or len(on_one_line(value)) > MAX_FLOW_CHARS
        )
    )


def block_lines(value: Mapping[str, Data], indent: int = 0) -> list[str]:
    """Return the lines of a mapping, one for each entry; blocks within it are indented further.

    Curves are aligned: their values start in one column.
    """
    names = {key: f"{as_scalar(key)}:" for key in value}
    curves = [len(names[key]) for key, one in value.items() if _is_curve(one)]
    width = max(curves, default=0)
    lines: list[str] = []
    for key, one in value.items():
        if wants_block(one):
            lines += [names[key], *block_lines(one, INDENT)]
        else:
            # curves of one bigram are compared with each other
            pad = width if _is_curve(one) else 0
            lines.append(f"{names[key]:<{pad}} {on_one_line(one)}")
    return [" " * indent + line for line in lines]


def _is_curve(value: Data) -> bool:
    """Return True for a list of lists."""
    return isinstance(value, (list, tuple)) and bool(value) and isinstance(value[0], (list, tuple))


def _number(value: float) -> str:
    """Return a number in as few digits as state it exactly."""
    short = f"{value:g}"
    if value != value or value in (float("inf"), float("-inf")):  # noqa: PLR0124 only NaN differs
        # `nan` and `-inf` are `.nan` and `-.inf` in YAML
        return f"{short[:-3]}.{short[-3:]}"
    return short if float(short) == value else repr(value)
