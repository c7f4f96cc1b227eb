"""Running text as it is written, beside the same text in words: both are read alike."""

import csv
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from re import fullmatch, search
from unicodedata import normalize

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import swept
from shipped import LIBRARY

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.models.text_models import LanguageText
from lipsync_lang.resolver.language_tables import abbreviations_of
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.g2p.abbreviation_keys import Expansions
from lipsync_lang.text.phonology.g2p.censored import uncensored
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import respelled
from lipsync_lang.text.phonology.g2p.utterances import Utterances, part_text

with (Path(__file__).parent / "running_lines.tsv").open(encoding="utf-8", newline="") as file:
    ROWS = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
LINES = defaultdict(list)
for row in ROWS:
    LINES[row["language"]].append((row["written"], row["said"]))
assert len(ROWS) > 100
INFLECTING = sorted(
    {one.name for one in LIBRARY.names("language") if b"\n      endings:" in one.path.read_bytes()}
)
OTHER_READINGS = {
    "slt": "salut",
    "Kap.": "Kapitel",
    "Đ/c": "địa chỉ",
    "Πλ.": "Πλατεία|Πλατεία",
    "G.": "Ginoo",
}
"""Spellings of ranks that mean something else without a name, too."""
CURSING = sorted(
    {one.name for one in LIBRARY.names("language") if b"\n  curses:" in one.path.read_bytes()}
)


COUNTING = sorted(
    {one.name for one in LIBRARY.names("language") if b"{decimal_unit}" in one.path.read_bytes()}
)
assert COUNTING


def bare_letters(words):
    return "".join(filter(str.isalpha, words)).casefold()


def sounds(speaker, texts):
    """Return the phonemes of texts; pauses and the seams of words make no difference here."""
    read = list(speaker.transcribe_many(texts))
    if isinstance(read[0], SpeechError):
        pytest.skip(str(read[0]))
    assert not any(one.unread for one in read)
    return ["".join(name for name in one.phonemes if name != "_") for one in read]


@pytest.mark.parametrize("language", swept(LINES, quick=[*LINES][::4]))
def test_written_forms_are_read_as_their_words(language):
    written, said = zip(*LINES[language], strict=True)
    speaker = Speaker.of(language)
    pairs = zip(written, sounds(speaker, written), sounds(speaker, said), strict=True)
    assert [pair for pair in pairs if pair[1] != pair[2]] == []


@pytest.mark.parametrize("signs", ["*", "**", "@#", "#$%", "$@!#"])
@pytest.mark.parametrize("word", ["blimming", "lunkers", "grizzled", "mörder"])
def test_a_vowel_behind_signs_is_no_name_of_the_signs(word, signs):
    forms = Speaker.of("english").manner.forms
    for at in (n for n, one in enumerate(word) if one in "aeiouö"):
        written = word[:at] + signs + word[at + 1 :]
        (read,) = uncensored(f"You {written}!", forms)
        assert read == (4, 4 + len(written), f"{word[:at]}u{word[at + 1 :]}")


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("cr*p", "crap"),
        ("sh**ty", "shitty"),
        ("BULLSH*T", "BULLSHIT"),
        ("f***ing", "fucking"),
        ("bullsh!t", "bullshit"),
        ("p*ss", "piss"),
    ],
)
def test_a_censored_curse_has_its_own_letters(written, said):
    forms = Speaker.of("english").manner.forms
    assert [*uncensored(f"That {written}!", forms)] == [(5, 5 + len(written), said)]


def test_no_curse_is_looked_for_in_endless_letters():
    # its time would grow with the square of their number
    forms = Speaker.of("english").manner.forms
    ((_, _, near),) = uncensored(f"{'b' * 30}sh*t", forms)
    ((_, _, far),) = uncensored(f"{'b' * 31}sh*t", forms)
    assert (near[-4:], far[-4:]) == ("shit", "shut")


