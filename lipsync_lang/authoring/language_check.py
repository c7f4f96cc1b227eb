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
from lipsync_lang.schedules.schedule import SILENCE, Schedule

FAILED_TEST = "P221"

FAINTEST_WEIGHT = 0.05
"""Smallest weight of a pose in the description of a mouth."""

MUTE, REST = "(mute)", "at rest"

MOST_SOUNDS, MOST_WORDS = 8, 3
"""Maximum numbers of sounds and of words in a row."""

HELD_SOUND_SECONDS = 0.5
"""Duration of each sound, and of the silence around it."""


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
        return self.told()

    def told(self, *, table: bool = True) -> str:
        """Return the check as text, with or without the table of mouths."""
        values: dict[str, Any] = {**vars(self), "failed": self.failed}
        if self.sounds is not None:
            needed = [row for row in self.sounds["rows"] if row["need"] in {"unmapped", "doubtful"}]
            values |= {"mouths": mouths_in(self.sounds), "needed": needed}
            values["table"] = columns(self._rows(self.sounds), widest=64) if table else ()
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

    A name is, in this order: one letter of the IPA, a common phoneme by any of its names, or a
    label of any notation of the language, in any case. A row has its `caption`: the name with a
    word, or with the look of the mouth. Sounds that pass through several mouths are left out unless
    they are named, because each of these has a row. Raises OutputError if the language has no
    sounds, or none of this name.
    """
    mouths = mouths_in(sounds)
    if not named:
        shown = [own[0] for mouth, own in mouths.items() if len(mouth) == 1]
        if not shown:
            raise OutputError("the language maps no sounds; there is no mouth to draw")
        return [row | {"caption": (row["label"], next(iter(row["words"]), ""))} for row in shown]
    titles = {one["name"]: one["title"] for one in sounds["common"]}
    common = {
        name: {"to": [one["name"]], "words": ()}
        for one in sounds["common"]
        for name in (*one["spelled"], one["name"])
    }
    # A later one counts. Names that all languages share come before labels of several letters,
    # since `th` is an aspirated t in some notations.
    rows = sounds["rows"][::-1]
    rows.sort(key=lambda row: row["notation"] == IPA)
    known = common | {row["label"].casefold(): row for row in rows}
    known |= {row["label"]: row for row in rows}
    known |= {name: own for name, own in common.items() if tuple(own["to"]) in mouths}
    known |= {row["label"]: row for row in rows if (len(row["label"]), row["notation"]) == (1, IPA)}
    found = []
    for name in named:
        row = known.get(name) or known.get(name.casefold()) or {"to": (), "words": ()}
        mouth = tuple(row["to"])
        if mouth not in mouths:
            has = ", ".join(own[0]["label"] for one, own in mouths.items() if len(one) == 1)
            offered = [one for one, own in known.items() if tuple(own["to"]) in mouths]
            hint = f"it has {has}" if mouth else did_you_mean(name, offered)
            looks = f" ({titles[mouth[0]]})" if mouth else ""
            raise OutputError(f"{sounds['name']} has no sound '{name}'{looks}; {hint}")
        looks = " -> ".join(titles[one] for one in mouth) or MUTE
        same = (one for one in mouths[mouth] if one["label"] == name)
        drawn = next(same, mouths[mouth][0])
        found.append(drawn | {"caption": (name, next(iter(row["words"]), looks))})
    return found


def draw_mouths(
    performers: Sequence[Performer], shown: Sequence[Mapping[str, Any]], out: BinaryIO
) -> None:
    """Draw a PNG with a still of each row of `mouths_to_draw`, each performer below the others.

    Raises OutputError if Pillow is missing, or a character has no model.
    """
    from lipsync_lang.render.sheet import moments, stacked

    labels = [SILENCE, *chain.from_iterable((row["label"], SILENCE) for row in shown)]
    times = np.arange(len(labels) + 1, dtype=np.float64) * HELD_SOUND_SECONDS
    schedule = Schedule(tuple(labels), times, notation=shown[0]["notation"])
    captions = [row["caption"] for row in shown]
    middles = (times[1:-1:2] + times[2::2]) / 2
    sheets = {}
    for performer in performers:
        sheet = BytesIO()
        animation = performer.rigged(performer.perform(schedule))
        moments(animation, middles.tolist(), sheet, close=True, captions=captions)
        sheets[performer.character] = sheet.getvalue()
    if len(sheets) == 1:
        out.write(*sheets.values())
    else:
        stacked(sheets, out)
