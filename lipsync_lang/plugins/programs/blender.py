"""A Blender script that sets keyframes on the shape keys of a face.

Blender cannot import curve files but runs Python. The script holds the keyframes as JSON, followed
by the code from `blender.txt`. It applies them to all meshes with matching shape keys;
known alternative spellings match too. Curves are linear between keys, or Bezier curves with `keys`:
handles a third of the way to the next key make them cubic in time. The sound starts at frame 1
plus the offset; movement before the sound is at earlier frames.
"""

import json
from functools import partial
from math import ceil
from typing import TextIO

import numpy as np

from lipsync_lang.animations.fixed import boneless, shape_columns
from lipsync_lang.animations.keys import ERROR
from lipsync_lang.animations.moving_shapes import on_model, unbound
from lipsync_lang.animations.writers import Animation, template, writer
from lipsync_lang.base.arrays import Floats

FIRST = 1
"""First frame number of a Blender scene."""


@writer("blender", suffix=".py", remarks=partial(boneless, program="Blender"))
def write_blender(animation: Animation, out: TextIO) -> None:
    """A script for Blender's text editor: keyframes of shape keys."""
    animation = unbound(animation)
    curves, on_meshes = animation.keyframes(ERROR), on_model(animation)
    rate = max(1, round(animation.fps))
    channels: list[dict[str, object]] = []
    for number in shape_columns(animation):
        channel, curve = animation.columns[number], curves[number]
        spellings = [name for _, name, column in on_meshes if column == number]
        keys: dict[str, object] = {
            "names": list(dict.fromkeys([channel.name, *spellings, *channel.names])),
            "mesh": channel.mesh,
            "frames": _frames(animation, curve.times - animation.begins),
            "values": curve.values.round(6).tolist(),
        }
        if curve.cubic:
            slopes = np.column_stack((curve.arriving, curve.leaving)) / animation.fps
            keys["slopes"] = slopes.round(8).tolist()
        channels.append(keys)
    take = {
        "name": animation.title,
        "fps": rate,
        # Rates of Blender are whole numbers, divided by a base: 24 by 1.001 for 23.976.
        "fps_base": rate / animation.fps,
        "end": ceil(_frames(animation, animation.times)[-1]),
        "channels": channels,
    }
    [sound] = _frames(animation, np.zeros(1))
    script = template(__file__)[0].replace("@SOUND@", f"{sound:g}")
    out.write(script.replace("@TAKE@", json.dumps(take)))


def _frames(animation: Animation, times: Floats) -> list[float]:
    """Convert seconds of the sound to scene frames."""
    return (FIRST + (times + animation.offset) * animation.fps).round(5).tolist()
