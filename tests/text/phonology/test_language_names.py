"""Names of languages: tags, aliases, endonyms and the names in stores and engines."""

from pathlib import Path

import pytest

from lipsync_lang.base.errors import LipsyncError, PackError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.finding import answers_of, named_as
from lipsync_lang.packs.library import Library
from lipsync_lang.text.lines.columns import language_column, stated_column, text_column
from lipsync_lang.text.lines.line_readers import LineFile
from lipsync_lang.text.phonology.language_names import folded_language

LIBRARY = Library(project=None)
PACKS = sorted(found.name for found in LIBRARY.names("language"))
assert PACKS, "a sweep over nothing passes"

STORE = {
    "arabic": "العربية",
    "bulgarian": "български език",
    "schinese": "简体中文",
    "tchinese": "繁體中文",
    "czech": "čeština",
    "danish": "Dansk",
    "dutch": "Nederlands",
    "english": "English",
    "finnish": "Suomi",
    "french": "Français",
    "german": "Deutsch",
    "greek": "Ελληνικά",
    "hungarian": "Magyar",
    "indonesian": "Bahasa Indonesia",
    "italian": "Italiano",
    "japanese": "日本語",
    "koreana": "한국어",
    "norwegian": "Norsk",
    "polish": "Polski",
    "portuguese": "Português",
    "brazilian": "Português-Brasil",
    "romanian": "Română",
    "russian": "Русский",
    "spanish": "Español-España",
    "latam": "Español-Latinoamérica",
    "swedish": "Svenska",
    "thai": "ไทย",
    "turkish": "Türkçe",
    "ukrainian": "Українська",
    "vietnamese": "Tiếng Việt",
}
"""Steam's API language codes with their native names."""

CULTURES = (
    "zh-Hans",
    "zh-Hant-TW",
    "pt-BR",
    "pt-PT",
    "es-ES",
    "es-419",
    "en-GB",
    "de_AT",
    "sr-Cyrl",
)


def owner(name):
    return LIBRARY.language(name).path


@pytest.mark.parametrize("name", PACKS)
def test_a_look_up_knows_exactly_the_stated_names(name):
    pack = LIBRARY.language(name)
    stated = [pack.model.tag, *pack.model.aliases]
    assert answers_of(pack.path) == list(dict.fromkeys(map(folded_language, stated)))


def test_no_name_belongs_to_two_packs():
    own = {}
    for name in PACKS:
        for answer in {name, *answers_of(LIBRARY.find("language", name))}:
            assert own.setdefault(answer, name) == name, answer


@pytest.mark.parametrize(("code", "native"), STORE.items())
def test_codes_and_native_names_of_a_store_find_one_pack(code, native):
    assert (
        owner(code) == owner(native) == owner(native.upper()) == owner(native.replace("-", " - "))
    )


@pytest.mark.parametrize("code", CULTURES)
def test_culture_codes_of_engines_find_a_pack(code):
    assert owner(code)


def test_accents_are_not_needed():
    assert owner("francais") == owner("Français") == owner("franc\u0327ais")


@pytest.mark.parametrize("name", ["my language", "no idea", "de facto", "zh/Hans", "en:US"])
def test_words_that_begin_like_a_tag_find_nothing(name):
    with pytest.raises(PackError):
        LIBRARY.find("language", name)


@pytest.mark.parametrize(
    ("language", "heads"),
    [
        (
            "mandarin",
            ["Chinese (Simplified)", "简体中文", "schinese", "Chinese (Simplified)(zh-Hans)"],
        ),
        ("german", ["Deutsch", "DEUTSCH (DE)", "text_deutsch", "German(de)"]),
        ("portuguese-br", ["brazilian", "Português (Brasil)", "Portuguese (Brazil)(pt-BR)"]),
        ("spanish", ["Español", "espanol", "Español - España", "es-ES"]),
    ],
)
def test_columns_are_found_by_every_name(language, heads):
    names = named_as(LIBRARY.find("language", language))
    for head in heads:
        assert language_column(["id", "English", "Notes", head], names) == 3, head


def test_the_first_alias_wins_over_a_later_one():
    names = named_as(LIBRARY.find("language", "mandarin"))
    assert language_column(["id", "tchinese", "schinese"], names) == 2
    head = ["id", "Chinese (Traditional)", "Chinese (Simplified)"]
    assert language_column(head, names) == 2


