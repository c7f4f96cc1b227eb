"""Labels are looked up alike by the kernel and by Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.performing.label_sounds import LabelTable
from lipsync_lang.pipeline import kernel

LABELS = ("M", "AA", "AA1", "IY0", "UW2", "_", "AY", "nothing")
"""Labels with and without a mark, and one that the notation lacks."""


@pytest.mark.skipif(kernel.compiled is None, reason="the kernel is not built, or is switched off")
@given(st.lists(st.sampled_from(LABELS), min_size=1, max_size=6).map(tuple))
def test_the_kernel_and_python_read_the_same_numbers_and_marks(labels):
    reader = ll.resolve("english", "facefx").labels
    table = LabelTable(reader.notations["arpabet"], reader.numbers)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "compiled", None)
        numbers, marks = table.read(labels)  # and so the table knows them
    again, others = table.read(labels)
    assert (numbers is None) == (again is None) == ("nothing" in labels)
    assert numbers is None or np.array_equal(numbers, again)
    assert np.array_equal(marks, others)
    assert marks.size in {0, len(labels)}
