"""Every segment of the IPA is mapped to the common phoneme with the most similar look."""

import csv
import gzip
import re
import subprocess
import sys
from itertools import pairwise
from unicodedata import normalize

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, swept
from packs_tree import put
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.resolver.nearest_phonemes import (
    among,
    among_all,
    candidates,
    disagreements,
    reason_for,
)
from lipsync_lang.text.phonology.ipa import Features, key
from lipsync_lang.text.phonology.nearest import NearestPhonemes, ShadeLabels

COMMON = LIBRARY.common().model
MODEL = LIBRARY.ipa().model
DATA = MODEL.model_dump(mode="json", by_alias=True)
FEATURES = Features(DATA)
LETTERS = [*MODEL.letters]
MARKS = [mark.replace("\u25cc", "") for mark in MODEL.marks]
assert len(LETTERS) > 100
assert len(MARKS) > 100


def near(*adds, **rest):
    """Common phonemes of a language with additions to the base."""
    names = (*COMMON.base, *adds)
    return NearestPhonemes(FEATURES, {name: COMMON.phonemes[name].ipa for name in names}, **rest)


BASE, ROUND = near(), near("yu")


def shown(label, nearest=ROUND):
    """Phonemes of a label, without shares."""
    return " ".join(name for name, _ in nearest.nearest(label).value)


# What linguists say

