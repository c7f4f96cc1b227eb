"""The test words of a language pack on a face: where the mesh stays away from the mouths of sounds.

Conventions: as in `seen`. A pack states the mouth of a sound, or one for each step of a sound that
moves; what a viewer sees in the middle of each is compared with it. The words have no sound: their
times are estimated.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang import Animation, LipsyncError, Performer, SpeechError
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.commands.check import FACE_CHECKS
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.language_models import MOUTH_MEASURES, SoundMouth
from lipsync_lang.reports.quality.check_animation import judged_on
from lipsync_lang.reports.quality.face_columns import SeenMouth, face_of
from lipsync_lang.resolver.solving import own_reach

LEAST_AWAY = 0.03
"""Smallest difference that is named, in widths of the mouth: 1.5 mm of a human mouth."""

SHOWN = 12
"""Number of differences in the text."""


class SeenSound(NamedTuple):
    """A measure of the mouth at a sound, the mean of all its places."""

    sound: str
    """The common phoneme, and the number of its step if it moves."""
    measure: str
    asked: float
    seen: float


@dataclass(frozen=True)
class WordsOnFace:
    """The mouth of a face in the words of a language pack, beside that of their sounds."""

    subject: str
    judged: str
    """The mesh that was judged."""
    sounds: tuple[SeenSound, ...]
    """The largest difference first."""

    def __str__(self) -> str:
        far = [one for one in self.sounds if abs(one.seen - one.asked) > LEAST_AWAY]
        rows = [(f"  {one[0]}", one[1], f"{one[2]:+.3f}", f"{one[3]:+.3f}") for one in far[:SHOWN]]
        lines = [self.subject, f"  {self.judged}"]
        lines += columns([("  sound", "measure", "asked", "seen"), *rows] if far else [])
        lines += [f"  ... and {len(far) - SHOWN} more (--json lists them)"] * (len(far) > SHOWN)
        for measure in MOUTH_MEASURES:
            own, away = ([o for o in some if o.measure == measure] for some in (self.sounds, far))
            mean = np.mean([abs(one.seen - one.asked) for one in own]) if own else 0.0
            told = (
                f"{len(own) - len(away)} of {len(own)} sounds within {LEAST_AWAY:g} of their mouth"
            )
            lines.append(f"{measure}: {told}, {mean:.3f} away on average")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {**vars(self), "sounds": [one._asdict() for one in self.sounds]}


@FACE_CHECKS.register("words")
def check_words(performer: Performer) -> tuple[str, dict[str, Any]]:
    """Return the report of the test words on a face, and its data."""
    found = words_on_face(performer)
    return str(found), found.to_dict()


def words_on_face(performer: Performer) -> WordsOnFace:
    """Perform the test words of a performer's language, and measure the mouth at each sound.

    Raises
    ------
    LipsyncError
        The mouth is not measured on a mesh, or the language has no tests that can be read.
    """
    library = Library(performer.paths)
    language, name = library.language(performer.language).model, performer.character
    spoken = performer.speaker.speak_many([test.text for test in language.tests], engine="none")
    lines = [one for one in spoken if not isinstance(one, SpeechError)]
    if not lines:
        raise LipsyncError(f"{performer.language} has no test words that are read; give a TEXT")
    animations = performer.perform_many(lines)
    face = face_of(animations[0], performer)
    judged, mouth = judged_on(face, performer.model), face.seen
    if mouth is None:
        other = "another model" if performer.model else "a model"
        raise LipsyncError(f"{judged}; give a TEXT, or name {other} with -c head.glb")
    mouths = library.common().model.mouths()
    mouths |= {name: own.mouth for name, own in language.adds.items() if own and own.mouth}
    if library.lookup("character", name):
        mouths |= library.character(name).model.mouths

    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for animation in animations:
        for key, pair in _places(performer, mouth, mouths, animation):
            found.setdefault(key, []).append(pair)
    means = ((key, np.mean(pairs, axis=0)) for key, pairs in found.items())
    sounds = [SeenSound(*key, *(round(float(one), 4) for one in mean)) for key, mean in means]
    sounds.sort(key=lambda one: -abs(one.seen - one.asked))
    subject = f"{performer.language} on {name}: {len(lines)} words of the language"
    return WordsOnFace(subject, judged, tuple(sounds))


def _places(
    performer: Performer,
    face: SeenMouth,
    mouths: Mapping[str, Sequence[SoundMouth]],
    line: Animation,
) -> Iterator[tuple[tuple[str, str], tuple[float, float]]]:
    """Yield the sound and a measure of each place of a line, with the values asked and seen."""
    seen = face.gains @ line.weights[:, : face.gains.shape[1]].T
    seen[0] = np.maximum(0.0, seen[0])  # lips do not pass each other
    ids, bounds, _ = performer.common_phonemes(line.schedule)
    for number, begin, end in zip(ids, bounds, bounds[1:], strict=False):
        sound = performer.compiled.phonemes[number]
        steps = mouths.get(sound, ())
        for step, wanted in enumerate(steps):
            at = begin + (end - begin) * (step + 0.5) / len(steps)
            label = f"{sound} {step + 1}" if len(steps) > 1 else sound
            for course, measure in zip(seen, MOUTH_MEASURES, strict=True):
                if (asked := getattr(wanted, measure)) is not None:
                    has = float(np.interp(at, line.times, course))
                    yield (label, measure), (own_reach(wanted, face.reach) * asked, has)