@pytest.mark.parametrize("name", swept(CURSING, quick=CURSING[::6]))
def test_every_curse_of_a_pack_is_read_behind_a_sign(name):
    forms = Speaker.of(name).manner.forms
    for curse in forms.curses:
        assert curse == curse.lower()
        for at in range(1, len(curse) - 1):
            written = f"{curse[:at]}*{curse[at + 1 :]}"
            ((_, _, read),) = uncensored(written, forms)
            # an earlier curse of the list may fit as well, but the letters in sight stay
            assert fullmatch(written.replace("*", "[^*]"), read)


def test_a_row_of_asterisks_is_about_as_long_as_the_curse():
    forms = replace(Speaker.of("english").manner.forms, curses=("blimming", "blast"))
    read = {"b***g": "blimming", "bl***ming": "blimming", "bl**t": "blast", "b***": "blast"}
    for written, said in read.items():
        assert [*uncensored(written, forms)] == [(0, len(written), said)]
    ((_, _, far),) = uncensored("b***********", forms)
    assert far not in forms.curses


@pytest.mark.parametrize("name", INFLECTING)
def test_ranks_keep_their_words_in_each_case(name):
    text = LIBRARY.language(name).model.text
    key, rank = next((k, w) for k, w in text.ranks.items() if k.endswith(".") and " " not in w)
    for case, one in text.rank_cases.items():
        changed = [w for w in " ".join(text.ranks.values()).split() if w.endswith((*one.endings,))]
        assert changed or not one.endings, f"{case} changes no rank"
    # a name that shows nothing, where a text begins
    forms = Speaker.of(name).manner.forms
    assert [found.read for found in Expansions(forms).find(f"{key} Xxx")] == [rank]


@pytest.mark.parametrize("name", INFLECTING)
def test_a_rank_needs_no_name_before_a_mark(name):
    text = LIBRARY.language(name).model.text
    keys = {key: word for key, word in text.ranks.items() if key.endswith(".") and len(key) > 2}
    expansions = Expansions(replace(Speaker.of(name).manner.forms, rank_cases=()))
    for key, word in keys.items():
        assert [found.read for found in expansions.find(f"- {key}!")] == [word]


def test_a_letter_behind_a_rank_is_an_initial_and_no_numeral():
    read, expected = {}, {}
    for one in LIBRARY.names("language"):
        text = LIBRARY.language(one.name).model.text
        books = text.ranks.keys() & {key[:-2] for key in text.abbreviations if key[-3:] == ". ~"}
        expansions = Expansions(replace(Speaker.of(one.name).manner.forms, letters={}))
        for book in books:
            for name in ("L. Xxx", "V. Xxx", "C.D. Xxx", "L..."):
                line = f"- {book} {name}"
                expected[one.name, line] = [text.ranks[book]]
                read[one.name, line] = [found.read for found in expansions.find(line)][:1]
    assert read
    assert read == expected


@pytest.mark.parametrize(
    ("anywhere", "ranks"),
    [
        (True, ["sgt.", "çvş.", "сгт.", "пдпрч.", "στρ.", "րպտ.", "სრჟ."]),
        (False, ["cap.", "lt.", "sgt", "Sgt.", "край.", "αρχ.", "ցեղ.", "გენ.", "רסן.", "नयक."]),
    ],
)
def test_a_rank_is_read_anywhere_without_a_vowel_in_any_alphabet(anywhere, ranks):
    text = LanguageText.model_validate({"ranks": dict.fromkeys(ranks, "rank")})
    read = abbreviations_of(text, LIBRARY.common().model.text.vowels)
    assert read == dict.fromkeys(ranks, "rank||rank" if anywhere else "rank||")


