"""A script of Ren'Py: an image of the mouth that changes its drawings, and the line with its voice.

Based on the manual of Ren'Py 8 ("Transforms", "Voice"). The image is an ATL block: a picture, then
the seconds for which it stays. Pictures are `images/mouth/NAME.png` in the folder `game`. The
label shows the image and says the line, so that mouth and voice start together. Movement before the
sound is cut.
"""

import re
from itertools import pairwise
from typing import TextIO

from lipsync_lang.animations.held import NEUTRAL_DRAWING, held
from lipsync_lang.animations.writers import Animation, writer

RENPY_ESCAPES = str.maketrans(
    {"\\": r"\\", '"': r"\"", "\n": " ", "\r": " ", "[": "[[", "{": "{{", "%": "%%"}
)
"""Characters with a meaning in text of Ren'Py."""


@writer("renpy", suffix=".rpy")
def write_renpy(animation: Animation, out: TextIO) -> None:
    """A script of Ren'Py: an image of changing drawings, and the line with its voice."""
    shapes = held(animation)
    name = re.sub(r"\W+", "_", animation.title.casefold()).strip("_") or "line"
    name = name if name.isascii() else f"line_{name.encode().hex()[:32]}"
    pictures = [*shapes, shapes[-1]._replace(name=animation.neutral or NEUTRAL_DRAWING)]
    files = [re.sub(r'[\\/:*?"<>|\x00-\x1f]', "_", shape.name) for shape in pictures]
    rows = [f'    "images/mouth/{file}.png"\n' for file in files]
    # Ends are rounded, and not waits, so that errors do not add up over a line.
    ends = [0, *(round(1000 * shape.end) for shape in shapes)]
    waits = [f"    {(end - start) / 1000:.3f}\n" for start, end in pairwise(ends)]
    out.write(f"image mouth {name}:\n")
    out.writelines(row + wait for row, wait in zip(rows, [*waits, ""], strict=True))
    words = " ".join(word.text for word in animation.schedule.words) or animation.title
    out.write(
        f"\nlabel say_{name}:\n"
        f"    show mouth {name}\n"
        f'    voice "audio/{name}.wav"\n'
        f'    "{words.translate(RENPY_ESCAPES)}"\n'
        "    return\n"
    )
