"""Draw the pictures of `docs/explanation/how-good-is-it.md` from the figures that its page has.

Each is readable at the width of a phone: few words, large letters, one column.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from how_good import MEASURES, METHODS, MOTIONS
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from pathlib import Path

    from how_good import Page

OURS, PAPER, OTHER, INK, PALE = "#1f618d", "#c0392b", "#999999", "#222222", "#d5d8dc"
COLOURS = {"drafted bank": OURS, "paper's motion": PAPER}
SHORT = {
    "drafted bank": "this program",
    "paper's motion": "paper's motion",
    "linear warp": "even stretching",
    "keyframes at centres": "keyframes",
    "dominance, utterance": "dominance",
}
WIDTH = 6.4
"""Inches; with 100 dots an inch and letters of 11 points a phone shows it well."""

MARKS = ("o", "X", "s", "^", "D", "v", "P")
LINES = (INK, "#7f8c8d", "#1f77b4", "#e67e22", "#27ae60", "#85c1e9", "#8e44ad")
"""Colours of the sets of boundaries; manual boundaries stand out."""


def draw(page: Page, folder: Path) -> None:
    """Draw all pictures into a folder."""
    for make in (articulation, motion, coverage, reading, alignment, speed):
        figure = make(page)
        figure.savefig(folder / f"how-good-{make.__name__}.png", dpi=100)


def _figure(height: float, **more: Any) -> tuple[Figure, Any]:
    """Return a picture, and its axes in a plain style."""
    figure = Figure((WIDTH, height), layout="constrained")
    axes = figure.subplots(**more)
    for one in np.atleast_1d(axes).flat:
        one.tick_params(labelsize=11)
        one.spines[["top", "right"]].set_visible(False)
        one.set_axisbelow(True)
    return figure, axes


def articulation(page: Page) -> Figure:
    """Draw r by method, a panel for each measure, with the recordings as dots."""
    figure, rows = _figure(7.6, nrows=len(MEASURES), sharex=True)
    found = page.figures("articulation")["r"]
    for axes, (measure, title) in zip(rows, MEASURES, strict=True):
        names = [method for method, _ in METHODS][::-1]
        values = [found[measure][name] for name in names]
        means = [float(np.mean(each)) for each in values]
        axes.barh(names, means, color=[COLOURS.get(name, PALE) for name in names], height=0.7)
        for at, each in enumerate(values):
            axes.plot(each, [at] * len(each), "o", color=INK, ms=4, alpha=0.6)
            axes.text(0.02, at, f"{means[at]:.2f}", va="center", fontsize=11,
                      color="white" if names[at] in COLOURS else INK)  # fmt: skip
        axes.set_yticks(range(len(names)), [SHORT[name] for name in names])
        axes.set_title(title, loc="left", fontsize=12, fontweight="bold")
        axes.grid(axis="x", color="#dddddd", lw=0.6)
    rows[-1].set_xlim(0, 1)
    rows[-1].set_xlabel("Pearson's r with real mouths; dots are recordings", fontsize=11)
    return figure


def motion(page: Page) -> Figure:
    """Draw each measure of the jaw beside the range of captures, a panel each."""
    figure, panels = _figure(6.8, nrows=3, ncols=2)
    ours = page.figures("motion")["posesets"]
    drawn = [(name, ours[name], OURS if not n else "#5dade2") for n, name in enumerate(ours)]
    drawn.append(("paper's", page.figures("motion-paper")["posesets"]["facefx"], PAPER))
    for axes, (key, title) in zip(panels.flat, MOTIONS, strict=True):
        low, high = page.here["captures"][key]
        values = [figures[key] for _, figures, _ in drawn]
        pad = max(0.012 * max(*values, high), 0)
        axes.axvspan(low - pad, high + pad, color="#a9dfbf", zorder=0)
        for at, (_, figures, colour) in enumerate(drawn[::-1]):
            axes.plot([0, figures[key]], [at, at], color=colour, lw=2)
            axes.plot(figures[key], at, "o", color=colour, ms=9, clip_on=False)
        axes.set_yticks(range(len(drawn)), [name for name, *_ in drawn[::-1]])
        axes.set_ylim(-0.6, len(drawn) - 0.4)
        axes.set_xlim(0, 1.15 * max(*values, high))
        axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
    figure.supxlabel(
        "green: captures of a real face; blue: this program on two faces;\n"
        "red: the paper's motion on the first",
        fontsize=11,
    )
    return figure


def coverage(page: Page) -> Figure:
    """Draw the bigrams that the text of each language uses."""
    spoken = page.figures("languages")["languages"]
    order = sorted(spoken, key=lambda name: spoken[name]["used"])
    figure, axes = _figure(0.19 * len(order) + 1.2)
    used = [spoken[name]["used"] for name in order]
    axes.barh(order, used, color=PALE, height=0.8, label="all that the text uses")
    ninety = [spoken[name]["for_90"] for name in order]
    axes.barh(order, ninety, color=OURS, height=0.8, label="90 % of what is spoken")
    axes.set(xlim=(0, 441), ylim=(-0.7, len(order) - 0.3))
    axes.set_xlabel("bigrams, of 441", fontsize=11)
    axes.tick_params(axis="y", labelsize=9)
    axes.legend(frameon=False, fontsize=11, loc="lower right")
    axes.grid(axis="x", color="#dddddd", lw=0.6)
    return figure


def reading(page: Page) -> Figure:
    """Draw the phoneme error of each language, and its wrong lip closures."""
    found = page.figures("reading")["languages"]
    order = sorted(found, key=lambda name: -found[name]["error"])
    figure, axes = _figure(0.3 * len(order) + 1.2)
    axes.barh(order, [100 * found[name]["error"] for name in order], color=OURS, height=0.7,
              label="phonemes that differ")  # fmt: skip
    axes.plot([100 * found[name]["closures"] for name in order], order, "D", color=PAPER, ms=6,
              clip_on=False, label="words with a wrong lip closure")  # fmt: skip
    axes.set_xlabel("% against a dictionary", fontsize=11)
    axes.set_ylim(-0.7, len(order) - 0.3)
    axes.legend(frameon=False, fontsize=11, loc="upper right")
    axes.grid(axis="x", color="#dddddd", lw=0.6)
    return figure


def alignment(page: Page) -> Figure:
    """Draw the share of boundaries within each error."""
    figure, axes = _figure(5.0)
    for (title, one), mark, colour in zip(page.aligned(), MARKS, LINES, strict=False):
        limits = [float(limit) for limit in one["within_ms"]]
        shares = [100 * share for share in one["within_ms"].values()]
        hand = one is page.aligned()[0][1]
        axes.plot(limits, shares, marker=mark, ms=5, lw=3 if hand else 1.4,
                  color=INK if hand else colour,
                  label=f"{title} ({one['boundaries']:,})")  # fmt: skip
    axes.set_xscale("log")
    axes.set_xticks([5, 10, 20, 50, 100, 200], ["5", "10", "20", "50", "100", "200"])
    axes.minorticks_off()
    axes.set(xlim=(2.4, 210), ylim=(0, 101))
    axes.set_xlabel("boundary off by at most, ms", fontsize=11)
    axes.set_ylabel("% of the boundaries", fontsize=11)
    axes.grid(color="#dddddd", lw=0.6)
    axes.legend(frameon=False, fontsize=9.5, loc="lower right")
    return figure


def speed(page: Page) -> Figure:
    """Draw the time of an utterance by its length."""
    figure, axes = _figure(3.8)
    counts, seconds = np.array(page.lengths()).T
    axes.loglog(counts, 1000 * seconds, "o-", color=OURS, lw=2)
    for count, second in zip(counts, seconds, strict=True):
        axes.annotate(f"{1000 * second:.2g} ms", (count, 1000 * second), (-5, 5), fontsize=10,
                      textcoords="offset points", ha="right")  # fmt: skip
    ticks = (10, 100, 1_000, 10_000, 100_000)
    axes.set_xticks(ticks, [f"{tick:,}" for tick in ticks])
    axes.set_yticks((0.1, 1, 10, 100), ("0.1", "1", "10", "100"))
    axes.set(xlim=(2, 250_000), ylim=(0.02, 400))
    axes.set_xlabel("phonemes of an utterance", fontsize=11)
    axes.set_ylabel("ms for its curves, 60 fps", fontsize=11)
    axes.grid(color="#dddddd", lw=0.6)
    return figure
