"""Teeth as a viewer sees them, on drawn mouths: none alone in "oo", none in m, on the lip in f.

A round mouth is no shut one: it leaves a hole. Rounded consonants look rounded from the front, too.

Words are spoken by the German pack, which has all rounded vowels. A sample of a picture shows the
material of the nearest triangle, so light and colours do not matter.
"""

from itertools import chain

import numpy as np
import pytest
from ict_clone import write_clone
from lanes import full

import lipsync_lang as ll
from lipsync_lang.render.model.camera import close_up
from lipsync_lang.render.model.raster import MIN_AREA, Window, area, fill, shown
from lipsync_lang.render.staging import staged, sweep

SIDE = 320
SOUND, PAUSE = 0.12, 0.3
WORDS = tuple(
    tuple(word.split())
    for word in (
        "k uː l", "b l uː", "l u p", "m yː d ə", "f ʏ n f", "m ʏ ts ə n", "oː f uː", "v yː s t",
        "ʃ v ɪ m ə n", "m ɛ n", "z uː m", "b ɛ t",
    )
)  # fmt: skip
SIBILANTS = tuple(
    tuple(word.split())
    for word in ("tʃ ɪ n", "ʃ iː", "f ɪ ʃ", "ʃ uː", "ʒ uː", "z uː", "z oː", "f l ʊ s", "dʒ ʌ dʒ")
)
ROUNDED = tuple(
    tuple(word.split())
    for word in ("s iː", "ʃ iː", "tʃ ɪ n", "dʒ ɛ t", "ɪ ʒ ə", "ɹ ɛ d", "ɪ ɹ ɪ", "f ɜː", "w ɪ")
)
FAST, BRISK = 0.07, 0.09
HASTY = tuple(
    tuple(word.split())
    for word in ("s w ɪ m", "s ɛ v ə n", "s uː n", "w iː s ɛ", "dʒ æ k", "m ɛ ʒ ɚ", "w ɑː tʃ ɪ z")
)
SHORT, SHOWN = 0.055, 0.042  # seconds of a fast closure, and of the frame of film in its middle
CLOSURES = tuple(
    tuple(word.split())
    for word in ("w oʊ m ɛ n", "b oʊ b oʊ θ", "ð ɛ m ɛ n", "s w ɪ m", "ɹ ɑː p ɑː", "ð ɪ b oʊ θ")
)
SHORT_ROUND = tuple(tuple(word.split()) for word in ("m uː v", "b uː b", "f ʏ n f", "t uː v ɔ l"))
LABIODENTALS = tuple(tuple(word.split()) for word in ("w uː f uː", "oʊ v ɚ", "f ɑː v", "v ɛ s t"))
INSIDE = ("teeth", "mouth", "gums", "tongue")


def seen(head, said=WORDS, language="german", lasting=SOUND, late=0.0):
    """Yield each sound with its word, the samples of each part of its mouth, and its hole's width.

    The mouth is seen in the middle of the sound, or some seconds `late`; the hole is a share of the
    width of the lips.
    """
    performer = ll.resolve(language, head)
    schedule = spoken(said, lasting)
    labels, times = schedule.labels, schedule.times
    animation = performer.rigged(performer.perform(schedule, fps=60))
    scene, camera = staged(animation), close_up(staged(sweep(animation)))
    names = np.array([*(row["name"] for row in scene.document["materials"]), "", ""])
    middles = dict(enumerate((times[1:] + times[:-1]) / 2))
    words = chain.from_iterable([word] * len(word) + [None] for word in said)
    for number, word in enumerate(words, 1):
        if word is not None:
            flat, near = camera.see(scene.points(scene.sound + middles[number] + late), SIDE)
            corners, depth = flat[scene.triangles], near[scene.triangles]
            faces = np.flatnonzero((area(corners) < -MIN_AREA) & (depth > 0).all(axis=1))
            keys = np.zeros(SIDE * SIDE, np.uint64)
            fill(keys, Window(0, 0, SIDE, SIDE), corners[faces], depth[faces], faces)
            triangles = shown(keys)
            parts = names[np.where(triangles >= 0, scene.material[triangles], -1)]
            count = {part: int((parts == part).sum()) for part in (*INSIDE, "lips")}
            hole = across(parts.reshape(SIDE, SIDE))
            yield " ".join(word), labels[number], count | {"across": hole}


def spoken(said, lasting):
    """Return the schedule of words whose sounds last so many seconds, with pauses between them."""
    labels = ["_", *chain.from_iterable([*word, "_"] for word in said)]
    seconds = [PAUSE if label == "_" else lasting for label in labels]
    return ll.Schedule(tuple(labels), np.cumsum([0.0, *seconds]), notation="ipa")


