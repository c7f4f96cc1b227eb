"""Draw the face of every English phoneme from the front and from the side, on one sheet.

    python docs/draw_phonemes.py [CHARACTER] [-o PICTURE]

Each phoneme of CMUdict is said by itself and drawn in its middle, a diphthong at both ends. The
character is a pose set or a model, such as a head of `lipsync-lang heads`; without one, it is that
of docs/images/phonemes-facefx.png. Needs the extra `video`.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import lipsync_lang as ll
from lipsync_lang.render.model.camera import close_up
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.schedules.schedule import SILENCE

CHARACTER = "facefx"

CONSONANTS = "pau P B M F V TH DH T D N L S Z SH ZH CH JH K G NG R Y HH W"
VOWELS = "UW UH OW AO AA AW AY OY AH AE EH EY ER IH IY"

DIPHTHONGS = {"OW", "AW", "AY", "OY", "EY"}

SECONDS = 0.3
"""Length of a phoneme, and of the silences beside it."""

SIDE_DEGREES = 65

ROOM = 1.25
"""Size of a picture over that of a close-up, so that lips that are pushed out stay in it."""

CELL, FOOT, COLUMNS, COLOURS = 112, 18, 9, 256
"""Pixels: side of a picture, height of a caption; pictures in a row; colours of the sheet."""

PAPER, INK = "#ffffff", "#222222"


def moments() -> list[tuple[str, str, float]]:
    """List captions, phonemes, and the shares of their time at which they are drawn."""
    found = []
    for phoneme in f"{CONSONANTS} {VOWELS}".split():
        if phoneme in DIPHTHONGS:
            found += [(f"{phoneme} -", phoneme, 0.25), (f"{phoneme} +", phoneme, 0.8)]
        else:
            found.append((phoneme, phoneme, 0.5))
    return found


def sheet(character: str) -> Image.Image:
    """Draw the sheet of a character."""
    performer = ll.resolve("english", character)
    cells = moments()
    rows = -(-len(cells) // COLUMNS)
    tall = 2 * CELL + FOOT
    page = Image.new("RGB", (COLUMNS * CELL, rows * tall), PAPER)
    draw, font = ImageDraw.Draw(page), ImageFont.truetype("DejaVuSans.ttf", 12)
    for number, (text, phoneme, share) in enumerate(cells):
        times = [SECONDS * n for n in range(4)]
        line = ll.Schedule((SILENCE, phoneme, SILENCE), times, notation="arpabet")
        animation = performer.rigged(performer.perform(line))
        scene, swept = staged(animation), staged(sweep(animation))
        front = close_up(swept)
        front = replace(front, distance=ROOM * front.distance)
        turn = np.radians(SIDE_DEGREES)
        yaw = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
        left, top = number % COLUMNS * CELL, number // COLUMNS * tall
        for row, camera in enumerate((front, replace(front, turn=front.turn @ np.array(yaw)))):
            at = SECONDS * (1 + share) - float(animation.times[0])
            picture = Artist(scene, CELL, camera, swept).draw(at)
            page.paste(Image.fromarray(picture), (left, top + row * CELL))
        draw.text((left + CELL / 2, top + 2 * CELL + 2), text, INK, font=font, anchor="ma")
    return page


def main() -> None:
    """Draw the sheet."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("character", nargs="?", default=CHARACTER)
    own = Path(__file__).parent / "images" / f"phonemes-{CHARACTER}.png"
    parser.add_argument("-o", "--out", type=Path, default=own)
    options = parser.parse_args()
    page = sheet(options.character)
    page.quantize(COLOURS).save(options.out, optimize=True)


if __name__ == "__main__":
    main()
