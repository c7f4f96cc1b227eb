"""Every built-in pose set speaks every language, and keeps its promises."""

from functools import cache
from itertools import pairwise, product

import numpy as np
import pytest
from lanes import skip_if_its_reader_was_removed, swept
from shipped import LIBRARY, POSESETS, RESTING

from lipsync_lang import Schedule, resolve
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.settings import motion_with
from lipsync_lang.sound.speech.speaking.speaker import Speaker

EXACT = 1e-9
FPS = 30
WORDS = 8
MAX_LINES = 100
"""Maximum number of lines of YAML in a pose set with its gestures, without comments and blanks."""

every_set = pytest.mark.parametrize("name", POSESETS)
every_pair = pytest.mark.parametrize(
    ("language", "name"),
    swept(
        product(RESTING, POSESETS),
        quick=set(zip(RESTING[:: len(RESTING) // len(POSESETS)], POSESETS, strict=False)),
    ),
)
"""Every language on every pose set; each pose set once in the quick lane."""

READERS = ("espeakng_loader", "pypinyin", "opencc", "pyopenjtalk", "thaiphon", "pythainlp")
"""Engines for the writing of a language that must be installed."""


@cache
def sentence(language):
    """Words of a language's own tests, read aloud with estimated times."""
    tests = LIBRARY.language(language).model.tests
    text = " ".join(test.text for test in tests[:WORDS] if test.text) or "a"
    return Speaker.of(language).speak(text, engine="none")


def demanded(performance):
    """Yield each contact, with the span of every phoneme that demands it."""
    track = performance.track
    for contact, (wanted, _) in zip(performance.tables.contacts, performance.held, strict=True):
        for number in np.flatnonzero(wanted):
            yield contact, track.bounds[number], track.bounds[number + 1]


def assert_promises(performance, name):
    tables, weights = performance.tables, performance.weights()
    times = performance.frames.times()
    assert np.isfinite(weights).all(), name
    assert weights.min() >= 0, name
    assert weights.max() <= 1, name
    assert weights.max() > 0.2, f"{name}: nothing moves"
    assert np.abs(weights[[0, -1]]).max() <= 1e-5, name
    step = performance.motion.speed_limit / FPS
    assert np.abs(np.diff(weights, axis=0)).max() <= step + EXACT, name
    for low, high, threshold in tables.caps:
        over = weights[:, low] + weights[:, high] > threshold + EXACT
        assert (weights[over, low] <= EXACT).all(), name
    for pose, other in tables.at_most:
        assert (weights[:, pose] <= weights[:, other] + EXACT).all(), name
    for contact, start, end in demanded(performance):
        near = (times >= start - 0.5 / FPS - 1e-6) & (times <= end + 0.5 / FPS + 1e-6)
        up = (weights >= 0.9 * contact.floor - EXACT).all(axis=1)
        down = (weights <= contact.ceiling + GIVEN + EXACT).all(axis=1)
        assert (near & up & down).any(), (name, start)
    hold = performance.motion.hold
    if hold:
        shown = np.where(weights.any(axis=1), weights.argmax(axis=1), -1)
        held = np.logical_or.reduce([frames for _, frames in performance.held])
        bounds = [0, *(np.flatnonzero(np.diff(shown)) + 1), len(shown)]
        least = round(hold * FPS)
        for start, stop in list(pairwise(bounds))[1:-1]:
            contact = held[max(0, start - 2 * least) : stop + 2 * least].any()
            assert stop - start >= least or contact, (name, start, stop)


@every_pair
def test_every_language_is_performed_with_all_promises_kept(language, name):
    for module in READERS:
        pytest.importorskip(module, reason=f"{module} is not installed, which reads a language")
    skip_if_its_reader_was_removed(LIBRARY.language(language).model.g2p)
    compiled = compile_pair(LIBRARY, language, name)
    report = compiled.report
    assert not report.gaps
    assert len(report.phonemes) ** 2 == report.shared + report.extra
    performer = Performer(compiled, motion_with(compiled.motion, None))
    assert_promises(performer.performance(sentence(language), FPS), language)


@every_set
def test_a_pose_set_is_sound_and_says_nothing_in_vain(name):
    path = LIBRARY.find("poseset", name)
    assert not [str(fault) for fault in validate(LIBRARY, [path.parent])]


@every_set
def test_a_pose_set_with_its_styles_fits_on_two_screens(name):
    text = LIBRARY.find("poseset", name).read_text("utf-8")
    stated = [one for one in text.splitlines() if one.strip() and not one.strip().startswith("#")]
    shades = {f"{shade}:" for shade in LIBRARY.common().model.shades}  # which nobody has to state
    assert len([one for one in stated if one.split()[0] not in shades]) <= MAX_LINES


@every_set
def test_every_phoneme_has_a_target_and_every_pose_a_title(name):
    model = LIBRARY.poseset(name).model
    phonemes = LIBRARY.common().model.phonemes
    assert not [label for label in phonemes if label not in model.targets and label != "_"]
    assert not [pose for pose, told in model.poses.items() if not told.title or not told.region]
    assert model.measures


@pytest.mark.parametrize("round_vowel", ["uː", "ʊ", "ɔː"])
def test_a_round_vowel_does_not_part_the_teeth_of_an_s_before_it(round_vowel):
    schedule = Schedule(("_", "s", round_vowel, "_"), (0, 0.2, 0.36, 0.6, 0.8), notation="ipa")
    animation = resolve("english", "facefx").perform(schedule)
    hissing = (animation.times >= 0.22) & (animation.times <= 0.3)
    assert animation["W"][hissing].max() < 0.3, "it begins early all the same"
    assert animation["W"].max() > 0.3, "the vowel itself is round"


@pytest.mark.parametrize(("before", "after"), [("v", "m"), ("f", "p"), ("v", "b")])
def test_teeth_let_go_of_the_lip_where_lips_press(before, after):
    labels = ("_", "a", before, after, "a", "_")
    times = (0, 0.2, 0.35, 0.43, 0.5, 0.65, 0.9)
    animation = resolve("english", "facefx").perform(Schedule(labels, times, notation="ipa"))
    pressed = (animation["PBM"] >= 0.7) & (animation.times >= 0.43) & (animation.times <= 0.5)
    assert pressed.any()
    assert animation["FV"][pressed].max() < 0.2
    bitten = (animation["FV"] >= 0.6) & (animation.times >= 0.35) & (animation.times <= 0.43)
    assert bitten.any()
