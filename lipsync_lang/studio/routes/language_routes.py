"""Routes of the language view: new languages, the table of sounds with its tests, single sounds."""

import re
from weakref import WeakKeyDictionary

import numpy as np

from lipsync_lang.authoring.new_pack import PackWish, check_name, write_new
from lipsync_lang.authoring.sound_table import SoundMemory, SoundTable
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.finding import FOLDERS
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.language_models import TAG_PATTERN
from lipsync_lang.packs.yaml.value_text import on_one_line
from lipsync_lang.resolver.layers import PairPacks
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.studio.routes.line_routes import MAX_TYPED_CHARS, whole
from lipsync_lang.studio.routes.requests import PackedResponse, StudioRequest
from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

SOUND_SECONDS = (0.25, 0.4, 0.25)
"""Durations of the silence, the sound and the silence of a single sound."""

_memories: "WeakKeyDictionary[Workshop, SoundMemory]" = WeakKeyDictionary()
"""Cached results of tables by workshop."""


def language(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the table of sounds with the tests of the pack, unsaved edits included."""
    return _table(workshop).told()


def _table(workshop: Workshop) -> SoundTable:
    performer, library = workshop.performer, workshop.library()
    pack = library.language(performer.compiled.language)
    memory = _memories.setdefault(workshop, SoundMemory())
    schedule, notation = workshop.schedule, performer.speaker.manner.notation
    spoken: list[tuple[str, str]] = []
    if schedule is not None and schedule.notation in {None, "", notation}:
        for word in schedule.words:
            labels = schedule.labels[word.first : word.stop]
            spoken += [(label, word.text) for label in labels]
    return SoundTable(library, pack, memory, tuple(spoken))


def begin(workshop: Workshop, request: StudioRequest) -> Json:
    """Write a new language of the project, which extends another, and return its name and file.

    Raises LipsyncError, and writes nothing, if the name or the code cannot be used.
    """
    name, base = request.text("name").strip(), request.text("base")
    path, library = workshop.project / FOLDERS["language"] / f"{name}.yaml", workshop.library()
    check_name(name, path)
    if library.lookup("language", name):
        raise LipsyncError(f"there is a language '{name}' already; choose another name")
    tag = request.text("tag").strip() or library.language(base).model.tag
    if not re.fullmatch(TAG_PATTERN, tag):
        raise LipsyncError(f"'{tag[:20]}' is no language code; write one such as 'sw' or 'pt-BR'")
    stated = {"kind": "language", "format": 1, "name": name, "tag": tag}
    stated |= {"title": PackWish(name).heading, "extends": base}
    text = "".join(f"{field}: {on_one_line(value)}\n" for field, value in stated.items())
    files = {path: text.encode()}
    Library(workshop.paths, workshop.project, unsaved=files).language(name)  # refuses a faulty pack
    refuse_outside(path, workshop.project)
    write_new(files)
    workshop.look_again()
    return {"name": name, "file": workshop.shown(path)}


def transcript(workshop: Workshop, request: StudioRequest) -> Json:
    """Transcribe a text with the unsaved edits: labels, and their common phonemes."""
    text, most = request.text("text").strip(), MAX_TYPED_CHARS
    if len(text) > most:
        raise LipsyncError(f"the text is longer than {most} characters; try a single word")
    if not text:
        raise LipsyncError("type a word to try")
    return _table(workshop).transcribed(text)


def sound(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Perform one sound between silences without a voice, as the line."""
    notation, label = request.text("notation"), request.text("label")
    notations = workshop.performer.speaker.notations
    if notation not in notations:
        raise LipsyncError(f"unknown notation '{notation}'; choose one of {', '.join(notations)}")
    if notations[notation].find(label) is None:
        raise LipsyncError(f"'{label}' has no mapping in {notation}; add one first")
    times = np.cumsum([0.0, *SOUND_SECONDS])
    schedule = Schedule((SILENCE, label, SILENCE), times, notation=notation)
    workshop.line, workshop.text = SpokenLine(schedule), label
    return whole(workshop)


def mouth(workshop: Workshop, request: StudioRequest) -> Json:
    """Return the weights of the model's channels at the target of a common phoneme."""
    compiled = workshop.performer.compiled
    packs = PairPacks.open(workshop.library(), compiled.language, compiled.character)
    if request.name not in {*compiled.phonemes, *compiled.shades}:
        raise LipsyncError(f"'{request.name}' is not a common phoneme of {compiled.language}")
    targets, coarse = packs.face.targets, compiled.shades.get(request.name, request.name)
    names = (request.name, coarse, packs.likes.get(coarse, ""))
    name = next((one for one in names if one in targets), request.name)
    if name not in targets and name != SILENCE:
        raise LipsyncError(f"{compiled.poseset} has no target for '{request.name}'")
    held = [one.weights for one in targets[name]] if name in targets else [{}]
    steps = np.array([[one.get(pose, 0.0) for pose in compiled.poses] for one in held])
    return {"phoneme": name, "steps": workshop.performer.held_channels(steps).tolist()}
