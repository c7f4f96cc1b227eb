"""Parse a YAML text into events with PyYAML: by libyaml, which its wheels carry, or without.

Both parsers know YAML 1.1. The texts that YAML 1.2 reads otherwise (tabs as indentation, unusual
line breaks) are refused before they are parsed. See decision 0016.
"""

from collections.abc import Iterator
from typing import Any

Event = Any
"""An event of PyYAML, with or without libyaml."""


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
    import yaml

    # The C parser is fifteen times as fast.
    parser = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        yield from iter(parser(text).get_event, None)
    except yaml.MarkedYAMLError as error:
        mark, context_mark = error.problem_mark or error.context_mark, error.context_mark
        place = (mark.line + 1, mark.column + 1) if mark is not None else None
        started = context_mark.line + 1 if context_mark is not None else None
        raise YamlError(place, _flat(error.problem), _flat(error.context), started) from None
    except yaml.YAMLError as error:
        raise YamlError(None, _flat(str(error)), "", None) from None


def _flat(words: str | None) -> str:
    return " ".join((words or "").split())
