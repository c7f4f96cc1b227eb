"""The page of drawn mouths in the how-to, in a browser: it shows the drawing of each moment."""

import numpy as np
from lanes import full
from places import ROOT
from test_consumers import HERE, chromium, found, run

import lipsync_lang as ll
from lipsync_lang.animations.held import held

pytestmark = full

SOUNDS = ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F", "UW1", "M")


def test_the_page_shows_the_drawing_of_each_moment(tmp_path):
    node, modules = found("playwright-core")
    schedule = ll.Schedule(SOUNDS, np.arange(11) / 10, notation="arpabet")
    animation = ll.resolve("english", "rhubarb").perform(schedule)
    animation.save(tmp_path / "hello.rhubarb.json")
    page = (ROOT / "docs/how-to/draw-a-2d-mouth.md").read_text("utf-8")
    content = page.partition("```html\n")[2].partition("```")[0]
    (tmp_path / "page.html").write_text(content, "utf-8")
    shapes = held(animation, "rest")
    moments = [(shape.start + shape.end) / 2 for shape in shapes]
    shown = run(node, HERE / "sprite.mjs", modules, chromium(), tmp_path, *map(str, moments))
    drawings = "ABCDEFGHX"
    assert shown == [f"{-200 * drawings.index(shape.name)}px" for shape in shapes]
    assert len({*shown}) > 3
