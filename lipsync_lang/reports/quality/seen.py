"""Measures of the mouth as a viewer sees it, on the mesh of the model, beside filmed lips.

Conventions: lengths are in widths of the closed mouth, and are what the shapes of the model add to
the face at rest. `languages/common.yaml` states the mouths of sounds in film, which the `reach` of
the character scales. They come from 170 sentences of a speaker of the GRID corpus (Cooke, Barker,
Cunningham and Shao, 2006) and from the lips of six actors, who open twice as far as he does.
"""

from collections.abc import Callable, Iterator
from functools import partial, wraps
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.reports.quality.curve_statistics import percentile
from lipsync_lang.reports.quality.face_columns import SeenMouth
from lipsync_lang.reports.quality.figures import Figure
from lipsync_lang.reports.quality.likeness import LEAST_SOUNDS, LEAST_SPEECH_SECONDS
from lipsync_lang.reports.quality.measured_scene import MeasuredScene
from lipsync_lang.reports.quality.measures import Find, measure, once, one, places, unjudged

SLIT = 0.06
"""Aperture of lips that a viewer sees apart: 3 mm of a human mouth."""

FLAP = 0.1
"""Aperture of a consonant, past that of filmed lips at reach 1, that a viewer sees as a flap."""

SLIT_SHARE = 0.4
"""Aperture of rounded lips that a viewer sees as shut, as a share of that in film."""

MUMBLING = 1.3
"""Factor of the times by which a mouth opens less far than in film: people differ less there."""

NO_MOVEMENT = 0.01
"""Opening or narrowing of a mouth that never does, so that it can be divided by."""

WEAK_ROUNDING = 2.6
"""Times by which rounded lips narrow less than in film that a viewer sees as hardly round."""


class _MeshMouth(NamedTuple):
    """The mouth of all lines."""

    seen: SeenMouth
    aperture: Floats
    """(T,) at least 0: lips do not pass each other."""
    width: Floats
    """(T,)"""
    filmed: Floats
    """(n,) aperture of each phoneme in film; NaN if none is stated."""
    middle: Floats
    """(n,) aperture in the middle of each phoneme."""


Figures = Iterator[list[Figure]]

FindSeen = Callable[[MeasuredScene, _MeshMouth, list[int]], Figures]
"""Function of a scene, its mouth, and the lines that are judged; it yields the figures of each."""


@once
def _mouth(scene: MeasuredScene) -> _MeshMouth | str:
    """Return the mouth, or the reason why it is not judged."""
    seen = scene.face.seen
    if seen is None:
        return "the mouth is not measured on a mesh"
    if scene.motion.hold > 0:
        return "poses are shown one at a time"
    aperture, width = seen.gains[:2] @ scene.curves
    aperture, filmed = np.maximum(0.0, aperture), seen.apertures[scene.ids]
    # The middle of a last sound may lie behind the last frame.
    last = scene.frames[scene.line + 1] - 1
    middles = np.minimum(scene.frame_at(scene.line, (scene.begin + scene.end) / 2), last)
    return _MeshMouth(seen, aperture, width, filmed, aperture[middles])


def _on_mesh(seconds: float = 0.0) -> Callable[[FindSeen], Find]:
    """Judge the mouth on the mesh alone, and only lines with so many seconds of speech."""

    def judged(find: FindSeen) -> Find:
        @wraps(find)
        def figures(scene: MeasuredScene) -> list[list[Figure]]:
            mouth = _mouth(scene)
            if isinstance(mouth, str):
                return [unjudged(mouth) for _ in scene.spans]
            every = [*enumerate(zip(scene.seconds, scene.spoken, strict=True))]
            lines = [line for line, (length, spoken) in every if spoken and length >= seconds]
            found = dict(zip(lines, find(scene, mouth, lines), strict=True))
            few = f"s of speech are too short; statistics need {seconds:g} s"
            return [found.get(n) or unjudged(f"{length:.1f} {few}") for n, (length, _) in every]

        return figures

    return judged


