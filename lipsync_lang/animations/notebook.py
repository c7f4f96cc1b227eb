"""What notebooks show of an animation: its curves as a small inline SVG."""

from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation

WIDTH, HEIGHT = 720, 160
"""Pixels of the drawing."""

MOST_POINTS = 720
"""Points of a curve that are drawn, so that an hour's curves stay as light as a line's."""

MOST_CURVES = 60
"""Curves that are drawn: those that move most."""


def curves_html(animation: "Animation") -> str:
    """Draw the curves over seconds, each in a colour of its own, with a legend below.

    Values run from 0 to 1 or, where a rig has wider ones, from the least to the greatest.
    """
    head = escape(repr(animation))
    if not len(animation):
        return f"<p>{head}</p>"
    moving = np.ptp(animation.weights, axis=0)
    shown = [int(i) for i in np.argsort(-moving, kind="stable")[:MOST_CURVES] if moving[i] > 0]
    low, high = min(0.0, animation.weights.min()), max(1.0, animation.weights.max())
    picked = np.unique(np.linspace(0, len(animation) - 1, MOST_POINTS).round().astype(int))
    times = animation.times[picked] - animation.times[0]
    across = times / max(times[-1], 1e-9) * WIDTH
    lines, legend = [], []
    for number, pose in enumerate(sorted(shown)):
        colour = f"hsl({360 * number / len(shown):.0f},65%,45%)"
        heights = HEIGHT * (high - animation.weights[picked, pose]) / (high - low)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, heights, strict=True))
        name = escape(animation.poses[pose])
        lines.append(
            f'<polyline stroke="{colour}" points="{points}"><title>{name}</title></polyline>'
        )
        legend.append(f'<span style="color:{colour}">{name}</span>')
    return (
        f"<div><p>{head}</p>"
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" fill="none" '
        f'stroke-width="1.5">{"".join(lines)}</svg><p>{" ".join(legend)}</p></div>'
    )
