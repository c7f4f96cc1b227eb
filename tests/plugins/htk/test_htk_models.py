"""Monophones of HTK: definitions, settings and features; what cannot be followed is refused."""

import numpy as np
import pytest
from lanes import full
from spoken_sentences import SENTENCES

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.plugins.htk.htk_front_end import (
    HtkFrontEnd,
    kept_features,
    mel_filters,
    regression,
)
from lipsync_lang.resolver.nearest_phonemes import model_phones
from lipsync_lang.schedules import SILENCE
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.hearing.sphinx.features import PreparedSound, features
from lipsync_lang.sound.speech.hearing.sphinx.folder import models_in, read_model
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")

TEXT = "Glue the sheet to the dark blue background."
HTK_CONFIG = "TARGETKIND = MFCC_0_D_A_Z\nNUMCHANS = 26\nCEPLIFTER = 22\nSOURCERATE = 625\n"


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


def hmmdefs(phones, kind="MFCC_0_D_A_Z", size=39):
    """Return monophones of HTK: for each name the means and variances of three states."""
    rows = [f"~o <STREAMINFO> 1 {size} <VECSIZE> {size}<NULLD><{kind}><DIAGC>"]
    for name, states in phones.items():
        rows += [f'~h "{name}"', "<BEGINHMM>", "<NUMSTATES> 5"]
        for number, parts in enumerate(states, 2):
            rows.append(f"<STATE> {number} <NUMMIXES> {len(parts)}")
            for n, (mean, spread) in enumerate(parts, 1):
                rows += [
                    f"<MIXTURE> {n} {1 / len(parts):e}",
                    f"<MEAN> {size}", " ".join(f"{one:e}" for one in mean),
                    f"<VARIANCE> {size}", " ".join(f"{one:e}" for one in spread), "<GCONST> 1.0",
                ]  # fmt: skip
        rows += [
            "<TRANSP> 5",
            "0 1 0 0 0 0 .7 .3 0 0 0 0 .7 .3 0 0 0 0 .7 .3 0 0 0 0 0",
            "<ENDHMM>",
        ]
    return "\n".join(rows) + "\n"


def simple(size):
    """Return a state of one Gaussian."""
    return [(np.arange(size), np.ones(size))]


def put(folder, text, config=HTK_CONFIG, phones=""):
    folder.mkdir(exist_ok=True)
    for name, content in (("hmmdefs", text), ("config", config), ("phones.yaml", phones)):
        if content:
            (folder / name).write_text(content, encoding="utf-8")
    return folder


def test_htk_features_follow_their_formulas():
    kept, rows = kept_features("MFCC_0_D_A_Z", 39, None)
    front = HtkFrontEnd(rows, 26)
    seconds = np.arange(16_000) / 16_000
    tone = 1000 * np.sin(2 * np.pi * 1000 * seconds)
    found = front(tone)
    assert (kept, found.shape) == (tuple(range(39)), (100, 1, 39))
    np.testing.assert_allclose(found[5:90, 0, :13], 0, atol=0.5)  # a tone is its own mean
    # filters are triangles in mel whose neighbours add up to 1
    filters = mel_filters(front)
    assert filters.shape == (257, 26)
    centres = filters.argmax(axis=0)
    np.testing.assert_allclose(filters[centres[0] + 1 : centres[-1]].sum(axis=1), 1)
    mel = 1127 * np.log(1 + 8000 / 700) / 27 * np.arange(1, 27)
    np.testing.assert_allclose(centres * 31.25, 700 * (np.exp(mel / 1127) - 1), atol=16)
    # a gain is the same in all bands: it changes the first cepstrum alone
    louder = front.cepstra_at(2 * tone, np.array([1600])) - front.cepstra_at(tone, np.array([1600]))
    np.testing.assert_allclose(louder[0, -1], np.sqrt(2 / 26) * 26 * np.log(2), rtol=0.02)
    np.testing.assert_allclose(louder[0, :12], 0, atol=1)
    np.testing.assert_allclose(regression(np.arange(9.0)[:, None])[2:-2], 1)


@pytest.mark.parametrize("front", [features, HtkFrontEnd(tuple(range(39)), 26)])
def test_pauses_beside_a_held_sound_hardly_move_its_features(front):
    """The cepstra of a held sound are their own mean, and pauses take a limited part in it."""
    tone = 8000 * np.sin(2 * np.pi * 1000 * np.arange(16_000) / 16_000)
    hiss = np.random.default_rng(0).normal(0, 3, 16_000)

    def level(seconds):
        pause = np.tile(hiss, seconds)
        found = front(np.concatenate([pause, tone + hiss, pause])).reshape(-1, 39)
        return np.linalg.norm(found[100 * seconds + 10 : 100 * seconds + 90, :13].mean(axis=0))

    assert level(0) < 2
    assert 2 < level(1) < 1.2 * level(5)


@pytest.mark.parametrize(
    ("kind", "size", "first", "count"),
    [
        ("mfcc_0_D_N_Z", 25, 0, 25),
        ("MFCC_D_N_Z_0", 25, 0, 25),
        ("MFCC_E_D_A_Z", 39, 0, 36),
        ("MFCC_E_D_N_Z", 25, 0, 24),
    ],
)
def test_vectors_of_htk_are_known_by_their_kind(kind, size, first, count):
    kept, rows = kept_features(kind, size, None)
    assert (rows[0], len(rows), len(kept)) == (first, count, count)
    assert rows[12:25] == tuple(range(13, 26)) or "0" not in kind


