"""Description of a language pack as plain data: map, inventory, tests and disagreements.

Output is nested dicts and lists for JSON and for the table of `authoring.printing`.
"""

from typing import Any

from lipsync_lang.authoring.trial import Trial, try_out
from lipsync_lang.packs import models
from lipsync_lang.packs.checking.language_checks import notation_of
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.resolver.nearest_phonemes import among, disagreements, reason_for
from lipsync_lang.text.phonology.labels import Value, normalise


def describe(library: Library, pack: Pack[models.Language]) -> dict[str, Any]:
    """Return the description of a language for `languages show --json`."""
    model = pack.model
    near = among(library, pack)
    decided = library.ipa().model.decided
    common, trial = library.common().model, try_out(library, pack)
    failed = [fault for fault in trial.faults(common.silence) if fault.severity == "fault"]
    reasons = {one: reason_for(model, near, one, decided) for one in model.notations.get(IPA, {})}
    speaks = f"{model.tts.engine}, voice {model.tts.voice or '(default)'}" if model.tts else ""
    moves = model.motion.model_dump(exclude_none=True)
    return {
        "name": model.name,
        "title": model.title or model.name,
        "tag": model.tag,
        "aliases": list(model.aliases),
        "path": shown(pack.path),
        "extends": model.extends,
        "automatic": model.automatic,
        "adds": list(model.adds),
        "reads": _reads(model),
        "speaks": speaks,
        "moves": ", ".join(f"{name} {value}" for name, value in moves.items()),
        "caveats": list(model.caveats),
        "sources": dict(model.text.sources) if model.text else {},
        "notations": _notations(model, reasons),
        "mouths": _mouths(model, common),
        "inventory": model.inventory.model_dump(mode="json") if model.inventory else None,
        "disagreements": [
            {
                "label": row.label,
                "common": _sounds(row.common),
                "automatic": _sounds(row.automatic),
                "reason": row.reason,
            }
            for row in disagreements(model, near, decided)
        ],
        "tests": {
            "count": len(model.tests),
            "failed": len(failed),
            "refusal": trial.refusal,
            "untested": _untested(trial, common),
        },
    }


def _notations(model: models.Language, reasons: dict[str, str]) -> dict[str, list[dict[str, str]]]:
    """Return the rows of each notation; `reasons` are those of IPA, and the first has examples."""
    return {
        name: [
            {
                "label": label,
                "common": " ".join(sounds.to),
                "example": model.examples.get(label, "") if number == 0 else "",
                "reason": (reasons if name == IPA else model.reasons).get(label, ""),
            }
            for label, sounds in table.items()
        ]
        for number, (name, table) in enumerate(model.notations.items())
    }


def _sounds(value: Value) -> str:
    return " ".join(name for name, _ in value) or "(mute)"


def _mouths(model: models.Language, common: models.Phonemes) -> dict[str, list[dict[str, float]]]:
    """Return the mouth of each common phoneme that the language uses, in measures."""
    used = {name for table in model.notations.values() for one in table.values() for name in one.to}
    return {
        name: [step.model_dump(exclude_none=True) for step in mouth]
        for name, mouth in common.mouths(model.adds).items()
        if name in used
    }


def _reads(model: models.Language) -> str:
    g2p = model.g2p
    if g2p is None:
        return ""
    parts = [
        g2p.engine,
        f"voice {g2p.voice}" if g2p.voice else "",
        f"code {g2p.code}" if g2p.code else "",
        g2p.file or "",
        f"{len(g2p.rules)} rules" if g2p.rules else "",
        f"{len(g2p.corrections)} corrections" if g2p.corrections else "",
        f"respelled as {g2p.respell}" if g2p.respell else "",
    ]
    return ", ".join(filter(None, parts))


def _untested(trial: Trial, common: models.Phonemes) -> dict[str, list[str]]:
    """Return the untested phonemes, common phonemes and rules; rules appear by spelling."""
    model = trial.pack.model
    reached = trial.reached
    heard = {name for test in model.tests for name in test.phonemes}
    names = [*common.base, *(name for name in model.adds if name not in common.base)]
    if model.inventory:
        spelled, name = model.inventory.spelled, IPA
        phonemes = [s for s in model.inventory.segments if s not in model.inventory.absent]
    else:
        spelled, name = {}, next(iter(model.notations), "")
        phonemes = [*(model.examples or model.notations.get(name, {}))]
    missing = [label for label in phonemes if normalise(spelled.get(label, label)) not in reached]
    notation = notation_of(model, name)
    mapped = {name for label in phonemes for name, _ in notation.find(label) or ()}
    rules = model.g2p.rules if model.g2p else ()
    return {
        "phonemes": missing,
        "common phonemes": [name for name in names if name in mapped and name not in heard],
        "rules": [rules[number].spelling for number in trial.silent_rules()],
    }
