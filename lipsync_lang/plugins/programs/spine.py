"""A skeleton of Spine, as JSON of version 4.2: drawings of the mouth that replace each other.

Based on "JSON export format" (esotericsoftware.com/spine-json-format). The slot `mouth` shows one
attachment at a time, whose names are those of the drawings. The animation has the name of the line.
Movement before the sound is cut, so that both start together. The sizes of the drawings are those
of the project into which the file is imported; here they are stand-ins.
"""

import json
from typing import TextIO

from lipsync_lang.animations.held import NEUTRAL_DRAWING, held
from lipsync_lang.animations.writers import Animation, writer

SPINE_VERSION = "4.2.00"
SLOT = "mouth"
STAND_IN_PIXELS = 100


@writer("spine", suffix=".spine.json")
def write_spine(animation: Animation, out: TextIO) -> None:
    """A skeleton of Spine 4.2: the time at which its slot shows each drawing."""
    rest = animation.neutral or NEUTRAL_DRAWING
    shapes = held(animation)
    keys = [{"time": round(shape.start, 4), "name": shape.name} for shape in shapes]
    keys.append({"time": round(shapes[-1].end, 4), "name": rest})
    drawings = dict.fromkeys([rest, *(shape.name for shape in shapes)])
    size = {"width": STAND_IN_PIXELS, "height": STAND_IN_PIXELS}
    document = {
        "skeleton": {"spine": SPINE_VERSION},
        "bones": [{"name": "root"}],
        "slots": [{"name": SLOT, "bone": "root", "attachment": rest}],
        "skins": [{"name": "default", "attachments": {SLOT: dict.fromkeys(drawings, size)}}],
        "animations": {animation.title: {"slots": {SLOT: {"attachment": keys}}}},
    }
    json.dump(document, out, ensure_ascii=False, indent=1)
    out.write("\n")
