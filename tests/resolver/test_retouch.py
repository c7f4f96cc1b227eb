"""Changed bigrams of a compiled pair, compared with the same files compiled again."""

import gc
import weakref
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, swept
from packs_tree import CHILD, COMMON, plant, put

from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import ABSENT, SplicedText
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.pipeline.tables import Contact, Tables
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.compiled import CompiledPair, Origin, Report
from lipsync_lang.resolver.retouch import OpenPair

HEAD = "kind: bank\nformat: 1\nname: {0}\nposeset: {1}\n{2}bigrams: {{}}\n"
FILES = {"first": "", "second": "", "spoken": "language: {0}\n", "sad": "style: sad\n"}
"""Additional banks: two shared ones, one of a language, and one of a style."""

CHARACTER = "kind: character\nformat: 1\nname: mine\nposeset: {0}\nbigrams: {{}}\n"


def project(folder, poseset, language):
    """Make empty banks for a pose set, and a character; return their texts."""
    files = {folder / "characters/mine.yaml": CHARACTER.format(poseset)}
    for name, more in FILES.items():
        path = folder / f"posesets/{poseset}/banks/{name}.yaml"
        files[path] = HEAD.format(name, poseset, more.format(language))
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return {path.stem: SplicedText.read(path, text.encode()) for path, text in files.items()}


