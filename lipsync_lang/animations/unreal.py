"""A curve table of Unreal Engine, as its editor imports it from CSV.

After `UCurveTable::CreateTableFromCSVString`: the first row names the times, every other row is a
curve with a value at each of them; the first cell of a row is its name, and that of the first row
counts for nothing. Names are not told apart by capitals, and a table that repeats one is refused.
Whether curves are straight between their keys is asked at the import: choose `Linear`. Times are
seconds of the sound, so a table may begin below zero. Lines end as Windows ends them, which the
importers of older versions need.
"""

import csv
from collections import Counter
from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.errors import OutputError


@writer("unreal", suffix=".unreal.csv")
def write_unreal(animation: Animation, out: TextIO) -> None:
    """A curve table of Unreal Engine: a row for each curve, a column for each frame."""
    counts = Counter(name.casefold() for name in animation.poses)
    twice = [name for name in animation.poses if counts[name.casefold()] > 1]
    if twice:
        raise OutputError(
            f"Unreal Engine does not tell {' and '.join(twice)} apart; rename one of them"
        )
    table = csv.writer(out, lineterminator="\r\n")
    times = (animation.times + animation.offset).tolist()
    table.writerow(["Name", *(f"{time:.6f}" for time in times)])
    for name, values in zip(animation.poses, animation.weights.T.tolist(), strict=True):
        table.writerow([name, *(f"{value:.6f}" for value in values)])
