"""The comparison with films: figures of tracked lips whose answer is known."""

import sys
from argparse import Namespace

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


def test_a_head_without_a_model_and_a_folder_without_films_are_refused_in_a_sentence(
    face_on, tmp_path
):
    wanted = Namespace(folder=tmp_path, language="english", head=["arkit"])
    (tmp_path / "ann_texts.tsv").write_text("")
    with pytest.raises(SystemExit, match=r"no films with a text .* by benchmarks/mouths\.py"):
        face_on.main(wanted)
    for name in ("ann.mp4", "ann.txt"):
        (tmp_path / name).write_text("")
    with pytest.raises(SystemExit, match="arkit has no model to film"):
        face_on.main(wanted)
