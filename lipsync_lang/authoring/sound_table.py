"""Table of the sounds of a language: the mouth of each label, and the mappings to check.

Rows are in order of urgency: unmapped labels, mappings that their features
contradict, mappings that lose much of the sound, and the rest.
"""

from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

from lipsync_lang.authoring.trial import Trial, try_out
from lipsync_lang.base.errors import PackError
from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs import models
from lipsync_lang.packs.checking.language_checks import notation_of
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.pack import Pack
from lipsync_lang.resolver.language_tables import manner_of, notations_of
from lipsync_lang.resolver.nearest_phonemes import (
    among,
    candidates,
    disagreements,
    fights,
    reason_for,
)
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.labels import Notation, looser, normalise
from lipsync_lang.text.phonology.manner import Manner
from lipsync_lang.text.phonology.nearest import SMALL_MARK, NearestPhonemes

NEEDS = ("unmapped", "doubtful", "automatic", "loses", "")
"""Reasons to check a row, the most urgent first."""

MAX_EXAMPLE_WORDS = 3


@dataclass
class SoundMemory:
    """Results that stay valid after edits of a table; each user needs one instance.

    `read` has words of texts, by the settings of the engine that read them, and `near` the latest
    search by features, with what it depends on.
    """

    read: dict[tuple[Any, ...], dict[str, tuple[SpokenWord, ...]]] = field(default_factory=dict)
    near: tuple[object, NearestPhonemes | None] = (None, None)


