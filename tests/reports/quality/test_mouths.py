"""The benchmark that compares mouths on meshes with filmed lips."""

import importlib
import sys

import numpy as np
import pytest

import lipsync_lang as ll

LABELS = "DH AH K AE T S AE T AA N DH AH M AE T B AA D IY EH L S M EY D K IY P M AH N IY"


@pytest.fixture
def mouths(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    yield importlib.import_module("mouths")
    for name in ("mouths", "json_figures"):
        sys.modules.pop(name, None)


def clips(head, ahead):
    """Return a clip whose lips are those of the head, so many seconds early."""
    labels = LABELS.split()
    times = 0.2 + 0.11 * np.arange(len(labels) + 1)
    schedule = ll.Schedule(("_", *labels, "_"), [0, *times, times[-1] + 0.3])
    animation = head.performer.perform(schedule, 100)
    seconds = np.arange(0, schedule.times[-1], 1 / 25)
    lips = [np.interp(seconds + ahead, animation.times, one) for one in head.lips(animation)]
    return [(schedule, np.column_stack([seconds, *lips]))]


def test_the_lips_of_a_head_are_like_themselves_however_early(mouths):
    head = mouths.Head.of("facefx", "english")
    leads = [mouths.lead(head, clips(head, ahead)) for ahead in (0.0, 0.08)]
    assert leads[1] - leads[0] == pytest.approx(0.08, abs=0.04)  # a frame of the film
    figures, film, sounds = mouths.judge(head, clips(head, 0.05), 0.05)
    assert figures["aperture r"] > 0.999
    assert figures["aperture range"] == pytest.approx(1, abs=0.01)
    assert figures["width 5 %"] == pytest.approx(film["width 5 %"], abs=0.01)
    heading, *rows = mouths.errors({"one": sounds, "same": sounds})
    assert heading == ["aperture", "times", "film", "one", "same"]
    assert rows
    assert {row[0] for row in rows} <= set(head.performer.compiled.phonemes)
    assert all(int(row[1]) >= mouths.LEAST_TIMES for row in rows)
    assert all(abs(float(row[3])) < 0.03 for row in rows)


@pytest.mark.parametrize(
    ("name", "said"),
    [("arkit", "arkit has no model; name one"), ("facef", "did you mean 'facefx'")],
)
def test_a_head_that_has_no_mesh_ends_with_a_sentence(mouths, name, said):
    with pytest.raises(SystemExit, match=said):
        mouths.Head.of(name, "english")
