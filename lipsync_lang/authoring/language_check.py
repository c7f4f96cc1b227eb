"""Check of a language pack for its author: faults, tests, and the mouth of each sound.

A picture shows the mouths: each sound alone, on the model of a character.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from lipsync_lang.authoring.new_pack import from_template
from lipsync_lang.authoring.sound_table import SoundTable
from lipsync_lang.authoring.trial import doubts, try_out, unheard
from lipsync_lang.base.errors import OutputError, did_you_mean
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.finding import IPA, is_model
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.performing.performer import Performer
from lipsync_lang.schedules.schedule import SILENCE, Schedule, Word

FAILED_TEST = "P221"

FAINTEST_WEIGHT = 0.05
"""Smallest weight of a pose in the description of a mouth."""

MUTE, REST = "(mute)", "at rest"

MOST_SOUNDS, MOST_WORDS = 8, 3
"""Maximum numbers of sounds and of words in a row."""

HELD_SOUND_SECONDS = 0.5
"""Duration of each sound, and of the silence around it."""

MOUTHS_IN_ROW = 8


@dataclass(frozen=True)
class LanguageCheck:
    """Faults of a language pack, and its sounds if it can be read."""

    faults: tuple[Fault, ...]
    sounds: Mapping[str, Any] | None
    """The table of sounds (`SoundTable.told`); None if a fault keeps the pack from being read."""
    mouths: Mapping[str, str] = field(default_factory=dict)
    """Description of each common phoneme on a character, such as ``open 0.60, wide 0.20``."""
    character: str = ""
    tests: int = 0
    """Tests that the pack states, or keeps from the pack that it shadows."""
    refusal: str = ""
    """Reason why the texts of the tests were not read; empty if they were."""

    @property
    def failed(self) -> int:
        """Number of tests with another result."""
        return len({(one.file, one.line) for one in self.faults if one.code == FAILED_TEST})

    @property
    def sound(self) -> bool:
        """True if there is no fault; warnings do not count."""
        return all(fault.severity != "fault" for fault in self.faults)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "faults": [fault.to_dict() for fault in self.faults],
            "sounds": self.sounds,
            "character": self.character or None,
            "mouths": dict(self.mouths),
            "tests": {"count": self.tests, "failed": self.failed, "refusal": self.refusal},
        }

    def __str__(self) -> str:
        values: dict[str, Any] = {**vars(self), "failed": self.failed}
        if self.sounds is not None:
            needed = [row for row in self.sounds["rows"] if row["need"] in {"unmapped", "doubtful"}]
            values |= {"mouths": mouths_in(self.sounds), "needed": needed}
            values["table"] = columns(self._rows(self.sounds), widest=64)
        return from_template("language_check", **values).removesuffix("\n")

    def _rows(self, sounds: Mapping[str, Any]) -> list[list[str]]:
        """Return the rows of the table of mouths; the last column is for a character."""
        titles = {one["name"]: one["title"] for one in sounds["common"]}
        rows = [["mouth", "sounds", "as in", "looks like", self.character]]
        for mouth, own in mouths_in(sounds).items():
            words = [*dict.fromkeys(word for row in own for word in row["words"][:1])]
            looks = " -> ".join(titles.get(name, "") for name in mouth)
            poses = " -> ".join(self.mouths.get(name, REST) for name in mouth)
            more = f" + {len(own) - MOST_SOUNDS}" if len(own) > MOST_SOUNDS else ""
            labels = " ".join(row["label"] for row in own[:MOST_SOUNDS]) + more
            told = [" ".join(mouth) or MUTE, labels, ", ".join(words[:MOST_WORDS]), looks]
            rows.append([*told, poses])
        return rows if self.mouths else [row[:-1] for row in rows]


def mouths_in(sounds: Mapping[str, Any]) -> dict[tuple[str, ...], list[dict[str, Any]]]:
    """Return the sounds of each mouth, those with example words first.

    A mouth is the common phonemes that a label becomes. Labels are of the notation that people
    read: IPA, or else the first of the language.
    """
    notations = sounds["notations"]
    shown = IPA if IPA in notations else next(iter(notations), IPA)
    own = [one for one in sounds["rows"] if one["notation"] == shown]
    mouths = grouped((tuple(one["to"]), one) for one in own if one["need"] != "unmapped")
    return {mouth: sorted(own, key=lambda row: not row["words"]) for mouth, own in mouths.items()}


def check_language(library: Library, path: Path, character: str | None = None) -> LanguageCheck:
    """Check a language pack in a folder of the library; a character shows the mouths."""
    faults = validate(library, [path])
    if any(fault.severity == "fault" and fault.code != FAILED_TEST for fault in faults):
        return LanguageCheck(tuple(faults), None)
    pack = library.extended(path)
    trial = try_out(library, pack)
    tried = trial.faults(library.common().model.silence)
    found = tuple(sorted({*faults, *tried, *doubts(library, pack), *unheard(library, pack)}))
    sounds, tests = SoundTable(library, pack).told(), len(pack.model.tests)
    mouths = mouths_of(library, pack.model.name, character) if character else {}
    return LanguageCheck(found, sounds, mouths, character or "", tests, trial.refusal)


def mouths_of(library: Library, language: str, character: str) -> dict[str, str]:
    """Describe the target of each common phoneme: its poses with their weights, largest first."""
    from lipsync_lang.resolver.layers import PairPacks
    from lipsync_lang.resolver.rigging import best_match

    match, on = best_match(library, Path(character)) if is_model(character) else (None, None)
    name, has = (match.poseset, match.optional) if match else (character, ())
    shelf = PairPacks.open(library, language, name, has, on)
    told = {}
    for phoneme, (target, _) in shelf.targets.items():
        weights = zip(target.weights.max(axis=0).tolist(), shelf.poses, strict=True)
        seen = sorted((-weight, pose) for weight, pose in weights if weight >= FAINTEST_WEIGHT)
        told[phoneme] = ", ".join(f"{pose} {-weight:.2f}" for weight, pose in seen) or REST
    return told


def mouths_to_draw(sounds: Mapping[str, Any], named: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Return a row of the table of sounds for each mouth: those of named sounds, or all.

    A name is a label of any notation of the language, in any case, or a common phoneme. Sounds that
    pass through several mouths are left out unless they are named, because each of these has a row.
    Raises OutputError if the language has no sounds, or none of this name.
    """
    mouths = mouths_in(sounds)
    if not named:
        shown = [own[0] for mouth, own in mouths.items() if len(mouth) == 1]
        if not shown:
            raise OutputError("the language maps no sounds; there is no mouth to draw")
        return shown
    known = {row["label"].casefold(): row["to"] for row in reversed(sounds["rows"])}
    known |= {mouth[0]: mouth for mouth in mouths if len(mouth) == 1 and mouth[0] not in known}
    found = []
    for name in named:
        mouth = tuple(known.get(name.casefold(), ()))
        if mouth not in mouths:
            raise OutputError(
                f"{sounds['name']} has no sound '{name}'; {did_you_mean(name, known)}"
            )
        rows = mouths[mouth]
        found.append(next((row for row in rows if row["label"] == name), rows[0]))
    return found


def draw_mouths(
    performers: Sequence[Performer], shown: Sequence[Mapping[str, Any]], out: BinaryIO
) -> None:
    """Draw a PNG with a still of each sound and a word, each performer below the others.

    Raises OutputError if Pillow is missing, or a character has no model.
    """
    from lipsync_lang.render.sheet import moments, stacked

    labels = [SILENCE, *chain.from_iterable((row["label"], SILENCE) for row in shown)]
    times = np.arange(len(labels) + 1, dtype=np.float64) * HELD_SOUND_SECONDS
    words = tuple(
        Word(next(iter(row["words"]), row["label"]), 2 * n + 1, 2 * n + 2)
        for n, row in enumerate(shown)
    )
    schedule = Schedule(tuple(labels), times, words, notation=shown[0]["notation"])
    middles = (times[1:-1:2] + times[2::2]) / 2
    sheets = {}
    for performer in performers:
        sheet = BytesIO()
        animation = performer.rigged(performer.perform(schedule))
        moments(animation, middles.tolist(), sheet, close=True, columns=MOUTHS_IN_ROW)
        sheets[performer.character] = sheet.getvalue()
    if len(sheets) == 1:
        out.write(*sheets.values())
    else:
        stacked(sheets, out)
