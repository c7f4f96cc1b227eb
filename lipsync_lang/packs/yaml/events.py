"""Parse a YAML text into events, with libyaml where possible and ruamel.yaml otherwise.

libyaml is fifteen times as fast. ruamel.yaml reads the few texts on which the two parsers
disagree. It also reads every text that libyaml refuses, so that messages are the same with and
without libyaml. A text longer than `MAX_SLOW_CHARS` is read by libyaml alone. See decision 0016.
"""

import re
from collections.abc import Callable, Iterator
from typing import Any

Event = Any
"""An event of either parser; both name their classes and attributes alike."""

Parser = Callable[[str], Iterator[Event]]

MAX_SLOW_CHARS = 2**18
"""Longest text that ruamel.yaml may read, which takes it about three seconds."""

_DISPUTED = re.compile(
    r"[\x85\u2028\u2029\ufeff]|\r(?!\n)|^%|(?<![^\s\[{,:-])[&*][\w-]+[:?%@`]|[|>][-+\d]*#",
    re.MULTILINE,
)
"""Text on which the parsers differ: unusual line breaks, byte order marks, directives, anchors
with punctuation in the name, and comments that touch a block indicator (`|`, `>`)."""

_NEEDED = "\x85\u2028\u2029\ufeff\r%&*|>"
"""Characters of which `_DISPUTED` needs one; looking for them is far quicker than matching it."""


class YamlError(Exception):
    """A parser cannot read the text: its words, which may be empty, and their place.

    `place` is line and column from 1, `started` the line in which the context starts; None if the
    parser gives none.
    """

    def __init__(
        self, place: tuple[int, int] | None, problem: str, context: str, started: int | None
    ) -> None:
        super().__init__(problem)
        self.place = place
        self.problem = problem
        self.context = context
        self.started = started


MAX_SLOW_BRACKETS = 200
"""Open brackets; ruamel.yaml looks at each of them again for every token that follows."""


def parsers(text: str) -> tuple[Parser, ...]:
    """Return the parsers for a text, in the order to try them: the next one after a `YamlError`.

    Raise `YamlError` for a text that only ruamel.yaml can read, and that is too long for it.
    """
    if not has_libyaml():
        return (by_ruamel,)
    disputed = _disputed(text)
    if len(text) <= MAX_SLOW_CHARS and not _nests_deep(text):
        return (by_ruamel,) if disputed is not None else (by_libyaml, by_ruamel)
    if disputed is not None:
        line = text.count("\n", 0, disputed) + 1
        column = disputed - text.rfind("\n", 0, disputed)
        what = f"U+{ord(text[disputed]):04X} is not read in a file of this size"
        raise YamlError((line, column), what, "delete it, or write it as an escape in quotes", None)
    return (by_libyaml,)


def _nests_deep(text: str) -> bool:
    """Return True if too many brackets are open at once, those in quotes and comments included."""
    if text.count("[") + text.count("{") <= MAX_SLOW_BRACKETS:
        return False
    depth = deepest = 0
    for bracket in re.findall(r"[\[\]{}]", text):
        depth = depth + 1 if bracket in "[{" else max(depth - 1, 0)
        deepest = max(deepest, depth)
    return deepest > MAX_SLOW_BRACKETS


def by_libyaml(text: str) -> Iterator[Event]:
    """Yield the events of libyaml, the C parser within PyYAML."""
    from yaml.cyaml import CParser
    from yaml.error import MarkedYAMLError, YAMLError

    try:
        yield from iter(CParser(text).get_event, None)
    except MarkedYAMLError as error:
        raise _converted(error) from None
    except YAMLError as error:
        raise YamlError(None, str(error), "", None) from None


def by_ruamel(text: str) -> Iterator[Event]:
    """Yield the events of ruamel.yaml's own parser."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError

    try:
        yield from YAML(typ="safe", pure=True).parse(text)
    except MarkedYAMLError as error:
        raise _converted(error) from None
    except GeneratorExit:
        raise
    except Exception as error:  # noqa: BLE001 the parser has errors of its own: they are the file's
        what = f"not valid YAML from here on ({type(error).__name__})"
        raise YamlError(None, what, "use a simpler form", None) from None


def has_libyaml() -> bool:
    """Return True if PyYAML was built with libyaml, as its wheels are."""
    import yaml

    return bool(yaml.__with_libyaml__)


def _disputed(text: str) -> int | None:
    """Return the offset of the first character on which the parsers may differ, or None."""
    found = _DISPUTED.search(text) if any(sign in text for sign in _NEEDED) else None
    places = [found.start()] if found else []
    # libyaml accepts tabs as indentation, which YAML forbids. A tab after ` #` is harmless: it
    # lies in a comment or in quoted text.
    start = 0
    for line in text.split("\n") if "\t" in text else ():
        tab, comment = line.find("\t"), 0 if line.startswith("#") else line.find(" #")
        if tab >= 0 and not 0 <= comment < tab:
            places.append(start + tab)
            break
        start += len(line) + 1
    return min(places, default=None)


def _converted(error: Any) -> YamlError:
    """Convert the error of either parser."""
    mark, context_mark = error.problem_mark or error.context_mark, error.context_mark
    place = (mark.line + 1, mark.column + 1) if mark is not None else None
    started = context_mark.line + 1 if context_mark is not None else None
    return YamlError(place, _flat(error.problem), _flat(error.context), started)


def _flat(words: str | None) -> str:
    return " ".join((words or "").split())
