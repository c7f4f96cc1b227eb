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
    from matplotlib.text import Text


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
    figure = page()
    found = fonts_for(letters_of(_strings(figure)))
    if found.paths:
        _take(found.paths)
        figure = page()
    if found.missing:
        for text in _texts(figure):
            text.set_text(legible(text.get_text(), found.missing))
        warn_of(found.missing)
    return figure


def fonts_for(letters: frozenset[str]) -> FoundFonts:
    """Return fonts for the letters that matplotlib's usual font lacks."""
    from matplotlib import font_manager

    usual = Path(font_manager.findfont(font_manager.FontProperties()))
    lacking = letters - coverage(usual, letters)
    return find_fonts(lacking, coverage) if lacking else FoundFonts((), frozenset())


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


def _take(paths: tuple[Path, ...]) -> None:
    """Append font files to the fonts of matplotlib's settings."""
    from matplotlib import rcParams

    rcParams["font.family"] = [*rcParams["font.family"], *map(_family, paths)]


@cache
def _family(path: Path) -> str:
    """Register a font file with matplotlib, and return its family."""
    from matplotlib import font_manager

    manager = font_manager.fontManager
    if all(one.fname != str(path) for one in manager.ttflist):
        manager.addfont(str(path))
    return str(font_manager.get_font(str(path)).family_name)


def _texts(figure: "Figure") -> "list[Text]":
    from matplotlib.text import Text

    return [text for text in figure.findobj(Text) if isinstance(text, Text)]


def _strings(figure: "Figure") -> Iterator[str]:
    """Yield the texts of a figure, with those of ticks, which matplotlib sets on request."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            yield from (label.get_text() for label in axis.get_ticklabels(which="both"))
    yield from (text.get_text() for text in _texts(figure))