CASES = {
    # vowels, one by one and with marks
    "i": "ih", "ɪ": "ih", "ɨ": "ih", "ɯ": "ih", "ᵻ": "ih", "ɩ": "ih", "ɿ": "ih", "ʅ": "ih",
    "e": "eh", "ɛ": "eh", "ᴇ": "eh", "e̞": "eh", "ẽ": "eh", "eː": "eh",
    "æ": "ah", "a": "aa", "ä": "aa", "ɐ": "ah", "ə": "ah", "ʌ": "ah", "ɤ": "ah", "ɜ": "ah",
    "ɘ": "ah", "ə̃": "ah", "ã": "aa", "aˤ": "aa", "ə̥": "ah",
    "ɑ": "aa", "ɑ̃ː": "aa", "ɔ": "ao", "ɒ": "ao", "ɔ̰": "ao", "o": "ao", "o̞": "ao",
    "u": "w", "ʊ": "w", "ɷ": "w", "ũː": "w", "o̝": "w", "ɯᵝ": "w",
    "y": "yu", "ʏ": "yu", "ø": "yu", "œ": "yu", "ʉ": "yu", "ɵ": "yu", "ü": "yu", "ɨ̹": "yu",
    "ɚ": "er", "ɝ": "er", "ə˞": "er", "ɜ˞": "er", "ə̃˞": "er", "a˞": "aa r", "ɑ˞": "aa r",
    # vowels in sequence
    "ai": "ay", "aɪ": "ay", "aj": "ay", "ɑɪ": "ay", "äi̯": "ay", "ai̯": "ay", "a͡ɪ": "ay",
    "au": "aw", "aʊ": "aw", "aw": "aw", "ɑu": "aw", "ãũ": "aw", "oi": "oy", "ɔɪ": "oy",
    "ou": "ow", "oʊ": "ow", "əʊ": "ow", "ei": "eh", "eɪ": "eh", "eu": "eh w", "ɛʊ": "eh w",
    "ia": "ih aa", "ua": "w aa", "ui": "w ih", "iu": "ih w", "ie": "ih eh", "eə": "eh ah",
    "ja": "ih aa", "wa": "w aa", "iau": "ih aw", "uai": "w ay", "aɪə": "ay ah", "aɪɚ": "ay er",
    "ii": "ih", "uʊ": "w", "ɔːɹ": "ao r", "əl": "ah l", "yi": "yu ih", "œy": "yu",
    # lips
    "p": "bmp", "b": "bmp", "m": "bmp", "ɓ": "bmp", "ʙ": "bmp", "ʘ": "bmp", "pʼ": "bmp",
    "ᵐb": "bmp", "mb": "bmp", "k͡p": "bmp", "kp": "bmp", "ɡ͡b": "bmp", "ŋ͡m": "bmp",
    "ŋmɡb": "bmp", "ŋʘ": "bmp", "kʘʼ": "bmp", "m̥": "bmp", "bʲ": "bmp", "m̩": "bmp",
    "β": "bmp", "β̞": "bmp", "pɦ": "bmp", "pʰ": "bmp", "p̚": "bmp", "pː": "bmp",
    "f": "f", "v": "f", "ʋ": "f", "ɱ": "f", "ⱱ": "f", "ɸ": "f", "p̪": "f", "ɱv": "f", "ȹ": "f",
    "pf": "bmp f", "p͡f": "bmp f", "mpf": "bmp f", "p̼": "th",
    # the tip of the tongue
    "t": "d", "d": "d", "n": "d", "ɖ": "d", "ʈ": "d", "ɳ": "d", "ɲ": "d", "ɾ": "d", "r": "d",
    "ɽ": "d", "ȶ": "d", "ȡ": "d", "ȵ": "d", "ᴅ": "d", "ᶑ": "d", "ɗ": "d", "ŋ": "d", "t̪": "d",
    "tʼ": "d", "ʰt": "d", "ⁿd": "d", "nd": "d", "ⁿt̪ʰ": "d", "n̩": "d", "d̪̤": "d", "tˠ": "d",
    "l": "l", "ɭ": "l", "ʎ": "l", "ɫ": "l", "ɬ": "l", "ɮ": "l", "ʟ": "l", "ȴ": "l", "ɺ": "l",
    "l̩": "l", "tɬ": "d l", "tɬʼ": "d l", "ɹ": "r", "ɻ": "r", "ɹ̩": "r",
    "θ": "th", "ð": "th", "ð̞": "th", "t̪θ": "d th",
    "s": "s", "z": "s", "s̪": "s", "sʼ": "s", "ts": "d s", "d͡z": "d s", "ʦ": "d s", "nts": "d s",
    "ʃ": "sh", "ʒ": "sh", "ɕ": "sh", "ʑ": "sh", "ʂ": "sh", "ʐ": "sh", "ɧ": "sh", "tʃ": "sh",
    "t̠ʃʰ": "sh", "dʒ": "sh", "ʤ": "sh", "n̠d̠ʒ": "sh", "ttʃ": "sh", "tɕ": "sh", "ʈʂʰ": "sh",
    # behind it
    "k": "kg", "ɡ": "kg", "g": "kg", "x": "kg", "ɣ": "kg", "q": "kg", "ɢ": "kg", "χ": "kg",
    "ʁ": "kg", "ʀ": "kg", "c": "kg", "ɟ": "kg", "ŋɡ": "kg", "ⁿɡ": "kg", "ɴɢ": "kg", "kx": "kg",
    "qχʼ": "kg", "c͡ç": "kg", "ɟʝ": "kg", "ɠ": "kg", "ʄ": "kg", "kŋ": "kg", "kˀ": "kg",
    "ç": "h", "h": "h", "ɦ": "h", "ħ": "h", "ʕ": "h", "ʔ": "h", "ʡ": "h", "ʔʲ": "h",
    "ʔm": "bmp", "ʔi": "ih", "ˀj": "ih",
    # glides
    "j": "ih", "ʝ": "ih", "ɰ": "ih", "w": "w", "ʍ": "w", "ɥ": "yu", "ʲ": "ih", "ʷ": "w",
    # clicks, with whatever the back of the tongue does
    "ǀ": "d", "ǃ": "d", "!": "d", "ǂ": "d", "ǁ": "l", "kǀ": "d", "ŋǃ": "d", "ɡǁx": "l",
    "kǃxʔ": "d", "ɢǃqʰ": "d", "ʔŋǂ": "d", "ŋ̥̰ǀʔ": "d", "kǃʰʼ": "d", "‼": "d", "ʇ": "d",
    # rounded beside another articulation
    "kʷ": "kg w", "kʷʼ": "kg w", "ŋɡʷ": "kg w", "pʷ": "bmp w", "tʃʷ": "sh w", "hʷ": "h w",
    "ʷr": "w d", "ʰʷts": "w d s", "ɡᶣ": "kg yu", "wʷ": "w", "t̪s̪ʰʷʲ": "d s w",
    # nothing to see
    "˥": "", "˥˩": "", "↓˦": "", "ː": "", "": "",
    "a˥": "aa", "i³": "ih", "ˈaː": "aa", '"o"': "ao", "<f>": "f", "(ɛː)": "eh", "d̪|d": "d",
}  # fmt: skip
assert len(CASES) > 80


