"""Take of a page: schedule, curves, stages and explanations of values, as JSON with arrays.

Conventions: T frames of the animation, P poses; stages are (P, T).
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.base.presentation.wording import short_place
from lipsync_lang.performing import gesturing
from lipsync_lang.performing.performer import PerformedLine, Performer
from lipsync_lang.performing.trace import STAGE_WORDS, VISIBLE, constraint_reason, held_reason
from lipsync_lang.pipeline.perform import Performance, Stage
from lipsync_lang.pipeline.warp import locate
from lipsync_lang.render.plot import STAGES
from lipsync_lang.reports.quality.figures import Quality
from lipsync_lang.reports.quality.measures import sentence
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.studio.array_pack import ArrayPack

WEIGHT_STEPS = 65535
"""Number of steps of a weight from 0 to 1."""

HATCHES = {name: number for number, name in enumerate(STAGES)}
"""Number of each stage; a page draws a pattern for it."""

NO_POSITION = WEIGHT_STEPS
"""Position in a bigram for frames outside it."""


def take_data(
    animation: Animation,
    performer: Performer | None,
    pack: ArrayPack,
    quality: Quality | None = None,
) -> Json:
    """Return an animation as JSON data, with its arrays in a pack.

    `performer` is that of this face, for stages and explanations of its own animation; `quality`
    are figures of the animation, for the timeline.
    """
    made, schedule = _Stages.of(animation), animation.schedule
    data: Json = {
        "fps": animation.fps,
        "start": round(float(animation.times[0]), 6),
        "count": len(animation),
        **curves_data(animation, pack),
        "measures": {} if performer is None else performer.compiled.measures,
        "spoken": {
            "title": " ".join(word.text for word in schedule.words),
            "estimated": schedule.estimated,
            "times": [round(float(time), 5) for time in schedule.times],
            "labels": list(schedule.labels),
            "words": [[word.text, word.first, word.stop] for word in schedule.words],
            "emphasis": [word.emphasis for word in schedule.words],
            "left_out": list(schedule.left_out),
            "doubts": {
                number: round(word.confidence, 2)
                for number, word in enumerate(schedule.words)
                if word.confidence is not None and word.confidence < DOUBTFUL
            },
        },
        "figures": [] if quality is None else figures_data(quality),
    }
    if performer is not None:
        data |= {"language": performer.language, "character": performer.character}
        shown = set(animation.poses)
        pairs = performer.compiled.mirrored.items()
        data["mirrored"] = {both: sides for both, sides in pairs if shown.issuperset(sides)}
    if made is not None:
        data["making"] = made.data(pack)
    return data


def curves_data(animation: Animation, pack: ArrayPack) -> Json:
    """Return the names of an animation's columns, their ranges, and their scaled values."""
    ranges = (
        (min(0.0, float(one.min())), max(1.0, float(one.max()))) for one in animation.weights.T
    )
    rows = [
        {
            "low": low,
            "high": high,
            "moves": bool(np.ptp(curve) > VISIBLE),
            "values": pack.add((curve - low) / (high - low), "u2", WEIGHT_STEPS),
        }
        for curve, (low, high) in zip(animation.weights.T, ranges, strict=True)
    ]
    return {"poses": list(animation.poses), "curves": rows}


def figures_data(quality: Quality) -> list[Json]:
    """Return figures with their verdicts and findings, for the timeline."""
    return [
        {
            "name": one.name,
            "verdict": one.verdict,
            "told": sentence(one),
            "findings": [[round(float(f.at), 4), f.what] for f in one.findings],
        }
        for one in quality.figures
    ]


