"""Target file for an edit of a bigram."""

from collections.abc import Callable
from pathlib import Path

from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.finding import FOLDERS
from lipsync_lang.packs.yaml.faults import shown
from lipsync_lang.resolver.bigram_sources import stated
from lipsync_lang.resolver.compiled import Pair
from lipsync_lang.resolver.layers import NEUTRAL, PairPacks

PROJECT_BANK = "common"
"""Name of the bank for bigrams that are in no bank of the project."""


def bigram_home(
    packs: PairPacks, pair: Pair, project: Path, own: Callable[[Path], bool]
) -> tuple[Path, bool]:
    """Return the target file for an edit of a bigram, and True if that file has the bigram.

    The user's file with the bigram comes first, then the project's common bank, which may be new;
    `own` tells the files of the user. Raises LipsyncError if an installed character or a bank of
    one language states the bigram, and would take precedence over a common bank.
    """
    row = packs.row(pair)
    if row.place is not None and stated(packs, row) == "-".join(pair):
        if own(row.place.file):
            return row.place.file, True
        if row.origin.layer != "shared":
            raise LipsyncError(
                f"{shown(row.place.file)} is installed and precedes the banks of this "
                "project; copy it into the project to change it"
            )
    poseset = packs.poseset.model.name
    common = project / FOLDERS["poseset"] / poseset / "banks" / f"{PROJECT_BANK}.yaml"
    mine = [
        bank.path
        for bank in packs.banks
        if own(bank.path) and bank.model.language is None and bank.model.style == NEUTRAL
    ]
    return common if common in mine or not mine else mine[0], False
