"""Batch: many schedules become animations.

Each animation equals that of a single schedule bit by bit: labels are mapped all at once but
independently, and the stages process one schedule at a time.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.rates import checked_rate
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.edits import corrected
from lipsync_lang.performing.played_pair import LineDelivery, OwnSettings
from lipsync_lang.pipeline.kernel_plan import keep, serves
from lipsync_lang.pipeline.prepare import prepare

if TYPE_CHECKING:
    from collections.abc import Callable

    from lipsync_lang.animations.animation import AnimationSource
    from lipsync_lang.performing.played_pair import PlayedPair
    from lipsync_lang.pipeline.kernel_plan import KernelCopy
    from lipsync_lang.schedules.schedule import Schedule


def animate(  # noqa: PLR0913, PLR0917 the lines, and settings of their delivery
    performer: "PlayedPair",
    schedules: "Sequence[Schedule]",
    fps: float,
    lines: Sequence[str | None] | None,
    asked: OwnSettings,
    source: "Callable[[OwnSettings], AnimationSource]",
) -> list[Animation]:
    """Animate schedules; see `Performer.perform_many`. `source` keeps the settings of each line."""
    fps = checked_rate(fps)
    names = [None] * len(schedules) if lines is None else lines
    if len(names) != len(schedules):
        raise LipsyncError(
            f"{len(names)} lines for {len(schedules)} schedules; give one line per schedule"
        )
    compiled, lined = performer.compiled, zip(schedules, names, strict=True)
    schedules = [
        corrected(compiled.line_deliveries.get(line or "", {}), compiled, schedule, line)
        for schedule, line in lined
    ]
    read = performer.labels.read(schedules) if schedules else []
    kept = _neutral_copy(performer, fps)
    moving = asked.get("gestures")
    if moving:
        from lipsync_lang.performing import gesturing
    out = []
    for schedule, sounds, line in zip(schedules, read, names, strict=True):
        settings = {"line": line, **asked}
        said = LineDelivery.of(performer, schedule, sounds, line, asked)
        if kept is not None and not (said.blends or said.overlays or said.bends):
            times, weights = kept.utter(sounds.ids, sounds.times, said.dials)
        else:
            made = said.performance(performer, sounds, fps)
            times, weights = made.frames.times(), made.weights()
        channels = performer.shown_channels(said.tables)
        poses = tuple(channel.name for channel in channels)
        scales = gesturing.scales_of(performer.compiled, moving, line) if moving else None
        if scales is not None:
            facts = performer, schedule, sounds, times, fps, scales, settings
            weights = gesturing.with_gestures(weights, *facts)
            poses += performer.gesture_set.poses
            channels += performer.gesture_channels
        animation = Animation(
            times,
            poses,
            weights,
            fps,
            schedule,
            source(settings),
            channels=channels,
            model=performer.model,
            neutral=performer.compiled.neutral,
            contacts=dict(performer.contact_floors),
        )
        out.append(animation)
    return out


def _neutral_copy(performer: "PlayedPair", fps: float) -> "KernelCopy | None":
    """Return the neutral bank as the compiled kernel keeps it; None if the kernel cannot play it.

    `lay_track` lays the tracks of a bank with trigrams.
    """
    tables, motion = performer.compiled.tables, performer.motion
    if not serves(motion) or len(tables.trigrams):
        return None
    shown = tables.papers if motion.thresholds == "paper" else tables
    return keep(shown, motion, prepare(shown, motion, fps), fps)
