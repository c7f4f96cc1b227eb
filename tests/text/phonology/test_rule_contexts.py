"""Contexts of spelling rules: their meaning, and their bounded work."""

import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lanes import full

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.library import Library
from lipsync_lang.text.phonology.g2p.contexts import (
    MAX_CONTEXT_CHARS,
    MAX_MATCH_STEPS,
    SEEN_LETTERS,
    ContextError,
    compile_context,
)
from lipsync_lang.text.phonology.g2p.g2p_engines import Rule
from lipsync_lang.text.phonology.g2p.rules import Rewriter, too_slow
from lipsync_lang.text.phonology.g2p.tokens import plain

HOSTILE = {
    "nested repeats": "(a+)+$",
    "alternatives that overlap": "(a|aa)+$",
    "alternatives in sequence": "(a|a)" * 40 + "$",
    "optional groups in sequence": "(a?b?)?" * 40 + "$",
    "repeats in sequence": ".*.*.*.*.*x",
    "counted in counted": "((a{1000}){1000}){1000}",
    "counted alternatives": "(a|aa){1,60}$",
    "a look ahead in a repeat": "(a(?=.*b)|a)*c",
    "long": "a" * (MAX_CONTEXT_CHARS + 1),
}

FOREIGN = {"recursion": "(?R)", "flags": "(?i)a", "a condition": "(a)?(?(1)b)", "remark": "(?#a)"}

RULE_PACK = """kind: language
format: 1
name: mine
tag: x-mine
g2p:
  engine: rules
  rules:
    - {{from: a, to: a, {side}: '{text}'}}
notations:
  ipa: {{a: aa}}
tests:
  - {{text: {word}, phonemes: [aa]}}
"""


def fits(text, word, at, *, precedes=False):
    return compile_context(text, precedes=precedes).fits(plain(word), at)


# Meaning


@pytest.mark.parametrize(
    ("text", "word", "found"),
    [
        (r"\S", "xa", True),
        (r"\D", "x7", False),
        (r"\Z", "x", True),
        (r"(?P<Same>.)(?P=Same)", "xss", True),
        ("[A-Z]É", "xaE\u0301", True),
        ("e\u0301", "xÉ", True),
        (r"\u00c9", "xé", True),
        ("ẞ$", "xss", True),
        ("[’]", "x'", True),
        (r"\d\u0301", "x7\u0301", True),
    ],
)
def test_the_text_is_folded_and_the_expression_keeps_its_meaning(text, word, found):
    assert fits(text, word, 1) is found


def test_a_context_sees_the_letters_beside_the_place_and_where_the_word_ends():
    assert fits("^a(?!b)", "ab", 1, precedes=True)
    assert not fits("^", "ab", 1)
    assert fits("b$", "ab", 1)
    assert not fits("(?<!a)b", "ab", 1), "a look behind sees what precedes the rule"


def test_letters_far_away_are_not_seen():
    word = "x" + "a" * SEEN_LETTERS + "b"
    assert not fits("a*b", word, 1)
    assert fits("a*b", word, 2)
    assert not fits("^xa*", word, len(word) - 1, precedes=True)
    assert fits("^xa*", word, len(word) - 2, precedes=True)


# Hostile ones


@pytest.mark.parametrize("precedes", [False, True])
@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_a_context_that_could_run_away_is_refused(text, precedes):
    with pytest.raises(ContextError) as refused:
        compile_context(text, precedes=precedes)
    assert refused.value.slow
    assert refused.value.cure


@pytest.mark.parametrize("text", FOREIGN.values(), ids=FOREIGN)
def test_what_contexts_do_not_have_is_refused_by_name(text):
    with pytest.raises(ContextError, match="is not available in contexts; groups are"):
        compile_context(text, precedes=False)


