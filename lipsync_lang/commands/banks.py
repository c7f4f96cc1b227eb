"""Commands for bigram banks."""

import sys
from argparse import Namespace
from itertools import groupby
from typing import TYPE_CHECKING

from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.errors import LipsyncError
from lipsync_lang.files import STANDARD_STREAM

if TYPE_CHECKING:
    from lipsync_lang.banks.smartbody import Remarks

SHOWN = 8
"""Limits on printed remarks per kind and on bigrams listed by a comparison."""


def draft(options: Namespace) -> int:
    """Draft bigrams; print them as YAML or put them into a bank."""
    from lipsync_lang.banks.write import draft_yaml, write_drafts
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.drafts import draft_bigrams

    library = Library(options.path)
    drafts = draft_bigrams(library, options.language, options.character, options.bigrams)
    if options.write or options.to:
        print(write_drafts(library, drafts, options.to), file=sys.stderr)
    else:
        print(draft_yaml(drafts), end="")
    return SOUND


def import_(options: Namespace) -> int:
    """Put bigrams of another program into a bank."""
    from lipsync_lang.authoring.bank_import import import_bank
    from lipsync_lang.packs.library import Library

    imported = import_bank(
        Library(options.path), options.files, options.character,
        to=options.to, style=options.style, interpolation=options.interpolation,
        mapped=_mapped(options.map),
    )  # fmt: skip
    if options.json:
        print(as_json(imported.to_dict()))
    else:
        _print_remarks(imported.remarks)
        print(imported, file=sys.stderr)
    return SOUND


def _mapped(pairs: list[str]) -> dict[str, str]:
    """Parse ``THEIRS=OURS`` pairs."""
    mapped = {}
    for pair in pairs:
        theirs, equals, ours = pair.rpartition("=")
        if not equals or not theirs or not ours:
            raise LipsyncError(f"--map {pair}: write THEIRS=OURS, such as --map z=s")
        mapped[theirs] = ours
    return mapped


def _print_remarks(remarks: "Remarks") -> None:
    """Print the first remarks of each kind and the count of the rest."""
    kinds = list(remarks.counts)
    kept = sorted(remarks.kept, key=lambda remark: kinds.index(remark.kind))
    for kind, some in groupby(kept, key=lambda remark: remark.kind):
        for remark in list(some)[:SHOWN]:
            print(remark, file=sys.stderr)
        if remarks.counts[kind] > SHOWN:
            more = remarks.counts[kind] - SHOWN
            print(f"  ... and {more} more like these (--json lists them)", file=sys.stderr)


def diff(options: Namespace) -> int:
    """Show what a layer changes."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.bank_diff import diff_banks, told

    found = diff_banks(
        Library(options.path), options.language, options.character, options.against,
        options.bigrams,
    )  # fmt: skip
    if options.plot:
        from lipsync_lang.commands.performing import plot_kind
        from lipsync_lang.files import atomic
        from lipsync_lang.render.bank_diff_plot import plot_diff

        with atomic(options.plot) as stream:
            plot_diff(found, stream, plot_kind(options.plot))
    words = sys.stderr if options.plot == STANDARD_STREAM else sys.stdout
    if options.json:
        print(as_json(found.to_dict()), file=words)
    else:
        print(told(found, None if options.all or options.bigrams else SHOWN), file=words)
    return SOUND