@pytest.mark.parametrize("label", CASES)
def test_a_segment_becomes_what_the_policy_says(label):
    assert shown(label) == CASES[label]
    assert not ROUND.nearest(label).unknown


@pytest.mark.parametrize(
    ("label", "expected"),
    [("y", "w"), ("ʉ", "w"), ("ɥ", "w"), ("ʏ", "w"), ("ø", "ao"), ("œ", "ao"), ("ɡᶣ", "kg w")],
)
def test_a_rounded_front_vowel_goes_to_its_next_best(label, expected):
    assert shown(label, BASE) == expected


def test_the_page_on_mapping_states_what_a_draft_proposes_and_the_parent(root):
    page = (root / "docs/explanation/mapping.md").read_text(encoding="utf-8")
    drafted = among_all(LIBRARY)
    checked = 0
    for row in page.split("\n"):
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        if len(cells) != 3 or not cells[1].startswith("`") or re.search(r"[a-z]{4}", cells[0]):
            continue  # no row of labels
        mouth, *parent = [
            v.strip("[]").replace(",", "") for v in re.findall(r"`([^`]+)`", cells[1])
        ]
        for label in cells[0].split():
            assert shown(label, drafted) == mouth, row
            assert [COMMON.shades[mouth].like] == parent if mouth in COMMON.shades else not parent
            checked += 1
    assert checked > 90


def test_an_o_keeps_still_and_a_diphthong_moves():
    assert {shown(label) for label in ("o", "oː", "o̞", "õ", "ɔ")} == {"ao"}
    assert [shown(label) for label in ("oʊ", "əʊ")] == ["ow", "ow"]


# What is lost


@pytest.mark.parametrize(
    ("label", "losses"),
    [
        ("a", []),
        ("ãː", ["nasality", "length"]),
        ("˥˩", ["tone"]),
        ("tʰ", ["aspiration"]),
        ("pʼ", ["ejection"]),
        ("ŋɡ", ["prenasalisation"]),
        ("kǃ", ["accompaniment"]),
        ("b̤", ["voice quality"]),
        ("kʷ", []),
        ("y", []),
        ("ɯ", ["backness"]),
        ("x", ["contact"]),
    ],
)
def test_what_does_not_show_is_named(label, losses):
    assert list(ROUND.nearest(label).losses) == losses


def test_a_feature_that_is_shown_otherwise_is_named():
    assert list(BASE.nearest("y").losses) == ["backness"]
    assert BASE.nearest("y").distance > ROUND.nearest("y").distance == 0


def test_what_is_no_ipa_is_named_and_has_no_value():
    found = ROUND.nearest("tQö€")
    assert found.unknown == ("Q", "€")
    assert shown("tQö€") == "d yu"
    assert ROUND.value("tQö€") is None
    assert ROUND.value("tö") is not None
    assert ROUND.value("Q") is None


def test_time_is_shared_by_length():
    assert ROUND.nearest("ua").value == (("w", 0.5), ("aa", 0.5))
    assert ROUND.nearest("uːa").value == (("w", 2 / 3), ("aa", 1 / 3))
    assert ROUND.nearest("u̯a").value == (("w", 1 / 3), ("aa", 2 / 3))
    assert ROUND.nearest("aːː").value == (("aa", 1.0),)


# Everything there is


