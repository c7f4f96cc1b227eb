"""Commands that list packs, show one, and draft new ones."""

import sys
from argparse import Namespace
from dataclasses import replace
from textwrap import indent
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError, count
from lipsync_lang.base.files import write_all
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, lines_of, tell_written, working
from lipsync_lang.commands.registry import handler

if TYPE_CHECKING:
    from lipsync_lang.authoring.new_pack import PackDraft
    from lipsync_lang.packs.describe import Description
    from lipsync_lang.packs.library import Library


@handler(
    "languages", "list language packs, show one, check one, or draft a new one", "languages list"
)
@handler("posesets", "list pose sets, show one, or draft a new one", "posesets list")
@handler("characters", "list characters, show one, or draft one from a model", "characters list")
def packs(options: Namespace) -> int:
    """List packs of a kind, shadowed ones included, or show one."""
    from lipsync_lang.packs import describe
    from lipsync_lang.packs.library import Library

    library = Library(options.path)
    if options.action in {"new", "solve"}:
        made: Any = NEW[options.kind](library, options)
        made.write()
        print(made, file=sys.stderr)
        if options.json and options.kind == "character":
            print(as_json(made.to_dict()))
        return SOUND
    if options.action == "check":
        return _check_language(library, options)
    # `vars`, since only some kinds of packs have these options.
    if any(vars(options).get(one) for one in ("picture", "sounds", "beside")):
        raise LipsyncError(f"{options.action} draws no picture; languages check NAME does")
    if vars(options).get("poses"):
        raise LipsyncError(f"{options.action} takes no poses; only `posesets new` does")
    if options.action == "show":
        if options.name is None:
            raise LipsyncError(f"name the {options.kind} to show: {options.kind}s show NAME")
        if options.kind == "language":
            from lipsync_lang.authoring.language_description import describe as describe_language
            from lipsync_lang.authoring.printing import language_table

            with working(f"trying {options.name}"):
                described = describe_language(library, library.language(options.name))
            print(as_json(described) if options.json else language_table(described))
            return SOUND
        told = _with_losses(library, options, describe.show(library, options.kind, options.name))
    elif options.name is not None:
        raise LipsyncError(f"list takes no name; run: {options.kind}s show {options.name}")
    else:
        told = describe.listing(library, options.kind)
    print(as_json(told.data) if options.json else told.text)
    return SOUND


def _with_losses(library: "Library", options: Namespace, told: "Description") -> "Description":
    """Add the losses of each rig of a pose set, or of a character's, and doubts of its model."""
    from lipsync_lang.faces.rigs.recognise import loss_table, losses
    from lipsync_lang.packs.describe import Description
    from lipsync_lang.resolver.rigging import face_on_model, load_rig

    if options.kind == "poseset":
        rigs, doubts = library.rigs(options.name), None
    else:
        who = library.character(options.name)
        poseset = library.poseset(who.model.poseset)
        poseset = replace(poseset, model=poseset.model.having(who.model.has))
        rigs = [load_rig(library, who.model.rig, poseset.model)] if who.model.rig else []
        face = face_on_model(library, who, poseset)
        doubts = [*face.told] if face else []
    found = {rig.model.name: losses(library, rig) for rig in rigs}
    lines = [
        f"\nnot shown by {name}\n{indent(loss_table(lost), '  ')}" for name, lost in found.items()
    ]
    data = {n: [one.to_dict() for one in lost] for n, lost in found.items()}
    more = {} if doubts is None else {"doubts": doubts}
    text = "\n".join([told.text, *(doubts or ()), *lines])
    return Description(text, {**told.data, **more, "losses": data})


def _new_language(library: "Library", options: Namespace) -> "PackDraft":
    from lipsync_lang.authoring.language_draft import LanguageWish, draft

    if options.name is None:
        raise LipsyncError("name the new language: languages new NAME --voice sw")
    wanted = LanguageWish(
        options.name, tag=options.tag, title=options.title, voice=options.voice,
        epitran=options.epitran, lexicon=options.lexicon, profile=options.profile,
        inventory=options.inventory, inventory_id=options.inventory_id,
        texts=lines_of(options.text) if options.text else (),
    )  # fmt: skip
    with working(f"drafting {options.name}"):
        return draft(library, wanted)


def _new_poseset(library: "Library", options: Namespace) -> "PackDraft":
    from lipsync_lang.authoring.poseset_draft import PoseSetWish, draft, solve_looks

    if options.action == "solve":
        if options.name is None:
            raise LipsyncError("name the pose set: posesets solve NAME --model FILE")
        return solve_looks(library, options.name, options.model)
    if options.name is None:
        raise LipsyncError("name the new pose set, and its poses: posesets new NAME POSE ...")
    wanted = PoseSetWish(
        options.name, poses=options.poses, model=options.model, like=options.like,
        title=options.title, guess=options.guess, solve=options.solve,
    )  # fmt: skip
    return draft(library, wanted)


def _new_character(library: "Library", options: Namespace) -> "PackDraft":
    from lipsync_lang.authoring.character_draft import CharacterWish, draft

    if options.name is None or options.model is None:
        what = "name the new character, and its model: characters new NAME --model FILE"
        raise LipsyncError(what)
    wanted = CharacterWish(
        options.name, options.model, options.poseset, options.rig, title=options.title
    )
    with working(f"trying pose sets on {options.model}"):
        return draft(library, wanted)


def _check_language(library: "Library", options: Namespace) -> int:
    """Print the faults, the mouths and the tests of a language pack."""
    from lipsync_lang.authoring.language_check import check_language, draw_mouths, mouths_to_draw
    from lipsync_lang.packs.finding import located
    from lipsync_lang.packs.library import Library
    from lipsync_lang.performing.resolving import resolve

    if options.name is None:
        raise LipsyncError("name the language or its file: languages check languages/NAME.yaml")
    if options.picture is not None and options.character is None:
        raise LipsyncError("--picture draws a character; name one with -c CHARACTER")
    if options.picture is None and (options.sounds or options.beside):
        raise LipsyncError("--sounds and --beside are for pictures; name one with --picture FILE")
    (name,), folders = located(options.path, language=options.name)
    library = Library(folders)
    with working(f"checking {name}"):
        found = check_language(library, library.find("language", name), options.character)
    if found.sounds is not None and options.picture is not None:
        sounds, paths = found.sounds, options.path
        # A draft of a language lacks bigrams, and its mouths are of single sounds.
        shown = mouths_to_draw(sounds, options.sounds.split(",") if options.sounds else ())
        performers = [
            resolve(options.name, one, paths=paths, gaps="rest")
            for one in dict.fromkeys((options.character, *options.beside))
        ]
        write_all({options.picture: lambda out: draw_mouths(performers, shown, out)})
        tell_written(options.picture)
    # A picture shows the table.
    told = found.told(table=options.picture is None)
    print(as_json(found.to_dict()) if options.json else told)
    faults = sum(fault.severity == "fault" for fault in found.faults)
    warnings = count(len(found.faults) - faults, "warning")
    print(f"{count(faults, 'fault')}, {warnings}", file=sys.stderr)
    return SOUND if found.sound else FAULTS


NEW = {"language": _new_language, "poseset": _new_poseset, "character": _new_character}
"""Draft functions by pack kind."""
