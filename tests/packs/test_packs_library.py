"""Places of packs, and their descriptions in a library."""

import subprocess
import sys
from pathlib import Path

import pytest
from lanes import full
from packs_tree import ANNAS_BANK, BANK, CHILD, PARENT, POSESET, TREE, plant, put

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs import finding
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.describe import kinds, schema
from lipsync_lang.packs.finding import Finder, built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import MODELS
from lipsync_lang.packs.yaml import building
from lipsync_lang.packs.yaml.building import scan
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.resolver.compile import compile_pair


@pytest.fixture
def library(tmp_path):
    return Library([plant(tmp_path)], project=None)


def offer(site: Path, value: str, monkeypatch) -> None:
    """Install a distribution whose entry point offers packs."""
    put(site, "offer-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: offer\nVersion: 1.0\n")
    put(site, "offer-1.0.dist-info/entry_points.txt", f"[lipsync_lang.packs]\noffer = {value}\n")
    monkeypatch.syspath_prepend(site)


def test_a_pack_of_the_project_that_is_found_first_overrides_a_built_in_one(tmp_path):
    own = put(tmp_path, "project/languages/english.yaml", CHILD)
    put(tmp_path, "project/languages/child.yaml", CHILD)
    put(tmp_path, "given/languages/english.yaml", CHILD)
    project = tmp_path / "project"
    assert Finder((), project).overriding("language", "english") == (own,)
    assert Finder((), project).overriding("language", "child") == ()
    assert Finder((), project).overriding("language", "french") == ()
    assert Finder([tmp_path / "given"], project).overriding("language", "english") == ()


def test_places_are_searched_in_order(tmp_path, monkeypatch):
    names = ["given", "variable", "project", "site/offered/packs"]
    given_, variable, project, offered = (plant(tmp_path / name) for name in names)
    put(tmp_path, "site/offered/__init__.py", "raise SystemExit('must not run')")
    offer(tmp_path / "site", "offered.packs", monkeypatch)
    monkeypatch.setenv(finding.PATH_VARIABLE, f"{variable}:{tmp_path / 'gone'}:")
    monkeypatch.chdir(project)

    finder = Finder([given_])

    assert [root.path for root in finder.roots] == [
        given_, variable, project, offered, built_in(),
    ]  # fmt: skip
    assert [root.origin for root in finder.roots] == [
        "path", finding.PATH_VARIABLE, "project", "installed: offer", "built-in",
    ]  # fmt: skip
    assert finder.find("language", "child") == given_ / "languages/child.yaml"


def test_the_first_of_a_name_shadows_the_others(tmp_path):
    first, second = tmp_path / "first", plant(tmp_path / "second")
    mine = put(first, "languages/child.yaml", CHILD)
    library = Library([first, second], project=None)
    found = [f for f in library.names("language") if f.name == "child"]
    assert [(f.path, f.shadowed_by) for f in found] == [
        (mine, None),
        (second / "languages/child.yaml", mine),
    ]
    assert library.language("child").path == mine


def test_a_place_is_searched_once(tmp_path):
    roots = Finder([plant(tmp_path), tmp_path], project=tmp_path).roots
    assert [root.path for root in roots] == [tmp_path, built_in()]


def test_a_given_folder_must_be_there(tmp_path):
    with pytest.raises(PackError, match="no such folder"):
        Library([tmp_path / "gone"])


def test_unsaved_contents_stand_in_for_files(tmp_path, monkeypatch):
    home = plant(tmp_path)
    saved = Library([home], project=None)
    old = saved.poseset("face"), saved.banks("face")[0]
    named = POSESET.replace("title: Face", "title: New").encode()
    unsaved = {
        home / "posesets/face/poseset.yaml": named,
        home / "posesets/face/banks/more.yaml": BANK.replace("name: common", "name: more").encode(),
        home / "posesets/other/poseset.yaml": named.replace(b"name: face", b"name: other"),
        home / "characters/ben.yaml": TREE["characters/anna.yaml"].replace("anna", "ben").encode(),
        home / "characters/ben-bank.yaml": ANNAS_BANK.replace("anna", "ben").encode(),
    }
    read = []
    monkeypatch.setattr(building, "scan", lambda path, _: read.append(path.name) or scan(path, _))
    library = Library([home], project=None, unsaved=unsaved, earlier=saved)
    assert library.poseset("face").model.title == "New"
    assert library.banks("face")[0].model is old[1].model
    assert [bank.model.name for bank in library.banks("face")] == ["common", "more"]
    assert library.poseset("other").model.name == "other"
    ben = library.character("ben")
    assert [bank.model.name for bank in library.character_banks(ben)] == ["ben-bank"]
    assert read == ["poseset.yaml", "more.yaml", "poseset.yaml", "ben.yaml", "ben-bank.yaml"]
    assert [found.name for found in library.names("character")] == ["anna", "ben"]
    again = Library([home], project=None, unsaved={}, earlier=library)
    assert again.poseset("face").model.title == "Face"
    compiled = compile_pair(library, "child", "ben")
    assert compiled.character == "ben"


