"""Words that a pack reads its own way, in IPA or respelled, with the endings of its language."""

from dataclasses import asdict
from json import dumps, loads

import pytest
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.language_tables import forms_of
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.g2p.own_words import OwnWords, by_spelling, ipa_labels
from lipsync_lang.text.phonology.g2p.spoken_forms import OwnWord, SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import plain, read_words
from lipsync_lang.text.phonology.g2p.utterances import Utterances

FORMS = SpokenForms(
    interjections={"mm": OwnWord(("m",))},
    abbreviations={"Bo": "bob"},
    words={"Joe": OwnWord((), "djo"), "Anna": OwnWord(tuple("ana")),
           "Mia": OwnWord(tuple("mia"), "me a"), "xan": OwnWord((), "zan"),
           "Bo": OwnWord((), "bou"), "iPod": OwnWord(tuple("aipod"))},
    endings={"": {"em": ("e", "m"), "go": ("g", "o")}, "a": {"i": ("i",), "o": ("o",)}},
)  # fmt: skip


def spell(texts):
    return [read_words(text, lambda word: SpokenWord(word, tuple(word.lower()))) for text in texts]


def read(text):
    (words,) = Utterances(FORMS, (), "aeiou".__contains__).read([text], spell)
    return " ".join(f"{w.text}:{''.join(w.labels)}" if w.labels else w.text for w in words)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("no Joe, mm", "no:no Joe:djo , mm:m"),
        ("JOE joe Joe'go", "JOE:djo joe:joe Joe'go:djogo"),
        ("Joeem Joe-go Joeks", "Joeem:djoem Joe-go:djogo Joeks:joeks"),
        ("joeem xanem", "joeem:joeem xanem:zanem"),  # a name, and a word
        ("Anna Anni Anno, Annem", "Anna:ana Anni:ani Anno:ano , Annem:annem"),
        ("so Mia Mii", "so:so Mia:mia Mii:mii"),  # `me a` loses its last letter, not `a` alone
        ("big-Joe's", "big-Joe's:big-joe's"),
        ("big-Joe", "big-Joe:big-djo"),
        ("an iPod, iPodem", "an:an iPod:aipod , iPodem:aipodem"),  # its capital is not the first
        ("noJoe UJoe McJoe", "noJoe:nodjo UJoe:udjo McJoe:mcjoe"),
        ("Bo", "Bo:bou"),  # a project's word goes before an abbreviation
    ],
)
def test_words_are_read_by_their_entry_and_its_endings(text, said):
    assert read(text) == said


def test_a_voice_says_the_respelling():
    words = {"Mia": OwnWord(tuple("mia"), "mea")}
    forms = SpokenForms(words=words, endings=FORMS.endings)
    (said,) = Utterances(forms, (), "aeiou".__contains__).read(["Mio"], spell)
    assert said == (SpokenWord("Mio", tuple("mio"), "meo"),)


def test_prefixes_join_respelled_words_of_three_letters():
    words = {"kot": OwnWord((), "kott"), "by": OwnWord((), "bi"), "xyz": OwnWord(("k",))}
    own = OwnWords(SpokenForms(words=words, beginnings={"na": "na-"}))
    assert own.respelled("nakot naby naxyz kot") == "na-kott naby naxyz kott"


def test_ipa_is_cut_into_labels_of_the_notation():
    known = by_spelling(("tʃ", "ɛ", "p", "a", "ɡ"))
    assert ipa_labels("ˈtʃɛ pa", known) == ("tʃ", "ɛ", "p", "a")
    assert ipa_labels("ɡ ga", known) == ("ɡ", "ɡ", "a")


def test_a_tone_goes_with_the_whole_label_before_it():
    known = by_spelling(("x", "ɑ", "ɑʊ", "ʊ", "n"))
    assert ipa_labels("xɑʊ˨˩˦nɑ˥", known) == ("x", "ɑʊ˨˩˦", "n", "ɑ˥")


def test_forms_survive_the_cache():
    kept = SpokenForms.from_plain(loads(dumps(asdict(FORMS))))
    assert kept.words == FORMS.words
    assert kept.endings["a"]["i"] == ["i"]


