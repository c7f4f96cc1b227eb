"""Measures of the mouth as a viewer sees it, on the mesh of the model, beside filmed lips.

Conventions: lengths are in widths of the closed mouth, and are what the shapes of the model add to
the face at rest. `languages/common.yaml` states the mouths of sounds in film, which the `reach` of
the character scales. They come from 170 sentences of a speaker of the GRID corpus (Cooke, Barker,
Cunningham and Shao, 2006) and from the lips of six actors, who open twice as far as he does.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.reports.quality.curve_statistics import percentile
from lipsync_lang.reports.quality.face_columns import SeenMouth
from lipsync_lang.reports.quality.figures import Figure
from lipsync_lang.reports.quality.likeness import LEAST_SOUNDS, LEAST_SPEECH_SECONDS
from lipsync_lang.reports.quality.measured_scene import MeasuredScene, search
from lipsync_lang.reports.quality.measures import measure, once, one, places, share, unjudged

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


class _MeasuredMouth(NamedTuple):
    """The mouth of all lines."""

    seen: SeenMouth
    aperture: Floats
    """(T,) at least 0: lips do not pass each other."""
    width: Floats
    """(T,)"""
    filmed: Floats
    """(n,) aperture of each phoneme in film; NaN if none is stated."""
    meant: Floats
    """(T,) the same of each frame; NaN outside of speech, too."""
    lowest: Floats
    """(n,) lowest aperture in the frames of each phoneme; NaN without frames."""


FigureOf = Callable[[_MeasuredMouth, slice, slice], list[Figure]]
"""Function of a mouth, and of the frames and the phonemes of a line."""


@once
def _mouth(scene: MeasuredScene) -> _MeasuredMouth | str:
    """Return the mouth, or the reason why it is not judged."""
    seen = scene.face.seen
    if seen is None:
        return "the mouth is not measured on a mesh"
    if scene.motion.hold > 0:
        return "poses are shown one at a time"
    aperture, width = seen.gains[:2] @ scene.curves
    aperture, filmed = np.maximum(0.0, aperture), seen.apertures[scene.ids]
    meant = np.where(scene.speaking, filmed[scene.owner], np.nan)
    # The lowest is the highest of the opposite.
    return _MeasuredMouth(seen, aperture, width, filmed, meant, -scene.highest(-aperture))


def _lines(
    scene: MeasuredScene, figure_of: FigureOf, seconds: float = 0.0
) -> Iterator[list[Figure]]:
    """Yield a figure for each line with so many seconds of speech."""
    mouth = _mouth(scene)
    own = [slice(*one) for one in pairwise(scene.phonemes.tolist())]
    lines = zip(scene.spans, own, scene.seconds, scene.spoken, strict=True)
    for span, sounds, length, spoken in lines:
        if isinstance(mouth, str):
            yield unjudged(mouth)
        elif length < seconds or not spoken:
            yield unjudged(f"{length:.1f} s of speech are too short; statistics need {seconds:g} s")
        else:
            yield figure_of(mouth, span, sounds)


@measure("seen_opening", "times", limit=2.3)
def seen_opening(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Times by which the mouth opens farther, or less far, on the mesh than in film.

    The sounds of the line say how far filmed people open it. Actors open twice as far as others,
    and so may a face; the limit is just above. Nobody opens half as far: single sentences of the
    speaker who opens least have 0.69 to 1.29 of the film, and sad ones 0.82 of that. So less than
    0.57 is past the limit::

        ours, film = 95th percentiles over frames of speech of the aperture
        value = max(ours / film, 1.3 * film / ours)
    """

    def figure_of(mouth: _MeasuredMouth, span: slice, _: slice) -> list[Figure]:
        filmed = mouth.meant[span]
        known = np.isfinite(filmed)
        meant = filmed[known]
        if not meant.max(initial=0.0) > SLIT:
            return unjudged("no sound of the line opens the mouth")
        both = mouth.aperture[span][known], meant
        ours, film = (round(percentile(part, 95), 4) for part in both)
        ratio = max(ours, NO_MOVEMENT) / max(film, SLIT)
        return one(max(ratio, MUMBLING / ratio), {"opening": ours, "film": film})

    return _lines(scene, figure_of, LEAST_SPEECH_SECONDS)


