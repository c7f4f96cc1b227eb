"""The commands that draft and show bigrams, and what a bank changes."""

import sys
from argparse import Namespace

from lipsync_lang.base.files import STANDARD_STREAM, atomic
from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.commands.performing import plot_kind
from lipsync_lang.commands.registry import family, handler

SHOWN = 8
"""Limits on printed remarks per kind and on bigrams listed by a comparison."""


family(
    "bank", "show bigrams, draft them, import them, accept fitted ones, or see what a bank changes",
    "bank draft -l english -c facefx",
)  # fmt: skip


@handler(
    "bank draft",
    "draft bigrams from a pose set's targets",
    "bank draft -l english -c facefx --write l-ow h-eh",
    more=", as YAML to look at or to edit",
)
def draft(options: Namespace) -> int:
    """Draft bigrams; print them as YAML, or put them into a bank or a character."""
    from lipsync_lang.packs.banks.write import bigrams_yaml, write_drafts
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.bigram_sources import draft_bigrams

    library = Library(options.path)
    drafts = draft_bigrams(library, options.language, options.character, options.bigrams)
    if options.write or options.to:
        print(write_drafts(library, drafts, options.to), file=sys.stderr)
    else:
        print(bigrams_yaml(drafts), end="")
    return SOUND


@handler(
    "bank show",
    "show bigrams as a character performs them, drawn or drafted",
    "bank show f-ah -l english -c facefx --plot f-ah.png",
)
def show(options: Namespace) -> int:
    """Show bigrams: their source, their control points, and a picture."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.bigram_sources import show_bigrams

    found = show_bigrams(
        Library(options.path), options.language, options.character, options.bigrams
    )
    if options.plot:
        from lipsync_lang.render.bigram_plot import plot_bigrams

        with atomic(options.plot) as stream:
            plot_bigrams(found, stream, plot_kind(options.plot))
    _print(options, [one.to_dict() for one in found], "\n".join(one.told() for one in found))
    return SOUND


@handler(
    "bank diff",
    "show which bigrams a character's layers change, and by how much",
    "bank diff -l english -c facefx --plot changes.png",
    more="; without --against, a pose set's banks are compared with its drafts",
)
def diff(options: Namespace) -> int:
    """Show what a layer changes."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.bank_diff import diff_banks, told

    found = diff_banks(
        Library(options.path), options.language, options.character, options.against,
        options.bigrams,
    )  # fmt: skip
    if options.plot:
        from lipsync_lang.render.bigram_plot import plot_diff

        with atomic(options.plot) as stream:
            plot_diff(found, stream, plot_kind(options.plot))
    _print(options, found.to_dict(), told(found, None if options.all or options.bigrams else SHOWN))
    return SOUND


def _print(options: Namespace, data: object, text: str) -> None:
    """Print what is shown, as JSON if asked."""
    # The picture takes standard output, so the words move aside.
    words = sys.stderr if options.plot == STANDARD_STREAM else sys.stdout
    print(as_json(data) if options.json else text, file=words)
