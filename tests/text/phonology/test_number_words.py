"""Numbers whose words a pack puts together by rules."""

import re

import pytest
from lanes import swept
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.text.phonology.g2p.number_words import MAX_DIGITS, number_words

DIGITS = ["nought", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine"]
RULES = {
    **dict(zip("0123456789", DIGITS, strict=True)),
    "10": "ten",
    "11": "> and ten",
    "20": "<ty[-and->]",
    "100": "< hundred[ >]",
    "1000": "< thousand[ >]",
    "1000000": "< million[ >]",
}


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("0", "nought"),
        ("007", "seven"),
        ("13", "three and ten"),
        ("20", "twoty"),
        ("25", "twoty-and-five"),
        ("300", "three hundred"),
        ("15000", "five and ten thousand"),
        ("120004", "one hundred twoty thousand four"),
        ("2000001", "two million one"),
        ("2.500", "two thousand five hundred"),
        ("1,000,000", "one million"),
        ("3,5", "three,five"),
        ("0351", "nought three five one"),
        ("7" * (MAX_DIGITS + 1), " ".join(["seven"] * (MAX_DIGITS + 1))),
    ],
)
def test_rules_put_the_words_together(written, words):
    assert number_words(RULES, written) == words


def test_a_rule_may_count_in_its_own_number():
    rules = {**RULES, "100000": "<< lakh[ >>]"}
    assert number_words(rules, "350000") == "three lakh fivety thousand"
    assert number_words(rules, "1200000") == "one million two lakh"


def test_digits_after_a_decimal_sign_are_read_one_by_one():
    assert number_words(RULES, "20.05", decimal="point") == "twoty point nought five"
    assert number_words(RULES, "2.500", decimal="point") == "two thousand five hundred"


def test_a_number_without_a_rule_stays():
    assert number_words({"20": "score[ >]"}, "25 7") == "score 5 7"


def test_numbers_from_an_empty_rule_on_stay():
    rules = {"1": "one", "10": "ten[ >]", "20": ""}
    read = [number_words(rules, number) for number in ("11", "20", "35", "1200")]
    assert read == ["ten one", "20", "35", "1200"]


def test_rules_of_digits_alone_name_each_digit():
    rules = dict(zip("0123456789", DIGITS, strict=True))
    assert number_words(rules, "0199") == "nought one nine nine"
    assert number_words(rules, "555") == "five five five"


def test_a_rest_may_have_rules_of_its_own():
    joined = {"1": "and-one", "10": "and-ten[ >]"}
    rules = {**RULES, "10": "ten[ >{joined}]", "100": "< hundred[ >{joined}]"}
    assert number_words(rules, "111", {"joined": joined}) == "one hundred and-ten and-one"
    assert number_words(rules, "1", {"joined": joined}) == "one"


def test_rules_choose_the_form_of_a_noun():
    hours = {"0": "часов", "1": "час", "2": "часа", "5": "часов", "21": ">", "100": ">"}
    read = {n: number_words(hours, str(n)) for n in (1, 3, 11, 20, 21, 44, 112, 102)}
    assert {n for n in read if read[n] == "часов"} == {11, 20, 112}
    assert {n for n in read if read[n] == "часа"} == {3, 44, 102}


MAX_NOUN_FORMS = 3
"""Most forms of a noun behind a number."""

SOME = (*range(1000), *range(1000, 10_000, 37), 10**6, 123_456_789)
"""Every number of three digits, and one of 37 others, so that all digits stand beside all."""


def read_by_rules(language, numbers):
    """Yield the numbers that each table of a pack serves, with its rules and the words read."""
    text = LIBRARY.language(language).model.text
    tables = text.number_tables if text else {}
    for rules in tables.values():
        if not rules[min(rules, key=int)]:
            continue  # the rest of each number is left to the engine
        first = int(min(rules, key=int))
        stop = min((int(n) for n in rules if not rules[n]), default=10**9)
        served = [n for n in numbers if first <= n < stop]
        yield rules, [number_words(rules, str(n), tables) for n in served]


@pytest.mark.parametrize("language", swept(LANGUAGES, LANGUAGES[::4]))
def test_no_number_of_a_pack_leaves_a_digit_or_a_mark(language):
    for rules, read in read_by_rules(language, SOME):
        assert [words for words in read if re.search(r"[0-9<>\[\]{}]", words)] == []
        forms = set(rules.values()) - {">", ""}  # an empty rule ends a table
        if len(forms) <= MAX_NOUN_FORMS:
            assert set(read) == forms
        else:
            assert len(set(read)) > 0.99 * len(read)
