"""Builds with adapted acoustic models: made once, and again when a recording or a text changes."""

import pytest
from lanes import full
from spoken_sentences import SENTENCES

from lipsync_lang import cli
from lipsync_lang.production.builds.project_build import ProjectBuild
from lipsync_lang.resolver.cache import CACHE_VARIABLE
from lipsync_lang.sound.speech.hearing import adaptation
from lipsync_lang.sound.speech.hearing.sphinx.folder import find_models
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")
soundfile = pytest.importorskip("soundfile")


@pytest.fixture
def game(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    (tmp_path / "vo").mkdir()
    english = Speaker.of("english")
    rows = ["id,text"]
    for number, text in enumerate(SENTENCES[:10]):
        audio = english.speak(text).audio
        soundfile.write(tmp_path / "vo" / f"{number}.wav", audio.samples, audio.rate)
        rows.append(f"{number},{text}")
    (tmp_path / "lines.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (tmp_path / "lipsync.yaml").write_text(
        "kind: project\nformat: 1\nlanguage: english\ncharacter: facefx\nlines: lines.csv\n"
        "audio: vo/{id}.wav\noutputs: out/{id}.csv\nadapt: true\n", encoding="utf-8",
    )  # fmt: skip
    return tmp_path


def aligners(remarks):
    (pair,) = ProjectBuild.open(remark=remarks.append, adapt=True).pairs.values()
    return pair.performer.speaker.manner.audio.align


def test_a_build_adapts_once_for_the_same_recordings(game, monkeypatch):
    shipped, asked = find_models("en-us").model, []

    def adapt(_, lines, __):
        asked.append(len(lines))
        return adaptation.Adaptation(shipped, -2.0, -1.0, len(lines), ("3.wav: no",))

    monkeypatch.setattr(adaptation, "adapt", adapt)
    remarks = []
    first, second = aligners(remarks), aligners(remarks)
    assert asked == [10]
    assert first == second == (f"pocketsphinx:{next((game / 'cache/models').iterdir())}",)
    assert "adapted to 10 lines, log likelihood of held-out frames -2.00 to -1.00" in remarks[0]
    assert remarks[1:] == ["english: not adapted to 3.wav: no"]
    (game / "vo" / "3.wav").write_bytes((game / "vo" / "4.wav").read_bytes())
    assert aligners(remarks) != first
    assert asked == [10, 10]


@pytest.mark.usefixtures("game")
def test_a_model_that_gains_nothing_stays(monkeypatch):
    same = adaptation.Adaptation(find_models("en-us").model, -1.0, -1.0, 10, ())
    monkeypatch.setattr(adaptation, "adapt", lambda *_: same)
    remarks = []
    assert aligners(remarks) == aligners(remarks) == ("pocketsphinx",)
    assert len(remarks) == 1
    assert "gains nothing" in remarks[0]


def test_too_few_recordings_are_told(game):
    for path in (game / "vo").glob("[2-9].wav"):
        path.unlink()
    remarks = []
    assert aligners(remarks) == ("pocketsphinx",)
    assert "was not adapted: 2 of 2 lines fit their text" in str(remarks[-1])


@full
def test_lines_are_aligned_by_the_adapted_model(game, capsys):
    assert cli.main(["build"]) == 0
    assert "acoustic model adapted to 10 lines" in capsys.readouterr().err
    assert len([*(game / "out").iterdir()]) == 10
    assert cli.main(["build"]) == 0
    assert "adapted" not in capsys.readouterr().err