NAMES = ["indonesian", "id"]
"""A language whose tag is a usual name of another column."""


@pytest.mark.parametrize(
    ("head", "at"),
    [
        (["id", "text"], -1),
        (["key", "id"], 1),
        (["id", "Indonesian"], 1),
        (["key", "id-ID"], 1),
        (["key", "id-ID", "id-SG"], -1),
        (["key", "id-ABCD"], -1),
    ],
)
def test_a_column_of_ids_is_no_text_unless_another_has_the_ids(head, at):
    assert language_column(head, NAMES) == at


@pytest.mark.parametrize(
    ("head", "at"),
    [
        (["id", "x"], 1),
        (["id", "Speaker", "x"], 2),
        (["id", "x", "y"], -1),
        (["x", "line", "TEXT"], 2),
        (["Text", "text"], 0),
    ],
)
def test_the_likeliest_text_is_a_known_name_or_the_only_column(head, at):
    assert text_column(head) == at


@pytest.mark.parametrize(
    ("asked", "at"),
    [
        ("b", 1),
        ("B", 0),
        ("c", 2),
        ("1", 0),
        ("4", 3),
        ("Bahasa", 3),
        ("bahása", 3),
        ("indonesian", 3),
    ],
)
def test_a_column_is_stated_by_its_name_its_number_or_its_language(asked, at):
    source = LineFile(Path("a.csv"), print, names=("indonesian", "bahasa"))
    assert stated_column(source, ["B", "b", "C", "Bahasa (Indonesia)"], asked) == at


@pytest.mark.parametrize("asked", ["0", "4", "-1", "klingon"])
def test_a_column_that_is_not_there_is_told_with_those_that_are(asked):
    source = LineFile(Path("a.csv"), print, names=("indonesian",))
    with pytest.raises(LipsyncError, match=rf"^a.csv:1: has no column '{asked}'.* x, y, z$"):
        stated_column(source, ["x", "y", "z"], asked)
    with pytest.raises(LipsyncError, match="did you mean 'dialogue_de'"):
        stated_column(source, ["dialogue_de", "y"], "dialog_de")


PACK = """kind: language
format: 1
name: {name}
tag: art-x-{name}
aliases:{aliases}
notations: {{ipa: {{a: aa}}}}
"""


@pytest.mark.parametrize(
    ("aliases", "found"),
    [
        (" [Örkisch, 'zwei Wörter']", ["orkisch", "zwei-worter"]),
        ('  # names\n  - Örkisch  # its own\n  - "zwei Wörter"\n', ["orkisch", "zwei-worter"]),
        (" [one,\n  # not two\n  three]", ["one", "three"]),
        ("\n- a-b\n- c", ["a-b", "c"]),
    ],
)
def test_aliases_may_be_written_in_every_form_of_a_list(aliases, found, tmp_path):
    path = tmp_path / "languages/toy.yaml"
    path.parent.mkdir()
    path.write_text(PACK.format(name="toy", aliases=aliases), "utf-8")
    assert answers_of(path) == ["art-x-toy", *found]
    library = Library([tmp_path], project=None)
    assert list(map(folded_language, library.language("toy").model.aliases)) == found
    assert library.language(found[-1]).model.name == "toy"


@pytest.mark.parametrize("alias", ["a,b", "a/b", "espeak:xx", " a", "a ", "a  b", "-a", "x" * 61])
def test_an_alias_that_could_not_be_asked_for_is_a_fault(alias, tmp_path):
    path = tmp_path / "languages/toy.yaml"
    path.parent.mkdir()
    path.write_text(PACK.format(name="toy", aliases=f" ['{alias}']"), "utf-8")
    faults = validate(Library([tmp_path], project=None), paths=[path])
    assert any("aliases" in str(fault) or "alias" in str(fault) for fault in faults), faults


def test_an_alias_of_two_packs_is_told_at_the_second(tmp_path):
    folder = tmp_path / "languages"
    folder.mkdir()
    for name, alias in (("one", "Öne"), ("two", "öne")):
        text = PACK.format(name=name, aliases=f" [{alias}]")
        (folder / f"{name}.yaml").write_text(text, "utf-8")
    faults = [f for f in validate(Library([tmp_path], project=None)) if f.code == "W305"]
    assert [(f.file.rpartition("/")[2], f.line) for f in faults] == [("two.yaml", 5)]
