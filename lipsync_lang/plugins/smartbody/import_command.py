"""The command that imports phone-bigram banks of SmartBody."""

import sys
from argparse import Namespace
from itertools import groupby
from pathlib import Path

from lipsync_lang import LipsyncError
from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_options, option, repeated

SHOWN = 8
"""Limits on printed remarks per kind and on bigrams listed by a comparison."""


@command("bank import")
def _add_import(action: Add) -> None:
    made = action(
        import_,
        "import the phone-bigram banks of SmartBody",
        "bank import init-diphoneDefault.py -c facefx",
        more=", its Python scripts (which are read, never run) or its text exports",
    )
    made.add_argument("files", metavar="FILE", type=Path, nargs="+", help="a script or text export")
    option(
        made, "-c, --character POSESET",
        "the pose set whose poses the bank moves, or a character of it [the project's]",
    )  # fmt: skip
    option(
        made, "--to FILE",
        "the bank to write to; its own bigrams stay [posesets/NAME/banks/ of this folder, by the "
        "first file's name]", type=Path,
    )  # fmt: skip
    option(
        made, "--style NAME",
        "the manner of speaking: picks one of several sets, or renames the only one",
    )  # fmt: skip
    option(
        made, "--interpolation",
        "the kind of curve: linear curves pass through the keys, as the artist saw them; bspline "
        "curves are smooth and stay below them [linear]", choices=("bspline", "linear"),
        default="linear",
    )  # fmt: skip
    repeated(
        made, "--map THEIRS=OURS",
        "a phoneme or pose for a name in the file, such as z=s; may be repeated",
    )  # fmt: skip
    add_options(made, ["path", "json"])


def import_(options: Namespace) -> int:
    """Put bigrams of another program into a bank."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.plugins.smartbody.bank_import import import_bank

    mapped = {}
    for pair in options.map:
        theirs, _, ours = pair.rpartition("=")
        if not theirs or not ours:
            raise LipsyncError(f"--map {pair}: write THEIRS=OURS, such as --map z=s")
        mapped[theirs] = ours
    imported = import_bank(
        Library(options.path), options.files, options.character,
        to=options.to, style=options.style, interpolation=options.interpolation, mapped=mapped,
    )  # fmt: skip
    if options.json:
        print(as_json(imported.to_dict()))
        return SOUND
    remarks = imported.remarks
    kinds = list(remarks.counts)
    kept = sorted(remarks.kept, key=lambda remark: kinds.index(remark.kind))
    for kind, some in groupby(kept, key=lambda remark: remark.kind):
        for remark in list(some)[:SHOWN]:
            print(remark, file=sys.stderr)
        if remarks.counts[kind] > SHOWN:
            more = remarks.counts[kind] - SHOWN
            print(f"  ... and {more} more like these (--json lists them)", file=sys.stderr)
    print(imported, file=sys.stderr)
    return SOUND
