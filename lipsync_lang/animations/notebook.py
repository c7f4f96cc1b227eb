"""Notebook display of an animation: its curves as a small inline SVG, or its whole page."""

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation

WIDTH, HEIGHT = 720, 160
"""Size of the drawing in pixels."""

MOST_POINTS = 720
"""Maximum number of points per curve, to limit the size of long animations."""

MOST_CURVES = 60
"""Maximum number of curves; those with the most movement are drawn."""


@dataclass(frozen=True)
class PageFrame:
    """A page in a frame of a notebook, `height` pixels high; it cannot reach the notebook."""

    page: str
    height: int

    def __repr__(self) -> str:
        """Say how the page is shown elsewhere."""
        size = f"{len(self.page) / 1e6:.1f} MB"
        return f"<PageFrame of {size}; save('line.html') writes it to a file>"

    def _repr_html_(self) -> str:
        """Show the page in notebooks."""
        return (
            f'<iframe sandbox="allow-scripts" width="100%" height="{self.height:d}" '
            f'style="border: 0" srcdoc="{escape(self.page)}"></iframe>'
        )


def curves_html(animation: "Animation") -> str:
    """Draw the curves over seconds in different colours, with a legend below.

    The vertical range is 0 to 1, or the range of the values if a rig exceeds it.
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