@full
def test_every_segment_of_phoible_finds_its_place(data):
    rows = (data / "phonology" / "phoible_segments.tsv").read_text("utf-8").split("\n")[1:]
    segments = [row.split("\t")[0] for row in rows if row]
    assert len(segments) == 3388
    fresh = near("yu")
    found = {segment: fresh.nearest(segment) for segment in segments}
    assert not [segment for segment, near in found.items() if near.unknown]
    mute = [s for s, n in found.items() if not n.value]
    assert not [s for s in mute if not re.fullmatch(r'[˥˦˧˨˩↓\u0324\u0330ˤ]+|"*|\*N', s)]
    assert sum(n.distance == 0 for n in found.values()) > 2000


@full
def test_every_inventory_of_phoible_finds_its_place(data):
    inventories = {}
    with gzip.open(data / "phonology" / "phoible_inventories.tsv.gz", "rt", "utf-8") as lines:
        for row in csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE):
            inventories.setdefault(row["inventory_id"], set()).add(row["phoneme_raw"])
    assert len(inventories) > 3000
    for segments in inventories.values():
        for segment in segments:
            found = ROUND.nearest(segment)
            assert not found.unknown or segment in {"*N", "ɡ̈V"}
            assert found.distance < 5


@pytest.mark.parametrize("letter", LETTERS)
def test_a_letter_that_closes_the_lips_is_shown_by_closed_lips(letter):
    words = set(MODEL.letters[letter].split())
    closed = "bilabial" in words
    for nearest in (BASE, ROUND):
        answer = shown(letter, nearest)
        assert (answer == shown("p")) == (closed or letter == "β")
        assert answer != shown("f") or {"labiodental", "loose-bilabial"} & words


@pytest.mark.parametrize("letter", LETTERS)
def test_a_language_shows_only_what_it_has(letter):
    assert {name for name, _ in BASE.nearest(letter).value} <= set(COMMON.base)


UNSEEN = [
    mark.replace("\u25cc", "")
    for mark, cases in MODEL.marks.items()
    if all(not case.set and not case.add and case.then is None for case in cases)
]
assert len(UNSEEN) > 60


@pytest.mark.parametrize("mark", swept(UNSEEN, quick=UNSEEN[::8]))
def test_a_mark_that_does_not_show_changes_nothing(mark):
    for letter in LETTERS:
        for label in (letter + mark, mark + letter):
            if key(label) not in map(key, MODEL.spellings):
                assert ROUND.nearest(label).value == ROUND.nearest(letter).value, label


texts = st.text(st.sampled_from([*LETTERS, *MARKS, "\u0361", "\u035c", "a", "p", "t", "ʃ"]))


@given(texts)
def test_any_string_of_letters_and_marks_is_read(label):
    found = ROUND.nearest(label)
    names = [name for name, _ in found.value]
    assert found == near("yu").nearest(label)
    assert found.unknown == ()
    assert set(names) <= {*COMMON.base, "yu"}
    assert all(one != other for one, other in pairwise(names))
    assert not names or sum(share for _, share in found.value) == pytest.approx(1)
    assert all(share > 0 for _, share in found.value)
    assert 0 <= found.distance < float("inf")
    assert bool(names) == bool(FEATURES.read(label).sounds)
    assert ROUND.value(label) == found.value


@given(texts)
def test_composition_and_ties_make_no_difference(label):
    plain = ROUND.nearest(label)
    for form in ("NFC", "NFD"):
        assert ROUND.nearest(normalize(form, label)) == plain
    tied = re.sub("(?<=[ptkdʃ])(?=[ptkdʃ])", "\u0361", label)
    assert ROUND.nearest(tied).value == plain.value


@full
@given(st.text())
def test_nothing_fails(label):
    found = BASE.nearest(label)
    assert (BASE.value(label) is None) == bool(found.unknown)


def test_without_candidates_nothing_answers():
    nobody = NearestPhonemes(FEATURES, {"ah": ()})
    assert nobody.nearest("a").value == ()
    assert nobody.value("a") is None
    assert nobody.value("˥") == ()


def test_it_is_pure():
    code = "import sys, lipsync_lang.text.phonology.nearest; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "pydantic", "yaml"} & set(run.stdout.split())


# The data


