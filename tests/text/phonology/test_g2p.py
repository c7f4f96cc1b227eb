"""Text to phonemes: tokens, rules, lexicons, and words of an engine matched with the text."""

import string
from pathlib import Path
from unicodedata import normalize

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import needs_plug_ins
from voices import speak

from lipsync_lang import SpeechError
from lipsync_lang.packs.checking.language_checks import check_labels
from lipsync_lang.packs.models import Language
from lipsync_lang.packs.models.text_models import LanguageText
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.source import YamlSource
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.espeak.process import EspeakProcess, words_of
from lipsync_lang.text.phonology.g2p import (
    G2P_ENGINES,
    RESPELLERS,
    Settings,
    SpokenWord,
    engine,
)
from lipsync_lang.text.phonology.g2p.corrections import corrector
from lipsync_lang.text.phonology.g2p.espeak_g2p import paired, parts
from lipsync_lang.text.phonology.g2p.g2p_engines import (
    Correction,
    MissingReaderError,
    Rule,
)
from lipsync_lang.text.phonology.g2p.ipa_text import segments
from lipsync_lang.text.phonology.g2p.lexicon import read_lexicon
from lipsync_lang.text.phonology.g2p.rules import (
    Rewriter,
    compiled_readings,
    never_fire,
    stated_syllables,
)
from lipsync_lang.text.phonology.g2p.tokens import pieces, plain


def words(text):
    """The words of a text."""
    return [piece.text for piece in pieces(text) if piece.kind == "word"]


# Tokens


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("Hello, world", ["Hello", "world"]),
        ("don't well-known", ["don't", "well-known"]),
        ("'quoted' -dash- word", ["quoted", "dash", "word"]),
        ("10,000 and 3.5 at 12:30.", ["10,000", "and", "3.5", "at", "12:30"]),
        ("हिन्दी में", ["हिन्दी", "में"]),
        ("สวัสดี", ["สวัสดี"]),
        ("ʼáłah fa‘afetai", ["ʼáłah", "fa‘afetai"]),
        ("သူ၏", ["သူ၏"]),
        ("مِنْ البيت؟", ["مِنْ", "البيت"]),
        ("e\u0301te\u0301", ["e\u0301te\u0301"]),
        ("", []),
        (" \t\n!?", []),
    ],
)
def test_words_are_told_apart(text, found):
    assert words(text) == found


def test_pauses_and_symbols_are_kept_apart():
    kinds = [(p.text, p.kind) for p in pieces("a, b - c… 5 $ 私。b\n\nc")]
    assert kinds == [
        ("a", "word"), (",", "pause"), ("b", "word"), ("-", "pause"), ("c", "word"),
        ("…", "pause"), ("5", "word"), ("$", "symbol"), ("私", "word"), ("。", "pause"),
        ("b", "word"), ("\n\n", "pause"), ("c", "word"),
    ]  # fmt: skip


@given(st.text())
def test_pieces_lie_in_the_text_in_order(text):
    at = 0
    for piece in pieces(text):
        assert piece.start >= at
        assert text[piece.start : piece.start + len(piece.text)] == piece.text
        assert piece.text
        at = piece.start + len(piece.text)
    assert sum(c.isalpha() for p in pieces(text) for c in p.text) == sum(map(str.isalpha, text))


# Rules


def read(rules, labels, word):
    """Return the labels of a word by some rules."""
    return Rewriter([Rule(*rule) for rule in rules], labels).read(word)


def test_the_first_rule_that_fits_wins_and_labels_need_none():
    rules = [("ch", ("tʃ",)), ("c", ("θ",), "[ei]"), ("c", ("k",)), ("h", ())]
    labels = ["a", "e", "i", "l", "tʃ", "θ", "k", "rr", "r"]
    assert read(rules, labels, "Chile").labels == ("tʃ", "i", "l", "e")
    assert read(rules, labels, "cielha").labels == ("θ", "i", "e", "l", "a")
    assert read(rules, labels, "carrar").labels == ("k", "a", "rr", "a", "r")
    assert read([], ["ɡ", "a"], "gaɡa").labels == ("ɡ", "a", "ɡ", "a")


def test_contexts_look_both_ways_and_know_where_a_word_ends():
    rules = [("r", ("rr",), "", "^|[nls]"), ("s", (), "$"), ("r", ("r",)), ("s", ("s",))]
    labels = ["a", "n", "r", "rr", "s"]
    assert read(rules, labels, "ranras").labels == ("rr", "a", "n", "rr", "a")
    assert read(rules, labels, "sara").labels == ("s", "a", "r", "a")


