"""Blend shapes in the JSON format of the Azure speech service.

One JSON object holds the number of its first frame and a (T, 55) list of values from 0 to 1: the
52 ARKit shapes, then rotations of head and eyes. The rate is always 60 frames per second
(learn.microsoft.com, "Get facial position with viseme"). The offset is rounded to whole frames;
weights are clipped to 0 to 1.
"""

import json
from functools import partial
from pathlib import Path
from typing import TextIO

from lipsync_lang import OutputError
from lipsync_lang.animations.fixed import FixedColumns, doubts, first_frame, names
from lipsync_lang.animations.writers import Animation, writer
from lipsync_lang.base.arrays import Floats

AZURE = "Azure"
FPS = 60
AZURE_NAMES = Path(__file__).with_name("azure-names.txt")


def _table(animation: Animation) -> Floats:
    """Return the values of each frame; refuse another rate, and other shapes."""
    if animation.fps != FPS:
        what = f"{AZURE}'s blend shapes are {FPS} frames a second, and this is {animation.fps:g}"
        raise OutputError(f"{what}; perform it with `fps={FPS}`")
    return FixedColumns(animation.columns, names(AZURE_NAMES), AZURE)(animation.weights)


@writer(
    "azure",
    suffix=".azure.json",
    remarks=partial(doubts, file=AZURE_NAMES, program=AZURE),
    refuse=_table,
)
def write_azure(animation: Animation, out: TextIO) -> None:
    """Azure's blend shapes: 55 weights for each of 60 frames a second."""
    table = _table(animation)
    rows = ",\n".join(json.dumps(row) for row in table.round(6).tolist())
    out.write(f'{{"FrameIndex": {first_frame(animation)}, "BlendShapes": [\n{rows}\n]}}\n')
