"""Statistics of a curve agree with those of numpy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.reports.quality.curve_statistics import percentile


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.sampled_from([1, 5, 50, 90, 95, 99]))
def test_a_percentile_is_that_of_numpy_to_the_last_bit(seed, length, per_cent):
    for values in np.random.default_rng(seed).random(
        (100, length)
    ):  # either form alone misses some
        assert percentile(values, per_cent) == np.percentile(values, per_cent)