@given(st.lists(st.integers(1, 5), min_size=2, max_size=5), st.sampled_from(["und", "oder"]))
def test_each_number_of_a_list_has_the_form_of_the_last(numbers, join):
    words = ("erste", "zweite", "dritte", "vierte", "fünfte")
    keys = {"#. *": "{1:weak}r {2}", "am #. *": "am {1:weak}n {2}", "im #. *": "im {1:weak}n {2}"}
    forms = SpokenForms(abbreviations=keys, numbers={"weak": words}, joins=("und", "oder"))
    for before, ending, after in (("am", "n", "Mai."), ("Im", "n", "Stock"), ("Der", "r", "Tag")):
        *most, last = numbers
        said = ", ".join(words[one - 1] + ending for one in most)
        said = f"{before} {said} {join} {words[last - 1]}{ending} {after}"
        written = ", ".join(f"{one}." for one in most)
        written = f"{before} {written} {join} {last}. {after}"
        read = respelled(written, Expansions(forms).find(written))
        assert read.casefold() == said.casefold()


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("about 5-6 km off", "about of-five to of-six kilometres off"),
        ("for 2–3 km", "for two to three kilometre"),
        ("for 3-2 km", "for 3 to two kilometre"),
        ("for 2-3 minutes", "for twain to 3 minutes"),
        ("for 1-3 minutes", "for 1 to 3 minutes"),
        ("about 2-3 May", "about the 2 till 3 May"),
        ("for 2-3-4 km", "for 2-3-4 km"),
    ],
)
def test_the_first_number_of_a_range_has_the_form_of_the_last(written, said):
    keys = {"#-#": "{1} to {2}", "#〜#": "{1} to {2}", "# km": "{1:n} kilometre"}
    keys |= {"#–#": "{1} to {2}", "about # km": "about {1:of} kilometres"}
    own = {"2 *s": "twain {1}s", "about #-# May": "about the {1} till {2} May"}
    own["1 *s"] = "single {1}s"
    words = ("one", "two", "three", "four", "five", "six")
    numbers = {"n": words, "of": tuple(f"of-{word}" for word in words)}
    forms = SpokenForms(abbreviations=keys | own, numbers=numbers)
    assert respelled(written, Expansions(forms).find(written)) == said


@pytest.mark.parametrize("name", COUNTING)
def test_a_number_with_decimals_has_one_unit(name):
    # rules of a noun have no word for a decimal, and would say it before and after the sign
    text = LIBRARY.language(name).model.text
    expansions = Expansions(Speaker.of(name).manner.forms)
    units = [key for key, read in text.abbreviations.items() if fullmatch(r"# ?[^#~*{}\d]+", key)]
    for key in (one for one in units if "} {1:" in text.abbreviations[one]):
        written = key.replace("#", "2,5")
        assert not search(r"[^\W\d],[^\W\d]", respelled(written, expansions.find(written)))
    for unit in text.lists["decimal_unit"]:
        read = [respelled(one, expansions.find(one)) for one in (f"2,5 {unit}", f"2.5 {unit}")]
        assert read[0] == read[1]


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("Sí, mi tte.", "Sí, mi teniente."),
        ("(Sí, mi tte.)", "(Sí, mi teniente)"),
        ("Sí, mi tte. espera", "Sí, mi teniente espera"),
        ("Un tte.", "Un tte."),
    ],
)
def test_a_rank_is_read_without_a_name_where_a_case_shows_it(written, said):
    nameless = ("$", r"(?<!\w)mi ", {})
    forms = SpokenForms(abbreviations={"tte.": "teniente||"}, rank_cases=(nameless,))
    assert respelled(written, Expansions(forms).find(written)) == said


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("5'e", "5e"),
        ("Ali'ye", "Aliye"),
        ("TSK'ya", "TSK'ya"),
        ("it is 3.5 km", "it is three and five km"),
        ("it is 3.500 km", "it is 3500 km"),
        ("60/40 and 7/10 and 50/50", "60 to 40 and 7 of 10 and 50 to 50"),
    ],
)
def test_signs_between_figures_show_what_they_mean(written, said):
    keys = {"…'…": "", "#.# km": "{1:n} and {2:n} km", "#/#": "{1} of {2}", "50/50": "50 to 50"}
    words = ("one", "two", "three", "four", "five")
    forms = SpokenForms(abbreviations=keys, numbers={"n": words}, thousands=".")
    assert respelled(written, Expansions(forms).find(written)) == said


