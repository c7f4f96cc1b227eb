"""Usual mappings: a label without a mapping has the usual one, and the old form means the same."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.packs.extending import with_usual
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Language
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.splicing import spliced
from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import YamlSource

HEAD = {"kind": "language", "format": 1, "name": "toy", "tag": "qaa"}


def full(sounds):
    """Return the mapping of a label as a file states it in full."""
    shares = {} if sounds.shares is None else {"shares": sounds.shares}
    return {"to": sounds.to, **shares}


def tables(tmp_path, notations):
    model = Language.model_validate({**HEAD, "notations": notations})
    source = YamlSource(tmp_path / "toy.yaml", {**HEAD, "notations": notations})
    return with_usual(Pack(model, (source,)), LIBRARY.common)[0].model.notations


@given(data=st.data())
def test_the_short_form_and_the_full_form_load_to_the_same_tables(tmp_path_factory, data):
    folder = tmp_path_factory.getbasetemp()
    usual = LIBRARY.common().model.usual
    notation = data.draw(st.sampled_from(sorted(usual)))
    labels = data.draw(st.lists(st.sampled_from(sorted(usual[notation])), unique=True))
    own = data.draw(st.sets(st.sampled_from(labels))) if labels else set()
    stated = {label: full(usual[notation][label]) for label in labels}
    short = {label: one if label in own else None for label, one in stated.items()}
    made = tables(folder, {notation: short})
    assert made == tables(folder, {notation: stated})
    assert list(made[notation]) == labels


@pytest.mark.parametrize("name", LANGUAGES)
def test_no_pack_restates_a_usual_mapping(name):
    pack, usual = LIBRARY.language(name), LIBRARY.common().model.usual
    stated = pack.source.data.get("notations") or {}
    own = Language.model_validate(pack.source.data).notations
    restated = [
        (notation, label)
        for notation, table in usual.items()
        for label, value in (stated.get(notation) or {}).items()
        if value is not None and own[notation][label] == table.get(label)
    ]
    assert not restated, "list the label alone"


def put(tmp_path, table):
    path = tmp_path / "languages" / "toy.yaml"
    path.parent.mkdir()
    head = "".join(f"{key}: {value}\n" for key, value in HEAD.items())
    path.write_text(f"{head}notations:\n  ipa: {{\n{table}  }}\n", "utf-8")
    return path


def test_an_unknown_label_without_a_mapping_is_a_fault_at_its_place(tmp_path):
    put(tmp_path, "    a, tʃx,\n    i: iy, ʄʄʄ,\n")
    with pytest.raises(PackFaults) as caught:
        Library(project=tmp_path).language("toy")
    found = [(one.line, one.column, one.code) for one in caught.value.faults]
    assert found == [(7, 8, "P238"), (8, 12, "P238")]
    assert caught.value.faults[0].what == "'tʃx' has no usual mapping in 'ipa'"
    assert "did you mean 'tʃ'" in caught.value.faults[0].hint


def test_a_label_that_is_listed_twice_is_a_fault(tmp_path):
    put(tmp_path, "    a, i,\n    a,\n")
    with pytest.raises(PackFaults, match=re.escape("toy.yaml:8:5")):
        Library(project=tmp_path).language("toy")


@pytest.mark.parametrize(
    ("label", "line"), [("a", "    a: ih, e,   # two"), ("e", "    a, e: ih,   # two")]
)
def test_a_change_of_a_listed_sound_adds_a_deviation(tmp_path, label, line):
    path = put(tmp_path, "    a, e,   # two\n    i, u: uh,\n")
    content = path.read_bytes()
    made = spliced(read_yaml(path), content, [(("notations", "ipa", label), "ih")])
    assert made.decode() == content.decode().replace("    a, e,   # two", line)
    path.write_bytes(made)
    model = Library(project=tmp_path).language("toy").model
    assert model.notations["ipa"][label].to == ("ih",)
    assert list(model.notations["ipa"]) == ["a", "e", "i", "u"]
