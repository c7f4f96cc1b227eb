"""Work on long, repetitive texts grows with their length; work is counted, never timed."""

import sys

import pytest

from lipsync_lang.text.lines import markup
from lipsync_lang.text.lines.choices import MAX_DEPTH, chosen
from lipsync_lang.text.phonology.emphasis import touched
from lipsync_lang.text.phonology.g2p import corrections
from lipsync_lang.text.phonology.g2p.abbreviation_keys import Expansions
from lipsync_lang.text.phonology.g2p.corrections import corrector
from lipsync_lang.text.phonology.g2p.drawn_out import drawn_out, starts_of
from lipsync_lang.text.phonology.g2p.g2p_engines import Correction, SpokenWord
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms

SIZE = 4_000


class CountedText(str):
    """Text that counts the characters copied from it."""

    __slots__ = ()
    work = 0

    def __getitem__(self, key):
        part = super().__getitem__(key)
        CountedText.work += len(part)
        return part

    def __len__(self):
        CountedText.work += 1
        return super().__len__()


def copied(call) -> int:
    CountedText.work = 0
    call()
    return CountedText.work


def calls(call) -> int:
    """Return the number of calls of functions during a call."""
    count = 0

    def counting(*_):
        nonlocal count
        count += 1

    sys.setprofile(counting)
    try:
        call()
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize("sign", ["%", "@", "Dr. "])
def test_abbreviations_copy_a_few_characters_each(sign):
    forms = SpokenForms(abbreviations={"%": "percent", "@": "at", "Dr.": "Doctor"})
    text = sign * SIZE
    found = []
    work = copied(lambda: found.extend(Expansions(forms).find(CountedText(text))))
    assert len(found) >= SIZE - 1
    assert work < 60 * len(found)


def test_corrections_measure_each_label_once(monkeypatch):
    class Label(CountedText):
        __slots__ = ()

        def replace(self, *_):
            return self

    monkeypatch.setattr(corrections, "plain", Label)
    mend = corrector([Correction(("a",), ("ə",))])
    assert copied(lambda: mend(SpokenWord("っ", ("a",) * SIZE))) <= 2 * SIZE


@pytest.mark.parametrize("part", ["1-", "a-", "abab", "aaabbb", "っ"])
def test_odd_words_are_no_stutters(part):
    few, many = (
        calls(lambda n=n: (starts_of(part * n + "x", "aeiou"), drawn_out(part * n, {})))
        for n in (SIZE // 4, SIZE)
    )
    assert many <= 6 * few


def test_emphasis_is_met_in_order():
    text = "a " * SIZE
    spans = [(2 * n, 2 * n + 1) for n in range(SIZE)]
    few = calls(lambda: touched(["a"] * (SIZE // 4), text, spans))
    assert calls(lambda: touched(["a"] * SIZE, text, spans)) < 5 * few
    assert touched(["a", "b", "a", "a"], "a b a a", [(2, 5)]) == [False, True, True, False]


def test_braces_within_braces_are_choices_to_a_depth():
    few, many = (
        calls(lambda n=n: chosen("{" * n + "a|b" + "}" * n, {})) for n in (SIZE // 4, SIZE)
    )
    assert many <= 5 * few
    deep = "{x|" * (MAX_DEPTH + 2)
    assert chosen(deep + "}" * (MAX_DEPTH + 2), {}).startswith("x")


@pytest.mark.parametrize("text", ["~ ", "<br>", "{0} ", "a  "])
def test_pauses_are_looked_for_without_runs_of_spaces(monkeypatch, text):
    seen = []

    class Pattern:
        def sub(self, _, found):
            seen.append(found)
            return found

    monkeypatch.setattr(markup, "PAUSED", Pattern())
    markup.spoken("a {w} b " + text * SIZE + "<b>")
    assert seen
    assert not any("  " in one for one in seen)


def test_arrows_begin_where_their_run_begins():
    assert markup.spoken("a --> b").dropped == ("-->",)
    assert markup.spoken("one->two now").text == "one two now"
    assert markup.spoken("-" * SIZE).dropped == ()


def test_many_gaps_beside_a_stray_mark_are_not_read_again_for_each():
    text = "[a] b " * SIZE + "} :-)"
    assert len(markup.spoken(text).gaps) == SIZE
    assert calls(lambda: markup.spoken(text)) < 200 * SIZE
