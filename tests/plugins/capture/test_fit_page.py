"""The page of a fit: complete, safe, and small enough for many lines."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from lipsync_lang.plugins.capture import fit_page as page_module
from lipsync_lang.plugins.capture.fit_file import (
    FitFold,
    FitItem,
    FitProposal,
    FitVerdict,
    SetAside,
)
from lipsync_lang.plugins.capture.fit_lines import ShownLine, signal_figures
from lipsync_lang.plugins.capture.fit_page import fit_page

ODD = "</script><script>alert(1)</script>\"'&"


def line(name="one", error=0.1, signals=("jaw", "lips"), frames=120, speaker="anna"):
    times = np.arange(frames) / 60
    captured = np.column_stack([np.sin(times * (n + 3)) for n in range(len(signals))])
    before, after = captured * 0.5 + error, captured + error
    captured = captured.copy()
    captured[10:20, 0] = np.nan
    figures = signal_figures(signals, captured, before, after)
    bounds = np.linspace(0, times[-1], 5)
    return ShownLine(
        name, times, tuple(signals), captured, before, after, ("m", "aa", "p", "_"), bounds,
        figures, speaker,
    )  # fmt: skip


def proposal(*, accepted=True, **more):
    stated = {
        "language": "english",
        "character": "anna",
        "poseset": "facefx",
        "lines": 2,
        "seconds": 12.5,
        "speakers": ("anna",),
        "verdict": FitVerdict(
            accepted=accepted,
            why="0.1 before, 0.05 after",
            folds=(FitFold(held_out="one", by="line", before=0.12, after=0.07),),
        ),
        "items": (
            FitItem(
                item="targets.aa", value={"open": 0.7}, was={"open": 0.5}, occurrences=21,
                residual_before=0.1, residual_after=0.04, confidence=0.9,
            ),
            FitItem(item="softness.jaw", value=0.06, occurrences=400, confidence=0.2),
        ),
        "set_aside": (SetAside(line="bad", why="its clock drifts"),),
        "remarks": ("one: is moved",),
    }  # fmt: skip
    return FitProposal(**(stated | more))


class Reader(HTMLParser):
    """Collects tags, and text by its tag."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in {"meta", "link", "path", "br"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in {"meta", "link", "path", "br"}:
            assert self.open.pop() == tag, "tags nest"

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.text.append(data)

    @property
    def told(self):
        return re.sub(r"\s+", " ", " ".join(self.text))


def test_all_parts_of_a_fit_are_told():
    told = Reader(fit_page([line("one"), line("two", 0.3)], proposal())).told
    for text in (
        "english on anna", "generalises", "0.1 before, 0.05 after", "12.5", "targets.aa",
        '{"open": 0.7}', '{"open": 0.5}', "softness.jaw", "its clock drifts", "one: is moved",
        "Pearson r after", "captured", "curves before", "aa",
    ):  # fmt: skip
        assert text in told, text


def test_a_refused_fit_says_so():
    told = Reader(fit_page([line()], proposal(accepted=False))).told
    assert "The fit is refused" in re.sub(" +", " ", told)
    assert "generalises" not in told


def test_the_worst_line_comes_first_and_opens():
    text = fit_page([line("good", 0.01), line("worst", 0.5), line("bad", 0.2)], proposal())
    places = [text.index(f"<summary>{name}") for name in ("worst", "bad", "good")]
    assert places == sorted(places)
    rows = re.findall(r'<a href="#line(\d)">(\w+)</a>', text)
    assert rows == [("1", "worst"), ("2", "bad"), ("3", "good")]
    assert text.index('id="line1"') < places[0] < text.index('id="line2"')


def test_figures_are_measured_where_something_was_captured():
    one = line(error=0.2)
    jaw = next(figures for figures in one.figures if figures.signal == "jaw")
    assert jaw.rms_after == pytest.approx(0.2)
    assert jaw.r_after == pytest.approx(1.0)
    assert one.rms_after == pytest.approx(0.2)
    known = np.isfinite(one.captured[:, 0])
    before = np.sqrt(np.mean((one.captured - one.before)[known, 0] ** 2))
    assert jaw.rms_before == pytest.approx(before)


