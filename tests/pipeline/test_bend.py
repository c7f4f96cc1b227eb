"""Keys that bend a line: added to its curves, faded at the ends, and never past its promises."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.pipeline.bend import FADE_SECONDS, Bend, bend

LINE = ll.Schedule(
    ("M", "AA", "B", "IY", "F", "OW"), np.arange(7) * 0.15,
    words=(ll.Word("ma", 0, 2), ll.Word("be", 2, 4), ll.Word("foe", 4, 6)), notation="arpabet",
)  # fmt: skip


PERFORMER = ll.resolve("english", "crab")


def test_a_bend_passes_its_keys_and_fades_at_its_ends():
    one = Bend(0, np.array([1.0, 1.2, 1.2]), np.array([0.5, -0.25, 0.1]))
    at = one.at(
        np.array(
            [0.0, 1 - FADE_SECONDS, 1 - FADE_SECONDS / 2, 1.0, 1.1, 1.2 + FADE_SECONDS / 2, 2.0]
        )
    )
    assert at == pytest.approx([0, 0, 0.25, 0.5, 0.125, 0.05, 0])


def test_a_bend_has_no_corner():
    one = Bend(0, np.array([1.0, 1.2, 1.5]), np.array([0.5, -0.25, 1.0]))
    speeds = np.diff(one.at(np.arange(0.8, 1.7, 1e-4)))
    assert np.abs(np.diff(speeds)).max() < 0.01 * np.abs(speeds).max()


def test_curves_stay_within_bounds_and_others_stay():
    curves = np.array([[0.2, 0.9], [0.3, 0.4]])
    out = bend(curves, [Bend(0, np.array([0.0]), np.array([0.5]))], np.array([0.0, 0.01]))
    assert out[0] == pytest.approx([0.7, 1.0])
    assert (out[1] == curves[1]).all()
    assert curves[0, 1] == 0.9


def test_a_bend_moves_its_pose_near_its_keys_and_is_explained():
    plain, bent = PERFORMER.perform(LINE), PERFORMER.perform(LINE, bends={"smile": [(0.5, 0.4)]})
    moved = bent["smile"] - plain["smile"]
    assert moved.max() > 0.1
    assert plain.times[moved > 1e-3] == pytest.approx(0.5, abs=0.25)
    found = next(one for one in bent.explain(0.5).poses if one.pose == "smile")
    (step,) = [stage for stage in found.stages if stage.stage == "bend"]
    assert step.why == "the line's own keys add +0.400"


KEYS = st.lists(st.tuples(st.floats(0, 0.9), st.floats(-1, 1)), min_size=1, max_size=4)


@given(st.dictionaries(st.sampled_from(["mouthOpen", "mouthOO", "smile"]), KEYS))
def test_no_bend_passes_a_contact_or_a_speed_limit(keys):
    bends = {pose: sorted(points) for pose, points in keys.items()}
    bent = PERFORMER.perform(LINE, bends=bends)
    assert bent.weights.min() >= 0
    assert bent.weights.max() <= 1
    shut = np.abs(bent.times - 0.375).argmin()
    assert bent["mouthOpen"][shut] == pytest.approx(0, abs=1e-3)
    fastest = np.abs(np.diff(bent.weights, axis=0)).max() * bent.fps
    assert fastest <= PERFORMER.motion.speed_limit * 1.01


@pytest.mark.parametrize(
    ("bends", "told"),
    [({"nose": [(0, 1)]}, "unknown pose 'nose'"), ({"smile": [(0, 2)]}, "from -1 to 1"),
     ({"smile": []}, "pairs"), ({"smile": [(1, 0), (0, 0)]}, "in order of time"),
     ({"smile": [(float("nan"), 0)]}, "pairs"), ({"smile": [(0, 1, 2)]}, "pairs")],
)  # fmt: skip
def test_keys_that_cannot_be_are_told(bends, told):
    with pytest.raises(ll.LipsyncError, match=told):
        PERFORMER.perform(LINE, bends=bends)


def test_keys_of_a_line_are_counted_in_words(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    head = "kind: character\nformat: 1\nname: anna\nposeset: crab\nlines:\n"
    text = "  intro: {bends: {smile: [[1.5, 0.4]]}}\n  short: {bends: {smile: [[7.5, 0.4]]}}\n"
    (folder / "anna.yaml").write_text(head + text)
    anna = ll.resolve("english", "anna", paths=[tmp_path], cache=False)
    own, same = anna.perform(LINE, line="intro"), anna.perform(LINE, bends={"smile": [(0.45, 0.4)]})
    assert own.weights == pytest.approx(same.weights, abs=1e-9)
    with pytest.raises(ll.LipsyncError, match=r"point at word 7\.5"):
        anna.perform(LINE, line="short")
    (folder / "anna.yaml").write_text(head + "  intro: {bends: {smil: [[1.5, 0.4]]}}\n")
    with pytest.raises(ll.LipsyncError, match="smil"):
        ll.resolve("english", "anna", paths=[tmp_path], cache=False)
