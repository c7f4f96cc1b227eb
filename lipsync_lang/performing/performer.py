"""Performer: a resolved language-character pair that animates schedules."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.rates import checked_rate
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import LipsyncError, PackError, count, shortlist
from lipsync_lang.packs.finding import IPA
from lipsync_lang.performing.delivery import (
    DialLevels,
    Points,
    corrected,
    delivery,
    with_expression,
)
from lipsync_lang.performing.played_pair import LineDelivery, OwnSettings, PlayedPair, with_drafts
from lipsync_lang.pipeline.drive import drive
from lipsync_lang.pipeline.kernel_plan import KernelCopy, keep, serves
from lipsync_lang.pipeline.perform import Performance
from lipsync_lang.pipeline.prepare import prepare
from lipsync_lang.pipeline.track import Track, lay_track
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.text.phonology.labels import Notation

if TYPE_CHECKING:
    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.faces.rigs.driver import Driver
    from lipsync_lang.performing.gesturing import GestureScales
    from lipsync_lang.performing.label_sounds import LabelSounds
    from lipsync_lang.performing.stream import Late, Stream
    from lipsync_lang.resolver.compiled import Report
    from lipsync_lang.sound.listening.listener import Listener
    from lipsync_lang.sound.speech.speaking.speaker import Speaker
    from lipsync_lang.text.phonology.nearest import Nearest


@dataclass(frozen=True, eq=False)
class Performer(PlayedPair):
    """A resolved language-character pair, ready to perform schedules."""

    def __repr__(self) -> str:
        """Summarise the performer in one line."""
        counts = f"{len(self.report.phonemes)} common phonemes, {len(self.poses)} poses"
        return f"<Performer {self.language} on {self.character}: {counts}>"

    def _repr_html_(self) -> str:
        """Show the report in notebooks."""
        from html import escape

        return f"<pre>{escape(str(self.report))}</pre>"

    @property
    def report(self) -> "Report":
        """Origin of every bigram of this pair, by layer."""
        return self.compiled.report

    def with_motion(self, change: Mapping[str, object] | str | None) -> Self:
        """Return a copy with changed motion settings."""
        from lipsync_lang.resolver.settings import motion_with

        return replace(self, motion=motion_with(self.motion, change))

    def perform(  # noqa: PLR0913 the schedule, and all settings of its delivery
        self,
        schedule: Schedule,
        fps: float = 60,
        *,
        line: str | None = None,
        styles: DialLevels | None = None,
        dials: DialLevels | None = None,
        intensity: float | None = None,
        gestures: "GestureScales | None" = None,
        placed: Sequence[Mapping[str, Any]] | None = None,
        whole: Schedule | None = None,
        bends: Mapping[str, Points] | None = None,
    ) -> Animation:
        """Animate a schedule.

        Parameters
        ----------
        schedule : timed phonemes in any notation of the language
        fps : output frames per second, from 1 to 1000; 23.976 and 29.97 stand for their fractions
        line : name of a line that has edits or settings in the character
        styles : share of each style over neutral, from 0 to 1
        dials : level of each region: 0 for no movement, 1 for normal, 2 for twice as far; shares
            and levels may also be points of seconds and value
        intensity : effect of loudness on movement, on top of the dials: 0 for none, 1 for the
            setting of the pose set, at most 2; the schedule needs audio. None stands for the
            motion's `loudness` if there is audio
        gestures : blinks, raised brows and nods of the pose set: ``all``, a text such as
            ``blink,accent:0.5``, or factors by name; each of their poses is a further column.
            None for no gestures
        placed : gestures placed by hand instead of those of the line, as in a character's file:
            ``[{"gesture": "nod", "word": 2, "scale": 0.5}]``
        whole : the line of which the schedule is a part, whose gestures the part has; its words
            count in `placed`. None if the schedule is a whole line
        bends : keys that are added to poses, such as ``{"jaw": [(0.4, 0.2)]}``: seconds and an
            amount from -1 to 1. It runs smoothly from key to key, and fades within 0.12 s at the
            ends. Constraints and limits hold

        Raises
        ------
        ScheduleError
            A label is in no notation of the language.
        LipsyncError
            A style, region, gesture or line is unknown; or `intensity` is set, but the schedule
            has no audio or the pose set names no region for loudness.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]), fps=24)
        >>> animation.weights.shape == (len(animation), len(performer.poses))
        True
        """
        return self.perform_many(
            [schedule], fps, lines=[line], styles=styles, dials=dials, intensity=intensity,
            gestures=gestures, placed=placed, whole=whole, bends=bends,
        )[0]  # fmt: skip

    def perform_many(  # noqa: PLR0913 as `perform`
        self,
        schedules: Iterable[Schedule],
        fps: float = 60,
        *,
        lines: Sequence[str | None] | None = None,
        styles: DialLevels | None = None,
        dials: DialLevels | None = None,
        intensity: float | None = None,
        gestures: "GestureScales | None" = None,
        placed: Sequence[Mapping[str, Any]] | None = None,
        whole: Schedule | None = None,
        bends: Mapping[str, Points] | None = None,
    ) -> list[Animation]:
        """Animate many schedules; each animation equals that of `perform` bit by bit.

        Batches of some hundreds keep memory low.

        Parameters
        ----------
        schedules : timed phonemes of each line
        lines : name of the line of each schedule, for its edits and settings; None for no line
        fps, styles, dials, intensity, gestures, placed, whole, bends : as in `perform`, the same
            for all

        Raises
        ------
        LipsyncError
            As in `perform`, for the first faulty schedule.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> one, other = (ll.Schedule(labels, [0, 0.1, 0.3]) for labels in ("MA", "BI"))
        >>> [len(animation) for animation in performer.perform_many([one, other], fps=24)]
        [13, 13]
        """
        asked = {
            "styles": styles, "dials": dials, "intensity": intensity, "gestures": gestures,
            "placed": placed, "whole": whole, "bends": bends,
        }  # fmt: skip
        return _animate(self, tuple(schedules), fps, lines, asked)

    def stream(  # noqa: PLR0913 as `perform`
        self,
        fps: float = 60,
        *,
        notation: str | None = None,
        styles: DialLevels | None = None,
        dials: DialLevels | None = None,
        stress: bool | None = None,
        emphasis: bool = False,
        late: "Late" = "refuse",
        gestures: "GestureScales | None" = None,
    ) -> "Stream":
        """Open a stream, which takes phonemes as they become known and returns final frames.

        The frames equal those of `perform` for the whole schedule. Loudness, lines and the rig of
        a model need the whole schedule, so a stream has none of them.

        Parameters
        ----------
        fps : output frames per second, as in `perform`
        notation : notation of single labels; None for the notation of the language's texts. A
            stream cannot recognise the notation, since most labels are still unknown
        styles, dials : as in `perform`
        stress : True if vowels without a mark are unstressed, as in a line with some marks; False
            to ignore marks, which saves the look-ahead to the next vowel; None if a mark tells,
            as in `perform`. Vowels in frames that were returned before the first mark keep the
            level 1, so give True if single labels may begin without one
        emphasis : True if some words may have emphasis
        late : `refuse` a phoneme that starts before the known time ends, or `shorten` it
        gestures : as in `perform` for a schedule without sound; `Stream.delays` has their delay,
            which is shorter if `Stream.ends_at` states the end of the line

        Raises
        ------
        LipsyncError
            A setting of motion looks at the whole line, or an argument is out of range.

        Examples
        --------
        >>> stream = ll.resolve("english", "facefx").stream(60, notation="arpabet")
        >>> round(stream.delay, 3)
        0.617
        """
        from lipsync_lang.performing.stream import Stream

        refuse_gaps(self)
        return Stream(
            self, checked_rate(fps), notation=notation, styles=styles, dials=dials, stress=stress,
            emphasis=emphasis, late=late, gestures=gestures,
        )  # fmt: skip

    def listen(
        self,
        rate: int = 16_000,
        delay: float = 0.08,
        fps: float = 60,
        *,
        poses: Sequence[str] | None = None,
    ) -> "Listener":
        """Open a listener, which takes sound as it arrives and returns final frames.

        It needs no text. A voice in any language moves the lips, by the sounds of this language
        that are most like those heard.

        Parameters
        ----------
        rate : samples per second of the sound
        delay : seconds of sound after a frame that are awaited; more make the lips more exact
        fps : output frames per second, as in `perform`
        poses : columns of the frames, as those of a stream with a style; postures of styles are
            not heard, and stay 0. None for the poses of speech

        Raises
        ------
        LipsyncError
            The acoustic model is not installed, or an argument is out of range.

        Examples
        --------
        >>> listener = ll.resolve("english", "facefx").listen(delay=0.08)
        >>> times, weights = listener.push(np.zeros(1600, np.int16))
        >>> round(float(weights.max()), 2)
        0.0
        """
        from lipsync_lang.sound.listening.listener import open_listener

        refuse_gaps(self)
        tables, motion, labels = self.compiled.tables, self.motion, self.labels
        return open_listener(
            tables.papers if motion.thresholds == "paper" else tables, motion,
            self.poses if poses is None else tuple(poses), labels.notations.get(IPA),
            self.compiled.numbers(shades=labels.shades), rate=rate, delay=delay,
            fps=checked_rate(fps),
        )  # fmt: skip

    def rigged(self, animation: Animation) -> Animation:
        """Convert an animation of poses to an animation of the model's rig channels.

        Times do not change. Bone values are degrees or units of length. Without a rig, or for an
        animation already rigged, the result is the input.

        Raises
        ------
        LipsyncError
            The animation has different poses.
        """
        driver, count = self.driver, len(self.poses)
        if driver is None or animation.channels[: len(driver.channels)] == driver.channels:
            return animation
        if animation.poses[:count] != self.poses:
            raise LipsyncError(
                f"the rig of {self.character} needs the poses of {self.character}; "
                "this animation has others"
            )
        spoken = np.ascontiguousarray(animation.weights[:, :count])
        values = driver.driven(spoken, self.motion, animation.fps)
        names = (*(channel.name for channel in driver.channels), *animation.poses[count:])
        if len(animation.poses) > count:  # shapes that speech does not move go to the model as such
            values = np.hstack([values, animation.weights[:, count:]])
        return replace(
            animation, poses=names, weights=values, model=self.model, contacts={},
            channels=(*driver.channels, *animation.channels[count:]),
        )  # fmt: skip

    def held_channels(self, weights: Floats) -> Floats:
        """Return the channels (T, C) of the model for poses (T, P), each row as a held pose.

        Without a rig, the channels are the poses.
        """
        driver = self.driver
        if driver is None:
            return weights
        rows = [drive(row[None], driver.rig, 1.0) for row in weights]
        return np.vstack(rows) if rows else np.zeros((0, len(driver.channels)))

    def with_expression(self, animation: Animation, expression: DialLevels) -> Animation:
        """Add an expression to an animation of this performer; speech takes precedence.

        Contacts and constraints still hold: an expression adds only as much as they allow. Shapes
        that speech does not move become additional columns.

        Parameters
        ----------
        animation : poses, before `rigged`
        expression : weight of each shape from 0 to 1, or points of seconds and weight

        Raises
        ------
        LipsyncError
            A weight is out of range, or the animation has other poses.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> spoken = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]))
        >>> smiling = performer.with_expression(spoken, {"wide": 0.3, "browUp": 0.5})
        >>> smiling.poses[-1], bool((smiling["wide"] >= spoken["wide"]).all())
        ('browUp', True)
        """
        if animation.poses[: len(self.poses)] != self.poses:
            raise LipsyncError(
                "an expression adds to poses; add it before you convert them to the channels of a "
                "rig"
            )
        tables = self.compiled.tables
        postures = animation.poses[len(self.poses) :][: len(self.compiled.posture["names"])]
        if postures and postures == tuple(self.compiled.posture["names"]):
            tables = with_drafts(self.compiled, ())
        papers = self.motion.thresholds == "paper"
        return with_expression(animation, tables.papers if papers else tables, expression)

    def track(
        self, schedule: Schedule, *, line: str | None = None, styles: DialLevels | None = None
    ) -> Track:
        """Lay out the phonemes of a schedule as `perform` does, without rendering frames."""
        ids, times, source = self.common_phonemes(schedule)
        blends, _ = delivery(self.compiled, schedule, line, styles, None)
        return lay_track(ids, times, source, self.tables(blends), self.motion, blends)

    def explain(self, animation: Animation, seconds: float) -> "Explanation":
        """Explain the weight of each pose at a time in an animation of this performer."""
        return animation.explain(seconds)

    def common_phonemes(self, schedule: Schedule) -> tuple[Ints, Floats, Ints]:
        """Map the labels of a schedule to (m,) indices in `compiled.phonemes`.

        The others are (m + 1,) boundaries in seconds, and (m,) indices of the labels.
        """
        return self.labels.read([schedule])[0][:3]

    def automatic(self, schedule: Schedule) -> "dict[str, Nearest]":
        """Return the labels mapped only by features; see `LabelReader.automatic`."""
        return self.labels.automatic(schedule)

    def notation(self, schedule: Schedule) -> Notation:
        """Return the notation of the schedule: as stated, or the most likely one."""
        return self.labels.notation(schedule)

    @cached_property
    def speaker(self) -> "Speaker":
        """Text-to-speech of the language, with the pronunciations of the character."""
        from lipsync_lang.sound.speech.speaking.speaker import Speaker
        from lipsync_lang.text.phonology.manner import Manner

        manner, labels = Manner.from_plain(self.compiled.manner), self.labels
        return Speaker(manner, labels.notations, labels.near, cleaning=self.cleaning)

    @cached_property
    def driver(self) -> "Driver | None":
        """Driver of the character's model; None without a rig."""
        if self.compiled.rig is None:
            return None
        from lipsync_lang.faces.rigs.driver import Driver

        return Driver.from_plain(self.compiled.rig, self.poses, self.compiled.tables.floors)


