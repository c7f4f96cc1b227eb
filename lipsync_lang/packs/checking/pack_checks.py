"""Check references within a pack and between packs; each check yields faults.

A check takes loaded packs and collections of known names. `validate.validate` runs the checks over
all packs of a library.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lipsync_lang.base.errors import PackError, did_you_mean
from lipsync_lang.packs import models
from lipsync_lang.packs.checking.conflicts import conflicts, unprepared
from lipsync_lang.packs.checking.language_checks import check_labels, notation_of
from lipsync_lang.packs.finding import NONE_UNSAVED, beside, model_beside
from lipsync_lang.packs.models.language_models import AudioFields
from lipsync_lang.packs.models.pose_models import MouthOrigin
from lipsync_lang.packs.models.rig_models import expanded
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.source import Loc


def check_phonemes(common: Pack[models.Phonemes]) -> Iterator[Fault]:
    """Check that silence, `base`, `like` and mouth shapes name declared phonemes."""
    model = common.model
    known = {*model.phonemes, model.silence}
    yield from _phonemes(common, ("base",), model.base, known)
    yield from _twice(common, ("base",), model.base)
    for label, phoneme in model.phonemes.items():
        if phoneme.like is not None:
            loc = ("phonemes", label, "like")
            yield from _phoneme(common, loc, phoneme.like, known - {label})
    yield from _shades(common)
    for name, table in model.usual.items():
        for label, sounds in table.items():
            loc = ("usual", name, label)
            yield from _phonemes(common, loc, sounds.to, with_shades(known, model))
    everywhere = {*model.base, model.silence}
    for name, notation in model.visemes.items():
        for label, sounds in notation.labels.items():
            place: Loc = ("visemes", name, "labels", label, "to")
            yield from _phonemes(common, place, sounds.to, everywhere)


def _shades(common: Pack[models.Phonemes]) -> Iterator[Fault]:
    """Check that each shade has a name of its own, and a parent that is not a shade."""
    model = common.model
    parents = {*model.phonemes} - {model.silence}
    for label, shade in model.shades.items():
        loc: Loc = ("shades", label)
        if label in model.phonemes or label == model.silence:
            what = f"shade '{label}' has the name of a phoneme"
            yield common.fault(loc, "P215", what, "choose another label", key=True)
        if shade.like in model.shades and shade.like not in parents:
            above = model.shades[shade.like].like
            what = f"the parent of shade '{label}' is '{shade.like}', which is a shade itself"
            hint = f"name a phoneme instead, such as '{above}'"
            yield common.fault((*loc, "like"), "P227", what, hint)
        else:
            yield from _phoneme(common, (*loc, "like"), shade.like, parents)


def check_language(language: Pack[models.Language], common: models.Phonemes) -> Iterator[Fault]:
    """Check that a language maps labels and words to its own phonemes only."""
    model = language.model
    known = with_shades({*common.base, common.silence, *model.adds}, common)
    yield from _adds(language, common, known)
    for notation, labels in model.notations.items():
        for label, sounds in labels.items():
            loc: Loc = ("notations", notation, label, "to")
            yield from _phonemes(language, loc, sounds.to, known, common)
    for number, name in enumerate(model.stress_digits):
        if name not in model.notations:
            place = ("stress_digits", number)
            yield language.unknown(place, "P217", "notation", name, model.notations)
    yield from _similar_notations(language)
    for word, reading in model.words.items():
        yield from _phonemes(language, ("words", word, "phonemes"), reading.phonemes, known, common)
    for index, test in enumerate(model.tests):
        yield from _phonemes(language, ("tests", index, "phonemes"), test.phonemes, known, common)
        yield from _phonemes(language, ("tests", index, "read"), test.read, known, common)
    yield from _engines(language)
    yield from check_labels(language)


def _adds(
    language: Pack[models.Language], common: models.Phonemes, known: Collection[str]
) -> Iterator[Fault]:
    # the model has a mapping, which lost the items that a list states twice
    stated = language.source.data.get("adds")
    if isinstance(stated, tuple):
        yield from _twice(language, ("adds",), stated)
    for label, phoneme in language.model.adds.items():
        if phoneme is None:
            yield from _phoneme(language, ("adds", label), label, common.phonemes, key=True)
        elif label in common.phonemes or label in common.shades:
            what = f"'{label}' is declared in the common pack already"
            hint = f"write `{label}: null` to add it unchanged, or choose another label"
            hint = "choose another label" if label in common.shades else hint
            yield language.fault(("adds", label), "P215", what, hint, key=True)
        elif phoneme.like is not None:
            loc = ("adds", label, "like")
            yield from _phoneme(language, loc, phoneme.like, set(known) - {label}, common)


def _engines(language: Pack[models.Language]) -> Iterator[Fault]:
    """Check that `g2p` and `audio` name a notation of the language, and `audio` its labels."""
    model, g2p, audio = language.model, language.model.g2p, language.model.audio
    for field, part in (("g2p", g2p), ("audio", audio)):
        name = part.notation if part is not None else None
        if name is not None and name not in model.notations:
            yield language.unknown((field, "notation"), "P217", "notation", name, model.notations)
    if g2p is not None:
        yield from _file(language, ("g2p", "file"), g2p.file)
    if audio is not None:
        yield from _acoustic_models(language, audio)
    if audio is None or audio.notation not in model.notations:
        return
    notation = notation_of(model, audio.notation)
    stated = [("phones", *item) for item in audio.phones.items()]
    for field, label, phones in [*stated, *(("also", *item) for item in audio.also.items())]:
        for phone in phones:
            if notation.find(phone) is None:
                what = f"'{phone}' is not in the notation '{audio.notation}'"
                hint = notation.suggest(phone)
                yield language.fault(("audio", field, label), "P218", what, hint)


def _similar_notations(language: Pack[models.Language]) -> Iterator[Fault]:
    """Warn of notations that a child adds beside one of nearly the same name of its parent."""
    own, *above = [source.data.get("notations") or {} for source in language.sources]
    inherited = {name for one in above for name in one}
    for name in own if isinstance(own, dict) else ():
        near = did_you_mean(name, inherited) if name not in inherited else ""
        if near.startswith("did"):
            what = f"notation '{name}' is a new one beside those of the parent"
            yield language.warning(("notations", name), "W321", what, near, key=True)


def _acoustic_models(language: Pack[models.Language], audio: AudioFields) -> Iterator[Fault]:
    """Check that the models of `audio` lie in the folder of packs, or have a name alone."""
    engines = [("align", one) for one in audio.align] + [("recognise", audio.recognise or "")]
    for field, engine in (*engines, ("model", f":{audio.model or ''}")):
        try:
            model_beside(language.where(("audio", field)).file, engine)
        except PackError as error:
            what, _, hint = str(error).partition(": ")[2].partition("; ")
            yield language.fault(("audio", field), "P213", what, hint)


def check_poseset(
    poseset: Pack[models.PoseSet],
    phonemes: Collection[str],
    banks: Iterable[models.BankPack] | None = None,
    common: models.Phonemes | None = None,
) -> Iterator[Fault]:
    """Check that a pose set names its own poses and known phonemes, and that its rules agree.

    `banks` are the pose set's banks; None if one cannot be loaded. `common` is for hints.
    """
    yield from _gestures(poseset)
    # rules may name poses that few models have
    model = poseset.model.having(poseset.model.optional_poses)
    poseset = replace(poseset, model=model)
    yield from _twice(poseset, ("priority",), model.priority)
    yield from _poses(poseset)
    for loc, pose in _poses_named(model):
        yield from _pose(poseset, loc, pose, model)
    for name, contact in model.contacts.items():
        place: Loc = ("contacts", name, "phonemes")
        yield from _phonemes(poseset, place, contact.phonemes, phonemes, common)
        yield from _twice(poseset, place, contact.phonemes)
    for label in model.targets:
        yield from _phoneme(poseset, ("targets", label), label, phonemes, common, key=True)
    yield from _rules(poseset, model.checks, model, phonemes)
    yield from _regions(poseset, ("softness",), model.softness, model)
    for number, region in enumerate(model.intensity.regions if model.intensity else ()):
        yield from _regions(poseset, ("intensity", "regions", number), [region], model, key=False)
    for name, style in model.styles.items():
        yield from _regions(poseset, ("styles", name, "regions"), style.regions, model)
        for pose in style.posture:
            if pose not in model.posture_poses:
                yield from _pose(poseset, ("styles", name, "posture", pose), pose, model)
    yield from _postures(poseset)
    for part, other in model.mirrored.items():
        if not model.mirrors(part):
            what = f"no pose has '{part}' in its name where another has '{other}'"
            hint = "spell both parts as the names of poses do, such as `Left: Right`"
            yield poseset.fault(("mirrored", part), "P235", what, hint, key=True)
    yield from _file(poseset, ("model",), model.model)
    yield from conflicts(poseset, banks)


def _poses_named(model: models.PoseSet) -> Iterator[tuple[Loc, str]]:
    """Yield (place, name) for every pose named outside `poses`."""
    for index, pair in enumerate(model.constraints.pairs):
        at = ("constraints", "pairs", index)
        if isinstance(pair, models.Threshold):
            yield from (((*at, "between", n), pose) for n, pose in enumerate(pair.between))
        else:
            yield (*at, "pose"), pair.pose
            yield (*at, "at_most"), pair.at_most
    yield from ((("priority", n), pose) for n, pose in enumerate(model.priority))
    for name, contact in model.contacts.items():
        yield from ((("contacts", name, "floor", pose), pose) for pose in contact.floor)
        yield from ((("contacts", name, "ceiling", pose), pose) for pose in contact.ceiling)
    yield from _poses_targeted(model)
    for name, style in model.styles.items():
        yield from ((("styles", name, "scale", pose), pose) for pose in style.scale)
        yield from ((("styles", name, "offset", pose), pose) for pose in style.offset)
    for name, gains in model.measures.items():
        yield from ((("measures", name, pose), pose) for pose in gains)


def _poses_targeted(model: models.PoseSet | models.Character) -> Iterator[tuple[Loc, str]]:
    """Yield (place, name) for every pose of a target."""
    for label, targets in model.targets.items():
        for index, target in enumerate(targets):
            at: Loc = ("targets", label, index)
            yield from (((*at, pose), pose) for pose in target.weights)
            yield from (((*at, "dominance", pose), pose) for pose in target.dominance)


def _poses(poseset: Pack[models.PoseSet]) -> Iterator[Fault]:
    """Check that each spelling belongs to one pose, none is the face at rest, and targets move all.

    A pose set without targets leaves all its poses to the banks.
    """
    model = poseset.model
    moved = {p for targets in model.targets.values() for t in targets for p in t.weights}
    if model.neutral in model.poses:
        what = f"the face at rest and a pose have the same name, '{model.neutral}'"
        yield poseset.fault(("neutral",), "P225", what, "rename one, or remove the pose")
    owners = {pose.casefold(): pose for pose in model.poses}
    for pose, told in model.poses.items():
        field = "optional_poses" if pose in model.optional_poses else "poses"
        for number, text in enumerate(told.names):
            for spelling in expanded(text):
                owner = owners.setdefault(spelling.casefold(), pose)
                if owner != pose:
                    what = f"the shape name '{spelling}' belongs to '{owner}' and to '{pose}'"
                    hint = f"give it to one pose; '{owner}' comes first"
                    yield poseset.fault((field, pose, "names", number), "P224", what, hint)
        if model.targets and pose not in moved:
            what = f"no target moves '{pose}', so drafts leave it at rest"
            hint = "name it under `targets`, or leave it to the banks"
            yield poseset.warning((field, pose), "W301", what, hint, key=True)


def _postures(poseset: Pack[models.PoseSet]) -> Iterator[Fault]:
    """Check that postures have poses of their own, limited beside known poses and contacts."""
    model = poseset.model
    for name, pose in model.posture_poses.items():
        at: Loc = ("posture_poses", name)
        if name in model.poses or name in model.gesture_poses:
            what = f"'{name}' is a pose of speech or of gestures already"
            yield poseset.fault(at, "P232", what, "delete one of the two", key=True)
        for other in pose.together:
            yield from _pose(poseset, (*at, "together", other), other, model)
        for contact in pose.ceiling:
            if contact not in model.contacts:
                loc = (*at, "ceiling", contact)
                yield poseset.unknown(loc, "P201", "contact", contact, model.contacts, key=True)


def _gestures(poseset: Pack[models.PoseSet]) -> Iterator[Fault]:
    """Check that gestures move poses of their own, within their bounds and speed."""
    model = poseset.model
    for field in ("gesture_poses", "optional_poses"):
        for pose in getattr(model, field).keys() & model.poses.keys():
            what = f"'{pose}' is a pose of speech already"
            yield poseset.fault((field, pose), "P232", what, "delete one of the two", key=True)
    for name, gesture in model.gestures.items():
        for pose in gesture.poses:
            loc: Loc = ("gestures", name, "poses", pose)
            stated = model.gesture_poses.get(pose)
            if pose in model.poses:
                what = f"speech moves '{pose}', so the gesture '{name}' may not"
                hint = "move another shape, declared under `gesture_poses`"
                yield poseset.fault(loc, "P232", what, hint, key=True)
            elif stated is None:
                yield poseset.unknown(loc, "P201", "pose", pose, model.gesture_poses, key=True)
            else:
                yield from _gesture_bounds(poseset, loc, gesture, stated)


def _gesture_bounds(
    poseset: Pack[models.PoseSet], loc: Loc, gesture: models.Gesture, pose: models.GesturePose
) -> Iterator[Fault]:
    """Check that a gesture keeps to the largest amount and the speed of one of its poses."""
    least = 0.0 if pose.node is None else -pose.most
    for reached in gesture.amounts(str(loc[-1])):
        if not least <= reached <= pose.most:
            what = f"'{loc[-1]}' goes from {least:g} to {pose.most:g}, not to {reached:g}"
            yield poseset.fault(loc, "P233", what, "lower the amount, or raise `most`")
    speed, unit = gesture.speed(str(loc[-1])), "" if pose.node is None else " degrees"
    # floats of a curve that meets its limit exactly may exceed it by a digit
    if speed > pose.speed_limit * (1 + 1e-9):
        what = f"'{loc[-1]}' moves by {speed:.3g}{unit} a second; its limit is {pose.speed_limit:g}"
        hint = "give the curve more seconds, lower the amount, or raise `speed_limit`"
        yield poseset.fault(loc, "P233", what, hint)


def check_bank(
    bank: Pack[models.BankPack],
    poseset: models.PoseSet,
    phonemes: Collection[str] | None,
    languages: Collection[str],
) -> Iterator[Fault]:
    """Check that a bank fits its pose set and language, and names known poses and phonemes.

    `phonemes` is None if those of the bank's language are unknown.
    """
    yield from check_home(bank, bank.model.poseset, poseset)
    poseset = poseset.having(poseset.optional_poses)
    language = bank.model.language
    if language is not None and language not in languages:
        yield bank.unknown(("language",), "P210", "language", language, languages)
    yield from check_bigrams(bank, bank.model.bigrams, poseset, phonemes)
    yield from check_bigrams(bank, bank.model.trigrams, poseset, phonemes, field="trigrams")


def check_character(  # noqa: PLR0913 the packs that a character refers to
    character: Pack[models.Character],
    poseset: models.PoseSet,
    phonemes: Collection[str],
    *,
    rigs: Collection[str],
    languages: Collection[str],
    styles: Collection[str],
    unsaved: Mapping[Path, bytes] = NONE_UNSAVED,
) -> Iterator[Fault]:
    """Check that a character names known poses, phonemes, regions and styles, and its files."""
    model = character.model
    poseset = poseset.having(model.has)
    yield from _delivery(character, (), model, poseset, styles)
    for name, line in model.lines.items():
        yield from _delivery(character, ("lines", name), line, poseset, styles)
        yield from _placed(character, name, line, poseset)
        yield from check_poses(character, ("lines", name, "bends"), line.bends, poseset)
    yield from check_bigrams(character, model.bigrams, poseset, phonemes)
    yield from _own_drafts(character, poseset, phonemes)
    yield from check_bigrams(character, model.trigrams, poseset, phonemes, field="trigrams")
    lines = ((name, one) for name, line in model.lines.items() for one in enumerate(line.edits))
    drawn: list[tuple[Loc, Iterable[str]]] = [
        *((("words", word), edit.curves) for word, edit in model.words.items()),
        *((("lines", name, "edits", index), edit.curves) for name, (index, edit) in lines),
    ]
    for loc, curves in drawn:
        yield from check_poses(character, (*loc, "curves"), curves, poseset)
    for language, words in model.pronunciations.items():
        said: Loc = ("pronunciations", language)
        if language not in languages:
            yield character.unknown(said, "P210", "language", language, languages, key=True)
        for word, sounds in words.items():
            yield from _phonemes(character, (*said, word), sounds, phonemes)
    yield from _rules(character, model.checks, poseset, phonemes)
    for number, file in enumerate(model.banks):
        if beside(character.path, file, unsaved) is None:
            what, hint = f"there is no file '{file}'", "it belongs beside the character"
            yield character.fault(("banks", number), "P213", what, hint)
    yield from _file(character, ("model",), model.model)
    if model.rig is not None and model.rig not in rigs:
        yield character.unknown(("rig",), "P212", "rig", model.rig, rigs)


def _own_drafts(
    character: Pack[models.Character], poseset: models.PoseSet, phonemes: Collection[str]
) -> Iterator[Fault]:
    """Check the poses, targets and seconds of a character for unknown names."""
    model, optional = character.model, poseset.optional_poses
    for number, pose in enumerate(model.has):
        if pose not in optional:
            yield character.unknown(("has", number), "P201", "optional pose", pose, optional)
    for field in ("targets", "mouths"):
        for label in getattr(model, field):
            yield from _phoneme(character, (field, label), label, phonemes, key=True)
    for loc, pose in _poses_targeted(model):
        yield from _pose(character, loc, pose, poseset)
    yield from unprepared(character, poseset)
    yield from _regions(character, ("softness",), model.softness, poseset)
    yield from check_poses(character, ("anticipate",), model.anticipate, poseset)
    for item in model.fitted:
        if model.scalar(item) is None:
            what, hint = f"the character states no `{item}`", "delete this line"
            yield character.warning(("fitted", item), "W308", what, hint, key=True)


def idle_mouths(
    character: Pack[models.Character],
    poseset: models.PoseSet,
    project: MouthOrigin | None = None,
    *,
    solved: bool | None = None,
) -> Iterator[Fault]:
    """Warn of mouths without an effect, because no target is solved for them.

    `project` is the `mouth` of the project, and `solved` tells if the model was solved. None for a
    model that nobody has read: it may be.
    """
    model, hint = character.model, "state the weights under `targets`"
    stated = "mouths" if model.mouths else "mouth" if model.mouth == "solved" else None
    if (model.mouth or project or poseset.mouth) == "declared":
        who = "the character" if model.mouth else "the project" if project else "the pose set"
        why, hint = f"{who} keeps declared targets", f"state `mouth: solved` here, or {hint}"
    elif model.model is not None:
        why, solved = "the mouth of its model cannot be measured", solved is not False
    elif poseset.model is not None:
        why = f"{poseset.name} keeps the targets that were made for its own model"
    else:
        why, hint = "the character has no model", f"name one under `model`, or {hint}"
    if stated and not solved:
        yield character.warning((stated,), "W322", f"no effect, because {why}", hint, key=True)
    for name in [name for name in model.mouths if solved and name in model.targets]:
        told = f"no effect on the motion, because `targets` states the weights of '{name}'"
        yield character.warning(("mouths", name), "W322", told, "delete one of both", key=True)


def _rules(
    pack: Pack[models.PoseSet] | Pack[models.Character],
    stated: models.Checks,
    poseset: models.PoseSet,
    phonemes: Collection[str],
) -> Iterator[Fault]:
    """Check that rules name known phonemes and measures of the pose set."""
    for name, rule in stated.rules.items():
        at: Loc = ("checks", "rules", name)
        yield from _phonemes(pack, (*at, "phonemes"), rule.phonemes, phonemes)
        yield from _twice(pack, (*at, "phonemes"), rule.phonemes)
        if rule.measure not in poseset.measures:
            hint = did_you_mean(rule.measure, poseset.measures)
            if not poseset.measures:
                hint = "state it under `measures` of the pose set, as sums of gain times pose"
            yield pack.fault((*at, "measure"), "P231", f"unknown measure '{rule.measure}'", hint)


def _file(pack: Pack[Any], loc: Loc, file: str | None) -> Iterator[Fault]:
    """Check that a file named by a pack lies beside the file that names it."""
    # an inherited file lies beside the parent, which states it
    place = pack.where(loc).file
    if file is not None and beside(place, file) is None:
        hint = f"it belongs in {place.parent.name}/: copy it there, and state its path from there"
        yield pack.fault(loc, "P213", f"{place.parent.name}/ has no file '{file}'", hint)


def _regions(
    pack: Pack[Any], loc: Loc, named: Iterable[str], poseset: models.PoseSet, *, key: bool = True
) -> Iterator[Fault]:
    """Check that regions, which are the keys at a place, are those of poses."""
    known = sorted({pose.region for pose in poseset.poses.values() if pose.region})
    for region in named:
        if region not in known:
            place = (*loc, region) if key else loc
            yield pack.unknown(place, "P230", "region", region, known, key=key)


def _delivery(
    character: Pack[models.Character],
    at: Loc,
    stated: models.Delivery,
    poseset: models.PoseSet,
    styles: Collection[str],
) -> Iterator[Fault]:
    """Check that dials name regions of the pose set, and that styles have a bank or a draft."""
    yield from _regions(character, (*at, "dials"), stated.dials, poseset)
    for name in stated.gestures:
        if name not in poseset.gestures:
            place: Loc = (*at, "gestures", name)
            yield character.unknown(place, "P234", "gesture", name, poseset.gestures, key=True)
    # all styles are shares over the default one, which is what is left of them
    known = {*styles, *poseset.styles} - {models.BankPack.model_fields["style"].default}
    for style in stated.styles:
        if style not in known:
            what = f"no bank has the style '{style}', so it has no effect"
            hint = did_you_mean(style, known) if known else "write a bank that states `style:`"
            yield character.warning((*at, "styles", style), "W320", what, hint, key=True)


def _placed(
    character: Pack[models.Character], name: str, line: models.LineEdits, poseset: models.PoseSet
) -> Iterator[Fault]:
    """Check that a line places gestures of the pose set."""
    for index, one in enumerate(line.placed):
        if one.gesture not in poseset.gestures:
            at: Loc = ("lines", name, "placed", index, "gesture")
            yield character.unknown(at, "P234", "gesture", one.gesture, poseset.gestures)


def with_shades(phonemes: Collection[str], common: models.Phonemes) -> set[str]:
    """Return phonemes together with the shades of each."""
    shades = (name for name, shade in common.shades.items() if shade.like in phonemes)
    return {*phonemes, *shades}


def check_bigrams(
    pack: Pack[models.BankPack] | Pack[models.Character],
    bigrams: Mapping[str, models.BigramCurves | models.TrigramCurves],
    poseset: models.PoseSet,
    phonemes: Collection[str] | None,
    *,
    field: str = "bigrams",
) -> Iterator[Fault]:
    """Check that bigrams, or the trigrams of another field, name known phonemes and poses."""
    for key, bigram in bigrams.items():
        for label in dict.fromkeys(key.split("-")):
            if phonemes is not None:
                yield from _phoneme(pack, (field, key), label, phonemes, key=True)
        yield from check_poses(pack, (field, key, "curves"), bigram.curves, poseset)


def check_home(
    pack: Pack[models.BankPack] | Pack[models.RigPack], stated: str, poseset: models.PoseSet
) -> Iterator[Fault]:
    """Check that a bank or rig lies in the folder of its pose set."""
    if stated != poseset.name:
        what = f"the pack is for pose set '{stated}', but is in the folder of '{poseset.name}'"
        yield pack.fault(("poseset",), "P204", what, "move the file, or correct its `poseset`")


def _twice(pack: Pack[Any], loc: Loc, items: Iterable[str]) -> Iterator[Fault]:
    seen: set[str] = set()
    for number, item in enumerate(items):
        if item in seen:
            yield pack.fault((*loc, number), "P205", f"'{item}' appears twice in `{loc[-1]}`")
        seen.add(item)


def check_poses(
    pack: Pack[Any], loc: Loc, named: Iterable[str], poseset: models.PoseSet
) -> Iterator[Fault]:
    """Check that the keys at a place are poses of a pose set."""
    for pose in named:
        yield from _pose(pack, (*loc, pose), pose, poseset)


def _pose(pack: Pack[Any], loc: Loc, pose: str, poseset: models.PoseSet) -> Iterator[Fault]:
    if pose not in poseset.poses:
        yield pack.unknown(loc, "P201", "pose", pose, poseset.poses, key=pose == loc[-1])


def _phonemes(
    pack: Pack[Any],
    loc: Loc,
    labels: Iterable[str],
    known: Collection[str],
    common: models.Phonemes | None = None,
) -> Iterator[Fault]:
    """Check that each label of a list is a known phoneme."""
    for number, label in enumerate(labels):
        yield from _phoneme(pack, (*loc, number), label, known, common)


def _phoneme(  # noqa: PLR0913 the phoneme, its place and options
    pack: Pack[Any],
    loc: Loc,
    label: str,
    known: Collection[str],
    common: models.Phonemes | None = None,
    *,
    key: bool = False,
) -> Iterator[Fault]:
    if label in known:
        return
    # a letter of the IPA is the likeliest mistake, and similar spelling would suggest another
    sounds = {} if common is None else {**common.shades, **common.phonemes}
    sounding = (name for name, one in sounds.items() if label in one.ipa)
    whole = next((name for name in sounding if name in known), None)
    hint = did_you_mean(label, known) if whole is None else f"write '{whole}' for it"
    if common is not None and label in common.shades:
        parent = common.shades[label].like
        hint = f"it is a shade of '{parent}': put '{parent}' in the language's `adds`"
    elif common is not None and label in common.phonemes:
        hint = f"it is beyond the base: put '{label}' in the language's `adds`"
    yield pack.fault(loc, "P202", f"unknown phoneme '{label}'", hint, key=key)
