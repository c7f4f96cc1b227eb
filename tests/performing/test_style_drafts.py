"""Styles drafted from the neutral bigrams: visible, within all promises, and below banks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import swept
from shipped import LIBRARY
from strategies import assert_promises
from test_loudness import line

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.reports.quality.check_animation import check_all

SAID = Schedule(
    ("M", "AA", "B", "IY", "S", "UW", "P", "AA"), np.arange(9) * 0.13, notation="arpabet"
)
DRAFTED = {
    one.name: tuple(LIBRARY.poseset(one.name).model.styles)
    for one in LIBRARY.names("poseset")
    if LIBRARY.poseset(one.name).model.styles
}
STYLES = [(name, style) for name, styles in DRAFTED.items() for style in styles]
every_style = pytest.mark.parametrize(("poseset", "style"), swept(STYLES, quick=STYLES[::4]))


def stitched(performer, **how):
    performance = performer.performance(SAID, 60, **how)
    curves = performance.stages(0, performance.frames.count)[0].curves
    return performance.frames.times(), curves


def spoken(performer, **how):
    """Return the weights of a line on the poses of speech, (T, P)."""
    return performer.perform(SAID, **how).weights[:, : len(performer.poses)]


def test_faces_ship_six_styles_and_sets_of_visemes_alone_fewer():
    five = {"angry", "happy", "sad", "whisper", "shout"}
    faces = ("facefx", "arkit", "crab", "vrm", "vrm0", "mpeg4")
    assert all(set(DRAFTED[name]) >= five and len(DRAFTED[name]) == 6 for name in faces)
    assert all({"whisper", "shout", "sad"} <= set(styles) for styles in DRAFTED.values())


@every_style
def test_a_style_shows_and_starts_and_ends_at_rest(poseset, style):
    performer = ll.resolve("english", poseset)
    plain, styled = (performer.perform(SAID, styles=s) for s in ({}, {style: 1}))
    apart = styled.weights[:, : len(performer.poses)] - plain.weights
    assert max(np.abs(apart).max(), styled.weights[:, len(performer.poses) :].max(initial=0)) > 0.05
    assert np.abs(styled.weights[[0, -1]]).max() <= 1e-5


OPENS = {"angry": (1.2, 1.65), "shout": (1.3, 2.1), "sad": (0.6, 0.98)}
"""How far styles open: actors do so 1.4 times as far in anger, and 0.9 in sadness."""

VARIED = Schedule(
    ("D", "EH", "N", "IY", "T", "AA", "M", "OW", "K", "AE", "S", "IH", "L", "AH", "P", "UW"),
    np.arange(17) * 0.12,
    notation="arpabet",
)


@pytest.mark.parametrize(
    ("poseset", "style"),
    [
        (name, style)
        for name, style in STYLES
        if style in OPENS and "aperture" in LIBRARY.poseset(name).model.measures
    ],
)
def test_an_angry_line_opens_wider_and_a_sad_one_less(poseset, style):
    """In sets of whole mouths as well, whose vowels share the face and cannot all grow."""
    performer = ll.resolve("english", poseset)
    gains = performer.compiled.measures["aperture"]
    takes = (performer.perform(VARIED, styles=own) for own in ({}, {style: 1}))
    plain, styled = (
        np.quantile(sum(gain * take[pose] for pose, gain in gains.items()), 0.9) for take in takes
    )
    low, high = OPENS[style]
    assert low <= styled / plain <= high


def test_a_sad_upper_lip_comes_down_where_the_lips_press():
    styled = ll.resolve("english", "arkit").perform(SAID, styles={"sad": 1})
    assert styled["mouthShrugUpper"].max() > 0.1
    pressed = [np.abs(styled.times - middle).argmin() for middle in (2.5 * 0.13, 6.5 * 0.13)]
    assert styled["mouthShrugUpper"][pressed].max() < 0.07


PAUSED = Schedule(("M", "AA", "pau", "P", "IY"), [0, 0.13, 0.26, 1.4, 1.5, 1.7], notation="arpabet")
POSTURES = [
    (name, style, stated.posture)
    for name, styles in DRAFTED.items()
    for style, stated in LIBRARY.poseset(name).model.styles.items()
    if stated.posture
]
every_posture = pytest.mark.parametrize(
    ("poseset", "style", "posture"),
    swept(POSTURES, quick={one[0]: one for one in POSTURES}.values()),
)


@every_posture
def test_a_line_is_judged_by_its_poses_of_speech_beside_a_posture(poseset, style, posture):
    performer = ll.resolve("english", poseset)
    plain, styled = (performer.perform(SAID, styles=own) for own in ({}, {style: 1}))
    both = check_all([plain, styled], performer)
    assert both == [*map(ll.check, (plain, styled))]
    shown = performer.with_expression(styled, dict.fromkeys(["browInnerUp", *posture], 0.1))
    assert len(shown.poses) > len(styled.poses) >= len(plain.poses)
    for quality in (both[1], ll.check(shown)):
        made = [one.value for one in quality.figures if one.name.startswith("contacts")]
        assert made
        assert not any(made)


@every_posture
def test_a_posture_holds_in_a_pause_and_is_let_go_at_the_ends(poseset, style, posture):
    styled = ll.resolve("english", poseset).perform(PAUSED, styles={style: 1})
    pause = (styled.times > 0.7) & (styled.times < 0.9)
    for pose, weight in posture.items():
        assert styled[pose][pause] == pytest.approx(weight, abs=0.01)
        assert styled[pose][[0, -1]].max() <= 1e-5


@every_posture
def test_a_stream_shows_the_posture_of_a_style_as_the_whole_line_does(poseset, style, posture):
    performer = ll.resolve("english", poseset)
    whole = performer.perform(PAUSED, styles={style: 1})
    stream = performer.stream(notation="arpabet", styles={style: 1})
    stream.feed(PAUSED)
    stream.finish()
    times, weights = stream.frames()
    assert stream.poses == whole.poses
    assert np.array_equal(times, whole.times)
    assert np.abs(weights - whole.weights).max() <= 1e-6
    held = weights[np.abs(times - 0.8).argmin(), [stream.poses.index(pose) for pose in posture]]
    assert held == pytest.approx([*posture.values()], abs=0.01)


def test_a_posture_is_at_half_for_half_a_style_and_a_column_only_with_it():
    performer = ll.resolve("english", "arkit")
    half, none = (performer.perform(PAUSED, styles={"happy": share}) for share in (0.5, 0))
    middle = int(np.abs(half.times - 0.8).argmin())
    assert half["mouthSmileLeft"][middle] == pytest.approx(0.325, abs=0.01)
    assert none.poses == performer.poses
    told = str(half.explain(0.8))
    assert "mouthSmileLeft = 0.325\n    stitch    0.325  the posture of happy adds 0.325" in told


def test_an_expression_adds_to_a_posture():
    performer = ll.resolve("english", "arkit")
    smiling = performer.perform(PAUSED, styles={"happy": 1})
    more = performer.with_expression(smiling, {"mouthFrownLeft": 1, "cheekPuff": 0.2})
    assert more["mouthFrownLeft"].max() == 1
    assert more.poses == (*smiling.poses, "cheekPuff")


@pytest.mark.parametrize("poseset", DRAFTED)
def test_a_shout_is_wide_and_a_whisper_small(poseset):
    performer = ll.resolve("english", poseset)
    jaw = performer.compiled.regions["jaw"]
    peaks = [
        performer.perform(SAID, styles={style: 1}).weights[:, jaw].sum(axis=1).max()
        for style in ("whisper", "shout")
    ]
    assert peaks[1] > 2 * peaks[0]


def test_half_a_style_is_half_way():
    performer = ll.resolve("english", "facefx")
    poses = len(performer.poses)
    plain, half, whole = (
        stitched(performer, styles={"happy": share})[1][:poses] for share in (0, 0.5, 1)
    )
    apart = np.abs(whole - plain) > 0.02
    assert apart.any()
    # two bigrams are joined by their maximum, so that half a style may be a little above
    assert (half - (plain + whole) / 2)[apart] == pytest.approx(0, abs=0.03)


def test_an_offset_is_for_sounds_and_not_for_silence():
    performer = ll.resolve("english", "facefx", motion={"silence_reach": 0.1})
    jaw = performer.poses.index("open")
    times, shout = stitched(performer, styles={"shout": 1})
    sounding = (times > 0.1) & (times < SAID.end - 0.1)
    assert shout[jaw, sounding].min() >= 0.14 - 1e-6
    assert shout[jaw, [0, -1]].max() < 0.05


def test_styles_are_drafted_only_when_they_are_heard():
    performer = ll.resolve("english", "facefx")
    assert performer.compiled.tables.styles == ()
    assert performer.performance(SAID, 60).tables is performer.compiled.tables
    one, two = (performer.performance(SAID, 60, styles={"sad": 1}).tables for _ in range(2))
    assert one is two
    neutral, sad = one.neutral.curves, one.styles[performer.compiled.style_names.index("sad")]
    assert not np.array_equal(sad.curves, neutral)
    assert all(np.array_equal(b.curves, neutral) for b in one.styles if b is not sad)


def test_a_frame_names_the_draft_of_a_style():
    told = str(ll.resolve("english", "facefx").perform(SAID, styles={"sad": 0.5}).explain(0.2))
    assert "style sad 0.50: draft, drafted\n      " in told
    assert "facefx/poseset.yaml:" in told


def test_the_cache_keeps_them(tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path))
    first, again = (ll.resolve("english", "facefx").compiled.style_drafts for _ in range(2))
    assert first == again
    assert list(tmp_path.iterdir())


BANK = """kind: bank
format: 1
name: sad
poseset: facefx
style: sad
bigrams:
  bmp-aa: {curves: {open: [[0, 0], [0.5, 0.3], [1, 0]]}}
