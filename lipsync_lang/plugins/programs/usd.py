"""Universal Scene Description: a SkelAnimation of blend shapes, as text.

The file holds only the animation; the model binds it by `skel:animationSource` and matches shapes
by name (openusd.org, "UsdSkel schemas"). Time codes are frames, so rates such as 24000/1001 stay
exact. The sound starts at time code 0 plus the offset; earlier movement has lower time codes. Every
sample holds the weights of all shapes. USD joins samples by straight lines: with `keys`, the file
holds the samples that lines within this error need.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, TextIO

import numpy as np

from lipsync_lang import OutputError
from lipsync_lang.animations.fixed import boneless
from lipsync_lang.animations.moving_shapes import shapes
from lipsync_lang.animations.writers import Animation, template, writer
from lipsync_lang.animations.writers.glb import unplaced
from lipsync_lang.base.errors import shortlist

if TYPE_CHECKING:
    from lipsync_lang.base.arrays import Floats

USD_ESCAPES = str.maketrans({"\\": r"\\", '"': r"\"", "\n": r"\n", "\r": r"\r", "\t": r"\t"})
"""Characters of a name that a string of USD cannot hold."""


def doubts(animation: Animation) -> Iterator[str]:
    """Yield warnings about channels that the file omits."""
    yield from unplaced(animation)
    yield from boneless(animation, "a .usda")


@writer("usd", suffix=".usda", remarks=doubts)
def write_usd(animation: Animation, out: TextIO) -> None:
    """A USD SkelAnimation of blend shapes, to be bound to a model."""
    animation = animation.thinned()
    # USD matches by name alone, so meshes are merged.
    found = shapes(animation)
    moves: dict[str, Floats] = {}
    for shape in found:
        moves.setdefault(shape.name, shape.values)
    strays = {shape.name for shape in found if (shape.values != moves[shape.name]).any()}
    if apart := [name for name in moves if name in strays]:
        what = "moves differently on different meshes, but USD identifies shapes by name"
        raise OutputError(f"{shortlist(apart)}: {what}; rename it on one of the meshes")
    frames = (animation.times + animation.offset) * animation.fps
    numbers = (f"{round(frame, 6) + 0.0:.6f}" for frame in frames.tolist())
    codes = [number.rstrip("0").rstrip(".") for number in numbers]
    rate = repr(float(animation.fps)).removesuffix(".0")
    tokens = ", ".join(f'"{name.translate(USD_ESCAPES)}"' for name in moves)
    row = "        %s: [" + ", ".join(["%.6g"] * len(moves)) + "],\n"
    # Adding 0.0 turns the negative zeros of rounding into zeros.
    table = np.column_stack([*moves.values()]).round(6) + 0.0
    samples = zip(codes, table.tolist(), strict=True)
    rows = "".join(row % (code, *weights) for code, weights in samples)
    values = {"start": codes[0], "end": codes[-1], "rate": rate, "tokens": tokens, "samples": rows}
    out.write(template(__file__)[0].format(**values))
