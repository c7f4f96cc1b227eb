"""Commands that list packs, show one, and draft new ones."""

import sys
from argparse import Namespace
from typing import TYPE_CHECKING

from lipsync_lang.commands.output import SOUND, as_json, lines_of, working
from lipsync_lang.errors import LipsyncError

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library


def packs(options: Namespace) -> int:
    """List packs of a kind, shadowed ones included, or show one."""
    from lipsync_lang.packs import describe
    from lipsync_lang.packs.library import Library

    library = Library(options.path)
    if options.action == "new":
        return _new_language(library, options)
    if options.action == "show":
        if options.name is None:
            raise LipsyncError(f"name the {options.kind} to show: {options.kind}s show NAME")
        if options.kind == "language":
            return _show_language(library, options)
        told = describe.show(library, options.kind, options.name)
    elif options.name is not None:
        raise LipsyncError(f"list takes no name; did you mean: {options.kind}s show {options.name}")
    else:
        told = describe.listing(library, options.kind)
    print(as_json(told.data) if options.json else told.text)
    return SOUND


def _new_language(library: "Library", options: Namespace) -> int:
    from lipsync_lang.authoring.draft import Wanted, draft

    if options.name is None:
        raise LipsyncError("name the new language: languages new NAME --voice sw")
    wanted = Wanted(
        options.name,
        tag=options.tag,
        title=options.title,
        voice=options.voice,
        epitran=options.epitran,
        lexicon=options.lexicon,
        inventory=options.inventory,
        inventory_id=options.inventory_id,
        texts=lines_of(options.text) if options.text else (),
    )
    with working(f"drafting {options.name}"):
        made = draft(library, wanted)
    print(made.write(), file=sys.stderr)
    return SOUND


def _show_language(library: "Library", options: Namespace) -> int:
    from lipsync_lang.authoring.language import describe
    from lipsync_lang.authoring.table import language_table

    with working(f"trying {options.name}"):
        told = describe(library, library.language(options.name))
    print(as_json(told) if options.json else language_table(told))
    return SOUND
