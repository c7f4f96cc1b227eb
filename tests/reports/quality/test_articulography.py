"""Articulography: drafts follow real mouths better than keys at phoneme centres."""

import json
import sys

import numpy as np
import pytest
from lanes import full, needs_plug_ins

from lipsync_lang import resolve
from lipsync_lang.reports.quality.baselines import keyframes

pytestmark = needs_plug_ins


@pytest.fixture
def bench(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    import articulography

    yield articulography
    sys.modules.pop("articulography")


@full
def test_the_draft_follows_real_lips_better_than_keyframes(bench, data):
    lines = bench.recordings(data / "articulography")
    assert lines, "a comparison over nothing passes"
    performer = resolve(bench.LANGUAGE, "facefx")
    gains = performer.compiled.measures["aperture"]

    def mean(perform):
        return np.mean(
            [
                bench.correlate(perform(schedule), gains, signals["aperture"], times)
                for _, schedule, signals, times in lines
            ]
        )

    drafted = mean(lambda schedule: performer.perform(schedule, fps=bench.FPS))
    keyed = mean(lambda schedule: keyframes(performer, schedule, fps=bench.FPS))
    assert drafted > keyed


def test_the_table_is_printed_and_an_empty_folder_is_told(bench, data, tmp_path, capsys):
    file = tmp_path / "figures.json"
    assert bench.main(data / "articulography", file=file) == 0
    table = capsys.readouterr().out
    for word in ("aperture", "protrusion", "tongue_tip", "draft", "keyframes at centres", "mean"):
        assert word in table
    kept = json.loads(file.read_text("utf-8"))
    assert f"{np.mean(kept['r']['aperture']['drafted bank']):.3f}" in table
    assert len(kept["recordings"]) == len(kept["r"]["aperture"]["drafted bank"])
    assert bench.main(tmp_path) == 1
    assert "holds no recordings" in capsys.readouterr().out
    assert bench.main(tmp_path, "head.glb") == 1
    assert "head.glb: is a model" in capsys.readouterr().out


def test_keyframes_stand_at_their_targets_in_the_middle_of_each_phoneme():
    from lipsync_lang import Schedule
    from lipsync_lang.packs.library import Library

    schedule = Schedule.from_intervals(
        [("P", 0.0, 0.2), ("AA", 0.2, 0.6), ("F", 0.6, 0.8)], notation="arpabet"
    )
    performer = resolve("english", "facefx")
    animation = keyframes(performer, schedule, fps=10)
    target = Library(project=None).poseset("facefx").model.targets["aa"][0].weights["open"]
    at = animation.times.round(3).tolist().index
    assert animation["PBM"][at(0.1)] == pytest.approx(0.85)
    assert animation["open"][at(0.4)] == pytest.approx(target)
    assert animation["FV"][at(0.7)] == pytest.approx(0.8)
    assert animation["PBM"][at(0.2)] == pytest.approx(0.85 * 2 / 3)