def placeless(value):
    """Return a value of a compiled pair without line numbers, and with comparable arrays."""
    if isinstance(value, Origin):
        return value._replace(places=())
    if isinstance(value, Report):
        return replace(value, warnings=tuple(w.partition(": ")[2] for w in value.warnings))
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, (CompiledPair, Tables, Contact)):
        return {field.name: placeless(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: placeless(one) for key, one in value.items()}
    return tuple(map(placeless, value)) if isinstance(value, tuple) else value


def assert_equal(one, other):
    """Compare two compiled pairs to the last bit, except the places of origins."""
    mine, yours = placeless(one), placeless(other)
    assert mine.keys() == yours.keys()
    assert not [name for name in mine if mine[name] != yours[name]]


PHONEMES = ["_", "aa", "ow", "l", "bmp", "d", "w", "ax", "ae", "uh", "wx", "n", "yu", "y"]
"""Silence, the base, shades, and sounds that other languages add."""

POSES = {"facefx": ["open", "W", "PBM", "tBack"], "crab": ["mouthOpen", "mouthOO", "tongueTip"]}

POINTS = st.lists(st.sampled_from([0, 0.2, 0.55, 1]), min_size=2, max_size=5).map(
    lambda values: [[t / (len(values) - 1), value] for t, value in enumerate(values)]
)


def entries(poseset):
    return st.fixed_dictionaries(
        {"curves": st.dictionaries(st.sampled_from(POSES[poseset]), POINTS, max_size=3)},
        optional={
            "status": st.sampled_from(["edited", "approved"]),
            "boundary": st.sampled_from([0.3, 0.5]),
            "contact": st.just("free"),
            "interpolation": st.just("linear"),
            "word": st.just("low"),
        },
    )


def changes(poseset):
    sound = st.sampled_from(PHONEMES)
    pairs = st.tuples(sound, sound).filter(lambda pair: set(pair) != {"_"})
    new = st.one_of(entries(poseset), st.just(ABSENT))
    return st.tuples(st.sampled_from(["mine", *FILES]), pairs.map("-".join), new)


PAIRS = [("facefx", "english"), ("crab", "finnish"), ("crab", "english"), ("facefx", "finnish")]


@pytest.mark.parametrize(("poseset", "language"), swept(PAIRS, 2))
@given(data=st.data())
@costly()
def test_a_retouched_pair_equals_the_files_compiled_anew(poseset, language, data, tmp_path):
    texts = project(tmp_path, poseset, language)
    library = Library([tmp_path], project=None)
    pair = OpenPair.open(library, language, "mine")
    for some in data.draw(st.lists(st.lists(changes(poseset), min_size=1, max_size=3), max_size=4)):
        for name, key, entry in some:
            texts[name] = texts[name].changed([(("bigrams", key), entry)])
        pair = pair.retouched(texts.values())
    unsaved = {text.path: text.content for text in texts.values()}
    anew = Library([tmp_path], project=None, unsaved=unsaved, earlier=library)
    assert_equal(pair.compiled, compile_pair(anew, language, "mine"))


LAYERED = [
    ("first", "a-f", 0.1), ("spoken", "a-f", 0.2), ("mine", "a-f", 0.3), ("first", "ae-p", 0.4),
    ("second", "ae-p", 0.5), ("sad", "ae-p", 0.6), ("mine", "yu-f", 0.7), ("sad", "a-b", 0.8),
    ("mine", "ae-b", 0.9), ("second", "b-ae", 1.0), ("first", "_-b", 0.5), ("spoken", "f-_", 0.5),
]  # fmt: skip
"""Bigrams with precedence: layers, files, shades and their parents, added sounds, styles."""


@pytest.mark.parametrize("order", swept([1, -1]))
def test_layers_and_shades_hide_each_other_one_by_one(tmp_path, order):
    plant(tmp_path)
    shades = "shades:\n  ae: {like: a, ipa: [æ], reason: r}\n  b: {like: p, ipa: [b], reason: r}\n"
    put(tmp_path, "languages/common.yaml", COMMON + shades)
    labels = CHILD.replace("P: f", "P: f\n    A: ae\n    B: b")
    put(tmp_path, "languages/child.yaml", labels)
    texts = project(tmp_path, "face", "child")
    library = Library([tmp_path], project=None)
    pair = OpenPair.open(library, "child", "mine")
    edits = [(name, key, {"curves": {"open": [[0, top], [1, 0]]}}) for name, key, top in LAYERED]
    gone = [(name, key, ABSENT) for name, key, _ in edits[::order]]
    for name, key, entry in [*edits, *gone]:
        texts[name] = texts[name].changed([(("bigrams", key), entry)])
        unsaved = {text.path: text.content for text in texts.values()}
        library = Library([tmp_path], project=None, unsaved=unsaved, earlier=library)
        pair = pair.retouched([texts[name]])
        assert_equal(pair.compiled, compile_pair(library, "child", "mine"))


def test_a_changed_bigram_has_its_place(tmp_path):
    texts = list(project(tmp_path, "facefx", "english").values())[1:]
    pair = OpenPair.open(Library([tmp_path], project=None), "english", "mine")
    new = texts[0].changed([(("bigrams", "l-ow"), {"curves": {}})])
    origins = {origin.pair: origin for origin in pair.retouched([new]).compiled.origins}
    assert origins["l", "ow"].places == (f"{texts[0].path}:6:3",)
    assert pair.retouched([new, texts[0]]).compiled.tables.curves.flags.writeable is False


def test_what_is_no_bigram_needs_compiling_anew(tmp_path):
    texts = list(project(tmp_path, "facefx", "english").values())[1:]
    pair = OpenPair.open(Library([tmp_path], project=None), "english", "mine")
    assert pair.retouched([texts[0].changed([(("style",), "sad")])]) is None
    other = tmp_path / "posesets/facefx/banks/new.yaml"
    text = texts[0].content.replace(b"name: first", b"name: new")
    assert pair.retouched([SplicedText.read(other, text)]) is None
    assert pair.retouched(texts).compiled is pair.compiled


def test_an_unknown_pose_is_told_with_its_place(tmp_path):
    texts = list(project(tmp_path, "facefx", "english").values())[1:]
    pair = OpenPair.open(Library([tmp_path], project=None), "english", "mine")
    new = texts[0].changed([(("bigrams", "l-ow"), {"curves": {"opne": [[0, 0], [1, 1]]}})])
    with pytest.raises(PackFaults, match=r"first\.yaml:8:7: P201 unknown pose 'opne'"):
        pair.retouched([new])


def test_tables_of_earlier_edits_are_let_go(tmp_path):
    plant(tmp_path)
    texts = project(tmp_path, "face", "child")
    pair = OpenPair.open(Library([tmp_path], project=None), "child", "mine")
    before = weakref.ref(pair.compiled.tables)
    new = texts["first"].changed([(("bigrams", "a-p"), {"curves": {"open": [[0, 1], [1, 0]]}})])
    pair = pair.retouched([new])
    gc.collect()
    assert before() is None
