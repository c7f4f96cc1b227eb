"""Target file for an edit of a bigram."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.packs.finding import FOLDERS
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.resolver.bigram_sources import stated
from lipsync_lang.resolver.compiled import CompiledPair, Pair
from lipsync_lang.resolver.layers import NEUTRAL, BigramRow, PairPacks

PROJECT_BANK = "common"
"""Name of the bank for bigrams that are in no bank of the project."""


def bigram_home(
    packs: PairPacks, pair: Pair, project: Path, own: Callable[[Path], bool], style: str = NEUTRAL
) -> tuple[Path, bool]:
    """Return the target file for an edit of a bigram, and True if that file has the bigram.

    The user's file with the bigram comes first, then the project's common bank, or the bank of the
    style, which may be new; `own` tells the files of the user. Raises LipsyncError if an installed
    character or a bank of one language states the bigram, and would take precedence over a common
    bank, or if the file for a new bank of the style is taken.
    """
    row = styled_row(packs, pair, style)
    if row.style == style and row.place is not None and stated(packs, row) == "-".join(pair):
        if own(row.place.file):
            return row.place.file, True
        if row.origin.layer != "shared":
            raise LipsyncError(
                f"{shown(row.place.file)} is installed and precedes the banks of this "
                "project; copy it into the project to change it"
            )
    poseset = packs.poseset.model.name
    name = PROJECT_BANK if style == NEUTRAL else style
    common = project / FOLDERS["poseset"] / poseset / "banks" / f"{name}.yaml"
    mine = [
        bank.path
        for bank in packs.banks
        if own(bank.path) and bank.model.language is None and bank.model.style == style
    ]
    # The bank of a style is a new file of its name, which must not be a path, nor another bank.
    if style != NEUTRAL and not mine and (common.name != f"{style}.yaml" or common.exists()):
        raise LipsyncError(
            f"{shown(common)} cannot be the bank of the style {style}, as it has another content; "
            "write a bank with that `style` under another name"
        )
    return common if common in mine or not mine else mine[0], False


def styled_row(packs: PairPacks, pair: Pair, style: str) -> BigramRow:
    """Return the row of a pair in a style; the neutral row if the style has no other."""
    row = packs.authored(pair, style)
    if row is None or row.style != style:
        return packs.row(pair)
    return replace(row, origin=row.origin._replace(pair=pair))


def known_style(compiled: CompiledPair, style: str) -> str:
    """Return a style of the pair, or neutral for an empty name; refuse an unknown one."""
    known = compiled.style_names
    if style and style not in known:
        raise LipsyncError(f"unknown style '{style}'; {did_you_mean(style, known)}")
    return style or NEUTRAL
