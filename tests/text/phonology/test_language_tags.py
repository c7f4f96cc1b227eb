"""Languages by name, tag and alias, and packs over the packs that they shadow."""

import json
from pathlib import Path

import pytest
from lanes import full
from packs_tree import plant, put
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.finding import Finder, answers_of
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.resolver import cache
from lipsync_lang.text.phonology.language_names import folded_language


def schedule(*labels, **rest):
    return ll.Schedule(labels, [0.1 * n for n in range(len(labels) + 1)], **rest)


def spoken(performer, line):
    """The common phonemes of a schedule."""
    return [performer.compiled.phonemes[n] for n in performer.common_phonemes(line)[0]]


LANGUAGE = (
    "kind: language\nformat: 1\nname: {name}\ntag: {tag}\n{more}notations: {{ipa: {{a: aa}}}}\n"
)


def language(root, name, tag, more=""):
    return put(root, f"languages/{name}.yaml", LANGUAGE.format(name=name, tag=tag, more=more))


@pytest.fixture
def finder(tmp_path):
    """Languages with tags and aliases, besides the built-in languages."""
    language(tmp_path, "alpha", "qab", "aliases: [qab-AA, Alfa]\n")
    language(tmp_path, "beta", "qac-Latn", "aliases:  # several\n  - qac\n  - 'beta-one'  # old\n")
    language(tmp_path, "gamma", "qad-Hant", "aliases: [\n  qad-TW,\n  third]\n")
    language(tmp_path, "qae", "qaf")
    language(tmp_path, "Delta_2", "qae")
    return Finder([tmp_path], project=None)


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        ("alpha", "alpha"), ("ALPHA", "alpha"), ("qab", "alpha"), ("QAB-aa", "alpha"),
        ("qab_AA", "alpha"), ("alfa", "alpha"), ("qab-ZZ", "alpha"), ("qab-AA-x-me", "alpha"),
        ("qac", "beta"), ("qac-LATN", "beta"), ("Beta-One", "beta"), ("qac-Cyrl-XX", "beta"),
        ("qad-Hant-TW", "gamma"), ("qad_hant", "gamma"), ("qad-tw", "gamma"), ("third", "gamma"),
        ("qad", None), ("qad-Hans", None), ("alpha-x", None), ("", None), ("-", None),
        ("qae", "qae"), ("QAE", "Delta_2"), ("qae-XX", "Delta_2"), ("delta-2", "Delta_2"),
    ],
)  # fmt: skip
def test_a_language_answers_to_tags_and_aliases(finder, asked, expected):
    found = [Path(path).stem for path in finder.lookup("language", asked)]
    assert found == ([expected] if expected else [])


def test_answers_are_read_without_yaml(finder):
    named = {f.name: answers_of(f.path) for f in finder.names("language") if f.name < "e"}
    assert named["alpha"] == ["qab", "qab-aa", "alfa"]
    assert named["beta"] == ["qac-latn", "qac", "beta-one"]
    assert named["Delta_2"] == ["qae"]


@full
def test_every_shipped_language_answers_to_what_its_pack_says():
    for found in LIBRARY.names("language"):
        model = LIBRARY.language(found.name).model
        stated = map(folded_language, (model.tag, *model.aliases))
        assert answers_of(found.path) == list(dict.fromkeys(stated))
        assert LIBRARY.find("language", found.name) == found.path


@full
def test_one_alias_of_two_languages_is_a_warning(tmp_path):
    language(tmp_path, "one", "qab", "aliases: [same, qac]\n")
    language(tmp_path, "two", "qac", "aliases: [two, other, Same]\n")
    language(tmp_path, "zero", "qad", "aliases: [one]\n")
    faults = [f for f in validate(Library([tmp_path], project=None)) if f.code == "W305"]
    told = [(Path(f.file).name, f.line, f.column, f.what) for f in faults]
    assert told == [
        ("two.yaml", 4, 6, "tag 'qac' already belongs to language 'one'"),
        ("two.yaml", 5, 23, "alias 'same' already belongs to language 'one'"),
        ("zero.yaml", 5, 11, "alias 'one' already belongs to language 'one'"),
    ]


# A pack over the one it shadows


def test_a_project_adds_to_the_language_it_shadows(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    low, high = plant(tmp_path / "low"), tmp_path / "high"
    text = "kind: language\nformat: 1\nname: parent\ntag: qaa\nextends: parent\nwords: {hei: [a]}\n"
    put(high, "languages/parent.yaml", text)
    library = Library([high, low], project=None)
    pack = library.language("parent")
    assert pack.lineage == ("parent", "parent")
    assert [s.path.parents[1].name for s in pack.sources] == ["high", "low"]
    found = {word: one.phonemes for word, one in pack.model.words.items()}
    assert found == {"moi": ("p", "a"), "hei": ("a",)}
    assert pack.model.notations["first"]["P"].to == ("p",)
    own = high / "languages/parent.yaml"
    assert library.lookups["beneath", str(own)] == (str(low / "languages/parent.yaml"),)
    assert validate(Library([high, low], project=None), [own]) == []
    assert library.language("child").lineage == ("child", "parent", "parent")

    monkeypatch.chdir(tmp_path)
    paths = (high, low)
    ll.resolve("parent", "face", paths=paths)
    assert cache.load("parent", "face", paths) is not None
    middle = tmp_path / "middle"
    middle.mkdir()
    put(low, "languages/parent.yaml", (low / "languages/parent.yaml").read_text() + "# seen\n")
    assert cache.load("parent", "face", paths) is None


def test_a_new_pack_between_the_two_is_noticed(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    low, middle, high = plant(tmp_path / "low"), tmp_path / "middle", tmp_path / "high"
    middle.mkdir()
    text = "kind: language\nformat: 1\nname: parent\ntag: qaa\nextends: parent\n"
    put(high, "languages/parent.yaml", text)
    paths = (high, middle, low)
    ll.resolve("parent", "face", paths=paths)
    assert cache.load("parent", "face", paths) is not None
    put(middle, "languages/parent.yaml", text + "words: {hei: [a]}\n")
    assert cache.load("parent", "face", paths) is None
    assert ll.resolve("parent", "face", paths=paths).compiled.words == {
        "moi": ("p", "a"), "hei": ("a",),
    }  # fmt: skip


def test_a_pack_that_extends_itself_with_nothing_beneath_is_told_so(tmp_path):
    plant(tmp_path)
    text = "kind: language\nformat: 1\nname: own\ntag: qaa-own\nextends: own\n"
    path = put(tmp_path, "languages/own.yaml", text)
    library = Library([tmp_path], project=None)
    with pytest.raises(PackFaults, match="there is no other language 'own'") as caught:
        library.language("own")
    assert [(f.code, f.line) for f in caught.value.faults] == [("P210", 5)]
    assert library.lookups["beneath", str(path)] == ()


def test_the_built_in_english_can_be_added_to(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (
        "kind: language\nformat: 1\nname: english\ntag: en\nextends: english\n"
        "notations: {ipa: {ʙ: bmp}}\nwords: {gnocchi: [d, ao, kg, ih]}\n"
    )
    put(tmp_path, "languages/english.yaml", text)
    performer = ll.resolve("EN_us", "facefx", cache=False)
    assert performer.compiled.words["gnocchi"] == ("d", "ao", "kg", "ih")
    assert spoken(performer, schedule("ʙ", "t", notation="ipa")) == ["bmp", "d"]


def test_the_report_is_json():
    report = ll.resolve("espeak:sw", "facefx").report
    assert json.loads(json.dumps(vars(report)))["automatic"] is True
