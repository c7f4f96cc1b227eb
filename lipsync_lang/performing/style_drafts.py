"""Banks of drafted styles: neutral curves, scaled and offset as the pose set states.

A bank is as large as the neutral one, so it is made for the first use of a style.
"""

from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.pipeline.tables import RESOLUTION, Tables

if TYPE_CHECKING:
    from lipsync_lang.resolver.compiled import CompiledPair


def with_drafts(compiled: "CompiledPair", heard: Collection[str]) -> Tables:
    """Return the tables with a bank for each drafted style, in the order of `style_names`.

    Parameters
    ----------
    heard : styles to draft; the banks of the others stay neutral, and must not be used
    """
    tables = compiled.tables
    sounding = _sounding(compiled)
    banks = []
    for name, draft in compiled.style_drafts.items():
        bank = tables.neutral
        if name in heard:
            scale, offset = (np.array(draft[part], np.float32) for part in ("scale", "offset"))
            curves = bank.curves * scale
            for pose in np.flatnonzero(offset):
                # in place: the curves of a pair take some megabytes
                curves[:, :, pose] += offset[pose] * sounding
            np.clip(curves, 0, 1, out=curves)
            curves.setflags(write=False)
            bank = bank._replace(curves=curves)
        banks.append(bank)
    return replace(tables, styles=(*tables.styles, *banks))


def _sounding(compiled: "CompiledPair") -> Floats:
    """Return the share of an offset over each bigram: (B, RESOLUTION + 1).

    It is 1 in sounds, and falls to 0 in silence.
    """
    at = np.linspace(0, 1, RESOLUTION + 1)[None, :]
    silence = compiled.phonemes[0]
    pairs = [origin.pair for origin in compiled.origins]
    boundary = compiled.tables.boundary[:, None]
    starts = np.array([first == silence for first, _ in pairs])[:, None]
    ends = np.array([second == silence for _, second in pairs])[:, None]
    # a silence is left or entered along a straight line over its own part of the bigram
    share = np.where(starts, np.minimum(at / boundary, 1), 1.0)
    share = np.where(ends, np.minimum(share, np.minimum((1 - at) / (1 - boundary), 1)), share)
    # row 0 is rest, also in a style that smiles
    share[0] = 0
    return share.astype(np.float32)