def test_what_nothing_reads_is_named_and_loses_nothing_else():
    found = read([], ["a", "b"], "ab7ж-a")
    assert (found.labels, found.unread) == (("a", "b", "a"), "7ж")


def test_letters_are_compared_composed_and_small():
    rules = [("\u00e9", ("e",))]
    assert read(rules, [], "E\u0301").labels == ("e",)
    assert plain("E\u0301’S") == "\u00e9's"


def test_a_bad_context_is_a_message():
    with pytest.raises(SpeechError, match=r"rule 1 \('a'\): its context is not a regular"):
        Rewriter([Rule("a", ("a",), "(")])


@pytest.mark.parametrize(
    ("rules", "found"),
    [
        ([("c", ("k",)), ("ch", ("x",))], [(1, 0)]),
        ([("ch", ("x",)), ("c", ("k",))], []),
        ([("c", ("s",), "e"), ("c", ("k",))], []),
        ([("c", ("s",), "e"), ("c", ("k",), "e")], [(1, 0)]),
        ([("c", ("s",), "h"), ("ch", ("k",))], []),
        ([("c", ("k",)), ("c", ("s",), "e")], [(1, 0)]),
        ([("a", ("a",), "", "^"), ("a", ("b",), "x", "^")], [(1, 0)]),
        ([("É", ("a",)), ("é", ("b",))], [(1, 0)]),
    ],
)
def test_rules_that_never_fire_are_found(rules, found):
    assert list(never_fire([Rule(*rule) for rule in rules])) == found


small = st.text("abc", min_size=1, max_size=2)
contexts = st.sampled_from(["", "a", "[bc]", "$"])


@given(
    st.lists(st.tuples(small, contexts, st.sampled_from(["", "^", "b"])), max_size=6),
    st.text("abc", max_size=8),
)
def test_a_rule_that_never_fires_never_fires(drawn, word):
    rules = [Rule(spelling, (str(n),), before, after) for n, (spelling, before, after) in
             enumerate(drawn)]  # fmt: skip
    dead = {number for number, _ in never_fire(rules)}
    assert dead.isdisjoint(number for number, _, _ in Rewriter(rules).steps(word))


def test_labels_that_the_notation_lacks_are_found():
    g2p = {"engine": "rules", "rules": ({"from": "a", "to": ("g", "x")},)}
    stated = {"g2p": g2p, "notations": {"ipa": {"\u0261": "kg"}}}
    model = Language(kind="language", format=1, name="own", tag="x", **stated)
    pack = Pack(model, (YamlSource(Path("own.yaml"), {}),))
    assert [fault.what for fault in check_labels(pack)] == ["'x' is not in the notation 'ipa'"]


# Lexicons


def test_lexicons_come_in_two_forms(tmp_path):
    file = tmp_path / "words.tsv"
    file.write_text(";;; comment\n# another\nHAUS\th aʊ s\nWORD(2)  W ER1 D\nWORD  X\n\n", "utf-8")
    assert read_lexicon(file) == {"haus": ("h", "aʊ", "s"), "word": ("W", "ER1", "D")}


@pytest.mark.parametrize("tab", ["\t", " "])
def test_probabilities_of_a_lexicon_are_no_labels(tmp_path, tab):
    file = tmp_path / "english_us_mfa_reduced.dict"
    rows = [
        "about 0.05 0.11 1.68 1.05 ə b a w t",
        "about 0.99 0.1 1.68 1.05 ə b aw t",
        "about 0.5 0.1 1.68 1.05 b aw t",
        "kaldi 1.0 K AA1",
        "six s 6 k s",
        "six x",
        "<unk> spn",
        "[laughter] 0.9 spn",
    ]
    lines = (row.replace(" ", tab, 5 if "1.68" in row else 1) for row in rows)
    file.write_text("\n".join(lines), "utf-8")
    assert read_lexicon(file) == {
        "about": ("ə", "b", "aw", "t"),
        "kaldi": ("K", "AA1"),
        "six": ("s", "6", "k", "s"),
    }


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"zero 0.99 0.1\n", r"words.tsv:1: .* is not a word and its labels"),
        (b"<unk> spn\n", "has no words"),
        (b"haus\n", r"words.tsv:1: 'haus' is not a word and its labels"),
        (b"a\tb\nhaus\t \n", r"words.tsv:2: .* is not a word and its labels"),
        (b"", "has no words"),
        (b"\xff\tb", r"is not UTF-8 text \(byte 0\)"),
    ],
)
def test_bad_lexicons_are_located(tmp_path, content, message):
    file = tmp_path / "words.tsv"
    file.write_bytes(content)
    with pytest.raises(SpeechError, match=message):
        read_lexicon(file)
    with pytest.raises(SpeechError, match="cannot be read"):
        read_lexicon(tmp_path / "none.tsv")


