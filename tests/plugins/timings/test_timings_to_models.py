"""Timings of every format, performed on a 3D model."""

import pytest
from lanes import swept
from test_schedule import EXAMPLES, ONLY_WORDS

from lipsync_lang.animations.animation_readers import read_animation
from lipsync_lang.cli import main
from lipsync_lang.schedules.timing_readers import TIMING_READERS


@pytest.mark.parametrize("name", swept(sorted(TIMING_READERS), ["elan", "moho"]))
def test_every_format_moves_a_model(name, tmp_path, capsys):
    path, out = tmp_path / f"line{TIMING_READERS[name].suffix}", tmp_path / "line.glb"
    path.write_text(EXAMPLES[name], "utf-8")
    run = ["run", "--schedule", str(path), "-l", "english", "-c", "facefx", "-o", str(out)]
    assert main(run) == 0
    told = capsys.readouterr().err
    assert told.startswith("4 phonemes, ")
    assert ("phonemes are estimated within each word" in told) == (name in ONLY_WORDS)
    recording = read_animation(out)
    assert len(recording.times) > 10
    assert recording.values.max() > 0.3
