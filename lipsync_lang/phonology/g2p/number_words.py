"""Words of numbers that a pack puts together, as "vinte e un" of 20 and 1."""

import re
from collections.abc import Mapping

MAX_DIGITS = 12
"""Longer numbers are read digit by digit."""

_GROUPS = re.compile(r"[0-9]{1,3}(?:([.,])[0-9]{3})(?:\1[0-9]{3})*")
_POWERS = (10**9, 10**6, 1000, 100, 10)
_OPTIONAL = re.compile(r"\[([^\[\]]*)\]")


def number_words(rules: Mapping[str, str], written: str) -> str:
    """Return the words of a number in digits; what follows a decimal sign is a number of its own.

    A rule serves its number and all up to the next rule. `>` in it is the rest, `<` how many
    tens, hundreds, thousands or millions there are; a part in brackets needs a rest other than 0.

    >>> number_words({"1": "one", "2": "two", "100": "< hundred[ and >]"}, "102")
    'one hundred and two'
    """
    if _GROUPS.fullmatch(written):
        written = re.sub("[.,]", "", written)
    return re.sub("[0-9]+", lambda digits: _of_digits(rules, digits[0]), written)


def _of_digits(rules: Mapping[str, str], digits: str) -> str:
    if len(digits) > MAX_DIGITS:
        return " ".join(_words(rules, int(digit)) for digit in digits)
    return _words(rules, int(digits))


def _words(rules: Mapping[str, str], value: int) -> str:
    start = max((int(key) for key in rules if int(key) <= value), default=0)
    power = next((power for power in _POWERS if power <= start), 0)
    if not power:
        return rules.get(str(value), str(value))
    quotient, rest = divmod(value, power)
    words = _OPTIONAL.sub(r"\1" if rest else "", rules[str(start)])
    if "<" in words:
        words = words.replace("<", _words(rules, quotient))
    return words.replace(">", _words(rules, rest)) if ">" in words else words