@pytest.mark.parametrize(
    ("text", "cure"),
    [("[[a]", "backslash before"), ("[a--b]", "backslash before"), ("[xß]", r"\(\?:ß\|")],
)
def test_a_set_that_would_mean_something_else_is_refused(text, cure):
    with pytest.raises(ContextError, match=cure):
        compile_context(text, precedes=False)


@pytest.mark.parametrize(
    "text", ["(?>a|aa)*+$", "(?:ab)*c", "(?:a[bc]*+)*d", "(?:a|aa){0,8}b", "a*+b"]
)
def test_repeats_that_cannot_run_away_are_allowed(text):
    assert compile_context(text, precedes=False).steps <= MAX_MATCH_STEPS


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, without a cache."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", "off")
    return tmp_path


@pytest.mark.parametrize("side", ["before", "after"])
@pytest.mark.parametrize(
    ("text", "code", "cure"),
    [("(a+)+$", "P118", "atomic"), ("(a", "P117", ""), ("(?i)a", "P117", "groups are")],
)
def test_validate_and_transcribe_name_the_place_and_the_cure(  # noqa: PLR0913, PLR0917 fixtures
    cli, folder, side, text, code, cure
):
    file = folder / "languages" / "mine.yaml"
    file.parent.mkdir(exist_ok=True)
    file.write_text(RULE_PACK.format(side=side, text=text, word="a" * 60))
    for command in (["validate", str(file)], ["transcribe", "-l", "mine", "a" * 60]):
        code_, out, err = cli(*command)
        said = out + err
        assert code_ == 1
        assert f"mine.yaml:8:{26 + len(side)}: {code} " in said
        assert f"`{side}`" in said
        assert cure in said


def test_brackets_are_balanced_within_a_context():
    with pytest.raises(ContextError, match="not a regular expression: unbalanced parenthesis"):
        compile_context(")(?:", precedes=True)


# What passes works


PIECES = st.lists(
    st.sampled_from(
        [*"abÉß^$.|()[]{},*+?\\-'7", "(?:", "(?=", "(?<!a)", "[ab]", r"\S", r"\Z", "*+"]
    ),
    max_size=12,
).map("".join)


@full
@settings(max_examples=500)
@given(PIECES, st.booleans(), st.text("abé7'", max_size=60), st.integers(0, 60))
def test_every_context_that_is_accepted_works_in_use(text, precedes, word, at):
    try:
        context = compile_context(text, precedes=precedes)
    except ContextError:
        return
    word = plain(word)
    assert context.fits(word, min(at, len(word))) in (True, False)


@full
def test_the_rules_of_every_shipped_language_are_within_their_steps():
    library = Library()
    swept = 0
    for found in library.names("language"):
        g2p = library.language(found.name).model.g2p
        rules = [Rule(r.spelling, r.to, r.before, r.after) for r in (g2p.rules if g2p else ())]
        assert not list(too_slow(rules)), found.name
        swept += len(rules)
    assert swept > 1000, "a sweep over nothing passes"


def test_many_costly_rules_for_one_letter_are_refused_together():
    rules = [
        Rule("a", ("a",), after=f"{letter}.*.*b") for letter in "abcdefghijklmnopqrstuvwxyz" * 30
    ]
    with pytest.raises(SpeechError, match=r"rule \d+ \('a'\) and those before it"):
        Rewriter(rules)
    Rewriter([rule._replace(spelling=rule.after[0]) for rule in rules])


def calls_of_reading(word, rules):
    """Count the functions called, and the compiled expressions tried, while a word is read."""
    rewriter, count = Rewriter(rules, "a"), 0

    def counted(_frame, event, _argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(counted)
    try:
        rewriter.read(word)
    finally:
        sys.setprofile(None)
    return count


def test_reading_a_word_costs_in_step_with_its_letters():
    rules = [Rule("a", ("a",), ".*b", ".*c"), Rule("aa", ("a",), "a*+b")]
    short, long = (calls_of_reading("a" * length, rules) for length in (500, 1000))
    assert 1.8 * short < long < 2.2 * short
