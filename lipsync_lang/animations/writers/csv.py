"""Comma-separated values, for spreadsheets and scripts."""

from typing import TextIO

import numpy as np

from lipsync_lang.animations.moving_shapes import in_words_of_model
from lipsync_lang.animations.writers import Animation, writer

ROWS_AT_ONCE = 1000
"""Rows formatted at once; one at a time takes twice as long."""


@writer("csv", suffix=".csv")
def write_csv(animation: Animation, out: TextIO) -> None:
    """A row per frame: time_s, then a column per pose."""
    animation = in_words_of_model(animation)
    quoted = (
        '"' + name.replace('"', '""') + '"' if set(name) & set(',"\r\n') else name
        for name in animation.poses
    )
    out.write(",".join(["time_s", *quoted]) + "\n")
    row = ",".join(["%.6f", *["%.5f"] * len(animation.poses)]) + "\n"
    table = np.column_stack([animation.times + animation.offset, animation.weights])
    for first in range(0, len(table), ROWS_AT_ONCE):
        part = table[first : first + ROWS_AT_ONCE]
        out.write(row * len(part) % tuple(part.ravel().tolist()))
