"""Words of numbers that a pack puts together, as "vinte e un" of 20 and 1, and Roman numerals."""

import re
from bisect import bisect_right
from collections.abc import Mapping
from functools import cache

MAX_DIGITS = 12
"""Longer numbers are read digit by digit."""

DIGITS = frozenset("0123456789")

_GROUPS = re.compile(r"\d{1,3}(?:([.,])\d{3})(?:\1\d{3})*")
_DECIMAL = re.compile(r"\d+[.,]\d+")
_POWERS = (10**9, 10**6, 1000, 100, 10)
_OPTIONAL = re.compile(r"\[([^\[\]]*)\]")
_PART = re.compile(r"(<<?|>>?)(?:\{([^{}]*)\})?")

_ROMAN = re.compile(
    "M{0,3}"
    + "".join(
        f"(?:{one}{ten}|{one}{five}|{five}?{one}{{0,3}})"
        for one, five, ten in ("CDM", "XLC", "IVX")
    )
)
_VALUES = {"I": 1, "V": 5, "X": 10, "L": 50, "C": 100, "D": 500, "M": 1000}

Rules = Mapping[str, str]


def number_words(
    rules: Rules, written: str, named: Mapping[str, Rules] | None = None, decimal: str = ""
) -> str:
    """Return the words of a number in digits.

    `decimal` is the word of the decimal sign, after which digits are read one by one. Without it,
    what follows the sign is a number of its own.

    A rule serves its number and all up to the next rule. `>` in it is the rest, `<` how many
    tens, hundreds, thousands or millions there are; a part in brackets needs a rest other than 0.
    A rule with `<<` or `>>` counts in its own number, such as 100000, instead.
    `>{joined}` and `<{joined}` go by the `named` rules `joined`. An empty rule leaves its numbers
    and larger ones as digits. Rules for 0 to 9 alone name each digit.

    >>> number_words({"1": "one", "2": "two", "100": "< hundred[ and >]"}, "102")
    'one hundred and two'
    """
    if _GROUPS.fullmatch(written):
        written = re.sub("[.,]", "", written)
    elif decimal and _DECIMAL.fullmatch(written):
        whole, digits = re.split("[.,]", written)
        written = " ".join([whole, decimal, *digits])
    return re.sub(r"\d+", lambda digits: _of_digits(rules, digits[0], named or {}), written)


def named_rules(words: str) -> list[str]:
    """Return the names of other rules in the words of a rule."""
    return [place[2] for place in _PART.finditer(words) if place[2] is not None]


def _of_digits(rules: Rules, digits: str, named: Mapping[str, Rules]) -> str:
    # numbers of telephones
    zeros = len(digits) > len("007") and int(digits[0]) == 0
    if len(digits) > MAX_DIGITS or zeros or rules.keys() == DIGITS:
        return " ".join(_words(rules, int(digit), named) for digit in digits)
    return _words(rules, int(digits), named)


@cache
def _starts(numbers: tuple[str, ...]) -> list[int]:
    return sorted(map(int, numbers))


def _words(rules: Rules, value: int, named: Mapping[str, Rules]) -> str:
    starts = _starts(tuple(rules))
    place = bisect_right(starts, value)
    start = starts[place - 1] if place else 0
    words = rules.get(str(start), "")
    own = "<<" in words or ">>" in words
    power = start if own else next((one for one in _POWERS if one <= start), 0)
    if not power or not words:
        return words or str(value)
    quotient, rest = divmod(value, power)

    def part(place: re.Match[str]) -> str:
        return _words(named.get(place[2], rules), rest if place[1][0] == ">" else quotient, named)

    return _PART.sub(part, _OPTIONAL.sub(r"\1" if rest else "", words))


def roman(numeral: str) -> int:
    """Return the value of a Roman numeral; 0 for any other text.

    >>> roman("XIV"), roman("IIX")
    (14, 0)
    """
    if not numeral or not _ROMAN.fullmatch(numeral):
        return 0
    values = [_VALUES[letter] for letter in numeral]
    return sum(-v if v < after else v for v, after in zip(values, (*values[1:], 0), strict=True))