@measure("seen_flaps", "of consonants", limit=0.25)
def seen_flaps(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Consonants that open the mouth on the mesh far more than in film.

    Shapes of consonants that open the mouth as far as vowels do make it flap. Actors pass the
    aperture of film by 0.06 on average::

        value = consonants with an aperture of 0.1 * reach more than in film / consonants
    """
    return _off(
        scene,
        lambda mouth: mouth.seen.consonants,
        lambda ours, film, reach: ours - film > FLAP * reach,
        "consonants",
    )


@measure("seen_slits", "of rounded vowels", limit=0.34)
def seen_slits(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Rounded vowels that are nearly shut on the mesh.

    Shapes that push the lips out may shut them, too: a line is seen where a hole belongs. The
    aperture in the middle of the vowel is judged. Solved heads are below 0.4 of the film's in one
    short vowel of six. The limit lets one of three pass. Only a pose set with `mouth: solved`
    should round as people do::

        value = rounded vowels with an aperture below 0.4 of that in film / rounded vowels
    """
    return _off(
        scene,
        lambda mouth: np.isfinite(mouth.seen.rounded) & ~mouth.seen.consonants,
        lambda ours, film, _: ours < SLIT_SHARE * film,
        "vowels that this face should round",
    )


def _off(
    scene: MeasuredScene,
    chosen: Callable[[_MeasuredMouth], Bools],
    is_off: Callable[[Floats, Floats, float], Bools],
    few: str,
) -> Iterator[list[Figure]]:
    """Yield the share of chosen sounds whose aperture in the middle is off, beside the film's."""
    frames = (scene.frame_line, scene.times)
    middles = search(frames, (scene.line, (scene.begin + scene.end) / 2))

    def figure_of(mouth: _MeasuredMouth, span: slice, own: slice) -> list[Figure]:
        film = mouth.filmed[own]
        meant = chosen(mouth)[scene.ids[own]] & np.isfinite(film)
        if meant.sum() < LEAST_SOUNDS:
            return unjudged(f"fewer than {LEAST_SOUNDS} {few}")
        # The middle of a last sound may lie behind the last frame.
        ours = mouth.aperture[np.minimum(middles[own], span.stop - 1)]
        found = meant & is_off(ours, film, mouth.seen.reach)
        told = {
            own.start + n: f"opens the mouth to {ours[n]:.2f}; filmed people to {film[n]:.2f}"
            for n in found.nonzero()[0].tolist()
        }
        return one(share(found[meant]), findings=places(scene, told))

    return _lines(scene, figure_of)


@measure("seen_gaps", "of closures", limit=0)
def seen_gaps(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Sounds with shut lips whose lips stay apart on the mesh.

    Such sounds demand a contact, and shut the lips in film. At one frame, extended by half a frame,
    the aperture must be at most 0.06 of the mouth's width: 3 mm of a human mouth::

        value = sounds that stay above / such sounds
    """
    asked = np.asarray(scene.demanded.any(axis=0))

    def figure_of(mouth: _MeasuredMouth, _: slice, own: slice) -> list[Figure]:
        meant = asked[own] & (mouth.filmed[own] == 0)
        if not meant.any():
            return unjudged("no sound of the line shuts the lips")
        least = mouth.lowest[own]
        apart = meant & ~(least <= SLIT)
        told = {own.start + n: f"leaves the lips {least[n]:.2f} apart" for n in apart.nonzero()[0]}
        return one(share(apart[meant]), findings=places(scene, told))

    return _lines(scene, figure_of)


@measure("seen_width", "of the mouth", limit=0.36)
def seen_width(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Range of the mouth's width on the mesh, at reach 1.

    The GRID speaker has 0.03 to 0.19 in a sentence, and 0.09 in all. Actors round up to four times
    as far as he does, which is the limit. With a reach below 1, lips round nearly as far::

        value = (95th - 5th percentile over frames of speech of the width) / max(reach, 1)
    """

    def figure_of(mouth: _MeasuredMouth, span: slice, _: slice) -> list[Figure]:
        width = mouth.width[span][scene.speaking[span]]
        low, high = (round(percentile(width, share), 4) for share in (5, 95))
        return one((high - low) / max(mouth.seen.reach, 1.0), {"low": low, "high": high})

    return _lines(scene, figure_of, LEAST_SPEECH_SECONDS)


@measure("seen_rounding", "times", limit=WEAK_ROUNDING)
def seen_rounding(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Times by which rounded lips narrow less on the mesh than in film.

    Sounds that push the lips out round them. The width in film is half-way between the GRID speaker
    and six actors. He narrows the least of these seven: 2.3 times less in his median sentence. The
    limit is just above. Only a pose set with `mouth: solved` should round as people do::

        ours, film = means over rounded sounds of the farthest narrowing in their frames, at least 0
        value = film / ours
    """

    def figure_of(mouth: _MeasuredMouth, _: slice, own: slice) -> list[Figure]:
        film, ours = np.abs(mouth.seen.rounded[scene.ids[own]]), np.abs(narrow[own])
        meant = np.isfinite(film) & np.isfinite(ours)
        if meant.sum() < LEAST_SOUNDS:
            return unjudged(f"fewer than {LEAST_SOUNDS} sounds that this face should round")
        ratios = film / np.maximum(ours, NO_MOVEMENT)
        told = {
            own.start + n: f"narrows the mouth by {ours[n]:.2f}; filmed people by {film[n]:.2f}"
            for n in np.flatnonzero(meant & (ratios > WEAK_ROUNDING)).tolist()
        }
        means = [round(float(each[meant].mean()), 4) for each in (ours, film)]
        parts = dict(zip(("narrowing", "film"), means, strict=True))
        return one(means[1] / max(means[0], NO_MOVEMENT), parts, places(scene, told))

    mouth = _mouth(scene)
    narrow = np.empty(0) if isinstance(mouth, str) else scene.highest(np.maximum(0, -mouth.width))
    return _lines(scene, figure_of)
