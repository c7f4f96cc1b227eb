"""Played pairs: a compiled pair with its motion, and the parts of a performance made from both."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Self

import numpy as np

from lipsync_lang.animations.rates import checked_rate
from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.base.errors import LipsyncError, refuse_other
from lipsync_lang.faces.rigs.channel import Channel, bare
from lipsync_lang.performing.delivery import DialLevels, Points, bends_of, delivery, overlays
from lipsync_lang.performing.effort import emphasis_dial, loudness_dial, stress_dial
from lipsync_lang.performing.label_reader import LabelReader, Unknown
from lipsync_lang.pipeline.constrain import FREE
from lipsync_lang.pipeline.motion import SLOW_SPEED, Motion
from lipsync_lang.pipeline.perform import Performance, perform
from lipsync_lang.pipeline.tables import RESOLUTION, Bank, Contact, Tables
from lipsync_lang.pipeline.track import lay_track
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.text.lines.cleaning import AS_WRITTEN, Cleaning

if TYPE_CHECKING:
    from lipsync_lang.performing.label_sounds import LabelSounds
    from lipsync_lang.pipeline.bend import Bend
    from lipsync_lang.pipeline.gestures.laying import GestureSet
    from lipsync_lang.pipeline.levels import Blend, Dial
    from lipsync_lang.pipeline.overlay import Overlay
    from lipsync_lang.schedules.schedule import Schedule

OwnSettings = Mapping[str, Any]
"""Options of `Performer.perform` that are the same for all schedules, by name."""

Gaps = Literal["error", "rest"]
"""Treatments of bigrams without curves."""

COURSES = 16
"""Number of courses of a line that was heard without words, whose mean is shown."""

YIELDING = -1.0
"""Priority of a pose of a posture, below those of all poses of speech."""


class LineDelivery(NamedTuple):
    """Delivery of a schedule: its styles, dials, curve edits and keys."""

    tables: "Tables"
    blends: "tuple[Blend, ...]"
    dials: "tuple[Dial, ...]"
    overlays: "tuple[Overlay, ...]"
    bends: "tuple[Bend, ...]"
    others: "tuple[LabelSounds, ...]"
    """Courses of a line of which the sound alone was heard."""

    @classmethod
    def plain(cls, pair: "PlayedPair", asked: OwnSettings) -> Self | None:
        """Return the delivery of all plain lines; None if the call or the character states one."""
        compiled, given = pair.compiled, [one for one in asked.values() if one is not None]
        if given or compiled.word_edits or any(compiled.delivery.values()):
            return None
        return cls(compiled.tables, (), (), (), (), ())

    @classmethod
    def of(
        cls,
        pair: "PlayedPair",
        schedule: "Schedule",
        sounds: "LabelSounds",
        line: str | None,
        asked: OwnSettings,
    ) -> Self:
        """Find the delivery of a schedule; `asked` holds the options of `perform`."""
        compiled = pair.compiled
        blends, dials = delivery(compiled, schedule, line, asked["styles"], asked["dials"])
        intensity = asked["intensity"]
        if intensity is None and schedule.audio is not None:
            intensity = compiled.line_deliveries.get(line or "", {}).get("intensity")
        dials += _effort(pair, schedule, sounds, intensity)
        own: tuple[Overlay, ...] = ()
        if line is not None or compiled.word_edits:
            silent = np.ones(len(schedule), bool)
            # a label is silent only if none of its sounds is anything else
            silent[sounds.source[sounds.ids != compiled.tables.silence]] = False
            own = overlays(compiled, schedule, silent.tolist(), line)
        bends = bends_of(compiled, schedule, line, asked["bends"])
        others = tuple(pair.labels.read(schedule.weighed(COURSES)))
        return cls(pair.tables(blends), blends, dials, own, bends, others)

    def performance(self, pair: "PlayedPair", sounds: "LabelSounds", fps: float) -> Performance:
        """Lay the track, and prepare its performance."""
        own = self._asdict()
        tables, motion = own.pop("tables"), pair.styled_motion(self.blends)
        said = sounds, *self.others
        track, *others = (lay_track(*one[:3], tables, motion, self.blends) for one in said)
        return perform(tables, track, motion, fps, **{**own, "others": tuple(others)})


def _effort(
    pair: "PlayedPair", schedule: "Schedule", sounds: "LabelSounds", intensity: float | None
) -> "tuple[Dial, ...]":
    """Return the dials of stress, emphasis and loudness; empty without an effect."""
    stated, motion, labels = pair.compiled.intensity, pair.motion, pair.labels
    poses = pair.opening_poses
    stresses = labels.stresses(sounds) if motion.stress and stated else sounds.marks[:0]
    dials = [
        stress_dial(stated, schedule, stresses, motion.stress, poses),
        emphasis_dial(stated, schedule, poses),
    ]
    if schedule.audio is not None or intensity is not None:
        spoken = np.array(labels.classes(sounds, len(schedule)), str) != ""
        dials.append(loudness_dial(pair.compiled, schedule, spoken, intensity, motion, poses))
    return tuple(dial for dial in dials if dial is not None)


@dataclass(frozen=True, eq=False)
class PlayedPair:
    """A compiled pair with its motion; `Performer` adds the performance of whole lines."""

    compiled: "CompiledPair"
    motion: Motion
    unknown: Unknown = "nearest"
    """Treatment of unmapped labels: `error`, `rest`, or `nearest` (IPA only, else an error)."""
    paths: tuple[Path, ...] = ()
    """Folders and files with priority in pack searches."""
    shades: bool | None = None
    """True if shades have their own curves; None means True, except with the paper's thresholds."""
    cleaning: Cleaning = AS_WRITTEN
    """Values of placeholders in texts, and the parts of texts that are not spoken."""
    gaps: Gaps = "error"
    """Treatment of bigrams of a line that have no curves."""

    def __post_init__(self) -> None:
        if isinstance(self.compiled, str):
            pair = f'"{self.compiled}", "{self.motion}"'
            what = f"a performer is made by `ll.resolve({pair})`, not of names"
            raise LipsyncError(what)
        refuse_other("unknown", self.unknown, Unknown)
        refuse_other("gaps", self.gaps, Gaps)

    def __getstate__(self) -> dict[str, object]:
        """Pickle only the fields; cached properties are computed again after loading."""
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
        """Pose names, in column order of an animation."""
        return self.compiled.poses

    @cached_property
    def model(self) -> Path | None:
        """Model file of the character, or of its pose set."""
        return Path(self.compiled.model) if self.compiled.model is not None else None

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Channel of each pose on a model; `rigged` provides the channels of a rig."""
        return bare(self.poses, self.compiled.pose_names)

    def shown_channels(self, tables: "Tables") -> tuple[Channel, ...]:
        """Channels of the poses of speech, and of postures if the tables have them."""
        if len(tables.priority) == len(self.poses):
            return self.channels
        names = self.compiled.posture["names"]
        return (*self.channels, *bare(tuple(names), names))

    @cached_property
    def gesture_set(self) -> "GestureSet":
        """Gestures of the pose set, ready to be placed."""
        from lipsync_lang.pipeline.gestures.laying import GestureSet

        return GestureSet.from_plain(self.compiled.gestures)

    @cached_property
    def gesture_channels(self) -> tuple[Channel, ...]:
        """Channel of each pose of gestures."""
        return tuple(Channel(**fields, gesture=True) for fields in self.gesture_set.channels)

    def performance(  # noqa: PLR0913 as `perform`
        self,
        schedule: "Schedule",
        fps: float,
        *,
        line: str | None = None,
        styles: DialLevels | None = None,
        dials: DialLevels | None = None,
        intensity: float | None = None,
        bends: Mapping[str, Points] | None = None,
    ) -> Performance:
        """Prepare a performance with access to each stage; see `perform`."""
        fps = checked_rate(fps)
        asked = {"styles": styles, "dials": dials, "intensity": intensity, "bends": bends}
        (sounds,) = self.labels.read([schedule])
        said = LineDelivery.of(self, schedule, sounds, line, asked)
        return said.performance(self, sounds, fps)

    def repeated(
        self, settings: Mapping[str, Any], schedule: "Schedule", fps: float
    ) -> Performance:
        """Prepare the performance of a line again, with the options of its `perform`."""
        beside = {"gestures", "placed", "whole"}
        spoken = {name: value for name, value in settings.items() if name not in beside}
        return self.performance(schedule, fps, **spoken)

    def tables(self, blends: "Sequence[Blend]") -> "Tables":
        """Return the tables with the banks of the drafted styles in use.

        They have more poses than speech if a style has a posture of its own.
        """
        names, drafts = self.compiled.style_names, self.compiled.style_drafts
        heard = frozenset(names[one.style] for one in blends if names[one.style] in drafts)
        if not heard:
            return self.compiled.tables
        if heard not in self._drafted:
            self._drafted[heard] = with_drafts(self.compiled, heard)
        return self._drafted[heard]

    def styled_motion(self, blends: "Sequence[Blend]") -> Motion:
        """Return the motion of a line with the manner of moving of its styles."""
        names, drafts, motion = self.compiled.style_names, self.compiled.style_drafts, self.motion
        speed = softness = 1.0
        for blend in blends:
            draft, share = drafts.get(names[blend.style], {}), float(blend.share.values.max())
            speed *= 1 + share * (draft.get("speed", 1) - 1)
            softness *= 1 + share * (draft.get("softness", 1) - 1)
        if speed == softness == 1:
            return motion
        limit = min(max(motion.speed_limit * speed, SLOW_SPEED), motion.speed_limit)
        return replace(motion, speed_limit=limit, softness=motion.softness * softness)

    @cached_property
    def labels(self) -> LabelReader:
        """Label reader of the language."""
        shades = self.motion.thresholds != "paper" if self.shades is None else self.shades
        return LabelReader(self.compiled, self.unknown, self.paths, shades)

    @cached_property
    def _drafted(self) -> "dict[frozenset[str], Tables]":
        """Tables with drafted styles, by the styles in use."""
        return {}

    @cached_property
    def contact_floors(self) -> dict[str, float]:
        """Minimum weight by pose, for the poses that a contact raises."""
        floors = zip(self.poses, self.compiled.tables.floors.tolist(), strict=True)
        return {pose: floor for pose, floor in floors if floor > 0}

    @cached_property
    def opening_poses(self) -> Bools:
        """(P,) True for the poses that stress, emphasis and loudness move."""
        regions = self.compiled.intensity["regions"] if self.compiled.intensity else ()
        poses = [pose for one in regions for pose in self.compiled.regions.get(one, [])]
        return np.isin(np.arange(len(self.poses)), poses)


def with_drafts(compiled: CompiledPair, heard: Collection[str]) -> Tables:
    """Return the tables with a bank for each drafted style, in the order of `style_names`.

    It has the neutral curves, scaled and offset as the pose set states. A bigram that a bank of the
    style draws has the drawn curves instead; the posture is added to both. A bank is as large as
    the neutral one, so it is made for the first use of a style. Poses that only postures move come
    after the poses of speech, and are subject to the same stages.

    Parameters
    ----------
    heard : styles to draft; the banks of the others stay neutral, and must not be used
    """
    tables, drafts = compiled.tables, compiled.style_drafts
    poses = len(tables.priority)
    if not heard or any(any(drafts[name]["posture"][poses:]) for name in heard):
        tables = _with_postures(tables, compiled.posture)
    sounding = _sounding(compiled)
    drawn = dict(zip(compiled.style_origins, tables.styles, strict=True))
    banks = []
    for name in compiled.style_names:
        bank = drawn.get(name, tables.neutral)
        if name in heard:
            draft = drafts[name]
            scale, offset, posture = (
                np.array(draft[part], np.float32) for part in ("scale", "offset", "posture")
            )
            curves = bank.curves.copy()
            curves[:, :, :poses] *= scale
            for pose in np.flatnonzero(offset):
                # in place: the curves of a pair take some megabytes
                curves[:, :, pose] += offset[pose] * sounding
            own = list(map(int, compiled.style_origins.get(name, ())))
            curves[own] = bank.curves[own]
            curves += posture[: curves.shape[2]]
            np.clip(curves, 0, 1, out=curves)
            curves.setflags(write=False)
            bank = bank._replace(curves=curves)
        banks.append(bank)
    return replace(tables, styles=tuple(banks))


def _with_postures(tables: Tables, posture: dict[str, Any]) -> Tables:
    """Return tables with the poses of postures after those of speech."""
    together = np.array(posture["together"], float)
    count = len(together)

    def beside(array: np.ndarray[Any, Any], value: Any) -> Any:
        """Return an array whose last axis has a column more for each pose of a posture."""
        more = np.broadcast_to(np.asarray(value, array.dtype), (*array.shape[:-1], count))
        return np.concatenate((array, more), axis=-1)

    def square(rules: Floats) -> Floats:
        lower = beside(together, np.full((count, count), FREE))
        return np.vstack((beside(rules, together.T), lower))

    def bank(one: Bank) -> Bank:
        return one._replace(curves=beside(one.curves, 0))

    return replace(
        tables, curves=beside(tables.curves, 0), styles=tuple(map(bank, tables.styles)),
        contacts=tuple(
            Contact(one.phonemes, beside(one.floor, 0), beside(one.ceiling, ceiling))
            for one, ceiling in zip(tables.contacts, posture["ceilings"], strict=True)
        ),
        thresholds=square(tables.thresholds), paper=square(tables.paper),
        priority=beside(tables.priority, YIELDING), opposed=beside(tables.opposed, 0),
        softness=beside(tables.softness, posture["softness"]),
        anticipate=beside(tables.anticipate, 0), highest=beside(tables.highest, 1),
    )  # fmt: skip


def _sounding(compiled: CompiledPair) -> Floats:
    """Return the share of an offset over each bigram: (B, RESOLUTION + 1).

    It is 1 in sounds, and falls to 0 in silence.
    """
    at = np.linspace(0, 1, RESOLUTION + 1)[None, :]
    silence = compiled.phonemes[0]
    pairs = [origin.pair for origin in compiled.origins]
    boundary = compiled.tables.boundary[:, None]
    starts = np.array([first == silence for first, _ in pairs])[:, None]
    ends = np.array([second == silence for _, second in pairs])[:, None]
    # a silence is left or entered along a straight line over its own part of the bigram
    share = np.where(starts, np.minimum(at / boundary, 1), 1.0)
    share = np.where(ends, np.minimum(share, np.minimum((1 - at) / (1 - boundary), 1)), share)
    # row 0 is rest, also in a style that smiles
    share[0] = 0
    return share.astype(np.float32)
