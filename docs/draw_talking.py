"""Draw the moving picture at the top of the README: a recording, its words and a face that says it.

    python docs/draw_talking.py [FOLDER]

The recording is a sentence of LibriSpeech (CC BY 4.0) in the folder that LIPSYNC_LANG_TEST_DATA
names. Its text is aligned as `lipsync-lang run --audio` does it. Needs the extras `audio`, `speech`
and `video`. The picture, and a film with the sound, go into docs/images, or into another folder.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import lipsync_lang as ll
from lipsync_lang.render.model.camera import framed
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.schedules.schedule import SILENCE

if TYPE_CHECKING:
    from collections.abc import Iterator

RECORDING = "recordings/mfa_tests/61-70968-0000"
LANGUAGE, CHARACTER = "english", "facefx"
UNTIL = "wizard"
"""Last word in the picture; a pause follows."""

COMMAND = (
    '$ lipsync-lang run "He began a confused ..." '
    "-l english -c facefx --audio line.flac -o line.mp4"
)

WIDTH, FACE, BAR, SOUND, EDGE = 720, 320, 34, 120, 14
"""Pixels: width of the picture, side of the face, height of the command and sound, margin."""

HEIGHT = BAR + FACE + SOUND
FINE = 3
"""Samples per pixel and direction of the still part."""

FPS, QUALITY = 20, 60
TAIL_SECONDS = 0.15

PAPER, NIGHT, INK, PALE, LINE = "#ffffff", "#20242c", "#222222", "#8a8f98", "#d9dce1"
WAVE, CURVE, NOW = "#7d8794", "#4f86c6", "#d1495b"


class Page:
    """The still part of the picture, and the scale of its time axis."""

    def __init__(self, animation: ll.Animation) -> None:
        """Draw the command, the sound with its words and phonemes, and the curves."""
        self.animation = animation
        schedule = animation.schedule
        last = next(word.stop for word in schedule.words if word.text == UNTIL)
        self.begin, self.end = float(animation.times[0]), float(schedule.times[last]) + TAIL_SECONDS
        self.words = [word for word in schedule.words if word.stop <= last]
        self.phonemes = last
        self.page = Image.new("RGB", (WIDTH * FINE, HEIGHT * FINE), PAPER)
        self._draw = ImageDraw.Draw(self.page)
        self._box(0, 0, WIDTH, BAR, NIGHT)
        self._text(EDGE, BAR / 2, COMMAND, 12, "#e6e9ee", "lm", "SansMono")
        self._curves()
        self._sound()
        self.page = self.page.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)

    def across(self, seconds: float, left: float, right: float) -> float:
        """Return the column of a time, between two columns."""
        return left + (seconds - self.begin) / (self.end - self.begin) * (right - left)

    def _curves(self) -> None:
        left, right = FACE + 84, WIDTH - EDGE
        columns = zip(self.animation.columns, self.animation, strict=True)
        poses = [p for c, (p, curve) in columns if curve.max() > 0.05 and not c.gesture]  # noqa: PLR2004
        row = (FACE - 2 * EDGE) / len(poses)
        for number, pose in enumerate(poses):
            foot = BAR + EDGE + (number + 1) * row
            shown = self.animation.times <= self.end
            xs = [self.across(time, left, right) for time in self.animation.times[shown]]
            ys = foot - 0.78 * row * self.animation[pose][shown]
            outline = [(left, foot), *zip(xs, ys, strict=True), (right, foot)]
            self._draw.polygon([(x * FINE, y * FINE) for x, y in outline], fill=CURVE)
            self._box(left, foot - 0.5, right, foot + 0.3, LINE)
            self._text(left - 8, foot - row * 0.3, pose, 12, INK, "rm")

    def _sound(self) -> None:
        schedule, top = self.animation.schedule, BAR + FACE
        audio, left, right = schedule.audio, EDGE, WIDTH - EDGE
        assert audio is not None  # noqa: S101 it was recorded
        middle, loud = top + 30, np.abs(audio.samples).max()
        for column in range(left * FINE, right * FINE):
            ends = [self.begin + (at / FINE - left) / (right - left) * (self.end - self.begin)
                    for at in (column, column + 1)]  # fmt: skip
            first, stop = (max(0, round(one * audio.rate)) for one in ends)
            part = audio.samples[first:stop] / loud * 26
            if len(part):
                low, high = middle - part.max(), middle - part.min()
                self._draw.line([(column, low * FINE), (column, high * FINE)], WAVE)
        times = schedule.times
        for number, label in enumerate(schedule.labels[: self.phonemes]):
            if label != SILENCE:
                centre = self.across(float(times[number] + times[number + 1]) / 2, left, right)
                self._text(centre, top + 72 + 11 * (number % 2), label, 10, PALE, "mm")
        for word in self.words:
            start, stop = (
                self.across(float(times[n]), left, right) for n in (word.first, word.stop)
            )
            self._box(start, top + 64, start + 1, top + 112, LINE)
            self._text((start + stop) / 2, top + 104, word.text, 13.5, INK, "mm")

    def _box(self, left: float, top: float, right: float, bottom: float, colour: str) -> None:
        corners = [round(one * FINE) for one in (left, top, right, bottom)]
        self._draw.rectangle(corners, fill=colour)

    def _text(  # noqa: PLR0913, PLR0917
        self, x: float, y: float, text: str, size: float, ink: str, anchor: str, kind: str = "Sans"
    ) -> None:
        name = f"DejaVu{kind}.ttf"
        font = ImageFont.truetype(name, size * FINE)
        self._draw.text((x * FINE, y * FINE), text, ink, font=font, anchor=anchor)

    def frames(self) -> Iterator[Image.Image]:
        """Draw the face at each time, and a line at that time through curves and sound."""
        scene, swept = staged(self.animation), staged(sweep(self.animation))
        artist = Artist(scene, FACE, framed(swept), swept)
        for seconds in np.arange(self.begin, self.end, 1 / FPS):
            frame = self.page.copy()
            frame.paste(Image.fromarray(artist.draw(seconds - self.begin)), (0, BAR))
            draw = ImageDraw.Draw(frame)
            across = self.across(seconds, FACE + 84, WIDTH - EDGE)
            draw.line([(across, BAR + 6), (across, BAR + FACE - 6)], NOW, 2)
            across = self.across(seconds, EDGE, WIDTH - EDGE)
            draw.line([(across, BAR + FACE + 2), (across, HEIGHT - 4)], NOW, 2)
            yield frame


def performed() -> ll.Animation:
    """Align the recording with its text and perform it."""
    path = Path(os.environ["LIPSYNC_LANG_TEST_DATA"], RECORDING)
    text = path.with_suffix(".lab").read_text("utf-8").strip().lower()
    schedule = ll.align(path.with_suffix(".flac"), text, LANGUAGE)
    return ll.resolve(LANGUAGE, CHARACTER).perform(schedule, fps=60, gestures="all")


def moving(frames: list[Image.Image], path: Path, fps: float = FPS, quality: int = QUALITY) -> None:
    """Write frames as an animated WebP."""
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=round(1000 / fps), loop=0,
        quality=quality, method=6,
    )  # fmt: skip


def main() -> None:
    """Draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent / "images")
    folder = parser.parse_args().folder
    from draw_gallery import film  # beside this script

    page = Page(performed())
    frames = [*page.frames()]
    moving(frames, folder / "talking.webp")
    film(frames, page.begin, page.animation.schedule, folder / "talking.mp4", FPS)


if __name__ == "__main__":
    main()
