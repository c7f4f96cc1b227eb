"""Heard trigrams: the sounds of a stream that begin a trigram, or can still begin one.

If two trigrams share a bigram, the first one plays, so each trigram depends on those before it. No
two trigrams begin at neighbouring sounds. Therefore a window makes the same choice as the whole
line if no trigram begins one sound before the window.
"""

from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.pipeline.track import trigrams_in

if TYPE_CHECKING:
    from lipsync_lang.performing.heard import Heard
    from lipsync_lang.pipeline.tables import Tables


def begun_trigrams(heard: "Heard", tables: "Tables") -> frozenset[int]:
    """Return the sounds that begin a trigram, by index; -1 is the silence before the first."""
    if not len(tables.trigrams) or not heard.sounds:
        return frozenset()
    before = not heard.forgotten and heard.sounds[0] != heard.silence
    ids = np.array([heard.silence] * before + heard.sounds)
    return frozenset(at - before for at in trigrams_in(ids, tables).tolist())


def open_trigram(heard: "Heard", tables: "Tables", silence_reach: float) -> float | None:
    """Return the time from which bigrams depend on the sound after the last one.

    Parameters
    ----------
    silence_reach : seconds of a silence that a bigram uses

    Returns
    -------
    None if no trigram can begin with the last two sounds
    """
    if not len(tables.trigrams) or not heard.sounds:
        return None
    only = len(heard.sounds) == 1
    before = heard.silence if only else heard.sounds[-2]
    if only and (heard.forgotten or heard.silent):
        return None
    size = len(tables.pairs)
    code = (before * size + heard.sounds[-1]) * size
    at = int(tables.trigrams.searchsorted(code))
    if at == len(tables.trigrams) or int(tables.trigrams[at]) >= code + size:
        return None
    if len(heard.sounds) - len(("one", "two", "three")) in begun_trigrams(heard, tables):
        return None
    if before != heard.silence:
        return heard.starts[-2]
    early = heard.starts[-1] - silence_reach
    first = only or (len(heard.sounds) == len(("silence", "sound")) and not heard.forgotten)
    return early if first else max(heard.starts[-2], early)
