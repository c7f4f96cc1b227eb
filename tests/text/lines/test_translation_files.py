"""Files for translation: states, languages, forms and placeholders, and files that attack."""

import pytest
from script_samples import LINES, SEEDS

from lipsync_lang import LipsyncError
from lipsync_lang.schedules import timing_file
from lipsync_lang.text.lines import read_lines
from lipsync_lang.text.lines.cleaning import Cleaning
from lipsync_lang.text.lines.entries import MAX_ENTRY_DEPTH

GERMAN, ENGLISH = ("german", "German", "de"), ("english", "English", "en")


@pytest.mark.parametrize("seed", LINES)
def test_each_kind_is_read_with_its_places_names_and_speakers(seed):
    lines = read_lines(SEEDS / seed, remark=lambda _: None)
    found = [(int(one.place.rpartition(":")[2]), one.name, one.speaker, one.text) for one in lines]
    assert found == LINES[seed]


UNIT = '<trans-unit id="{0}"><source>Go {0}.</source>{1}</trans-unit>'


def xliff(*targets):
    units = "".join(UNIT.format(at, target) for at, target in enumerate(targets))
    head = '<xliff version="1.2"><file source-language="en-US" target-language="de-DE"><body>'
    return f"{head}{units}</body></file></xliff>"


def test_a_file_without_translations_gives_its_originals(texts_read):
    remarks = []
    whole = xliff("<target>Geh.</target>", "", '<target state="new">Go 2.</target>')
    assert texts_read("a.xlf", whole, remark=remarks.append) == [("0", "Geh.")]
    assert "left out 2 empty or untranslated entries" in remarks[0]
    assert texts_read("a.xlf", xliff("", "")) == [("0", "Go 0."), ("1", "Go 1.")]


def test_the_language_chooses_the_side_and_the_file(texts_read):
    whole = xliff("<target>Geh.</target>", "")
    assert texts_read("a.xlf", whole, names=ENGLISH) == [("0", "Go 0."), ("1", "Go 1.")]
    other = xliff("<target>Va.</target>").replace("de-DE", "fr").partition("<file")[2]
    both = whole.replace("</xliff>", "") + "<file" + other
    assert texts_read("a.xlf", both, names=GERMAN) == [("0", "Geh.")]
    assert texts_read("a.xlf", both, names=("french", "French", "fr")) == [("0", "Va.")]


def test_languages_of_one_file_in_json(texts_read):
    whole = {"en": {"a": {"b": "Hello."}}, "de": {"a": {"b": "Hallo."}}}
    assert texts_read("a.json", whole, names=GERMAN) == [("a.b", "Hallo.")]
    catalogue = (SEEDS / "xcstrings" / "1.xcstrings").read_text("utf-8")
    german = [("Hello", "Hallo"), ("maps %lld.one", "Karte"), ("maps %lld.other", "Karten")]
    assert texts_read("a.xcstrings", catalogue, names=GERMAN) == german
    assert texts_read("a.xcstrings", catalogue, names=ENGLISH)[0] == ("Hello", "Hello")
    assert texts_read("a.xcstrings", catalogue, names=("french", "French", "fr")) == []


MAPS = "{n, plural, =0 {No map} one {# {kind, select, old {old map} other {map}}} other {# maps}}"


def test_each_form_of_a_message_is_a_line(texts_read):
    found = texts_read("a.arb", {"maps": MAPS})
    assert found == [
        ("maps-0", "No map"),
        ("maps-one-old", "old map"),
        ("maps-one-other", "map"),
        ("maps-other", "maps"),
    ]
    known = Cleaning({"n": "2", "kind": "old"})
    assert texts_read("a.arb", {"maps": MAPS}, cleaning=known) == [("maps", "2 maps")]
    many = " ".join(f"{{a{at}, select, x {{X}} other {{Y}}}}" for at in range(12))
    assert texts_read("a.arb", {"many": many}) == [("many", " ".join("Y" * 12))]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.json", '{"a": "Hello, {{who}}."}'),
        ("a.xlf", xliff('<target>Hello, <x id="who"/>.</target>').replace('id="0"', 'id="a"')),
    ],
)
def test_placeholders_have_the_values_of_the_project(texts_read, name, text):
    values = Cleaning({"who": "Bo", "%@": "Bo"})
    assert [text for _, text in texts_read(name, text, cleaning=values)] == ["Hello, Bo."]
    assert [text for _, text in texts_read(name, text)] == ["Hello,."]


BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>'
EXTERNAL = '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
DEEP = MAX_ENTRY_DEPTH * 4


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.xlf", f"<?xml version='1.0'?>\n{BOMB}<xliff>&b;</xliff>", ":2: has a DOCTYPE with def"),
        ("a.xlf", f"{EXTERNAL}<xliff>&a;</xliff>", ":1: has a DOCTYPE with definitions"),
        ("a.xlf", '<!DOCTYPE x SYSTEM "x.dtd"><xliff>&a;</xliff>', ":1: has the entity '&a;'"),
        ("a.resx", f"{EXTERNAL}<root/>", ":1: has a DOCTYPE with definitions"),
        ("a.xlf", "<x>" * DEEP, f":1: is nested deeper than {MAX_ENTRY_DEPTH * 2} elements"),
        ("a.xlf", xliff("<target>" + "<g>" * DEEP), ":1: is nested deeper"),
        ("a.xlf", "<xliff>\n<file></xliff>", ":2: not XML: mismatched tag"),
        ("a.xml", "<manifest/>", ":1: begins with no <resources>"),
        ("a.arb", '{"a":' * DEEP + '"x"' + "}" * DEEP, f"deeper than {MAX_ENTRY_DEPTH} levels"),
        ("a.json", '{"a":' * DEEP + '"x"' + "}" * DEEP, f"deeper than {MAX_ENTRY_DEPTH} levels"),
        ("a.json", "[" * 100_000, "nested too deep"),
        ("a.json", '{"a": "x",\n"b": }', ":2:6: not JSON"),
    ],
)
def test_attacks_and_damage_are_refused_by_a_limit_or_at_a_place(texts_read, name, text, message):
    with pytest.raises(LipsyncError) as refused:
        texts_read(name, text)
    assert message in str(refused.value)


def test_a_file_above_the_limit_is_refused(texts_read, monkeypatch):
    monkeypatch.setattr(timing_file, "MAX_TIMINGS_BYTES", 2**20)
    with pytest.raises(LipsyncError, match="is larger than 1 MB"):
        texts_read("a.xlf", xliff("<target>x</target>") + " " * 2**20)
