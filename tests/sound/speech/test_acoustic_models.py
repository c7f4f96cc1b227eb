"""Acoustic models as data: the model of pocketsphinx written in other forms aligns alike."""

import struct
import threading
import tracemalloc
from contextlib import suppress
from functools import cache
from shutil import copytree

import numpy as np
import pytest
from lanes import full

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.resolver.nearest_phonemes import model_phones
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.hearing.sphinx import acoustic_model, decoders
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import Listening
from lipsync_lang.sound.speech.hearing.sphinx.decoders import decoded_words
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    EVEN_STEPS,
    CepstralFrames,
    PreparedSound,
    features,
)
from lipsync_lang.sound.speech.hearing.sphinx.folder import (
    Models,
    find_models,
    models_in,
    read_gaussians,
    read_model,
    read_sphinx,
)
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")

TEXT = "Glue the sheet to the dark blue background."
POSITIONS = "ibes"


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


@pytest.fixture(scope="module")
def spoken(english):
    return english.speak(TEXT).audio


@pytest.fixture(scope="module")
def shipped():
    return find_models("en-us")


def table(path, sizes, values):
    """Write a binary table of Sphinx."""
    values = np.asarray(values, "<f4")
    head = b"s3\nversion 1.0\nendhdr\n" + struct.pack("<I", 0x11223344)
    path.write_bytes(head + struct.pack(f"<{len(sizes)}i", *sizes) + values.tobytes())


def text_mdef(model, contexts):
    """Return the text of the phonemes without context and of some rows of others."""
    names, alone = model.names, [phone.states for phone in model.alone]
    rows = [
        f"{name} - - - {'filler' if n in model.fillers else 'n/a'} {n} {' '.join(map(str, own))} N"
        for n, (name, own) in enumerate(zip(names, alone, strict=True))
    ]
    for key, row in contexts:
        here, left, right, place = (int(key) >> shift & 255 for shift in (24, 16, 8, 0))
        states = " ".join(map(str, model.states[row].tolist()))
        where = f"{names[here]} {names[left]} {names[right]} {POSITIONS[place]}"
        rows.append(f"{where} n/a {here} {states} N")
    return "\n".join(["# made by a test", "0.3", f"{len(names)} n_base", *rows]) + "\n"


@cache
def whole_text(model):
    """Return the text of all phonemes, with and without context."""
    return text_mdef(model, zip(model.keys, model.rows, strict=True))


def in_text(shipped, folder):
    """Write the model with a text `mdef` and with `mixture_weights`."""
    folder.mkdir()
    for name in ("feat.params", "means", "variances", "transition_matrices"):
        (folder / name).write_bytes((shipped.acoustic / name).read_bytes())
    model = shipped.model
    (folder / "mdef").write_text(whole_text(model), encoding="utf-8")
    weights = np.moveaxis(model.weights, -1, 0)
    table(folder / "mixture_weights", (*weights.shape, weights.size), 1000 * weights)
    return folder


def continuous(shipped, folder):
    """Write the phonemes without context with a codebook for each state."""
    folder.mkdir()
    model = shipped.model
    for name in ("feat.params", "transition_matrices"):
        (folder / name).write_bytes((shipped.acoustic / name).read_bytes())
    (folder / "mdef").write_text(text_mdef(model, ()), encoding="utf-8")
    states = np.array([phone.states for phone in model.alone])
    assert states.ravel().tolist() == [*range(states.size)]
    for name in ("means", "variances"):
        values = np.repeat(read_gaussians(shipped.acoustic / name), 3, axis=0)
        books, streams, count, length = values.shape
        sizes = (books, streams, count, *[length] * streams, values.size)
        table(folder / name, sizes, values)
    weights = np.moveaxis(model.weights[:, :, : states.size], -1, 0)
    table(folder / "mixture_weights", (*weights.shape, weights.size), weights)
    return folder


def close(english, audio, one, other, seconds=1e-4):
    """Check that two models put the same labels at the same times."""
    found, known = (
        aligned(english, audio, TEXT, aligner=f"pocketsphinx:{folder}") for folder in (one, other)
    )
    assert found.labels == known.labels
    assert np.median(np.abs(found.times - known.times)) <= seconds
    assert found.confidence > 0.5


def test_a_model_in_text_is_the_binary_one(shipped, english, spoken, tmp_path):
    folder = in_text(shipped, tmp_path / "text")
    model, other = shipped.model, models_in(folder).model
    assert (model.names, model.alone, model.fillers) == (other.names, other.alone, other.fillers)
    np.testing.assert_array_equal(model.keys, other.keys)
    np.testing.assert_array_equal(model.states[model.rows], other.states[other.rows])
    np.testing.assert_array_equal(model.books, other.books)
    # quantised weights add up to 1 roughly
    shares = model.weights / model.weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(other.weights, shares, rtol=1e-3, atol=2e-7)
    (folder / "words.dict").write_bytes(shipped.dictionary.read_bytes())
    close(english, spoken, folder, shipped.folder)


