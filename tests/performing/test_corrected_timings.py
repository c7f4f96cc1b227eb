"""Corrections that hold for labels of timings, whoever wrote them."""

import numpy as np
import pytest

import lipsync_lang as ll


def read(labels, language="mandarin", notation="pinyin"):
    """Return the common phonemes of labels."""
    performer = ll.resolve(language, "facefx")
    labels = labels.split()
    schedule = ll.Schedule(labels, np.arange(len(labels) + 1) * 0.1, notation=notation)
    return [performer.compiled.phonemes[i] for i in performer.common_phonemes(schedule)[0]]


@pytest.mark.parametrize("written", ["-i", "i", "i4"])
@pytest.mark.parametrize("sibilant", ["zh", "ch", "sh", "r", "z", "c", "s"])
def test_an_aligned_i_after_a_sibilant_is_the_sibilant_held(sibilant, written):
    assert read(f"_ {sibilant} {written} _") == [*read(f"_ {sibilant} _")[:-1], "s", "_"]


@pytest.mark.parametrize("before", ["x", "b", "er2", "er", "_", "ng"])
def test_an_i_after_other_labels_stays(before):
    assert read(f"_ d a {before} i1 _")[-2:] == ["iy", "_"]


@pytest.mark.parametrize(("text", "labels"), [("四", "s i4"), ("是", "sh i4"), ("日", "r i4")])
def test_aligned_and_read_syllables_look_alike(text, labels):
    said = ll.speak(text, "mandarin")
    assert read(" ".join(said.labels)) == read(f"_ {labels} _")


def test_a_batch_is_read_as_each_alone():
    performer = ll.resolve("mandarin", "facefx")
    times = np.arange(5) * 0.1
    lines = [ll.Schedule(("_", *one.split(), "_"), times) for one in ("sh i4", "x i1")]
    together = performer.labels.read(lines)
    alone = [ll.resolve("mandarin", "facefx").labels.read([one])[0] for one in lines]
    for one, other in zip(together, alone, strict=True):
        assert one.ids.tolist() == other.ids.tolist()


def test_unknown_labels_are_rest_beside_corrected_ones():
    performer = ll.resolve("mandarin", "facefx", unknown="rest")
    schedule = ll.Schedule(("qqq", "sh", "i4"), np.arange(4) * 0.1, notation="pinyin")
    ids = performer.common_phonemes(schedule)[0]
    assert [performer.compiled.phonemes[i] for i in ids if i][:2] == ["sh", "s"]


@pytest.mark.parametrize(
    ("language", "labels", "mouths"),
    [
        ("mandarin", "ʂ ʐ̩ s z̩", ["sh", "s", "s", "s"]),
        ("swedish", "b ɨː", ["bmp", "iy"]),
        ("japanese", "s ɯ̥ k i", ["s", "kg", "iy"]),
        ("polish", "s ɨ n", ["s", "ux", "n"]),
    ],
)
def test_other_buzzing_and_whispered_vowels(language, labels, mouths):
    assert read(f"_ {labels} _", language, "ipa") == ["_", *mouths, "_"]
