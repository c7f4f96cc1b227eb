"""Formats with a fixed list of shapes.

The lists are text files in `names/`, with one name per line in file order: first the shapes, then,
after an empty line, the rotations of head and eyes, of which only those of the head move. Columns
match shapes by the name rules of `faces/rigs/shape_matching.py`, so spelling variants are accepted.
"""

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import OutputError, shortlist
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.shape_matching import placed
from lipsync_lang.faces.rigs.transforms import HEAD_ANGLES, HeadTurn, head_angles


class FormatNames(NamedTuple):
    """Names of the shapes and rotations of a format."""

    shapes: tuple[str, ...]
    turns: tuple[str, ...]


@cache
def names(file: Path) -> FormatNames:
    """Read a list of names: shapes, and below a blank line turns of the head."""
    shapes, _, turns = file.read_text(encoding="utf-8").partition("\n\n")
    return FormatNames(tuple(shapes.split()), tuple(turns.split()))


class FixedColumns:
    """Arranges columns of a face in the fixed order of a format.

    Weights are clipped to 0 to 1, and turns of the head are radians. Shapes without a column are 0.
    If two columns match one shape, the larger weight is used. Raises OutputError if no column
    matches a shape of the format.
    """

    def __init__(self, columns: Sequence[Channel], held: FormatNames, program: str) -> None:
        found = placed(columns, held.shapes).shapes
        if not found:
            raise OutputError(
                f"{program} holds ARKit's shapes alone ({', '.join(held.shapes[:2])}, ...), and "
                f"here are {shortlist([one.name for one in columns])}; perform on a character "
                "whose poses, or whose rig's channels, have those names"
            )
        pairs = [(n, held.shapes.index(shape)) for n, own in found.items() for shape in own]
        self._sources, self._targets = np.array(pairs).T
        self._held, self._head = held, _head(columns, held)

    def __call__(self, weights: Floats) -> Floats:
        """Arrange (T, P) weights: (T, N)."""
        first, turns = len(self._held.shapes), len(self._held.turns)
        table = np.zeros((first + turns, len(weights)))
        # Indexing would keep one of two columns for a shape; `at` goes through both.
        np.maximum.at(table, self._targets, weights.T[self._sources])
        table = table.clip(0.0, 1.0)
        if self._head.columns:
            table[first : first + len(HEAD_ANGLES)] = head_angles(self._head(weights)).T
        return table.T


def _head(columns: Sequence[Channel], held: FormatNames) -> HeadTurn:
    """Return the turns of the head that a format holds."""
    return HeadTurn.of(columns if held.turns[: len(HEAD_ANGLES)] == HEAD_ANGLES else ())


def doubts(animation: Animation, file: Path, program: str) -> Iterator[str]:
    """Yield warnings about omitted channels and a delayed sound, for a name list."""
    columns, held = animation.columns, names(file)
    found = {*placed(columns, held.shapes).shapes, *_head(columns, held).columns}
    yield from _lost(animation, [n for n in range(len(animation.poses)) if n not in found], program)
    yield from late(animation, program)


def shape_columns(animation: Animation) -> list[int]:
    """Return the indices of columns that are shapes; an OutputError if all are bones."""
    found = [n for n, channel in enumerate(animation.columns) if channel.node is None]
    if not found:
        raise OutputError("only bones move, and this format has only shapes; write a .glb")
    return found


def first_frame(animation: Animation) -> int:
    """Return the number of the first frame, in formats that count frames from the file start."""
    return round(float(animation.timeline[0]) * animation.fps)


def boneless(animation: Animation, program: str, *, head: bool = False) -> Iterator[str]:
    """Yield a warning about moving bones, for formats without bones, except perhaps the `head`."""
    shown = HeadTurn.of(animation.columns).columns if head else ()
    bones = [n for n, one in enumerate(animation.columns) if one.node is not None]
    yield from _lost(animation, [n for n in bones if n not in shown], program)


def late(animation: Animation, program: str) -> Iterator[str]:
    """Yield a warning about a delayed sound, for formats without negative time."""
    if animation.begins > animation.offset:
        yield (
            f"{program} has no time below zero, so the sound begins {animation.begins:.3f} s into "
            "the file: start it so much later, or leave out what comes before it (`cut`)"
        )


def shapes_from_zero(animation: Animation, program: str, *, head: bool = False) -> Iterator[str]:
    """Yield warnings about bones and a delayed sound, for formats that have neither."""
    yield from boneless(animation, program, head=head)
    yield from late(animation, program)


def _lost(animation: Animation, columns: list[int], program: str) -> Iterator[str]:
    if np.any(animation.weights[:, columns]):  # all are named, so that a build says it once
        lost = [animation.poses[number] for number in columns]
        yield f"{program} has nothing for {shortlist(lost)}"
