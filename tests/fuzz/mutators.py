"""Seeded damage: bytes, typing errors in text, and values in JSON, GLB and YAML.

Each function takes a random generator and a content, and gives another content. The same seed
gives the same damage.
"""

import json
import re
import struct
from collections.abc import Callable, Sequence
from copy import deepcopy
from random import Random

MOST_BYTES = 200_000
"""Maximum size of a mutated input; other tests cover large files."""

INSERTS = [
    ":", ": ", "-", "- ", "[", "]", "{", "}", ",", "#", " #", "'", '"', "&a ", "*a", "!", "!!int ",
    "|", ">", "%", "@", "`", "?", "? ", "<<: ", "\t", "\n", "\r\n", "\n\n  ", "---\n", "...\n",
    "\\", "\0", "\x07", "\u2028", "\ufeff", "\ud7ff", "é", "𝕏", "~", "null", "[[", "]]", "{{",
]  # fmt: skip
VALUES = [
    "", "~", "null", "true", "no", "0", "-1", "1e999", ".nan", "-.inf", "9" * 400, "0x", "1,5",
    "[]", "{}", "[[]]", "[1, 2, 3]", "{a: b}", "'", '"\\ud800"', "text", "_", "a-b-c",
    "[[1, 0], [0, 1]]",
    "../../etc/passwd", "kind", "&x [*x]", "*nobody", "!!python/object:os.system x",
]  # fmt: skip
"""Values for a YAML file."""

NUMBERS = [
    "0", "-1", "-0", "1e-320", "1e300", "-1e300", "1e999", "nan", "inf", "-inf", "9" * 400,
    "9" * 5000, "86400", "1e15", "4294967296", "18446744073709551616", "0x10", "1_0", "1,5", "٣",
    "²", "", "true", "None", "+-1", "1e", ".", "1e9", "0.0000001", "-5.5",
]  # fmt: skip
"""Numbers for texts with numbers."""

NAMES = ["../../x", "/etc/passwd", "nul\0", "\x1b[2J", "\u202e", "a" * 30_000, "", "é", "\ud800"]

ODD = [
    None, True, False, 0, 1, -1, 2, 255, 2**31 - 1, 2**32, 2**63, 10**400, -(10**40), 0.5, -0.0,
    1e-320, 1e300, -1e300, float("nan"), float("inf"), float("-inf"), "", "0", "1e999", "nan",
    *NAMES, [], {}, [[]], [None], [0], [1, 2, 3], ["a", "b"], {"a": 1}, [{}], {"": None},
]  # fmt: skip
"""Values for a JSON document."""

WORDS = [
    struct.pack("<I", one) for one in (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFFFF, 0x10000)
] + [struct.pack("<f", one) for one in (float("nan"), float("inf"), -1e38, 3e38, 1e-45)]
"""Four bytes for a false length or an invalid number."""

ENCODINGS = ["utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig", "latin-1", "utf-7"]
"""Encodings of files."""

GLB_JSON, GLB_BINARY = 0x4E4F534A, 0x004E4942


# Slips of the hand in text


def delete(rng: Random, text: str) -> str:
    """Leave out up to 40 characters."""
    start = rng.randrange(len(text))
    return text[:start] + text[start + rng.choice((1, 1, 2, 5, 40)) :]


def duplicate(rng: Random, text: str) -> str:
    """Repeat up to 60 characters."""
    start = rng.randrange(len(text))
    stop = start + rng.choice((1, 2, 8, 60))
    return text[:stop] + text[start:stop] + text[stop:]


def swap(rng: Random, text: str) -> str:
    """Swap two neighbours."""
    at = rng.randrange(max(1, len(text) - 1))
    return text[:at] + text[at + 1 : at + 2] + text[at] + text[at + 2 :]


def insert(rng: Random, text: str) -> str:
    """Insert a character with a meaning for parsers."""
    at = rng.randrange(len(text))
    return text[:at] + rng.choice(INSERTS) + text[at:]


def lines(rng: Random, text: str) -> str:
    """Delete, repeat, move, indent or truncate a line."""
    rows = text.splitlines(keepends=True)
    one, other = rng.randrange(len(rows)), rng.randrange(len(rows))
    kind = rng.randrange(5)
    if kind == 0:
        del rows[one]
    elif kind == 1:
        rows.insert(other, rows[one])
    elif kind == 2:
        rows[one], rows[other] = rows[other], rows[one]
    elif kind == 3:
        rows[one] = rng.choice((" ", "  ", "\t", "    ")) + rows[one]
    else:
        rows = [*rows[:one], rows[one][: rng.randrange(len(rows[one]) + 1)]]
    return "".join(rows)


def value(rng: Random, text: str) -> str:
    """Replace a value after a colon or in a list."""
    places = [at for at, letter in enumerate(text) if letter in ":,["]
    at = rng.choice(places or [len(text) - 1]) + 1
    stop = at
    while stop < len(text) and text[stop] not in ",]}\n":
        stop += 1
    return f"{text[:at]} {rng.choice(VALUES)}{text[stop:]}"


def number(rng: Random, text: str) -> str:
    """Replace a number of any text by an odd one."""
    places = [found.span() for found in re.finditer(r"-?\d+(?:\.\d+)?", text)]
    start, stop = rng.choice(places or [(0, 0)])
    return text[:start] + rng.choice(NUMBERS) + text[stop:]


