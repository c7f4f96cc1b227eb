"""Every language pack, through its own voice: its texts become what its tests say."""

from operator import attrgetter

import pytest

from lipsync_lang import SpeechError, resolve, speak
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library

LIBRARY = Library(project=None)
PACKS = [
    LIBRARY.language(found.name).model
    for found in LIBRARY.names("language")
    if found.path.is_relative_to(built_in())
]
assert PACKS, "a sweep over nothing passes"

FACE = LIBRARY.names("poseset")[0].name
"""Any pose set: common phonemes are the same for all."""


def heard(text, language):
    """Speak text and return its common phonemes, pauses aside."""
    performer = resolve(language, FACE)
    ids, _, _ = performer.common_phonemes(speak(text, language))
    silence = performer.compiled.tables.silence
    return [performer.compiled.phonemes[i] for i in ids if i != silence]


@pytest.mark.parametrize("pack", PACKS, ids=attrgetter("name"))
def test_every_language_passes_its_own_tests(pack):
    if pack.tts is None:
        pytest.skip(f"{pack.name} names no voice")
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    wrong = {
        test.text: (" ".join(said), " ".join(test.phonemes))
        for test in pack.tests
        if (said := heard(test.text, pack.name)) != list(test.phonemes)
    }
    assert pack.tests, f"{pack.name} has no tests"
    assert not wrong


@pytest.mark.parametrize("pack", PACKS, ids=attrgetter("name"))
def test_every_language_resolves_on_every_pose_set_without_a_gap(pack):
    for found in LIBRARY.names("poseset"):
        report = resolve(pack.name, found.name).report
        assert not report.gaps
        assert len(report.phonemes) ** 2 == report.shared + report.extra


def test_a_voiceless_language_says_what_to_do(tmp_path):
    folder = tmp_path / "languages"
    folder.mkdir()
    (folder / "mute.yaml").write_text(
        "kind: language\nformat: 1\nname: mute\ntag: qaa\nnotations: {ipa: {a: aa}}\n"
    )
    with pytest.raises(SpeechError, match=r"mute names no voice: give its pack a `tts`"):
        speak("a", "mute", paths=[tmp_path])
