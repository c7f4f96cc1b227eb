"""Parse YAML with ruamel.yaml: by libyaml, if `ruamel.yaml.clib` is installed, or in Python.

libyaml knows YAML 1.1. The texts that YAML 1.2 reads otherwise (tabs as indentation, unusual line
breaks) are refused before they are parsed. See decision 0016.
"""

import re
from collections import deque
from collections.abc import Iterator
from importlib import import_module
from itertools import islice
from typing import Any

Event = Any
"""An event of ruamel.yaml, of either parser."""

_WITHIN_A_WORD = re.compile(r"[:?][^\s,\[\]{}]")
"""A sign that libyaml refuses within a word between brackets, as in `{source: https://...}`."""

_HELD_BACK = 8
"""Number of events that are kept back: libyaml splits a word before it refuses its sign."""


class YamlError(Exception):
    """The parser cannot read the text: its words, which may be empty, and their place.

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


def events(text: str) -> Iterator[Event]:
    """Yield the events of a text; raise `YamlError` where it cannot be read."""
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    try:
        yield from _parsed(text)
    except MarkedYAMLError as error:
        mark, context_mark = error.problem_mark or error.context_mark, error.context_mark
        place = (mark.line + 1, mark.column + 1) if mark is not None else None
        started = context_mark.line + 1 if context_mark is not None else None
        raise YamlError(place, _flat(error.problem), _flat(error.context), started) from None
    except YAMLError as error:
        raise YamlError(None, _flat(str(error)), "", None) from None


def load_yaml(text: str) -> Any:
    """Load a text that this project has written itself, such as its table of faults.

    Packs are read by `scan`, which knows places, and reads plain words as text.
    """
    from ruamel.yaml import YAML

    return YAML(typ="safe").load(text)


def parser_in_c() -> Any:
    """Return the class of libyaml's parser; None without `ruamel.yaml.clib`."""
    try:
        return import_module("ruamel.yaml.cyaml").CParser
    except ImportError:
        return None


def _parsed(text: str) -> Iterator[Event]:
    """Yield the events of libyaml, or of the parser in Python where that reads more.

    Events are yielded as they are parsed, so that a reader who has seen enough stops the parser.
    """
    from ruamel.yaml.error import MarkedYAMLError

    libyaml = parser_in_c()
    if libyaml is None:
        yield from _parsed_in_python(text)
        return
    given, held = 0, deque[Event]()
    try:
        for event in iter(libyaml(text).get_event, None):
            held.append(event)
            if len(held) > _HELD_BACK:
                given += 1
                yield held.popleft()
    except MarkedYAMLError as error:
        mark = error.problem_mark
        if mark is not None and _WITHIN_A_WORD.match(text, mark.index):
            # The other parser starts anew, and passes over what was given.
            yield from islice(_parsed_in_python(text), given, None)
            return
        yield from held
        raise
    yield from held


def _parsed_in_python(text: str) -> Iterator[Event]:
    from ruamel.yaml import YAML

    return YAML(typ="safe", pure=True).parse(text)


def _flat(words: str | None) -> str:
    return " ".join((words or "").split())
