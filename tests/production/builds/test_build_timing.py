"""Timing of lines from their files, many at once and in order."""

import json
from types import SimpleNamespace

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.timing import schedules
from lipsync_lang.sound.speech.hearing import alignment, recognition


class Voice:
    """A speaker that returns one schedule for each text, and counts its calls."""

    asked = 0

    def speak_many(self, texts, engine=None):
        """Return the texts, with the engine."""
        self.asked += 1
        return [f"{engine} says {text}" for text in texts]


def line(name, text="", audio=None, timings=None):
    """Return a planned line."""
    return PlannedLine(name, "english", "facefx", text, "", "script.csv:2", timings, audio, ())


def test_each_line_is_timed_by_what_it_has(tmp_path, monkeypatch):
    taken = []

    def align_many(_, pairs):
        taken.append("align")
        return (f"{audio.name} with {text}" for audio, text in pairs)

    def recognise_many(_, sounds):
        taken.append("recognise")
        return (SpeechError(f"{audio.name} is silent") for audio in sounds)

    monkeypatch.setattr(alignment, "align_many", align_many)
    monkeypatch.setattr(recognition, "recognise_many", recognise_many)
    phonemes = [{"label": "AA", "start": 0, "end": 1}]
    (tmp_path / "d.json").write_text(json.dumps({"notation": "arpabet", "phonemes": phonemes}))
    voice = Voice()
    lines = [
        line("a", "Hello."),
        line("b", "Well?", audio="b.wav"),
        line("c", audio="c.wav"),
        line("d", timings="d.json"),
        line("e", "Bye.", audio="e.wav"),
        line("f", "Now.", timings="missing.json"),
        line("g", "Oh."),
        line("h", timings="h.csv"),
    ]
    (tmp_path / "h.csv").write_bytes("label,start,end\nÄ,0,1\n".encode("cp1252"))
    found = schedules(tmp_path, lines, SimpleNamespace(speaker=voice), "espeak")
    assert (found[0], found[6]) == ("espeak says Hello.", "espeak says Oh.")
    assert (found[1], found[4]) == ("b.wav with Well?", "e.wav with Bye.")
    assert str(found[2]) == "c.wav is silent"
    assert found[3].labels == ("AA",)
    assert "missing.json" in str(found[5])
    assert str(found[7]).endswith("save it as UTF-8")
    assert (voice.asked, sorted(taken)) == (1, ["align", "recognise"])


def test_timings_with_phonemes_need_neither_a_language_nor_the_cache(tmp_path):
    rows = [{"label": "AA", "start": 0, "end": 1}]
    (tmp_path / "d.json").write_text(json.dumps({"notation": "arpabet", "phonemes": rows}))
    opened = []
    (found,) = schedules(
        tmp_path, [line("d", timings="d.json")], object(), opened=lambda: opened.append("cache")
    )
    assert found.labels == ("AA",)
    assert not opened
