"""Fonts of matplotlib's figures: installed fonts that contain each letter.

matplotlib draws a letter in the first font of a list that contains it. The list is the default
font, followed by fonts for its missing letters. Fonts are searched only if letters are missing.
"""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.render.fonts import FoundFonts, find_fonts, legible, letters_of, warn_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@contextmanager
def quiet_fonts() -> Iterator[None]:
    """Silence matplotlib's log of fonts without a bold face within the block."""
    log = logging.getLogger("matplotlib.font_manager")
    before = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(before)


def with_fonts(page: "Callable[[], Figure]") -> "Figure":
    """Make a figure with fonts for all its letters.

    The figure is made again if the default font lacks letters, since labels are placed by the width
    of their text. The caller restores matplotlib's settings. Letters that no font has become "…",
    and the log has one warning with the font to install.
    """
    from matplotlib import rcParams
    from matplotlib.text import Text

    figure = page()
    texts = [text.get_text() for text in figure.findobj(Text)]
    for axes in figure.axes:  # matplotlib sets the texts of ticks only on request
        for axis in (axes.xaxis, axes.yaxis):
            texts += [label.get_text() for label in axis.get_ticklabels(which="both")]
    found = fonts_for(letters_of(texts))
    if found.paths:
        rcParams["font.family"] = [*rcParams["font.family"], *map(_family, found.paths)]
        figure = page()
    if found.missing:
        for text in figure.findobj(Text):
            text.set_text(legible(text.get_text(), found.missing))
        warn_of(found.missing)
    return figure


def fonts_for(letters: frozenset[str]) -> FoundFonts:
    """Return fonts for the letters that matplotlib's usual font lacks."""
    from matplotlib import font_manager

    usual = Path(font_manager.findfont(font_manager.FontProperties()))
    lacking = letters - coverage(usual, letters)
    return find_fonts(lacking, coverage)


def coverage(path: Path, letters: frozenset[str]) -> frozenset[str]:
    """Return the letters that a font file contains; none if matplotlib cannot use it."""
    from matplotlib.ft2font import FT2Font

    try:
        font = FT2Font(str(path))
    except (OSError, RuntimeError, ValueError):
        return frozenset()
    if not font.scalable:
        return frozenset()
    return frozenset(one for one in letters if all(font.get_char_index(ord(c)) for c in one))


@cache
def _family(path: Path) -> str:
    """Register a font file with matplotlib, and return its family."""
    from matplotlib import font_manager

    manager = font_manager.fontManager
    if all(one.fname != str(path) for one in manager.ttflist):
        manager.addfont(str(path))
    return str(font_manager.get_font(str(path)).family_name)