def test_a_lexicon_reads_compounds_falls_back_on_rules_and_names_the_rest(tmp_path):
    file = tmp_path / "words.tsv"
    file.write_text("well\tw ɛ l\nknown\tn oʊ n\n", "utf-8")
    settings = Settings("test", file=file, labels=("a",))
    (found,) = engine("lexicon", settings)(["Well-known, zap"])
    assert found == (
        SpokenWord("Well-known", ("w", "ɛ", "l", "n", "oʊ", "n")), SpokenWord(",", ()),
        SpokenWord("zap", (), unread="zap"),
    )  # fmt: skip
    ruled = Settings("test", file=file, rules=(Rule("z", ("s",)),), labels=("a",))
    (found,) = engine("lexicon", ruled)(["zap"])
    assert found == (SpokenWord("zap", ("s", "a"), unread="p"),)
    with pytest.raises(SpeechError, match="reads by a lexicon, but names none"):
        engine("lexicon", Settings("test"))


# Engines by name


def test_every_engine_and_respeller_is_where_it_is_said_to_be():
    for known in (G2P_ENGINES, RESPELLERS):
        assert set(known.modules) <= set(known.built_in())


@needs_plug_ins
def test_unknown_engines_are_messages():
    with pytest.raises(SpeechError, match="unknown G2P engine 'espaek'; did you mean 'espeak'"):
        engine("espaek", Settings("x"))
    with pytest.raises(SpeechError, match="unknown respeller 'kanna'; did you mean 'kana'"):
        RESPELLERS.find("kanna", SpeechError)


@given(st.lists(st.sampled_from(["t͡s", "tʰ", "aː", "n̩", "kʷ", "ŋ", "ɡ", "ã"]), max_size=9))
def test_ipa_is_cut_into_letters_with_their_marks(drawn):
    known = ["ts"]
    found = segments("".join(drawn), known)
    assert list(found) == [d.replace("t͡s", "ts").replace("ɡ", "g").replace("ː", ":") for d in drawn]


def test_labels_that_an_engine_runs_together_are_taken_apart():
    assert words_of("nˈi_k (en)_d_ʲ_(fr)") == [("n", "ˈi", "k"), ("dʲ",)]
    assert parts("jd", {"j", "d"}) == ("j", "d")
    assert parts("ntɕ", {"n", "tɕ"}) == ("n", "tɕ")
    assert parts("jx", {"j"}) == ("jx",)


@pytest.mark.parametrize(
    ("voice", "text", "labels"),
    [("ar", "مُحَمَّد", "muħammad"), ("he", "שָׁלוֹם", "ʃalom"), ("uk", "Так… «ні»", "t̪akɲi")],
)
def test_marks_are_read_in_any_order_and_quotes_not_by_name(voice, text, labels):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    for form in ("NFC", "NFD"):
        heard = speak(normalize(form, text), voice).labels
        assert "".join(label for label in heard if label != "_").replace("ɡ", "k") == labels


# An engine's words and the user's

CLAUSE = [("h", "ə"), ("w", "ɜː")]


def texts(found):
    """Return the spelling and the labels of spoken words."""
    return [(said.text, "".join(said.labels)) for said in found]


@pytest.mark.parametrize(
    ("text", "clauses", "found"),
    [
        ("Hello world", [CLAUSE], [("Hello", "hə"), ("world", "wɜː")]),
        ("Hello, world!", [CLAUSE[:1], CLAUSE[1:]], [("Hello", "hə"), (",", ""), ("world", "wɜː")]),
        ("Hello, world", [CLAUSE], [("Hello", "hə"), ("world", "wɜː")]),
        ("of the world", [CLAUSE], [("of the world", "həwɜː")]),
        ("in the world", [CLAUSE], [("in the", "hə"), ("world", "wɜː")]),
        ("in the", [CLAUSE[:1]], [("in the", "hə")]),
        ("in the 8", [CLAUSE], [("in the 8", "həwɜː")]),
        ("10 000", [CLAUSE], [("10 000", "həwɜː")]),
        ("NASA it", [CLAUSE], [("NASA it", "həwɜː")]),
        ("5", [CLAUSE], [("5", "həwɜː")]),
        ("hel-wor 7", [[*CLAUSE, ("d",)]], [("hel-wor", "həwɜː"), ("7", "d")]),
        ("of hel-wor 7", [[*CLAUSE, ("d",)]], [("of hel-wor 7", "həwɜːd")]),
        ("of 8", [CLAUSE], [("of 8", "həwɜː")]),
        ("a. b c", [CLAUSE, CLAUSE[:1]], [("a", "həwɜː"), (",", ""), ("b c", "hə")]),
        ("a.b, hel", [CLAUSE, CLAUSE[:1]], [("a", "hə"), ("b", "wɜː"), (",", ""), ("hel", "hə")]),
        ("...", [], []),
    ],
)
def test_words_are_the_users_where_that_is_sure(text, clauses, found):
    assert texts(paired(text, clauses, {"hel-wor": 2, "7": 1, "in the": 1})) == found