@pytest.mark.parametrize(
    ("text", "config", "told"),
    [
        (hmmdefs({"sil": [simple(39)] * 3}, "PLP_0_D_A_Z"), HTK_CONFIG, "<PLP_0_D_A_Z>"),
        (hmmdefs({"sil": [simple(39)] * 3}, "MFCC_0_D_A"), HTK_CONFIG, "without _Z"),
        (hmmdefs({"sil": [simple(26)] * 3}, size=26), HTK_CONFIG, "<VECSIZE> 26"),
        (hmmdefs({"a": [simple(39)] * 3}), HTK_CONFIG, "no phone is silence"),
        (hmmdefs({"sil": [simple(39)] * 2}), HTK_CONFIG, "2 states instead of 3"),
        (hmmdefs({"sil": [simple(39)] * 3}), "", "config: is missing"),
        (hmmdefs({"sil": [simple(39)] * 3}), "SOURCERATE = 1250\n", "SOURCERATE = 1250"),
        (hmmdefs({"sil": [simple(39)] * 3}), "NUMCHANS = many\n", "mend the number"),
        (hmmdefs({"sil": [simple(39)] * 3}), "VTLN = 1\n", "VTLN: this setting is unknown"),
        (hmmdefs({"sil": [simple(39)] * 3}).replace("<VARIANCE>", "<INVCOVAR>"), HTK_CONFIG,
         r"hmmdefs:9: '<INVCOVAR>' is not read here"),
        ("\0\1\2 binary", HTK_CONFIG, "is no text"),
        (hmmdefs({"sil": [simple(39)] * 3})[:200], HTK_CONFIG, "ends within a definition"),
    ],
)  # fmt: skip
def test_models_of_htk_that_do_not_fit_are_refused_by_name(tmp_path, text, config, told):
    with pytest.raises(SpeechError, match=told):
        _ = models_in(put(tmp_path / "other", text, config)).model


def test_definitions_of_htk_refer_to_each_other(tmp_path):
    numbers = " ".join("1" * 25)
    gaussian = f"<Mean> 25\n{numbers}\n<Variance> 25\n{numbers}\n<GConst> 3\n"
    moves = "<TransP> 5\n0 1 0 0 0\n0 .5 .5 0 0\n0 0 .5 .3 .2\n0 0 0 .5 .5\n0 0 0 0 0\n"
    states = '<State> 2\n~s "one"\n<State> 3\n~s "two"\n<State> 4\n'
    (tmp_path / "macros").write_text(
        f'~o <StreamInfo> 1 25\n<VecSize> 25\n<nulld>\n<mfcc_0_D_N_Z>\n<diagc>\n~v "varFloor1"\n'
        f"<Variance> 25\n{numbers}\n", encoding="utf-8",
    )  # fmt: skip
    put(
        tmp_path,
        f'~s "one"\n{gaussian}~m "part"\n{gaussian}~t "moves"\n{moves}'
        f'~s "two"\n<NumMixes> 2\n<Mixture> 1 .25\n~m "part"\n<Mixture> 2 .75\n{gaussian}'
        f'~h "sil"\n<BeginHMM>\n<NumStates> 5\n{states}{gaussian}~t "moves"\n<EndHMM>\n'
        f'~h "sp"\n<BeginHMM>\n<NumStates> 3\n<State> 2\n~s "one"\n<TransP> 3\n0 .5 .5\n0 .5 .5\n'
        "0 0 0\n<EndHMM>\n",
    )
    model = read_model(tmp_path)
    assert model.names == ("sil",)
    np.testing.assert_allclose(model.weights[0].T, [[1, 0], [0.25, 0.75], [1, 0]])
    # the move past a state is left out
    np.testing.assert_allclose(np.exp(model.stay[0]), [0.5, 0.5 / 0.8, 0.5])


VARIED = (
    *SENTENCES[:9],
    "Measure the joy of your usual voice with care.",
    "Glue brings the youth the blue sheet back.",
)


def trained(english, folder):
    """Write monophones of HTK, fitted to how the model of Sphinx aligns some sentences."""
    _, rows = kept_features("MFCC_0_D_A_Z", 39, None)
    front, frames = HtkFrontEnd(rows, 26), {}
    for sentence in VARIED:
        found = aligned(english, english.speak(sentence).audio, sentence, aligner="pocketsphinx")
        heard = front(PreparedSound.of(found.audio).samples())[:, 0]
        for label, start, stop in zip(found.labels, found.times, found.times[1:], strict=False):
            span = heard[int(start * 100) : max(int(stop * 100), int(start * 100) + 3)]
            states = frames.setdefault("sil" if label == SILENCE else label, ([], [], []))
            for state, part in zip(states, np.array_split(span, 3), strict=True):
                state.append(part)
    phones = {
        name: [[(np.vstack(one).mean(axis=0), np.vstack(one).var(axis=0) + 0.1)] for one in states]
        for name, states in frames.items()
    }
    letters = model_phones().nearest.candidates
    rows = [f"{n}: [{', '.join(letters[n])}]" for n in phones if n != "sil"]
    return put(folder, hmmdefs(phones), phones="\n".join(rows) + "\n")


@full
def test_monophones_of_htk_align_a_sentence_that_they_were_not_trained_on(english, tmp_path):
    folder = trained(english, tmp_path / "htk")
    known = english.speak(TEXT)
    found = aligned(english, known.audio, TEXT, aligner=f"pocketsphinx:{folder}")
    assert [word.text for word in found.words] == [word.text for word in known.words]
    off = [
        abs(found.times[mine.first] - known.times[theirs.first])
        for mine, theirs in zip(found.words, known.words, strict=True)
    ]
    assert np.median(off) < 0.02
    assert found.confidence > 0.5
