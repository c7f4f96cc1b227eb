"""Comma-separated values: a time column, and one column per curve."""

import csv
from pathlib import Path

import numpy as np

from lipsync_lang.animations.animation_readers import Recording, fail, reader
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import AnimationError
from lipsync_lang.base.files.reading import utf8_text

TIME_COLUMNS = dict.fromkeys(("ms", "timems", "milliseconds"), 1e-3) | dict.fromkeys(
    ("time", "times", "seconds", "sec", "t", "timestamp", "timeseconds", "timecode"), 1.0
)
"""Normalised headers of time columns, and their units in seconds."""

SEPARATORS = ",;\t"


@reader("csv", suffix=".csv")
def read_csv(path: Path, content: bytes) -> Recording:
    """A column of times (`time_s`, `time`, `time_ms`, ...), then a column for each curve."""
    times, names, values = table_of(path, content)
    return Recording(str(path), times, names, values)


def table_of(
    path: Path, content: bytes, *, gaps: bool = False
) -> tuple[Floats, tuple[str, ...], Floats]:
    """Read times (T,) in seconds, C names, and values (T, C); with `gaps`, blank cells are NaN."""
    text = utf8_text(path, content, AnimationError)
    first = text.partition("\n")[0]
    # The header alone is counted, because numbers in the rows may have decimal commas.
    separator = max(SEPARATORS, key=first.count)
    try:
        rows = [row for row in csv.reader(text.splitlines(), delimiter=separator) if any(row)]
    except csv.Error as error:
        fail(path, f"is not a table: {error}")
    if not rows:
        fail(path, "is empty", "export it again")
    if gaps:
        rows[1:] = [[value.strip() or "nan" for value in row] for row in rows[1:]]
    head = [name.strip() for name in rows[0]]
    unit = TIME_COLUMNS.get("".join(filter(str.isalpha, head[0].lower())))
    if unit is None:
        what = f"its first column is '{head[0]}', not a time"
        fail(f"{path}:1", what, "name it time_s or time_ms")
    values = np.array([_numbers(path, n, row, len(head)) for n, row in enumerate(rows[1:], 2)])
    table = values.reshape(-1, len(head))
    return table[:, 0] * unit, tuple(head[1:]), table[:, 1:]


def _numbers(path: Path, line: int, row: list[str], count: int) -> list[float]:
    """Parse the numbers of a row."""
    if len(row) != count:
        fail(f"{path}:{line}", f"has {len(row)} values for {count} columns", "export it again")
    numbers: list[float] = []
    try:
        numbers.extend(map(float, row))
    except ValueError:
        bad = row[len(numbers)]  # `extend` keeps the numbers before it
        mend = "write it with a point" if "," in bad else "remove the text"
        fail(f"{path}:{line}", f"'{bad[:20]}' is not a number", mend)
    return numbers