@measure("seen_opening", "times", limit=2.3)
@_on_mesh(LEAST_SPEECH_SECONDS)
def seen_opening(scene: MeasuredScene, mouth: _MeshMouth, lines: list[int]) -> Figures:
    """Times by which the mouth opens farther, or less far, on the mesh than in film.

    The sounds of the line say how far filmed people open it. Actors open twice as far as others,
    and so may a face; the limit is just above. Nobody opens half as far: single sentences of the
    speaker who opens least have 0.69 to 1.29 of the film, and sad ones 0.82 of that. So less than
    0.57 is past the limit::

        ours, film = 95th percentiles over frames of speech of the aperture
        value = max(ours / film, 1.3 * film / ours)
    """
    known = np.isfinite(mouth.filmed)[scene.owner]
    aperture, meant = mouth.aperture[known], mouth.filmed[scene.owner[known]]
    parts = scene.frames_of(known)
    for part in map(parts.__getitem__, lines):
        if not meant[part].max(initial=0.0) > SLIT:
            yield unjudged("no sound of the line opens the mouth")
            continue
        ours, film = (round(percentile(every[part], 95), 4) for every in (aperture, meant))
        ratio = max(ours, NO_MOVEMENT) / max(film, SLIT)
        yield one(max(ratio, MUMBLING / ratio), {"opening": ours, "film": film})


@measure("seen_flaps", "of consonants", limit=0.25)
@_on_mesh()
def seen_flaps(scene: MeasuredScene, mouth: _MeshMouth, lines: list[int]) -> Figures:
    """Consonants that open the mouth on the mesh far more than in film.

    Shapes of consonants that open the mouth as far as vowels do make it flap. Actors pass the
    aperture of film by 0.06 on average::

        value = consonants with an aperture of 0.1 * reach more than in film / consonants
    """
    meant = mouth.seen.consonants[scene.ids] & np.isfinite(mouth.filmed)
    marks = meant, meant & (mouth.middle - mouth.filmed > FLAP * mouth.seen.reach)
    few = f"fewer than {LEAST_SOUNDS} consonants"
    return _shares(scene, lines, marks, partial(_beside_film, mouth), few)


@measure("seen_slits", "of rounded vowels", limit=0.34)
@_on_mesh()
def seen_slits(scene: MeasuredScene, mouth: _MeshMouth, lines: list[int]) -> Figures:
    """Rounded vowels that are nearly shut on the mesh.

    Shapes that push the lips out may shut them, too: a line is seen where a hole belongs. The
    aperture in the middle of the vowel is judged. Solved heads are below 0.4 of the film's in one
    short vowel of six. The limit lets one of three pass. Only a pose set with `mouth: solved`
    should round as people do::

        value = rounded vowels with an aperture below 0.4 of that in film / rounded vowels
    """
    rounded = np.isfinite(mouth.seen.rounded) & ~mouth.seen.consonants
    meant = rounded[scene.ids] & np.isfinite(mouth.filmed)
    marks = meant, meant & (mouth.middle < SLIT_SHARE * mouth.filmed)
    few = f"fewer than {LEAST_SOUNDS} vowels that this face should round"
    return _shares(scene, lines, marks, partial(_beside_film, mouth), few)


def _beside_film(mouth: _MeshMouth, number: int) -> str:
    ours, film = mouth.middle[number], mouth.filmed[number]
    return f"opens the mouth to {ours:.2f}; filmed people to {film:.2f}"


def _shares(  # noqa: PLR0913, PLR0917 the sounds of a scene, and their words
    scene: MeasuredScene,
    lines: list[int],
    marks: tuple[Bools, Bools],
    told: Callable[[int], str],
    few: str,
    least: int = LEAST_SOUNDS,
) -> Figures:
    """Yield the share of sounds with the first mark that have the second, (n,) each."""
    meant, off = scene.counts(marks[0]).tolist(), marks[1].nonzero()[0]
    wrong, parts = off.tolist(), scene.split(off)
    for line in lines:
        if meant[line] < least:
            yield unjudged(few)
            continue
        own = wrong[parts[line]]
        found = places(scene, {number: told(number) for number in own})
        yield one(len(own) / meant[line], findings=found)


