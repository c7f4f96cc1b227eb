"""RPG Maker MV and MZ: the messages and choices of maps, common events and troops.

An event has lists of commands, each with a code and parameters. A message begins with command 101,
whose fifth parameter is the speaker in MZ, and its rows are commands 401; rows of a scrolling text
are 405 after 105. Command 102 has the choices. A line is named by the numbers on its way.
"""

import re
from collections.abc import Iterator
from itertools import groupby

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.text.lines.entries import MAX_ENTRY_DEPTH, ScriptEntry
from lipsync_lang.text.lines.json_scripts import JsonScript, add_json_script
from lipsync_lang.text.lines.line_readers import LineFile

MESSAGE, MESSAGE_ROW, CHOICES, SCROLLING, SCROLLING_ROW = 101, 401, 102, 105, 405
ROW_CODES = {MESSAGE: MESSAGE_ROW, SCROLLING: SCROLLING_ROW}
SPEAKER_PARAMETER = 4
SMALL_CODE = re.compile(r"\\[a-z]+(?=\[)")
"""A code in small letters, such as `\\v[2]`; the engine reads both alike."""


class RpgMaker(JsonScript):
    """The format of RPG Maker's events."""

    def fits(self, document: object) -> bool:
        """Return True if the file holds commands of events."""
        return next(_lists(document, ()), None) is not None

    def entries(self, source: LineFile, file: TimingFile) -> Iterator[ScriptEntry]:
        """Yield the messages and choices of a file; each event of a file is a line of it."""
        stem = source.path.stem
        at, line = 0, 1
        for keys, commands in _lists(file.json, ()):
            for number, command in enumerate(commands):
                name = ".".join((stem, *keys, str(number)))
                for choice, (text, speaker) in enumerate(_texts(commands, number, command)):
                    # Parsed JSON has no lines, and texts may repeat, so the search goes on from the
                    # text before. It stops at a backslash, which the file doubles.
                    found = file.text.find(text.partition("\n")[0].partition("\\")[0], at)
                    if found >= 0:
                        line += file.text.count("\n", at, found)
                        at = found
                    many = command["code"] == CHOICES
                    yield ScriptEntry(
                        line, f"{name}-{choice}" if many else name, text, speaker=speaker
                    )


def _texts(commands: list[Json], at: int, command: Json) -> Iterator[tuple[str, str]]:
    """Yield the texts that begin with a command, with their speaker."""
    given = command["parameters"]
    if command["code"] in ROW_CODES:
        kind, found = next(
            ((kind, list(rows)) for kind, rows in groupby(commands[at + 1 :], _code)), (0, [])
        )
        rows = [_capital(one["parameters"][0]) for one in found if one["parameters"]]
        speaker = given[SPEAKER_PARAMETER] if len(given) > SPEAKER_PARAMETER else ""
        if kind == ROW_CODES[command["code"]]:
            yield "\n".join(rows), speaker if isinstance(speaker, str) else ""
    elif command["code"] == CHOICES and given and isinstance(given[0], list):
        yield from ((_capital(text), "") for text in given[0])


def _capital(text: object) -> str:
    return SMALL_CODE.sub(lambda found: found[0].upper(), str(text))


def _code(command: Json) -> int:
    return int(command["code"])


def _lists(value: object, keys: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], list[Json]]]:
    """Yield the lists of commands in a document, with the numbers on their way."""
    if isinstance(value, list) and any(map(_is_command, value)):
        yield keys, [one for one in value if _is_command(one)]
    elif isinstance(value, (list, dict)) and len(keys) < MAX_ENTRY_DEPTH:
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, inner in pairs:
            step = (str(key),) if isinstance(value, list) else ()
            yield from _lists(inner, (*keys, *step))


def _is_command(value: object) -> bool:
    return (
        isinstance(value, dict)
        and isinstance(value.get("code"), int)
        and isinstance(value.get("parameters"), list)
    )


add_json_script(
    RpgMaker(
        "rpg-maker",
        "RPG Maker MV and MZ: messages and choices of maps and events (`Map001.json`).",
        text="parameters",
    ),
    __name__,
)
