"""Drafts of bigrams for editing, also of bigrams in banks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lipsync_lang.banks.write import Drafts
from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.resolver.layers import PairPacks

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library


def draft_bigrams(
    library: "Library", language: str, character: str, wanted: Sequence[str] = ()
) -> Drafts:
    """Draft bigrams from the targets of a character's pose set, also bigrams in banks.

    Parameters
    ----------
    wanted : bigrams such as `l-ow`; none means every one that no bank answers

    Raises
    ------
    LipsyncError
        A wanted bigram is not one of this language, or its phonemes have no targets.
    """
    shelf = PairPacks.open(library, language, character)
    pairs = {"-".join(pair): pair for pair in shelf.pairs()}
    if wanted:
        pairs |= {"-".join(pair): pair for pair in shelf.shade_pairs()}
    for key in wanted:
        if key not in pairs:
            raise LipsyncError(f"unknown bigram '{key}' in {language}; {did_you_mean(key, pairs)}")
    chosen = list(wanted) or [key for key, pair in pairs.items() if shelf.authored(pair) is None]
    rows = shelf.drafts([pairs[key] for key in chosen])
    missing = [key for key in chosen if pairs[key] not in rows]
    if missing and wanted:
        raise LipsyncError(
            f"{shelf.poseset.model.name} has no targets to draft {', '.join(missing)} from; "
            f"add them in {shelf.poseset.path}"
        )
    return Drafts(
        shelf.poseset.model.name,
        {
            "-".join(pair): {
                shelf.poses[pose]: [[float(t), float(v)] for t, v in points]
                for pose, points in row.curves.items()
            }
            for pair, row in rows.items()
        },
        shelf.character.model.name if shelf.character.model.targets else "",
    )
