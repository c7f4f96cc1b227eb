"""Contact sheet: stills of the most different faces of a line, each with its word and time."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from textwrap import shorten
from typing import Any, BinaryIO

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.errors import OutputError
from lipsync_lang.pipeline.arrays import Ints
from lipsync_lang.render.model.camera import close_up, framed
from lipsync_lang.render.model.gltf import pillow
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.schedules.schedule import SILENCE, Schedule

MOST, COLUMNS = 12, 4

CELL, FOOT, GAP, EDGE = 320, 58, 12, 16
"""Pixels: side of a still, height of its caption, gap between stills, margin of the sheet."""

PAPER, INK, PALE = "#ffffff", "#222222", "#777777"

FONTS = (
    *("DejaVuSans.ttf", "NotoSans-Regular.ttf", "segoeui.ttf", "Arial Unicode.ttf", "arial.ttf"),
    *("NotoSansCJK-Regular.ttc", "NotoSansCJKjp-Regular.otf", "msyh.ttc", "PingFang.ttc"),
    *("YuGothM.ttc", "malgun.ttf", "Nirmala.ttf", "NotoSansDevanagari-Regular.ttf"),
    *("NotoSansArabic-Regular.ttf", "NotoSansHebrew-Regular.ttf", "NotoSansThai-Regular.ttf"),
    *("FreeSans.ttf", "unifont.ttf"),
)
"""System fonts by preference; the first with all letters of a text is used."""

ABSENT = "\U0010fffe"
"""A character absent from every font."""


@dataclass(frozen=True)
class Still:
    """A moment of a line, in seconds of its schedule, with the sound and the word there."""

    seconds: float
    sound: str
    word: str


def sheet(animation: Animation, out: BinaryIO) -> None:
    """Draw the most different faces of a line.

    Raises
    ------
    OutputError
        Pillow is missing, or there is nothing to draw.
    ModelError
        The model cannot be drawn.
    """
    pillow()
    scene, schedule = staged(animation), animation.schedule
    middles = (schedule.times[:-1] + schedule.times[1:]) / 2
    stills = [
        Still(float(middles[number]), schedule.labels[number], _word(schedule, number))
        for number in _chosen(animation).tolist()
    ]
    _paste(stills, Artist(scene, CELL), scene.sound, out)


def moments(
    animation: Animation, seconds: Sequence[float], out: BinaryIO, *, close: bool = False
) -> None:
    """Draw the faces of a line at given times, from one place for all lines of a model.

    Parameters
    ----------
    seconds : in the schedule
    close : show the mouth alone

    Raises
    ------
    OutputError
        A time is outside the animation, Pillow is missing, or there is nothing to draw.
    ModelError
        The model cannot be drawn.
    """
    pillow()
    first, last = float(animation.times[0]), float(animation.times[-1])
    for one in seconds:
        if not first <= one <= last:
            raise OutputError(
                f"{one:g} s is outside the animation, which runs from {first:.3f} to {last:.3f} s"
            )
    scene, swept = staged(animation), staged(sweep(animation))
    camera = close_up(swept) if close else framed(swept)
    stills = [_still(animation.schedule, one) for one in seconds]
    _paste(stills, Artist(scene, CELL, camera, swept), scene.sound, out)


def _still(schedule: Schedule, seconds: float) -> Still:
    number = int(np.searchsorted(schedule.times, seconds, side="right")) - 1
    if not 0 <= number < len(schedule):
        return Still(seconds, SILENCE, "")
    return Still(seconds, schedule.labels[number], _word(schedule, number))


def _paste(stills: Sequence[Still], artist: Artist, start: float, out: BinaryIO) -> None:
    """Write a sheet of stills, of an animation whose sound begins at `start` seconds."""
    image = pillow()
    from PIL import ImageDraw

    columns = min(COLUMNS, len(stills))
    rows = -(-len(stills) // columns)
    size = (2 * EDGE - GAP + columns * (CELL + GAP), 2 * EDGE + rows * (CELL + FOOT))
    page = image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(page)
    for place, still in enumerate(stills):
        row, column = divmod(place, columns)
        left, top = EDGE + column * (CELL + GAP), EDGE + row * (CELL + FOOT)
        picture = artist.draw(still.seconds + start)
        page.paste(image.fromarray(picture), (left, top))
        told = f"{_plain(still.word, 24)}   {still.seconds:.2f} s".strip()
        _write(draw, left, top + CELL + 4, _plain(still.sound, 12), 20, INK)
        _write(draw, left, top + CELL + 29, told, 14, PALE)
    page.save(out, "PNG", optimize=True)


def _chosen(animation: Animation) -> Ints:
    """Choose the sounds with faces farthest from rest and from each other, in time order."""
    labels, times = animation.schedule.labels, animation.schedule.times
    sounds = np.array([n for n, label in enumerate(labels) if label != SILENCE] or [0])
    middles = (times[sounds] + times[sounds + 1]) / 2
    frames = np.searchsorted(animation.times, middles).clip(0, len(animation.times) - 1)
    most = np.abs(animation.weights).max(axis=0, initial=0.0)
    faces = animation.weights[frames] / np.where(most > 0, most, 1.0)
    apart = np.linalg.norm(faces, axis=1)
    chosen: list[int] = []
    while len(chosen) < min(MOST, len(sounds)):
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.linalg.norm(faces - faces[chosen[-1]], axis=1))
        apart[chosen] = -1.0
    found: Ints = sounds[np.sort(chosen)]
    return found


def _word(schedule: Schedule, number: int) -> str:
    word = schedule.word_at(number)
    return word.text if word else ""


def _plain(text: str, width: int) -> str:
    return shorten(text, width, placeholder="…") or text[:width].strip()


def _write(draw: Any, left: int, top: int, text: str, size: int, ink: str) -> None:  # noqa: PLR0913, PLR0917
    """Draw a text in the first font with all its letters, or else in the one with most of them."""
    letters = [letter for letter in dict.fromkeys(text) if not letter.isspace()]
    fonts = _fonts(size)
    lacks = [sum(not _has(font, letter) for letter in letters) for font in fonts]
    draw.text((left, top), text, fill=ink, font=fonts[lacks.index(min(lacks))])


@cache
def _fonts(size: int) -> list[Any]:
    from PIL import ImageFont

    found = []
    for name in FONTS:
        try:
            found.append(ImageFont.truetype(name, size))
        except OSError:
            continue
    return [*found, ImageFont.load_default(size)]


@cache
def _has(font: Any, letter: str) -> bool:
    return bytes(font.getmask(letter)) != bytes(font.getmask(ABSENT))