@given(
    st.text(string.ascii_letters + " ,.5"),
    st.lists(st.lists(st.just(("a", "b")), max_size=3), max_size=3),
)
def test_no_label_is_lost_in_pairing(text, clauses):
    labels = [label for said in paired(text, clauses) for label in said.labels]
    assert labels == [label for clause in clauses for word in clause for label in word]


# Corrections


def test_a_correction_of_names_needs_a_capital():
    mend = corrector([Correction(("z",), (), before="$", spelled="^(?!les$).*s$", capital=True)])
    said = {text: mend(SpokenWord(text, ("a", "z"))).labels for text in ("Bois", "bois", "Les")}
    assert said == {"Bois": ("a",), "bois": ("a", "z"), "Les": ("a", "z")}
    assert mend(SpokenWord("BOIS", ("a", "z"))).labels == ("a", "z")


def test_corrections_see_labels_around_them_and_the_spelling():
    mend = corrector(
        [
            Correction(("a",), ("ə",), before="$", spelled="e$"),
            Correction(("a",), ("æ",), before="r", spelled="^[^a]*$"),
            Correction(("a",), ("ɑː",)),
            Correction(("n", "n"), ("n",)),
            Correction(("h",), (), after="^k"),
            Correction(("ts",), ("t", "s")),
            Correction(("o:",), ("o",), after="uː"),
        ]
    )
    found = {
        word: " ".join(mend(SpokenWord(word, tuple(labels.split()))).labels)
        for word, labels in {
            "Mage": "m a ɡ a", "merke": "m a r k a", "hann": "h ɑ n n", "kha": "k h ɑ",
            "tsar": "ts ɑ r", "sti": "s t i", "ka": "k a", "duo": "d uː oː",
        }.items()
    }  # fmt: skip
    assert found == {
        "Mage": "m ɑː ɡ ə", "merke": "m æ r k ə", "hann": "h ɑ n", "kha": "k ɑ",
        "tsar": "t s ɑ r", "sti": "s t i", "ka": "k ɑː", "duo": "d uː o",
    }  # fmt: skip


def test_corrections_keep_the_stress_of_what_they_correct():
    mend = corrector([Correction(("a", "n"), ("e", "m", "n")), Correction(("ə",), ())])
    said = mend(SpokenWord("word", ("t", "a", "n", "ə"), stress=(None, 1, None, 0)))
    assert (said.labels, said.stress) == (("t", "e", "m", "n"), (None, 1, None, None))


def test_corrections_that_cannot_be_used_are_named():
    with pytest.raises(SpeechError, match=r"correction 2 .*is not a regular expression"):
        corrector([Correction(("a",), ()), Correction(("b",), (), before="(")])


def test_an_engine_with_corrections_is_corrected():
    rules = (Rule("ai", ("a", "i")),)
    read = engine(
        "rules",
        Settings(
            "", rules=rules, labels=("t",), corrections=(Correction(("i",), ("j",), after="a"),)
        ),
    )
    assert [word.labels for text in read(["tai"]) for word in text] == [("t", "a", "j")]


def test_a_correction_sees_the_first_label_of_the_next_word_but_none_across_a_pause():
    rules = tuple(Rule(letter, (letter,)) for letter in "ratp")
    open_end = Correction(("r",), ("r", "ə"), before="$", next_word="[pt]")
    read = engine("rules", Settings("", rules=rules, corrections=(open_end,)))
    (found,) = read(["atr pa tr a ptr, pa tr"])
    said = [" ".join(word.labels) for word in found]
    assert said == ["a t r ə", "p a", "t r", "a", "p t r", "", "p a", "t r"]