class _Stages:
    """The stages of a performance on the frames of its animation."""

    def __init__(
        self, animation: Animation, performer: Performer, performance: Performance
    ) -> None:
        self._performer, self._performance = performer, performance
        frames = performance.frames
        first = round((float(animation.times[0]) - float(frames.times(0, 1)[0])) * frames.fps)
        self._first, self._stop = max(0, first), min(frames.count, max(0, first) + len(animation))
        begin, stop = 0, frames.count
        if not performance.far:
            begin = max(0, self._first - performance.halo())
            stop = min(frames.count, self._stop + performance.halo())
        own = slice(self._first - begin, self._stop - begin)
        self.times = frames.times(self._first, self._stop)
        self.stages = [Stage(n, c[:, own]) for n, c in performance.stages(begin, stop)]

    @classmethod
    def of(cls, animation: Animation) -> "_Stages | None":
        """Repeat the performance of an animation; None for an animation of another program."""
        line = PerformedLine.of(animation)
        if line is None:
            return None
        try:
            return cls(animation, line.performer, line.performance(animation))
        except LipsyncError:
            return None

    def data(self, pack: ArrayPack) -> Json:
        """Return the stages, bigrams and reasons as JSON data."""
        poses = self._performer.poses
        place = locate(self._performance.track, self.times)
        ending, beginning = self._performance.bigrams(place, self.times)
        tops = np.max([np.abs(s.curves).max(axis=1, initial=0) for s in self.stages], axis=0)
        moving = np.flatnonzero(tops > VISIBLE)
        track = self._performance.track
        pairs = np.column_stack((track.rows, track.ids[:-1], track.ids[1:]))
        bigrams, said = np.unique(pairs, axis=0, return_inverse=True)
        return {
            "poses": list(poses),
            "moving": moving.tolist(),
            "common": [self._performer.compiled.phonemes[number] for number in track.ids],
            "source": track.source.tolist(),
            "bounds": [round(float(time), 5) for time in track.bounds],
            "stages": list(self._stages(moving, pack)),
            "phoneme": pack.add(place.phoneme, "u2"),
            "places": [pack.add(one, "u2", WEIGHT_STEPS) for one in self._places(place)],
            "bigrams": [self._bigram(*one) for one in bigrams.tolist()],
            "said": said.tolist(),
            "given": [[pack.add(side[:, p], "u2", WEIGHT_STEPS) for p in moving]
                      for side in (ending, beginning)],
            "dials": [
                {
                    "name": dial.name,
                    "poses": np.flatnonzero(dial.poses).tolist(),
                    "level": pack.add(dial.level.at(self.times), "f4"),
                }
                for dial in self._performance.dials
            ],
        }  # fmt: skip

    def _stages(self, moving: Any, pack: ArrayPack) -> Iterator[Json]:
        """Yield each stage; curves are None for poses that it does not change."""
        before = np.zeros_like(self.stages[0].curves)
        for stage in self.stages:
            changed = np.abs(stage.curves - before) > VISIBLE
            label, colour = STAGES.get(stage.name, (stage.name, "#777777"))
            yield {
                "name": stage.name,
                "label": label,
                "colour": colour,
                "hatch": HATCHES.get(stage.name, 0),
                "why": STAGE_WORDS.get(stage.name, {}).get("effect", ""),
                "curves": [
                    pack.add(stage.curves[pose], "u2", WEIGHT_STEPS)
                    if changed[pose].any()
                    else None
                    for pose in moving
                ],
                "reasons": [list(self._reasons(stage, pose, changed[pose])) for pose in moving],
            }
            before = stage.curves

    def _reasons(self, stage: Stage, pose: int, changed: Any) -> Iterator[tuple[int, int, str]]:
        """Yield runs of frames with the same reason: first frame, frame after the last, text."""
        if stage.name not in {"hold", "constrain"}:
            return
        told, begin, end = "", -1, -1
        holding = [frames[self._first :] for _, frames in self._performance.held]
        known: dict[tuple[bool, ...], str] = {}
        for frame in np.flatnonzero(changed).tolist():
            if stage.name == "hold":
                held = tuple(frames[frame] for frames in holding)  # the same contacts, one reason
                if held not in known:
                    at = self._first + frame
                    known[held] = held_reason(self._performer, self._performance, pose, at)
                text = known[held]
            else:
                weights = stage.curves[:, frame]
                text = constraint_reason(self._performer, self._performance, pose, weights)
            if text != told or frame != end:
                if told:
                    yield begin, end, told
                told, begin = text, frame
            end = frame + 1
        if told:
            yield begin, end, told

    def _places(self, place: Any) -> tuple[Floats, Floats]:
        """Return each frame's position in the ending bigram and in the beginning one."""
        track = self._performance.track
        boundary = track.boundary(self._performer.compiled.tables.neutral)
        at, last = place.phoneme, len(track.rows)
        absent = NO_POSITION / WEIGHT_STEPS
        if not last:
            return np.full(len(at), absent), np.full(len(at), absent)
        pin = boundary[np.maximum(at - 1, 0)]
        coming = np.where((at > 0) & (place.coming <= 1), pin + (1 - pin) * place.coming, absent)
        begins = (at < last) & (place.going >= 0)
        going = np.where(begins, boundary[np.minimum(at, last - 1)] * place.going, absent)
        almost = (WEIGHT_STEPS - 1) / WEIGHT_STEPS  # the end of a bigram is no absence
        found = (coming, going)
        coming, going = (np.where(at < absent, np.minimum(at, almost), absent) for at in found)
        return coming, going

    def _bigram(self, row: int, first: int, second: int) -> Json:
        compiled = self._performer.compiled
        origin, pair = compiled.origins[row], (compiled.phonemes[first], compiled.phonemes[second])
        data: Json = {
            "pair": "-".join(pair),
            "layer": origin.layer,
            "status": origin.status,
            "from": [short_place(place) for place in origin.places],
        }
        if origin.word:
            data["word"] = origin.word
        if origin.triple is not None:
            data["trigram"] = origin.name
        elif origin.pair != pair and origin.layer != "gap":
            data["drawn_as"] = "-".join(origin.pair)
        return data


def gesture_data(animation: Animation) -> Json | None:
    """Return the gestures of an animation as JSON data; None if it has no columns for them.

    `kinds` are those that are on. `hand` is the number of a gesture that a person placed, among the
    `placed` of the line, and -1 for one that came by rule. `first` is the number in the line of the
    first word shown.
    """
    said = PerformedLine.of(animation)
    if said is None:
        return None
    performer, settings = said.performer, said.settings
    scales = gesturing.scales_of(performer.compiled, settings["gestures"], settings["line"])
    if scales is None:
        return None
    own, part = performer.gesture_set, animation.schedule
    whole = settings["whole"] or part
    hands = gesturing.placed_by_hand(performer, whole, settings["line"], settings["placed"])
    places = {(one.number, one.fact): n for n, one in enumerate(hands)}
    laid = gesturing.laid_gestures(said.performer, said.settings, animation)[1]
    rows = [
        {
            "name": own.shapes[placed.number].name,
            "at": round(placed.fact, 5),
            "begin": round(float(animation.times[one.first]), 5),
            "scale": round(placed.height / scales[placed.number], 3),
            "why": gesturing.told_gesture(own, one, animation),
            "hand": places[placed.number, placed.fact]
            if placed.trigger == gesturing.BY_HAND
            else -1,
        }
        for one, placed in ((one, one.gesture) for one in laid)
    ]
    kinds = [
        {"name": one.name, "lead": one.lead, "seconds": one.seconds, "room": one.room}
        for one, scale in zip(own.shapes, scales, strict=True)
        if scale
    ]
    # A long line is shown in parts, and gestures by hand name words of the whole line.
    first = sum(word.start < part.start for word in whole.words)
    return {"poses": list(own.poses), "kinds": kinds, "rows": rows, "first": first}
