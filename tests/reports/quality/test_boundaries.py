"""Errors of alignment in a folder of recordings whose labels are known."""

import json
import sys

import pytest
from lanes import needs_espeak

import lipsync_lang as ll

pytest.importorskip("pocketsphinx")
soundfile = pytest.importorskip("soundfile")
pytestmark = needs_espeak

TEXT = "Please buy five maps"


@pytest.fixture
def boundaries(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    import boundaries as benchmark

    yield benchmark
    for name in ("boundaries", "alignment", "hearing", "json_figures", "warping"):
        sys.modules.pop(name, None)


def test_labels_of_a_voice_are_found_again(boundaries, tmp_path, monkeypatch, capsys):
    known = ll.speak(TEXT, "english")
    for name in ("line", "other"):
        soundfile.write(tmp_path / f"{name}.wav", known.audio.samples, known.audio.rate)
    starts = [*known.times]
    starts[3] = starts[2]  # a sound without length shares the time of the one after it
    rows = zip(known.labels, starts, starts[1:], strict=False)
    table = "".join(f"{label},{start},{end}\n" for label, start, end in rows)
    (tmp_path / "line.csv").write_text("label,start,end\n" + table, "utf-8")
    (tmp_path / "line.txt").write_text(TEXT, "utf-8")
    out = tmp_path / "figures.json"
    options = ["-l", "english", "--notation", known.notation, "--json", out]
    monkeypatch.setattr("sys.argv", list(map(str, ["", tmp_path, *options])))
    assert boundaries.main() == 0
    (row,) = json.loads(out.read_text("utf-8"))["rows"]
    assert (row["lines"], row["doubted"], row["failed"]) == (1, 0, 0)
    assert row["boundaries"] > len(known) / 2
    assert row["median_ms"] < 20
    assert "other.wav: has no labels beside it" in capsys.readouterr().err
