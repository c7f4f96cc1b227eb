"""Merge a language or a pose set with the one it extends, which may extend another."""

from functools import reduce
from typing import TYPE_CHECKING
from unicodedata import normalize

from pydantic import BaseModel

from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.packs.yaml.source import Data
from lipsync_lang.text.phonology.labels import normalise

if TYPE_CHECKING:
    from collections.abc import Callable

    from lipsync_lang.packs.models import Language, Phonemes, PoseSet
    from lipsync_lang.packs.models.language_models import G2P

REPLACED_FIELDS = (
    "tts", "audio", "motion", "automatic", "gesture_words", "stress_digits", "asides", "weak",
)  # fmt: skip
"""Fields that a child replaces as a whole, or inherits."""

MERGED_FIELDS = ("adds", "durations", "words", "examples", "reasons")
"""Mappings that are merged; a child's entry replaces its parent's."""


def with_usual(
    pack: "Pack[Language]", common: "Callable[[], Pack[Phonemes]]"
) -> "tuple[Pack[Language], list[Fault]]":
    """Return a language with the usual mapping of each label that states none, and its faults."""
    from lipsync_lang.packs.models import USUAL

    notations = pack.model.notations
    bare = [
        (name, label)
        for name, table in notations.items()
        for label, sounds in table.items()
        if sounds is USUAL
    ]
    if not bare:
        return pack, []
    usual = common().model.usual
    faults = []
    for name, label in bare:
        known = usual.get(name, {})
        if label not in known:
            near = did_you_mean(label, known)
            hint = near if near.startswith("did") else "write its common phonemes after it"
            what = f"'{label}' has no usual mapping in '{name}'"
            faults.append(pack.fault(("notations", name, label), "P238", what, hint, key=True))
    if faults:
        return pack, faults
    filled = {
        name: {label: usual[name][label] if one is USUAL else one for label, one in table.items()}
        for name, table in notations.items()
    }
    return Pack(pack.model.model_copy(update={"notations": filled}), pack.sources), []


def with_alike(pack: "Pack[Language]", common: "Callable[[], Pack[Phonemes]]") -> "Pack[Language]":
    """Return a language with the other spellings of each abbreviation that is first of its list."""
    text = pack.model.text
    known = text.abbreviations if text else {}
    shared = common().model.text if known else None
    if text is None or shared is None:
        return pack
    others = {
        other: known[first]
        for first, *alike in shared.alike
        if first in known
        for other in alike
        if other not in known
    }
    if not others:
        return pack
    text = text.model_copy(update={"abbreviations": {**known, **others}})
    return Pack(pack.model.model_copy(update={"text": text}), pack.sources)


ADDED_FIELDS = ("rules", "readings", "foreign", "corrections", "letters")
"""Lists of `g2p` to which a child adds; its own are tried first."""


def _joined_g2p(parent: "G2P | None", child: "G2P | None") -> "G2P | None":
    """Join the settings of two engines; those of another engine or voice replace the parent's."""
    if parent is None or child is None:
        return child or parent
    stated = {name: getattr(child, name) for name in child.model_fields_set}
    other = ("engine", "voice", "code", "file")
    if child.replace or any(stated.get(n, getattr(parent, n)) != getattr(parent, n) for n in other):
        return child
    for name in ADDED_FIELDS:
        stated[name] = tuple(dict.fromkeys((*stated.get(name, ()), *getattr(parent, name))))
    return parent.model_copy(update=stated)


def merge(parent: "Language", child: "Language") -> "Language":
    """Merge a child into its parent; a child that takes its parent's name keeps its tests."""
    stated = child.model_fields_set
    taken = {name: getattr(parent, name) for name in REPLACED_FIELDS if name not in stated}
    taken |= {name: {**getattr(parent, name), **getattr(child, name)} for name in MERGED_FIELDS}
    # a correction of a pack must not break its tests; a language of its own has other words
    if child.name == parent.name:
        stated_anew = {test.text for test in child.tests}
        kept = (test for test in parent.tests if test.text not in stated_anew)
        taken["tests"] = (*child.tests, *kept)
    # written forms are merged by entry, so that a child adds one abbreviation and keeps all others
    taken["text"] = child.text or parent.text
    if parent.text is not None and child.text is not None:
        forms = {name: getattr(child.text, name) for name in child.text.model_fields_set}
        for name, value in forms.items():
            if isinstance(value, dict):  # mappings by their entries, the rest as a whole
                forms[name] = {**getattr(parent.text, name), **value}
        taken["text"] = parent.text.model_copy(update=forms)
    taken["g2p"] = _joined_g2p(parent.g2p, child.g2p)
    taken["silence"] = tuple(dict.fromkeys((*parent.silence, *child.silence)))
    notations = {name: dict(labels) for name, labels in parent.notations.items()}
    for name, labels in child.notations.items():
        # `ɡ` and `g` are one label
        anew, known = set(map(normalise, labels)), notations.get(name, {}).items()
        others = {one: way for one, way in known if one in labels or normalise(one) not in anew}
        notations[name] = others | labels
    return child.model_copy(update={**taken, "notations": notations})


def joined(parent: Data, child: Data) -> Data:
    """Join values of two pose sets: mappings by entry, models by stated field, others replaced."""
    if isinstance(parent, dict) and isinstance(child, dict):
        return {**parent, **{name: joined(parent.get(name), one) for name, one in child.items()}}
    if isinstance(parent, BaseModel) and type(parent) is type(child):
        stated = {name: getattr(child, name) for name in child.model_fields_set}
        own = {name: joined(getattr(parent, name), one) for name, one in stated.items()}
        return parent.model_copy(update=own)
    return child


def merged_face(line: "list[Pack[PoseSet]]") -> "tuple[PoseSet, list[Fault]]":
    """Merge a pose set, the first, into those that it extends, in its names of their poses."""
    child, names = line[0].model, dict[str, str]()
    parts: list[PoseSet] = []
    faults: list[Fault] = []
    for number, pack in enumerate(line, 1):
        data, renamed = pack.source.data, pack.model.renamed
        parts.append(type(child).model_validate(data, context=names) if names else pack.model)
        names |= {old: names.get(new, new) for old, new in renamed.items()}
        models = [one.model for one in line[number:]]
        known = {pose for one in models for pose in (*one.poses, *one.posture_poses)}
        wrong = sorted(renamed.keys() - known)
        faults += [pack.unknown(("renamed", n), "P201", "pose", n, known, key=True) for n in wrong]
    whole = reduce(_over, reversed(parts))
    # the path of a model is that of its own file
    return whole.model_copy(update={"model": child.model, "renamed": child.renamed}), faults


def _over(parent: "PoseSet", child: "PoseSet") -> "PoseSet":
    """Join two pose sets; a target that the child states is its look as well."""
    looks = {name: one for name, one in parent.looks.items() if name not in child.targets}
    whole: PoseSet = joined(parent.model_copy(update={"looks": looks}), child)
    return whole


def test_fault(pack: "Pack[Language]", index: int, what: str, hint: str, *more: str) -> Fault:
    """Return the fault of a test at its place, which is another file if the test is inherited."""
    text = pack.model.tests[index].text
    for source in pack.sources[1:] if index >= len(pack.source.data.get("tests") or ()) else ():
        for number, test in enumerate(source.data.get("tests") or ()):
            if normalize("NFC", test["text"]) == normalize("NFC", text):
                place = source.where(("tests", number))
                hint = f"correct the map, or state this test again in {shown(pack.path)}"
                return Fault(shown(source.path), *place, "P221", what, hint)
    return pack.fault(("tests", index, *more), "P221", what, hint)