def field(rng: Random, text: str) -> str:
    """Replace a cell, a word or an attribute by an odd one."""
    places = [found.span() for found in re.finditer(r"[^\s,;|\t\"'<>=:{}\[\]]+", text)]
    start, stop = rng.choice(places or [(0, 0)])
    return text[:start] + rng.choice(NAMES) + text[stop:]


def nest(rng: Random, text: str) -> str:
    """Open brackets or elements again and again."""
    at = rng.randrange(len(text))
    mark = rng.choice(("[", "{", "<a>", '{"a":', "- ", "(", "&lt;", '"', "\\", "a: "))
    return text[:at] + mark * rng.choice((50, 2_000, 5_000)) + text[at:]


SLIPS: tuple[Callable[[Random, str], str], ...] = (
    delete, duplicate, swap, insert, insert, lines, lines, value, value, value,
)  # fmt: skip
"""Errors of a person who edits a pack."""

TEXT_DAMAGE = (*SLIPS, number, number, number, field, field, nest)


# Bytes


def flip(rng: Random, content: bytes) -> bytes:
    """Flip a bit."""
    changed = bytearray(content)
    changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def spoil(rng: Random, content: bytes) -> bytes:
    """Replace a byte."""
    changed = bytearray(content)
    changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed)


def word(rng: Random, content: bytes) -> bytes:
    """Replace four bytes, often of a header."""
    reach = min(len(content), rng.choice((16, 64, len(content))))
    at = rng.randrange(reach)
    return content[:at] + rng.choice(WORDS) + content[at + 4 :]


def truncate(rng: Random, content: bytes) -> bytes:
    """Cut off the end."""
    return content[: rng.randrange(len(content))]


def repeat(rng: Random, content: bytes) -> bytes:
    """Repeat a part many times."""
    start = rng.randrange(len(content))
    part = content[start : start + rng.choice((1, 8, 64))]
    return content[:start] + part * rng.choice((2, 20, 500)) + content[start:]


BYTE_DAMAGE = (flip, spoil, word, word, truncate, repeat)


# JSON and GLB


def document(rng: Random, tree: object) -> object:
    """Return a copy of a JSON value with one place of it changed."""
    tree = deepcopy(tree)
    places = [*_places(tree)]
    if not places:
        return rng.choice(ODD)
    holder, key = rng.choice(places)
    kind = rng.randrange(8)
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, list):
        holder.insert(key, deepcopy(holder[key]))
    elif kind == 2 and isinstance(holder, dict):
        holder[rng.choice((*holder, "x", ""))] = holder.pop(key)
    elif kind == 3:
        other, there = rng.choice(places)
        holder[key] = deepcopy(other[there])
    else:
        holder[key] = rng.choice(ODD)
    return tree


def _places(tree: object) -> list[tuple[object, object]]:
    found, waiting = [], [tree]
    while waiting:
        one = waiting.pop()
        inner = one.items() if isinstance(one, dict) else enumerate(one)
        for key, below in inner:
            found.append((one, key))
            if isinstance(below, (dict, list)):
                waiting.append(below)
    return found


def dumped(tree: object) -> bytes:
    """Return JSON, including values that only Python accepts."""
    return json.dumps(tree, ensure_ascii=True).encode()


def parsed(content: bytes) -> object:
    """Parse a content as JSON; return None if it is not JSON."""
    try:
        tree = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return tree if isinstance(tree, (dict, list)) else None


def glb(rng: Random, content: bytes) -> bytes:
    """Change a field of a GLB's JSON, or its binary data, and correct all lengths."""
    length = struct.unpack_from("<I", content, 12)[0]
    text, rest = content[20 : 20 + length], content[20 + length :]
    if rest[8:] and rng.random() < 0.3:
        binary = bytearray(rest[8:])
        at = rng.randrange(0, len(binary), 4)
        binary[at : at + 4] = rng.choice(WORDS)
        rest = rest[:8] + bytes(binary)
    else:
        for _ in range(rng.choice((1, 1, 2))):
            text = dumped(document(rng, json.loads(text)))
    return joined(text, rest)


def joined(text: bytes, rest: bytes) -> bytes:
    """Return a GLB of its JSON and all chunks after it."""
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<2I", len(text), GLB_JSON) + text + rest
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _is_glb(content: bytes) -> bool:
    if content[:4] != b"glTF" or len(content) < 20:
        return False
    length = struct.unpack_from("<I", content, 12)[0]
    return isinstance(parsed(content[20 : 20 + length]), dict)


# All of them


def mutated(rng: Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Return a content with one to three kinds of damage; `others` are of the same format."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        content = _damaged(rng, content or b"\n", others)[:MOST_BYTES]
    return content


def _damaged(rng: Random, content: bytes, others: Sequence[bytes]) -> bytes:  # noqa: PLR0911 a choice
    chance = rng.random()
    if chance < 0.1:
        return rng.choice(BYTE_DAMAGE)(rng, content)
    if chance < 0.15:  # a splice
        other = rng.choice(others)
        return content[: rng.randrange(len(content))] + other[rng.randrange(len(other) or 1) :]
    if _is_glb(content):
        return glb(rng, content)
    tree = parsed(content)
    if tree is not None and chance < 0.75:
        return dumped(document(rng, tree))
    try:
        text = content.decode()
    except UnicodeDecodeError:
        return rng.choice(BYTE_DAMAGE)(rng, content)
    if "\0" in text:
        return rng.choice(BYTE_DAMAGE)(rng, content)
    if chance > 0.96:
        return text.encode(rng.choice(ENCODINGS), "replace")
    return rng.choice(TEXT_DAMAGE)(rng, text).encode("utf-8", "surrogatepass")
