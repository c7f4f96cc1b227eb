"""What needs two places or two files to be seen: named checks that yield faults.

Each check takes loaded packs and the names that are known; `validate.validate` runs them over
everything a library finds.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from lipsync_lang.errors import did_you_mean
from lipsync_lang.packs.conflicts import conflicts, path_between
from lipsync_lang.packs.faults import Fault
from lipsync_lang.packs.finding import beside
from lipsync_lang.packs.language_checks import check_labels
from lipsync_lang.packs.models import (
    Bank,
    Bigram,
    Character,
    Language,
    Phonemes,
    PoseSet,
    Rig,
    Threshold,
)
from lipsync_lang.packs.source import Loc

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Pack


def check_phonemes(common: "Pack[Phonemes]") -> Iterator[Fault]:
    """Silence, `base` and `like` name phonemes that are declared."""
    model = common.model
    known = {*model.phonemes, model.silence}
    for number, label in enumerate(model.base):
        yield from _phoneme(common, ("base", number), label, known)
    yield from _twice(common, ("base",), model.base)
    for label, phoneme in model.phonemes.items():
        if phoneme.like is not None:
            loc = ("phonemes", label, "like")
            yield from _phoneme(common, loc, phoneme.like, known - {label})


def check_language(language: "Pack[Language]", common: Phonemes) -> Iterator[Fault]:
    """Everything a language maps to is a phoneme it has."""
    model = language.model
    known = phonemes_of(model, common)
    yield from _adds(language, common, known)
    for notation, labels in model.notations.items():
        for label, sounds in labels.items():
            for number, sound in enumerate(sounds.to):
                loc: Loc = ("notations", notation, label, "to", number)
                yield from _phoneme(language, loc, sound, known, common)
    for word, sounded in model.words.items():
        for number, sound in enumerate(sounded):
            yield from _phoneme(language, ("words", word, number), sound, known, common)
    for index, test in enumerate(model.tests):
        for number, sound in enumerate(test.phonemes):
            loc = ("tests", index, "phonemes", number)
            yield from _phoneme(language, loc, sound, known, common)
    yield from _g2p(language)
    yield from check_labels(language)


def _adds(language: "Pack[Language]", common: Phonemes, known: Collection[str]) -> Iterator[Fault]:
    stated = language.source.data.get("adds")
    if isinstance(stated, tuple):
        yield from _twice(language, ("adds",), stated)
    for label, phoneme in language.model.adds.items():
        if phoneme is None:
            yield from _phoneme(language, ("adds", label), label, common.phonemes, key=True)
        elif label in common.phonemes:
            what = f"'{label}' is declared in the common pack already"
            hint = f"write `{label}: null` to add it as it is, or choose another label"
            yield language.fault(("adds", label), "P215", what, hint, key=True)
        elif phoneme.like is not None:
            loc = ("adds", label, "like")
            yield from _phoneme(language, loc, phoneme.like, set(known) - {label}, common)


def _g2p(language: "Pack[Language]") -> Iterator[Fault]:
    g2p, notations = language.model.g2p, language.model.notations
    if g2p is None:
        return
    if g2p.notation is not None and g2p.notation not in notations:
        hint = did_you_mean(g2p.notation, notations)
        what = f"unknown notation '{g2p.notation}'"
        yield language.fault(("g2p", "notation"), "P217", what, hint)
    place = language.where(("g2p", "file")).file
    if g2p.file is not None and beside(place, g2p.file) is None:
        what, hint = f"there is no file '{g2p.file}'", f"it belongs in {place.parent.name}/"
        yield language.fault(("g2p", "file"), "P213", what, hint)


def check_poseset(poseset: "Pack[PoseSet]", phonemes: Collection[str]) -> Iterator[Fault]:
    """A pose set speaks of its own poses and of phonemes that exist, and its rules agree."""
    model = poseset.model
    yield from _priority(poseset)
    for loc, pose in _poses_named(model):
        yield from _pose(poseset, loc, pose, model.poses)
    for name, contact in model.contacts.items():
        for number, label in enumerate(contact.phonemes):
            yield from _phoneme(poseset, ("contacts", name, "phonemes", number), label, phonemes)
        yield from _twice(poseset, ("contacts", name, "phonemes"), contact.phonemes)
    for label in model.targets:
        yield from _phoneme(poseset, ("targets", label), label, phonemes, key=True)
    yield from conflicts(poseset)
    yield from _without_target(poseset)


def _poses_named(model: PoseSet) -> Iterator[tuple[Loc, str]]:
    """Yield every place of a pose set that names a pose, but for `poses` itself."""
    for index, pair in enumerate(model.constraints.pairs):
        at = ("constraints", "pairs", index)
        if isinstance(pair, Threshold):
            yield from (((*at, "between", n), pose) for n, pose in enumerate(pair.between))
        else:
            yield (*at, "pose"), pair.pose
            yield (*at, "at_most"), pair.at_most
    yield from ((("priority", n), pose) for n, pose in enumerate(model.priority))
    for name, contact in model.contacts.items():
        yield from ((("contacts", name, "floor", pose), pose) for pose in contact.floor)
        yield from ((("contacts", name, "ceiling", pose), pose) for pose in contact.ceiling)
    for label, targets in model.targets.items():
        for index, target in enumerate(targets):
            at_target: Loc = ("targets", label, index)
            yield from (((*at_target, pose), pose) for pose in target.weights)
            yield from (((*at_target, "dominance", pose), pose) for pose in target.dominance)
    for name, gains in model.measures.items():
        yield from ((("measures", name, pose), pose) for pose in gains)


def _priority(poseset: "Pack[PoseSet]") -> Iterator[Fault]:
    yield from _twice(poseset, ("priority",), poseset.model.priority)


def _without_target(poseset: "Pack[PoseSet]") -> Iterator[Fault]:
    model = poseset.model
    moved = {p for targets in model.targets.values() for t in targets for p in t.weights}
    if not model.targets:
        return
    for pose in model.poses:
        if pose not in moved:
            what = f"no target moves '{pose}', so that drafts leave it at rest"
            hint = "name it under `targets`, or leave it to the banks"
            yield poseset.warning(("poses", pose), "W301", what, hint, key=True)


def check_bank(
    bank: "Pack[Bank]",
    poseset: PoseSet,
    phonemes: Collection[str] | None,
    languages: Collection[str],
) -> Iterator[Fault]:
    """A bank belongs to its pose set, and moves poses of it for phonemes that exist.

    `phonemes` may be None where nobody knows those of the bank's language.
    """
    yield from _belongs(bank, bank.model.poseset, poseset)
    if bank.model.language is not None and bank.model.language not in languages:
        hint = did_you_mean(bank.model.language, languages)
        yield bank.fault(("language",), "P210", f"unknown language '{bank.model.language}'", hint)
    yield from _bigrams(bank, bank.model.bigrams, poseset, phonemes)


def check_rig(rig: "Pack[Rig]", poseset: PoseSet) -> Iterator[Fault]:
    """A rig belongs to its pose set, and speaks of its poses and its own channels."""
    yield from _belongs(rig, rig.model.poseset, poseset)
    channels = rig.model.channels
    for name, channel in channels.items():
        for pose in channel.gains:
            yield from _pose(rig, ("channels", name, "gains", pose), pose, poseset.poses)
        if channel.at_most is not None:
            loc = ("channels", name, "at_most")
            yield from _channel(rig, loc, channel.at_most, [c for c in channels if c != name])
    for name in rig.model.names:
        yield from _channel(rig, ("names", name), name, channels, key=True)
    waits = {name: {c.at_most} if c.at_most else set() for name, c in channels.items()}
    for name, channel in channels.items():
        path = path_between(waits, channel.at_most, name) if channel.at_most else ()
        if path and channel.at_most != name:
            what = f"channels run in a circle: {' -> '.join((name, *path))}"
            loc = ("channels", name, "at_most")
            yield rig.fault(loc, "P206", what, "a channel cannot wait for itself; drop one")


def check_character(
    character: "Pack[Character]",
    poseset: PoseSet,
    phonemes: Collection[str],
    rigs: Collection[str],
    languages: Collection[str],
) -> Iterator[Fault]:
    """A character moves poses of its pose set, and its files exist."""
    model = character.model
    yield from _bigrams(character, model.bigrams, poseset, phonemes)
    for word, edit in model.words.items():
        for pose in edit.curves:
            yield from _pose(character, ("words", word, "curves", pose), pose, poseset.poses)
    for name, line in model.lines.items():
        for index, change in enumerate(line.edits):
            for pose in change.curves:
                loc = ("lines", name, "edits", index, "curves", pose)
                yield from _pose(character, loc, pose, poseset.poses)
    yield from _pronunciations(character, phonemes, languages)
    for number, file in enumerate(model.banks):
        if beside(character.path, file) is None:
            what, hint = f"there is no file '{file}'", "it belongs beside the character"
            yield character.fault(("banks", number), "P213", what, hint)
    if model.rig is not None and model.rig not in rigs:
        what, hint = f"unknown rig '{model.rig}'", did_you_mean(model.rig, rigs)
        yield character.fault(("rig",), "P212", what, hint)


def _pronunciations(
    character: "Pack[Character]", phonemes: Collection[str], languages: Collection[str]
) -> Iterator[Fault]:
    for language, words in character.model.pronunciations.items():
        said: Loc = ("pronunciations", language)
        if language not in languages:
            what, hint = f"unknown language '{language}'", did_you_mean(language, languages)
            yield character.fault(said, "P210", what, hint, key=True)
        for word, sounds in words.items():
            for number, sound in enumerate(sounds):
                yield from _phoneme(character, (*said, word, number), sound, phonemes)


def phonemes_of(language: Language, common: Phonemes) -> set[str]:
    """Return the common phonemes of a language: the base, silence, and what it adds."""
    return {*common.base, common.silence, *language.adds}


def _bigrams(
    pack: "Pack[Bank] | Pack[Character]",
    bigrams: Mapping[str, Bigram],
    poseset: PoseSet,
    phonemes: Collection[str] | None,
) -> Iterator[Fault]:
    for key, bigram in bigrams.items():
        for label in dict.fromkeys(key.split("-")):
            if phonemes is not None:
                yield from _phoneme(pack, ("bigrams", key), label, phonemes, key=True)
        for pose in bigram.curves:
            yield from _pose(pack, ("bigrams", key, "curves", pose), pose, poseset.poses)


def _belongs(pack: "Pack[Bank] | Pack[Rig]", stated: str, poseset: PoseSet) -> Iterator[Fault]:
    if stated != poseset.name:
        what = f"the pack is for pose set '{stated}', but lies in that of '{poseset.name}'"
        yield pack.fault(("poseset",), "P204", what, "move the file, or mend its `poseset`")


def _twice(pack: "Pack[Any]", loc: Loc, items: Iterable[str]) -> Iterator[Fault]:
    seen: set[str] = set()
    for number, item in enumerate(items):
        if item in seen:
            yield pack.fault((*loc, number), "P205", f"'{item}' stands twice in `{loc[-1]}`")
        seen.add(item)


def _pose(pack: "Pack[Any]", loc: Loc, pose: str, known: Collection[str]) -> Iterator[Fault]:
    if pose not in known:
        what, hint = f"unknown pose '{pose}'", did_you_mean(pose, known)
        yield pack.fault(loc, "P201", what, hint, key=pose == loc[-1])


def _phoneme(  # noqa: PLR0913 what a place may say of a phoneme
    pack: "Pack[Any]",
    loc: Loc,
    label: str,
    known: Collection[str],
    common: Phonemes | None = None,
    *,
    key: bool = False,
) -> Iterator[Fault]:
    if label in known:
        return
    hint = did_you_mean(label, known)
    if common is not None and label in common.phonemes:
        hint = f"it is beyond the base: put '{label}' in the language's `adds`"
    yield pack.fault(loc, "P202", f"unknown phoneme '{label}'", hint, key=key)


def _channel(
    rig: "Pack[Rig]", loc: Loc, name: str, known: Collection[str], *, key: bool = False
) -> Iterator[Fault]:
    if name not in known:
        yield rig.fault(
            loc, "P214", f"unknown channel '{name}'", did_you_mean(name, known), key=key
        )