def across(image):
    """Return the width of the hole that is seen, as a share of that of the lips."""
    hole, lips = (np.isin(image, some).any(axis=0).nonzero()[0] for some in (INSIDE, ["lips"]))
    return np.ptp(hole) / np.ptp(lips) if len(hole) else 0.0


def faults(head, *manner):
    """Return what a viewer would refuse: (word, sound, cause) of each mouth."""
    found = []
    for word, sound, count in seen(head, *manner):
        inside, lips = sum(count[part] for part in INSIDE), count["lips"]
        if sound in {"uː", "u", "yː", "ʏ"} and count["teeth"] > 0.1 * inside:
            found.append((word, sound, "teeth in a round mouth"))
        if sound in {"uː", "u", "yː", "ʏ"} and inside < 0.01 * lips:
            found.append((word, sound, "a shut round mouth"))
        if sound == "m" and inside > 0.002 * lips:
            found.append((word, sound, "lips apart"))
        if sound in {"f", "v"} and not count["teeth"] >= 0.95 * inside > 0.01 * lips:
            found.append((word, sound, "teeth off the lip"))
        if sound == "ɛ" and count["teeth"] < 0.1 * inside:
            found.append((word, sound, "no teeth in a spread vowel"))
    return found


def test_the_shipped_head_shows_teeth_on_the_lip_and_none_in_round_or_shut_mouths():
    assert faults("facefx") == []


@pytest.mark.parametrize("late", [-SHOWN / 2, 0, SHOWN / 2])
def test_lips_of_the_shipped_head_are_shut_throughout_a_fast_closure(late):
    closed = 0
    for word, sound, found in seen("facefx", CLOSURES, "english", SHORT, late):
        if sound in {"m", "b", "p"}:
            assert sum(found[part] for part in INSIDE) < 0.012 * found["lips"], (word, sound)
            closed += 1
    assert closed == 7


def test_the_lower_lip_of_the_shipped_head_lies_on_the_upper_teeth_in_fast_labiodentals():
    heights = []
    for word, sound, found in seen("facefx", LABIODENTALS, "english", FAST):
        if sound in {"f", "v"}:
            inside = sum(found[part] for part in INSIDE)
            assert found["teeth"] > 0.93 * inside > 0.01 * found["lips"], (word, sound)
            heights.append(inside / found["lips"])
    assert len(heights) == 5
    assert max(heights) < 0.25, "a snarl"


def apart(head, least, *manner):
    """Return the sibilants whose rows of teeth fill less than a share of the hole."""
    return [
        (word, sound, count)
        for word, sound, count in seen(head, *(manner or (SIBILANTS,)))
        if sound in {"tʃ", "ʃ", "dʒ", "ʒ", "z", "s"}
        and count["teeth"] < least * sum(count[part] for part in INSIDE)
    ]


def test_the_teeth_of_the_shipped_head_meet_before_the_tongue_in_sibilants():
    assert apart("facefx", 0.88) == []
    assert apart("facefx", 0.84, HASTY, "english", FAST) == []


def test_the_teeth_of_the_shipped_head_meet_in_the_sibilants_of_mandarin_beside_rounded_vowels():
    shares = [
        count["teeth"] / sum(count[part] for part in INSIDE)
        for _, sound, count in seen("facefx", (("tɕʰ", "y"), ("ɕ", "y", "ɕ", "i")), "mandarin")
        if sound in {"tɕʰ", "ɕ"}
    ]
    assert len(shares) == 3
    assert min(shares) > 0.84


def test_fast_sibilants_shut_the_jaw_between_vowels_and_a_glide_with_the_tongue_of_sh_does_not():
    schedule = spoken((*HASTY, ("ɑː", "j", "ɑː")), FAST)
    animation = ll.resolve("english", "arkit").perform(schedule, fps=60)
    jaw = animation.weights[:, animation.poses.index("jawOpen")]
    middles = (schedule.times[1:] + schedule.times[:-1]) / 2
    at = zip(schedule.labels, np.interp(middles, animation.times, jaw), strict=True)
    low = [(label, weight) for label, weight in at if label in {"s", "z", "ʒ", "dʒ", "tʃ", "j"}]
    assert [label for label, weight in low if weight > 0.09] == ["j"]


