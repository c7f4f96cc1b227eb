"""The commands that draft and show bigrams, and what a bank changes."""

import sys
from argparse import Namespace
from pathlib import Path

from lipsync_lang.base.files import STANDARD_STREAM, argument_path, atomic
from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.commands.performing import plot_kind
from lipsync_lang.commands.registry import Add, command, family
from lipsync_lang.commands.shared_options import add_json, add_pair, flag, option

SHOWN = 8
"""Limits on printed remarks per kind and on bigrams listed by a comparison."""


family(
    "bank", "show bigrams, draft them, import them, accept fitted ones, or see what a bank changes",
    "bank draft -l english -c facefx",
)  # fmt: skip


@command("bank draft")
def _add_draft(action: Add) -> None:
    made = action(
        draft,
        "draft bigrams from a pose set's targets",
        "bank draft -l english -c facefx --write l-ow h-eh",
        more=", as YAML to look at or to edit",
    )
    made.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    add_pair(made)
    flag(made, "--write", "write them to a bank or a character; its own bigrams stay")
    option(
        made, "--to FILE",
        "the bank or the character's file to write to [posesets/NAME/banks/common.yaml of this "
        "folder, which all characters of the pose set use]", type=Path,
    )  # fmt: skip


@command("bank show")
def _add_show(action: Add) -> None:
    made = action(
        show,
        "show bigrams as a character performs them, drawn or drafted",
        "bank show f-ah -l english -c facefx --plot f-ah.png",
    )
    made.add_argument("bigrams", metavar="BIGRAM", nargs="+", help="such as l-ow")
    add_pair(made)
    option(
        made, "--plot FILE", "draw their curves and control points; - is standard output, as PNG",
        type=argument_path,
    )  # fmt: skip
    add_json(made)


@command("bank diff")
def _add_diff(action: Add) -> None:
    made = action(
        diff,
        "show which bigrams a character's layers change, and by how much",
        "bank diff -l english -c facefx --plot changes.png",
        more="; without --against, a pose set's banks are compared with its drafts",
    )
    made.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    add_pair(made)
    option(
        made, "--against CHARACTER",
        "another character of the pose set, or the bare pose set [the layers below]",
    )  # fmt: skip
    option(
        made, "--plot FILE", "draw the bigrams that differ most; - is standard output, as PNG",
        type=argument_path,
    )  # fmt: skip
    flag(made, "--all", "list every bigram that differs")
    add_json(made)


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
