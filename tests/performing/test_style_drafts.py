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
from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library

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


def test_faces_ship_the_five_styles():
    five = {"angry", "happy", "sad", "whisper", "shout"}
    assert all(set(DRAFTED[name]) == five for name in ("facefx", "arkit", "crab"))
    assert all({"whisper", "shout"} <= set(styles) for styles in DRAFTED.values())


@every_style
def test_a_style_shows_and_starts_and_ends_at_rest(poseset, style):
    performer = ll.resolve("english", poseset)
    plain, styled = (performer.perform(SAID, styles=s).weights for s in ({}, {style: 1}))
    assert np.abs(styled - plain).max() > 0.05
    assert np.abs(styled[[0, -1]]).max() <= 1e-5


@pytest.mark.parametrize("poseset", DRAFTED)
def test_a_shout_is_wide_and_a_whisper_small(poseset):
    performer = ll.resolve("english", poseset)
    jaw = performer.compiled.regions["jaw"]
    peaks = [
        performer.perform(SAID, styles={style: 1}).weights[:, jaw].sum(axis=1).max()
        for style in ("whisper", "shout")
    ]
    assert peaks[1] > 1.3 * peaks[0]


def test_half_a_style_is_half_way():
    performer = ll.resolve("english", "facefx")
    (_, plain), (_, half), (_, whole) = (
        stitched(performer, styles={"happy": share}) for share in (0, 0.5, 1)
    )
    apart = np.abs(whole - plain) > 0.02
    assert apart.any()
    # two bigrams are joined by their maximum, so that half a style may be a little above
    assert (half - (plain + whole) / 2)[apart] == pytest.approx(0, abs=0.03)


def test_an_offset_is_for_sounds_and_not_for_silence():
    performer = ll.resolve("english", "facefx", motion={"silence_reach": 0.1})
    wide = performer.poses.index("wide")
    times, happy = stitched(performer, styles={"happy": 1})
    sounding = (times > 0.1) & (times < SAID.end - 0.1)
    assert happy[wide, sounding].min() >= 0.25 - 1e-6
    assert happy[wide, [0, -1]].max() < 0.05


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


def test_a_bank_of_the_style_replaces_the_draft(tmp_path):
    folder = tmp_path / "posesets/facefx/banks"
    folder.mkdir(parents=True)
    (folder / "sad.yaml").write_text(BANK, "utf-8")
    performer = ll.resolve("english", "facefx", paths=tmp_path, cache=False)
    assert "sad" not in performer.compiled.style_drafts
    assert tuple(performer.compiled.style_origins) == ("sad",)
    assert "happy" in performer.compiled.style_drafts
    both = performer.perform(SAID, styles={"sad": 0.5, "happy": 0.5}).weights
    assert np.abs(both - performer.perform(SAID).weights).max() > 0.05


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