def test_a_signal_that_stands_still_has_no_r_and_a_lost_one_no_figures():
    captured = np.column_stack([np.full(9, 0.2), np.full(9, np.nan)])
    shown = np.random.default_rng(0).random((9, 2))
    (only,) = signal_figures(("still", "lost"), captured, shown, shown)
    assert (only.signal, only.r_before, only.r_after) == ("still", None, None)


def test_gaps_of_a_capture_are_gaps_of_its_curve():
    text = fit_page([line(signals=("jaw",))], proposal())
    captured = re.search(r'<path class="captured" d="([^"]*)"', text)[1]
    assert captured.count("M") == 2
    assert re.search(r'<path class="after" d="([^"]*)"', text)[1].count("M") == 1
    assert "nan" not in captured


def test_a_signal_at_rest_lies_at_the_foot():
    one = line(signals=("jaw",))
    rest = np.zeros_like(one.before)
    figures = signal_figures(one.signals, rest, rest, rest)
    still = replace(one, captured=rest, before=rest, after=rest, figures=figures)
    text = fit_page([still], proposal())
    heights = re.findall(
        r"[ML][\d.]+ ([\d.]+)", re.search(r'class="captured" d="([^"]*)"', text)[1]
    )
    assert {float(height) for height in heights} == {page_module.HEIGHT}


@pytest.mark.parametrize("where", ["name", "signal", "label", "speaker", "why", "remark", "item"])
def test_odd_names_stay_text(where):
    odd = line(
        ODD if where == "name" else "one",
        signals=(ODD if where == "signal" else "jaw",),
        speaker=ODD if where == "speaker" else "",
    )
    if where == "label":
        object.__setattr__(odd, "labels", (ODD, "aa", "p", "_"))
    more = {}
    if where == "why":
        more["set_aside"] = (SetAside(line=ODD, why=ODD),)
    if where == "remark":
        more["remarks"] = (ODD,)
    if where == "item":
        more["language"] = ODD
    page = Reader(fit_page([odd], proposal(**more)))
    assert "script" not in {tag for tag, _ in page.tags}
    assert ODD in "".join(page.text)


def test_a_zero_character_is_replaced():
    odd = line()
    object.__setattr__(odd, "labels", ("m\0", "aa", "p", "_"))
    text = fit_page([odd], proposal())
    assert "\0" not in text
    assert "m\N{REPLACEMENT CHARACTER}" in text


def test_nothing_is_loaded_or_run():
    text = fit_page([line()], proposal())
    assert "default-src 'none'" in text
    assert "script" not in {tag for tag, _ in Reader(text).tags}
    assert not re.search(r"(src|href)=\"(?!#|data:,)", text)
    assert "http" not in text.replace('http-equiv="', "")


def test_many_lines_are_named_but_not_all_drawn(monkeypatch):
    monkeypatch.setattr(page_module, "MAX_DRAWN_LINES", 3)
    lines = [line(f"line{n}", n / 100) for n in range(8)]
    text = fit_page(lines, proposal())
    assert text.count("<details") == 3
    assert "The worst 3 are drawn below" in text
    assert all(f">{one.name}<" in text for one in lines)


def test_long_lines_and_many_signals_keep_the_page_small():
    names = tuple(f"s{n}" for n in range(40))
    text = fit_page([line(signals=names, frames=36_000)], proposal())
    assert text.count('class="curves"') == page_module.MAX_DRAWN_SIGNALS
    assert f"The {page_module.MAX_DRAWN_SIGNALS} signals that move most, of 40" in text
    assert len(text) < 2_000_000


def test_no_lines_are_a_page_too():
    assert "No line was captured" in fit_page([], proposal())
