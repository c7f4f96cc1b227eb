"""Dependencies of a line on its packs: digests of everything that its performance reads.

A need has a name, such as `bigram m iy`, and a digest of the value that the packs give it. A line
whose needs all have the digests of the last build would be made the same again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.animations.rates import USUAL_FPS
from lipsync_lang.base.presentation.wording import short_place
from lipsync_lang.base.version import __version__
from lipsync_lang.performing.performer import Performer
from lipsync_lang.production.builds.digests import VALUE_BYTES, digest, file_digest, joined
from lipsync_lang.production.builds.timing_formats import TimingFormats
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.text.phonology.g2p.tokens import plain

ABSENT_DIGEST = b"\0" * VALUE_BYTES
"""Digest of a need that is no longer in the packs."""

CURVE_SOURCE = "source"
"""Need of the source of a bigram or a trigram, which only outputs with reasons show."""

OF_LINES = frozenset((
    "language", "line_deliveries", "line_edits", "manner", "model", "nearest", "notations",
    "origins", "phonemes", "report", "shades", "silences", "style_origins", "tables", "visemes",
    "word_edits", "words",
))  # fmt: skip
"""Fields of a compiled pair that have needs of their own, or that no output shows."""

OF_ROWS = frozenset((
    "boundary", "contacts", "curves", "free", "opposed", "pairs", "styles", "trigram_rows",
    "trigrams",
))  # fmt: skip
"""Fields of the tables with a row for each bigram, trigram or phoneme."""

TOLD = {
    "program": "the program's version",
    "settings": "the frame rate, offset, motion, limits or `glb`",
    "face": "the rules of the face",
    "model": "the model",
    "voice": "the language's reading or voice",
    "labels": "the labels that the language knows",
}
"""Words for the needs without a name."""


class BuildSettings(NamedTuple):
    """Settings that hold for every line of a build."""

    fps: float
    limits: Mapping[str, float]
    tts: str | None = None
    gestures: str | None = None
    idle: float = 0.0
    offset: float = 0.0
    face_once: bool = False
    """True if the lines of a character share the data of its model."""
    timing_formats: TimingFormats | None = None
    """Formats of timings that the project states, as plain fields by name."""
    frame_rate: float | None = None
    """`fps` if the project states it; None for the usual rate."""


class PairNeeds:
    """Digests of a resolved pair, each computed on first use."""

    def __init__(self, performer: Performer, settings: BuildSettings) -> None:
        self.performer = performer
        self.settings = settings
        self._known: dict[str, bytes] = {}

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the performer, the settings and the digests of files, not the other digests."""
        # An interrupted build deletes its copies of files while workers still look for them.
        files = {"model_digest": self.model_digest, "_manner": self._manner}
        return {"performer": self.performer, "settings": self.settings, "_known": {}, **files}

    def of(self, schedule: Schedule, *, spoken: bool, reasons: bool) -> dict[str, bytes]:
        """Return the needs of a line with their digests.

        Parameters
        ----------
        spoken : True if the language's reading and voice made the schedule
        reasons : True if an output tells the files and lines of packs
        """
        names = ["program", "settings", "face", "model"]
        names += ["voice"] if spoken else []
        names += ["labels"] if schedule.notation is None else []
        notation = self.performer.notation(schedule)
        known = self.performer.labels.notations
        own = next(name for name, one in known.items() if one is notation)
        names += [f"label {own} {label}" for label in dict.fromkeys(schedule.labels)]
        names += [f"word {text}" for text in dict.fromkeys(word.text for word in schedule.words)]
        ids, _, _ = self.performer.common_phonemes(schedule)
        phonemes, count = self.performer.compiled.phonemes, len(self.performer.compiled.phonemes)
        silence = np.array([self.performer.compiled.tables.silence])
        around = np.concatenate((silence, ids, silence))
        # Codes, since integers are sorted faster than names; trigrams come after all bigrams.
        pairs = around[:-1] * count + around[1:]
        threes = (pairs[:-1] * count + around[2:])[around[1:-1] != silence] + count**2
        codes = {*pairs.tolist(), *threes.tolist()}
        for code in codes.difference(self._units):
            self._units[code] = _trigram(phonemes, code - count**2)
        units = [self._units[code] for code in sorted(codes)]
        names += units
        names += [f"{CURVE_SOURCE} {unit}" for unit in units] if reasons else []
        return {name: self._known.get(name) or self.current(name) for name in names}

    def current(self, name: str) -> bytes:
        """Return the digest of a need by its name."""
        if name in self._known:
            return self._known[name]
        kind, _, rest = name.partition(" ")
        compiled, labels = self.performer.compiled, self.performer.labels
        if kind in {"bigram", "trigram"}:
            found = self._curves.get(name, ABSENT_DIGEST)
        elif kind == CURVE_SOURCE:
            rows = (compiled.origins[row] for row in self._rows.get(rest, ()))
            # As pages show them, so that a moved project is as it was.
            found = digest(
                [one._replace(places=tuple(map(short_place, one.places))) for one in rows]
            )
        elif kind == "label":
            notation, _, label = rest.partition(" ")
            value = None
            if notation in labels.notations:
                known = labels.notations[notation]
                value = known.find(label)
                if value is None:
                    value = labels.unlisted(known, label)
            numbers = compiled.numbers(shades=labels.shades)  # shades as they are performed
            # By the names that the numbers stand for: an added phoneme renumbers the others.
            found = digest(value and [(compiled.phonemes[numbers[n]], share) for n, share in value])
        elif kind == "word":
            edit = compiled.word_edits.get(rest.casefold())
            found = digest(edit, compiled.words.get(plain(rest)))
        else:
            found = self._wide.get(kind, ABSENT_DIGEST)
        self._known[name] = found
        return found

    @cached_property
    def _units(self) -> dict[int, str]:
        """Needs of bigrams by code, and of those trigrams that lines have, after them."""
        # The rows begin with all bigrams, in the order of their codes.
        return dict(enumerate(islice(self._rows, self.performer.compiled.tables.pairs.size)))

    @cached_property
    def speech(self) -> bytes:
        """Digest of the reading and speaking of texts: pairs that share it share schedules."""
        compiled = self.performer.compiled
        return digest(self._manner, compiled.notations, compiled.nearest)

    @cached_property
    def _manner(self) -> dict[str, Any]:
        """Settings of reading and speaking; files of packs count by content, not by place."""
        from lipsync_lang.sound.speech.hearing.sphinx.folder import own_folder

        manner = self.performer.compiled.manner
        path = manner["settings"]["file"]
        file = file_digest(Path(path)) if path and Path(path).is_file() else path
        known = {name: value for name, value in manner.items() if name != "weak"}
        audio = manner["audio"]
        engines = filter(None, (*audio["align"], audio["recognise"], f":{audio['model']}"))
        folders = (own_folder(engine.partition(":")[2]) for engine in engines)
        paths = (path for folder in folders if folder for path in sorted(folder.rglob("*")))
        heard = [file_digest(path) for path in paths if path.is_file()]
        return known | {"settings": manner["settings"] | {"file": file}, "heard": heard}

    @cached_property
    def model_digest(self) -> str | None:
        """Digest of the file of the character's model; None without one."""
        model = self.performer.model
        return file_digest(model) if model and model.is_file() else None

    @cached_property
    def _wide(self) -> dict[str, bytes]:
        """Digests of all that every line of the pair depends on."""
        performer, compiled = self.performer, self.performer.compiled
        manner = {name: value for name, value in self._manner.items() if name != "words"}
        stated = {f.name: getattr(compiled, f.name) for f in fields(compiled)}
        rules = {f.name: getattr(compiled.tables, f.name) for f in fields(compiled.tables)}
        face = {name: value for name, value in stated.items() if name not in OF_LINES}
        # Gestures and drafts of styles state the places of their packs, which no output shows.
        face["style_drafts"] = [
            (name, {key: value for key, value in draft.items() if key != "place"})
            for name, draft in compiled.style_drafts.items()
        ]
        made = compiled.gestures["gestures"]
        face["gestures"] = compiled.gestures | {"gestures": [one | {"place": ""} for one in made]}
        tables = {name: value for name, value in rules.items() if name not in OF_ROWS}
        held = [(one.floor, one.ceiling) for one in compiled.tables.contacts]
        said = performer.motion, performer.shades, performer.unknown
        known = {name: sorted(one.table) for name, one in performer.labels.notations.items()}
        own = self.settings
        chosen = own.fps, own.limits, own.offset, own.face_once, own.gestures, own.idle
        # Nothing without formats, so that lines of older builds stay up to date. The usual rate, if
        # it is stated, shows in files that count frames of a program.
        further: list[object] = [one for one in (own.timing_formats,) if one]
        further += ["frames"] if own.frame_rate == USUAL_FPS else []
        return {
            "program": digest(__version__),
            "settings": digest(*said, *chosen, *further),
            "face": digest(face, tables, held, manner["kinds"], compiled.nearest),
            "model": digest(self.model_digest),
            "voice": digest(manner, self.settings.tts),
            "labels": digest(known, compiled.silences),
        }

    @cached_property
    def _rows(self) -> dict[str, tuple[int, ...]]:
        """Rows of each bigram, and both rows of each drawn trigram."""
        tables, names = self.performer.compiled.tables, self.performer.compiled.phonemes
        trigrams = zip(tables.trigrams.tolist(), tables.trigram_rows.tolist(), strict=True)
        return {
            f"bigram {names[a]} {names[b]}": (row,)
            for a, of_first in enumerate(tables.pairs.tolist())
            for b, row in enumerate(of_first)
        } | {_trigram(names, code): tuple(own) for code, own in trigrams}

    @cached_property
    def _curves(self) -> dict[str, bytes]:
        """Digests of each bigram and each drawn trigram: curves in every style, and rules."""
        tables, names = self.performer.compiled.tables, self.performer.compiled.phonemes
        arrays = [array for bank in (tables.neutral, *tables.styles) for array in bank]
        rows = [
            joined(*(np.ascontiguousarray(array[row]).tobytes() for array in arrays))
            for row in range(len(tables.curves))
        ]
        rules = {
            name: joined(
                opposed.tobytes(), bytes(bool(one.phonemes[at]) for one in tables.contacts)
            )
            for at, (name, opposed) in enumerate(zip(names, tables.opposed, strict=False))
        }
        found = {}
        for unit, own in self._rows.items():
            kind, *sounds = unit.split(" ")
            ruled = [rules[name] for name in sounds] if kind == "bigram" else []
            found[unit] = joined(*(rows[row] for row in own), *ruled)
        return found


def _trigram(names: Sequence[str], code: int) -> str:
    """Return the need of a trigram, by its code."""
    pair, last = divmod(code, len(names))
    return f"trigram {names[pair // len(names)]} {names[pair % len(names)]} {names[last]}"


def need_in_words(name: str) -> str:
    """Describe a need, as the reason to make a line again."""
    kind, _, rest = name.partition(" ")
    if kind in {"bigram", "trigram"}:
        return f"the {kind} {rest.replace(' ', '-')}"
    if kind == CURVE_SOURCE:
        return f"the source of {need_in_words(rest)}"
    if kind == "label":
        return f"the sound of {rest.partition(' ')[2]}"
    return f"the word {rest}" if kind == "word" else TOLD.get(kind, f"'{name}'")