def test_human_heads_keep_a_last_m_shut_the_lips_of_s_low_and_the_tongue_of_th_out():
    said = (*map(tuple, map(str.split, ("s w ɪ m", "θ ɪ n", "l ɔː"))),)
    schedule = spoken(said, SOUND)
    animation = ll.resolve("english", "arkit").perform(schedule, fps=120)

    def at(number, pose, share=0.5):
        start, end = schedule.times[number : number + 2]
        weights = animation.weights[:, animation.poses.index(pose)]
        return np.interp(start + share * (end - start), animation.times, weights)

    last, tongue, low, round_ = (schedule.labels.index(one) for one in ("m", "θ", "s", "ɔː"))
    assert at(last, "jawOpen", 1) < 0.02
    assert at(tongue, "tongueOut") > 0.44 > at(tongue + 1, "tongueOut")
    assert at(low, "mouthUpperUpLeft") < 0.15 < at(low, "mouthLowerDownLeft")
    assert at(round_, "jawOpen") > 0.3, "the rows of teeth are apart behind a round mouth"


def test_a_short_front_rounded_vowel_between_an_m_and_teeth_parts_the_jaw_in_its_pucker():
    schedule = spoken((("m", "ʏ", "ts", "ə", "n"),), FAST)
    animation = ll.resolve("german", "arkit").perform(schedule, fps=120)
    now = schedule.times[[2, 3]].mean()
    jaw, pucker = (
        np.interp(now, animation.times, animation.weights[:, animation.poses.index(pose)])
        for pose in ("jawOpen", "mouthPucker")
    )
    assert jaw > 0.15
    assert pucker > 0.32


def test_human_heads_part_short_round_lips_between_labials_and_no_pucker_hides_the_teeth_of_f():
    schedule = spoken(SHORT_ROUND, BRISK)
    animation = ll.resolve("german", "arkit").perform(schedule, fps=120)
    middles = (schedule.times[1:] + schedule.times[:-1]) / 2
    jaw, close, pucker = (
        np.interp(middles, animation.times, animation.weights[:, animation.poses.index(pose)])
        for pose in ("jawOpen", "mouthClose", "mouthPucker")
    )
    assert (close <= jaw + 1e-4).all()
    for label, gap, rounding in zip(schedule.labels, jaw - close, pucker, strict=True):
        if label == "uː":
            assert gap > 0.08
            assert rounding > 0.2
        if label in {"f", "v"}:
            assert rounding < 0.13, "the teeth are hidden"


def test_rounded_consonants_of_the_shipped_head_look_rounded_from_the_front():
    for word, sound, found in seen("facefx", ROUNDED, "english"):
        if sound in {"ʃ", "tʃ", "dʒ", "ʒ", "ɹ", "ɜː", "w"}:
            assert 0.3 < found["across"] < 0.7, (word, sound)
        if sound in {"s", "iː"}:
            assert found["across"] > 0.75, (word, sound)


@full
@pytest.mark.parametrize("seed", [None, 4, 8])
def test_a_made_head_does_so_too(tmp_path, seed):
    reason = "the room of heads was removed"
    models = pytest.importorskip("lipsync_lang.plugins.heads.face_model", reason=reason)
    heads = pytest.importorskip("lipsync_lang.plugins.heads.made_head", reason=reason)
    clone = models.FaceModel(write_clone(tmp_path / "clone", 40), models.read_recipe("ict"))
    made = heads.make_head(clone, heads.HeadWish(seed=seed))
    path = tmp_path / "head.glb"
    path.write_bytes(made.content)
    assert faults(path) == faults(path, SHORT_ROUND, "german", BRISK) == []
    assert apart(path, 0.86) == []
    assert apart(path, 0.78, HASTY, "english", FAST) == []


def test_a_round_mouth_that_shows_its_teeth_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    stated = "kind: character\nformat: 1\nname: anna\nposeset: facefx\ntargets: {w: {ShCh: 0.6}}\n"
    (tmp_path / "characters" / "anna.yaml").write_text(stated)
    assert {(sound, cause) for _, sound, cause in faults("anna")} >= {
        (sound, "teeth in a round mouth") for sound in ("uː", "u")
    }


@pytest.mark.parametrize("reach", [0.5, 1.6])
def test_round_shut_spread_and_tongue_stay_readable_at_any_reach(reach, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    stated = f"kind: character\nformat: 1\nname: anna\nposeset: facefx\nreach: {reach}\n"
    (tmp_path / "characters" / "anna.yaml").write_text(stated)
    words = tuple(tuple(word.split()) for word in ("b l uː", "f iː", "θ ɪ n", "m ɛ n"))
    for word, sound, found in seen("anna", words):
        inside = sum(found[part] for part in INSIDE)
        if sound == "uː":
            assert found["across"] < 0.5, "a flat slit"
            assert inside > 0.05 * found["lips"] > found["teeth"], word
        if sound == "iː":
            assert found["across"] > 0.75, word
        if sound == "θ":
            assert found["tongue"] > 0.3 * inside, word
        if sound == "f":
            assert found["teeth"] >= 0.95 * inside > 0.01 * found["lips"], word
        if sound in {"b", "m"}:
            assert inside <= 0.002 * found["lips"], word
