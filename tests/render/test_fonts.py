"""Fonts of pictures: an installed font draws every letter, or a remark names one to install."""

import importlib.util
import logging
import re
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from lanes import swept
from shipped import LANGUAGES, LIBRARY

pytest.importorskip("matplotlib", reason="pictures need matplotlib")

from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from matplotlib import font_manager
from matplotlib.figure import Figure
from matplotlib.text import Text

from lipsync_lang.render import fonts, sheet
from lipsync_lang.render.fonts import (
    ELLIPSIS,
    find_fonts,
    font_files,
    font_remark,
    fonts_for,
    fonts_to_install,
    legible,
    letters_of,
    split_letters,
    with_fonts,
)

pillow = pytest.mark.skipif(importlib.util.find_spec("PIL") is None, reason="needs Pillow")

KHMER = "កខគ"
"""Letters of a script that are missing from the default fonts of matplotlib and Pillow."""


def forget():
    for kept in (find_fonts, font_files, fonts._remarked):  # noqa: SLF001
        (kept.clear if isinstance(kept, set) else kept.cache_clear)()


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The only folder with fonts."""
    monkeypatch.setattr(fonts, "FONT_FOLDERS", {"linux": (str(tmp_path),)})
    monkeypatch.setattr(fonts.sys, "platform", "linux")
    before = list(font_manager.fontManager.ttflist)
    forget()
    yield tmp_path
    font_manager.fontManager.ttflist = before
    forget()


def make_font(path, family, letters):
    """Write a font with squares as letters, and an empty frame for missing ones."""
    pens = {}
    for name, corners in {"letter": (50, 550), ".notdef": (200, 300)}.items():
        pen, (low, high) = TTGlyphPen(None), corners
        pen.moveTo((low, low))
        for point in ((low, high), (high, high), (high, low)):
            pen.lineTo(point)
        pen.closePath()
        pens[name] = pen.glyph()
    order = [".notdef", *(f"l{number}" for number in range(len(letters)))]
    made = FontBuilder(1000, isTTF=True)
    made.setupGlyphOrder(order)
    made.setupCharacterMap({ord(c): f"l{number}" for number, c in enumerate(letters)})
    made.setupGlyf({name: pens.get(name, pens["letter"]) for name in order})
    made.setupHorizontalMetrics(dict.fromkeys(order, (600, 50)))
    made.setupHorizontalHeader(ascent=800, descent=-200)
    made.setupNameTable({"familyName": family, "styleName": "Regular"})
    made.setupOS2()
    made.setupPost()
    path.parent.mkdir(parents=True, exist_ok=True)
    made.save(path)
    return path


def page(text):
    def make():
        figure = Figure(figsize=(3, 1))
        figure.text(0.1, 0.5, text, size=12, weight="bold")
        return figure

    return make


def strings(figure):
    return [text.get_text() for text in figure.findobj(Text)]


def drawn(text):
    """Draw a text; a letter without a glyph would cause a warning, which is an error here."""
    with fonts.quiet_fonts(), plot_fonts_context():
        figure = with_fonts(page(text))
        figure.savefig(BytesIO(), format="png")
    return strings(figure)


def plot_fonts_context():
    import matplotlib as mpl

    return mpl.rc_context()


# Letters


@pytest.mark.parametrize(
    ("text", "letters"),
    [
        ("a b", ["a", "b"]),
        ("ク\u0325a", ["ク\u0325", "a"]),
        ("\u0325a", ["\u0325", "a"]),
        ("क्ष", ["क्", "ष"]),
        ("می\u200cرود", list("میرود")),
        ("\ue000\x07", []),
    ],
)
def test_a_mark_belongs_to_its_character(text, letters):
    assert list(split_letters(text)) == letters
    assert letters_of([text]) == {*letters, *(letter[0] for letter in letters)}
    assert "".join(split_letters(text, hidden=True)) == text


def test_letters_that_no_font_has_become_an_ellipsis():
    assert legible(f"a {KHMER} b", set(KHMER)) == f"a {ELLIPSIS} b"
    assert legible("ク\u0325", {"ク\u0325"}) == "ク"
    assert legible("plain", {"क"}) == "plain"


def test_a_remark_names_a_few_letters():
    told = font_remark([chr(0x1780 + number) for number in range(30)])
    (shown,) = re.findall("the letters (.+):", told.partition(" the picture")[0])
    assert shown.split() == [*(chr(0x1780 + number) for number in range(12)), "..."]


# Which fonts


def test_folders_of_fonts_may_be_those_of_a_user(tmp_path, monkeypatch):
    monkeypatch.setattr(fonts, "FONT_FOLDERS", {"linux": ("~/one", "$FONTS/two")})
    monkeypatch.setattr(fonts.sys, "platform", "an unknown system")
    for name in ("HOME", "USERPROFILE", "FONTS"):
        monkeypatch.setenv(name, str(tmp_path))
    wanted = {tmp_path / "one/A.ttf", tmp_path / "two/b.OTF"}
    for path in (*wanted, tmp_path / "one/readme.txt"):
        path.parent.mkdir(exist_ok=True)
        path.touch()
    forget()
    assert set(font_files()) == wanted
    forget()


def test_without_a_font_the_letters_are_left_out_and_the_font_is_named(installed, caplog):
    assert list(installed.iterdir()) == []
    with caplog.at_level(logging.WARNING):
        assert drawn(f"ok {KHMER}") == [f"ok {ELLIPSIS}"]
        assert drawn(f"ok {KHMER}") == [f"ok {ELLIPSIS}"]
    (told,) = caplog.messages
    assert all(letter in told for letter in KHMER)
    assert "install Noto Sans Khmer: sudo apt install fonts-noto-core" in told


def test_an_installed_font_draws_what_the_usual_one_lacks(installed, caplog):
    make_font(installed / "khmer/NotoSansKhmer-Regular.ttf", "Squares", KHMER)
    assert drawn(f"ok {KHMER}") == [f"ok {KHMER}"]
    assert not caplog.messages
    with plot_fonts_context() as _:
        figure = with_fonts(page(KHMER))
        (text,) = figure.findobj(Text)
        assert text.get_fontfamily()[-1] == "Squares"


def test_the_usual_font_stays_alone_where_it_has_all_letters(installed):
    make_font(installed / "Other-Regular.ttf", "Other", "abc")
    assert fonts_for(letters_of(["abc ʃ̩ ə̃ ŋ"])).paths == ()


def test_several_fonts_share_the_letters_of_a_text(installed):
    one = make_font(installed / "One-Regular.ttf", "One", KHMER)
    other = make_font(installed / "Other-Regular.ttf", "Other", "กข")
    found = fonts_for(letters_of([KHMER + "กข"]))
    assert set(found.paths) == {one, other}
    assert not found.missing


def test_a_plain_sans_serif_comes_first(installed):
    plain = make_font(installed / "z/NotoSansX-Regular.ttf", "Plain", KHMER)
    for name in ("ASerif-Regular", "ASans-Bold", "ASansUI-Regular", "AMono", "ASans-Italic"):
        make_font(installed / f"{name}.ttf", name, KHMER)
    assert fonts_for(letters_of([KHMER])).paths == (plain,)


@pytest.mark.parametrize("name", ["LastResort.otf", "NotoColorEmoji.ttf", "AdobeBlank.ttf"])
def test_a_font_of_boxes_or_pictures_is_not_taken(installed, name):
    make_font(installed / name, "Boxes", KHMER)
    assert fonts_for(letters_of([KHMER])).paths == ()


@pillow
def test_a_file_that_is_no_font_is_passed_over(installed):
    (installed / "Broken-Regular.ttf").write_bytes(b"\0\1\0\0 no font")
    (installed / "Empty-Regular.otf").touch()
    good = make_font(installed / "longer-name-of-a-font.ttf", "Good", KHMER)
    assert fonts_for(letters_of([KHMER])).paths == (good,)
    assert find_fonts(letters_of([KHMER]), sheet.coverage).paths == (good,)


# Stills


@pillow
def test_captions_of_stills_are_drawn_in_parts(installed):
    good = make_font(installed / "NotoSansX-Regular.ttf", "Good", KHMER)
    usual = sheet._usual()  # noqa: SLF001
    fonts = sheet._fonts_of([f"ok {KHMER} 2"])  # noqa: SLF001
    parts = sheet._parts(f"ok {KHMER} 2", fonts)  # noqa: SLF001
    assert parts == [("ok ", usual), (f"{KHMER} ", str(good)), ("2", usual)]
    assert sheet._parts("plain", fonts) == [("plain", usual)]  # noqa: SLF001


@pillow
def test_captions_of_stills_have_no_boxes(installed, caplog):
    from PIL import Image

    assert list(installed.iterdir()) == []
    stills = [(0.1, "k", f"ok {KHMER}"), (0.2, "m", "plain"), (0.3, "n", "技")]
    black = np.zeros((sheet.CELL, sheet.CELL, 3), np.uint8)
    with caplog.at_level(logging.WARNING):
        sheet.draw_stills([*stills, *stills[:2]], lambda _: black, page := BytesIO(), 4)
        fonts = sheet._fonts_of([stills[0][2]])  # noqa: SLF001
    ((text, _),) = sheet._parts(stills[0][2], fonts)  # noqa: SLF001
    assert text == f"ok {ELLIPSIS}"
    (first, *_) = caplog.messages
    assert "install Noto Sans Khmer" in first
    assert "install Noto Sans CJK" in first, "one remark for all captions"
    assert 3 * sheet.CELL < Image.open(page).width < 4 * sheet.CELL, "rows of three and two"


# All languages


@pytest.mark.parametrize("empty", [False, True], ids=["installed", "no fonts"])
@pytest.mark.parametrize(
    "language", swept(LANGUAGES, quick=["arabic", "hindi", "japanese", "thai"])
)
def test_every_letter_of_every_language_is_drawn_or_named(language, empty, request, monkeypatch):
    if empty:
        request.getfixturevalue("installed")
    model = LIBRARY.language(language).model
    texts = [text for test in model.tests for text in (test.text, test.ipa)]
    texts += [label for table in model.notations.values() for label in table]
    letters = letters_of(texts)
    found = fonts_for(letters)
    usual = Path(font_manager.findfont(font_manager.FontProperties()))
    having = [fonts.coverage(path, letters) for path in (usual, *found.paths)]
    assert letters == found.missing.union(*having)
    left = letters_of(legible(text, found.missing) for text in texts) - {ELLIPSIS}
    assert left <= frozenset().union(*having)
    named = fonts_to_install(letter for letter in found.missing if len(letter) == 1)
    assert bool(named) == any(len(letter) == 1 for letter in found.missing)
    assert all(name.startswith("Noto Sans") and how for name, how in named.items())
    if empty:
        monkeypatch.setattr(fonts.sys, "platform", "darwin")
        assert all("font-noto-sans" in how for how in fonts_to_install(found.missing).values())


@pytest.mark.parametrize(
    ("letter", "name", "linux"),
    [
        ("漢", "Noto Sans CJK", "fonts-noto-cjk"),
        ("カ", "Noto Sans CJK", "fonts-noto-cjk"),
        ("한", "Noto Sans CJK", "fonts-noto-cjk"),
        ("ب", "Noto Sans Arabic", "fonts-noto-core"),
        ("क", "Noto Sans Devanagari", "fonts-noto-core"),
        ("ʞ", "Noto Sans", "fonts-noto-core"),
    ],
)
def test_the_font_to_install_is_that_of_the_script(monkeypatch, letter, name, linux):
    for platform, told in {
        "linux": linux,
        "darwin": "brew install --cask font-noto-sans",
        "win32": "https://fonts.google.com/noto",
    }.items():
        monkeypatch.setattr(fonts.sys, "platform", platform)
        ((found, how),) = fonts_to_install([letter]).items()
        assert found == name
        assert told in how
        assert f"the letter {letter}:" in font_remark({letter})
