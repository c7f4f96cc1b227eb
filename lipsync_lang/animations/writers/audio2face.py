"""Blend shape weights in the JSON format of NVIDIA Audio2Face.

`weightMat` is a (T, C) list of weights, with columns in the order of `facsNames`. Frame k is at
k / `exportFps` seconds. The offset is rounded to whole frames of rest. Importers match shapes by
name, so each column keeps its own name; weights are not scaled.
"""

import json
from collections.abc import Iterator
from typing import TextIO

from lipsync_lang.animations.fixed import boneless, first_frame, late, shape_columns
from lipsync_lang.animations.writers import Animation, writer

AUDIO2FACE = "Audio2Face"


def remarks(animation: Animation) -> Iterator[str]:
    """Yield warnings about omitted channels and a delayed sound."""
    yield from boneless(animation, AUDIO2FACE)
    yield from late(animation, AUDIO2FACE)


@writer("audio2face", suffix=".a2f.json", remarks=remarks)
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
    text = json.dumps(head, ensure_ascii=False, indent=1)
    out.write(f'{text[: text.rindex("}")].rstrip()},\n "weightMat": [\n  ')
    out.write(",\n  ".join(rows) + "\n ]\n}\n")