class PerformedLine(NamedTuple):
    """Source of an animation that a performer made: it can be repeated, and explained.

    Parameters
    ----------
    performer : the performer that made the animation
    settings : options of `Performer.perform`: line name, styles, dials, intensity and gestures
    """

    performer: Performer
    settings: Mapping[str, Any]

    @classmethod
    def of(cls, animation: Animation) -> Self | None:
        """Return the performed line of an animation; None for curves of another program."""
        return animation.source if isinstance(animation.source, cls) else None

    def performance(self, animation: Animation) -> Performance:
        """Repeat the performance of an animation, with access to each stage."""
        return self.performer.repeated(self.settings, animation.schedule, animation.fps)

    def explain(self, animation: Animation, seconds: float) -> "Explanation":
        """Explain the weight of each pose at a time."""
        from lipsync_lang.performing.trace import explain

        return explain(self.performer, self.settings, animation, seconds)


def performer_of(animation: Animation) -> Performer | None:
    """Return the performer that made an animation; None for curves of another program."""
    line = PerformedLine.of(animation)
    return line.performer if line else None


def _animate(
    performer: "Performer",
    schedules: Sequence[Schedule],
    fps: float,
    lines: Sequence[str | None] | None,
    asked: OwnSettings,
) -> list[Animation]:
    """Animate schedules; see `Performer.perform_many`."""
    fps, compiled = checked_rate(fps), performer.compiled
    schedules, names = _stated(performer, schedules, lines)
    read = performer.labels.read(schedules) if schedules else []
    kept, common = _neutral_copy(performer, fps), LineDelivery.plain(performer, asked)
    gaps, model, floors = compiled.report.gaps, performer.model, performer.contact_floors
    moving = asked.get("gestures")
    if moving:
        from lipsync_lang.performing import gesturing
    sources = {line: PerformedLine(performer, {"line": line, **asked}) for line in {*names}}
    out, tables = [], None
    for asked_for, sounds, line in zip(schedules, read, names, strict=True):
        schedule = without_gaps(performer, asked_for, sounds) if gaps else asked_for
        stated = schedule.words or schedule.likely or sounds.marks.size
        plain = common if line is None and schedule.audio is None and not stated else None
        said = plain or LineDelivery.of(performer, schedule, sounds, line, asked)
        if kept is not None and not (said.blends or said.overlays or said.bends or said.others):
            times, weights = kept.utter(sounds.ids, sounds.times, said.dials)
        else:
            made = said.performance(performer, sounds, fps)
            times, weights = made.frames.times(), made.weights()
        if said.tables is not tables:
            tables, shown = said.tables, performer.shown_channels(said.tables)
            names_shown = (*performer.poses, *(one.name for one in shown[len(performer.poses) :]))
        poses, channels = names_shown, shown
        scales = gesturing.scales_of(performer.compiled, moving, line) if moving else None
        if scales is not None:
            line_at = performer, schedule, times, fps
            curves, _ = gesturing.gesture_curves(*line_at, scales, sources[line].settings)
            weights = np.concatenate((weights, curves), axis=1)
            poses += performer.gesture_set.poses
            channels += performer.gesture_channels
        out.append(Animation.filled(
            times=times, poses=poses, weights=weights, fps=fps, schedule=schedule,
            source=sources[line], channels=channels, model=model,
            neutral=compiled.neutral, contacts=dict(floors),
        ))  # fmt: skip
    return out