@dataclass(frozen=True)
class SoundTable:
    """The table of sounds of a language, with its sources, unsaved edits included.

    The memory has results of earlier tables. `spoken` are further (label, word) of the engine's
    notation, such as those of a line.
    """

    library: Library
    pack: Pack[models.Language]
    memory: SoundMemory = field(default_factory=SoundMemory)
    spoken: tuple[tuple[str, str], ...] = ()

    def told(self) -> dict[str, Any]:
        """Return JSON data: rows, common phonemes each followed by its shades, tests, caveats."""
        trial = self.trial()
        model, sources = self.pack.model, self.pack.sources
        known, common = self.library.common().model, []
        for name in candidates(model, known):
            stated: Any = model.adds.get(name) or known.phonemes[name]
            common.append(_described(name, stated, ""))
            common += [_described(s, x, name) for s, x in known.shades.items() if x.like == name]
        return {
            "name": model.name,
            "title": next(filter(None, (one.data.get("title") for one in sources)), model.name),
            "tag": model.tag,
            "extends": model.extends,
            "automatic": model.automatic,
            "speaks": model.tts is not None,
            "notations": list(model.notations),
            "read": model.g2p_notation,
            "common": common,
            "rows": self.rows(trial),
            "tests": self._tests(trial),
            "own_tests": len(self.pack.source.data.get("tests") or ()),
            "refusal": trial.refusal,
            "caveats": list(model.caveats),
        }

    def trial(self) -> Trial:
        """Run the tests of the pack, and those of the packs that it extends."""
        tests = list(self.pack.model.tests)
        for source in self.pack.sources:
            taken = source.data["name"] == self.pack.model.name
            if not taken and (source.path.is_file() or source.path in self.library.unsaved):
                found: Any = self.library.load(source.path, "language", source.path.stem)
                tests += found.model.tests
        whole = replace(self.pack, model=self.pack.model.model_copy(update={"tests": tests}))
        return try_out(self.library, whole, self._read(self._manner()))

    def transcribed(self, text: str) -> dict[str, Any]:
        """Transcribe a text: words with labels, and common phonemes of each; or a SpeechError."""
        manner = self._manner()
        near = self._near() if self.pack.model.automatic else None
        notations = notations_of(self.library, self.pack)
        speaker = Speaker(manner, notations, near, self._read(manner))
        (transcript,) = speaker.transcribe([text])
        return speaker.to_json(transcript)

    def _manner(self) -> Manner:
        return manner_of(self.pack, self.library.common().model)

    def _read(self, manner: Manner) -> "MutableMapping[str, tuple[SpokenWord, ...]]":
        file = manner.settings.file
        # A lexicon that was saved again gives other words under the same settings.
        when = file.stat().st_mtime_ns if file is not None and file.is_file() else 0
        key = (manner.engine, manner.settings, frozenset(manner.words), when)
        return self.memory.read.setdefault(key, {})

    def rows(self, trial: Trial) -> list[dict[str, Any]]:
        """Return a row for each label of each notation, the most urgent first."""
        model, near = self.pack.model, self._near()
        # Words by normalised label; those of a looser spelling come last.
        names = {normalise(label) for table in model.notations.values() for label in table}
        words: dict[str, list[str]] = {}
        for label, own in self._heard(trial).items():
            mapped = next((one for one in looser(label) if one in names), label)
            words.setdefault(mapped, []).extend(own)
        first = next(iter(model.notations), "")
        rows = [*self._unmapped(trial)]
        for notation, table in model.notations.items():
            judged = self._judged(near) if notation == IPA and near is not None else {}
            known = words if notation in (IPA, model.g2p_notation) else {}
            for label, sounds in table.items():
                row = self._row(notation, label, list(sounds.to), list(sounds.shares or ()))
                example = model.examples.get(label, "") if notation == first else ""
                own = [example] if example else []
                row["words"] = [*dict.fromkeys(own + known.get(normalise(label), []))]
                rows.append(row | judged.get(label, {}))
        rows += self._automatic(trial, near)
        for row in rows:
            row["words"] = row["words"][:MAX_EXAMPLE_WORDS]
        # Two stable sorts: by distance within each need, and sound rows in the order of the pack.
        rows.sort(key=lambda row: -row["distance"] if row["need"] else 0.0)
        return sorted(rows, key=lambda row: NEEDS.index(row["need"]))

    def _row(self, notation: str, label: str, to: list[str], shares: list[float]) -> dict[str, Any]:
        stated = self.pack.source.data
        tables = stated.get("notations") or {}
        return {
            "notation": notation,
            "label": label,
            "to": to,
            "shares": shares,
            "reason": self.pack.model.reasons.get(label, ""),
            "own": label in (tables.get(notation) or {}),
            "own_reason": label in (stated.get("reasons") or {}),
            "why": "",
            "need": "",
            "says": "",
            "losses": [],
            "distance": 0.0,
            "words": [],
        }

    def _near(self) -> NearestPhonemes | None:
        """Return the search by features; None if the pack of the IPA is unsound."""
        library, model = self.library, self.pack.model
        try:
            ipa, common = library.ipa(), library.common()
            files = [library.files[str(pack.path)] for pack in (ipa, common)]
            key = (files, candidates(model, common.model))
            if self.memory.near[0] != key:
                self.memory.near = key, among(library, self.pack)
        except PackError:
            return None
        return self.memory.near[1]

    def _judged(self, near: NearestPhonemes) -> dict[str, dict[str, Any]]:
        """Return the reason of each IPA mapping, and any contradiction with its features."""
        model, decided = self.pack.model, self.library.ipa().model.decided
        against = dict(fights(model, near))
        other = {row.label: row for row in disagreements(model, near, decided)}
        judged = {}
        for label in model.notations[IPA]:
            found = near.nearest(label)
            one: dict[str, Any] = {
                "why": reason_for(model, near, label, decided),
                "losses": list(found.losses),
                "distance": 0.0 if found.distance == inf else round(found.distance, 3),
            }
            row, need, says = other.get(label), "doubtful", ""
            if label in against:
                says = f"contradicts its features: {', '.join(against[label])}"
            elif row is not None and not row.reason:
                by = " ".join(name for name, _ in row.automatic) or "nothing"
                says = f"the nearest by its features is {by}, and no reason is given"
            elif row is None and found.losses and one["distance"] > SMALL_MARK:
                need, says = "loses", f"not shown: {', '.join(found.losses)}"
            judged[label] = one | ({"need": need, "says": says} if says else {})
        return judged

    def _unmapped(self, trial: Trial) -> Iterator[dict[str, Any]]:
        """Yield rows for unmapped labels that are spoken or in the inventory."""
        model = self.pack.model
        name = model.g2p_notation
        found: dict[tuple[str, str], list[str]] = {}
        for heard in trial.transcripts:
            for label in heard.unmapped:
                found.setdefault((name, label), []).append(heard.text)
        notation = notation_of(model, name)
        for label, word in self.spoken if not model.automatic else ():
            if notation.find(label) is None:
                found.setdefault((name, label), []).append(word)
        mapped, inventory = notation_of(model, IPA), model.inventory
        if inventory is not None and not model.automatic:
            for segment in inventory.segments:
                if segment not in inventory.absent and mapped.find(segment) is None:
                    found.setdefault((IPA, segment), [])
        for (where, label), words in found.items():
            says = f"'{words[0]}' has this label" if words else "the inventory has it"
            own = {"need": "unmapped", "says": f"not mapped: {says}", "words": words}
            yield self._row(where, label, [], []) | own

    def _automatic(self, trial: Trial, near: NearestPhonemes | None) -> Iterator[dict[str, Any]]:
        """Yield rows for labels that an automatic language maps by features alone."""
        model = self.pack.model
        if not model.automatic or near is None:
            return
        stated = Notation(dict.fromkeys(model.notations.get(IPA, {}), ()))
        for label, words in self._heard(trial).items():
            found = near.nearest(label)
            if stated.stated(label) is not None or found.distance == inf:
                continue
            says = f"not shown: {', '.join(found.losses)}" if found.losses else "by its features"
            row = self._row(IPA, label, [name for name, _ in found.value], [])
            row |= {"need": "automatic", "says": says, "words": words}
            yield row | {"losses": list(found.losses), "distance": round(found.distance, 3)}

    def _heard(self, trial: Trial) -> dict[str, list[str]]:
        """Return the words of each label, as the engine or a test's source writes it."""
        read = (word for transcript in trial.transcripts for word in transcript.words)
        pairs = [(label, word.text) for word in read for label in word.labels]
        tests = trial.pack.model.tests
        pairs += ((label, test.text) for test in tests for label in test.ipa.split())
        return grouped((normalise(label), word) for label, word in (*pairs, *self.spoken))

    def _tests(self, trial: Trial) -> list[dict[str, Any]]:
        """Return each test with its result."""
        common = self.library.common().model
        notation = notation_of(self.pack.model, IPA)
        rows = []
        for number, test in enumerate(trial.pack.model.tests):
            heard = trial.transcripts[number] if number < len(trial.transcripts) else None
            said = [name for name in heard.phonemes if name != common.silence] if heard else []
            claimed = [n for label in test.ipa.split() for n, _ in notation.find(label) or ()]
            claim = not test.ipa or test.accepts(claimed, common.shades)
            right = heard is None or (
                not heard.unmapped and test.accepts(said, common.shades, read=True)
            )
            rows.append(
                {
                    "text": test.text,
                    IPA: test.ipa,
                    "source": test.source,
                    "expected": list(test.read or test.phonemes),
                    "said": said,
                    "claimed": claimed if not claim else [],
                    "labels": list(heard.labels) if heard else [],
                    "unmapped": list(heard.unmapped) if heard else [],
                    "right": right,
                    "passed": right and claim,
                }
            )
        return rows


def _described(name: str, stated: models.SoundFields, like: str) -> dict[str, Any]:
    """Return the description of a common phoneme or a shade."""
    return {
        "name": name,
        "title": stated.title,
        IPA: list(stated.ipa),
        "spelled": list(getattr(stated, "spelled", ())),
        "example": stated.example,
        "class": stated.sound or "",
        "like": like,
        "reason": getattr(stated, "reason", ""),
    }
