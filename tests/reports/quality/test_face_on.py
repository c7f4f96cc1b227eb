"""The comparison with films: figures of tracked lips whose answer is known."""

import sys

import numpy as np
import pytest

TIMES = np.arange(0, 4, 1 / 30)
SPANS = np.array([[0.45, 0.55], [1.2, 1.3]])
"""The first has shut lips (see `lips`), the second has not."""


@pytest.fixture
def face_on(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    import face_on as benchmark

    yield benchmark
    sys.modules.pop("face_on")


def lips(benchmark, late=0.0, gain=1.0):
    """Lips that shut every half second and widen every third of a second."""
    at = TIMES - late
    aperture = 1 + np.cos(4 * np.pi * (at - 0.25))
    return benchmark.Lips(TIMES, gain * np.column_stack([aperture, np.sin(6 * np.pi * at)]), {}, 30)


def test_equal_lips_agree(face_on):
    found = face_on.judge(lips(face_on), lips(face_on), (0.5, 3.5), SPANS)
    for name in ("aperture r", "width r", "aperture range", "width range"):
        assert found[name] == pytest.approx(1)
    assert found["lag ms"] == pytest.approx(0, abs=1e-9)
    assert found["shut %"] == found["really shut %"] == 50


def test_late_and_smaller_lips_are_told(face_on):
    ours = lips(face_on, late=0.06, gain=0.5)
    found = face_on.judge(lips(face_on), ours, (0.5, 3.5), SPANS)
    assert found["lag ms"] == pytest.approx(60, abs=5)
    assert found["aperture range"] == pytest.approx(0.5, abs=0.02)


def test_frames_without_a_face_do_not_count(face_on):
    real = lips(face_on)
    real.shape[40:60] = np.nan
    found = face_on.judge(real, lips(face_on), (0.5, 3.5), SPANS)
    assert found["aperture r"] == pytest.approx(1)
    assert np.isfinite(list(found.values())).all()
