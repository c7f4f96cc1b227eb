"""Notations of mouth shapes: read in every language, and never guessed."""

from dataclasses import replace

import numpy as np
import pytest
from packs_tree import TREE, plant, put
from shipped import LANGUAGES, LIBRARY, POSESETS
from spellings import spelling_conflicts

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.compile import compile_pair

COMMON = LIBRARY.common().model
VISEMES = COMMON.visemes
assert VISEMES, "a sweep over nothing passes"
every_notation = pytest.mark.parametrize("name", VISEMES)


def schedule(name, labels, **rest):
    """A line of these labels, a tenth of a second each."""
    labels = tuple(labels)
    return ll.Schedule(labels, np.arange(len(labels) + 1) / 10, notation=name, **rest)


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def heard(performer, line):
    numbers, _, _ = performer.common_phonemes(line)
    return [performer.compiled.phonemes[n] for n in numbers]


# The data


@every_notation
def test_each_shape_is_one_spelling_and_one_of_them_is_rest(name):
    labels = VISEMES[name].labels
    table = {label: tuple((to, 1.0) for to in sounds.to) for label, sounds in labels.items()}
    assert spelling_conflicts(table) == []
    assert sum(sounds.to == (COMMON.silence,) for sounds in labels.values()) == 1


DRAWN_OTHERWISE = {
    ("oculus", "nn"): "n is drawn as DD, which is d, t and n",
    ("oculus", "RR"): "r is solved with ou, whose lips are rounder",
    ("preston-blair", "U"): "w is drawn as WQ, whose lips are rounder",
}
"""Reason why the phoneme of a (notation, shape) is drawn as another shape."""

DRAWN_AS = {name: name for name in VISEMES} | {"sapi-visemes": "sapi", "azure": "sapi"}
"""Pose set with the shapes of a notation, if there is one."""

SAME = {("oculus", "I"): "ih", ("oculus", "O"): "oh", ("oculus", "U"): "ou"}
"""Two names of one shape."""

DRAWN = [name for name in VISEMES if DRAWN_AS[name] in POSESETS]
assert DRAWN, "a sweep over nothing passes"


@pytest.mark.parametrize("name", DRAWN)
def test_what_a_shape_is_read_as_is_drawn_as_that_shape(name):
    poseset = LIBRARY.poseset(DRAWN_AS[name]).model
    poses = {pose.removeprefix("viseme_"): pose for pose in (*poseset.poses, poseset.neutral)}
    otherwise = set()
    for label, sounds in VISEMES[name].labels.items():
        shape = poses[SAME.get((name, label), label)]
        targets = [target.weights for target in poseset.targets.get(sounds.to[0], ())]
        drawn = max(targets[0], key=targets[0].get) if targets and targets[0] else poseset.neutral
        if drawn != shape:
            otherwise.add((name, label))
    assert otherwise == {key for key in DRAWN_OTHERWISE if key[0] == name}


@every_notation
def test_every_shape_is_read(name, performer):
    labels = VISEMES[name].labels
    wanted = [to for sounds in labels.values() for to in sounds.to]
    assert heard(performer, schedule(name, labels)) == wanted


# In every language


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_reads_shapes(language):
    own = LIBRARY.language(language).model.adds
    for name in VISEMES:
        targets = {to for sounds in VISEMES[name].labels.values() for to in sounds.to}
        assert targets <= {*COMMON.base, COMMON.silence, *own}


def test_shapes_are_performed_alike_in_every_language():
    line = schedule("rhubarb", "XDCBFAGHX")
    english, mandarin = (
        ll.resolve(language, "rhubarb").perform(line) for language in ("english", "mandarin")
    )
    np.testing.assert_array_equal(english.weights, mandarin.weights)


@every_notation
def test_labels_are_never_guessed_to_be_shapes(name, performer):
    line = schedule(None, VISEMES[name].labels)
    own = [performer.compiled.notations[one] for one in performer.compiled.notations]
    assert performer.notation(line).table in own


def test_an_unknown_shape_is_named_with_its_notation(performer):
    with pytest.raises(ScheduleError, match=r"'EHSZ'.* is not in the preston-blair of eng"):
        performer.perform(schedule("preston-blair", ["AI", "EHSZ"]))
    with pytest.raises(ScheduleError, match="did you mean 'rhubarb'"):
        performer.perform(schedule("rhubab", ["A"]))
    rest = replace(performer, unknown="rest")
    assert heard(rest, schedule("preston-blair", ["AI", "EHSZ"])) == ["aa", "_"]


# In packs

SHAPES = """
visemes:
  mouths: {title: Mouths, labels: {A: p, B: [a, f], C: {to: [a, p], shares: [0.25, 0.75]}, X: _}}
  first: {title: Hidden, labels: {P: a}}
"""


def with_shapes(tmp_path, text=SHAPES):
    plant(tmp_path)
    put(tmp_path, "languages/common.yaml", TREE["languages/common.yaml"] + text)
    return Library([tmp_path], project=None)


def test_a_languages_own_notation_of_the_name_wins(tmp_path):
    compiled = compile_pair(with_shapes(tmp_path), "parent", "face")
    assert compiled.visemes["mouths"]["C"] == (("a", 0.25), ("p", 0.75))
    performer = ll.Performer(compiled, compiled.motion)
    assert heard(performer, schedule("mouths", "XBA")) == ["_", "a", "f", "p"]
    assert heard(performer, schedule("first", "P")) == ["p"]


def test_shapes_go_to_phonemes_that_every_language_has(tmp_path):
    bad = SHAPES.replace("A: p", "A: q").replace("P: a", "P: [a, yu]")
    faults = validate(with_shapes(tmp_path, bad), [tmp_path / "languages" / "common.yaml"])
    told = [(fault.code, fault.what) for fault in faults]
    assert told == [("P202", "unknown phoneme 'q'"), ("P202", "unknown phoneme 'yu'")]
    assert [fault.line for fault in faults] == [15, 16]