def test_a_continuous_model_scores_as_the_tied_one(shipped, spoken, tmp_path):
    model, other = shipped.model, models_in(continuous(shipped, tmp_path / "cont")).model
    assert len(other.gaussians) == 3 * len(model.names)
    sound = features(PreparedSound.of(spoken).samples())[:50]
    known, found = (Listening(one, sound).scores(one.alone) for one in (model, other))
    away = found - known  # weights of one state add up to 1 roughly
    assert np.abs(away - away.mean(axis=0)).max() < 0.5
    assert np.abs(away).max() < 1


def test_one_stream_is_three_in_a_row(shipped, tmp_path):
    folder = continuous(shipped, tmp_path / "three")
    single = tmp_path / "one"
    single.mkdir()
    for name in ("feat.params", "mdef", "transition_matrices"):
        (single / name).write_bytes((folder / name).read_bytes())
    for name in ("means", "variances"):
        first = read_gaussians(folder / name)[:, :, :1]
        table(single / name, (len(first), 1, 1, 39, first.size), first)
        table(folder / name, (len(first), 3, 1, 13, 13, 13, first.size), first)
    for where, streams in ((folder, 3), (single, 1)):
        alike = np.ones((len(first), streams, 1))
        table(where / "mixture_weights", (*alike.shape, alike.size), alike)
    sound = np.random.default_rng(1).normal(0, 5, (20, 3, 13))
    one, three = (read_sphinx(where) for where in (single, folder))
    np.testing.assert_allclose(
        Listening(one, sound).scores(one.alone), Listening(three, sound).scores(three.alone), 1e-4
    )


def test_likelihoods_are_kept_up_to_a_limit_and_made_anew_beyond_it(shipped, monkeypatch):
    model = shipped.model
    features = np.random.default_rng(1).normal(0, 5, (50, 3, 13))
    known = Listening(model, features).scores(model.alone)
    cells = 50 * model.gaussians.shape[-1]
    monkeypatch.setattr(acoustic_model, "MAX_KEPT_CELLS", 5 * cells)
    tracemalloc.start()
    sound = Listening(model, features)
    for _ in range(2):
        assert np.array_equal(sound.scores(model.alone), known)
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 5 * 4 * cells < kept < 6 * 4 * cells


@pytest.mark.parametrize("seed", range(3))
def test_scores_do_not_depend_on_the_order_of_sums(shipped, spoken, monkeypatch, seed):
    random, product = np.random.default_rng(seed), acoustic_model._product  # noqa: SLF001
    heard = np.rint(features(PreparedSound.of(spoken).samples())[:50] * EVEN_STEPS)
    known = Listening(shipped.model, heard / EVEN_STEPS).scores(shipped.model.alone)
    assert (known * EVEN_STEPS % 1 == 0).all()

    def in_another_order(many, few):
        found = product(many, few)
        return found * (1 + random.uniform(-1e-14, 1e-14, found.shape))

    monkeypatch.setattr(acoustic_model, "_product", in_another_order)
    other = heard + random.uniform(-0.4, 0.4, heard.shape)
    found = Listening(shipped.model, other / EVEN_STEPS).scores(shipped.model.alone)
    assert np.array_equal(found, known)


def test_states_that_share_one_codebook_are_read(shipped, tmp_path):
    folder = continuous(shipped, tmp_path / "semi")
    for name in ("means", "variances"):
        first = read_gaussians(folder / name)[:1]
        table(folder / name, (*first.shape[:3], 13, 13, 13, first.size), first)
    assert set(read_sphinx(folder).books.tolist()) == {0}


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("-feat s2_4x", "-feat s2_4x: the features have 1s_c_d_dd"),
        ("-lda yes", "-lda yes: the features have no such parameter"),
        ("-agc max", "-agc max: the features have none"),
        ("-samprate 8000", "-samprate 8000: the features have 16000"),
        ("-cmn none", "-cmn none: the features have batch"),
        ("-transform wavelet", "-transform wavelet"),
        ("-upperf 9000", "leave 0 to 8000 Hz"),
        ("-nfilt 300", "-nfilt, -lowerf, -upperf"),
        ("-shoe 44", "-shoe: this parameter is unknown"),
    ],
)
def test_features_that_cannot_be_computed_are_refused_by_parameter(shipped, tmp_path, line, told):
    folder = continuous(shipped, tmp_path / "other")
    params = folder / "feat.params"
    params.write_text(f"{params.read_text('utf-8')}\n{line}\n", encoding="utf-8")
    with pytest.raises(SpeechError, match=told):
        _ = models_in(folder).model


