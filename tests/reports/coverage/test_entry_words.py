"""Words of a script that deserve an entry: foreign letters, names, and two readings."""

from shipped import LIBRARY

from lipsync_lang.reports.coverage.scripts import EntryWords, letters_of
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import Line


def found(language, *texts, letters=None):
    words = EntryWords(
        Speaker.of(language),
        letters_of(LIBRARY.language(language).model) if letters is None else letters,
    )
    words.add(Line(text, f"a.txt:{n}") for n, text in enumerate(texts, 1))
    return [(one.what, one.count, one.why) for one in words.tallies()]


def test_foreign_letters_and_names_deserve_an_entry():
    told = found("polish", "Widzę Tali, a pan Xan milczy.", "Hej, to Tali!", "Mówi Pan. 3PO, TALI")
    assert told == [("Tali", 2, "name"), ("Xan", 1, "letters")]


def test_capitals_make_no_name_in_a_script_with_many():
    line = "Der Mann sieht den Hund im Haus mit dem Dach."
    assert found("german", *[line] * 9) == []


def test_words_with_an_entry_are_not_named(tmp_path, monkeypatch):
    (tmp_path / "languages").mkdir()
    pack = "kind: language\nformat: 1\nname: polish\ntag: pl\nextends: polish\nwords: {Xan: ksan}\n"
    (tmp_path / "languages/polish.yaml").write_text(pack, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert found("polish", "Widzę Xana, Xanem i Tali") == [("Tali", 1, "name")]


def test_a_language_without_texts_names_no_words():
    assert found("polish", "Widzę Tali", letters=()) == []


def test_two_engines_that_differ_are_told(monkeypatch):
    import lipsync_lang.reports.coverage.scripts as module

    monkeypatch.setattr(module.EntryWords, "_differing", lambda _: frozenset({"tak"}))
    assert found("polish", "tak, tak, nie") == [("tak", 2, "engines")]
