"""Formats that hold a list of shapes of their own, whatever a face has.

Their lists are text in `names/`, one name a line in the order of the file: first the shapes, then,
after an empty line, turns of the head and the eyes, which speech leaves at 0. A column of an
animation is the shape that it would be on a model (see `rigs/names.py`), so in any spelling.
"""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.animations.animation import Animation
from lipsync_lang.errors import OutputError
from lipsync_lang.rigs.model import some
from lipsync_lang.rigs.names import places

Floats = npt.NDArray[np.float64]


class FormatNames(NamedTuple):
    """What a format holds."""

    shapes: tuple[str, ...]
    turns: tuple[str, ...]


@cache
def names(file: str) -> FormatNames:
    """Read a list of `names/`."""
    text = (Path(__file__).parent / "names" / file).read_text(encoding="utf-8")
    shapes, _, turns = text.partition("\n\n")
    return FormatNames(tuple(shapes.split()), tuple(turns.split()))


def laid_out(animation: Animation, held: FormatNames, program: str) -> Floats:
    """Return (T, N) what a format holds: weights from 0 to 1, and 0 for what nothing moves.

    Of two columns for one shape, the larger counts.

    Raises
    ------
    OutputError
        No column is a shape of the format.
    """
    table = np.zeros((len(animation.times), len(held.shapes) + len(held.turns)))
    found = places(animation.columns, held.shapes)
    if not found:
        raise OutputError(
            f"{program} holds ARKit's shapes alone ({', '.join(held.shapes[:2])}, ...), and here "
            f"are {some(animation.poses)}; perform on a character whose poses, or whose rig's "
            "channels, have those names"
        )
    for column, shapes in found.items():
        for shape in shapes:
            number = held.shapes.index(shape)
            table[:, number] = np.maximum(table[:, number], animation.weights[:, column])
    return table.clip(0.0, 1.0)


def doubts(animation: Animation, held: FormatNames, program: str) -> Iterator[str]:
    """Yield, in words, what moves and is not held, and when the sound begins."""
    found = places(animation.columns, held.shapes)
    yield from _lost(animation, [n for n in range(len(animation.poses)) if n not in found], program)
    yield from late(animation, program)


def shape_columns(animation: Animation) -> list[int]:
    """Return the columns that are shapes.

    Raises
    ------
    OutputError
        All are bones.
    """
    found = [n for n, channel in enumerate(animation.columns) if channel.node is None]
    if not found:
        raise OutputError(
            "all that moves here are bones, and this format holds shapes; write a .glb"
        )
    return found


def first_frame(animation: Animation) -> int:
    """Return which frame the first one is, in files that count frames from their beginning."""
    return round(float(animation.timeline[0]) * animation.fps)


def boneless(animation: Animation, program: str) -> Iterator[str]:
    """Yield, in words, which bones move that a format without bones does not hold."""
    bones = [n for n, channel in enumerate(animation.columns) if channel.node is not None]
    yield from _lost(animation, bones, program)


def late(animation: Animation, program: str) -> Iterator[str]:
    """Yield, in words, when the sound begins, if a format without time below zero delays it."""
    if animation.begins > animation.offset:
        yield (
            f"{program} has no time below zero, so the sound begins {animation.begins:.3f} s into "
            "the file: start it so much later, or leave out what comes before it (`cut`)"
        )


def _lost(animation: Animation, columns: list[int], program: str) -> Iterator[str]:
    moved = np.abs(animation.weights).max(axis=0, initial=0.0) > 0
    lost = [animation.poses[n] for n in columns if moved[n]]
    if lost:
        yield f"{program} has nothing for {', '.join(lost)}"
