"""A performer: a resolved language-character pair, ready for any schedule."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from html import escape
from itertools import compress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.rates import exact
from lipsync_lang.errors import LipsyncError, refuse_other
from lipsync_lang.performing.delivery import delivery
from lipsync_lang.performing.edits import overlays
from lipsync_lang.performing.label_reader import LabelReader, Unknown
from lipsync_lang.performing.loudness import loudness_dial
from lipsync_lang.phonology.labels import Notation
from lipsync_lang.pipeline.arrays import Floats, Ints
from lipsync_lang.pipeline.drive import drive
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.perform import Performance, perform
from lipsync_lang.pipeline.prepare import channel_kernel
from lipsync_lang.pipeline.track import lay_track
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.performing.delivery import Levels
    from lipsync_lang.phonology.nearest import Nearest
    from lipsync_lang.pipeline.overlay import Overlay
    from lipsync_lang.resolver.compiled import Compiled, Report
    from lipsync_lang.rigs.channel import Channel
    from lipsync_lang.rigs.driver import Driver
    from lipsync_lang.speech.speaking import Speaker

FASTEST = 1000.0
"""Most frames per second; beyond it the number is a mistake."""


@dataclass(frozen=True, eq=False)
class Performer:
    """What `resolve` returns."""

    compiled: "Compiled"
    motion: Motion
    unknown: Unknown = "error"
    """What becomes of labels no notation maps: an `error`, `rest`, or, of IPA, the `nearest`."""
    paths: tuple[Path, ...] = ()
    """Folders and files that were searched for packs before all others."""

    def __post_init__(self) -> None:
        refuse_other("unknown", self.unknown, Unknown)

    def __repr__(self) -> str:
        """Say in one line whose performer it is."""
        counts = f"{len(self.compiled.phonemes) - 1} common phonemes, {len(self.poses)} poses"
        return f"<Performer {self.language} on {self.character}: {counts}>"

    def _repr_html_(self) -> str:
        """Show notebooks the report."""
        return f"<pre>{escape(str(self.report))}</pre>"

    def __getstate__(self) -> dict[str, object]:
        """Pickle what it was made of; what it worked out since is worked out again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def language(self) -> str:
        """Name of the language pack."""
        return self.compiled.language

    @property
    def character(self) -> str:
        """Name of the character."""
        return self.compiled.character

    @property
    def poses(self) -> tuple[str, ...]:
        """Pose names, in the order of an animation's columns."""
        return self.compiled.poses

    @property
    def model(self) -> Path | None:
        """The model file that the character names, or else its pose set."""
        return Path(self.compiled.model) if self.compiled.model is not None else None

    @cached_property
    def channels(self) -> "tuple[Channel, ...]":
        """What each pose is on a model; a rig's own channels come with `rigged`."""
        from lipsync_lang.rigs.driver import bare

        return bare(self.poses, self.compiled.pose_names)

    @property
    def report(self) -> "Report":
        """What of this pair comes from which layer."""
        return self.compiled.report

    def with_motion(self, change: "Mapping[str, object] | str | None") -> Self:
        """Return this performer with some motion settings changed."""
        from lipsync_lang.resolver.settings import motion_with

        return replace(self, motion=motion_with(self.motion, change))

    def perform(  # noqa: PLR0913 what is said, and all that says how
        self,
        schedule: Schedule,
        fps: float = 60,
        *,
        line: str | None = None,
        styles: "Levels | None" = None,
        dials: "Levels | None" = None,
        intensity: float = 0.0,
    ) -> Animation:
        """Animate a schedule.

        Parameters
        ----------
        schedule : timed phonemes in any notation of the language
        fps : output frames per second, from 1 to 1000; 23.976 and 29.97 mean their fractions
        line : the name of a line, where the character has something of its own for it
        styles : by name, the share of a style over neutral, from 0 to 1
        dials : by region, how far its poses move: 0 not at all, 1 as usual, 2 twice as far;
            shares and levels alike may be points of seconds and number instead
        intensity : how much loudness moves the mouth, beside the dials: 0 not at all, 1 as the
            pose set says, up to 2; the schedule must have its sound

        Raises
        ------
        ScheduleError
            A label is in no notation of the language.
        LipsyncError
            A style, a region or a line is unknown here; or loudness has nothing to move, or
            nothing to be taken from.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]), fps=24)
        >>> animation.weights.shape == (len(animation), len(performer.poses))
        True
        """
        fps = exact(fps)
        asked: dict[str, Any] = {
            "line": line, "styles": styles, "dials": dials, "intensity": intensity,
        }  # fmt: skip
        performance = self.performance(schedule, fps, **asked)
        return Animation(
            performance.frames.times(),
            self.poses,
            performance.weights(),
            fps,
            schedule,
            performer=self,
            asked=asked,
            channels=self.channels,
            model=self.model,
            neutral=self.compiled.neutral,
            contacts=tuple(compress(self.poses, self.compiled.tables.held)),
        )

    def rigged(self, animation: Animation) -> Animation:
        """Drive the character's model: an animation of its rig's channels in place of poses.

        The same times; values of bones are degrees or units of length. A character without a rig,
        or an animation that is rigged already, stays as it is.

        Raises
        ------
        LipsyncError
            The animation is of other poses.
        """
        driver = self._driver
        if driver is None or animation.channels == driver.channels:
            return animation
        if animation.poses != self.poses:
            raise LipsyncError(f"the rig of {self.character} drives other poses than these")
        motion, fps = self.motion, animation.fps
        kernel = channel_kernel(motion, fps)
        values = drive(animation.weights, driver.rig, motion.speed_limit / fps, kernel)
        names = tuple(channel.name for channel in driver.channels)
        return replace(
            animation,
            poses=names,
            weights=values,
            channels=driver.channels,
            model=self.model,
            contacts=(),
        )

    def performance(  # noqa: PLR0913 as `perform`
        self,
        schedule: Schedule,
        fps: float,
        *,
        line: str | None = None,
        styles: "Levels | None" = None,
        dials: "Levels | None" = None,
        intensity: float = 0.0,
    ) -> Performance:
        """Prepare a performance whose stages can be looked at one by one; see `perform`."""
        if not 1 <= fps <= FASTEST:
            raise LipsyncError(f"{fps} frames per second: give a number from 1 to {FASTEST:g}")
        fps = exact(fps)
        ids, times, source = self.labels.common_phonemes(schedule)
        compiled = self.compiled
        blends, scaled = delivery(compiled, schedule, line, styles, dials)
        loud = loudness_dial(compiled, schedule, lambda: self.labels.classes(schedule), intensity)
        scaled += () if loud is None else (loud,)
        track = lay_track(ids, times, source, compiled.tables, self.motion, blends)
        own: tuple[Overlay, ...] = ()
        if line is not None or compiled.word_edits:
            silent = np.ones(len(schedule), bool)
            silent[source[ids != compiled.tables.silence]] = False
            own = overlays(compiled, schedule, silent.tolist(), line)
        return perform(
            compiled.tables, track, self.motion, fps, overlays=own, blends=blends, dials=scaled
        )

    def explain(self, animation: Animation, seconds: float) -> "Explanation":
        """Say why each pose of an animation of this performer stands where it stands at a time."""
        from lipsync_lang.performing.trace import explain

        return explain(animation, seconds)

    def common_phonemes(self, schedule: Schedule) -> tuple[Ints, Floats, Ints]:
        """Map a schedule's labels to common phonemes; see `LabelReader.common_phonemes`."""
        return self.labels.common_phonemes(schedule)

    def automatic(self, schedule: Schedule) -> "dict[str, Nearest]":
        """Return the labels that features alone mapped; see `LabelReader.automatic`."""
        return self.labels.automatic(schedule)

    def notation(self, schedule: Schedule) -> Notation:
        """Return the notation of a schedule's labels: the stated one, else the likeliest."""
        return self.labels.notation(schedule)

    @cached_property
    def labels(self) -> LabelReader:
        """The reader of schedules' labels."""
        return LabelReader(self.compiled, self.unknown, self.paths)

    @cached_property
    def speaker(self) -> "Speaker":
        """The language, ready to read and speak text; its character's words included."""
        from lipsync_lang.phonology.manner import Manner
        from lipsync_lang.speech.speaking import Speaker

        return Speaker(
            Manner.from_plain(self.compiled.manner), self.labels.notations, self.labels.near
        )

    @cached_property
    def _driver(self) -> "Driver | None":
        """What drives the character's model; None where it has no rig."""
        from lipsync_lang.rigs.driver import Driver

        data, floors = self.compiled.rig, self.compiled.tables.floors
        return None if data is None else Driver.from_plain(data, self.poses, floors)