def test_an_engine_that_is_not_installed_is_replaced_by_the_other_that_the_pack_names(monkeypatch):
    def missing(settings):
        raise MissingReaderError(f"{settings.language} needs something")

    find = G2P_ENGINES.find
    monkeypatch.setattr(
        G2P_ENGINES, "find", lambda name, error: missing if name == "missing" else find(name, error)
    )
    rules = (Rule("a", ("a",)),)
    read = engine("missing", Settings("x", rules=rules, otherwise="rules"))
    assert [word.labels for text in read(["aa"]) for word in text] == [("a", "a")]
    with pytest.raises(SpeechError, match="x needs something"):
        engine("missing", Settings("x", rules=rules))


@pytest.mark.parametrize("context", ["kɡ", "kg", "aːɡ", "a:g"])
def test_contexts_of_corrections_see_labels_in_any_spelling(context):
    mend = corrector([Correction(("n",), ("ŋ",), before=f"[{context}]")])
    assert mend(SpokenWord("tango", ("t", "a", "n", "ɡ", "o"))).labels[2] == "ŋ"
    mend = corrector([Correction(("n",), ("ŋ",), after="aː$")])
    assert mend(SpokenWord("taan", ("t", "aː", "n"))).labels[2] == "ŋ"


def test_stated_readings_count_for_whole_words_between_their_contexts():
    readings = compiled_readings(
        [Rule("长", ("chang2",), "(?!大)", "^"), Rule("大夫", ("dai4", "fu5"))]
    )
    found = {
        " ".join(phrases): stated_syllables("".join(phrases), phrases, readings)
        for phrases in (["长", "着"], ["长大"], ["很", "长"], ["大夫"], ["士大夫"])
    }
    assert found == {
        "长 着": {0: "chang2"}, "长大": {}, "很 长": {}, "大夫": {0: "dai4", 1: "fu5"},
        "士大夫": {},
    }  # fmt: skip
    with pytest.raises(SpeechError, match=r"reading 1 \('大夫'\) has 1 syllables for 2"):
        compiled_readings([Rule("大夫", ("dai4",))])


@pytest.mark.parametrize(
    "language", [pytest.param("thai", marks=needs_plug_ins), "lao", "khmer", "burmese", "mongolian"]
)
def test_a_language_without_latin_letters_hears_words_in_them_from_a_voice(language):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    (read,) = Speaker.of(language).transcribe(["Photoshop"])
    assert [one for one in read.phonemes if one in {"f", "bmp"}] == ["f", "bmp"]
    assert not read.unread
    (letters,) = Speaker.of(language).transcribe(["CD"])
    assert not letters.unread


@pytest.mark.parametrize(
    "language",
    [
        *(pytest.param(name, marks=needs_plug_ins) for name in ("japanese", "thai")),
        "mandarin",
        "vietnamese",
    ],
)
def test_another_voice_starts_once_for_all_words_of_a_text(language, monkeypatch):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    starts, transcribe = [], EspeakProcess.transcribe
    monkeypatch.setattr(
        EspeakProcess,
        "transcribe",
        lambda self, texts, voice: starts.extend(texts[:1]) or transcribe(self, texts, voice),
    )
    before = {"japanese": "私は ", "mandarin": "我", "thai": "ฉัน "}.get(language, "")
    (said,) = Speaker.of(language).transcribe([f"{before}Photoshop Firefox Hamburg Facebook"])
    assert len(starts) == 1
    assert not said.unread
    (alone,) = Speaker.of(language).transcribe([f"{before}Hamburg"])
    assert [one.labels for one in said.words if one.text == "Hamburg"] == [alone.words[-1].labels]


def test_a_sign_of_repetition_needs_an_expression_that_is_quick():
    assert LanguageText(repeated={"ໆ": "[ກ-ຮ][ະ-ຽ]?"}).repeated
    with pytest.raises(ValueError, match="`repeated` could take too long"):
        LanguageText(repeated={"ໆ": "[ກ-ຮ]*[ກ-ຽ]*[ກ-ໝ]*[ກ-ໝ]*[ກ-ໝ]*"})


def test_a_word_unlike_those_of_the_language_is_heard_from_the_voice():
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    read = Speaker.of("vietnamese").transcribe(["Harry Photoshop", "xã-hội nghiêng"])
    (harry, program), (society, tilted) = ([word.labels for word in one.words] for one in read)
    assert harry == ("h", "a", "r", "i")
    assert (program[0], program[-1]) == ("f", "p")
    assert (society[0], tilted[0]) == ("x", "ngh")
