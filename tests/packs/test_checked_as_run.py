"""Faults that a command refuses when it performs: `validate` refuses them before."""

import re

import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.models.motion_models import MotionFields
from lipsync_lang.pipeline.motion import PRESETS, Motion
from lipsync_lang.resolver.settings import RANGES, motion_with

PACK = "kind: language\nformat: 1\nname: x\ntag: en-x-x\nextends: english\n"

MISTAKES = {
    "tts: {engine: espek}": ("6:15: P115", "did you mean 'espeak'?"),
    "durations: {vowel: 110}": ("6:20: P104", "at most 5"),
    "stress_digits: [arpa]": ("6:17: P217", "did you mean 'arpabet'?"),
    "motion: {window: 80}": ("6:18: P104", "at most 10"),
    "motion: {hold: 80}": ("6:16: P104", "at most 10"),
    "motion: {preset: papr}": ("6:18: P107", "did you mean 'paper'?"),
    "motion: papr": ("6:9: P107", "did you mean 'paper'?"),
}


AUDIO = {
    "audio: {model: lm}": "6:16: P239 pocketsphinx has no model 'lm'",
    "audio: {align: pocketsfinx}": "6:16: P239 unknown aligner 'pocketsfinx'",
    "audio: {align: [warp, 'pocketsphinx:lm']}": "6:16: P239 pocketsphinx has no model 'lm'",
    "audio: {align: ['pocketsphinx:./lm']}": "lm: no such folder",
    "audio: {recognise: sounds}": "6:20: P239 unknown recogniser 'sounds'",
    "audio: {recognise: 'pocketsphinx:lm'}": "6:20: P239 pocketsphinx has no model 'lm'",
}


@pytest.fixture
def validate(cli, folder):
    (folder / "languages").mkdir()

    def checked(text, *more):
        (folder / "languages" / "x.yaml").write_text(f"{PACK}{text}\n")
        return cli("validate", "languages/x.yaml", *more)

    return checked


@pytest.mark.parametrize("text", MISTAKES)
def test_a_mistake_that_a_run_would_refuse_or_ignore_is_a_fault(validate, text):
    place, hint = MISTAKES[text]
    ended = validate(text)
    assert ended.code == 1
    assert f"languages/x.yaml:{place} " in ended.out
    assert hint in ended.out
    assert validate(text, "--no-tests").out == ended.out, "an engine is no test"


def test_a_fault_of_the_common_phonemes_hides_no_other(validate, folder):
    (folder / "languages/common.yaml").write_text("kind: phonemes\nformat: 1\nfoo: 1\n")
    ended = validate("motion: papr", "languages")
    assert ended.code == 1
    assert "common.yaml:3:1: P101" in ended.out
    assert "languages/x.yaml:6:9: P107" in ended.out


@pytest.mark.parametrize("text", AUDIO)
def test_an_engine_that_a_recording_would_miss_is_a_fault(validate, cli, folder, text):
    pytest.importorskip("pocketsphinx", reason="the extra `audio` is not installed")
    ended = validate(text)
    assert ended.code == 1
    assert AUDIO[text] in ended.out
    (folder / "models" / "lm").mkdir(parents=True)
    assert ("'lm'" in AUDIO[text]) == (validate(text).code == 0)
    assert validate("audio: {align: warp, recognise: sound}").code == 0
    assert "6:16: P213" in validate("audio: {model: ../../lm}").out
    ended = cli("languages", "check", "languages/x.yaml")
    assert "P239" not in ended.out


@pytest.mark.parametrize("label", ["{", "}", "[", "]", ",", "!", '"', "'", "{~", "!\\"])
def test_a_label_that_begins_with_a_sign_of_yaml_is_to_be_quoted(validate, label):
    ended = validate(f"notations:\n  sampa:\n    a: aa\n    {label}: ae\n    b: bmp")
    assert "languages/x.yaml:9:5: P008" in ended.out
    quoted = re.search(r"write it in quotes: `(.+): \.\.\.`", ended.out)[1]
    assert validate(f"notations:\n  sampa:\n    a: aa\n    {quoted}: ae\n    b: bmp").code == 0


def test_a_full_width_colon_is_named(validate):
    ended = validate("notations:\n  sampa:\n    a：aa\n    b: bmp")
    assert "8:6: P008 a full-width colon" in ended.out
    assert "write `a: aa`" in ended.out


@pytest.mark.parametrize(
    ("text", "place", "hint"),
    [
        ("words:\n  foo： [aa]", "7:3", "write `foo: [aa]`"),
        ("words:\n  foo：[aa]", "7:3", "write `foo: [aa]`"),
        ("g2p:\n  engine： espeak", "7:3", "write `engine: espeak`"),
        ("words： {foo: [aa]}", "6:6", "write `words: `"),
        ("words： [aa]", "6:6", "write `words: `"),
        ("words: {foo： [aa]}", "6:12", "write `foo: `"),
    ],
)
def test_a_full_width_colon_of_an_only_entry_is_named(validate, text, place, hint):
    told = validate(text).out
    assert f"languages/x.yaml:{place}: " in told
    assert "a full-width colon is no colon in YAML" in told
    assert hint in told


@pytest.mark.parametrize("name", ["IPA", "ipaa", "arpabett"])
def test_a_notation_that_is_nearly_inherited_is_doubted(validate, name):
    ended = validate(f"notations: {{{name}: {{a: aa}}}}")
    assert (ended.code, "6:13: W321" in ended.out) == (0, True)
    assert validate(f"notations: {{{name}: {{a: aa}}}}", "--strict").code == 1
    assert validate("notations: {mine: {a: aa}}", "--strict").code == 0


def test_a_region_of_softness_must_be_one_of_the_poses(cli, folder):
    (folder / "posesets" / "q").mkdir(parents=True)
    (folder / "posesets" / "q" / "poseset.yaml").write_text(
        "kind: poseset\nformat: 1\nname: q\nposes: {a: {region: jaw}}\ntargets: {aa: {a: 1}}\n"
        "softness: {jaw: 0.1, eyes: 0.1}\n"
    )
    assert "poseset.yaml:6:22: P230 unknown region 'eyes'" in cli("validate").out


def test_the_ranges_of_packs_are_those_of_calls():
    for name, (least, most) in RANGES.items():
        beyond = [least - 1] + [most + 1] * (most < 1e5)
        for value in beyond:
            with pytest.raises(ValueError, match=name):
                MotionFields(**{name: value})
            with pytest.raises(LipsyncError, match=name):
                motion_with(Motion(), {name: value})
    for preset in PRESETS:
        assert MotionFields(preset=preset).preset == preset
