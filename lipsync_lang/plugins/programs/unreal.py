"""An Unreal Engine curve table, for CSV import in the editor.

Based on `UCurveTable::CreateTableFromCSVString`. The first row holds the times, and every other row
is a curve. The first cell of a row is its name; the first cell of the first row is ignored. Names
are case-insensitive, and duplicates are rejected. The import dialog sets the interpolation; choose
`Linear`. Times are seconds of the sound and may be negative. Line ends are CRLF, as required by the
importers of older versions. The rows share their times and a table has no tangents: with `keys`,
the file holds the columns that straight lines within this error need.
"""

import csv
from collections import Counter
from typing import TextIO

from lipsync_lang import OutputError
from lipsync_lang.animations.moving_shapes import in_words_of_model
from lipsync_lang.animations.writers import Animation, writer


@writer("unreal", suffix=".unreal.csv")
def write_unreal(animation: Animation, out: TextIO) -> None:
    """A curve table of Unreal Engine: a row for each curve, a column for each frame."""
    animation = in_words_of_model(animation)
    counts = Counter(name.casefold() for name in animation.poses)
    twice = [name for name in animation.poses if counts[name.casefold()] > 1]
    if twice:
        what = f"Unreal Engine does not distinguish {' and '.join(twice)}"
        raise OutputError(f"{what}; rename one of them")
    animation = animation.thinned()
    table = csv.writer(out, lineterminator="\r\n")
    times = (animation.times + animation.offset).tolist()
    table.writerow(["Name", *(f"{time:.6f}" for time in times)])
    for name, values in zip(animation.poses, animation.weights.T.tolist(), strict=True):
        table.writerow([name, *(f"{value:.6f}" for value in values)])
