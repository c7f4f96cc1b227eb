"""A performer: a resolved language-character pair, ready for any schedule."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self
from weakref import WeakKeyDictionary

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.delivery import delivery
from lipsync_lang.edits import overlays
from lipsync_lang.errors import LipsyncError, ScheduleError, did_you_mean
from lipsync_lang.loudness import loudness_dial
from lipsync_lang.packs.finding import IPA
from lipsync_lang.phonology.g2p.tokens import plain
from lipsync_lang.phonology.labels import Notation, Value, recognise
from lipsync_lang.phonology.notations import ready
from lipsync_lang.pipeline.arrays import Floats, Ints
from lipsync_lang.pipeline.drive import drive
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.perform import Performance, perform
from lipsync_lang.pipeline.track import lay_track
from lipsync_lang.rates import exact
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lipsync_lang.animations.animation import Channel
    from lipsync_lang.delivery import Levels
    from lipsync_lang.phonology.nearest import Among, Nearest
    from lipsync_lang.pipeline.overlay import Overlay
    from lipsync_lang.resolver.compiled import Compiled, Report
    from lipsync_lang.rigs.driver import Driver
    from lipsync_lang.speaking import Speaker
    from lipsync_lang.trace import Explanation

FASTEST = 1000.0
"""Most frames per second; beyond it the number is a mistake."""


@dataclass(frozen=True, eq=False)
class Performer:
    """What `resolve` returns."""

    compiled: "Compiled"
    motion: Motion
    unknown: str = "error"
    """What becomes of labels no notation maps: an `error`, `rest`, or, of IPA, the `nearest`."""

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
        values = drive(animation.weights, driver.rig, self.motion.speed_limit / animation.fps)
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
        ids, times, source = self.common_phonemes(schedule)
        compiled = self.compiled
        blends, scaled = delivery(compiled, schedule, line, styles, dials)
        loud = loudness_dial(compiled, schedule, lambda: self._classes(schedule), intensity)
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
        from lipsync_lang.trace import explain

        return explain(animation, seconds)

    def common_phonemes(self, schedule: Schedule) -> tuple[Ints, Floats, Ints]:
        """Map a schedule's labels to common phonemes.

        Returns
        -------
        (m,) numbers of common phonemes, (m + 1,) boundaries in seconds, (m,) the index of the
        scheduled phoneme each came from
        """
        values = self._values(schedule)
        if all(len(value) == 1 for value in values):
            numbers = np.array([self._numbers[value[0][0]] for value in values])
            return numbers, schedule.times, np.arange(len(numbers))
        ids: list[int] = []
        starts: list[float] = []
        source: list[int] = []
        times = schedule.times.tolist()
        for index, value in enumerate(values):
            at, length = times[index], times[index + 1] - times[index]
            for name, share in value:
                ids.append(self._numbers[name])
                starts.append(at)
                source.append(index)
                at += share * length
        if not ids:
            raise ScheduleError(
                f"{schedule.source}: all its labels are mute; there is no sound in it"
            )
        starts[0] = times[0]
        return np.array(ids), np.array([*starts, times[-1]]), np.array(source)

    def automatic(self, schedule: Schedule) -> "dict[str, Nearest]":
        """Return what features alone made of a schedule's labels: each that no pack maps, once.

        The common phonemes with their shares, what of the label is not shown, and how far it is
        from what is. Empty for a language that maps all its labels itself.
        """
        notation, near = self.notation(schedule), self._near
        if near is None or notation.nearest is None:
            return {}
        unmapped = (label for label in schedule.labels if notation.stated(label) is None)
        found = {label: near.nearest(notation.text(label) or label) for label in unmapped}
        return {label: nearest for label, nearest in found.items() if not nearest.unknown}

    def _values(self, schedule: Schedule) -> list[Value]:
        """Return what each label stands for, words of the language's own said its way."""
        notation = self.notation(schedule)
        values = self._found(schedule, notation)
        own = self.compiled.words if schedule.language == self.language else {}
        for word in schedule.words if own else ():
            sounds = own.get(plain(word.text))
            if sounds:
                values[word.first : word.stop] = _spread(sounds, word.stop - word.first)
        unknown = [i for i, value in enumerate(values) if value is None]
        if unknown and self.unknown != "rest":
            raise ScheduleError(self._unknown(schedule, unknown, notation))
        rest: Value = ((self.compiled.phonemes[0], 1.0),)
        return [rest if value is None else value for value in values]

    def _classes(self, schedule: Schedule) -> list[str]:
        """Return the class of each label's first sound; nothing for silence."""
        kinds, silence = self.compiled.manner["kinds"], self.compiled.phonemes[0]
        firsts = [value[0][0] if value else silence for value in self._values(schedule)]
        return ["" if name == silence else kinds.get(name) or "sound" for name in firsts]

    def _found(self, schedule: Schedule, notation: Notation) -> list[Value | None]:
        """Return what the notation says of each label, and of unknown IPA what is asked for."""
        values = [notation.find(label) for label in schedule.labels]
        wanted = self.unknown == "nearest" and notation is self._notations.get(IPA)
        near = self._hints if wanted and None in values else None
        if near is None:
            return values
        return [
            near.value(label) if value is None else value
            for label, value in zip(schedule.labels, values, strict=True)
        ]

    def notation(self, schedule: Schedule) -> Notation:
        """Return the notation of a schedule's labels: the one it states, else the likeliest."""
        name = schedule.notation
        if name is None:
            name = self._recognised.get(schedule)
        if name is None:
            shapes = self.compiled.visemes.keys() - self.compiled.notations.keys()
            own = {one: n for one, n in self._notations.items() if one not in shapes}
            name = recognise(schedule.labels, own)
            self._recognised[schedule] = name
        if name not in self._notations:
            raise ScheduleError(
                f"{schedule.source}: {self.language} has no notation '{name}'; "
                f"{did_you_mean(name, self._notations)}"
            )
        return self._notations[name]

    @cached_property
    def _driver(self) -> "Driver | None":
        """What drives the character's model; None where it has no rig."""
        from lipsync_lang.rigs.driver import Driver

        data, floors = self.compiled.rig, self.compiled.tables.floors
        return None if data is None else Driver.from_plain(data, self.poses, floors)

    @cached_property
    def speaker(self) -> "Speaker":
        """The language, ready to read and speak text; its character's words included."""
        from lipsync_lang.phonology.manner import Manner
        from lipsync_lang.speaking import Speaker

        return Speaker(Manner.from_plain(self.compiled.manner), self._notations, self._near)

    @cached_property
    def _notations(self) -> dict[str, Notation]:
        silence: Value = ((self.compiled.phonemes[0], 1.0),)
        near = self._near.value if self._near is not None else None
        tables = {**self.compiled.visemes, **self.compiled.notations}
        spelling, silences = self.compiled.spelling, self.compiled.silences
        return ready(tables, silences, silence, IPA, spelling, near)

    @cached_property
    def _near(self) -> "Among | None":
        from lipsync_lang.phonology.nearest import Among

        data = self.compiled.nearest
        return None if data is None else Among.from_plain(data)

    @cached_property
    def _hints(self) -> "Among | None":
        """What finds the nearest for messages alone: it is read only once something is wrong."""
        from lipsync_lang.resolver.nearest import among_shared

        return self._near or among_shared(self.compiled.phonemes[1:])

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.compiled.phonemes)}

    @cached_property
    def _recognised(self) -> "WeakKeyDictionary[Schedule, str]":
        return WeakKeyDictionary()

    def _hint(self, label: str, notation: str) -> str:
        """Say which label may be meant, what one of the IPA is nearest to, or why it is none."""
        known = self._notations[notation]
        hints = [known.suggest(label)] if known.table else []
        near = self._hints if notation == IPA else None
        found = near.nearest(label) if near is not None else None
        if found is not None and found.unknown:
            hints.append(f"no IPA: {' '.join(found.unknown)}")
        elif found is not None and found.value:
            hints.append(f"nearest by its features: {' '.join(n for n, _ in found.value)}")
        return "; ".join(hints)

    def _unknown(self, schedule: Schedule, at: list[int], notation: Notation) -> str:
        name = next(n for n, known in self._notations.items() if known is notation)
        lines = [
            f"{schedule.place(i)}: phoneme {i} ({schedule.labels[i]!r}, {schedule.times[i]:g} to "
            f"{schedule.times[i + 1]:g} s) is not in the {name} of {self.language}; "
            f"{self._hint(schedule.labels[i], name)}"
            for i in at[:8]
        ]
        more = f"\n... and {len(at) - 8} more" if len(at) > 8 else ""  # noqa: PLR2004 a screenful
        mend = (
            f"\nAdd them to {self.language}'s notations, name the notation they are in "
            "(--notation NAME), or ask for unknown labels at rest (--unknown rest)"
        )
        mend += " or by their features (--unknown nearest)" if name == IPA else ""
        return "\n".join(lines) + more + mend


def _spread(sounds: tuple[str, ...], count: int) -> list[Value]:
    """Share a word's common phonemes out over the labels it was given, in order.

    A sound that lasts over several labels is stated at the first; the others add their time to it.
    """
    cuts = [round(i * len(sounds) / count) for i in range(count + 1)]
    spread: list[Value] = []
    last = -1
    for low, high in pairwise(cuts):
        here = range(low, high) if low < high else range(min(low, len(sounds) - 1), low + 1)
        new = [n for n in here if last < n < len(sounds)]
        spread.append(tuple((sounds[n], 1 / len(new)) for n in new))
        last = max(last, *here)
    return spread
