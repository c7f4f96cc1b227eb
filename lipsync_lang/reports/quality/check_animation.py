"""Judgement of finished animations by the limits of their face, as text, JSON or JUnit XML."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.presentation.junit import JunitCase, JunitSuite, junit_text
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.performing.performer import PerformedLine, Performer, performer_of
from lipsync_lang.reports.quality.face_columns import Face
from lipsync_lang.reports.quality.figures import Figure, Quality, describe
from lipsync_lang.reports.quality.measured_scene import scene_of
from lipsync_lang.reports.quality.measures import load_measures

MAX_SUBJECT_CHARS = 60
"""Characters of the text of a line in the subject of its quality."""

BLOCK_LINES = 32
"""Lines that are judged at once: their arrays stay in the processor's cache."""

Limits = Mapping[str, float]
"""Highest acceptable values by the name of the measure."""

HEARD_REMARK = (
    "the sounds were heard, not known: the figures compare the mouth with what was heard, and "
    "cannot judge contacts that were missed or invented in hearing"
)

Qualities = Mapping[str, Quality]
"""Results by name; the first is for the judged animation, the others are for comparison."""


def check(
    animation: Animation,
    *,
    performer: Performer | None = None,
    limits: Limits | None = None,
    remarks: tuple[str, ...] = (),
) -> Quality:
    """Measure an animation and compare it with limits.

    Parameters
    ----------
    animation : animation of a performer's poses, or of its rig's channels
    performer : performer of this face; by default the one that performed the animation
    limits : limits by measure; they override those of the pose set and the character
    remarks : notes to print with the result, such as those of the reader

    Raises
    ------
    LipsyncError
        The animation has no performer and none is given, a limit is not a number
        of at least 0, or the animation is of another face.

    Examples
    --------
    >>> performer = ll.resolve("english", "facefx")
    >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]))
    >>> ll.check(animation)["contacts lips"].verdict
    'ok'
    """
    performer = performer or performer_of(animation)
    if performer is None:
        raise LipsyncError("this animation has no performer; give a performer of its face")
    (quality,) = check_all([animation], performer, limits)
    said = PerformedLine.of(animation)
    if said and animation.without_gestures() is not animation:
        from lipsync_lang.performing.gesturing import gesture_rates

        remarks = (gesture_rates(said.performer, said.settings, animation), *remarks)
    if animation.schedule is not None and animation.schedule.likely:
        remarks = (*remarks, HEARD_REMARK)
    return replace(quality, remarks=(*quality.remarks, *remarks))


def check_all(
    animations: Sequence[Animation], performer: Performer, limits: Limits | None = None
) -> list[Quality]:
    """Measure animations of one face at once: `check` takes four times as long for each."""
    measures = load_measures()
    asked = {name: one.limit for name, one in measures.items()}
    asked["speed"] = performer.motion.speed_limit
    # In order of precedence: the measure's own, the motion's, the packs', and the caller's.
    asked |= performer.compiled.checks["limits"]
    for name, value in (limits or {}).items():
        if name not in measures:
            raise LipsyncError(f"unknown measure '{name}'; {did_you_mean(name, measures)}")
        if not isfinite(value) or value < 0:
            raise LipsyncError(f"the limit of {name} is {value}; give a number of at least 0")
        asked[name] = value
    figures: list[list[Figure]] = [[] for _ in animations]
    told: tuple[str, ...] = ()
    for start in range(0, len(animations), BLOCK_LINES):
        scene = scene_of(animations[start : start + BLOCK_LINES], performer)
        told = (judged_on(scene.face, performer.model),)
        for name, one in measures.items():
            for line, found in zip(figures[start:], one.find(scene), strict=False):
                for part, amount, _, own, parts, findings, why in found:
                    most = asked[name] if own is None else own
                    whole = f"{name} {part}" if part else name
                    line.append(Figure(whole, amount, one.unit, most, parts, findings, why))
    return [
        Quality(_subject(animation, performer), tuple(own), told)
        for animation, own in zip(animations, figures, strict=True)
    ]


def judged_on(face: Face, model: Path | None) -> str:
    """Say whether a mesh was judged, or weights and why."""
    if model is None:
        return "weights were judged: this character has no model"
    if face.seen is None:
        return f"weights were judged: the mouth of {model.name} cannot be measured"
    return f"judged on the mesh of {model.name}"


def _subject(animation: Animation, performer: Performer) -> str:
    words = " ".join(word.text for word in animation.schedule.words)
    said = repr(words) if words else animation.schedule.source
    if len(said) > MAX_SUBJECT_CHARS:
        said = f"{said[: MAX_SUBJECT_CHARS - 3]}..."
    return f"{performer.language} on {performer.character}, {animation.fps:g} fps: {said}"


def as_text(qualities: Qualities) -> str:
    """Return the first result in full, then a table of all results if there are several."""
    first, *others = qualities.values()
    if not others:
        return str(first)
    names = list(dict.fromkeys(f.name for one in qualities.values() for f in one.figures))
    known = [{figure.name: figure for figure in one.figures} for one in qualities.values()]
    rows = [["", *qualities]]
    rows += [[name, *(_cell(one.get(name)) for one in known)] for name in names]
    return "\n".join([str(first), "", *columns(rows)])


def _cell(figure: Figure | None) -> str:
    if figure is None or figure.value is None:
        return "-"
    return f"{figure.value:.3g}{'' if figure.passed else ' FAIL'}"


def as_json(qualities: Qualities) -> str:
    """Return all results by name as JSON."""
    data = {name: quality.to_dict() for name, quality in qualities.items()}
    return json.dumps(data, ensure_ascii=True, indent=2)


def as_junit(qualities: Qualities) -> str:
    """Return a test suite for each result, with a case for each figure."""
    suites = [
        JunitSuite(name, [_case(quality.subject, figure) for figure in quality.figures])
        for name, quality in qualities.items()
    ]
    return junit_text(suites, counts=("tests", "failures", "skipped"))


def _case(subject: str, figure: Figure) -> JunitCase:
    if figure.verdict == "-":
        return JunitCase(subject, figure.name, "skipped", describe(figure))
    if figure.passed:
        return JunitCase(subject, figure.name)
    findings = "\n".join(f"{one.at:.3f} s: {one.what}" for one in figure.findings)
    return JunitCase(subject, figure.name, "failure", describe(figure), findings)


FORMATS: dict[str, Callable[[Qualities], str]] = {
    "text": as_text,
    "json": as_json,
    "junit": as_junit,
}
"""Output formats by name."""
