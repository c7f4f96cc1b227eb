"""Batch: many schedules become animations.

Each is what it would be alone, to the bit: labels are mapped all at once, each by itself, and the
stages see one schedule at a time.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.rates import checked_rate
from lipsync_lang.errors import LipsyncError
from lipsync_lang.performing.delivery import delivery
from lipsync_lang.performing.edits import overlays
from lipsync_lang.performing.loudness import loudness_dial
from lipsync_lang.performing.stress import emphasis_dial, stress_dial
from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.pipeline.perform import performed

if TYPE_CHECKING:
    from lipsync_lang.performing.label_sounds import LabelSounds
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.levels import Blend, Dial
    from lipsync_lang.pipeline.overlay import Overlay
    from lipsync_lang.pipeline.tables import Tables
    from lipsync_lang.schedules.schedule import Schedule

Asked = Mapping[str, Any]
"""Options of `Performer.perform` that are the same for all schedules, by name."""


class Delivered(NamedTuple):
    """All that says how a schedule is spoken."""

    tables: "Tables"
    blends: "tuple[Blend, ...]"
    dials: "tuple[Dial, ...]"
    overlays: "tuple[Overlay, ...]"

    @classmethod
    def of(
        cls,
        performer: "Performer",
        schedule: "Schedule",
        sounds: "LabelSounds",
        line: str | None,
        asked: Asked,
    ) -> Self:
        """Find what applies to a schedule; `asked` is of `perform`."""
        compiled = performer.compiled
        blends, dials = delivery(compiled, schedule, line, asked["styles"], asked["dials"])
        dials += _effort(performer, schedule, sounds, asked["intensity"])
        own: tuple[Overlay, ...] = ()
        if line is not None or compiled.word_edits:
            silent = np.ones(len(schedule), bool)
            silent[sounds.source[sounds.ids != compiled.tables.silence]] = False
            own = overlays(compiled, schedule, silent.tolist(), line)
        return cls(performer.tables(blends), blends, dials, own)


def _effort(
    performer: "Performer",
    schedule: "Schedule",
    sounds: "LabelSounds",
    intensity: float | None,
) -> "tuple[Dial, ...]":
    """Return the dials of stress, emphasis and loudness; none where there is no effect."""
    stated, motion, labels = performer.compiled.intensity, performer.motion, performer.labels
    poses = performer.opening_poses
    stresses = labels.stresses(sounds) if motion.stress and stated else sounds.marks[:0]
    heard = schedule.audio is not None or intensity is not None
    classes = labels.classes(sounds.ids, sounds.source, len(schedule)) if heard else []
    dials = (
        stress_dial(stated, schedule, stresses, motion.stress, poses),
        emphasis_dial(stated, schedule, poses),
        loudness_dial(performer.compiled, schedule, classes, intensity, motion, poses),
    )
    return tuple(dial for dial in dials if dial is not None)


def animate(
    performer: "Performer",
    schedules: "Sequence[Schedule]",
    fps: float,
    lines: Sequence[str | None] | None,
    asked: Asked,
) -> list[Animation]:
    """Animate schedules; see `Performer.perform_many`."""
    fps = checked_rate(fps)
    names = [None] * len(schedules) if lines is None else lines
    if len(names) != len(schedules):
        raise LipsyncError(f"{len(names)} lines for {len(schedules)} schedules; give each one")
    read = performer.labels.read(schedules) if schedules else []
    out = []
    for schedule, sounds, line in zip(schedules, read, names, strict=True):
        said = Delivered.of(performer, schedule, sounds, line, asked)
        times, weights = _weighed(performer, sounds, said, fps)
        out.append(_animation(performer, schedule, times, weights, fps, {"line": line, **asked}))
    return out


def _weighed(
    performer: "Performer", sounds: "LabelSounds", said: Delivered, fps: float
) -> tuple[Floats, Floats]:
    ids, times, source, _ = sounds
    tables, blends, dials, laid = said
    return performed(
        tables, ids, times, source, performer.motion, fps,
        overlays=laid, blends=blends, dials=dials,
    )  # fmt: skip


def _animation(  # noqa: PLR0913, PLR0917 what an animation holds
    performer: "Performer",
    schedule: "Schedule",
    times: Floats,
    weights: Floats,
    fps: float,
    asked: dict[str, Any],
) -> Animation:
    return Animation(
        times,
        performer.poses,
        weights,
        fps,
        schedule,
        performer=performer,
        asked=asked,
        channels=performer.channels,
        model=performer.model,
        neutral=performer.compiled.neutral,
        contacts=dict(performer.contact_floors),
    )