def _stated(
    performer: "Performer", schedules: Sequence[Schedule], lines: Sequence[str | None] | None
) -> tuple[Sequence[Schedule], Sequence[str | None]]:
    """Return schedules as the project corrects them, with the names of their lines."""
    names = [None] * len(schedules) if lines is None else lines
    if len(names) != len(schedules):
        what = f"{len(names)} lines for {len(schedules)} schedules"
        raise LipsyncError(f"{what}; give one line per schedule")
    compiled = performer.compiled
    if compiled.line_deliveries:
        schedules = [
            corrected(compiled.line_deliveries.get(line or "", {}), compiled, schedule, line)
            for schedule, line in zip(schedules, names, strict=True)
        ]
    return schedules, names


def _neutral_copy(performer: "Performer", fps: float) -> KernelCopy | None:
    """Return the neutral bank as the compiled kernel keeps it; None if the kernel cannot play it.

    `lay_track` lays the tracks of a bank with trigrams. The copy of the last frame rate is cached.
    """
    tables, motion = performer.compiled.tables, performer.motion
    if not serves(motion) or len(tables.trigrams):
        return None
    known: tuple[float, KernelCopy] | None = vars(performer).get("_kept")
    if known is None or known[0] != fps:
        shown = tables.papers if motion.thresholds == "paper" else tables
        copy = keep(shown, motion, prepare(shown, motion, fps), fps)
        known = vars(performer)["_kept"] = fps, copy
    return known[1]