def test_the_ipa_is_no_language():
    assert IPA not in {found.name for found in LIBRARY.names("language")}
    with pytest.raises(ll.PackError, match="unknown language"):
        LIBRARY.language(IPA)


def test_no_letter_or_mark_is_stated_twice():
    for one, other in [("letters", "spellings"), ("letters", "marks"), ("marks", "spellings")]:
        stated = [*map(key, DATA[one]), *map(key, DATA[other]), *map(key, DATA["ignored"])]
        assert len(stated) == len(set(stated))


WRONG = [
    ("  p: bilabial stop", "  p: bilabal stop", "P222", "did you mean 'bilabial'"),
    ("bilabial:         {closure: 1}", "bilabial: {clossure: 1}", "P222", "'closure'"),
    ("  - {first: [click],", "  - {first: [clik],", "P222", "'click'"),
    ("  ʷ: {then: w}", "  ʷ: {then: Ж}", "P223", "`letters`"),
    ("  ʷ: {then: w}", "  ʷ: {set: {rouding: 1}}", "P222", "'rounding'"),
    ("  ˞: [{on: [central]", "  ˞: [{on: [middle]", "P222", ""),
    ("  β: {as: b", "  β: {as: Б", "P223", "`letters`"),
    ("  ɩ: ɪ\n", "  ɩ: Й\n", "P223", "under `letters` or `marks`"),
    ("  ʷ: w\n", "  Ю: w\n", "P223", "`marks`"),
    ("  sh: {j:", "  shh: {j:", "P202", "'sh'"),
    ("    to: [ax, ng]\n", "    to: [ax, nng]\n", "P202", "'ng'"),
    ("weight: 6,", "weight: -6,", "P104", ""),
    ("keep: both}", "keep: all}", "P107", ""),
]


@pytest.mark.parametrize(("old", "new", "code", "hint"), swept(WRONG, quick=3))
def test_what_is_wrong_in_the_ipa_is_found_where_it_stands(old, new, code, hint, tmp_path):
    text = LIBRARY.ipa().path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path = put(tmp_path, "languages/ipa.yaml", text.replace(old, new))
    faults = validate(Library([tmp_path], project=None), [path])
    line = text[: text.index(old)].count("\n") + 1
    assert [(f.code, f.line) for f in faults] == [(code, line)]
    assert hint in faults[0].hint
    with pytest.raises(PackFaults):
        ll.resolve("espeak:sw", "facefx", paths=[tmp_path], cache=False)
    assert ll.resolve("english", "facefx", paths=[tmp_path], cache=False), "it does not need it"


def test_a_phoneme_of_ones_own_takes_part(tmp_path):
    text = (
        "kind: language\nformat: 1\nname: throaty\ntag: qaa\nautomatic: true\n"
        "adds: {qq: {ipa: [ʕ, ç], like: h}, mm: {ipa: [m], like: bmp}}\n"
    )
    put(tmp_path, "languages/throaty.yaml", text)
    library = Library([tmp_path], project=None)
    pack = library.language("throaty")
    assert candidates(pack.model, library.common().model)["qq"] == ["ʕ", "ç"]
    nearest = among(library, pack)
    assert [shown(s, nearest) for s in ("ʕ", "ʢ", "ç", "h")] == ["qq", "qq", "qq", "h"]
    assert [shown(s, nearest) for s in ("m", "m̥", "p")] == ["mm", "mm", "bmp"], "its own is nearer"
    assert shown("y", nearest) == "w"


SHADED = NearestPhonemes(
    FEATURES,
    {name: COMMON.phonemes[name].ipa for name in COMMON.base},
    shades={name: ShadeLabels(s.like, s.ipa) for name, s in COMMON.shades.items()},
)


