"""Errors of alignment in a folder of recordings whose labels are known."""

import json
import sys

import pytest
from lanes import needs_espeak

import lipsync_lang as ll
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")
soundfile = pytest.importorskip("soundfile")
pytestmark = needs_espeak

TEXT = "Please buy five maps"


@pytest.fixture
def boundaries(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    import boundaries as benchmark

    yield benchmark
    for name in ("boundaries", "alignment", "closures", "hearing", "json_figures", "warping"):
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


def line(names, step=0.1, **changes):
    """Return phonemes of one length; `changes` move starts, by the number of the phoneme."""
    times = [step * n for n in range(len(names) + 1)]
    for number, seconds in changes.items():
        times[int(number[1:])] += seconds
    return ll.Schedule(tuple(names), times, notation="ipa")


def test_closures_are_judged_where_they_can_be_heard(boundaries):
    by_place, closures = boundaries.by_place, boundaries.closures
    speaker, names = Speaker.of("english"), ["_", *"pabamap", "_", *"bam", "_"]
    known = line(names)
    # after a pause the onset of a stop is not heard, and before one its release is not
    deaf = line(names, _1=0.05, _8=0.05, _9=0.05)
    assert {off for _, off in closures(deaf, known, speaker)} == {0}
    places = [place for place, _ in closures(known, known, speaker)]
    assert places == ["first", "inside", "nasal", "last", "first", "nasal"]
    moved = line(names, _2=0.04, _3=0.01, _5=0.02, _7=0.03)
    off = by_place(closures(moved, known, speaker))
    rows = {
        place: [one["closures"], round(one["median_ms"]), one["off"]] for place, one in off.items()
    }
    assert rows == {
        "nasal": [2, 10, 0], "inside": [1, 10, 0], "first": [2, 20, 0.5], "last": [1, 30, 0],
    }  # fmt: skip