@measure("seen_gaps", "of closures", limit=0)
@_on_mesh()
def seen_gaps(scene: MeasuredScene, mouth: _MeshMouth, lines: list[int]) -> Figures:
    """Sounds with shut lips whose lips stay apart on the mesh.

    Such sounds demand a contact, and shut the lips in film. At one frame, extended by half a frame,
    the aperture must be at most 0.06 of the mouth's width: 3 mm of a human mouth::

        value = sounds that stay above / such sounds
    """
    meant = np.asarray(scene.demanded.any(axis=0)) & (mouth.filmed == 0)
    lowest = -scene.highest(-mouth.aperture)  # the highest of the opposite
    marks = meant, meant & ~(lowest <= SLIT)
    few = "no sound of the line shuts the lips"
    return _shares(scene, lines, marks, lambda n: f"leaves the lips {lowest[n]:.2f} apart", few, 1)


@measure("seen_width", "of the mouth", limit=0.36)
@_on_mesh(LEAST_SPEECH_SECONDS)
def seen_width(scene: MeasuredScene, mouth: _MeshMouth, lines: list[int]) -> Figures:
    """Range of the mouth's width on the mesh, at reach 1.

    The GRID speaker has 0.03 to 0.19 in a sentence, and 0.09 in all. Actors round up to four times
    as far as he does, which is the limit. With a reach below 1, lips round nearly as far::

        value = (95th - 5th percentile over frames of speech of the width) / max(reach, 1)
    """
    width, parts = mouth.width[scene.speaking], scene.frames_of(scene.speaking)
    for part in map(parts.__getitem__, lines):
        low, high = (round(percentile(width[part], share), 4) for share in (5, 95))
        yield one((high - low) / max(mouth.seen.reach, 1.0), {"low": low, "high": high})


@measure("seen_rounding", "times", limit=WEAK_ROUNDING)
@_on_mesh()
def seen_rounding(scene: MeasuredScene, mouth: _MeshMouth, lines: list[int]) -> Figures:
    """Times by which rounded lips narrow less on the mesh than in film.

    Sounds that push the lips out round them. The width in film is half-way between the GRID speaker
    and six actors. He narrows the least of these seven: 2.3 times less in his median sentence. The
    limit is just above. Only a pose set with `mouth: solved` should round as people do::

        ours, film = means over rounded sounds of the farthest narrowing in their frames, at least 0
        value = film / ours
    """
    film = np.abs(mouth.seen.rounded[scene.ids])
    ours = np.abs(scene.highest(np.maximum(0, -mouth.width)))
    numbers = (np.isfinite(film) & np.isfinite(ours)).nonzero()[0]
    film, ours, parts = film[numbers], ours[numbers], scene.split(numbers)
    weak = film / np.maximum(ours, NO_MOVEMENT) > WEAK_ROUNDING
    for part in map(parts.__getitem__, lines):
        count = part.stop - part.start
        if count < LEAST_SOUNDS:
            yield unjudged(f"fewer than {LEAST_SOUNDS} sounds that this face should round")
            continue
        rows = (row[part].tolist() for row in (weak, numbers, ours, film))
        told = {
            number: f"narrows the mouth by {own:.2f}; filmed people by {meant:.2f}"
            for is_weak, number, own, meant in zip(*rows, strict=True)
            if is_weak
        }
        narrowing, filmed = (round(each[part].sum().item() / count, 4) for each in (ours, film))
        ratio = filmed / max(narrowing, NO_MOVEMENT)
        yield one(ratio, {"narrowing": narrowing, "film": filmed}, places(scene, told))