@pytest.mark.parametrize(
    "params",
    [
        "-nfilt 40 -transform legacy",
        "-nfilt 30 -lowerf 130 -upperf 6800 -transform dct -lifter 22",
        "-lowerf 200 -transform htk -lifter 22 -remove_noise yes",
    ],
)
def test_features_are_those_of_pocketsphinx(spoken, shipped, tmp_path, params):
    from pocketsphinx import Decoder

    for path in shipped.acoustic.iterdir():
        if path.name != "feat.params":
            (tmp_path / path.name).symlink_to(path)
    text = f"{params} -feat 1s_c_d_dd -svspec 0-12/13-25/26-38 -cmn batch"
    (tmp_path / "feat.params").write_text(text.replace(" -", "\n-") + "\n", encoding="utf-8")
    decoder = Decoder(hmm=str(tmp_path), dict=str(shipped.dictionary), lm=None, loglevel="FATAL")
    decoder.set_align_text("glue")
    decoder.start_utt()
    sound = np.rint(PreparedSound.of(spoken).samples())
    decoder.process_raw(sound.astype("<i2").tobytes(), full_utt=True)
    decoder.end_utt()
    mean = [float(one) for one in decoder.get_cmn(update=False).split(",")]
    ours = CepstralFrames(read_model(tmp_path).front_end).push(sound).mean(axis=0)
    np.testing.assert_allclose(ours, mean, rtol=0.02, atol=0.05)


# Phones


def phones_of(folder, names):
    letters = model_phones().nearest.candidates
    rows = [f"{name}: [{', '.join(letters[name])}]" for name in names if name in letters]
    (folder / "phones.yaml").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return folder


def test_phones_without_letters_are_listed_with_their_file(shipped, tmp_path):
    folder = phones_of(continuous(shipped, tmp_path / "few"), ["P", "T"])
    with pytest.raises(SpeechError, match=r"phones.yaml:1:1: no letters for AA, AE"):
        _ = models_in(folder).phones


def test_wrong_letters_and_phones_are_told_by_line(shipped, tmp_path):
    folder = phones_of(continuous(shipped, tmp_path / "bad"), shipped.numbers)
    path = folder / "phones.yaml"
    path.write_text(path.read_text("utf-8").replace("P: [p]", "P: ['Ж']") + "QQ: p\n", "utf-8")
    with pytest.raises(SpeechError) as told:
        _ = models_in(folder).phones
    lines = str(told.value).splitlines()
    assert len(lines) == 2
    assert any("'Ж' is not IPA" in line for line in lines)
    assert any(f"yaml:{len(shipped.numbers) + 1}:1: 'QQ' is no phone" in line for line in lines)


def test_a_phone_without_sound_is_a_filler(shipped, tmp_path):
    folder = phones_of(continuous(shipped, tmp_path / "quiet"), shipped.numbers)
    path = folder / "phones.yaml"
    path.write_text(path.read_text("utf-8").replace("ZH: [ʒ]", "ZH: []"), "utf-8")
    models = models_in(folder)
    assert models.model.names.index("ZH") in models.model.fillers
    assert "ZH" not in models.numbers


def test_a_pack_names_the_folder_of_a_model_beside_it(shipped, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = phones_of(continuous(shipped, tmp_path / "mine"), shipped.numbers)
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages" / "kin.yaml").write_text(
        "kind: language\nformat: 1\nname: kin\ntag: de-x-kin\nextends: german\n"
        "audio: {model: ../mine, align: pocketsphinx}\n", encoding="utf-8",
    )  # fmt: skip
    speaker = Speaker.of("kin")
    assert find_models(speaker.manner.audio.model).folder.resolve() == folder
    spoken = speaker.speak("Guten Morgen, mein Freund.")
    found = aligned(speaker, spoken.audio, "Guten Morgen, mein Freund.")
    assert [word.text for word in found.words] == ["Guten", "Morgen", "mein", "Freund"]