@pytest.mark.parametrize(
    ("label", "shade"),
    [
        ("ə", "ax"), ("æ", "ae"), ("æ̃", "ae"), ("ŋ", "ng"), ("ŋ̩", "ng"), ("n̪", "n"), ("ɲ", "n"),
        ("t", "d"), ("ʌ", "ah"), ("i", "iy"), ("ɪ", "ih"), ("ʊ", "uh"), ("u", "w"), ("ɯ", "ux"),
        ("t͡ʃ", "ch"), ("ʃ", "sh"), ("ʂ", "sh"), ("ɕ", "xi"), ("ɚ", "axr"), ("ɝ", "er"), ("ɒ", "oa"),
        ("j", "iy"), ("o", "oc"), ("ɔ", "ao"), ("k", "kg"), ("tɕ", "xi"), ("dʑ", "xi"), ("ɸ", "bw"),
    ],
)  # fmt: skip
def test_a_segment_becomes_the_shade_that_it_is(label, shade):
    assert shown(label, SHADED) == shade


# What packs say otherwise


def test_disagreements_come_with_their_reasons(tmp_path):
    text = (
        "kind: language\nformat: 1\nname: odd\ntag: qaa\n"
        "notations: {ipa: {t: d, ŋ: kg, ɾ: kg, tt: [d, d], r: kg, Q: s}}\n"
        "reasons: {ɾ: its tongue}\n"
    )
    put(tmp_path, "languages/odd.yaml", text)
    library = Library([tmp_path], project=None)
    pack = library.language("odd")
    found = disagreements(pack.model, among(library, pack))
    assert [(d.label, d.common, d.automatic, d.reason) for d in found] == [
        ("ɾ", (("kg", 1.0),), (("d", 1.0),), "its tongue"),
        ("r", (("kg", 1.0),), (("d", 1.0),), ""),
        ("Q", (("s", 1.0),), (), ""),
    ]


def test_a_reason_is_the_packs_or_shared_or_follows_from_features_or_another_label(tmp_path):
    text = (
        "kind: language\nformat: 1\nname: odd\ntag: qaa\n"
        "notations: {ipa: {tʰ: d, ʃ: s, ʃʲ: s, ɜː: er, ɜ: er, x: h, ɣ: s}}\n"
        "reasons: {x: soft}\n"
    )
    put(tmp_path, "languages/odd.yaml", text)
    library = Library([tmp_path], project=None)
    pack, decided = library.language("odd"), library.ipa().model.decided
    near = among(library, pack)
    found = {one: reason_for(pack.model, near, one, decided) for one in pack.model.notations[IPA]}
    fur = found.pop("ɜː")
    assert "fur" in fur
    assert found == {
        "tʰ": "by its features; not shown: aspiration",
        "ʃ": "", "ʃʲ": "as ʃ", "ɜ": fur, "x": "soft", "ɣ": "",
    }  # fmt: skip


def test_a_soft_b_does_not_close_where_shades_are_told_apart():
    everything = among_all(LIBRARY)
    assert [shown(one, everything) for one in ("β", "β̞", "ŋ", "eɪ")] == ["bw", "bw", "ng", "ey"]
    assert everything.nearest("β").losses == ()
    assert shown("β") == "bmp"


@full
def test_packs_agree_with_the_features_for_the_most_part():
    for found in LIBRARY.names("language"):
        pack = LIBRARY.language(found.name)
        table = pack.model.notations.get(IPA, {})
        differing = disagreements(pack.model, among(LIBRARY, pack))
        assert len(differing) <= 0.4 * len(table), found.name


@full
def test_packs_say_why_they_differ_from_the_features():
    decided = LIBRARY.ipa().model.decided
    for found in LIBRARY.names("language"):
        pack = LIBRARY.language(found.name)
        differing = disagreements(pack.model, among(LIBRARY, pack), decided)
        assert not [one.label for one in differing if not one.reason], found.name


def test_shared_decisions_are_made_by_some_pack_and_against_the_features():
    packs = [LIBRARY.language(found.name).model for found in LIBRARY.names("language")]
    tables = [pack.notations.get(IPA, {}) for pack in packs]
    made = {(label, sounds.to) for table in tables for label, sounds in table.items()}
    decided = [(label, one.to) for one in LIBRARY.ipa().model.decided for label in one.labels]
    assert not [one for one in decided if one not in made]
    assert len(decided) == len(set(decided))
