"""Routes of the language view: the table of sounds, the tests of the pack, and single sounds."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from lipsync_lang.authoring.sound_table import SoundMemory, SoundTable
from lipsync_lang.errors import LipsyncError
from lipsync_lang.resolver.layers import PairPacks
from lipsync_lang.rigs.container import Json
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.studio.routes.asking import Packed, Routes, Wish
from lipsync_lang.studio.routes.line_routes import MAX_TEXT_CHARS, whole
from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

SOUND_SECONDS = (0.25, 0.4, 0.25)
"""Durations of the silence, the sound and the silence of a single sound."""

_memories: "WeakKeyDictionary[Workshop, SoundMemory]" = WeakKeyDictionary()
"""Cached results of tables by workshop."""


def language(workshop: Workshop, _: Wish) -> Json:
    """Return the table of sounds with the tests of the pack, unsaved edits included."""
    return _table(workshop).told()


def _table(workshop: Workshop) -> SoundTable:
    performer, library = workshop.performer, workshop.library()
    pack = library.language(performer.compiled.language)
    memory = _memories.setdefault(workshop, SoundMemory())
    return SoundTable(library, pack, memory, tuple(_spoken(workshop, performer.speaker.manner)))


def _spoken(workshop: Workshop, manner: Any) -> list[tuple[str, str]]:
    """Return the labels of the line with their words, if they are in the engine's notation."""
    schedule = workshop.schedule
    if schedule is None or (schedule.notation or manner.notation) != manner.notation:
        return []
    return [
        (label, word.text)
        for word in schedule.words
        for label in schedule.labels[word.first : word.stop]
    ]


def transcript(workshop: Workshop, asked: Wish) -> Json:
    """Transcribe a text with the unsaved edits: labels, and their common phonemes."""
    text = asked.text("text").strip()
    if len(text) > MAX_TEXT_CHARS:
        raise LipsyncError(
            f"the text is longer than {MAX_TEXT_CHARS} characters; try a single word"
        )
    if not text:
        raise LipsyncError("type a word to try")
    return _table(workshop).transcribed(text)


def sound(workshop: Workshop, asked: Wish) -> Packed:
    """Perform one sound between silences without a voice, as the line."""
    notation, label = asked.text("notation"), asked.text("label")
    notations = workshop.performer.speaker.notations
    if notation not in notations:
        raise LipsyncError(f"unknown notation '{notation}'; choose one of {', '.join(notations)}")
    if notations[notation].find(label) is None:
        raise LipsyncError(f"'{label}' has no mapping in {notation}; add one first")
    times = np.cumsum([0.0, *SOUND_SECONDS])
    schedule = Schedule((SILENCE, label, SILENCE), times, notation=notation)
    workshop.line, workshop.text = SpokenLine(schedule), label
    return whole(workshop)


def mouth(workshop: Workshop, asked: Wish) -> Json:
    """Return the weights of the model's channels at the target of a common phoneme."""
    compiled = workshop.performer.compiled
    shelf = PairPacks.open(workshop.library(), compiled.language, compiled.character)
    if asked.name not in {*compiled.phonemes, *compiled.shades}:
        raise LipsyncError(f"'{asked.name}' is not a common phoneme of {compiled.language}")
    targets, coarse = shelf.face.targets, compiled.shades.get(asked.name, asked.name)
    names = (asked.name, coarse, shelf.likes.get(coarse, ""))
    name = next((one for one in names if one in targets), asked.name)
    if name not in targets and name != SILENCE:
        raise LipsyncError(f"{compiled.poseset} has no target for '{asked.name}'")
    held = [one.weights for one in targets[name]] if name in targets else [{}]
    steps = np.array([[one.get(pose, 0.0) for pose in compiled.poses] for one in held])
    return {"phoneme": name, "steps": workshop.performer.held_channels(steps).tolist()}


ROUTES: Routes = {
    "GET language": language,
    "POST language/transcript": transcript,
    "POST language/sound": sound,
    "GET language/mouth/{name}": mouth,
}