"""


def test_a_drawn_bigram_of_a_style_leaves_its_other_bigrams_and_its_posture(tmp_path):
    folder = tmp_path / "posesets/facefx/banks"
    folder.mkdir(parents=True)
    (folder / "sad.yaml").write_text(BANK, "utf-8")
    performer = ll.resolve("english", "facefx", paths=tmp_path, cache=False)
    compiled = performer.compiled
    assert tuple(compiled.style_origins) == ("sad",)
    assert compiled.style_names[0] == "sad"

    def curves(one):
        tables = one.performance(SAID, 60, styles={"sad": 1}).tables
        return tables.styles[one.compiled.style_names.index("sad")].curves

    drafted, drawn = curves(ll.resolve("english", "facefx", cache=False)), curves(performer)
    changed = np.flatnonzero(np.abs(drawn - drafted).max(axis=(1, 2)) > 0)
    assert set(changed) == {*map(int, compiled.style_origins["sad"])}
    assert ("bmp", "aa") in [compiled.origins[row].pair for row in changed]
    posture = np.array(compiled.style_drafts["sad"]["posture"], np.float32)
    assert posture.any()
    pose = int(posture.argmax())
    assert drawn[changed[0], :, pose] == pytest.approx(posture[pose])

    both = spoken(performer, styles={"sad": 0.5, "happy": 0.5})
    assert np.abs(both - spoken(performer)).max() > 0.05


POSESET = """kind: poseset
format: 1
name: mini
poses: {mouth: {region: jaw}}
styles:
  angry: {regions: {jaws: 1.2}, scale: {mouht: 1.1}}
  happy: {offset: {smile: 0.2}}
