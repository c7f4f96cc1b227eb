"""Names of files that are valid on every system.

A script is written on one system and built on another. A name that one of them cannot store, or
takes for another file, is refused everywhere.
"""

import re
from collections.abc import Mapping
from unicodedata import normalize

MAX_NAME_BYTES = 200
"""Maximum size of a name in UTF-8; file systems store 255 bytes, and a suffix follows."""

RESERVED = re.compile(r"(?:con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])(?:\..*)?", re.IGNORECASE)
"""Names of devices on Windows, with any suffix."""

_USUAL = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]*", re.ASCII)
_UNFIT = re.compile(r'[<>:"|?*]')

PLACEHOLDER = re.compile(r"\{\{|\}\}|\{[^{}]*\}")
"""Part of a path that stands for something else."""

BRACES = {"{{": "{", "}}": "}"}
"""Doubled braces, which stand for single ones in names of files."""


def fill(pattern: str, values: Mapping[str, str]) -> str:
    """Put values for placeholders, and for doubled braces, into a path."""
    return PLACEHOLDER.sub(lambda found: values.get(found[0], found[0]), pattern)


def fault_of_name(name: str) -> str:
    """Return the reason why a name is not valid for a file, with the cure; empty if it is valid.

    >>> fault_of_name("intro_001")
    ''
    >>> fault_of_name("intro/001")
    "has a '/', which separates folders; use '-' or '_'"
    """
    usual = _USUAL.fullmatch(name) and len(name) <= MAX_NAME_BYTES
    if usual and len(name) > len("COM1"):
        return ""
    parting = next((mark for mark in "/\\" if mark in name), "")
    unfit = _UNFIT.search(name)
    faults = {
        "is empty; give it a name": not name.strip(),
        f"has a '{parting}', which separates folders; use '-' or '_'": parting,
        "has an invisible character; remove it": not name.isprintable(),
        f"has a '{unfit and unfit[0]}', which Windows does not allow; use '-' or '_'": unfit,
        "begins with a dot, which hides its files; remove it": name.startswith("."),
        "begins with a space; remove it": name.startswith(" "),
        "ends in a space or a dot, which Windows drops; remove it": name.endswith((" ", ".")),
        "is the name of a device on Windows; choose another": RESERVED.fullmatch(name),
        f"is longer than {MAX_NAME_BYTES} bytes; choose a shorter one": (
            len(name.encode("utf-8", "replace")) > MAX_NAME_BYTES
        ),
    }
    return next((fault for fault, holds in faults.items() if holds), "")


def folded_name(name: str) -> str:
    """Return the form in which macOS and Windows compare names: no case, one normal form."""
    return name.lower() if name.isascii() else normalize("NFC", normalize("NFC", name).casefold())
