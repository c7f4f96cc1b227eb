"""Blend shape weights in the JSON format of NVIDIA Audio2Face.

`weightMat` is a (T, C) list of weights, with columns in the order of `facsNames`. Frame k is at
k / `exportFps` seconds. The offset is rounded to whole frames of rest. Importers match shapes by
name, so each column keeps its own name; weights are not scaled.
"""

import json
from functools import partial
from typing import TextIO

from lipsync_lang.animations.fixed import first_frame, shape_columns, shapes_from_zero
from lipsync_lang.animations.writers import Animation, writer


@writer("audio2face", suffix=".a2f.json", remarks=partial(shapes_from_zero, program="Audio2Face"))
def write_audio2face(animation: Animation, out: TextIO) -> None:
    """Audio2Face's weights: a list per frame, in the order of the shapes' names."""
    shapes = shape_columns(animation)
    rest = [json.dumps([0.0] * len(shapes))] * first_frame(animation)
    rows = [*rest, *map(json.dumps, animation.weights[:, shapes].round(6).tolist())]
    head = {
        "exportFps": animation.fps,
        "numPoses": len(shapes),
        "numFrames": len(rows),
        "facsNames": [animation.poses[n] for n in shapes],
    }
    # The matrix is added as text: `indent` would give each of its numbers a line.
    text = json.dumps(head, ensure_ascii=False, indent=1)
    out.write(f'{text[: text.rindex("}")].rstrip()},\n "weightMat": [\n  ')
    out.write(",\n  ".join(rows) + "\n ]\n}\n")
