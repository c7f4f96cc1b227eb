"""X-SAMPA is read in all places for IPA, from data, and the two are not confused."""

from unicodedata import normalize

import pytest
from lanes import full, swept
from packs_tree import put
from shipped import LANGUAGES, LIBRARY

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.language_tables import tables_of
from lipsync_lang.resolver.nearest_phonemes import spelling
from lipsync_lang.text.phonology.ipa import key
from lipsync_lang.text.phonology.labels import Notation, ready, recognise

SPELLING = spelling(LIBRARY)
SIGNS = SPELLING["spelled"]["x-sampa"]
SILENT = (("_", 1.0),)
assert len(LANGUAGES) > 50

LETTERS = {}
"""IPA letters and their X-SAMPA signs."""
for sign, meant in SIGNS.items():
    LETTERS.setdefault(normalize("NFD", key(meant)), sign)


def spelled(label):
    """Return an IPA label in X-SAMPA; None if a part of it has no sign."""
    out, rest = "", normalize("NFD", key(label))
    while rest:
        longest = max(
            (part for part in LETTERS if part and rest.startswith(part)), key=len, default=""
        )
        if not longest:
            return None
        out, rest = out + LETTERS[longest], rest[len(longest) :]
    return out


def notations(name):
    """Notations of a language from a performer, without shapes."""
    pack = LIBRARY.language(name).model
    silences = LIBRARY.common().model.rests
    return ready(tables_of(pack), silences, SILENT, IPA, SPELLING)


@pytest.mark.parametrize("name", swept(LANGUAGES, quick=LANGUAGES[::9]))
def test_a_pack_reads_its_ipa_in_both_spellings_and_tells_them_apart(name):
    known = notations(name)
    assert IPA in known
    assert known["x-sampa"].signs
    labels = [*known[IPA].table]
    assert recognise(labels, known) == IPA
    pairs = [(label, other) for label in labels if (other := spelled(label)) is not None]
    assert len(pairs) > 0.7 * len(labels)
    wrong = [
        (label, other)
        for label, other in pairs
        if known["x-sampa"].find(other) != known[IPA].find(label)
    ]
    assert not wrong
    assert recognise([other for _, other in pairs], known) in {"sampa", "x-sampa"}


@pytest.mark.parametrize(
    ("label", "ipa"),
    [
        ("tS", "tʃ"), ("t_S", "tʃ"), ("t`_h", "ʈʰ"), ("2:", "øː"), ("@", "ə"), ("6", "ɐ"),
        ("_?", "ˀ"), ("r\\`", "ɻ"), ("r\\", "ɹ"), ("r`", "ɽ"), ("a~", "ã"), ("n=", "n̩"),
        ("d_Z", "dʒ"), ("b_<", "ɓ"), ("J\\", "ɟ"), ("t_j", "tʲ"), ("@`", "ɚ"), ('"a', "ˈa"),
        ("t_d", "t̪"), ("o_u", "ou"), ("|\\|\\", "ǁ"),
    ],
)  # fmt: skip
def test_a_label_is_read_the_longest_sign_first(label, ipa):
    assert key(Notation({}, signs=SIGNS).text(label)) == key(ipa)


@pytest.mark.parametrize("label", ["ʃ", "tʃ", "ə", "aː", "$", "§"])
def test_what_has_no_sign_is_not_read(label):
    notation = Notation({"ʃ": SILENT, "tʃ": SILENT, "ə": SILENT, "aː": SILENT}, signs=SIGNS)
    assert notation.find(label) is None
    assert notation.suggest(label) == "a sign of it is unknown"


@pytest.mark.parametrize("label", ["", "<p:>", "sil", "SIL", "_"])
def test_silence_is_silence_in_it(label):
    table = {"s": (("s", 1.0),), "p": (("bmp", 1.0),)}
    notation = Notation(table, ["", "sil", "<p:>", "_"], SILENT, signs=SIGNS)
    assert notation.find(label) == SILENT


def test_a_table_of_that_name_is_taken_instead():
    tables = {IPA: {"s": SILENT}, "x-sampa": {"tS": SILENT}}
    known = ready(tables, (), SILENT, IPA, SPELLING)
    assert [*known] == [IPA, "x-sampa", "praat", "worldbet"]
    assert not known["x-sampa"].signs


def test_a_language_without_ipa_has_none_to_spell():
    assert [*ready({"own": {"s": SILENT}}, (), SILENT, IPA, SPELLING)] == ["own"]


@pytest.mark.parametrize(
    ("old", "new"), [("    S: ʃ\n", "    S: Щ\n"), ("    _w: ʷ\n", "    _w: Щ\n")]
)
def test_a_sign_of_what_is_no_ipa_is_a_fault(old, new, tmp_path):
    text = LIBRARY.ipa().path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path = put(tmp_path, "languages/ipa.yaml", text.replace(old, new))
    faults = validate(Library([tmp_path], project=None), [path])
    line = text[: text.index(old)].count("\n") + 1
    assert [(f.code, f.line) for f in faults] == [("P223", line)]


def schedule(labels, **rest):
    spoken = labels.split()
    return ll.Schedule(tuple(spoken), [0.1 * n for n in range(len(spoken) + 1)], **rest)


def common(performer, line):
    """The common phonemes of a schedule."""
    return [performer.compiled.phonemes[n] for n in performer.common_phonemes(line)[0]]


@pytest.mark.parametrize("language", ["hindi", "ipa:hi"])
@pytest.mark.parametrize("notation", [None, "x-sampa"])
def test_a_line_becomes_the_same_in_both_spellings(language, notation):
    performer = ll.resolve(language, "facefx")
    line = schedule("<p:> d_d a: tS_h E~ t`_h @ S v u: <p:>", notation=notation)
    same = schedule("<p:> d̪ aː tʃʰ ɛ̃ ʈʰ ə ʃ v uː <p:>")
    assert common(performer, line) == common(performer, same)
    if performer.compiled.nearest:
        told = performer.automatic(line)
        assert told["tS_h"] == performer.automatic(same)["tʃʰ"]


def test_a_label_that_it_cannot_read_stops_the_line_and_says_what_was_read():
    performer = ll.resolve("hindi", "facefx")
    with pytest.raises(
        ScheduleError, match=r"phoneme 1 \('t_Nat', .* x-sampa of hindi; it is read as"
    ):
        performer.perform(schedule("a t_Nat a", notation="x-sampa"))


@pytest.mark.parametrize("language", ["german", "ipa:de"])
def test_hand_made_sampa_is_told_from_ipa_and_known_throughout(language, data):
    performer = ll.resolve(language, "facefx")
    files = sorted((data / "articulography").glob("*.phones.tsv"))
    assert files
    for path in files:
        labels = [row.split("\t")[2] for row in path.read_text(encoding="utf-8").splitlines()]
        line = schedule(" ".join(filter(None, labels)))
        notation = performer.notation(line)
        expected = "sampa" if language == "german" else "x-sampa"
        assert notation is performer.speaker.notations[expected]
        assert [label for label in line.labels if notation.find(label) is None] == []


@full
def test_an_alignment_of_maus_is_read_in_any_language_of_its_sounds(data):
    path = data / "alignments/polyglotdb/textgrids/maus/maus_test.TextGrid"
    line = ll.read_schedule(path)
    performer = ll.resolve("ipa:en", "facefx")
    assert performer.notation(line) is performer.speaker.notations["x-sampa"]
    assert all(performer.notation(line).find(label) is not None for label in line.labels)
