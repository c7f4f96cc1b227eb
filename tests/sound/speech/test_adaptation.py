"""Adaptation: an acoustic model learns voices from recordings and their texts alone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lanes import full
from spoken_sentences import SENTENCES

from lipsync_lang import cli
from lipsync_lang.base.errors import OutputError, SpeechError
from lipsync_lang.sound.speech.hearing import adaptation
from lipsync_lang.sound.speech.hearing.adaptation import (
    AlignedFrames,
    GaussianSums,
    adapt,
    aligned_frames,
    means_of,
    spoken_files,
    write_adapted,
)
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import Listening
from lipsync_lang.sound.speech.hearing.sphinx.folder import find_models, models_in, read_gaussians
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")
soundfile = pytest.importorskip("soundfile")


@pytest.fixture(scope="module")
def shipped():
    return find_models("en-us")


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


@pytest.fixture(scope="module")
def recordings(english, tmp_path_factory):
    folder = tmp_path_factory.mktemp("vo")
    for number, text in enumerate(SENTENCES):
        audio = english.speak(text).audio
        soundfile.write(folder / f"{number:02}.wav", audio.samples, audio.rate)
        (folder / f"{number:02}.txt").write_text(text, encoding="utf-8")
    return folder


def test_means_move_towards_the_frames_as_the_formula_says(shipped):
    model = shipped.model
    state = model.alone[model.names.index("AA")].states[1]
    rng = np.random.default_rng(2)
    line = AlignedFrames(rng.normal(0, 3, (40, 3, 13)), np.full(40, state))
    evidence = GaussianSums(model)
    before = evidence.add(line)
    moved = evidence.adapted()
    np.testing.assert_allclose(evidence.counts.sum(axis=(0, 2)), 40)
    precision, means = means_of(model)
    same, found = means_of(moved)
    np.testing.assert_allclose(same, precision)
    book = model.books[state]
    counts, scale = evidence.counts[book, 0], np.sqrt(precision[book, 0])
    away = (evidence.sums[book, 0] - counts * means[book, 0]) * scale
    whole = away.sum(axis=1, keepdims=True)
    voice = whole / (20 + 40)
    phoneme = (20 * voice + whole) / (20 + 40)
    gaussian = (20 * phoneme + away) / (20 + counts)
    shifts = (found - means) * np.sqrt(precision)
    np.testing.assert_allclose(shifts[book, 0], gaussian, rtol=1e-3, atol=1e-3)
    # phonemes that are not heard move as the voice does
    others = np.arange(len(means)) != book
    np.testing.assert_allclose(
        shifts[others, 0], np.broadcast_to(voice, shifts[others, 0].shape), rtol=1e-3, atol=1e-3
    )
    assert GaussianSums(moved).add(line) > before
    # the log likelihood is that of the search
    scores = Listening(model, line.features).scores([model.alone[model.names.index("AA")]])
    assert before == pytest.approx(scores[:, 0, 1].mean(), rel=1e-4)


def test_frames_of_other_sound_are_left_out_and_states_follow_each_other(shipped):
    model = shipped.model
    numbers = [model.names.index(name) for name in ("AA", "T")]
    heard = [
        HeardPhoneme(-1, model.silence, 0, 10, 0.0),
        HeardPhoneme(0, numbers[0], 10, 22, 0.0),
        HeardPhoneme(0, numbers[1], 22, 25, 0.0),
        HeardPhoneme(-1, -1, 25, 30, 0.0),
    ]
    sound = np.random.default_rng(3).normal(0, 3, (30, 3, 13))
    states = aligned_frames(model, sound, heard).states
    assert len(states) == 25
    assert len({*states[10:22]}) == len({*states[22:25]}) == 3
    assert np.count_nonzero(np.diff(states)) == 8


@full
def test_a_voice_is_learned_and_its_model_is_read_again(shipped, english, recordings, tmp_path):
    lines = spoken_files(recordings)
    wrong = lines[3]._replace(text="Nobody ever heard about these new green apples.")
    found = adapt(english, [*lines[:3], wrong, *lines[4:]], shipped)
    assert found.gains
    assert found.lines == len(SENTENCES) - 1
    assert found.left_out[0].startswith("03.wav: the text")
    write_adapted(shipped, found.model, tmp_path / "anna")
    written = models_in(tmp_path / "anna")
    np.testing.assert_allclose(written.model.gaussians, found.model.gaussians, rtol=1e-3, atol=1e-2)
    assert written.dictionary.read_bytes() == shipped.dictionary.read_bytes()
    assert written.licence is not None
    with pytest.raises(OutputError, match="exists"):
        write_adapted(shipped, found.model, tmp_path / "anna")
    shape = read_gaussians(written.acoustic / "means").shape
    assert shape == read_gaussians(shipped.acoustic / "means").shape


@full
def test_noise_is_no_part_of_a_learned_voice(shipped, english, recordings, tmp_path):
    for path in recordings.iterdir():
        if path.suffix == ".wav":
            sound, rate = soundfile.read(path)
            noise = np.random.default_rng(0).normal(0, sound.std() * 10 ** (-10 / 20), len(sound))
            soundfile.write(tmp_path / path.name, (sound + noise) / 2, rate)
        else:
            (tmp_path / path.name).write_bytes(path.read_bytes())

    def shifts(folder):
        precision, means = means_of(shipped.model)
        _, moved = means_of(adapt(english, spoken_files(folder), shipped).model)
        return ((moved - means) * np.sqrt(precision)).ravel()

    # 0.53 in features with the noise, 0.73 in those without
    assert np.corrcoef(shifts(recordings), shifts(tmp_path))[0, 1] > 0.65


@full
def test_the_command_writes_a_model_that_aligns(recordings, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["models", "adapt", str(recordings), "-l", "english", "-o", "anna"]) == 0
    assert "11 lines; log likelihood of held-out frames" in capsys.readouterr().out
    run = [
        "run",
        SENTENCES[0],
        "-l",
        "english",
        "-c",
        "facefx",
        "--audio",
        str(recordings / "00.wav"),
    ]
    assert cli.main([*run, "--aligner", "pocketsphinx:./anna", "-o", "line.csv"]) == 0


@full
def test_the_text_of_a_language_without_a_pack_is_ipa(english, recordings, tmp_path, capsys):
    for text, path in zip(SENTENCES, sorted(recordings.glob("*.wav")), strict=True):
        (said,) = english.transcribe([text])
        (tmp_path / path.name).write_bytes(path.read_bytes())
        written = " ".join("".join(word.labels) for word in said.words)
        (tmp_path / path.name).with_suffix(".txt").write_text(written, "utf-8")
    made = ["-l", "ipa:und", "-o", str(tmp_path / "anna")]
    assert cli.main(["models", "adapt", str(tmp_path), *made]) == 0
    assert "11 lines" in capsys.readouterr().out


def test_a_model_that_gains_nothing_is_not_written(monkeypatch, tmp_path, shipped, capsys):
    nothing = adaptation.Adaptation(shipped.model, -100.0, -100.5, 10, ("a.wav: no",))
    monkeypatch.setattr(adaptation, "adapt", lambda *_: nothing)
    monkeypatch.setattr(adaptation, "spoken_files", lambda _: [])
    out = tmp_path / "anna"
    assert cli.main(["models", "adapt", str(tmp_path), "-l", "english", "-o", str(out)]) == 1
    assert "no model was written" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("place", ["../anna", "anna", "there/../../anna"])
def test_a_folder_outside_is_written_by_any_path(place, tmp_path, monkeypatch, shipped):
    here = tmp_path / "here"
    (here / "there").mkdir(parents=True)
    monkeypatch.chdir(here)
    write_adapted(shipped, shipped.model, Path(place))
    assert models_in(here / place).dictionary.exists()


@pytest.mark.parametrize(("place", "told"), [("link/anna", "by a link"), ("old", "exists")])
def test_a_folder_is_refused_before_the_work(place, told, tmp_path, monkeypatch, capsys):
    (tmp_path / "old").mkdir()
    monkeypatch.chdir(tmp_path / "old")
    (tmp_path / "old" / "old").mkdir()
    (tmp_path / "old" / "link").symlink_to(tmp_path)
    monkeypatch.setattr(adaptation, "spoken_files", lambda _: pytest.fail("it works"))
    assert cli.main(["models", "adapt", "vo", "-l", "english", "-o", place]) == 2
    assert told in capsys.readouterr().err


def test_few_lines_and_folders_without_texts_are_refused(english, shipped, tmp_path):
    with pytest.raises(SpeechError, match="no recording has its text beside it"):
        spoken_files(tmp_path)
    with pytest.raises(SpeechError, match="0 of 0 lines fit their text, and adaptation needs 10"):
        adapt(english, [], shipped)
    with pytest.raises(SpeechError, match="only models of CMU Sphinx"):
        write_adapted(replace(shipped, folder=tmp_path), shipped.model, tmp_path / "new")