def without_gaps(pair: PlayedPair, schedule: Schedule, sounds: "LabelSounds") -> Schedule:
    """Return a schedule whose bigrams have curves, or with a remark on those at rest.

    Only the line's own bigrams count: a set drawn for one sentence says it (paper, 5.3).
    Raises PackError if some have none, and gaps are errors.
    """
    compiled = pair.compiled
    track = lay_track(*sounds[:3], pair.tables(()), pair.motion)
    silent = track.ids == compiled.tables.silence
    # all gaps share the row of rest, so that the phonemes tell them apart
    at = (~(silent[1:] | silent[:-1]) & (track.rows == 0)).nonzero()[0]
    names = [compiled.phonemes[one] for one in track.ids.tolist()]
    parents = [compiled.shades.get(name, name) for name in names]
    missing = list(dict.fromkeys(f"{parents[n]}-{parents[n + 1]}" for n in at.tolist()))
    if not missing:
        return schedule
    if pair.gaps == "error":
        raise gap_error(pair, missing, "this line")
    told = f"{count(len(missing), 'bigram')} without curves at rest: {', '.join(missing)}"
    return replace(schedule, remarks=(*schedule.remarks, told))


def refuse_gaps(pair: PlayedPair) -> None:
    """Raise PackError for a pair with gaps, if they are errors and no line is known yet."""
    missing = pair.compiled.report.gaps
    if missing and pair.gaps == "error":
        raise gap_error(pair, missing, pair.compiled.report.language)


def gap_error(pair: PlayedPair, missing: Sequence[str], of: str) -> PackError:
    """Return the error that names bigrams without curves."""
    report = pair.compiled.report
    return PackError(
        f"{report.character} has no curves for {count(len(missing), 'bigram')} of {of}: "
        f"{shortlist(missing)}. Draw them, give {report.poseset} targets for their "
        "phonemes, or perform gaps as rest (`gaps='rest'`)"
    )
