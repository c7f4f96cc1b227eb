"""Explanations of weights: names, places and values that can be checked."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import RATES, real

from lipsync_lang import LipsyncError, Schedule, resolve
from lipsync_lang.animations.animation import Animation
from lipsync_lang.pipeline.motion import PRESETS
from lipsync_lang.pipeline.perform import CURVE_RATE
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.schedules.schedule import Word

LABELS = ("_", "HH", "AH", "L", "OW", "P", "IY", "F", "M", "B", "T", "CH", "W", "_", "AY", "Z")
SCHEDULE = Schedule(
    LABELS,
    np.concatenate(([0], np.cumsum(np.random.default_rng(3).uniform(0.04, 0.16, len(LABELS))))),
    words=(Word("hello", 1, 5), Word("peef", 5, 8), Word("mbt", 8, 11), Word("eyes", 14, 16)),
    notation="arpabet",
)
TAKES = st.floats(0, 1)


def there(place):
    """Return the line at a place, from its column on."""
    file, line, column = place.rsplit(":", 2)
    text = Path(file).read_text("utf-8").splitlines()
    return text[int(line) - 1], int(column)


def explained(take, fps, performer=None):
    animation = (performer or real()).perform(SCHEDULE, fps=fps)
    first, last = animation.times[[0, -1]]
    return animation, animation.explain(float(first + take * (last - first)))


@given(TAKES, RATES)
def test_the_explanation_names_the_phoneme_and_its_word(take, fps):
    animation, found = explained(take, fps)
    assert found.seconds == animation.times[found.frame]
    assert found.start - 1e-6 <= found.seconds <= found.end + 1e-6
    if found.index is None:
        assert (found.phoneme, found.common, found.word) == ("_", "_", None)
        return
    start, end = SCHEDULE.times[found.index : found.index + 2]
    if found.index > 0:  # the silence it begins with reaches before it
        assert start - 1e-6 <= found.seconds <= end + 1e-6
    assert found.phoneme == LABELS[found.index]
    notation = real().notation(SCHEDULE)
    assert notation.find(found.phoneme) == ((found.common, 1.0),)
    word = next((w for w in SCHEDULE.words if w.first <= found.index < w.stop), None)
    assert found.word == (word.text if word else None)


@given(TAKES, RATES)
def test_both_bigrams_are_named_with_the_lines_of_their_targets(take, fps):
    animation, found = explained(take, fps)
    common = [real().notation(SCHEDULE).find(label)[0][0] for label in LABELS]
    neighbours = {*zip(["_", *common], [*common, "_"], strict=True)}
    if found.common != "_":
        assert [bigram.pair[1 - n] for n, bigram in enumerate(found.bigrams)] == [found.common] * 2
    for bigram in found.bigrams:
        assert bigram.pair in neighbours
        assert found.common in bigram.pair
        assert 0 <= bigram.position <= 1
        assert (bigram.layer, bigram.status) == ("draft", "drafted")
        assert len(bigram.places) == 2
        for phoneme, place in zip(bigram.pair, bigram.places, strict=True):
            line, column = there(place)
            assert re.match(rf"  {phoneme}: ", line), (phoneme, line)
            assert line[column - 1] in "[{", "the column is where the target begins"
    assert len(animation.poses) == len(found.poses)


@pytest.mark.parametrize("preset", PRESETS)
@given(take=TAKES, fps=RATES)
def test_the_last_stage_is_what_the_animation_shows(preset, take, fps):
    animation, found = explained(take, fps, real().with_motion(preset))
    for number, pose in enumerate(found.poses):
        assert pose.pose == animation.poses[number]
        shown = animation.weights[found.frame, number]
        assert pose.weight == pytest.approx(shown, abs=1e-9)
        assert pose.stages[-1].weight == pose.weight
        stitched = pose.stages[0]
        assert stitched.stage == "stitch"
        # the paper's curves are read between their own samples
        read = 1e-9 if preset == "default" or CURVE_RATE % fps == 0 else 2e-3
        assert stitched.weight == pytest.approx(max(pose.bigrams, default=0), abs=read)
        for before, after in zip(pose.stages, pose.stages[1:], strict=False):
            changed = abs(after.weight - before.weight) > 1e-3
            assert bool(after.why) or not changed, "what changed a value says why"


@given(TAKES, RATES)
def test_the_winner_is_the_pose_that_leaves_the_least_room(take, fps):
    _, found = explained(take, fps)
    stages = {p.pose: next(s for s in p.stages if s.stage == "constrain") for p in found.poses}
    weights = {pose: stage.weight for pose, stage in stages.items()}
    why = {pose: stage.why for pose, stage in stages.items()}
    yielding = ("open", "W", "wide", "FV")
    assert not any(reason for pose, reason in why.items() if pose not in yielding)
    if why["open"]:
        strongest = max(("PBM", "FV", "ShCh"), key=weights.get)
        winner = why["open"].split()[0]
        assert weights[winner] == weights[strongest]


@pytest.mark.parametrize(
    ("label", "pose", "contact", "floor"), [("P", "PBM", "lips", 0.7), ("F", "FV", "teeth", 0.5)]
)
def test_a_p_or_an_f_makes_open_yield_and_says_so(label, pose, contact, floor):
    times = [0, 0.3, 0.33, 0.6]
    schedule = Schedule(("AA", label, "AA"), times, words=(Word("word", 0, 3),), notation="arpabet")
    animation = real().with_motion({"thresholds": "paper"}).perform(schedule, fps=100)
    found = animation.explain(0.302)
    poses = {p.pose: p for p in found.poses}
    assert (found.phoneme, found.word) == (label, "word")
    last, other = (
        next(s for s in poses[name].stages if s.stage == "constrain") for name in ("open", pose)
    )
    assert last.why == f"{pose} outranks it: together at most 0.5"
    assert last.weight == pytest.approx(max(0, 0.5 - other.weight))
    assert poses[pose].weight >= floor - GIVEN
    assert other.why == ""
    printed = str(found)
    assert f"0.300 s (frame {found.frame}): {label} as" in printed
    assert f"{pose} outranks it: together at most 0.5" in printed
    assert json.loads(json.dumps(found.to_dict()))["word"] == "word"
    held = next(s for s in poses[pose].stages if s.stage == "hold")
    assert held.why in ("", f"contact '{contact}' holds it at {floor} or more")


def bank(folder):
    path = folder / "posesets" / "facefx" / "banks" / "mine.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(
        "kind: bank\nformat: 1\nname: mine\nposeset: facefx\nbigrams:\n"
        "  aa-bmp: {word: opera, status: approved, curves: {}}\n"
        "  bmp-aa: {word: papa, curves: {open: [[0.4, 0], [0.7, 0.9], [1, 0]]}}\n",
        "utf-8",
    )
    return path


def test_a_bigram_of_a_bank_is_named_with_its_layer_status_word_and_line(tmp_path):
    path = bank(tmp_path)
    performer = resolve("english", "facefx", paths=[tmp_path], cache=False)
    schedule = Schedule(("AA", "P", "AA"), [0, 0.3, 0.4, 0.7], notation="arpabet")
    found = performer.perform(schedule, fps=100).explain(0.35)
    ending, beginning = found.bigrams
    assert (ending.pair, ending.layer, ending.status) == (("aa", "bmp"), "shared", "approved")
    assert (beginning.pair, beginning.layer, beginning.status) == (
        ("bmp", "aa"),
        "shared",
        "edited",
    )
    assert (ending.word, beginning.word) == ("opera", "papa")
    for bigram in found.bigrams:
        (place,) = bigram.places
        line, _ = there(place)
        assert line.startswith(f"  {'-'.join(bigram.pair)}: ")
        assert Path(place.rsplit(":", 2)[0]).resolve() == path.resolve()
    # the banks say nothing of PBM here: the contact alone lifts it, and says so
    poses = {p.pose: p for p in found.poses}
    held = next(s for s in poses["PBM"].stages if s.stage == "hold")
    assert held.weight >= 0.7
    assert held.why == "contact 'lips' holds it at 0.7 or more"


def test_a_time_outside_and_an_animation_of_nobody_are_told_of():
    animation = real().perform(SCHEDULE, fps=30)
    for seconds in (animation.times[0] - 0.02, animation.times[-1] + 0.02, float("nan")):
        with pytest.raises(LipsyncError, match="is outside the animation, which runs from"):
            animation.explain(seconds)
    bare = Animation(animation.times, animation.poses, animation.weights, 30, SCHEDULE)
    with pytest.raises(LipsyncError, match="it cannot be explained"):
        bare.explain(0.1)
