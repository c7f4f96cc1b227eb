"""Fonts for the text of pictures: installed fonts with its letters, or fonts to install.

No library lists fonts for all pictures: matplotlib draws plots, and Pillow draws sheets. So the
folders of the system are searched here, and the drawing library tests the letters of a file.

matplotlib draws a letter in the first font of a list that contains it. The list is the default
font, followed by fonts for its missing letters. Fonts are searched only if letters are missing.
"""

import logging
import os
import re
import sys
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FONT_FOLDERS = {
    "linux": ("/usr/share/fonts", "/usr/local/share/fonts", "~/.local/share/fonts", "~/.fonts"),
    "darwin": ("/System/Library/Fonts", "/Library/Fonts", "~/Library/Fonts"),
    "win32": ("%WINDIR%/Fonts", "%LOCALAPPDATA%/Microsoft/Windows/Fonts"),
}
"""Folders of fonts by platform; other systems use those of Linux."""

FONT_SUFFIXES = (".ttf", ".otf", ".ttc", ".otc")
MAX_FONTS = 5000

SHOWN_LETTERS = 12
"""Maximum number of missing letters in a remark."""

ELLIPSIS = "…"
"""Replaces letters that no font has."""

NO_LETTERS = re.compile(r"last ?resort|blank|emoji|color|symbol|music", re.IGNORECASE)
"""Words in names of fonts that show boxes or symbols instead of letters."""

UNUSUAL_STYLES = re.compile(
    r"bold|italic|oblique|black|thin|light|medium|condensed|narrow|mono|serif|slant|kufi|nastaliq"
    r"|looped|display|supplement|[a-z]UI\b",
    re.IGNORECASE,
)
"""Words in names of fonts that differ visibly from an upright sans serif."""

PLAIN_SCRIPTS = {"LATIN", "GREEK", "CYRILLIC", "COMBINING", "MODIFIER", "SUPERSCRIPT", "SUBSCRIPT"}
"""First words of Unicode names of letters that a font of several scripts contains."""

HIDDEN = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp", "Zs"}
"""Unicode categories of characters without a glyph."""

EAST_ASIAN_SCRIPTS = {
    "CJK", "HIRAGANA", "KATAKANA", "KATAKANA-HIRAGANA", "HANGUL", "BOPOMOFO", "IDEOGRAPHIC",
    "FULLWIDTH", "HALFWIDTH",
}  # fmt: skip

FontCoverage = Callable[[Path, frozenset[str]], frozenset[str]]
"""Return the subset of letters that a font file contains."""

_log = logging.getLogger(__name__)
_remarked: set[str] = set()


class FoundFonts(NamedTuple):
    """Fonts that together contain the letters of a text."""

    paths: tuple[Path, ...]
    missing: frozenset[str]
    """Letters that no font contains."""


@cache
def find_fonts(letters: frozenset[str], coverage: FontCoverage) -> FoundFonts:
    """Find a few installed fonts that contain some letters, plain fonts first.

    `letters` are characters, alone or with their marks, as `letters_of` gives them; `coverage` is a
    function of the drawing library that finds the letters of a font file.
    """
    wanted = {path: coverage(path, letters) for path in font_files()} if letters else {}
    chosen: list[Path] = []
    missing = set(letters)
    while missing and wanted:
        # Greedy: the smallest set of fonts is not worth a search; the order of files breaks ties.
        best = max(wanted, key=lambda path: len(wanted[path] & missing))
        if not wanted[best] & missing:
            break
        chosen.append(best)
        missing -= wanted[best]
    return FoundFonts(tuple(chosen), frozenset(missing))


@cache
def font_files() -> tuple[Path, ...]:
    """List the installed font files, plain upright ones first."""
    stated = FONT_FOLDERS.get(sys.platform, FONT_FOLDERS["linux"])
    folders = [Path(os.path.expandvars(one)).expanduser() for one in stated]
    files = (
        Path(here, name)
        for folder in folders
        for here, _, names in os.walk(folder)
        for name in names
        if name.lower().endswith(FONT_SUFFIXES) and not NO_LETTERS.search(name)
    )

    def rank(path: Path) -> tuple[int, bool, int, str]:
        """Few unusual styles in the name come first, then a sans serif, then a short name."""
        name = path.stem
        unusual = len(UNUSUAL_STYLES.findall(name))
        return unusual, "sans" not in name.lower(), len(name), str(path)

    return tuple(sorted(set(islice(files, MAX_FONTS)), key=rank))


def letters_of(texts: Iterable[str]) -> frozenset[str]:
    """Return the letters of texts: characters alone, and characters with the marks on them.

    A mark needs a font that also has its character, because both are drawn together.
    """
    found = {letter for text in texts for letter in split_letters(text)}
    return frozenset(found | {letter[0] for letter in found})


def split_letters(text: str, *, hidden: bool = False) -> Iterator[str]:
    """Yield each character with its marks, and characters without a glyph if `hidden`."""
    letter = ""
    for character in text:
        category = unicodedata.category(character)
        if letter and category.startswith("M"):
            letter += character
            continue
        if letter:
            yield letter
        letter = character if hidden or category not in HIDDEN else ""
    if letter:
        yield letter


def warn_of(missing: Collection[str]) -> None:
    """Log once the letters that no font contains, unless only their marks are left out."""
    if any(letter[0] in missing for letter in missing):
        remark = font_remark(missing)
        if remark not in _remarked:
            _remarked.add(remark)
            _log.warning(remark)


def legible(text: str, missing: Collection[str]) -> str:
    """Replace letters that no font contains with the character without marks, or an ellipsis."""
    # Letters with marks first, or their bare characters would be replaced within them.
    for letter in sorted(split_letters(text), key=len, reverse=True):
        if letter in missing:
            text = text.replace(letter, ELLIPSIS if letter[0] in missing else letter[0])
    return re.sub(f"{ELLIPSIS}+", ELLIPSIS, text)


def font_remark(missing: Collection[str]) -> str:
    """Name the letters that no installed font contains, and the font to install."""
    letters = sorted(letter for letter in missing if letter[0] in missing)
    shown = " ".join(letters[:SHOWN_LETTERS]) + (" ..." if len(letters) > SHOWN_LETTERS else "")
    what = f"the letters {shown}" if len(letters) > 1 else f"the letter {shown}"
    advice = "; ".join(f"install {name}: {how}" for name, how in fonts_to_install(letters).items())
    return f'no installed font has {what}: the picture shows "{ELLIPSIS}" instead; {advice}'


def fonts_to_install(letters: Iterable[str]) -> dict[str, str]:
    """Return names of fonts with some letters, each with its installation on this platform."""
    names = []
    for letter in sorted(letters):
        script = unicodedata.name(letter[0], "").partition(" ")[0]
        own = "CJK" if script in EAST_ASIAN_SCRIPTS else script.title()
        names.append("Noto Sans" if script in PLAIN_SCRIPTS else f"Noto Sans {own}".strip())
    if sys.platform == "darwin":
        casks = {n: n.lower().replace(" ", "-").replace("cjk", "cjk-jp") for n in names}
        return {name: f"brew install --cask font-{cask}" for name, cask in casks.items()}
    if sys.platform == "win32":
        how = "download it from https://fonts.google.com/noto and open the file to install it"
        return dict.fromkeys(names, how)
    packages = {n: "fonts-noto-cjk" if n.endswith("CJK") else "fonts-noto-core" for n in names}
    return {
        name: f"sudo apt install {package} (Debian, Ubuntu), or the Noto package of your system"
        for name, package in packages.items()
    }


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
        # matplotlib reads the list when a text is made, so the page is made again.
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