@full
def test_a_broken_distribution_is_a_warning(tmp_path, monkeypatch):
    offer(tmp_path, "nowhere.packs", monkeypatch)
    faults = [f for f in validate(Library(project=None)) if f.code == "W304"]
    assert len(faults) == 1
    assert faults[0].severity == "warning"


@pytest.mark.parametrize("name", ["../languages/child", "/etc/passwd", "", ".", "child.yaml", "c*"])
@pytest.mark.parametrize("kind", ["language", "poseset", "character"])
def test_a_name_never_leaves_its_folder(library, kind, name):
    with pytest.raises(PackError, match="unknown"):
        library.find(kind, name)


def test_unknown_names_come_with_the_nearest(library):
    with pytest.raises(PackError, match="unknown language 'chld': did you mean 'child'"):
        library.language("chld")
    with pytest.raises(PackError, match="unknown pose set 'fase': did you mean 'face'"):
        library.poseset("fase")
    with pytest.raises(PackError, match="unknown character 'ana': did you mean 'anna'"):
        library.character("ana")


def test_a_language_answers_to_its_tag(library, tmp_path):
    assert library.language("QAA-xx").model.name == "child"
    put(tmp_path, "languages/qaa.yaml", PARENT.replace("name: parent", "name: qaa"))
    assert Library([tmp_path], project=None).language("qaa").model.name == "qaa"


@full
def test_two_languages_of_one_tag_are_a_warning(tmp_path):
    plant(tmp_path)
    put(tmp_path, "languages/zwei.yaml", PARENT.replace("name: parent", "name: zwei"))
    faults = [f for f in validate(Library([tmp_path], project=None)) if f.code == "W305"]
    assert [(Path(f.file).name, f.line, f.column) for f in faults] == [("zwei.yaml", 4, 6)]


def test_a_shared_name_is_a_warning_where_its_file_is_validated(tmp_path):
    plant(tmp_path)
    taken = next(f for f in Library(project=None).names("language") if f.name != "common")
    copy = put(tmp_path, f"languages/{taken.path.name}", taken.path.read_text("utf-8"))
    twin = put(tmp_path, "languages/zwei.yaml", PARENT.replace("name: parent", "name: zwei"))
    other = tmp_path / "languages/child.yaml"
    own = {"W305", "W323"}

    def told(*paths):
        found = validate(Library([tmp_path], project=None), paths)
        return [(f.code, Path(f.file).name) for f in found if f.code in own]

    assert told(twin) == [("W305", "zwei.yaml")]
    assert told(other) == told(copy) == [], "an equal copy changes nothing"
    put(
        tmp_path,
        f"languages/{taken.path.name}",
        PARENT.replace("name: parent", f"name: {taken.name}"),
    )
    assert ("W323", copy.name) in told(copy)
    assert told(other) == []


@full
@pytest.mark.parametrize("kind", ["language", "poseset"])
def test_a_pack_in_place_of_a_built_in_one_is_a_warning_unless_it_extends_it(kind, tmp_path):
    shipped = Library(project=None)
    name = next(found.name for found in shipped.names(kind))
    file, text = {
        "language": (f"languages/{name}.yaml", PARENT.replace("name: parent", f"name: {name}")),
        "poseset": (
            f"posesets/{name}/poseset.yaml",
            POSESET.replace("name: face", f"name: {name}"),
        ),
    }[kind]
    for extends, places in (("", [(file, 3)]), (f"extends: {name}\n", [])):
        put(tmp_path, file, text.replace("title:", f"{extends}title:", 1))
        found = [f for f in validate(Library([tmp_path], project=None)) if f.code == "W323"]
        assert [(Path(f.file).relative_to(tmp_path).as_posix(), f.line) for f in found] == places


def test_common_is_no_language(library):
    assert {f.name for f in library.names("language")} >= {"child", "parent"}
    assert "common" not in {f.name for f in library.names("language")}
    assert library.common().model.base == ("p", "f", "a")


def test_a_pose_set_is_a_character_too(library):
    bare = library.character("face")
    assert (bare.model.poseset, bare.model.title, bare.model.bigrams) == ("face", "Face", {})
    assert bare.path.name == "poseset.yaml"


def test_a_face_is_found_in_other_letters_too(tmp_path):
    for name in ("Big_Crab", "big-crab"):
        put(tmp_path, f"characters/{name}.yaml", f"kind: character\nname: {name}\nposeset: crab\n")
    finder = Finder(tmp_path, project=None)
    assert finder.find("character", "Big_Crab").stem == "Big_Crab"
    assert finder.find("character", "big-crab").stem == "big-crab"
    assert finder.find("character", "BIG-CRAB").stem == "Big_Crab", "the first of several"
    assert finder.find("poseset", "CRAB").parent.name == "crab"


def test_a_characters_banks_are_no_characters(library):
    assert "anna-bank" not in {f.name for f in library.names("character")}
    banks = library.character_banks(library.character("anna"))
    assert [bank.model.name for bank in banks] == ["anna-bank"]