def test_no_pause_follows_an_apostrophe():
    # eSpeak NG rests behind it
    read = Speaker.of("turkish").transcribe(["Ankara'da kar var.", "Saat 10'da gel."])
    assert not any("_" in one.phonemes for one in read)


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("Hut u. Stock", "Hut und Stock"),
        ("U. Meier kommt", "U. Meier kommt"),
        ("usw. steht da", "und so weiter steht da"),
        ("Usw. steht da", "Und so weiter steht da"),
    ],
)
def test_a_single_letter_is_no_initial_of_a_name(written, said):
    forms = SpokenForms(abbreviations={"u. ": "und ", "usw.": "und so weiter"})
    assert respelled(written, Expansions(forms).find(written)).casefold() == said.casefold()


def test_no_rank_is_another_word_without_a_name():
    # `o cap. chegou` is said more often than a chapter without its number
    others = {}
    for one in LIBRARY.names("language"):
        if text := LIBRARY.language(one.name).model.text:
            same = {*map(bare_letters, text.ranks.values())}
            both = {k: text.abbreviations[k] for k in text.ranks.keys() & text.abbreviations}
            others |= {k: w for k, w in both.items() if bare_letters(w.split("|")[0]) not in same}
    assert others == OTHER_READINGS


def test_a_title_that_means_something_else_needs_a_name():
    expansions = Expansions(Speaker.of("english").manner.forms)
    for text in ("In Main St.!", "In Main St., now", "In Main St."):
        assert [found.read for found in expansions.find(text)] == ["Street"]


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("um kl. 9.00. Der", "um klokken 9. Der"),
        ("l'1 maggio, l'1,5 kg", "l'uno maggio, l'1,5 kg"),
        ("La III Cumbre", "La third Cumbre"),
        ("La zona III es", "La zona III es"),
        ("via Po 3, 2° piano", "via Po 3, second piano"),
        ("al 1, 3 e 2° piano", "al first, third e second piano"),
    ],
)
def test_a_numeral_is_read_as_its_neighbours_show(written, said):
    keys = {"kl. #.00": "klokken {1}", "#.": "{1:nth}", "…'1": "'uno", "#ª": "{1:nth}"}
    forms = SpokenForms(
        abbreviations=keys | {"#° *": "{1:nth} {2}"},
        numbers={"nth": ("first", "second", "third")},
        numerals_like={"la ~": "#ª"},
        counted=("capitolo",),
        joins=("e",),
    )
    assert respelled(written, Expansions(forms).find(written)) == said


@pytest.mark.parametrize(("after", "stops"), [(" and", 0), (" And", 1), (", and", 1), ("", 1)])
def test_the_stop_of_a_unit_ends_no_sentence_before_a_small_letter(after, stops):
    utterances = Utterances(Speaker.of("english").manner.forms, {}, str.islower)
    (read,) = map(part_text, utterances.cut(f"It weighs 12 lbs.{after}"))
    assert read == f"It weighs 12 pounds{'.' * stops}{after}"


@pytest.mark.parametrize("name", [one.name for one in LIBRARY.names("language")])
def test_written_forms_are_spelled_as_texts_are(name):
    model = LIBRARY.language(name).model
    split = [normalize("NFC", letter) for letter in (model.g2p.letters if model.g2p else ())]
    stated = model.text.abbreviations | model.text.ranks if model.text else {}
    assert not stated or model.text.sources, "say where the written forms come from"
    assert not [key for pair in stated.items() for key in pair if any(map(key.__contains__, split))]


@pytest.mark.parametrize("language", ["english", "russian", "greek", "german"])
def test_a_replacement_leaves_the_words_beside_it_in_capitals(language):
    reader = Utterances(Speaker.of(language).manner.forms, {}, str.islower)
    for text in ("5 KM TO", "TO 5:30 TO"):
        assert "".join(map(part_text, reader.cut(text))).isupper()


@pytest.mark.parametrize(
    "written", ["Lehrer*innen", "x*y", "C*", "a#b", "Wait!don't", "me@home.org", "**so**"]
)
def test_signs_beside_whole_words_are_no_censorship(written):
    assert not [*uncensored(f"You {written} too.", Speaker.of("english").manner.forms)]
