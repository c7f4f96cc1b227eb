"""Contact sheet: stills of the most different faces of a line, each with its word and time."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from io import BytesIO
from pathlib import Path
from textwrap import shorten
from typing import Any, BinaryIO

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.errors import OutputError
from lipsync_lang.render.fonts import (
    FoundFonts,
    find_fonts,
    legible,
    letters_of,
    split_letters,
    warn_of,
)
from lipsync_lang.render.model.camera import close_up
from lipsync_lang.render.model.picture import Artist, Pixels
from lipsync_lang.render.model.scene import pillow
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.schedules.schedule import SILENCE, Schedule

MOST, COLUMNS, CAPTIONED_COLUMNS = 12, 4, 8

CELL, FOOT, GAP, EDGE = 320, 58, 12, 16
"""Pixels: side of a still, height of its caption, gap between stills, margin of the sheet."""

PAPER, INK, PALE = "#ffffff", "#222222", "#777777"

TITLE, NAME, SMALL = (28, INK), (20, INK), (14, PALE)
"""Sizes in pixels and colours of texts: the name of a face, and the two lines of a caption."""

FONTS = ("DejaVuSans.ttf", "NotoSans-Regular.ttf", "segoeui.ttf", "Arial Unicode.ttf", "arial.ttf")
"""Default fonts by preference; other installed fonts draw the letters missing from them."""

TRIED = 12
"""Pixels: font size for the test of letters."""

MISSING_CHARACTER = "\U0010fffe"
"""A character absent from every font."""

Still = tuple[float, str, str]
"""A moment of a line in seconds of its schedule, with the two lines of its caption."""

Draw = Callable[[float], Pixels]


def sheet(animation: Animation, out: BinaryIO) -> None:
    """Draw the most different faces of a line; an OutputError if there is nothing to draw."""
    pillow()
    scene, schedule = staged(animation), animation.schedule
    middles = (schedule.times[:-1] + schedule.times[1:]) / 2
    stills = [_still(schedule, float(middles[number])) for number in _chosen(animation)]
    artist = Artist(scene, CELL)
    draw_stills(stills, lambda seconds: artist.draw(seconds + scene.sound), out, COLUMNS)


def moments(
    animation: Animation, seconds: Sequence[float], out: BinaryIO, *, close: bool = False,
    captions: Sequence[tuple[str, str]] = (),
) -> None:  # fmt: skip
    """Draw the faces of a line at some seconds of its schedule, with one camera for a model.

    `close` shows the mouth alone. `captions` are two lines below each face, instead of its sound,
    word and time. Raises OutputError if a time is outside the animation, Pillow is missing, or
    there is nothing to draw, and ModelError if the model cannot be drawn.
    """
    pillow()
    first, last = float(animation.times[0]), float(animation.times[-1])
    for one in seconds:
        if not first <= one <= last:
            runs = f"which runs from {first:.3f} to {last:.3f} s"
            raise OutputError(f"{one:g} s is outside the animation, {runs}")
    scene, swept = staged(animation), staged(sweep(animation))
    camera = close_up(swept) if close else None
    stills = [_still(animation.schedule, one) for one in seconds]
    columns = COLUMNS
    if captions:
        columns = CAPTIONED_COLUMNS
        stills = [(one, *caption) for one, caption in zip(seconds, captions, strict=True)]
    artist = Artist(scene, CELL, camera, swept)
    draw_stills(stills, lambda seconds: artist.draw(seconds + scene.sound), out, columns)


def stacked(sheets: Mapping[str, bytes], out: BinaryIO) -> None:
    """Write PNG sheets of the same stills, row by row below each other, each under its name."""
    image = pillow()
    from PIL import ImageDraw

    opened = [image.open(BytesIO(sheet)) for sheet in sheets.values()]
    high, (width, height) = CELL + FOOT, opened[0].size
    tops = range(EDGE, height - EDGE, high)
    size = width, len(tops) * len(opened) * (high + FOOT)
    page, below, fonts = image.new("RGB", size, PAPER), 0, _fonts_of(sheets)
    for top in tops:
        for name, one in zip(sheets, opened, strict=True):
            _write(ImageDraw.Draw(page), (EDGE, below + EDGE), _plain(name, 60), TITLE, fonts)
            page.paste(one.crop((0, top, width, top + high)), (0, below + FOOT))
            below += high + FOOT
    page.save(out, "PNG", optimize=True)


def _still(schedule: Schedule, seconds: float) -> Still:
    number = int(np.searchsorted(schedule.times, seconds, side="right")) - 1
    if not 0 <= number < len(schedule):
        return seconds, SILENCE, f"{seconds:.2f} s"
    word = schedule.word_at(number)
    said = f"{_plain(word.text, 24)} · " if word else ""
    return seconds, schedule.labels[number], f"{said}{seconds:.2f} s"


def draw_stills(stills: Sequence[Still], draw_at: Draw, out: BinaryIO, columns: int) -> None:
    """Write a sheet of stills, of which `draw_at` draws that of a second, (CELL, CELL, 3)."""
    image = pillow()
    from PIL import ImageDraw

    rows = -(-len(stills) // columns)
    columns = -(-len(stills) // rows)
    fonts = _fonts_of(text for _, *caption in stills for text in caption)
    size = (2 * EDGE - GAP + columns * (CELL + GAP), 2 * EDGE + rows * (CELL + FOOT))
    page = image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(page)
    for place, (seconds, name, told) in enumerate(stills):
        row, column = divmod(place, columns)
        left, top = EDGE + column * (CELL + GAP), EDGE + row * (CELL + FOOT)
        page.paste(image.fromarray(draw_at(seconds)), (left, top))
        _write(draw, (left, top + CELL + 4), _plain(name, 12), NAME, fonts)
        _write(draw, (left, top + CELL + 29), _plain(told, 36), SMALL, fonts)
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
        # Equal faces have the distance 0, and must not be chosen twice.
        apart[chosen] = -1.0
    return sounds[np.sort(chosen)]


def _plain(text: str, width: int) -> str:
    return shorten(text, width, placeholder="…") or text[:width].strip()


def _fonts_of(texts: Iterable[str]) -> FoundFonts:
    """Find fonts for the letters that the default font lacks, and name those without any once."""
    letters = letters_of(texts)
    found = find_fonts(letters - coverage(_usual(), letters), coverage)
    warn_of(found.missing)
    return found


def _write(
    draw: Any, place: tuple[int, int], text: str, look: tuple[int, str], fonts: FoundFonts
) -> None:
    """Draw a text in fonts that contain its letters."""
    (left, top), (size, ink) = place, look
    baseline, x = top + _font(_usual(), size).getmetrics()[0], float(left)
    for part, file in _parts(text, fonts):
        font = _font(file, size)
        draw.text((x, baseline), part, fill=ink, font=font, anchor="ls")
        x += font.getlength(part)


def _parts(text: str, fonts: FoundFonts) -> list[tuple[str, str]]:
    """Split a text by the font files that contain its letters."""
    usual, letters = _usual(), letters_of([text])
    lacking = letters - coverage(usual, letters)
    others = {str(path): coverage(path, lacking) for path in fonts.paths}
    parts: list[tuple[str, str]] = []
    for letter in split_letters(legible(text, fonts.missing), hidden=True):
        file = next((name for name, known in others.items() if letter in known), usual)
        if parts and (parts[-1][1] == file or not letters_of([letter])):
            parts[-1] = (parts[-1][0] + letter, parts[-1][1])
        else:
            parts.append((letter, file))
    return parts


def coverage(file: Path | str, letters: frozenset[str]) -> frozenset[str]:
    """Return the letters that a font file contains; none if Pillow cannot use it.

    A letter is there if its shape differs from that of a missing character.
    """
    characters = {character for letter in letters for character in letter}
    try:
        font = _font(str(file), TRIED, simple=True)
        # Pillow draws a box for a missing letter and raises nothing.
        absent = bytes(font.getmask(MISSING_CHARACTER))
        there = {one for one in characters if bytes(font.getmask(one)) != absent}
    except (OSError, ValueError):
        return frozenset()
    return frozenset(letter for letter in letters if there.issuperset(letter))


@cache
def _usual() -> str:
    """Return the file of the default font; empty for the font of Pillow."""
    for name in FONTS:
        with suppress(OSError):
            _font(name, TRIED)
            return name
    return ""


@cache
def _font(file: str, size: int, *, simple: bool = False) -> Any:
    """Open a font file; `simple` turns off the shaping of letters by their neighbours."""
    from PIL import ImageFont

    if not file:
        return ImageFont.load_default(size)
    layout = ImageFont.Layout.BASIC if simple else None
    return ImageFont.truetype(file, size, layout_engine=layout)