def test_banks_come_in_the_order_of_their_names(tmp_path):
    plant(tmp_path)
    for name in ("zz", "aa"):
        put(tmp_path, f"posesets/face/banks/{name}.yaml", BANK.replace("common", name, 1))
    banks = Library([tmp_path], project=None).banks("face")
    assert [bank.model.name for bank in banks] == ["aa", "common", "zz"]


def test_a_dialect_lies_over_its_parent(library):
    pack = library.language("child")
    model = pack.model
    assert pack.lineage == ("child", "parent")
    assert (model.name, model.tag, model.g2p.engine) == ("child", "qaa-XX", "rules")
    assert model.notations["first"]["P"].to == ("f",)
    assert model.notations["first"]["Y"].to == ("yu",)
    assert list(model.notations) == ["first", "ipa", "own"]
    assert {word: one.phonemes for word, one in model.words.items()} == {"moi": ("f",)}
    assert set(model.adds) == {"yu"}
    assert model.tests == ()


def test_places_follow_to_the_file_that_states_a_label(library):
    pack = library.language("child")
    here = [
        (("notations", "first", "P"), "child.yaml", 8, 8),
        (("notations", "first", "Y", "to", 0), "parent.yaml", 12, 20),
        (("words", "moi"), "child.yaml", 10, 14),
        (("tests",), "parent.yaml", 19, 3),
        (("g2p", "engine"), "parent.yaml", 7, 15),
    ]
    for loc, file, line, column in here:
        place = pack.where(loc)
        assert (place.file.name, place.line, place.column) == (file, line, column)


def test_places_are_shown_from_the_current_folder(library, tmp_path, monkeypatch):
    place = library.poseset("face").where(("poses", "FV"), key=True)
    monkeypatch.chdir(tmp_path)
    assert str(place) == f"{Path('posesets/face/poseset.yaml')}:8:3"
    monkeypatch.chdir(tmp_path / "languages")
    assert str(place) == f"{tmp_path / 'posesets/face/poseset.yaml'}:8:3"


def test_a_longer_circle_of_languages_is_a_fault(tmp_path):
    plant(tmp_path)
    put(tmp_path, "languages/parent.yaml", PARENT.replace("adds:", "extends: child\nadds:"))
    with pytest.raises(PackFaults, match="child -> parent -> child") as caught:
        Library([tmp_path], project=None).language("child")
    assert [f.code for f in caught.value.faults] == ["P211"]


def test_lookups_and_files_are_noted_and_repeatable(library, tmp_path):
    library.common()
    library.language("qaa-xx")
    library.character("face")
    library.banks("face")
    library.rigs("face")
    finder = Finder([tmp_path], project=None)
    assert {kind for kind, _ in library.lookups} == {
        "phonemes", "language", "character", "poseset", "banks", "rigs",
    }  # fmt: skip
    for (kind, name), found in library.lookups.items():
        assert finder.lookup(kind, name) == found
    assert {Path(path).name for path in library.files} == {
        "common.yaml", "child.yaml", "parent.yaml", "poseset.yaml", "model.yaml",
    }  # fmt: skip
    assert all(len(digest) == 64 for digest in library.files.values())


def test_faults_of_several_banks_come_at_once(tmp_path):
    plant(tmp_path)
    for name in ("one", "two"):
        text = BANK.replace("common", name, 1).replace("boundary: 0.4", "boundary: 4")
        put(tmp_path, f"posesets/face/banks/{name}.yaml", text)
    library = Library([tmp_path], project=None)
    with pytest.raises(PackFaults) as caught:
        library.banks("face")
    assert [Path(f.file).name for f in caught.value.faults] == ["one.yaml", "two.yaml"]
    assert tuple(library.faults) == caught.value.faults


def test_a_missing_file_is_a_fault(tmp_path):
    faults = validate(Library(project=None), [tmp_path / "gone.yaml"])
    assert [f.code for f in faults] == ["P001"]


def test_a_single_file_can_be_validated(tmp_path):
    plant(tmp_path)
    path = put(tmp_path, "posesets/face/poseset.yaml", POSESET.replace("FV: 0.9}", "FV: 9}"))
    library = Library([tmp_path], project=None)
    assert [f.code for f in validate(library, [path])] == ["P104"]
    assert validate(library, [tmp_path / "languages"]) == []


def test_importing_the_finder_is_light():
    code = "import sys, lipsync_lang.packs.finding as f; f.Finder(); print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {"pydantic", "ruamel.yaml", "numpy"} & set(loaded)


def test_every_shipped_pack_is_sound():
    faults = [f for f in validate(Library(project=None)) if f.severity == "fault"]
    assert not faults, "\n".join(map(str, faults))


@pytest.mark.parametrize("kind", sorted(MODELS))
def test_every_kind_has_a_schema_that_explains_itself(kind):
    made = schema(kind)
    assert kind in kinds()
    assert made["description"]
    assert [n for n, field in made["properties"].items() if "description" not in field] == []


def test_no_unknown_kind_has_a_schema():
    with pytest.raises(PackError, match="did you mean 'bank'"):
        schema("bnk")


def test_the_short_forms_are_in_the_schema():
    notations = schema("language")["properties"]["notations"]
    label = notations["additionalProperties"]["additionalProperties"]
    assert {"type": "string"} in label["anyOf"]
