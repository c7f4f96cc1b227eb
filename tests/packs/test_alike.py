"""Spellings of abbreviations that are read alike: those of one key, and those of shared lists."""

import pytest
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Language
from lipsync_lang.resolver.language_tables import forms_of

ALIKE = LIBRARY.common().model.text.alike


def read(tmp_path, abbreviations, name="toy", head="tag: qaa\n", lists=""):
    path = tmp_path / "languages" / f"{name}.yaml"
    path.parent.mkdir(exist_ok=True)
    rows = "".join(f"    {key}: {words}\n" for key, words in abbreviations.items())
    head = f"kind: language\nformat: 1\nname: {name}\n{head}"
    path.write_text(f"{head}text:\n{lists}  abbreviations:\n{rows}", "utf-8")
    return Library(project=tmp_path).language(name)


def test_spellings_of_one_key_have_its_words_and_its_place(tmp_path):
    pack = read(tmp_path, {"Nr.": "number", "a | b c | …d": "words"})
    assert pack.model.text.abbreviations == {
        "Nr.": "number", "a": "words", "b c": "words", "…d": "words",
    }  # fmt: skip
    places = {pack.where(("text", "abbreviations", one), key=True)[1:] for one in ("a", "b c")}
    assert places == {(8, 5)}


def test_a_language_that_states_the_first_of_a_list_has_the_others(tmp_path):
    first, second, *others = next(one for one in ALIKE if len(one) > 2)
    text = read(tmp_path, {f'"{first}"': "many", f'"{second}"': "one"}).model.text
    assert text.abbreviations == {first: "many", second: "one", **dict.fromkeys(others, "many")}


def test_a_language_that_states_another_of_a_list_has_that_one_alone(tmp_path):
    _, second, *_ = ALIKE[0]
    text = read(tmp_path, {f'"{second}"': "many"}).model.text
    assert text.abbreviations == {second: "many"}


def test_a_child_changes_the_others_of_its_parent_too(tmp_path):
    first, second, *_ = ALIKE[0]
    read(tmp_path, {f'"{first}"': "many"})
    child = read(tmp_path, {f'"{first}"': "few"}, "kid", "tag: qaa-x-kid\nextends: toy\n")
    assert child.model.text.abbreviations[second] == "few"


def test_a_list_tells_what_is_said_for_its_words(tmp_path):
    lists = '  lists: {unit: {km: miles, "m | mt": feet}, many: [some]}\n'
    rows = {'"# {unit}"': '"{1} {unit}"', '"{many} # {unit}"': '"{many} {1} {unit}"'}
    pack = read(tmp_path, rows, lists=lists)
    assert forms_of(pack.model, LIBRARY.common().model, "ipa").abbreviations == {
        "# km": "{1} miles", "# m": "{1} feet", "# mt": "{1} feet",
        "some # km": "some {1} miles", "some # m": "some {1} feet", "some # mt": "some {1} feet",
    }  # fmt: skip


@pytest.mark.parametrize("name", LANGUAGES)
def test_no_pack_restates_a_shared_spelling(name):
    text = Language.model_validate(LIBRARY.language(name).source.data).text
    stated = text.abbreviations if text else {}
    restated = [
        other
        for first, *others in ALIKE
        for other in others
        if first in stated and stated.get(other) == stated[first]
    ]
    assert not restated, "common.yaml lists it"


def test_each_list_serves_a_built_in_language():
    texts = [LIBRARY.language(name).model.text for name in LANGUAGES]
    stated = {spelling for text in texts if text for spelling in text.abbreviations}
    assert {first for first, *_ in ALIKE} <= stated
