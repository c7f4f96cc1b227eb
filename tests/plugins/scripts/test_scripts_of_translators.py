"""Files for translation with a logic of their own: terms, languages, and files that attack."""

import pytest

from lipsync_lang import LipsyncError
from lipsync_lang.text.lines import read_lines
from lipsync_lang.text.lines.cleaning import Cleaning
from lipsync_lang.text.lines.entries import MAX_ENTRY_DEPTH


def test_the_language_chooses_the_tree(texts_read):
    names = ("german", "German", "de")
    assert texts_read("de.yml", "en:\n  a: Hello.\nde:\n  a: Hallo.\n", names=names) == [
        ("a", "Hallo.")
    ]


TERMS = """-map = { $case ->
   *[nominative] the map
    [genitive] of the map
}
    .gender = neuter
a = See { -map }, the end { -map(case: "genitive") }.
    { -none }
b =
    { $n ->
        [one] { -map }
       *[other] { $n ->
            [two] two maps
           *[other] maps
        }
    }
"""


def test_terms_and_selectors_of_fluent(texts_read):
    assert texts_read("a.ftl", TERMS) == [
        ("a", "See the map, the end of the map."),
        ("b-one", "the map"),
        ("b-other-two", "two maps"),
        ("b-other-other", "maps"),
    ]
    known = Cleaning({"n": "1"})
    assert texts_read("a.ftl", TERMS, cleaning=known)[1:] == [("b", "the map")]


def test_a_comment_of_fluent_names_the_speaker_of_its_message_and_attributes(tmp_path):
    rows = "# Speaker: Anna\na = Hello.\n  .tip = Press.\n# Speaker: Bob\nb = Goodbye.\n"
    path = tmp_path / "a.ftl"
    path.write_text(rows, "utf-8")
    told = [(line.name, line.speaker) for line in read_lines(path)]
    assert told == [("a", "Anna"), ("a.tip", "Anna"), ("b", "Bob")]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.ftl", "a = Hello, { $who }.\n"),
        ("a.twee", ":: a\nHello, $who.\n"),
        ("a.strings", '"a" = "Hello, %@.";'),
    ],
)
def test_placeholders_have_the_values_of_the_project(texts_read, name, text):
    values = Cleaning({"who": "Bo", "%@": "Bo"})
    assert [text for _, text in texts_read(name, text, cleaning=values)] == ["Hello, Bo."]
    assert [text for _, text in texts_read(name, text)] == ["Hello,."]


def test_names_of_rpg_maker_have_values(texts_read):
    page = [{"code": 101, "parameters": ["", 0, 0, 2, "Harold"]}]
    page += [
        {"code": 401, "parameters": ["\\c[5]Hello\\c[0], \\n[1]."]},
        {"code": 0, "parameters": []},
    ]
    whole = {"events": [None, {"id": 1, "pages": [{"list": page}]}]}
    values = Cleaning({"\\N[1]": "Bo"})
    assert texts_read("Map001.json", whole, cleaning=values) == [("Map001.1.0.0", "Hello, Bo.")]


EXTERNAL = '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
DEEP = MAX_ENTRY_DEPTH * 4


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.stringsdict", f"{EXTERNAL}<plist><string>&a;</string></plist>", ":1: not a property"),
        ("a.yml", "de: [" + "[" * DEEP + "x" + "]" * DEEP + "]", f"deeper than {MAX_ENTRY_DEPTH}"),
        ("a.yml", "de:\n  a: [", ":2: not YAML"),
        ("a.yml", "just a text", ":1: has no language"),
        ("a.ftl", "a = b\n\n= c\n", ":3: not Fluent: = c"),
        ("a.strings", '"a" = "b";\n\n"c" "d";\n', ':3: not a pair: "c" "d";'),
        ("a.stringsdict", "<plist><array/></plist>", ":1: has no keys"),
        ("a.stringsdict", "<plist></dict></plist>", ":1: not a property list"),
        ("a.stringsdict", "<plist><key>a</key></plist>", ":1: not a property list"),
    ],
)
def test_attacks_and_damage_are_refused_by_a_limit_or_at_a_place(texts_read, name, text, message):
    with pytest.raises(LipsyncError) as refused:
        texts_read(name, text)
    assert message in str(refused.value)


def test_aliases_within_aliases_are_counted(texts_read):
    rows = ["a: &a [x, x, x, x, x, x, x, x, x, x]"]
    rows += [
        f"{two}: &{two} [{', '.join([f'*{one}'] * 10)}]"
        for one, two in ("ab", "bc", "cd", "de", "ef")
    ]
    with pytest.raises(LipsyncError, match="more than 200,000 texts"):
        texts_read("a.yml", "\n".join(rows))
