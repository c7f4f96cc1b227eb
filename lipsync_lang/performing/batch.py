"""Batch: many schedules become animations.

Each animation equals that of a single schedule bit by bit: labels are mapped all at once but
independently, and the stages process one schedule at a time.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.rates import checked_rate
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.delivery import bends_of, delivery
from lipsync_lang.performing.edits import corrected, overlays
from lipsync_lang.performing.loudness import loudness_dial
from lipsync_lang.performing.performed_line import PerformedLine
from lipsync_lang.performing.stress import emphasis_dial, stress_dial
from lipsync_lang.pipeline.kernel_plan import keep, serves
from lipsync_lang.pipeline.perform import Performance, perform
from lipsync_lang.pipeline.prepare import prepare
from lipsync_lang.pipeline.track import lay_track

if TYPE_CHECKING:
    from lipsync_lang.performing.label_sounds import LabelSounds
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.bend import Bend
    from lipsync_lang.pipeline.kernel_plan import KernelCopy
    from lipsync_lang.pipeline.levels import Blend, Dial
    from lipsync_lang.pipeline.overlay import Overlay
    from lipsync_lang.pipeline.tables import Tables
    from lipsync_lang.schedules.schedule import Schedule

OwnSettings = Mapping[str, Any]
"""Options of `Performer.perform` that are the same for all schedules, by name."""


class LineDelivery(NamedTuple):
    """Delivery of a schedule: its styles, dials, curve edits and keys."""

    tables: "Tables"
    blends: "tuple[Blend, ...]"
    dials: "tuple[Dial, ...]"
    overlays: "tuple[Overlay, ...]"
    bends: "tuple[Bend, ...]"

    @classmethod
    def of(
        cls,
        performer: "Performer",
        schedule: "Schedule",
        sounds: "LabelSounds",
        line: str | None,
        asked: OwnSettings,
    ) -> Self:
        """Find the delivery of a schedule; `asked` holds the options of `perform`."""
        compiled = performer.compiled
        blends, dials = delivery(compiled, schedule, line, asked["styles"], asked["dials"])
        intensity = asked["intensity"]
        if intensity is None and schedule.audio is not None:
            intensity = compiled.line_deliveries.get(line or "", {}).get("intensity")
        dials += _effort(performer, schedule, sounds, intensity)
        own: tuple[Overlay, ...] = ()
        if line is not None or compiled.word_edits:
            silent = np.ones(len(schedule), bool)
            # a label is silent only if none of its sounds is anything else
            silent[sounds.source[sounds.ids != compiled.tables.silence]] = False
            own = overlays(compiled, schedule, silent.tolist(), line)
        bends = bends_of(compiled, schedule, line, asked["bends"])
        return cls(performer.tables(blends), blends, dials, own, bends)

    def performance(self, performer: "Performer", sounds: "LabelSounds", fps: float) -> Performance:
        """Lay the track, and prepare its performance."""
        tables, blends, dials, laid, bends = self
        motion = performer.styled_motion(blends)
        ids, times, source, _ = sounds
        track = lay_track(ids, times, source, tables, motion, blends)
        return perform(
            tables, track, motion, fps, overlays=laid, blends=blends, dials=dials, bends=bends
        )


def _effort(
    performer: "Performer", schedule: "Schedule", sounds: "LabelSounds", intensity: float | None
) -> "tuple[Dial, ...]":
    """Return the dials of stress, emphasis and loudness; empty without an effect."""
    stated, motion, labels = performer.compiled.intensity, performer.motion, performer.labels
    poses = performer.opening_poses
    stresses = labels.stresses(sounds) if motion.stress and stated else sounds.marks[:0]
    dials = [
        stress_dial(stated, schedule, stresses, motion.stress, poses),
        emphasis_dial(stated, schedule, poses),
    ]
    if schedule.audio is not None or intensity is not None:
        classes = labels.classes(sounds, len(schedule))
        compiled = performer.compiled
        dials.append(loudness_dial(compiled, schedule, classes, intensity, motion, poses))
    return tuple(dial for dial in dials if dial is not None)


def animate(
    performer: "Performer",
    schedules: "Sequence[Schedule]",
    fps: float,
    lines: Sequence[str | None] | None,
    asked: OwnSettings,
) -> list[Animation]:
    """Animate schedules; see `Performer.perform_many`."""
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
            PerformedLine(performer, settings),
            channels=channels,
            model=performer.model,
            neutral=performer.compiled.neutral,
            contacts=dict(performer.contact_floors),
        )
        out.append(animation)
    return out


def _neutral_copy(performer: "Performer", fps: float) -> "KernelCopy | None":
    """Return the neutral bank as the compiled kernel keeps it; None if the kernel cannot play it.

    `lay_track` lays the tracks of a bank with trigrams.
    """
    tables, motion = performer.compiled.tables, performer.motion
    if not serves(motion) or len(tables.trigrams):
        return None
    shown = tables.papers if motion.thresholds == "paper" else tables
    return keep(shown, motion, prepare(shown, motion, fps), fps)
