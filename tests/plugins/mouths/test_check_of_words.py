"""The test words of a language on a head, beside the mouths of their sounds."""

import json

import pytest
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.plugins.mouths.words_check import LEAST_AWAY, words_on_face

CHARACTER = "kind: character\nformat: 1\nname: {name}\nposeset: facefx\n{rest}\n"


@pytest.fixture
def character(folder):
    """Return a function that measures a character of the shipped head."""
    (folder / "characters").mkdir()

    def measured(name, rest=""):
        path = folder / "characters" / f"{name}.yaml"
        path.write_text(CHARACTER.format(name=name, rest=rest), "utf-8")
        found = words_on_face(ll.resolve("english", name))
        return {(one.sound, one.measure): one for one in found.sounds}

    return measured


def test_what_is_asked_is_the_mouth_of_each_sound_and_the_worst_comes_first(character):
    found = character("plain")
    mouths = LIBRARY.common().model.mouths()
    for (sound, measure), one in found.items():
        name, _, step = sound.partition(" ")
        assert one.asked == pytest.approx(getattr(mouths[name][int(step or 1) - 1], measure))
    assert len({sound for sound, _ in found}) > 25
    away = [abs(one.seen - one.asked) for one in found.values()]
    assert away == sorted(away, reverse=True)
    assert found["bmp", "aperture"].seen < LEAST_AWAY < found["aa", "aperture"].seen


def test_a_sound_that_a_character_changes_is_seen_there_and_reach_and_mouths_are_asked(character):
    plain = character("plain")
    changed = character(
        "shut", "targets: {aa: {open: 0.05}}\nmouths: {eh: {aperture: 0.9, width: 0}}"
    )
    assert changed["aa", "aperture"].seen < plain["aa", "aperture"].seen / 2
    assert changed["eh", "aperture"].asked == 0.9
    wide = character("toon", "reach: 1.5")
    assert wide["aa", "aperture"].asked == pytest.approx(1.5 * plain["aa", "aperture"].asked)


def test_check_without_a_text_tells_them(folder, cli):
    ended = cli("check", "-l", "english", "-c", "facefx", "-o", "a.json", "-o", "a.txt")
    assert ended.code == 0
    told = json.loads((folder / "a.json").read_text("utf-8"))["words"]
    lines = (folder / "a.txt").read_text("utf-8").splitlines()
    assert lines[:2] == [told["subject"], f"  {told['judged']}"]
    assert lines[3].split()[-2:] == [f"{told['sounds'][0][one]:+.3f}" for one in ("asked", "seen")]
    assert lines[-4].startswith("aperture: ")


@pytest.mark.parametrize(
    ("rest", "why"),
    [
        (["-c", "arkit"], "weights were judged: this character has no model"),
        (["-c", "facefx", "-o", "a.xml"], "give a TEXT for pages, JUnit"),
        (["-c", "facefx", "--limit", "jitter=2"], "give a TEXT for pages, JUnit"),
        (["-c", "facefx", "-l", "espeak:sw"], "no test words that are read; give a TEXT"),
    ],
)
def test_what_needs_a_text_says_so(folder, cli, rest, why):
    ended = cli("check", "-l", "english", *rest)
    assert ended.code == 2
    assert why in ended.err
    assert not [*folder.iterdir()]