def test_a_model_of_the_project_has_the_name_of_its_folder(shipped, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    continuous(shipped, tmp_path / "models" / "mine")
    assert find_models("mine").folder == tmp_path / "models" / "mine"
    with pytest.raises(SpeechError, match="no such folder"):
        find_models("models/yours")


def test_a_model_without_letters_says_what_to_write(shipped, tmp_path):
    folder = continuous(shipped, tmp_path / "cont")
    mdef = folder / "mdef"
    mdef.write_text(
        mdef.read_text("utf-8").replace(" AA -", " aa -").replace("AA -", "aa -"), "utf-8"
    )
    german = Speaker.of("german")
    spoken = german.speak("Guten Morgen.")
    with pytest.raises(
        SpeechError, match=r"no phone of the model is known for 'ɡ': write .*phones"
    ):
        aligned(german, spoken.audio, "Guten Morgen.", aligner=f"pocketsphinx:{folder}")


def filled(name, number):
    """Return what fills a part of a binary table of a model with one number."""

    def change(folder):
        content = bytearray((folder / name).read_bytes())
        at = content.index(b"endhdr\n") + 39
        content[at : at + 400] = struct.pack("<100f", *[number] * 100)
        (folder / name).write_bytes(content)

    return change


def stated(line):
    """Return what adds a line to the parameters of the features."""

    def change(folder):
        path = folder / "feat.params"
        path.write_text(f"{path.read_text('utf-8')}\n{line}\n", "utf-8")

    return change


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (filled("means", np.nan), "no numbers"),
        (filled("means", 1e38), "no numbers"),
        (filled("variances", np.nan), "no numbers"),
        (filled("transition_matrices", 0), "no numbers"),
        (stated("-nfilt 0"), "-nfilt 0: the features have 1 to 1000 bands"),
        (stated("-nfilt 1000000000"), "1 to 1000 bands"),
        (stated("-nfilt many"), "invalid literal"),
        (stated("-lowerf nan"), "-lowerf"),
    ],
)
def test_a_damaged_model_is_told_in_words(shipped, tmp_path, change, told):
    folder = in_text(shipped, tmp_path / "damaged")
    change(folder)
    with pytest.raises(SpeechError, match=told) as error:
        read_model(folder)
    assert len(str(error.value)) < 400


def test_a_word_of_the_dictionary_without_phones_is_told(shipped, english, spoken, tmp_path):
    folder = in_text(shipped, tmp_path / "mute")
    (folder / "own.dict").write_text("glue\nthe DH AH\n", "utf-8")
    with pytest.raises(SpeechError, match=r"own.dict: 'glue' has no phones; add them"):
        aligned(english, spoken, TEXT, aligner=f"pocketsphinx:{folder}")


# The decoder, which is native code


WORKERS = {
    "crash": ("import os; os.abort()", "ended"),
    "hang": ("import time; time.sleep(60)", "did not answer in 1 s"),
    "garbage": ("print('[[1]]', flush=True)", "ended"),
}


@pytest.mark.parametrize("name", WORKERS)
def test_a_decoder_that_ends_or_hangs_is_told_in_words(
    name, shipped, spoken, tmp_path, monkeypatch
):
    code, told = WORKERS[name]
    script = tmp_path / "worker.py"
    script.write_text(code, "utf-8")
    monkeypatch.setattr(decoders, "DECODER_SCRIPT", script)
    monkeypatch.setattr(decoders, "threads", threading.local())
    monkeypatch.setattr(decoders, "LOADING_SECONDS", 1.0)
    monkeypatch.setattr(decoders, "PATIENCE", 0.0)
    with pytest.raises(SpeechError, match=f"pocketsphinx {told}.*copy its folder again"):
        decoded_words(shipped, PreparedSound.of(spoken).samples())
    assert not decoders.threads.loaded


@full
@pytest.mark.parametrize("name", ["mdef", "sendump", "means", "transition_matrices"])
def test_no_damaged_file_of_a_model_ends_the_program(name, shipped, spoken, tmp_path, monkeypatch):
    monkeypatch.setattr(decoders, "threads", threading.local())
    folder = tmp_path / shipped.folder.name
    copytree(shipped.folder, folder)
    path = Models(folder).acoustic / name
    content = path.read_bytes()
    rng = np.random.default_rng(0)
    sound = PreparedSound.of(spoken).samples()
    for _ in range(6):
        damaged = bytearray(content[: int(rng.integers(1, len(content)))])
        for at in rng.integers(0, len(damaged), 20):
            damaged[at] = int(rng.integers(0, 256))
        path.write_bytes(damaged)
        with suppress(SpeechError):
            decoded_words(Models(folder), sound)
        decoders.threads.loaded.clear()


@full
def test_a_decoder_has_a_limit_of_memory(shipped, spoken, tmp_path, monkeypatch):
    pytest.importorskip("resource")
    worker = decoders.DECODER_SCRIPT.read_text("utf-8").replace("2**31", "2**26")
    (tmp_path / "worker.py").write_text(worker, "utf-8")
    monkeypatch.setattr(decoders, "DECODER_SCRIPT", tmp_path / "worker.py")
    monkeypatch.setattr(decoders, "threads", threading.local())
    with pytest.raises(SpeechError, match="pocketsphinx ended"):
        decoded_words(shipped, PreparedSound.of(spoken).samples())
