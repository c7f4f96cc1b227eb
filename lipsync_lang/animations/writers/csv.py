"""Comma-separated values, for spreadsheets and scripts."""

from typing import TextIO

import numpy as np

from lipsync_lang.animations.moving_shapes import in_words_of_model
from lipsync_lang.animations.writers import Animation, writer
from lipsync_lang.base.arrays import Floats
from lipsync_lang.pipeline import kernel

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
    table = np.column_stack([animation.times + animation.offset, animation.weights])
    starts = range(0, len(table), ROWS_AT_ONCE)
    out.writelines(_rows(table[first : first + ROWS_AT_ONCE]) for first in starts)


def _rows(table: Floats) -> str:
    """Return rows of seconds with six digits, and of weights with five."""
    if kernel.compiled is not None:
        return str(kernel.compiled.rows(table.shape[1], np.ascontiguousarray(table)))
    row = ",".join(["%.6f", *["%.5f"] * (table.shape[1] - 1)]) + "\n"
    return row * len(table) % tuple(table.ravel().tolist())
