"""No dark pixel shows in the shipped head on the page where the picture of the frame is light."""

import json
from pathlib import Path

import numpy as np
import pytest
from lanes import full
from PIL import Image
from test_consumers import chromium, found, run

import lipsync_lang as ll
from lipsync_lang.render.model.camera import close_up
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged, sweep

pytestmark = full

HERE = Path(__file__).parent

FRAMES = 12
"""Frames of each line."""

STEP = 40
"""A pinhole is darker by this, of 255, than nine pixels of the picture that differ by less."""

LINES = [
    ("P", "AY1", "B", "UW1", "F", "M", "P"),
    ("SH", "IY1", "TH", "IH1", "N", "L", "OW1"),
    ("W", "IY1", "M", "OW1", "D", "AA1", "CH"),
]


def dark_pixels(page, picture):
    """Mask the pixels of a page (H, W, 4) that are dark where the picture (H, W, 3) is smooth."""
    height, width = page.shape[:2]
    bright = np.pad(picture.max(axis=2).astype(int), 1, mode="edge")
    around = [bright[y : y + height, x : x + width] for y in range(3) for x in range(3)]
    darkest, smooth = np.min(around, axis=0), np.ptp(around, axis=0) < STEP
    solid = page[..., 3] == 255
    return solid & smooth & (page[..., :3].max(axis=2) < darkest - STEP)


def compared(animation, folder, frames):
    """Yield frames of the page of an animation, close to the mouth, each with the picture of it."""
    node, modules = found("playwright-core")
    path = folder / "line.html"
    animation.save(path)
    drawn = run(
        node, HERE / "pinholes.mjs", modules, chromium(), path, json.dumps(frames), str(folder)
    )
    assert drawn == {"said": [], "frames": frames}
    scene, swept = staged(animation), staged(sweep(animation))
    pages = [np.asarray(Image.open(folder / f"{frame}.png")) for frame in frames]
    artist = Artist(scene, len(pages[0]), close_up(swept), swept)
    for frame, page in zip(frames, pages, strict=True):
        yield page, artist.draw(frame / animation.fps)


@pytest.mark.parametrize("labels", LINES)
def test_no_pinhole_shows_in_the_shipped_head(tmp_path, labels):
    line = ll.Schedule(labels, [0.1 * n for n in range(len(labels) + 1)], notation="arpabet")
    animation = ll.resolve("english", "facefx").perform(line)
    frames = [*map(int, np.linspace(0, len(animation.times) - 1, FRAMES))]
    pairs = [*compared(animation, tmp_path, frames)]
    assert sum(dark_pixels(*pair).sum() for pair in pairs) == 0
    # one dark pixel of skin would be found
    page, picture = pairs[0]
    page = page.copy()
    page[len(page) // 5, len(page) // 2, :3] //= 2
    assert dark_pixels(page, picture).sum() == 1
