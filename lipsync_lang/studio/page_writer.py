"""Output format `html`: the page of a line."""

from collections.abc import Iterator
from contextlib import suppress
from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.animations.writers.glb import unplaced
from lipsync_lang.base.errors import ModelError


def doubts(animation: Animation) -> Iterator[str]:
    """Yield warnings about the model of a page."""
    from lipsync_lang.studio.face_data import page_scene

    scene = None if animation.model is None else page_scene(animation)
    if isinstance(scene, str):
        yield f"the page draws a simple mouth instead of the model: {scene}"
    with suppress(ModelError):  # the reason is told
        yield from unplaced(animation)


@writer("html", suffix=".html", remarks=doubts, reasons=True, shows=True)
def write_html(animation: Animation, out: TextIO) -> None:
    """A page to hear and see the line in a browser, with every curve and its explanation."""
    from lipsync_lang.studio.line_page import line_page

    out.write(line_page(animation))