"""


def test_a_style_that_names_a_pose_or_region_the_set_lacks_is_located(tmp_path):
    file = tmp_path / "posesets/mini/poseset.yaml"
    file.parent.mkdir(parents=True)
    file.write_text(POSESET, "utf-8")
    found = validate(Library([tmp_path], project=None), [file])
    assert [(f.code, f.line, f.hint) for f in found if f.severity == "fault"] == [
        ("P230", 6, "did you mean 'jaw'?"),
        ("P201", 6, "did you mean 'mouth'?"),
        ("P201", 7, "known: mouth"),
    ]


def test_a_character_may_name_a_drafted_style(tmp_path):
    file = tmp_path / "characters/anna.yaml"
    file.parent.mkdir()
    text = (
        "kind: character\nformat: 1\nname: anna\nposeset: facefx\nstyles: {happy: 0.4, hapy: 1}\n"
    )
    file.write_text(text, "utf-8")
    found = validate(Library([tmp_path], project=None), [file])
    assert [(f.code, f.hint) for f in found] == [("W320", "did you mean 'happy'?")]


def test_an_unknown_style_is_told_which_there_are():
    with pytest.raises(LipsyncError, match="unknown style 'angri'; did you mean 'angry'"):
        ll.resolve("english", "facefx").perform(SAID, styles={"angri": 1})


@given(
    st.sampled_from([(name, style) for name, styles in DRAFTED.items() for style in styles]),
    st.floats(0, 1),
    st.floats(0.03, 0.3),
    st.sampled_from([24, 60, 120]),
)
def test_no_style_breaks_a_promise(named, share, seconds, fps):
    poseset, style = named
    performer = ll.resolve("english", poseset)
    performance = performer.performance(line([3000] * 9, seconds), fps, styles={style: share})
    weights = performance.weights()
    assert weights.min() >= 0
    assert weights.max() <= 1
    assert_promises(performance)
    for low, high, threshold in performance.tables.caps:
        assert (weights[:, low] + weights[:, high]).max() <= threshold + 1e-9
    for low, high in performance.tables.at_most:
        assert (weights[:, low] - weights[:, high]).max() <= 1e-9