POLISH = """\
kind: language
format: 1
name: polish
tag: pl
extends: polish
words:
  Shepard: szepard
  Garrus: {ipa: ɡarus, say: garus}
  Sheila: {ipa: ʂ ɛ j l a}
  Los Angeles: los andżeles
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages/polish.yaml").write_text(POLISH, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("Shepard", "sh eh bmp aa d d"),
        ("Sheparda", "sh eh bmp aa d d aa"),
        ("Shepardowi", "sh eh bmp aa d d ao f iy"),
        ("Shepardem", "sh eh bmp aa d d eh bmp"),
        ("Shepardzie", "sh eh bmp aa d d s eh"),
        ("Garrusa", "kg aa d w s aa"),
        ("Garrusowi", "kg aa d w s ao f iy"),
        ("Garrusem", "kg aa d w s eh bmp"),
        ("Garrusie", "kg aa d w s eh"),
        ("Sheila", "sh eh iy l aa"),
        ("Sheilę", "sh eh iy l eh"),
        ("Sheilą", "sh eh iy l ao w"),
        ("Los Angeles", "l ao s aa n ch eh l eh s"),
    ],
)
@pytest.mark.usefixtures("project")
def test_a_name_in_a_project_takes_its_cases(written, said):
    (found,) = Speaker.of("polish").transcribe([written])
    assert " ".join(found.phonemes) == said


@pytest.mark.usefixtures("project")
def test_a_word_in_ipa_needs_no_voice_and_no_time_of_its_own():
    schedule = Speaker.of("polish").speak("Widzę Garrusa", engine="none")
    assert [word.text for word in schedule.words] == ["Widzę", "Garrusa"]
    assert "".join(schedule.labels).endswith("ɡarusa")


@pytest.mark.parametrize(
    ("entry", "code", "what"),
    [
        ("Shepard: {ipa: ʂœ}", "P218", "'œ' is not in the notation 'ipa'"),
        ("Shepard: {ipa: a, phonemes: [l]}", "P115", "a word needs"),
        ("Shepard: {}", "P115", "a word needs"),
        ("Shepard: [zz]", "P202", "unknown phoneme 'zz'"),
        ("New York: {ipa: nu}", "P115", "'New York' has IPA"),
    ],
)
def test_a_wrong_entry_is_located(project, entry, code, what):
    path = project / "languages/polish.yaml"
    path.write_text(POLISH.replace("Shepard: szepard", entry), encoding="utf-8")
    found = validate(Library(), [path])
    assert [(fault.code, fault.line) for fault in found] == [(code, 7)]
    assert what in found[0].what


def test_every_ending_has_labels_of_its_language():
    stated = [
        (found.name, last, ending, sounds)
        for found in LIBRARY.names("language")
        for last, endings in getattr(LIBRARY.language(found.name).model.text, "endings", {}).items()
        for ending, sounds in endings.items()
    ]
    assert len({name for name, *_ in stated}) > 10
    assert {name for name, *_, sounds in stated if not sounds} == {"french"}  # a silent plural


def test_words_in_a_project_file_are_sent_to_a_pack(project):
    path = project / "lipsync.yaml"
    path.write_text("kind: project\nformat: 1\nwords: {polish: {a: b}}\n", encoding="utf-8")
    (fault,) = validate(Library(), [path])
    assert (fault.code, fault.line) == ("P101", 3)
    assert "files of the kind language or character" in fault.hint


@pytest.mark.parametrize("name", LANGUAGES)
def test_names_of_another_language_are_read_in_labels_of_this_one(name):
    """A sound may be missing, as the j of "John" in Samoan; most are there."""
    common, language = LIBRARY.common().model, LIBRARY.language(name).model
    words = forms_of(language, common, language.g2p_notation).words
    for tags, names in common.text.names.items():
        own = language.tag.partition("-")[0] in tags.split() or language.g2p_notation != "ipa"
        stated = {*map(plain, language.words)}
        for word, ipa in ((w, i) for w, i in names.items() if plain(w) not in stated):
            labels = words[word].labels if word in words else ()
            assert not (own and labels)
            assert set(labels) <= set(language.notations.get("ipa", ())) | set(ipa.split())
            assert own or not labels or len(labels) >= len(ipa.split()) - 1


def test_a_shared_name_with_a_capital_needs_one_and_that_of_a_pack_does_not():
    read = Speaker.of("catalan").transcribe_many(["Gates", "gates"])
    assert [found.phonemes[1] for found in read] == ["eh", "aa"]
    small, capital = Speaker.of("german").transcribe_many(["party", "Party"])
    assert small.phonemes == capital.phonemes


@pytest.mark.parametrize(
    ("name", "word", "vowel"),
    [
        ("hausa", "game", "aa"),
        ("romanian", "game", "aa"),
        ("romanian", "chef", "eh"),
        ("dutch", "loot", "oc"),
        ("polish", "chaty", "aa"),
        ("czech", "chatu", "aa"),
        ("polish", "Janem", "aa"),
        ("croatian", "Luke", "w"),
        ("croatian", "Jedi", "eh"),
        ("finnish", "Monet", "oc"),
        ("norwegian", "hater", "aa"),
    ],
)
def test_a_shared_loanword_leaves_a_word_of_the_language_alone(name, word, vowel):
    (found,) = Speaker.of(name).transcribe_many([word])
    assert found.phonemes[1] == vowel


def test_a_pack_reads_a_shared_name_its_own_way():
    french = LIBRARY.language("french").model
    assert "YouTube" not in forms_of(french, LIBRARY.common().model, "ipa").words
