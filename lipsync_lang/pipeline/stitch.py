"""Stitch: overlapping bigrams become one curve per pose (paper 3.2.1, figure 7).

Conventions: inputs are (T, P), frames by poses, as the tables have them; the result is (P, T), as
all later stages have it. The paper knows ``max`` only; ``crossfade`` is an addition.
"""

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.pipeline.warp import FramePlace


def stitch(ending: Floats, beginning: Floats, place: FramePlace, how: str) -> Floats:
    """Join the two bigrams that cover each frame.

    ``max`` keeps the larger, so that peaks survive: c(t) = max(c_i(t), c_i+1(t)).
    ``crossfade`` passes from the ending to the beginning one over the phoneme they share.

    Parameters
    ----------
    ending, beginning : (T, P) as from `warp`

    Returns
    -------
    (P, T)
    """
    if how == "max":
        joined = np.maximum(ending, beginning)
    else:
        share = place.going.clip(0, 1)[:, None]
        joined = ending * (1 - share) + beginning * share
    return np.ascontiguousarray(joined.T, dtype=np.float64)
